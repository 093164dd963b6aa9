#include "armtrue/calibration/calibration.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "armtrue/calibration/prediction.h"
#include "armtrue/statistics/distributions.h"
#include "calibration/covariance.h"
#include "calibration/levenberg_marquardt.h"
#include "calibration/pose_influence.h"
#include "calibration/prior.h"
#include "calibration/reading_law.h"
#include "calibration/refit.h"
#include "calibration/registration.h"
#include "calibration/session_models.h"
#include "campaign/selection.h"
#include "campaign/sessions.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr int kRowsForStart = 4096;  // a larger campaign starts from an even choice of its rows
constexpr int kMaxRounds = 8;  // of sigma and law of the residuals; they settle in three or four
constexpr int kStepsOfRound = 2;  // of the solver, near the solution
// Relative, of the cost. Rough: while sigma and law still change. End: of all rows, where a fit to
// an even choice of them has brought the unknowns to within their standard deviations.
constexpr double kRoughTolerance = 1e-6, kEndTolerance = 1e-7;
// Of a reading about the model, where the robot file states no noise; a start, no more.
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

// The triangle of all rows, from the folds of the sessions.
Eigen::MatrixXd joint_factor(const SessionModels& models, const std::vector<SessionFold>& folds) {
  std::vector<Eigen::MatrixXd> factors;
  for (const SessionFold& session : folds) factors.push_back(session.folded.triangle());
  return models.join(factors);
}

// J^T W J of all rows.
Eigen::MatrixXd joint_information(const SessionModels& models,
                                  const std::vector<SessionFold>& folds) {
  std::vector<Eigen::MatrixXd> informations;
  for (const SessionFold& session : folds) informations.push_back(session.folded.information());
  return models.sum(informations);
}

std::vector<KeptDerivatives> kept_at(const SessionModels& models, const Eigen::VectorXd& x) {
  std::vector<KeptDerivatives> kept;
  for (int s = 0; s < models.sessions(); ++s)
    kept.push_back(
        keep_derivatives(models.model(s).at(models.unknowns_of(s, x)), models.model(s)));
  return kept;
}

// How many of the unknowns positions and orientations determine: tr J (J_all^T J_all + P)^-1 J^T,
// J of that kind, P of the priors. With many equations, in proportion to their numbers, which
// leaves sigma right to 3 %.
Eigen::Array2d determined_by(const SessionModels& model, Eigen::MatrixXd information,
                             const Priors& priors, const Eigen::VectorXd& x) {
  constexpr double kMany = 4;  // equations per unknown
  const ReadingSize size = model.campaign().reading_size();
  const int p = model.unknowns();
  if (model.rows() * size.all() > kMany * p || size.orientation == 0)
    return (p - undetermined(information, priors)) *
           Eigen::Array2d(size.share_of_position(), 1 - size.share_of_position());
  add_priors(priors.of_unknowns, information);
  const Eigen::MatrixXd root = inverse_root(information);
  const SessionModels::At at = model.at(x);
  Eigen::MatrixXd block(model.row_size(), p + 1);
  Eigen::Array2d determined = Eigen::Array2d::Zero();
  for (int row = 0; row < model.rows(); ++row) {
    at.block(row, block);
    const Eigen::MatrixXd moved = block.leftCols(p) * root;
    determined[0] += moved.topRows(size.position).squaredNorm();
    determined[1] += moved.bottomRows(size.orientation).squaredNorm();
  }
  return determined;
}

