#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/planning/pose_cloud.h"
#include "armtrue/search/trace.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {

/// One found effect and its rivals (the members, of which exactly one is true), and the nuisance
/// parameters: geometry and all other effects, which are fitted in any case. Columns are
/// standardised over cloud and given poses: those of the nuisances together; those of each member
/// separately, as residuals of their regression on the nuisances.
struct Contest {
  /// Standardised columns: an orthonormal basis of the raw columns, in units of an average pose.
  struct Standard {
    Eigen::MatrixXd of_raw;           ///< raw columns times this are the standardised ones
    Eigen::MatrixXd of_coefficients;  ///< this times raw coefficients gives the standardised ones
  };
  struct Member {
    Effect effect;
    std::string separated_by;
    int raw_count = 0;
    int first = 0, count = 0;  ///< standardised columns, among those of the members
    Standard standard{};       ///< of what is left beside the nuisances
    Eigen::VectorXd size{};    ///< of the standardised columns
  };
  Robot robot;  ///< its effects: the others, then the members
  std::vector<Member> members;
  int nuisances = 0;         ///< standardised columns
  Eigen::MatrixXd standard;  ///< all raw columns times this are the standardised ones
};

/// The contest between a found effect and those that the campaign cannot distinguish from it. The
/// robot does not yet have the effects of the members, and no column is standardised.
Contest contest_about(size_t which, const Robot& robot, const std::vector<TracedEffect>& found);

/// Adds the members' effects to the robot.
void enter_members(Contest& contest, const std::vector<std::string>& temperature_names);

/// Whitened derivatives of the readings by all raw columns: (rows * row_size) x columns.
Eigen::MatrixXd derivatives(const Contest& contest, const PoseCloud& cloud,
                            const Campaign& campaign);

/// Sets the standardised columns from the derivatives at all poses, `poses` in number.
void standardise(Contest& contest, const Eigen::MatrixXd& rows, double poses);

/// Information of the members after the nuisances are projected out (Schur complement).
struct Fitted {
  Eigen::LLT<Eigen::MatrixXd> nuisance;  ///< information of the nuisances
  Eigen::MatrixXd share;                 ///< L^-1 times their products with the members
  Eigen::MatrixXd members;

  /// `gram`: inner products of the standardised columns.
  Fitted(const Eigen::MatrixXd& gram, int nuisances);
};

/// Least-squares fit of the rival to the truth.
struct Imitation {
  Eigen::VectorXd size;  ///< the rival's coefficients
  double left = 0;       ///< lambda: whitened residual sum of squares

  /// `information`: of all members, Fitted::members.
  Imitation(const Eigen::MatrixXd& information, const Contest::Member& truth,
            const Contest::Member& rival);
};

}  // namespace armtrue
