#pragma once

#include <Eigen/Core>

namespace armtrue {

/// White noise per axis of samples across the path, from their third differences: no deviation
/// worth a correction changes so fast. Uses the median, so that jumps do not count.
double white_noise(const Eigen::Matrix3Xd& samples);

}  // namespace armtrue
