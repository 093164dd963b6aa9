#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

/// Smallest noise of an instrument [m]: less is rounding, or a simulation without noise.
inline constexpr double kFinestReading = 1e-6;

/// Errors of a robot on measured poses, row by row.
struct Evaluation {
  /// Length of the error of each reading [m]. A point whose coordinates are rows of their own, as
  /// those of a touch, is one reading: its error is the distance by which the model misses it.
  std::vector<double> reading_errors() const;

  /// Measured minus model, R_A [m, rad], by row. A length (distance, coordinate, touch, pixel) has
  /// its residual in the first component, zero in the others.
  std::vector<Eigen::Matrix<double, 6, 1>> residuals;
  std::vector<double> position;     ///< norms of the positions [m]
  std::vector<double> orientation;  ///< norms of the rotations [rad]; empty without orientations
  std::vector<int> first_rows;      ///< as Campaign::first_rows_of_readings()
};

/// Evaluates every row with the base of its session (see Robot::sessions); its residual is in the
/// R_A of that session. Throws std::invalid_argument if the robot lacks a target, or the campaign a
/// column that drives an effect.
Evaluation evaluate(const Robot& robot, const Campaign& campaign);

/// Evaluation::position alone, in a seventh of the memory.
std::vector<double> position_errors(const Robot& robot, const Campaign& campaign);

/// Mean of Evaluation::reading_errors() [m]. The campaign has rows.
double mean_reading_error(const Robot& robot, const Campaign& campaign);

/// Errors along one axis, with their sign.
struct AxisErrors {
  char axis;                          ///< x, y or z of R_A, or l of lengths
  double mean = 0, min = 0, max = 0;  ///< [m]
};

/// Errors of the positions of a campaign, along x, y and z, or of its lengths. The campaign has
/// rows.
std::vector<AxisErrors> axis_errors(const Evaluation& evaluation, const Campaign& campaign);

inline constexpr const char* kImages = "images";

/// The errors of the readings of one kind.
struct KindErrors {
  std::string kind;            ///< points, distances, touches, beams or kImages
  std::vector<double> errors;  ///< as those of Evaluation::reading_errors() [m]
};

/// The errors of each kind of reading that the campaign has.
std::vector<KindErrors> errors_by_kind(const Evaluation& evaluation, const Campaign& campaign);
/// The errors of images alone [m]; empty without images.
std::vector<double> image_errors(const Evaluation& evaluation, const Campaign& campaign);

/// Errors of a robot on some poses.
struct PoseErrors {
  ErrorSummary position;                    ///< [m]
  std::optional<ErrorSummary> orientation;  ///< [rad]
  std::vector<AxisErrors> axes;             ///< [m]
  std::vector<KindErrors> kinds;
  double metre_per_pixel = 0;  ///< as Campaign::metre_per_pixel
};

/// The campaign has rows.
PoseErrors errors_of(const Evaluation& evaluation, const Campaign& campaign);
/// Throws std::invalid_argument as evaluate() does, and if the campaign has no rows.
PoseErrors errors_of(const Robot& robot, const Campaign& campaign);

/// Where the noise floor comes from.
struct NoiseFloor {
  enum class Source { replicates, instrument, none };
  /// Mean length of the error of a reading that is normal noise only [m]; 0 without a floor.
  double mean_error() const;

  Source source = Source::none;
  int axes = 3;       ///< numbers per row: 3 of a point, 1 of a distance or coordinate
  /// Number of axes of equal noise that scatter as much (Satterthwaite): `axes`, or fewer where the
  /// noise of one axis or session is larger.
  double even_axes = 3;
  /// Share of the readings that are points, in one row or three, for mean_error(). A pixel counts
  /// as pi / 2 - 1 of a point, which gives the mean error of two numbers.
  double points = 1;
  /// Standard deviation per axis [m]; if rows state their own sigma, that of a row with the median
  /// sigma.
  double position = 0;
  double orientation = 0;      ///< [rad]; 0 without orientations
  int degrees_of_freedom = 0;  ///< of the replicates, times the efficiency of their deviation
  double median_sigma = 0;     ///< that the rows state, of which `position` is the noise [m]; or 0
  /// Nine of ten replicates agree to kFinestReading where the model does not agree with them:
  /// copies of one reading. They say nothing of the noise.
  bool are_copies = false;
};

