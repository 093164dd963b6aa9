#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// What a sensor reads too much, as a function of the place within it: a polynomial of the pixel
/// (u, v), or of the point (y, z) of a line profile.
struct SensorField {
  int camera = -1;  ///< index into the chain's contacts; -1: the scanner of line profiles
  Eigen::Vector2d middle, half;  ///< of the places that were read [px or m]: they count as -1 to 1
  int degree = 0;
  Eigen::VectorXd values;  ///< of its terms [px or m]
};

/// An error of the sensors that the model of the readings lacks.
struct SensorError {
  std::vector<SensorField> fields;  ///< in the order in which they are taken off
  std::string words;  ///< what errs, by how much, and what to do; empty if nothing does
  /// Whether something is left that depends on the place within the sensor, or on the place on the
  /// board: an arm that is fitted to it may be worse than nominal.
  bool is_left = false;

  /// Takes the fields off the readings.
  void take_off(Campaign& campaign, const KinematicChain& chain) const;
};

/// Tests whether the residuals of images or of line profiles depend on the place within the sensor,
/// as those of a lens do that its model does not contain, or of a scanner whose axes are not
/// square or differ in scale. What arm and set-up do is taken off first: of an image all that moves
/// the board, and what the numbers of the lens do; of profiles all columns of a plain fit. With C
/// the columns of the polynomial beside these, r the residual and r_p its part of pose p,
///     share = |P_C r|^2 / |r|^2,
/// and the degree is that with the largest fall of BIC. It is an error of the sensor if BIC falls
/// by more than 20, and if of 2000 random signs of the poses (r_p corrected for its leverage) at
/// most one gives as large a fall (p < 0.001). A board whose points are elsewhere is the rival,
/// with a polynomial of the place on it: what explains more is named. Several rounds, each with a
/// new fit to readings without the fields found so far. Nothing for other readings.
SensorError find_sensor_error(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
