#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/kinematics/chain.h"
#include "calibration/session_models.h"

namespace armtrue {

/// Whether of a column of length `norm` enough is `left` beside the columns kept before it.
bool is_independent(double norm, double left);

/// Takes from `column` its part in the span of `basis` (orthonormal); returns the coordinates of
/// the part.
Eigen::VectorXd remove_part(const Eigen::Ref<const Eigen::MatrixXd>& basis,
                            Eigen::Ref<Eigen::VectorXd> column);

/// The derivatives of all readings at x = 0, in the order of the sessions. What a further session
/// has of its own moves the readings of that session alone: a basis of these columns is zero in all
/// other rows, so that the cost grows with the number of sessions, not with its square or cube.
class ColumnsBySession {
 public:
  /// Throws std::invalid_argument if the readings of a further session do not show what it has of
  /// its own.
  ColumnsBySession(const SessionModels& models, const KinematicChain& chain);

  /// (rows * row_size) x unknowns of the first session: its own, and those common to all.
  const Eigen::MatrixXd& of_first() const { return of_first_; }
  /// Of what the further sessions have of their own.
  int rank_of_own() const;
  /// Takes from `column` what the own parameters of further sessions can imitate.
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
