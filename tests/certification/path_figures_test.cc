#include "armtrue/certification/path_figures.h"

#include <gtest/gtest.h>

#include <cmath>

namespace armtrue::path_figures_test {
namespace {

// 300 mm along x in 3 s, 20 ms apart.
Path line() {
  Path path;
  constexpr int kSamples = 151;
  path.time.setLinSpaced(kSamples, 0, 3);
  path.position.setZero(3, kSamples);
  path.position.row(0) = 0.1 * path.time.transpose();
  return path;
}

Path moved(Path path, double y, double z) {
  path.position.row(1).array() += 1e-3 * y;
  path.position.row(2).array() += 1e-3 * z;
  return path;
}

// Passes at (0.1, 0), (0.2, 0.1) and (0, -0.1) mm beside the path: barycentre (0.1, 0), AT = 0.1.
// l = 0, 0.141421, 0.141421: mean 0.094281, S^2 = (0.094281^2 + 2 x 0.047140^2) / 2 = 0.0816497^2,
// RT = 0.094281 + 3 x 0.0816497 = 0.339230.
TEST(PathFigures, OfThreePassesAreThoseOfTheStandardsFormulas) {
  ClockOptions clock;
  clock.offset = 0;
  const PathFigures figures = path_figures(
      line(), {moved(line(), 0.1, 0), moved(line(), 0.2, 0.1), moved(line(), 0, -0.1)}, clock);
  EXPECT_EQ(figures.passes, 3);
  EXPECT_NEAR(figures.at, 0.1e-3, 1e-12);
  EXPECT_NEAR(*figures.rt, (0.2 / 3 * std::sqrt(2.0) + 3 * 0.2 / std::sqrt(6.0)) * 1e-3, 1e-12);
  EXPECT_NEAR(*figures.rt, 0.339230e-3, 1e-9);
  EXPECT_EQ(figures.planes, 151);
  EXPECT_FALSE(path_figures(line(), {moved(line(), 0.3, 0.4)}, clock).rt);
  EXPECT_NEAR(path_figures(line(), {moved(line(), 0.3, 0.4)}, clock).at, 0.5e-3, 1e-12);
}

}  // namespace
}  // namespace armtrue::path_figures_test
