#pragma once

#include <Eigen/Core>

namespace armtrue {

/// White noise per axis of samples across the path: what third differences show, since no deviation
/// worth a correction changes as fast. Their median, so that jumps do not count.
double white_noise(const Eigen::Matrix3Xd& samples);

}  // namespace armtrue
