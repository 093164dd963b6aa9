#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "calibration/pose_influence.h"
#include "search/linearization.h"
#include "search/projection.h"

namespace armtrue {

/// Gain of columns of a fit, on poses that the fit did not use.
struct GainLeftOut {
  double gain = 0;   ///< fall of the mean squared whitened residual, as a share of it
  double error = 0;  ///< standard error of the gain, over poses
};

/// Leaves out a tenth of the poses at a time, in an order drawn from `seed`, and predicts them from
/// the others; linear in all unknowns. What the basis of the fit needs is done once for all
/// columns.
class CrossValidation {
 public:
  /// Keeps a reference to the fit.
  CrossValidation(const Linearization& fit, std::uint64_t seed);

  /// Of columns that are added: orthonormal, and orthogonal to the fitted columns.
  GainLeftOut of(const Directions& added) const;
  /// Of an effect of the model beside all the others.
  GainLeftOut of_effect(int effect) const;

 private:
  // Poses that are left out. Their equations are those of their rows, and the rests of their
  // replicates, each with the number of its pose among them.
  struct Fold {
    int poses = 0;
    std::vector<Eigen::Index> equations, rests;
    std::vector<int> pose_of_equation, pose_of_rest;
    Eigen::MatrixXd basis;               // at the equations
    Eigen::LLT<Eigen::MatrixXd> others;  // Gram matrix of the basis at all other poses
  };
  // Of the poses of a fold, without and with the columns.
  struct Errors {
    Eigen::VectorXd without, with, rests_without, rests_with;
  };
  Fold fold_of(const std::vector<int>& poses, const GroupedRows& rows) const;
  template <typename ErrorsOf>
  GainLeftOut gain_by(const ErrorsOf& errors_of) const;

  const Linearization& fit_;
  std::vector<Fold> folds_;
};

}  // namespace armtrue
