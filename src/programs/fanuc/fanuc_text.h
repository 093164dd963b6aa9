#pragma once

#include <string>
#include <string_view>

namespace armtrue {

/// A program by masked(), with its quotes; comments in brackets, P[1:l'air], are masked too: in /MN
/// they stand without quotes, and may hold some.
std::string masked_fanuc(std::string_view program);

}  // namespace armtrue
