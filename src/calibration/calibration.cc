#include "armtrue/calibration/calibration.h"

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "calibration/fold.h"
#include "calibration/pose_influence.h"
#include "calibration/registration.h"
#include "calibration/session_models.h"
#include "campaign/selection.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr double kMinScale = 1e-9;   // m, rad: noise-free simulations must not divide by zero
constexpr int kRowsForStart = 4096;  // a larger campaign starts from an even choice of its rows
constexpr int kPosesForCovariance = 16384;  // tell a standard deviation to half a per cent
constexpr int kMaxRounds = 8;               // of the residuals' law; it settles in three or four
// Of the cost: while the law of the residuals is still settling, and of all rows where an even
// choice of them has brought the unknowns to within their standard deviations.
constexpr double kRoughTolerance = 1e-6, kEndTolerance = 1e-7;

// No effect moves a parameter by more than about this; the data alone may leave a curve free where
// they do not reach, and it must not run away there.
constexpr double kMaxEffect = 0.005;  // m, rad
constexpr double kTypicalCurve = 5e-4, kMinCurve = 1e-6;
constexpr size_t kMinOfCurve = 3;  // coefficients

// Prior knowledge of an unknown: (start + x) / deviation is one more residual, where `start` is how
// far the robot given already lies from what is expected.
struct Prior {
  int unknown;
  double deviation;
  double start = 0;
  int curve = -1;  // which of the effects that are curves, if one

  double residual(const Eigen::Ref<const Eigen::VectorXd>& x) const {
    return (start + x[unknown]) / deviation;
  }
};

// A fold of one session and what it was made at: the solver's last is what the statistics need.
struct LastFold {
  Eigen::VectorXd x;
  ReadingSigma scale;
  ReadingLaw law;
  Fold folded;

  bool is_at(const Eigen::VectorXd& other, const ObservationModel& model,
             const ReadingLaw& other_law) const {
    return x.size() == other.size() && x == other && scale.position == model.scale().position &&
           scale.orientation == model.scale().orientation && law == other_law;
  }
};