/// Estimated from replicates (rows of one session, pose, channel and load, see below), if they have
/// 20 degrees of freedom or more: the robust_deviation() of
///     sqrt(m / (m - 1)) (r - mean of the m replicates' r),
/// with r the residual of a row times (median sigma / own sigma), of each axis and session
/// (sessions of fewer than 30 count as one), and the root of their mean square. Where that robust
/// deviation is below kFinestReading, as of readings on a coarse scale, most of which agree, it is
/// their root mean square. Otherwise, or if they are copies, it is the median `sigma_mm` of the
/// rows, else the noise that the robot file states. Replicates read one after the other at
/// standstill show the noise of the instrument only, not how well the arm returns to a pose.
NoiseFloor noise_floor(const Robot& robot, const Campaign& campaign, const Evaluation& evaluation);

/// The same without the rows of blunders (ascending), evaluated with the robot.
NoiseFloor noise_floor_without(const std::vector<int>& blunders, const Robot& robot,
                               const Campaign& campaign);

/// Mean length of an error that is normal noise only, with the standard deviation s per axis: s
/// sqrt(8 / pi) for three axes, s sqrt(pi / 2) for two, s sqrt(2 / pi) for one.
double mean_error_of_noise(double deviation_per_axis, int axes = 3);

/// NoiseFloor::mean_error() of readings whose rows may state standard deviations: the mean over the
/// readings, each with its own. They may be other readings than those of the floor.
double mean_error(const NoiseFloor& noise, const Campaign& campaign);

/// Compares the residual of a fit with the noise of its readings; blunders are left out. The
/// lack-of-fit p is the probability of a Q this large if the model were complete (Draper, Smith,
/// "Applied regression analysis", 1998, 2.1):
///     Q = sum over groups of replicates of m |mean residual|^2 / noise^2,
/// with f = axes x groups - unknowns. Against replicates, `noise` is the root mean square of their
/// deviations: a robust one would take the tails of the noise, which are in Q as well, for a lack.
/// Q / f is F-distributed with f even_axes / axes and the replicates' degrees of freedom, times
/// even_axes / axes. Against a stated floor, Q is chi-squared with f; residuals of
/// rows that state covariances are white there (Campaign::whitening). Empty without a floor.
struct FitQuality {
  std::vector<int> blunders;  ///< rows with a weight below 0.05: some 14 standard deviations
  NoiseFloor noise;
  std::optional<double> lack_of_fit;              ///< of position and orientation together
  std::optional<double> lack_of_fit_in_position;  ///< of position alone
  /// `left`: root mean square of the residuals, per axis and without blunders, corrected for the
  /// unknowns. `pure`: of the noise, by replicates where they show the floor, else as stated (0:
  /// unknown). Both for a row with the median sigma [m, rad].
  InstrumentNoise left, pure;
  /// Standard deviation, per axis, of what the model lacks in a position [m]. With Q by `pure` in
  /// place of the floor, without the orientations, and m readings in a group on average:
  ///     rest^2 = pure^2 (Q / f - 1) / m, or 0 if that is negative,
  /// the variance between groups (Searle, Casella, McCulloch, "Variance components", 1992, 3.6).
  /// Replicates share what the model lacks, so that unknowns take up groups, not readings.
  double rest = 0;

  /// Whether what the fit leaves may be noise (p >= 0.01); nothing where no noise is known.
  std::optional<bool> leaves_noise() const;
};
FitQuality assess(const CalibrationResult& fit, const Campaign& campaign);

/// `evaluation`: evaluate(fit.robot, campaign).
FitQuality assess(const CalibrationResult& fit, const Campaign& campaign,
                  const Evaluation& evaluation);

}  // namespace armtrue
