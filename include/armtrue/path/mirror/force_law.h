#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "armtrue/effects/robot_model.h"
#include "armtrue/statistics/autocorrelated_regression.h"

namespace armtrue {

/// What a registered pass says about force and deviation: one column per sample, in one clock.
/// Leave out samples at standstill: friction and the servos hold the tool elsewhere there.
struct ForceRecord {
  /// Measured minus programmed position [m], the part along the path too: without it, a compliance
  /// is what it leaves across the path, which on a curve changes all the way. A fitted clock has
  /// taken a constant lag and drag off that part.
  Eigen::Matrix3Xd deviation;
  Eigen::Matrix3Xd force;  ///< on the tool [N], same axes, through the same low pass
  /// RMS noise of `force` per axis [N], through that low pass too (find_engagement() measures it in
  /// air). It draws every k towards zero by its share of the force's power, and is taken off.
  Eigen::Vector3d force_noise = Eigen::Vector3d::Zero();
  /// Sign of motion of each joint or axis that may have backlash, a row each (motion_directions()),
  /// through the same low pass if the deviation went through one. No rows: no backlash.
  Eigen::MatrixXd direction;
  /// What independent errors of unit variance that all samples share would add to `deviation`
  /// [m], one for each: those of a fitted clock (clock_errors()).
  std::vector<Eigen::Matrix3Xd> shared_errors;
};

/// deviation = k * force, as the paper's figure 8, where k is in m/N.
struct ForceLine {
  std::optional<Estimate> k;  ///< empty where no force stands out of its noise, or no
                              ///< deviation is given
  /// Share of the squared deviation that the force explains: of the deviation from what it is
  /// without force (for a line through the origin zero, else the constant and steps that fit best).
  double r2 = 0;
};

/// One principal direction of the force that occurred.
struct ForceDirection {
  Eigen::Vector3d direction;  ///< unit vector
  double rms = 0;             ///< of the force along it, its noise taken off [N]
  /// Deviation per newton along it, x, y, z [m/N]: the compliance times the direction. Empty where
  /// this force never stood out of its noise: there the compliance is unknown, not zero.
  std::optional<std::array<Estimate, 3>> compliance;
};

/// The deviation's change when joints or axes begin to move the other way.
struct ReversalStep {
  std::vector<Eigen::Index> axes;  ///< rows of `direction`; several if they reverse together
  std::array<Estimate, 3> step;    ///< from negative to positive motion of the first, x, y, z [m]
};

struct ForceLaw {
  std::array<ForceLine, 3> axis;  ///< deviation x on force x, y on y, z on z
  /// |deviation| on |force| through the origin, once `offset` and `reversals` are taken off; the
  /// interval takes these and the clock as exact. Noise lengthens |deviation| by half its variance
  /// across it.
  ForceLine magnitude;
  std::array<ForceDirection, 3> directions;  ///< strongest first
  /// Sum over the known directions of compliance * direction' [m/N]: what it says of a force along
  /// the others is nothing, so it is the whole compliance only if rank is 3.
  Eigen::Matrix3d compliance = Eigen::Matrix3d::Zero();
  int rank = 0;          ///< number of known directions
  double condition = 1;  ///< strongest over weakest known direction
  /// Deviation without force, which the air shows, at the mean of `direction` [m]: were it taken
  /// for zero, as the paper has it, an offset of the frame or half a backlash would be taken for
  /// force.
  std::array<Estimate, 3> offset;
  std::vector<ReversalStep> reversals;
};

/// Fits all of it by least squares with intervals for residuals that wander slowly
/// (regress_autocorrelated()). A constant and a step of each axis that reverses stand beside the
/// force: which side of a backlash is zero is not known. Throws std::invalid_argument if sizes
/// disagree or samples are fewer than twice the unknowns.
ForceLaw force_law(const ForceRecord& record);

/// y = k x through the origin, rows and columns of both taken together: predicted against measured
/// deviation (3 x n) for one. Throws std::invalid_argument if sizes disagree or there are fewer
/// than two numbers.
ForceLine line_through_origin(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y);

/// +-1 by the sign of motion of each row of `coordinates` (joints or axes, as programmed: a noisy
/// record would reverse at every sample); at standstill that of the last motion, before any that of
/// the first; 0 if it never moves by more than rounding between samples.
Eigen::MatrixXd motion_directions(const Eigen::MatrixXd& coordinates);

/// How far forces [N, axes of R_A] move the tool at the encoder angles `q` [rad], by the effects of
/// the robot that a force drives: the model with the force minus the model without, 3 x n [m] in
/// R_A. Throws std::invalid_argument if sizes disagree.
Eigen::Matrix3Xd deviation_from_force(const RobotModel& robot,
                                      const Eigen::Matrix<double, kJoints, Eigen::Dynamic>& q,
                                      const Eigen::Matrix3Xd& force);

}  // namespace armtrue
