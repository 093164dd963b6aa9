#include "statistics/white_noise.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "armtrue/statistics/summary.h"

namespace armtrue {

double white_noise(const Eigen::Matrix3Xd& samples) {
  std::vector<double> squares;
  for (Eigen::Index i = 3; i < samples.cols(); ++i)
    squares.push_back(
        (samples.col(i) - 3 * samples.col(i - 1) + 3 * samples.col(i - 2) - samples.col(i - 3))
            .squaredNorm());
  if (squares.empty()) return 0;
  // |.|^2 of two normal components of variance 20 s^2 has the median 2 ln 2 * 20 s^2.
  return std::sqrt(median(std::move(squares)) / (40 * std::numbers::ln2));
}

}  // namespace armtrue
