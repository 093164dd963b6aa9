#include "armtrue/calibration/calibration.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "armtrue/calibration/prediction.h"
#include "armtrue/calibration/refit.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/reading_law.h"
#include "armtrue/observation/registration.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/text/number_text.h"
#include "calibration/fit_statistics.h"
#include "calibration/levenberg_marquardt.h"
#include "calibration/prior.h"

namespace armtrue {
namespace {

// A larger campaign starts from rows at equal steps, then continues with sixteen times as many, and
// so on: each fit leaves a quarter of the distance to the solution of all rows.
constexpr int kRowsForStart = 4096, kMoreRows = 16;
constexpr int kStepsOfRound = 2;     // of the solver, near the solution
// Relative tolerances of the cost. Rough: while sigma and law still change. End: for all rows,
// after a fit to a part of them has brought the unknowns within their standard deviations.
constexpr double kRoughTolerance = 1e-6, kEndTolerance = 1e-7;
// Start value of the standard deviation of a reading, if the robot file states no noise.
constexpr double kTypicalSigma = 1e-4;        // m
constexpr double kStartDegreesOfFreedom = 4;  // of Student's t, before anything is known

// Squared norms [m^2, rad^2], not whitened: sigma is multiplied in again, the ratios of the rows'
// own standard deviations stay divided out.
std::vector<Eigen::Vector2d> raw_norms(const SessionModels& models, const Eigen::VectorXd& x) {
  std::vector<Eigen::Vector2d> norms = models.squared_norms(x);
  const ReadingSigma sigma = models.sigma();
  for (Eigen::Vector2d& s : norms) {
    s[0] *= sigma.position * sigma.position;
    s[1] *= sigma.orientation * sigma.orientation;
  }
  return norms;
}

std::vector<KeptDerivatives> kept_at(const SessionModels& models, const Eigen::VectorXd& x) {
  std::vector<KeptDerivatives> kept;
  for (int g = 0; g < models.groups(); ++g)
    kept.push_back(keep_derivatives(models.model(g).at(models.unknowns_of(g, x)), models.model(g)));
  return kept;
}

// Geometric mean of two descriptions of the residuals.
ResidualDescription half_way(const ReadingSigma& sigma, const ReadingLaw& law,
                             ResidualDescription next) {
  next.sigma = {std::sqrt(sigma.position * next.sigma.position),
                std::sqrt(sigma.orientation * next.sigma.orientation)};
  if (law.variance.size() == next.law.variance.size()) {
    for (size_t row = 0; row < law.variance.size(); ++row)
      next.law.variance[row] = std::sqrt(law.variance[row] * next.law.variance[row]);
    next.law = bounded_law(next.law.degrees_of_freedom, std::move(next.law.variance));
  }
  return next;
}

// Sets sigma, law and widths of the priors for the first round. Far from the solution sigma is that
// of the misfit. The priors are widened by the same factor, to keep their strength relative to the
// readings. `noise`: what sigma will be there.
void set_start(const CalibrationOptions& options, const ReadingSigma& noise,
               const Eigen::VectorXd& x, SessionModels& model, ReadingLaw& law, Priors& priors) {
  const std::vector<Eigen::Vector2d> at_start = raw_norms(model, x);
  if (options.start_law) {
    model.set_sigma(options.start_law->sigma);
    law = bounded_law(options.start_law->degrees_of_freedom,
                      pose_variances(at_start, model.campaign(), options.start_law->sigma));
  } else {
    model.set_sigma(median_sigma(at_start, model.campaign().reading_size()));
    if (options.robust) law = {kStartDegreesOfFreedom};
  }
  if (options.start_law && !options.start_law->prior_widths.empty())
    set_widths(options.start_law->prior_widths, priors);
  else
    scale_widths(std::max(1.0, model.sigma().position / noise.position), priors);
}

// Gives other rows of the same campaign, at the solution x of a part, the law of that part.
void set_law_of_rows(const Eigen::VectorXd& x, const ReadingSigma& sigma, SessionModels& model,
                     ReadingLaw& law) {
  model.set_sigma(sigma);
  if (law.degrees_of_freedom > 0)
    law = bounded_law(law.degrees_of_freedom,
                      pose_variances(raw_norms(model, x), model.campaign(), sigma));
}

// Estimates sigma, law, widths of the priors and x in turn, until convergence.
Solution fit(SessionModels& model, ReadingLaw& law, Priors& priors,
             const CalibrationOptions& options, Eigen::VectorXd& x) {
  const ReadingSize size = model.campaign().reading_size();
  const double rows = model.rows();
  const Eigen::Array2d equations = rows * Eigen::Array2d(size.position, size.orientation);
  const InstrumentNoise stated = model.noise();
  const ReadingSigma noise{stated.position > 0 ? stated.position : kTypicalSigma,
                           stated.orientation > 0 ? stated.orientation : kTypicalSigma};
  set_start(options, noise, x, model, law, priors);
  const bool near = options.start_law && !options.start_law->prior_widths.empty();
  Solution solution;
  int iterations = 0;
  bool settled = false;
  double last_change = 0;  // of ln sigma
  const bool by_steps = options.fold_by == FoldBy::normal_equations;
  std::vector<KeptDerivatives> kept;
  for (int round = 0; round < options.max_rounds; ++round) {
    const bool last_round = settled || round + 1 == options.max_rounds;
    const int left = options.max_iterations - iterations;
    // Near the solution x and law approach theirs together, a step at a time, by the derivatives of
    // the start. The last round is to end at the solution.
    if (by_steps && (round == 0 || last_round)) kept = kept_at(model, x);
    solution = minimise(
        model, law, priors.of_unknowns,
        by_steps && !last_round ? std::min(left, kStepsOfRound) : left,
        last_round ? options.tolerance : std::max(options.tolerance, kRoughTolerance),
        options.fold_by, x, kept, last_round ? Curvature::of_each_step : Curvature::of_first_step);
    iterations += solution.iterations;
    if (last_round || iterations >= options.max_iterations) break;
    const Eigen::MatrixXd information = joint_information(model, solution.folds);
    const Eigen::Array2d freedom =
        (equations - determined_by(model, information, priors, x)).max(0.0);
    ResidualDescription next =
        describe_residuals(raw_norms(model, x), model.campaign(), model.sigma(),
                           equations / freedom.max(1.0), options.robust);
    next.sigma = sigma_with_prior(next.sigma, freedom, noise, model.campaign().has_orientation());
    // The information at the new sigma, and the priors at theirs.
    const double rescaled = model.sigma().position / next.sigma.position;
    if (round == 0 && !near) scale_widths(1, priors);
    const bool widths_settled =
        update_widths(information, x, priors, rescaled * rescaled, model.unknowns_by_groups());
    settled = is_close(next.sigma, model.sigma()) &&
              next.law.degrees_of_freedom == law.degrees_of_freedom && widths_settled;
    // x depends on the law of the rows, and the law on x: they can alternate without end.
    const double change = std::log(next.sigma.position / model.sigma().position);
    if (change * last_change < 0) next = half_way(model.sigma(), law, std::move(next));
    last_change = change;
    model.set_sigma(next.sigma);
    law = next.law;
  }
  solution.iterations = iterations;
  return solution;
}

// Enters a deviation if its variance is positive: for readings that agree exactly, rounding leaves
// a variance near zero of either sign.
void set_deviation(const std::string& name, double variance, std::map<std::string, double>& std) {
  if (variance > 0 && std::isfinite(variance)) std[name] = std::sqrt(variance);
}

void set_robot(const SessionModels& model, const Eigen::VectorXd& x, CalibrationResult& result) {
  result.robot = model.robot_at(x);
  result.robot.std.clear();
  result.robot.uncertainty.reset();
  if (result.covariance.size() == 0) return;
  int k = 0;
  for (; k < model.geometric_count(); ++k)
    set_deviation(result.names[k], result.covariance(k, k), result.robot.std);
  for (int s = 1; s < model.sessions(); ++s) {
    const std::vector<int>& own = model.own(s);
    const auto count = std::ssize(own);
    const int all = layout_of(result.robot.chain).targets;
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(all, all);
    covariance(own, own) =
        result.covariance.block(model.first_own(s), model.first_own(s), count, count);
    // The base's, turned into the axes of the session's own R_A.
    Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(all, all);
    turn.block<3, 3>(kFirstBaseParameter, kFirstBaseParameter) =
        turn.block<3, 3>(kFirstBaseParameter + 3, kFirstBaseParameter + 3) =
            model.common_from_own(s).rotation.transpose();
    const Eigen::MatrixXd turned = turn * covariance;
    covariance = turned * turn.transpose();
    Session& session = result.robot.sessions.at(model.name(s));
    session.std.clear();
    for (int parameter : own)
      set_deviation(parameter_name(result.robot.chain, parameter),
                    covariance(parameter, parameter), session.std);
  }
  const double wide = student_t_975(model.campaign().poses() - 1);
  for (int e = 0; e < model.fitted_effects(); ++e)
    for (Coefficient& c : result.robot.effects[e].coefficients) {
      // The readings say nothing about effects that nothing drives in them.
      if (result.share_of_readings[k] > 0) {
        c.std = std::sqrt(std::max(0.0, result.covariance(k, k)));
        c.ci95 = {c.value - wide * c.std, c.value + wide * c.std};
      }
      ++k;
    }
}

void require_enough_readings(const SessionModels& model, const std::vector<Prior>& priors) {
  // A prior of a parameter or a curve counts as an equation; the mere bound of an effect does not.
  const auto known = std::ranges::count_if(priors, [&](const Prior& prior) {
    return prior.width >= 0 || prior.unknown < model.geometric_count();
  });
  const auto equations = model.rows() * model.row_size() + known;
  if (equations <= model.unknowns())
    throw std::invalid_argument(model.campaign().source + ": " + counted(model.rows(), "reading") +
                                (model.rows() == 1 ? " gives " : " give ") +
                                counted(equations, "equation") + " for " +
                                counted(model.unknowns(), "unknown") +
                                "; measure more poses, or identify fewer parameters (--identify)");
}

// Sets the coefficients of effects that are declared without them to zero. Without masses an effect
// of gravity has a coefficient for each first moment that this geometry shows; an earlier geometry
// may have shown more or fewer.
void match_coefficients(Robot& robot, const Campaign& campaign) {
  const bool knows_moments = !robot.bodies.empty() && !robot.ground_link;
  const auto match = [&](Effect& effect) {
    const bool by_gravity = effect.driver.kind == DriverKind::gravity_torque ||
                            effect.driver.kind == DriverKind::moment;
    if (!effect.coefficients.empty() && (knows_moments || !by_gravity)) return;
    const BoundEffect bound(effect, robot, campaign.temperature_names);
    effect.coefficients.resize(bound.coefficient_count());
  };
  for (Effect& effect : robot.effects) {
    for (Effect& member : effect.members) match(member);
    match(effect);
  }
}

void forget_measured(Robot& robot, int fitted_effects) {
  for (int e = 0; e < fitted_effects && e < std::ssize(robot.effects); ++e)
    robot.effects[e].driver_range.reset();
}

// Whether a joint that slides follows the angle of one next to it about the same axis: a screw, as
// of the quill of a SCARA, moves it in proportion.
bool is_screw(const KinematicChain& chain, const Effect& effect) {
  constexpr double kSame = 0.01;  // rad; m
  if (effect.shape.kind != ShapeKind::linear || !is_of_one_angle(effect)) return false;
  const auto parameter = find_parameter(chain, effect.parameter);
  if (!parameter || !is_zero_offset(chain, *parameter)) return false;
  const int slides = link_of_parameter(*parameter),
            turns = link_of_parameter(zero_offset(chain, effect.driver.joint));
  if (std::abs(slides - turns) != 1 || !is_prismatic(chain.links[slides]) ||
      is_prismatic(chain.links[turns]))
    return false;
  const Link& second = chain.links[std::max(slides, turns)];
  return std::abs(std::sin(second.alpha)) < kSame && std::abs(std::sin(second.beta)) < kSame &&
         std::abs(second.d) < kSame;
}

// Whether an effect must not be extrapolated beyond the covered values of its driver: a slope, a
// curve, or less than one cycle, which many causes resemble. Several cycles may be, and a law of
// time or temperature or a screw, unless another effect moves the same parameter by the same
// driver.
bool ends_at_readings(const KinematicChain& chain, const Effect& effect, double covered,
                      bool alone) {
  if (!can_be_bounded(effect)) return false;
  if (alone && (!is_of_one_angle(effect) || is_screw(chain, effect))) return false;
  const Shape& shape = effect.shape;
  switch (shape.kind) {
    case ShapeKind::linear:
    case ShapeKind::kink:
    case ShapeKind::series:
      return true;
    case ShapeKind::harmonic:
      return shape.harmonic * covered < kTurn;
    default:
      return false;
  }
}

// Fitted effects end where the readings end, with all effects of the same parameter and driver:
// readings determine their sum, in which large parts may cancel.
void set_measured(const Campaign& campaign, int fitted_effects, Robot& robot) {
  const std::span fitted(robot.effects.begin(), fitted_effects);
  for (const Effect& ending : fitted) {
    if (!can_be_bounded(ending)) continue;
    const auto [low, high] = std::ranges::minmax(values_of(ending.driver, campaign));
    const auto alike = std::ranges::count_if(
        fitted, [&](const Effect& effect) { return same_place(effect, ending); });
    if (!ends_at_readings(robot.chain, ending, high - low, alike == 1)) continue;
    for (Effect& effect : fitted)
      if (same_place(effect, ending)) effect.driver_range = {low, high};
  }
}

}  // namespace

CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const IdentifiableSet& set, const CalibrationOptions& options) {
  Robot start = starting_robot(robot, campaign, set.kept);
  if (!start.nominal) start.nominal = robot.chain;
  forget_measured(start, options.fitted_effects);
  match_coefficients(start, campaign);
  constexpr auto kSplit = SessionModels::Split::by_target;
  SessionModels model(campaign, start, set.kept, {1.0, 1.0}, options.fitted_effects, kSplit);
  Priors priors = priors_of(start, model);
  require_enough_readings(model, priors.of_unknowns);

  Eigen::VectorXd x = Eigen::VectorXd::Zero(model.unknowns());
  ReadingLaw law;
  ReadingSigma sigma;
  int iterations = 0;
  // The solution of a part is farther off than a start near the solution of all rows.
  if (!options.start_law)
    for (int rows = kRowsForStart; model.rows() > 2 * rows; rows *= kMoreRows) {
      const Campaign part = campaign.select(thinned_rows(campaign, rows));
      SessionModels part_model(part, start, set.kept, {1.0, 1.0}, options.fitted_effects, kSplit);
      if (iterations == 0) {
        iterations = fit(part_model, law, priors, options, x).iterations;
        sigma = part_model.sigma();
        continue;
      }
      set_law_of_rows(x, sigma, part_model, law);
      iterations += minimise(part_model, law, priors.of_unknowns, options.max_iterations,
                             kEndTolerance, options.fold_by, x)
                        .iterations;
    }
  Solution solution;
  if (iterations > 0) {
    set_law_of_rows(x, sigma, model, law);
    solution = minimise(model, law, priors.of_unknowns, options.max_iterations, kEndTolerance,
                        options.fold_by, x);
    solution.iterations += iterations;
  } else {
    solution = fit(model, law, priors, options, x);
  }
  CalibrationResult result;
  result.set = set;
  result.change = x;
  result.converged = solution.converged;
  result.iterations = solution.iterations;
  result.termination = solution.termination;
  result.sigma = model.sigma();
  result.degrees_of_freedom = law.degrees_of_freedom;
  if (options.statistics == FitStatistics::weights) {
    set_weights_alone(model, law, priors, x, solution.folds, result);
  } else {
    if (options.fold_by == FoldBy::normal_equations) solution.folds.clear();
    set_statistics(model, law, priors, x, std::move(solution.folds), options.statistics, result);
  }
  for (const PriorWidth& width : priors.widths)
    if (!width.name.empty()) result.prior_widths[width.name] = width.deviation;
  set_robot(model, x, result);
  set_measured(campaign, model.fitted_effects(), result.robot);
  return result;
}

CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const CalibrationOptions& options) {
  const IdentifiableSet set = require_identifiable(robot, campaign);
  CalibrationResult fit = calibrate(robot, campaign, set, options);
  // What the readings show depends on where the measured frame is: a reflector on the last axis, as
  // a rough file may have it, shows less than one beside it.
  constexpr double kElsewhere = 0.01;  // m
  Robot placed = robot;
  placed.chain.tool = fit.robot.chain.tool;
  if ((placed.chain.tool.translation - robot.chain.tool.translation).norm() < kElsewhere)
    return fit;
  const IdentifiableSet there = choose_identifiable(placed, campaign);
  return there.kept == set.kept ? fit : calibrate(robot, campaign, there, options);
}

CalibrationResult refit(const Robot& robot, const Campaign& campaign, const CalibrationResult& near,
                        double tolerance, int max_rounds, bool robust) {
  CalibrationOptions options;
  options.robust = robust;
  options.start_near(near);
  options.tolerance = tolerance;
  options.max_rounds = max_rounds;
  options.statistics = FitStatistics::weights;
  return calibrate(robot, campaign, near.set, options);
}

NearNominal near_nominal(const CalibrationResult& fit, const Campaign& campaign) {
  constexpr double kShareBeyondHelp = 0.01;  // share from which no number of such poses would help
  NearNominal result;
  double most = 0;
  for (int k = 0; k < std::ssize(fit.set.kept); ++k) {
    const double share = fit.share_of_readings[k];
    if (share >= kMostlyReadings) continue;
    result.parameters.push_back(k);
    if (share > kShareBeyondHelp) most = std::max(most, (1 - share) / share);
  }
  result.poses = static_cast<int>(std::ceil(std::max(0.0, most - 1) * campaign.poses()));
  return result;
}

void CalibrationOptions::start_near(const CalibrationResult& fit) {
  start_law = ResidualLaw{fit.sigma, fit.degrees_of_freedom, fit.prior_widths};
  fold_by = FoldBy::normal_equations;
}

Robot refit_set_up(const Robot& robot, const Campaign& campaign,
                   const std::vector<std::string>& what) {
  Robot links_only = robot;
  links_only.identify = what;
  links_only.identify_per_session.clear();
  links_only.effects.clear();
  Robot start = robot;
  start.identify_per_session.clear();
  CalibrationOptions options;
  options.fitted_effects = 0;
  const IdentifiableSet set = require_identifiable(links_only, campaign);
  Robot refitted = calibrate(start, campaign, set, options).robot;
  refitted.identify_per_session = robot.identify_per_session;
  refitted.uncertainty = robot.uncertainty;
  if (robot.uncertainty && rows_by_session(campaign).size() == 1)
    refitted.uncertainty = after_refit(refitted, campaign, set.kept);
  return refitted;
}

}  // namespace armtrue
