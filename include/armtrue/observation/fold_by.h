#pragma once

namespace armtrue {

/// How the rows of a campaign are reduced to a triangular factor R with R^T R = J^T W J.
enum class FoldBy {
  qr,                ///< Householder transformations (TSQR): exact to rounding, for statistics
  normal_equations,  ///< J^T W J is summed and factored: several times faster with hundreds of
                     ///< unknowns, but a direction of relative size e has a relative error of 1e-16
                     ///< / e^2; for the steps of a search
};

}  // namespace armtrue
