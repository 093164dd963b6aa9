#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/kinematics/chain.h"
#include "calibration/session_models.h"

namespace armtrue {

/// Whether the part `left` of a column of length `norm`, orthogonal to the columns kept before it,
/// is large enough to keep it.
bool is_independent(double norm, double left);

/// Subtracts from `column` its part in the span of `basis` (orthonormal); returns the coordinates
/// of that part.
Eigen::VectorXd remove_part(const Eigen::Ref<const Eigen::MatrixXd>& basis,
                            Eigen::Ref<Eigen::VectorXd> column);

/// The derivatives of all readings at x = 0, in the order of the sessions. The own parameters of a
/// further session affect the readings of that session alone: the basis of their columns is zero in
/// all other rows, so the cost grows with the number of sessions and not with its square or cube.
class ColumnsBySession {
 public:
  /// Throws std::invalid_argument if the readings of a further session cannot show its own
  /// parameters.
  ColumnsBySession(const SessionModels& models, const KinematicChain& chain);

  /// (rows * row_size) x unknowns of the first session: its own, and those common to all.
  const Eigen::MatrixXd& of_first() const { return of_first_; }
  /// Rank of the columns of the own parameters of further sessions.
  int rank_of_own() const;
  /// Subtracts from `column` the part that the own parameters of further sessions can imitate.
  void remove_own(Eigen::Ref<Eigen::VectorXd> column) const;

 private:
  struct Own {
    Eigen::Index first_row;
    Eigen::MatrixXd basis;  // rows of the session x own parameters, orthonormal
  };
  Eigen::MatrixXd of_first_;
  std::vector<Own> own_;
};

}  // namespace armtrue
