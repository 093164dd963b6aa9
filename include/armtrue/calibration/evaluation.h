#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

/// Errors of a robot on measured poses, reading by reading.
struct Evaluation {
  /// Measured minus model, R_A [m, rad]; of a distance the first component, the others zero.
  std::vector<Eigen::Matrix<double, 6, 1>> residuals;
  std::vector<double> position;     ///< norms [m]; of distances their errors
  std::vector<double> orientation;  ///< norms [rad]; empty without orientations
};

/// Every row against the base of its session (see Robot::sessions), in whose R_A its residual is.
/// Throws std::invalid_argument if the campaign lacks a target, or what an effect is driven by.
Evaluation evaluate(const Robot& robot, const Campaign& campaign);

/// Where the noise floor comes from.
struct NoiseFloor {
  enum class Source { replicates, instrument, none };
  Source source = Source::none;
  int axes = 3;  ///< of a position; 1: of a distance
  /// Per axis, one standard deviation [m]; of a row with the median of the deviations that are
  /// stated.
  double position = 0;
  double orientation = 0;      ///< [rad]; 0 without orientations
  int degrees_of_freedom = 0;  ///< of the replicates
};

/// Scatter of the replicates about their own mean residual, by session, pose and channel, estimated
/// robustly; where no pose is repeated, what the readings state themselves (their median
/// `sigma_mm`), else what the robot file says of the instrument. Replicates
/// taken in a row at standstill show the instrument, not the arm's return to a pose.
NoiseFloor noise_floor(const Robot& robot, const Campaign& campaign, const Evaluation& evaluation);

/// Mean length of an error that is only noise: three axes of a normal law, or one of a distance.
double mean_error_of_noise(double deviation_per_axis, int axes = 3);

/// A fit against the noise of its own readings, blunders apart. Lack of fit against pure error:
/// probability of a ratio of mean squares this large if the model lacked nothing (F test; against a
/// floor that is only known from the instrument, chi-square). Nothing without any floor.
struct FitQuality {
  std::vector<int> blunders;  ///< rows whose weight is next to nothing: 14 standard deviations
  NoiseFloor noise;
  std::optional<double> lack_of_fit;              ///< of position and orientation together
  std::optional<double> lack_of_fit_in_position;  ///< of position alone
};
FitQuality assess(const CalibrationResult& fit, const Campaign& campaign);

}  // namespace armtrue
