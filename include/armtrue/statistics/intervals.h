#pragma once

#include <array>
#include <functional>

namespace armtrue {

/// 95 % interval of a quantity that cannot be negative, such as a variance from which that of the
/// noise was subtracted: `value` is its normal estimate, which may be negative; `deviation(x)` is
/// the standard deviation of the estimate if the quantity is x. The interval is never empty: far
/// above zero it is value +- 1.96 standard deviations, near zero it begins at zero. Source: Feldman
/// and Cousins 1998, "Unified approach to the classical statistical analysis of small signals"
/// (likelihood-ratio ordering).
std::array<double, 2> not_negative_ci95(double value,
                                        const std::function<double(double)>& deviation);

/// 95 % interval of a standard deviation that was estimated with degrees of freedom > 0 (normal
/// law).
std::array<double, 2> deviation_ci95(double deviation, double freedom);

}  // namespace armtrue
