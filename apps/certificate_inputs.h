#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "armtrue/certification/certificate.h"
#include "command_line.h"

namespace armtrue::app {

/// What certify is asked for.
struct CertificateArguments {
  std::string robot, about, refit, cube, page, against, path;
  std::vector<std::string> passes;
  bool fit_frame = false;
  std::optional<double> tolerance_mm;
};

void add_certificate_options(Command& command, CertificateArguments& arguments);

/// Accuracy of the path that the passes ran. Throws InputError for files that are no programmed
/// path or no record.
PathFigures certified_path(Command& command, const CertificateArguments& arguments);

/// Runs `work`, and adds the name of the file to its errors.
template <typename Work>
auto about_file(const std::string& file, const Work& work) {
  try {
    return work();
  } catch (const std::invalid_argument& error) {
    throw InputError(file + ": " + error.what());
  }
}

}  // namespace armtrue::app
