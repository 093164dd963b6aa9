#pragma once

#include <functional>
#include <optional>

#include "programs/text_cursor.h"

namespace armtrue {

/// Takes the number of a name or a call that begins at the cursor; nothing if it is not known.
using NamedNumber = std::function<std::optional<double>(TextCursor&)>;

/// What `/` between two numbers means.
enum class Quotient { real, not_followed };

/// Takes a sum of products and quotients of numbers and names, in brackets or not; nothing if one
/// of them is not known.
std::optional<double> take_sum(TextCursor& cursor, const NamedNumber& named,
                               Quotient quotient = Quotient::real);

}  // namespace armtrue