// One session, or the whole campaign where it has no more, as one residual block of p + 1
// residuals: the triangle of its fold. Its parameter blocks are the session's runs. Their sum
// of squares is the robust loss, their Jacobian that of the weighted rows, so Levenberg-Marquardt
// takes the same steps as on all rows.
class FoldedCost : public ceres::CostFunction {
 public:
  FoldedCost(const SessionModels& models, int session, const ReadingLaw& law,
             const std::vector<Prior>& priors, FoldBy fold_by, LastFold& last)
      : model_(models.model(session)),
        fold_by_(fold_by),
        law_(models.law_of(session, law)),
        priors_(priors),
        last_(last) {
    for (const SessionModels::Run& run : models.runs(session))
      mutable_parameter_block_sizes()->push_back(run.count);
    set_num_residuals(model_.unknowns() + 1 + static_cast<int>(priors.size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const int p = model_.unknowns();
    Eigen::VectorXd x(p);
    int filled = 0;
    for (size_t b = 0; b < parameter_block_sizes().size(); ++b) {
      std::copy_n(parameters[b], parameter_block_sizes()[b], x.data() + filled);
      filled += parameter_block_sizes()[b];
    }
    const ObservationModel::At at = model_.at(x);
    Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
    r.setZero();
    for (size_t k = 0; k < priors_.size(); ++k)
      r[p + 1 + static_cast<int>(k)] = priors_[k].residual(x);
    if (!jacobians) {
      r[p] = std::sqrt(total_loss(at, model_, law_));
      return std::isfinite(r[p]);
    }
    last_ = {x, model_.scale(), law_, fold(at, model_, law_, fold_by_)};
    const Fold& folded = last_.folded;
    r.head(p) = folded.factor.col(p).head(p);
    // What the linear part does not explain; no unknown moves it.
    r[p] = std::sqrt(std::max(0.0, folded.loss - r.head(p).squaredNorm()));
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(num_residuals(), p);
    jacobian.topRows(p) = -folded.factor.topLeftCorner(p, p);
    for (size_t k = 0; k < priors_.size(); ++k)
      jacobian(p + 1 + static_cast<int>(k), priors_[k].unknown) = 1.0 / priors_[k].deviation;
    int taken = 0;
    for (size_t b = 0; b < parameter_block_sizes().size(); ++b) {
      const int columns = parameter_block_sizes()[b];
      if (jacobians[b])
        Eigen::Map<RowMajor>(jacobians[b], num_residuals(), columns) =
            jacobian.middleCols(taken, columns);
      taken += columns;
    }
    return std::isfinite(r[p]) && jacobian.allFinite();
  }

 private:
  const ObservationModel& model_;
  const FoldBy fold_by_;
  const ReadingLaw law_;
  const std::vector<Prior> priors_;
  LastFold& last_;
};

// The coefficients of a curve are many, and the data may leave some of them nearly free. They are
// taken as draws from one normal law whose deviation is what makes the data most likely (MacKay
// 1992): the curve is as large as the data ask for, and stays small where they say nothing.
struct CurveUpdate {
  bool settled = true;      // the deviations
  double undetermined = 0;  // coefficients, about, of which the readings say nothing
};

CurveUpdate update_curves(const Eigen::MatrixXd& factor, const Eigen::VectorXd& x,
                          std::vector<Prior>& priors) {
  CurveUpdate update;
  int curves = 0;
  for (const Prior& prior : priors) curves = std::max(curves, prior.curve + 1);
  if (curves == 0) return update;
  const Eigen::Index p = x.size();
  const Eigen::MatrixXd triangle = factor.topLeftCorner(p, p);
  Eigen::MatrixXd information = triangle.transpose() * triangle;
  for (const Prior& prior : priors)
    information(prior.unknown, prior.unknown) += 1.0 / (prior.deviation * prior.deviation);
  const Eigen::VectorXd unit = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  const Eigen::MatrixXd inverse = scaled.ldlt().solve(Eigen::MatrixXd::Identity(p, p));
  for (int curve = 0; curve < curves; ++curve) {
    double determined = 0, squares = 0, old = 0;
    for (const Prior& prior : priors) {
      if (prior.curve != curve) continue;
      const double variance =
          inverse(prior.unknown, prior.unknown) * unit[prior.unknown] * unit[prior.unknown];
      old = prior.deviation;
      const double by_readings = std::clamp(1.0 - variance / (old * old), 0.0, 1.0);
      determined += by_readings;
      update.undetermined += 1.0 - by_readings;
      squares += (prior.start + x[prior.unknown]) * (prior.start + x[prior.unknown]);
    }
    const double deviation =
        std::clamp(std::sqrt(squares / std::max(determined, 0.5)), kMinCurve, kMaxEffect);
    update.settled = update.settled && std::abs(deviation - old) < 0.1 * old;
    for (Prior& prior : priors)
      if (prior.curve == curve) prior.deviation = deviation;
  }
  return update;
}

struct Solution {
  bool converged = false;
  int iterations = 0;
  std::string termination;
};

// Beside a fit of nearly the same model there are steps of a search to take.
FoldBy fold_by(const CalibrationOptions& options) {
  return options.near ? FoldBy::normal_equations : FoldBy::qr;
}

Solution solve(const SessionModels& models, const ReadingLaw& law, const std::vector<Prior>& priors,
               int max_iterations, double tolerance, Eigen::VectorXd& x, FoldBy by,
               std::vector<LastFold>& last) {
  last.resize(models.sessions());
  if (x.size() == 0) return {true, 0, "nothing to identify"};
  ceres::Problem problem;
  for (int s = 0; s < models.sessions(); ++s) {
    std::vector<double*> blocks;
    for (const SessionModels::Run& run : models.runs(s)) blocks.push_back(x.data() + run.first);
    // Priors are of the robot and its first base, all of them unknowns of the first session.
    problem.AddResidualBlock(
        new FoldedCost(models, s, law, s == 0 ? priors : std::vector<Prior>{}, by, last[s]),
        nullptr, blocks);
  }
  ceres::Solver::Options options;
  // No session sees another's base.
  options.linear_solver_type =
      models.sessions() == 1 ? ceres::DENSE_QR : ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = tolerance;
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 1e-14;
  // Nearly linear problems with nearly invisible directions: start with hardly any damping.
  options.initial_trust_region_radius = 1e8;
  options.max_trust_region_radius = 1e20;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return {summary.termination_type == ceres::CONVERGENCE,
          std::max(0, static_cast<int>(summary.iterations.size()) - 1), summary.message};
}

// Squared norm of a row, whitened; `s` is unwhitened (m^2, rad^2).
double whitened(const Eigen::Vector2d& s, const ReadingSigma& scale, const ReadingSize& size) {
  return s[0] / (scale.position * scale.position) +
         (size.orientation > 0 ? s[1] / (scale.orientation * scale.orientation) : 0.0);
}

double log_likelihood(const std::vector<Eigen::Vector2d>& norms, const ReadingSigma& scale,
                      const ReadingLaw& law, const ReadingSize& size) {
  const int d = size.all();
  const double n = static_cast<double>(norms.size()), dof = law.degrees_of_freedom;
  double value = -size.position * n * std::log(scale.position);
  if (size.orientation > 0) value -= size.orientation * n * std::log(scale.orientation);
  for (size_t row = 0; row < norms.size(); ++row) {
    const double variance = law.variance_of(static_cast<int>(row));
    value -= 0.5 * law.loss(whitened(norms[row], scale, size), d, variance) / variance;
    if (dof > 0) value -= 0.5 * d * std::log(variance);
  }
  if (dof > 0)
    value +=
        n * (std::lgamma(0.5 * (dof + d)) - std::lgamma(0.5 * dof) - 0.5 * d * std::log(dof / 2));
  return value;
}

// Spreads by expectation-maximisation under a law. `norms` are unwhitened (m^2, rad^2).
ReadingSigma spread(const std::vector<Eigen::Vector2d>& norms, ReadingSigma scale,
                    const ReadingLaw& law, const ReadingSize& size, double correction) {
  const int d = size.all();
  const double n = static_cast<double>(norms.size());
  for (int round = 0; round < (law.degrees_of_freedom > 0 ? 30 : 1); ++round) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (size_t row = 0; row < norms.size(); ++row) {
      const double variance = law.variance_of(static_cast<int>(row));
      sum += law.weight(whitened(norms[row], scale, size), d, variance) / variance * norms[row];
    }
    scale.position = std::max(kMinScale, std::sqrt(correction * sum[0] / (size.position * n)));
    if (size.orientation > 0)
      scale.orientation =
          std::max(kMinScale, std::sqrt(correction * sum[1] / (size.orientation * n)));
  }
  return scale;
}

std::vector<double> variances(const std::vector<Eigen::Vector2d>& norms, const Campaign& campaign,
                              const ReadingSigma& scale) {
  const ReadingSize size = campaign.reading_size();
  std::vector<double> whole;
  for (const Eigen::Vector2d& s : norms) whole.push_back(whitened(s, scale, size));
  return pose_variances(campaign, whole, size.all());
}

bool close(const ReadingSigma& a, const ReadingSigma& b) {
  const auto same = [](double u, double v) { return std::abs(u - v) <= 1e-2 * std::max(u, v); };
  return same(a.position, b.position) && same(a.orientation, b.orientation);
}

struct Residuals {
  ReadingSigma scale;
  ReadingLaw law;
};

// The law and the spreads that make the residuals most likely. Gaussian unless Student's t is
// better by more than the price of its one parameter (BIC).
Residuals describe(const std::vector<Eigen::Vector2d>& norms, const Campaign& campaign,
                   const ReadingSigma& start, double correction, bool robust) {
  const ReadingSize size = campaign.reading_size();
  Residuals best{spread(norms, start, {0}, size, correction), {0}};
  if (!robust) return best;
  const std::vector<double> variance = variances(norms, campaign, start);
  double best_value = log_likelihood(norms, best.scale, best.law, size) +
                      0.5 * std::log(static_cast<double>(norms.size()));
  for (double dof : {2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0, 30.0}) {
    const ReadingLaw law{dof, variance};
    const ReadingSigma scale = spread(norms, start, law, size, correction);
    const double value = log_likelihood(norms, scale, law, size);
    if (value > best_value) {
      best_value = value;
      best = {scale, law};
    }
  }
  // What a pose is off by is in units of the scale, which follows it slowly.
  for (int round = 0; round < kMaxRounds && best.law.degrees_of_freedom > 0; ++round) {
    best.law.variance = variances(norms, campaign, best.scale);
    const ReadingSigma before = best.scale;
    best.scale = spread(norms, before, best.law, size, correction);
    if (close(best.scale, before)) break;
  }
  return best;
}

// Squared norms in m^2 and rad^2: with the model's own scale taken out again, row ratios kept.
std::vector<Eigen::Vector2d> raw_norms(const SessionModels& models, const Eigen::VectorXd& x) {
  std::vector<Eigen::Vector2d> norms = models.squared_norms(x);
  const ReadingSigma scale = models.scale();
  for (Eigen::Vector2d& s : norms) {
    s[0] *= scale.position * scale.position;
    s[1] *= scale.orientation * scale.orientation;
  }
  return norms;
}

ReadingSigma median_scale(const std::vector<Eigen::Vector2d>& norms, const ReadingSize& size) {
  constexpr double kMedianOfChiSquare1 = 0.4549364231, kMedianOfChiSquare3 = 2.365973884;
  std::vector<double> position, orientation;
  for (const Eigen::Vector2d& s : norms) {
    position.push_back(s[0]);
    orientation.push_back(s[1]);
  }
  const auto scale = [](const std::vector<double>& s, double median_of_noise) {
    return std::max(kMinScale, std::sqrt(median(s) / median_of_noise));
  };
  return {scale(position, size.position == 1 ? kMedianOfChiSquare1 : kMedianOfChiSquare3),
          scale(orientation, kMedianOfChiSquare3)};
}

// The triangle of all rows, from the last fold of each session.
Eigen::MatrixXd joint_factor(const SessionModels& models, const std::vector<LastFold>& last) {
  std::vector<Eigen::MatrixXd> factors;
  for (const LastFold& session : last) factors.push_back(session.folded.factor);
  return models.join(factors);
}

Solution fit(SessionModels& model, ReadingLaw& law, std::vector<Prior>& priors,
             const CalibrationOptions& options, Eigen::VectorXd& x, std::vector<LastFold>& last) {
  const double equations = static_cast<double>(model.rows()) * model.row_size();
  const std::vector<Eigen::Vector2d> at_start = raw_norms(model, x);
  if (options.near) {
    model.set_scale(options.near->scale);
    law = {options.near->degrees_of_freedom,
           variances(at_start, model.campaign(), options.near->scale)};
  } else {
    model.set_scale(median_scale(at_start, model.campaign().reading_size()));
    if (options.robust) law = {4.0};
  }
  // Roughly while the law of the residuals is still settling, to the end once it has.
  Solution solution;
  int iterations = 0;
  bool settled = false;
  for (int round = 0; round < kMaxRounds; ++round) {
    const bool last_round = settled || round + 1 == kMaxRounds;
    solution = solve(model, law, priors, options.max_iterations - iterations,
                     last_round ? options.tolerance : std::max(options.tolerance, kRoughTolerance),
                     x, fold_by(options), last);
    iterations += solution.iterations;
    if (last_round || iterations >= options.max_iterations) break;
    const CurveUpdate curves = update_curves(joint_factor(model, last), x, priors);
    const double freedom = equations - (model.unknowns() - curves.undetermined);
    const Residuals next = describe(raw_norms(model, x), model.campaign(), model.scale(),
                                    equations / std::max(1.0, freedom), options.robust);
    settled = close(next.scale, model.scale()) &&
              next.law.degrees_of_freedom == law.degrees_of_freedom && curves.settled;
    model.set_scale(next.scale);
    law = next.law;
  }
  solution.iterations = iterations;
  return solution;
}

// The covariance that all poses would show, from that of some of them; both, and the information of
// those, in coordinates in which the information of all is the unit matrix. A direction of which
// the poses taken show next to nothing, because few poses of all do, has its readings' variance.
Eigen::MatrixXd of_all_poses(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& information,
                             double variance) {
  constexpr double kShown = 0.1;  // of what they show on average
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  const Eigen::VectorXd& shares = eigen.eigenvalues();
  const auto shown = (shares.array() > kShown * shares.mean()).eval();
  const Eigen::VectorXd scale = shown.select(shares.cwiseMax(1e-300).cwiseSqrt().cwiseInverse(), 0);
  const Eigen::MatrixXd turned = scale.asDiagonal() * eigen.eigenvectors().transpose();
  Eigen::MatrixXd scaled = turned * covariance * turned.transpose();
  scaled.diagonal() += shown.select(Eigen::VectorXd::Zero(shares.size()), variance).matrix();
  return eigen.eigenvectors() * scaled * eigen.eigenvectors().transpose();
}

// Covariance of the unknowns from what each pose, and each prior, does to them.
Eigen::MatrixXd covariance_by_pose(const SessionModels& model, const std::vector<Prior>& priors,
                                   const Eigen::VectorXd& x, double variance,
                                   const CalibrationResult& result) {
  const Eigen::MatrixXd& root = result.inverse_root;
  if (root.cols() == 0) return Eigen::MatrixXd::Zero(root.rows(), root.rows());
  const RowsByPose all = rows_by_pose(model.campaign().pose);
  const RowsByPose some = some_poses(all, kPosesForCovariance);
  struct Sums {
    InfluenceSums influence;
    Eigen::MatrixXd information;
  } sums{{}, Eigen::MatrixXd::Zero(root.cols(), root.cols())};
  const bool is_part = some.poses() < all.poses();
  for_each_pose<Sums>(
      model.at(x), result.weights, root, some,
      [&](Sums& block, const PoseInfluence& pose, const auto& rows) {
        block.influence.add(pose);
        if (!is_part) return;
        if (block.information.size() == 0)
          block.information = Eigen::MatrixXd::Zero(root.cols(), root.cols());
        block.information.noalias() += rows.transpose() * rows;
      },
      [&](const Sums& block) {
        sums.influence.add(block.influence);
        if (is_part) sums.information += block.information;
      });
  Eigen::MatrixXd covariance = sums.influence.covariance(
      mean_psi_derivative(result.weights, result.degrees_of_freedom, model.row_size()), variance);
  if (is_part) covariance = of_all_poses(covariance, sums.information, variance);
  for (const Prior& prior : priors) {
    const Eigen::VectorXd known = root.row(prior.unknown).transpose() / prior.deviation;
    covariance += known * known.transpose();
  }
  return root * covariance * root.transpose();
}

void set_statistics(const SessionModels& model, const ReadingLaw& law,
                    const std::vector<Prior>& priors, const Eigen::VectorXd& x,
                    std::vector<LastFold> last, CalibrationResult& result) {
  const int p = model.unknowns();
  last.resize(model.sessions());
  for (int s = 0; s < model.sessions(); ++s) {
    const ObservationModel& session = model.model(s);
    const Eigen::VectorXd own = model.unknowns_of(s, x);
    const ReadingLaw own_law = model.law_of(s, law);
    if (!last[s].is_at(own, session, own_law))
      last[s].folded = fold(session.at(own), session, own_law);
  }
  const Eigen::MatrixXd factor = joint_factor(model, last);
  Eigen::MatrixXd information = factor.topLeftCorner(p, p).transpose() * factor.topLeftCorner(p, p);
  for (const Prior& prior : priors)
    information(prior.unknown, prior.unknown) += 1.0 / (prior.deviation * prior.deviation);
  result.inverse_root = inverse_root(information);
  result.prior_weight = result.prior_residual = Eigen::VectorXd::Zero(p);
  for (const Prior& prior : priors) {
    result.prior_weight[prior.unknown] = 1.0 / prior.deviation;
    result.prior_residual[prior.unknown] = -prior.residual(x);
  }
  result.names = model.unknown_names();
  const std::vector<Eigen::Vector2d> norms = model.squared_norms(x);
  result.weights.resize(norms.size());
  Eigen::Array2d weighted = Eigen::Array2d::Zero(), within_poses = weighted;
  for (size_t i = 0; i < norms.size(); ++i) {
    const double variance = law.variance_of(static_cast<int>(i));
    result.weights[i] = law.weight(norms[i].sum(), model.row_size(), variance);
    weighted += result.weights[i] * norms[i].array();
    within_poses += result.weights[i] / variance * norms[i].array();
  }
  // The scale is that of readings whose pose is not off as a whole.
  const Eigen::Array2d widening =
      (within_poses > 0).select((weighted / within_poses.max(1e-300)).sqrt(), 1.0);
  result.spread = {result.scale.position * widening[0], result.scale.orientation * widening[1]};
  const double variance =
      std::max(1.0, weighted.sum() / static_cast<double>(model.rows() * model.row_size()));
  result.covariance = covariance_by_pose(model, priors, x, variance, result);

  // Of all unknowns, coefficients too: of columns of unit length, whatever their units.
  const Eigen::MatrixXd triangle = factor.topLeftCorner(p, p);
  const Eigen::VectorXd length = triangle.colwise().norm().transpose().cwiseMax(1e-300);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> columns;
  columns.setThreshold(1e-10);
  columns.compute(triangle * length.cwiseInverse().asDiagonal());
  result.rank = static_cast<int>(columns.rank());

  // Observability in the units of the literature: rows as long as one position reading's noise.
  const std::vector<int> geometric = model.geometric_unknowns();
  if (const int g = static_cast<int>(geometric.size()); g > 0) {
    const Eigen::VectorXd s =
        model.scale().position *
        Eigen::JacobiSVD<Eigen::MatrixXd>(factor(Eigen::seqN(0, p), geometric)).singularValues();
    result.condition = s[0] / s[g - 1];
    result.observability = observability(s, model.rows());
  }
}

void set_robot(const SessionModels& model, const Eigen::VectorXd& x, CalibrationResult& result) {
  result.robot = model.robot_at(x);
  result.robot.std.clear();
  int k = 0;
  for (; k < model.geometric_count(); ++k)
    result.robot.std[result.names[k]] = std::sqrt(result.covariance(k, k));
  for (int s = 1; s < model.sessions(); ++s) {
    const std::vector<int>& own = model.own(s);
    const auto count = static_cast<int>(own.size());
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kTargetParameters, kTargetParameters);
    covariance(own, own) =
        result.covariance.block(model.first_own(s), model.first_own(s), count, count);
    // Of the base along the axes of the session's own R_A.
    Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(kTargetParameters, kTargetParameters);
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
      c.std = std::sqrt(result.covariance(k, k));
      c.ci95 = {c.value - wide * c.std, c.value + wide * c.std};
      ++k;
    }
}

