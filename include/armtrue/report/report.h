#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/certification/certificate.h"
#include "armtrue/io/document.h"

namespace armtrue {

/// Data of the run that a page shows beside its results. It has a date only if `about` states one,
/// so the same input always gives the same page.
struct PageHead {
  const Document& product;            ///< of the command; the page shows its values
  std::vector<std::string> warnings;  ///< of the command
  std::optional<About> about;         ///< who measured what, when and with what, if stated
  bool arm_in_doubt = false;  ///< a warning doubts that the robot file is of the arm: the page
                              ///< shows no good verdict
};

/// A picture as a file of its own.
struct PictureFile {
  std::string name;  ///< with .svg
  std::string text;
};

/// A page on one run, complete in itself: HTML that loads no scripts, fonts or other files. An
/// element with the attribute data-key holds a value of the product of the command, with the same
/// digits. The attribute is the path of the value, such as `before_after/after_mm`; for a value of
/// the robot file that was read it is such as `robot:std/A2.d`.
struct Report {
  std::string html;
  std::vector<PictureFile> pictures;  ///< of the page
};

}  // namespace armtrue
