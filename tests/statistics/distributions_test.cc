#include "armtrue/statistics/distributions.h"

#include <gtest/gtest.h>

#include <cmath>

namespace armtrue {
namespace {

// Readings without noise leave residuals that are nothing beside what they may be, at any number of
// degrees of freedom.
TEST(Distributions, ANumberThatIsNothingIsExceededForCertain) {
  for (const double dof : {3.0, 3e2, 3e5, 3e6, 3e8})
    for (const double value : {1e-300, 1e-30, 1e-12, 1e-9}) {
      EXPECT_NEAR(chi_squared_above(value, dof), 1, 1e-4) << value << " of " << dof;
      EXPECT_NEAR(fisher_f_above(value, dof, dof), 1, 1e-4) << value << " of " << dof;
      EXPECT_NEAR(non_central_chi_squared_above(value, std::min(dof, 3e5), 2), 1, 1e-4) << dof;
    }
}

TEST(Distributions, ANumberBeyondAllIsNotExceeded) {
  for (const double dof : {3.0, 3e2, 3e5, 3e6}) {
    for (const double value : {1e10, 1e100, 1e300})
      EXPECT_NEAR(chi_squared_above(value, dof), 0, 1e-9) << value << " of " << dof;
    EXPECT_NEAR(fisher_f_above(1e100, dof, dof), 0, 1e-9) << dof;
  }
}

// Of many degrees of freedom the laws are nearly normal: Wilson and Hilferty, 1931.
TEST(Distributions, QuantilesOfManyDegreesOfFreedom) {
  for (const double dof : {3e5, 3e6}) {
    const double share = 2 / (9 * dof);
    const double normal = dof * std::pow(1 - share + 1.6448536 * std::sqrt(share), 3);
    EXPECT_NEAR(chi_squared_quantile_above(0.05, dof) / normal, 1, 1e-6) << dof;
    EXPECT_NEAR(chi_squared_above(normal, dof), 0.05, 1e-4) << dof;
    EXPECT_NEAR(fisher_f_quantile(0.95, dof, dof), 1 + 1.6448536 * 2 / std::sqrt(dof), 1e-4) << dof;
  }
}

}  // namespace
}  // namespace armtrue