// Sigma where hardly more readings than unknowns are left over to show it. Beforehand
// ln sigma ~ N(ln expected, 2^2), so with S the sum of squares, sigma^2 f of f degrees of freedom,
//     S / sigma^2 = f + ln(sigma / expected) / 4.
// With many degrees of freedom it changes nothing.
double sigma_by_prior_too(double sigma, double freedom, double expected) {
  const double squares = sigma * sigma * freedom;
  double low = std::log(kMinSigma), high = std::log(std::max(sigma, expected)) + 1;
  while (high - low > 1e-9) {
    const double middle = 0.5 * (low + high);
    const double excess =
        squares * std::exp(-2 * middle) - freedom - 0.25 * (middle - std::log(expected));
    (excess > 0 ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

// Half the way from one description of the residuals to the next, by ratio.
ResidualDescription half_way(const ReadingSigma& sigma, const ReadingLaw& law,
                             ResidualDescription next) {
  next.sigma = {std::sqrt(sigma.position * next.sigma.position),
                std::sqrt(sigma.orientation * next.sigma.orientation)};
  if (law.variance.size() == next.law.variance.size())
    for (size_t row = 0; row < law.variance.size(); ++row)
      next.law.variance[row] = std::sqrt(law.variance[row] * next.law.variance[row]);
  return next;
}

// Sigma, law, widths of the priors and x in turn, until they settle.
Solution fit(SessionModels& model, ReadingLaw& law, Priors& priors,
             const CalibrationOptions& options, Eigen::VectorXd& x) {
  const ReadingSize size = model.campaign().reading_size();
  const Eigen::Array2d equations =
      static_cast<double>(model.rows()) * Eigen::Array2d(size.position, size.orientation);
  const std::vector<Eigen::Vector2d> at_start = raw_norms(model, x);
  if (options.start_law) {
    model.set_sigma(options.start_law->sigma);
    law = {options.start_law->degrees_of_freedom,
           pose_variances(at_start, model.campaign(), options.start_law->sigma)};
  } else {
    model.set_sigma(median_sigma(at_start, size));
    if (options.robust) law = {kStartDegreesOfFreedom};
  }
  // Far from the solution sigma is that of the misfit. The priors are widened by as much, so that
  // they hold back no more than they would at the noise.
  const InstrumentNoise stated = model.noise();
  const ReadingSigma noise{stated.position > 0 ? stated.position : kTypicalSigma,
                           stated.orientation > 0 ? stated.orientation : kTypicalSigma};
  const bool near = options.start_law && !options.start_law->prior_widths.empty();
  if (near)
    set_widths(options.start_law->prior_widths, priors);
  else
    scale_widths(std::max(1.0, model.sigma().position / noise.position), priors);
  Solution solution;
  int iterations = 0;
  bool settled = false;
  double last_change = 0;  // of ln sigma
  const bool by_steps = options.fold_by == FoldBy::normal_equations;
  std::vector<KeptDerivatives> kept;
  for (int round = 0; round < kMaxRounds; ++round) {
    const bool last_round = settled || round + 1 == kMaxRounds;
    const int left = options.max_iterations - iterations;
    // Near the solution x and law approach theirs together, a step at a time. The first round moves
    // x most, and the last one is to end at the solution.
    if (by_steps && (round <= 1 || last_round)) kept = kept_at(model, x);
    solution =
        minimise(model, law, priors.of_unknowns,
                 by_steps && !last_round ? std::min(left, kStepsOfRound) : left,
                 last_round ? options.tolerance : std::max(options.tolerance, kRoughTolerance),
                 options.fold_by, x, kept);
    iterations += solution.iterations;
    if (last_round || iterations >= options.max_iterations) break;
    const Eigen::MatrixXd information = joint_information(model, solution.folds);
    const Eigen::Array2d freedom =
        (equations - determined_by(model, information, priors, x)).max(0.0);
    ResidualDescription next =
        describe_residuals(raw_norms(model, x), model.campaign(), model.sigma(),
                           equations / freedom.max(1.0), options.robust);
    next.sigma.position = sigma_by_prior_too(next.sigma.position, freedom[0], noise.position);
    if (model.campaign().has_orientation())
      next.sigma.orientation =
          sigma_by_prior_too(next.sigma.orientation, freedom[1], noise.orientation);
    // The information at the new sigma, and the priors at theirs.
    const double rescaled = model.sigma().position / next.sigma.position;
    if (round == 0 && !near) scale_widths(1, priors);
    const bool widths_settled = update_widths(rescaled * rescaled * information, x, priors);
    settled = is_close(next.sigma, model.sigma()) &&
              next.law.degrees_of_freedom == law.degrees_of_freedom && widths_settled;
    // x follows the law of the rows, and the law x: they can go round each other without end.
    const double change = std::log(next.sigma.position / model.sigma().position);
    if (change * last_change < 0) next = half_way(model.sigma(), law, std::move(next));
    last_change = change;
    model.set_sigma(next.sigma);
    law = next.law;
  }
  solution.iterations = iterations;
  return solution;
}

// The folds of all sessions at x; one that was made elsewhere is made anew.
std::vector<SessionFold> folds_at(const SessionModels& model, const ReadingLaw& law,
                                  const Eigen::VectorXd& x, std::vector<SessionFold> folds) {
  folds.resize(model.sessions());
  for (int s = 0; s < model.sessions(); ++s) {
    const ObservationModel& session = model.model(s);
    const Eigen::VectorXd own = model.unknowns_of(s, x);
    const ReadingLaw own_law = model.law_of(s, law);
    if (!folds[s].is_at(own, session, own_law))
      folds[s].folded = fold(session.at(own), session, own_law);
  }
  return folds;
}

// Sets the weights of the rows and the spread. Returns the weighted mean square of the whitened
// residuals, at least 1.
double set_weights(const SessionModels& model, const ReadingLaw& law, const Eigen::VectorXd& x,
                   CalibrationResult& result) {
  const std::vector<Eigen::Vector2d> norms = model.squared_norms(x);
  result.weights.resize(norms.size());
  Eigen::Array2d weighted = Eigen::Array2d::Zero(), within_poses = weighted;
  for (size_t i = 0; i < norms.size(); ++i) {
    const double variance = law.variance_of(static_cast<int>(i));
    result.weights[i] = law.weight(norms[i].sum(), model.row_size(), variance);
    weighted += result.weights[i] * norms[i].array();
    within_poses += result.weights[i] / variance * norms[i].array();
  }
  // Sigma is that of readings whose pose is not off as a whole.
  const Eigen::Array2d widening =
      (within_poses > 0).select((weighted / within_poses.max(1e-300)).sqrt(), 1.0);
  result.spread = {result.sigma.position * widening[0], result.sigma.orientation * widening[1]};
  return std::max(1.0, weighted.sum() / static_cast<double>(model.rows() * model.row_size()));
}

// Cholesky's factor of information whose columns have unit length, or nothing if a direction is
// hardly determined.
std::optional<Eigen::LLT<Eigen::MatrixXd>> clear_factor(const Eigen::MatrixXd& information,
                                                        const Eigen::VectorXd& unit) {
  constexpr double kMinPivot = 1e-5;
  Eigen::LLT<Eigen::MatrixXd> llt(unit.asDiagonal() * information * unit.asDiagonal());
  if (llt.info() != Eigen::Success) return std::nullopt;
  if (llt.matrixLLT().diagonal().minCoeff() < kMinPivot) return std::nullopt;
  return llt;
}

Eigen::VectorXd unit_of(const Eigen::MatrixXd& information) {
  return information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
}

// inverse_root() of several sessions: the inverse of Cholesky's triangle. The own unknowns of the
// sessions come first, and no session sees those of another: so it has a block for each session
// beside the columns of the common unknowns, and zeros elsewhere. Empty if a direction is hardly
// determined.
Eigen::MatrixXd inverse_root_by_session(const SessionModels& model,
                                        const Eigen::MatrixXd& information) {
  const int p = model.unknowns(), common = model.first_own(1);
  std::vector<int> order;
  for (int k = common; k < p; ++k) order.push_back(k);
  for (int k = 0; k < common; ++k) order.push_back(k);
  const Eigen::MatrixXd ordered = information(order, order);
  const Eigen::VectorXd unit = unit_of(ordered);
  const auto llt = clear_factor(ordered, unit);
  if (!llt) return {};
  Eigen::MatrixXd root = Eigen::MatrixXd::Identity(p, p);
  llt->matrixU().solveInPlace(root);
  Eigen::MatrixXd result(p, p);
  result(order, Eigen::all) = unit.asDiagonal() * root;
  return result;
}

void set_condition(const SessionModels& model, const Eigen::VectorXd& singular_values,
                   CalibrationResult& result) {
  // In the units of the literature: rows are multiplied by sigma of position.
  const Eigen::VectorXd s = model.sigma().position * singular_values;
  result.condition = s[0] / s[s.size() - 1];
  result.observability = observability(s, model.rows());
}

// Rank, condition and observability of several sessions. They have many unknowns together, and the
// singular values of a triangle of them all take minutes. Where the columns are clearly
// independent, the roots of the eigenvalues of the information are the same. False where they are
// not.
bool set_observability_by_session(const SessionModels& model, const Eigen::MatrixXd& information,
                                  CalibrationResult& result) {
  constexpr double kMinEigenvalue = 1e-10;  // of the largest; a smaller one has few right digits
  const std::vector<int> geometric = model.geometric_unknowns();
  if (geometric.empty() || !clear_factor(information, unit_of(information))) return false;
  const Eigen::MatrixXd chosen = information(geometric, geometric);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(chosen, Eigen::EigenvaluesOnly);
  const Eigen::VectorXd& values = eigen.eigenvalues();  // smallest first
  if (values[0] < kMinEigenvalue * values.tail(1)[0]) return false;
  result.rank = model.unknowns();
  set_condition(model, values.reverse().cwiseSqrt(), result);
  return true;
}

// Rank of all unknowns, coefficients too; condition and observability of the geometric ones.
void set_observability(const SessionModels& model, const std::vector<SessionFold>& folds,
                       CalibrationResult& result) {
  const int p = model.unknowns();
  if (model.sessions() > 1 &&
      set_observability_by_session(model, joint_information(model, folds), result))
    return;
  const Eigen::MatrixXd factor = joint_factor(model, folds);
  // Columns of unit length, whatever their units.
  const Eigen::MatrixXd triangle = factor.topLeftCorner(p, p);
  const Eigen::VectorXd length = triangle.colwise().norm().transpose().cwiseMax(1e-300);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> columns;
  columns.setThreshold(1e-10);
  columns.compute(triangle * length.cwiseInverse().asDiagonal());
  result.rank = static_cast<int>(columns.rank());

  const std::vector<int> geometric = model.geometric_unknowns();
  if (!geometric.empty())
    set_condition(
        model,
        Eigen::JacobiSVD<Eigen::MatrixXd>(factor(Eigen::seqN(0, p), geometric)).singularValues(),
        result);
}

// `folds`: those of the solution, if they may be used for statistics.
void set_statistics(const SessionModels& model, const ReadingLaw& law, const Priors& all_priors,
                    const Eigen::VectorXd& x, std::vector<SessionFold> folds,
                    CalibrationResult& result) {
  const std::vector<Prior>& priors = all_priors.of_unknowns;
  const int p = model.unknowns();
  folds = folds_at(model, law, x, std::move(folds));
  Eigen::MatrixXd information = joint_information(model, folds);
  const Eigen::Array2d determined = determined_by(model, information, all_priors, x);
  result.determined = {determined[0], determined[1]};
  add_priors(priors, information);
  if (model.sessions() > 1) result.inverse_root = inverse_root_by_session(model, information);
  if (result.inverse_root.size() == 0) result.inverse_root = inverse_root(information);
  result.prior_weight = result.prior_residual = Eigen::VectorXd::Zero(p);
  result.share_of_readings = Eigen::VectorXd::Ones(p);
  for (const Prior& prior : priors) {
    result.prior_weight[prior.unknown] = 1.0 / prior.deviation;
    result.prior_residual[prior.unknown] = -prior.residual(x);
    result.share_of_readings[prior.unknown] =
        std::clamp(1 - result.inverse_root.row(prior.unknown).squaredNorm() /
                           (prior.deviation * prior.deviation),
                   0.0, 1.0);
  }
  result.names = model.unknown_names();
  const double variance = set_weights(model, law, x, result);
  result.covariance = covariance_by_pose(model, priors, x, result.weights,
                                         result.degrees_of_freedom, result.inverse_root, variance);
  set_observability(model, folds, result);
}

// What set_statistics() sets for a step of a search.
void set_weights_alone(const SessionModels& model, const ReadingLaw& law, const Priors& priors,
                       const Eigen::VectorXd& x, const std::vector<SessionFold>& folds,
                       CalibrationResult& result) {
  const Eigen::Array2d determined =
      determined_by(model, joint_information(model, folds), priors, x);
  result.determined = {determined[0], determined[1]};
  result.names = model.unknown_names();
  set_weights(model, law, x, result);
}

void set_robot(const SessionModels& model, const Eigen::VectorXd& x, CalibrationResult& result) {
  result.robot = model.robot_at(x);
  result.robot.std.clear();
  result.robot.uncertainty.reset();
  if (result.covariance.size() == 0) return;
  int k = 0;
  for (; k < model.geometric_count(); ++k)
    result.robot.std[result.names[k]] = std::sqrt(result.covariance(k, k));
  for (int s = 1; s < model.sessions(); ++s) {
    const std::vector<int>& own = model.own(s);
    const auto count = static_cast<int>(own.size());
    const int all = layout_of(result.robot.chain).targets;
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(all, all);
    covariance(own, own) =
        result.covariance.block(model.first_own(s), model.first_own(s), count, count);
    // The base's, turned into the axes of the session's own R_A.
    Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(all, all);
    turn.block<3, 3>(kBaseParameters, kBaseParameters) = turn.block<3, 3>(
        kBaseParameters + 3, kBaseParameters + 3) = model.common_from_own(s).rotation.transpose();
    covariance = (turn * covariance * turn.transpose()).eval();
    Session& session = result.robot.sessions.at(model.name(s));
    session.std.clear();
    for (int parameter : own)
      session.std[parameter_name(result.robot.chain, parameter)] =
          std::sqrt(covariance(parameter, parameter));
  }
  const double wide = student_t_975(static_cast<int>(model.campaign().pose_ids.size()) - 1);
  for (int e = 0; e < model.fitted_effects(); ++e)
    for (Coefficient& c : result.robot.effects[e].coefficients) {
      // Of what nothing drives in these readings they say nothing.
      if (result.share_of_readings[k] > 0) {
        c.std = std::sqrt(result.covariance(k, k));
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
  const int equations = model.rows() * model.row_size() + static_cast<int>(known);
  if (equations <= model.unknowns())
    throw std::invalid_argument(
        model.campaign().source + ": " + std::to_string(model.rows()) + " readings give " +
        std::to_string(equations) + " equations for " + std::to_string(model.unknowns()) +
        " unknowns; measure more poses, or identify fewer parameters (--identify)");
}

// Without masses an effect of gravity has as many coefficients as this geometry shows first
// moments, and those of an earlier geometry may be more or fewer.
void match_coefficients(Robot& robot, const Campaign& campaign) {
  if (!robot.bodies.empty()) return;
  const auto match = [&](Effect& effect) {
    const BoundEffect bound(effect, robot, campaign.temperature_names);
    effect.coefficients.resize(static_cast<size_t>(bound.coefficient_count()));
  };
  const auto by_gravity = [](const Effect& effect) {
    return effect.driver.kind == DriverKind::gravity_torque ||
           effect.driver.kind == DriverKind::moment;
  };
  for (Effect& effect : robot.effects) {
    if (!by_gravity(effect)) continue;
    for (Effect& member : effect.members) match(member);
    match(effect);
  }
}

enum class Statistics { all, weights };

CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const IdentifiableSet& set, const CalibrationOptions& options,
                            Statistics statistics) {
  Robot start = starting_robot(robot, campaign, set);
  if (!start.nominal) start.nominal = robot.chain;
  match_coefficients(start, campaign);
  SessionModels model(campaign, start, set.kept, {1.0, 1.0}, options.fitted_effects);
  Priors priors = priors_of(start, model);
  require_enough_readings(model, priors.of_unknowns);

  Eigen::VectorXd x = Eigen::VectorXd::Zero(model.unknowns());
  ReadingLaw law;
  int iterations = 0;
  if (model.rows() > 2 * kRowsForStart) {
    const Campaign part = campaign.select(thinned_rows(campaign, kRowsForStart));
    SessionModels part_model(part, start, set.kept, {1.0, 1.0}, options.fitted_effects);
    iterations = fit(part_model, law, priors, options, x).iterations;
    model.set_sigma(part_model.sigma());
    if (law.degrees_of_freedom > 0)
      law.variance = pose_variances(raw_norms(model, x), campaign, model.sigma());
  }
  Solution solution;
  if (iterations > 0) {
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
  if (statistics == Statistics::weights) {
    set_weights_alone(model, law, priors, x, solution.folds, result);
  } else {
    if (options.fold_by == FoldBy::normal_equations) solution.folds.clear();
    set_statistics(model, law, priors, x, std::move(solution.folds), result);
  }
  for (const PriorWidth& width : priors.widths)
    if (!width.name.empty()) result.prior_widths[width.name] = width.deviation;
  set_robot(model, x, result);
  return result;
}

}  // namespace

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

CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const IdentifiableSet& set, const CalibrationOptions& options) {
  return calibrate(robot, campaign, set, options, Statistics::all);
}

CalibrationResult refit(const Robot& robot, const Campaign& campaign, const CalibrationResult& near,
                        double tolerance) {
  CalibrationOptions options;
  options.start_near(near);
  options.tolerance = tolerance;
  return calibrate(robot, campaign, near.set, options, Statistics::weights);
}

NearNominal near_nominal(const CalibrationResult& fit, const Campaign& campaign) {
  constexpr double kNothing = 0.01;  // share from which no number of such poses would help
  NearNominal result;
  double most = 0;
  for (size_t k = 0; k < fit.set.kept.size(); ++k) {
    const double share = fit.share_of_readings[static_cast<Eigen::Index>(k)];
    if (share >= kMostlyReadings) continue;
    result.parameters.push_back(static_cast<int>(k));
    if (share > kNothing) most = std::max(most, (1 - share) / share);
  }
  result.poses = static_cast<int>(std::ceil(most * static_cast<double>(campaign.pose_ids.size())));
  return result;
}

void CalibrationOptions::start_near(const CalibrationResult& fit) {
  start_law = ResidualLaw{fit.sigma, fit.degrees_of_freedom, fit.prior_widths};
  fold_by = FoldBy::normal_equations;
}

std::array<double, 5> observability(const Eigen::VectorXd& s, int readings) {
  const double largest = s[0], smallest = s[s.size() - 1];
  return {std::exp(s.array().max(1e-300).log().mean()) / std::sqrt(std::max(1, readings)),
          smallest / largest, smallest, smallest * smallest / largest,
          1.0 / s.cwiseInverse().sum()};
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
