#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/observation/session_models.h"

namespace armtrue {

/// R with R^T R = rows^T rows.
Eigen::MatrixXd upper_triangle(const Eigen::MatrixXd& rows);
/// rows times the inverse of an upper triangle.
Eigen::MatrixXd divided_by(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& triangle);

/// Rows of derivatives of one group of readings: those by the unknowns that move no other group,
/// such as the place of a target, and by the common ones.
struct GroupRows {
  Eigen::MatrixXd own, common;  ///< rows x unknowns
};

/// Derivatives of some readings, group by group. The unknowns of each target stay apart, so that
/// the cost grows with the number of targets, not with its cube.
struct GroupedDerivatives {
  std::vector<GroupRows> groups;             ///< one for each target; one in all if not split
  std::vector<std::vector<int>> pose_of_row;  ///< of each group, the pose that each reading is of
  int row_size = 1;                          ///< rows of a reading
};

/// Which unknowns belong to which group: the same for all readings of a plan.
class UnknownGroups {
 public:
  /// The groups of the readings of the candidates.
  explicit UnknownGroups(const SessionModels& candidates);

  SessionModels::Split split() const { return split_; }
  size_t groups() const { return own_.size(); }
  /// Indices within the unknowns.
  const std::vector<int>& own(size_t group) const { return own_[group]; }
  const std::vector<int>& common() const { return common_; }

  /// Whitened derivatives of the readings at x = 0. `models`: split as split() says.
  GroupedDerivatives derivatives(const SessionModels& models) const;
  /// The same, the rows of each group reduced to a triangle R with the same R^T R; pose_of_row is
  /// empty.
  GroupedDerivatives triangles(const SessionModels& models) const;
  /// Rows of derivatives by all unknowns, of one group.
  GroupedDerivatives of_one_group(const Eigen::MatrixXd& rows) const;

 private:
  size_t group_of(const SessionModels& models, int group) const;
  GroupRows apart(const SessionModels& models, int group, const Eigen::MatrixXd& rows) const;

  SessionModels::Split split_;
  std::vector<std::vector<int>> own_;
  std::vector<int> common_;
  std::vector<int> target_;  // of each group
};

/// The triangle R of an information R^T R. In unknowns R x this information is the identity:
/// determinants and variances then stay near 1 whatever the units.
class Scaling {
 public:
  /// Of the information of these rows times `weight` squared.
  Scaling(const GroupedDerivatives& rows, double weight);
  /// The rows times R^-1.
  void apply(GroupedDerivatives& rows) const;

 private:
  std::vector<Eigen::MatrixXd> own_, shared_;  // of each group: own x own, own x common
  Eigen::MatrixXd common_;
};

/// Criterion of a design: D- or I-optimality. The information M of the chosen readings is a bordered
/// matrix: a block for what each group has of its own, and the common unknowns as border.
class Information {
 public:
  /// `candidates`: scaled; those of pose k of the `poses` are candidate k. `known`: M from the start
  /// is its products plus kKnownFromStart times the identity. `aim` A: minimise tr(A M^-1 A^T);
  /// without groups: maximise log det M.
  Information(GroupedDerivatives candidates, int poses, const GroupedDerivatives& known,
              const GroupedDerivatives& aim);

  void set_chosen(int candidate, bool chosen);

  /// With D the information of a group's own unknowns, F that between them and the common ones, and
  /// S the Schur complement of the common ones: a candidate's rows [E C] change log det M by
  ///     sum log det(I + E D^-1 E^T) + log det(I + G S^-1 G^T),  G = L^-1 (C - E D^-1 F),
  /// with L L^T = I + E D^-1 E^T, group by group, and S by G^T G. The fall of the variance of the
  /// aim follows from M before and after.
  Eigen::VectorXd values_of_adding() const;

 private:
  class Values;
  struct Block {
    Eigen::MatrixXd own, shared;  // D, F
  };
  struct Aim {
    std::vector<Block> blocks;
    Eigen::MatrixXd common;
  };
  // The columns of a candidate among the transposed rows of a group.
  Eigen::Block<const Eigen::MatrixXd> columns_of(const Eigen::MatrixXd& columns, size_t group,
                                                 int candidate) const;
  double variance(const std::vector<Block>& blocks, const Eigen::MatrixXd& schur) const;

  std::vector<GroupRows> candidates_;  // transposed: the numbers of a row lie side by side
  int poses_;
  std::vector<std::vector<Eigen::Index>> first_;  // row of each group and candidate, and one past
  std::vector<Block> blocks_;
  Eigen::MatrixXd common_;
  Aim aim_;
};

}  // namespace armtrue
