#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/path/low_pass.h"
#include "armtrue/path/mirror/path_deviation.h"
#include "armtrue/statistics/autocorrelated_regression.h"

namespace armtrue {

/// Force and deviation of a registered pass: one column for each sample, in one clock. Leave out
/// samples at standstill, where friction and the servos hold the tool elsewhere.
struct ForceRecord {
  /// Measured minus programmed position [m], including its part along the path. Without that part
  /// only the compliance across the path would show, and that changes along a curve. The fitted
  /// clock has already removed a constant lag and drag.
  Eigen::Matrix3Xd deviation;
  Eigen::Matrix3Xd force;  ///< on the tool [N], same axes, through the same low pass
  /// RMS noise of `force` per axis [N], after the low pass (find_engagement() measures it in air).
  /// It would shrink every k by its share of the power of the force; force_law() corrects for that.
  Eigen::Vector3d force_noise = Eigen::Vector3d::Zero();
  /// Position of the tool [m], through the same low pass. An arm's geometry makes it deviate by
  /// what changes slowly over the work space: a constant and a linear function of the position.
  /// Where the force follows the position, they cannot be separated and the intervals widen. No
  /// columns: the geometry is exact.
  Eigen::Matrix3Xd place;
  /// Sign of motion of each joint or axis that may have backlash, one row each
  /// (motion_directions()), after the same low pass as the deviation. No rows: no backlash.
  Eigen::MatrixXd direction;
  /// Errors of `deviation` that all samples share [m], such as those of a fitted clock
  /// (clock_errors()): each is multiplied by an unknown number of unit variance.
  std::vector<Eigen::Matrix3Xd> shared_errors;
};

/// deviation = k * force (the paper's figure 8), k in m/N.
struct ForceLine {
  /// Empty if the force is not larger than its noise, or the deviation is zero.
  std::optional<Estimate> k;
  /// 1 - |residual|^2 / |d|^2, with d the deviation after subtraction of the fitted constant,
  /// places and steps (for a line through the origin: the whole deviation). The share of d that the
  /// force explains.
  double r2 = 0;
};

/// One principal direction of the force that occurred.
struct ForceDirection {
  Eigen::Vector3d direction;  ///< unit vector
  double rms = 0;             ///< of the force along it, without its noise [N]
  /// Compliance times direction, x, y, z [m/N]. Empty if the force along it is not larger than its
  /// noise: the compliance is then unknown, not zero.
  std::optional<std::array<Estimate, 3>> compliance;
};

/// The step of the deviation when a joint or axis reverses.
struct ReversalStep {
  std::vector<Eigen::Index> axes;  ///< rows of `direction`; several if they reverse together
  std::array<Estimate, 3> step;    ///< from negative to positive motion of the first, x, y, z [m]
};

/// The result of force_law().
struct ForceLaw {
  std::array<ForceLine, 3> axis;  ///< deviation x on force x, y on y, z on z
  /// |deviation - offset - places - reversals| on |force|, through the origin. The interval takes
  /// all of them and the clock as exact. The noise of the deviation is not corrected for: it
  /// lengthens |deviation| by (its variance across) / (2 |deviation|).
  ForceLine magnitude;
  std::array<ForceDirection, 3> directions;  ///< strongest first
  /// Sum over the known directions of compliance * direction' [m/N]. This is the whole compliance
  /// only if `rank` is 3; along other directions it is unknown.
  Eigen::Matrix3d compliance = Eigen::Matrix3d::Zero();
  int rank = 0;          ///< number of known directions
  double condition = 1;  ///< strongest over weakest known direction
  /// Deviation without force, at the mean of `place` and `direction` [m]; the samples in air show
  /// it. The seed paper sets it to zero, and so takes an offset of the frame or half a backlash for
  /// an effect of the force.
  std::array<Estimate, 3> offset;
  std::vector<ReversalStep> reversals;
};

/// Fits deviation = offset + gradient * place + compliance * force + sum of steps * direction / 2
/// by least squares, with intervals for autocorrelated residuals (regress_autocorrelated()). The
/// offset is free because the zero of a backlash is unknown. Throws std::invalid_argument if sizes
/// disagree or there are fewer samples than twice the unknowns.
ForceLaw force_law(const ForceRecord& record);

/// y = k x over all entries of two matrices, such as predicted and measured deviation (3 x n).
/// Throws std::invalid_argument if sizes disagree or there are fewer than two entries.
ForceLine line_through_origin(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y);

/// Sign of motion, +-1, of each row of `coordinates`: joints or axes as programmed, because a noisy
/// record would reverse at every sample. At standstill it is the sign of the last motion, before
/// any motion that of the first. 0 if the row never moves by more than rounding between samples.
Eigen::MatrixXd motion_directions(const Eigen::MatrixXd& coordinates);

/// Displacement of the tool by forces [N, axes of R_A] at the encoder angles `q` [rad]: position of
/// the model with the force minus position without, 3 x n [m] in R_A. Throws std::invalid_argument
/// if sizes disagree.
Eigen::Matrix3Xd deviation_from_force(const RobotModel& robot, const JointMatrix& q,
                                      const Eigen::Matrix3Xd& force);

/// force_law() of a registered deviation, at the samples where the tool moves. Deviation, force and
/// directions go through the low pass; without it, noise would hide a weak force. `axes`:
/// coordinates of the axes that may have backlash, as programmed, a column for each sample of the
/// deviation. Empty without a force, and of a pass that is too short for a law.
std::optional<ForceLaw> force_law(const PathDeviation& deviation, const Path& programmed,
                                  const Eigen::MatrixXd& axes, const LowPass& filter);

/// Regression of the measured deviation across the path on the deviation that the effects of the
/// robot predict from the recorded force: k = 1 if the robot file is right. Empty without a force.
/// Throws as joint_path() does.
std::optional<ForceLine> measured_on_predicted(const PathDeviation& deviation,
                                               const Path& programmed, const Robot& robot);

}  // namespace armtrue
