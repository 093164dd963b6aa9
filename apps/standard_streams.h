#pragma once

#include <string>
#include <string_view>

namespace armtrue::app {

/// Opens /dev/null for each standard stream that is closed. The first file that the command opens
/// would take its number, and messages would go into a product. Reading and writing of a closed
/// standard input and output still fail.
void reserve_standard_streams();

/// Writes to standard error. A message that nobody can take is lost without an exception, so that
/// no product is lost with it.
void print_error(std::string_view text);

/// A text as it can be shown: control characters, those that turn the direction of writing, and
/// those without width become '?'. A name could hide another text with them.
std::string without_controls(std::string_view text);

/// The same of a message. Of more than 2000 bytes the middle is left out, so that the remedy at the
/// end stays.
std::string printable(std::string message);

}  // namespace armtrue::app
