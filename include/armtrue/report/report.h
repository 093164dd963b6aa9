#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/certification/certificate.h"

namespace armtrue {

/// What a page says of the run beside its results. A date stands on it only if `about` states one:
/// the page of one input is always the same.
struct PageHead {
  std::string command, version;
  std::vector<std::pair<std::string, std::string>> inputs;  ///< file, SHA-256
  std::vector<std::string> warnings;                        ///< that the command has given
  std::optional<About> about;  ///< who measured what, when and with what, if that is stated
};

/// What a prediction of an arm holds for, as its product states it.
struct ModelStory {
  std::string robot, controller;         ///< names
  std::vector<std::string> assumed;      ///< in sentences
  std::vector<std::string> not_applied;  ///< effects of the station
};

/// A picture as a file of its own.
struct PictureFile {
  std::string name;  ///< with .svg
  std::string text;
};

/// A page on one run, complete in itself: HTML without scripts, fonts or addresses that it would
/// load. An element with the attribute data-key holds a value of the command's product, written as
/// there; the attribute is its path, as `before_after/after_mm`, or in the robot file that was
/// read, as `robot:std/A2.d`.
struct Report {
  std::string html;
  std::vector<PictureFile> pictures;  ///< those of the page
};

}  // namespace armtrue
