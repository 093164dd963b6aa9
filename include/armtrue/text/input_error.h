#pragma once

#include <stdexcept>
#include <string>

namespace armtrue {

/// Input that cannot be used. The message names the file, the line, the column or key, the content
/// found and the remedy.
class InputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace armtrue