std::vector<Prior> priors_of(const Robot& robot, const SessionModels& model) {
  std::vector<Prior> priors;
  for (int k = 0; k < model.geometric_count(); ++k) {
    const auto found = robot.priors.find(parameter_name(robot.chain, model.geometric()[k]));
    if (found != robot.priors.end()) priors.push_back({k, found->second});
  }
  int k = model.geometric_count(), curves = 0;
  for (int e = 0; e < model.fitted_effects(); ++e) {
    const Effect& effect = robot.effects[e];
    const bool is_curve =
        effect.shape.kind == ShapeKind::series && effect.coefficients.size() >= kMinOfCurve;
    double squares = 0;
    for (const Coefficient& c : effect.coefficients) squares += c.value * c.value;
    const double as_before = std::sqrt(squares / static_cast<double>(effect.coefficients.size()));
    const double curve = squares > 0 ? std::max(kMinCurve, as_before) : kTypicalCurve;
    for (const Coefficient& c : effect.coefficients) {
      const double value = model.mean_square_value(k - model.geometric_count());
      if (is_curve)
        priors.push_back({k, curve, c.value, curves});
      else if (value > 0)
        priors.push_back({k, kMaxEffect / std::sqrt(value), c.value});
      ++k;
    }
    curves += is_curve;
  }
  return priors;
}

}  // namespace

CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const CalibrationOptions& options) {
  return calibrate(robot, campaign, choose_identifiable(robot, campaign), options);
}

CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const IdentifiableSet& set, const CalibrationOptions& options) {
  const Robot start = starting_robot(robot, campaign, set);
  SessionModels model(campaign, start, set.kept, {1.0, 1.0}, options.fitted_effects);
  std::vector<Prior> priors = priors_of(start, model);
  // What is known of a curve or a parameter counts as if it were read; that an effect has some
  // bound does not.
  const auto known = std::ranges::count_if(priors, [&](const Prior& prior) {
    return prior.curve >= 0 || prior.unknown < model.geometric_count();
  });
  const int equations = model.rows() * model.row_size() + static_cast<int>(known);
  if (equations <= model.unknowns())
    throw std::invalid_argument(
        campaign.source + ": " + std::to_string(model.rows()) + " readings give " +
        std::to_string(equations) + " equations for " + std::to_string(model.unknowns()) +
        " unknowns; measure more poses, or identify fewer parameters (--identify)");

  Eigen::VectorXd x = Eigen::VectorXd::Zero(model.unknowns());
  ReadingLaw law;
  std::vector<LastFold> last;
  int iterations = 0;
  if (model.rows() > 2 * kRowsForStart) {
    const Campaign part = campaign.select(thinned_rows(campaign, kRowsForStart));
    SessionModels part_model(part, start, set.kept, {1.0, 1.0}, options.fitted_effects);
    iterations = fit(part_model, law, priors, options, x, last).iterations;
    model.set_scale(part_model.scale());
    if (law.degrees_of_freedom > 0)
      law.variance = variances(raw_norms(model, x), campaign, model.scale());
  }
  CalibrationResult result;
  Solution solution;
  if (iterations > 0) {
    solution =
        solve(model, law, priors, options.max_iterations, kEndTolerance, x, fold_by(options), last);
    solution.iterations += iterations;
  } else {
    solution = fit(model, law, priors, options, x, last);
  }
  result.set = set;
  result.change = x;
  result.converged = solution.converged;
  result.iterations = solution.iterations;
  result.termination = solution.termination;
  result.scale = model.scale();
  result.degrees_of_freedom = law.degrees_of_freedom;
  if (fold_by(options) == FoldBy::normal_equations) last.clear();
  set_statistics(model, law, priors, x, last, result);
  set_robot(model, x, result);
  return result;
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
  Robot refitted =
      calibrate(start, campaign, choose_identifiable(links_only, campaign), options).robot;
  refitted.identify_per_session = robot.identify_per_session;
  return refitted;
}

}  // namespace armtrue
