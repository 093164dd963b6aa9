#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/fold_by.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/calibration/observation.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

struct CalibrationResult;

/// What the residuals of a fit look like.
struct ResidualLaw {
  ReadingSigma sigma;
  double degrees_of_freedom = 0;                 ///< of Student's t; 0: Gaussian
  std::map<std::string, double> prior_widths{};  ///< as CalibrationResult::prior_widths
};

struct CalibrationOptions {
  bool robust = true;  ///< false: least squares, even if the residuals have heavy tails
  /// Number of the robot's effects, counted from the first, whose coefficients are fitted. The
  /// others predict with the coefficients that they have.
  int fitted_effects = kAllEffects;
  int max_iterations = 1000;  ///< weakly observable directions need hundreds
  double tolerance = 1e-10;   ///< stop when an iteration lowers the cost by less than this share
  /// Sigma and law of the residuals to start from, such as those of an earlier fit. Nothing: sigma
  /// from the median of the residuals, Student's t with 4 degrees of freedom if `robust`.
  std::optional<ResidualLaw> start_law{};
  /// How the steps of the solver reduce the rows. The statistics of the result are always by QR.
  FoldBy fold_by = FoldBy::qr;

  /// Sets the two above for one step of a search, a fit of nearly the same model to the same
  /// campaign: starts from the law of `fit`, and steps by the normal equations.
  void start_near(const CalibrationResult& fit);
};

struct CalibrationResult {
  Robot robot;  ///< with the identified values, and their standard deviations in `std`
  IdentifiableSet set;
  /// Names of the unknowns: geometric parameters, coefficients, then the own parameters of further
  /// sessions (`session day 2 base.x`).
  std::vector<std::string> names;
  Eigen::VectorXd change;      ///< from the start [SI]
  Eigen::MatrixXd covariance;  ///< of the unknowns [SI], clustered by pose
  /// L with L L^T = (J^T W J + priors)^-1, unknowns x rank [SI]: the covariance if readings were
  /// independent of each other with the standard deviation `sigma`.
  Eigen::MatrixXd inverse_root;
  /// Prior of each unknown as one more equation: 1 / its standard deviation [1/SI], zero without a
  /// prior, and the residual of the equation at the solution.
  Eigen::VectorXd prior_weight, prior_residual;
  /// Deviations that the priors of a class share: "lengths" [m], "angles", "zero offsets" [rad],
  /// and of families, by their names, as factors of their typical sizes.
  std::map<std::string, double> prior_widths;
  /// How much of each unknown the readings say, 1 - posterior variance / prior variance; 1 without
  /// a prior. Below a half it stands nearer to its nominal value than to what the readings say.
  Eigen::VectorXd share_of_readings;
  /// How many of the unknowns positions and orientations determine; priors determine the others.
  std::array<double, 2> determined{};
  ReadingSigma sigma;   ///< by which readings are weighted, in poses that are not off as a whole
  ReadingSigma spread;  ///< of all readings about the model, those of poses off as a whole included
  double degrees_of_freedom = 0;  ///< of Student's t that describes the residuals; 0 = Gaussian
  std::vector<double> weights;    ///< of each row; a row far below 1 looks like a blunder
  int rank = 0;                   ///< of the Jacobian of all unknowns
  double condition = 0;           ///< of the Jacobian of the geometric unknowns in m and rad
  std::array<double, 5> observability{};  ///< O1 ... O5
  bool converged = false;
  int iterations = 0;
  std::string termination;  ///< the solver's own words
};

/// Below this share of its readings a parameter is said to stand at its nominal value.
inline constexpr double kMostlyReadings = 0.5;

/// The parameters, as indices into fit.set.kept, of which the readings say less than their priors
/// do, and how many poses like these would tell the best known of them apart from its nominal
/// value: with s the share of the readings at n poses, n (1 - s) / s. 0: no number of poses like
/// these.
struct NearNominal {
  std::vector<int> parameters;
  int poses = 0;
};
NearNominal near_nominal(const CalibrationResult& fit, const Campaign& campaign);

/// Identifies, from measured poses, the geometric parameters that `robot.identify` allows and the
/// campaign can show, and the coefficients of the robot's effects.
///
/// Maximum likelihood under Student's t, whose degrees of freedom and sigma of position and
/// orientation are found from the residuals, by Levenberg and Marquardt's method (Ceres) on the
/// folded residual block. A base far from the measurements is first set by rigid registration of
/// the points or anchors. Several sessions are solved jointly: the robot is common; each further
/// session adds the six unknowns of its base and the zero offsets of `robot.identify_per_session`,
/// which count in covariance, rank and observability. Their values stand in `robot.sessions`.
/// Readings of a pose may err alike. So the covariance, and with it every standard deviation, is
/// found from the influence of each pose on the fit (cluster covariance CR3 of Bell, McCaffrey
/// 2002). Priors, and directions that only one pose shows, contribute with their own standard
/// deviation and that of the readings. Intervals are Student's with poses - 1 degrees of freedom.
/// Lack of convergence and of rank are reported in the result. Throws std::invalid_argument if
/// there are not more equations than unknowns, or the robot and the campaign do not fit together.
CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const CalibrationOptions& options = {});

/// The same with the geometric parameters given: refits a model after an effect is added.
CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const IdentifiableSet& set, const CalibrationOptions& options = {});

/// O1 = (s_1 ... s_L)^(1/L) / sqrt(n), O2 = s_L / s_1, O3 = s_L, O4 = s_L^2 / s_1, O5 = 1 / sum
/// 1/s_i with s the singular values, largest first, of the Jacobian of n readings (Borm, Menq 1991;
/// Driels, Pathre 1990; Nahvi et al. 1994; Nahvi, Hollerbach 1996; Sun, Hollerbach 2008).
std::array<double, 5> observability(const Eigen::VectorXd& singular_values, int readings);

/// Calibrates a robot that was carried to another set-up: fits only what `what` names (base, tool,
/// single parameters); links and effects stay as they are. Each session of the campaign has a base
/// of its own; zero offsets that `robot` knows of a session are kept.
Robot refit_set_up(const Robot& robot, const Campaign& campaign,
                   const std::vector<std::string>& what);

}  // namespace armtrue
