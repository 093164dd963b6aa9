#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/observation/fold_by.h"
#include "armtrue/observation/observation.h"

namespace armtrue {

struct CalibrationResult;

/// Sigma and distribution of the residuals of a fit.
struct ResidualLaw {
  ReadingSigma sigma;
  double degrees_of_freedom = 0;                 ///< of Student's t; 0: normal distribution
  std::map<std::string, double> prior_widths{};  ///< as CalibrationResult::prior_widths
};

/// The statistics of a fit that are computed. The others are empty, and unless it is `all`, no
/// standard deviation is set.
enum class FitStatistics {
  weights,      ///< weights, spread and determined
  information,  ///< and inverse_root, share_of_readings and the equations of the priors
  all,          ///< and covariance, rank, condition and observability
};

struct CalibrationOptions {
  bool robust = true;  ///< false: least squares, even if the residuals have heavy tails
  /// Number of the robot's effects, from the first, whose coefficients are fitted. The others keep
  /// their coefficients.
  int fitted_effects = kAllEffects;
  int max_iterations = 1000;  ///< weakly observable directions need hundreds
  double tolerance = 1e-10;   ///< stop when an iteration lowers the cost by less than this share
  /// Sigma and distribution of the residuals to start from, such as those of an earlier fit. If
  /// empty: sigma from the median of the residuals, Student's t with 4 degrees of freedom if
  /// `robust`.
  std::optional<ResidualLaw> start_law{};
  /// Most rounds in which law and unknowns are estimated in turn; they settle in three or four. 1:
  /// `start_law` is kept.
  int max_rounds = 8;
  /// How the steps of the solver reduce the rows. The statistics of the result always use QR.
  FoldBy fold_by = FoldBy::qr;
  FitStatistics statistics = FitStatistics::all;

  /// Sets `start_law` to that of `fit`, and `fold_by` to the normal equations. For one step of a
  /// search, which fits nearly the same model to the same campaign.
  void start_near(const CalibrationResult& fit);
};

struct CalibrationResult {
  Robot robot;  ///< with the identified values, and their standard deviations in `std`
  IdentifiableSet set;
  /// Names of the unknowns: geometric parameters, coefficients, then the own parameters of further
  /// sessions (`session day 2 base.x`).
  std::vector<std::string> names;
  int shared = 0;              ///< how many come before the own ones of further sessions
  Eigen::VectorXd change;      ///< of each unknown from its start value [SI]
  Eigen::MatrixXd covariance;  ///< of the unknowns [SI], clustered by pose
  /// L with L L^T = (J^T W J + P)^-1, P the information of the priors; unknowns x rank [SI]. It
  /// would be the covariance if readings were independent of each other with the standard deviation
  /// `sigma`.
  Eigen::MatrixXd inverse_root;
  /// Prior of each unknown as one more equation: weight 1 / standard deviation [1/SI], zero without
  /// a prior, and residual at the solution.
  Eigen::VectorXd prior_weight, prior_residual;
  /// Standard deviation of the priors of a class: "lengths" [m], "angles", "zero offsets" [rad]; by
  /// the name of a family, the factor of its typical sizes.
  std::map<std::string, double> prior_widths;
  /// Share of each unknown that the readings determine: 1 - posterior variance / prior variance; 1
  /// without a prior. Below 0.5 the result is nearer to the nominal value than to that of the
  /// readings alone.
  Eigen::VectorXd share_of_readings;
  /// Number of unknowns that the positions and the orientations determine; priors determine the
  /// rest.
  std::array<double, 2> determined{};
  ReadingSigma sigma;   ///< of the readings, as weights use it; gross poses left out
  ReadingSigma spread;  ///< of all readings about the model, gross poses included
  double degrees_of_freedom = 0;  ///< of Student's t of the residuals; 0: normal
  std::vector<double> weights;    ///< of each row
  /// Weight of each row relative to its pose; far below 1: probably a blunder.
  std::vector<double> weights_in_pose;
  int rank = 0;          ///< of the Jacobian of all unknowns
  double condition = 0;  ///< of the Jacobian of the geometric unknowns in m and rad
  std::array<double, 5> observability{};  ///< O1 ... O5
  bool converged = false;
  int iterations = 0;
  std::string termination;  ///< message of the solver
};

/// A parameter whose share_of_readings is below this is reported as near its nominal value.
inline constexpr double kMostlyReadings = 0.5;

/// The parameters that their priors determine more than the readings, and the number of further
/// poses like these at which s = 0.5 for each: the largest n (1 - s) / s, less n, with s the
/// share_of_readings at n poses. Parameters with s below 0.01 do not count.
struct NearNominal {
  std::vector<int> parameters;  ///< indices into fit.set.kept
  int poses = 0;                ///< 0: no number of poses like these is enough
};
NearNominal near_nominal(const CalibrationResult& fit, const Campaign& campaign);

/// Identifies, from measured poses, the geometric parameters that `robot.identify` allows and the
/// campaign can show, and the coefficients of the robot's effects.
///
/// Maximum likelihood under Student's t. Its degrees of freedom and the sigma of position and of
/// orientation are estimated from the residuals. The solver is Levenberg-Marquardt (Ceres) on the
/// residual block, which is first reduced to a triangle (fold). A base far from the measurements is
/// first set by rigid registration of the points or anchors. Several sessions are solved jointly:
/// the robot is common; each further session adds the six unknowns of its base and the zero offsets
/// of `robot.identify_per_session`, which count in covariance, rank and observability. Their values
/// stand in `robot.sessions`. Readings of one pose may share an error. So the covariance, and with
/// it every standard deviation, comes from the influence of each pose on the fit (cluster
/// covariance CR3 of Bell, McCaffrey 2002; CR2 where each pose gives one number). Priors contribute
/// with their own standard deviation, and directions that only one pose shows with that of the
/// readings. Intervals are those of Student's t with poses - 1 degrees of freedom. The result
/// reports a lack of convergence or of rank. Throws std::invalid_argument if there are not more
/// equations than unknowns, or the robot and the campaign do not fit together.
CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const CalibrationOptions& options = {});

/// The same with the set of geometric parameters given, for the refit of a model after an effect is
/// added.
CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const IdentifiableSet& set, const CalibrationOptions& options = {});

/// O1 = (s_1 ... s_L)^(1/L) / sqrt(n), O2 = s_L / s_1, O3 = s_L, O4 = s_L^2 / s_1, O5 = 1 / sum
/// 1/s_i with s the singular values, largest first, of the Jacobian of n readings (Borm, Menq 1991;
/// Driels, Pathre 1990; Nahvi et al. 1994; Nahvi, Hollerbach 1996; Sun, Hollerbach 2008).
std::array<double, 5> observability(const Eigen::VectorXd& singular_values, int readings);

/// Calibrates a robot in another set-up: fits only what `what` names (base, tool, single
/// parameters); all else stays as it is. Each session of the campaign has a base of its own; zero
/// offsets that `robot` knows of a session are kept.
Robot refit_set_up(const Robot& robot, const Campaign& campaign,
                   const std::vector<std::string>& what);

}  // namespace armtrue
