#include "tracing/random_effects.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/statistics/summary.h"
#include "linear_algebra/decompositions.h"
#include "search/candidates.h"
#include "search/scan.h"
#include "statistics/variance_components.h"

namespace armtrue {
namespace {

using Rows = std::vector<Eigen::Index>;

// Numbers of equations from which the error at a pose is chosen, and of the model: they give a
// variance to some per cent. Memory is their number times that of the columns.
constexpr double kEquationsOfChoice = 4000, kMaxEquations = 12000;
constexpr double kReturn = 20e-6;     // rad: usual error of a joint at a pose; m on a rail
constexpr double kStepOfReturn = 3;   // factor between two that are tried
constexpr double kMostOfReturn = 3000;
// Relative to noise^2: columns with less information are left out where the error at a pose is
// chosen, and at the end.
constexpr double kMinWorthOfChoice = 0.3, kMinWorth = 0.03;
constexpr double kLeastOfNoise = 0.01;  // RMS: a group that moves readings less is no part of the arm
constexpr Eigen::Index kMostOfBlock = 128;  // columns turned together

// A block of random numbers that have one variance.
struct Block {
  size_t group, effect;  // the first of its effects
  size_t effects;
  Eigen::Index first, count;  // columns
  Eigen::MatrixXd root;       // coefficients of its effects, one after the other, x columns
  Eigen::MatrixXd silent;     // the same of the numbers of which the readings say nothing
};

// A fit as a mixed model: equations whitened by the fit, fixed effects with their priors.
struct Equations {
  Eigen::MatrixXd random;    // equations x random numbers of all groups
  Eigen::MatrixXd fixed;     // equations x unknowns of the fit
  Eigen::Index geometric = 0, coefficients = 0;  // of `fixed`: those of the effects stand behind
  Eigen::VectorXd weight;    // of each unknown, by its prior
  Eigen::VectorXd residual;
  Eigen::MatrixXd joints;    // equations x joints: derivatives by their zero offsets, times kReturn
  Eigen::MatrixXd prior;     // x unknowns: what was known beforehand
  Eigen::VectorXd prior_residual;
  std::vector<Rows> of_pose;
  std::vector<Block> blocks;
  int row_size = 1;
  double log_scale = 0;  // ln of what the equations are multiplied with
};

// Rotates the random numbers of each block so that their columns, projected off the fixed effects,
// are orthogonal, and leaves out those without information.
void turn_blocks(const std::vector<EffectGroup>& groups, double min_worth, Equations& all) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(all.fixed);
  const Eigen::MatrixXd basis = first_columns(qr.householderQ(), qr.rank());
  Eigen::Index from = 0, to = 0;
  for (size_t g = 0; g < groups.size(); ++g) {
    const std::vector<RandomEffect>& effects = groups[g].effects;
    for (size_t k = 0; k < effects.size();) {
      Block block{g, k, 0, to, 0, {}, {}};
      Eigen::Index coefficients = 0, numbers = 0;
      while (k < effects.size() &&
             (block.effects == 0 || numbers + effects[k].root.cols() <= kMostOfBlock)) {
        coefficients += effects[k].root.rows();
        numbers += effects[k].root.cols();
        ++block.effects, ++k;
      }
      const Eigen::MatrixXd own = all.random.middleCols(from, numbers);
      const Eigen::MatrixXd beside = own - basis * (basis.transpose() * own);
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes{
          Eigen::MatrixXd(beside.transpose() * beside)};
      // In ascending order of their information.
      const Eigen::Index worthless = (axes.eigenvalues().array() <= min_worth).count();
      block.count = numbers - worthless;
      const auto silent = axes.eigenvectors().leftCols(worthless);
      const auto turn = axes.eigenvectors().rightCols(block.count);
      all.random.middleCols(to, block.count).noalias() = own * turn;  // `to` is never beyond `from`
      block.root.resize(coefficients, block.count);
      block.silent.resize(coefficients, worthless);
      Eigen::Index row = 0, number = 0;
      for (size_t i = block.effect; i < block.effect + block.effects; ++i) {
        const Eigen::MatrixXd& root = effects[i].root;
        block.root.middleRows(row, root.rows()) =
            root * turn.middleRows(number, root.cols());
        block.silent.middleRows(row, root.rows()) = root * silent.middleRows(number, root.cols());
        row += root.rows(), number += root.cols();
      }
      from += numbers, to += block.count;
      if (block.count > 0) all.blocks.push_back(std::move(block));
    }
  }
  all.random.conservativeResize(Eigen::NoChange, to);
}

Equations equations(const std::vector<EffectGroup>& groups, const CalibrationResult& fit,
                    const Campaign& campaign, double min_worth) {
  Equations all;
  const SessionModels models(campaign, fit.robot, fit.set.kept, fit.sigma);
  Eigen::MatrixXd blocks = models.blocks();
  all.row_size = models.row_size();
  for (int row = 0; row < campaign.rows(); ++row)
    blocks.middleRows(row * all.row_size, all.row_size) *= std::sqrt(fit.weights[row]);
  // The weights of Student's law have any scale; here a residual has the size 1.
  const double left =
      std::sqrt(blocks.rightCols<1>().squaredNorm() / static_cast<double>(blocks.rows()));
  const double scale = left > 0 ? 1 / left : 1;
  blocks *= scale;
  all.log_scale = std::log(scale);
  all.fixed = blocks.leftCols(models.unknowns());
  all.residual = blocks.rightCols<1>();
  all.geometric = models.geometric_count();
  for (const Effect& effect : fit.robot.effects) all.coefficients += std::ssize(effect.coefficients);
  all.weight = fit.prior_weight;
  const std::vector<int> pose = campaign.pose_by_id();
  all.of_pose.resize(1 + *std::max_element(pose.begin(), pose.end()));
  for (size_t row = 0; row < pose.size(); ++row)
    for (int k = 0; k < all.row_size; ++k)
      all.of_pose[pose[row]].push_back(static_cast<Eigen::Index>(row) * all.row_size + k);
  Rows known;
  for (Eigen::Index k = 0; k < fit.prior_weight.size(); ++k)
    if (fit.prior_weight[k] > 0) known.push_back(k);
  all.prior = Eigen::MatrixXd(fit.prior_weight.asDiagonal())(known, Eigen::all);
  all.prior_residual = fit.prior_residual(known);

  std::vector<Candidate> candidates;
  Eigen::Index numbers = 0;
  for (const EffectGroup& group : groups)
    for (const RandomEffect& random : group.effects) {
      candidates.emplace_back().effect = random.effect;
      numbers += random.root.cols();
    }
  const CandidateScan scan(candidates, fit.robot, in_common_frame(campaign, fit.robot));
  const Linearization linear(fit, campaign);
  all.random.resize(blocks.rows(), numbers);
  Eigen::Index next = 0;
  int candidate = 0;
  for (const EffectGroup& group : groups)
    for (const RandomEffect& random : group.effects) {
      all.random.middleCols(next, random.root.cols()) =
          scan.columns_at_readings(linear, candidate++) * (scale * random.root);
      next += random.root.cols();
    }
  const int joints = joint_count(fit.robot.chain);
  all.joints.resize(blocks.rows(), joints);
  const Replicates& replicates = linear.replicates();
  for (int row = 0; row < linear.rows(); ++row)
    for (int r = replicates.first[row]; r < replicates.first[row + 1]; ++r)
      for (int j = 0; j < joints; ++j)
        all.joints.col(j).segment(replicates.reading[r] * all.row_size, all.row_size) =
            scale * kReturn * replicates.share[r] *
            linear.jacobian().col(zero_offset(fit.robot.chain, j)).segment(row * all.row_size,
                                                                          all.row_size);
  turn_blocks(groups, min_worth, all);
  return all;
}

// Sums beside the fixed effects.
struct Folded {
  MixedModelSums sums;
  double log_determinant = 0;  // of all variances but the random numbers'
  Eigen::MatrixXd of_unknowns;  // see RandomNumbers
};

// With A the derivatives of a pose by its joints and A A^T = U S U^T, multiplies its equations by
// (I + A A^T)^(-1/2) = I + U ((1 + S)^(-1/2) - 1) U^T. Returns ln det (I + A A^T).
double whiten_pose(const Eigen::MatrixXd& a, const Rows& rows, Eigen::MatrixXd& fixed,
                   Eigen::MatrixXd& random) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes{Eigen::MatrixXd(a.transpose() * a)};
  Rows kept;
  for (Eigen::Index k = 0; k < axes.eigenvalues().size(); ++k)
    if (axes.eigenvalues()[k] > 1e-9) kept.push_back(k);
  if (kept.empty()) return 0;
  const Eigen::ArrayXd squares = axes.eigenvalues()(kept);
  const Eigen::MatrixXd u =
      a * axes.eigenvectors()(Eigen::all, kept) * squares.rsqrt().matrix().asDiagonal();
  const Eigen::MatrixXd turn = u * ((1 + squares).rsqrt() - 1).matrix().asDiagonal();
  fixed(rows, Eigen::all) += turn * (u.transpose() * fixed(rows, Eigen::all));
  random(rows, Eigen::all) += turn * (u.transpose() * random(rows, Eigen::all));
  return (1 + squares).log().sum();
}

// ln of the prior precision of the coefficients of effects. A coefficient without a prior gets the
// information of one equation (Schwarz 1978).
double log_prior(const Eigen::MatrixXd& fixed, const Equations& all, double freedom) {
  if (all.coefficients == 0) return 0;
  Eigen::MatrixXd columns(fixed.rows(), fixed.cols());
  const Eigen::Index behind = all.geometric + all.coefficients, own = fixed.cols() - behind;
  columns << fixed.leftCols(all.geometric), fixed.rightCols(own),
      fixed.middleCols(all.geometric, all.coefficients);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  double sum = 0;
  for (Eigen::Index k = 0; k < all.coefficients; ++k) {
    const double weight = all.weight[all.geometric + k];
    const double r = qr.matrixQR()(all.geometric + own + k, all.geometric + own + k);
    sum += weight > 0 ? 2 * std::log(weight) : std::log(r * r / freedom);
  }
  return sum;
}

// `scale`: error of a joint at a pose, as a multiple of the usual one.
Folded fold(const Equations& all, double scale) {
  const Eigen::Index own = all.residual.size(), known = all.prior.rows(), p = all.random.cols();
  Eigen::MatrixXd fixed(own + known, all.fixed.cols());
  fixed << all.fixed, all.prior;
  Eigen::MatrixXd random = Eigen::MatrixXd::Zero(own + known, p + 1);  // the residual last
  random.topLeftCorner(own, p) = all.random;
  random.rightCols<1>() << all.residual, all.prior_residual;
  Folded folded;
  if (scale > 0)
    for (const Rows& rows : all.of_pose)
      if (!rows.empty())
        folded.log_determinant +=
            whiten_pose(scale * all.joints(rows, Eigen::all), rows, fixed, random);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(fixed);
  const Eigen::MatrixXd basis = first_columns(qr.householderQ(), qr.rank());
  const Eigen::MatrixXd on_basis = basis.transpose() * random;
  random.noalias() -= basis * on_basis;
  folded.of_unknowns = Eigen::MatrixXd::Zero(fixed.cols(), p);
  folded.of_unknowns.topRows(qr.rank()) = -qr.matrixR()
                                               .topLeftCorner(qr.rank(), qr.rank())
                                               .triangularView<Eigen::Upper>()
                                               .solve(on_basis.leftCols(p));
  folded.of_unknowns = qr.colsPermutation() * folded.of_unknowns;
  folded.sums.zz = Eigen::MatrixXd::Zero(p, p);
  folded.sums.zz.selfadjointView<Eigen::Lower>().rankUpdate(random.leftCols(p).transpose());
  folded.sums.zz = Eigen::MatrixXd(folded.sums.zz.selfadjointView<Eigen::Lower>());
  folded.sums.zr = random.leftCols(p).transpose() * random.rightCols<1>();
  folded.sums.rr = random.rightCols<1>().squaredNorm();
  folded.sums.freedom = static_cast<double>(own + known - qr.rank());
  folded.log_determinant +=
      2 * qr.matrixQR().diagonal().head(qr.rank()).cwiseAbs().array().log().sum();
  folded.log_determinant -= 2 * static_cast<double>(own) * all.log_scale;
  folded.log_determinant -= log_prior(fixed, all, folded.sums.freedom);
  return folded;
}

// Twice the log likelihood without random effects.
double evidence_alone(const Folded& folded) {
  const double freedom = folded.sums.freedom;
  return -folded.log_determinant - freedom * std::log(folded.sums.rr / freedom);
}

// Of each group the columns that it has; groups without any are left out.
struct Widths {
  std::vector<VarianceGroup> of;
  std::vector<size_t> group;
};

Widths widths_of(const std::vector<EffectGroup>& groups, const Equations& all) {
  Widths widths;
  for (const Block& block : all.blocks) {
    if (widths.group.empty() || widths.group.back() != block.group) {
      widths.group.push_back(block.group);
      widths.of.push_back({block.first, 0, groups[block.group].log_spread});
    }
    widths.of.back().count += block.count;
  }
  return widths;
}

struct Fit {
  double scale;  // error of a joint at a pose, as a multiple of the usual one
  Folded folded;
  Widths widths;
  VarianceComponents found;
  double evidence;
};

// `near`: variances of nearly the same model, from which the search for these begins.
Fit fit_of(const std::vector<EffectGroup>& groups, const Equations& all, double scale,
           const Fit* near = nullptr) {
  Fit fit{scale, fold(all, scale), widths_of(groups, all), {}, 0};
  const bool is_like = near && near->widths.group == fit.widths.group;
  fit.found = restricted_likelihood(fit.folded.sums, fit.widths.of,
                                    is_like ? near->found.tau : Eigen::VectorXd());
  fit.evidence = evidence_alone(fit.folded) + fit.found.gain;
  return fit;
}

CalibrationResult of_rows(CalibrationResult fit, const CalibrationResult& law,
                          const std::vector<int>& rows) {
  fit.weights.clear();
  for (int row : rows) fit.weights.push_back(law.weights[row]);
  fit.sigma = law.sigma;
  return fit;
}

std::vector<int> some_rows(const Campaign& campaign, int row_size, double most) {
  const auto poses = static_cast<double>(campaign.pose_ids.size());
  const double equations = static_cast<double>(campaign.rows()) * row_size;
  return rows_of_some_poses(campaign, std::lround(poses * std::min(1.0, most / equations)));
}

bool errs(const EffectGroup& group) {
  return is_lasting_of_instrument(group.effects.front().effect);
}

bool follows_campaign(const Driver& driver) {
  return driver.involves(DriverKind::time) || driver.involves(DriverKind::temperature) ||
         driver.involves(DriverKind::arrival);
}

void enter(const std::vector<EffectGroup>& groups, const Block& block, const Eigen::VectorXd& mean,
           double tau, const Robot& robot, const Campaign& campaign, RandomEffects& result) {
  const Eigen::VectorXd values = block.root * mean.segment(block.first, block.count);
  Eigen::Index next = 0;
  for (size_t k = block.effect; k < block.effect + block.effects; ++k) {
    Effect effect = groups[block.group].effects[k].effect;
    effect.name = kRemainder;
    const BoundEffect bound(effect, robot, campaign.temperature_names);
    for (const std::string& name : bound.coefficient_names())
      effect.coefficients.push_back({name, values[next++]});
    if (follows_campaign(effect.driver)) {
      result.of_campaign.push_back(std::move(effect));
    } else {
      const auto count = std::ssize(effect.coefficients);
      result.numbers.of_lasting.push_back({block.first, block.root.middleRows(next - count, count),
                                           tau * block.silent.middleRows(next - count, count)});
      result.lasting.push_back(std::move(effect));
    }
  }
}

}  // namespace

RandomEffects random_effects(const CalibrationResult& fit, const Campaign& campaign,
                             const std::vector<EffectGroup>& groups, const CalibrationResult& law) {
  if (summarize(position_errors(fit.robot, campaign)).rms < kFinestReading) return {};
  const int row_size = campaign.reading_size().all();
  const auto model_of = [&](double most, double min_worth) {
    const std::vector<int> rows = some_rows(campaign, row_size, most);
    return equations(groups, of_rows(fit, law, rows), campaign.select(rows), min_worth);
  };
  Equations equations = model_of(kEquationsOfChoice, kMinWorthOfChoice);
  Fit best = fit_of(groups, equations, 1);
  for (double scale = kStepOfReturn; scale < kMostOfReturn; scale *= kStepOfReturn) {
    Fit next = fit_of(groups, equations, scale, &best);
    if (next.evidence < best.evidence) break;
    best = std::move(next);
  }
  const bool is_promising = best.found.gain > 0.5 * kMinGain;
  if (is_promising) {
    equations = model_of(kMaxEquations, kMinWorth);
    best = fit_of(groups, equations, best.scale, &best);
  }
  auto& [scale, folded, widths, found, evidence] = best;
  RandomEffects result;
  result.gain = found.gain;
  result.determined = found.determined;
  result.evidence = evidence;
  result.joints_err =
      scale * scale * equations.joints.squaredNorm() > static_cast<double>(equations.joints.rows());
  const double readings = folded.sums.freedom;
  std::vector<bool> counts(groups.size());
  std::vector<double> tau(groups.size());
  for (size_t k = 0; k < widths.of.size(); ++k) {
    const VarianceGroup& width = widths.of[k];
    const Eigen::VectorXd u = found.mean.segment(width.first, width.count);
    const auto own =
        folded.sums.zz.block(width.first, width.first, width.count, width.count);
    const EffectGroup& group = groups[widths.group[k]];
    const double moved = std::sqrt(u.dot(own * u) / readings);
    const ReadingSize size = campaign.reading_size();
    result.groups.push_back(
        {group.name, group.owner == EffectGroup::Owner::arm, moved / found.noise,
         moved / std::exp(equations.log_scale) * fit.sigma.position * std::sqrt(size.position)});
    tau[widths.group[k]] = found.tau[k];
    counts[widths.group[k]] = result.groups.back().of_noise > kLeastOfNoise;
  }
  // Errors of the instrument are among the groups only if the instrument has them.
  for (const Block& block : equations.blocks)
    if (counts[block.group] && (found.gain >= kMinGain || errs(groups[block.group])))
      enter(groups, block, found.mean, tau[block.group], fit.robot, campaign, result);
  // u | r ~ N(mean, s^2 (Z'^T Z' + s^2 / tau^2)^-1)
  result.numbers.precision = std::move(folded.sums.zz);
  for (size_t k = 0; k < widths.of.size(); ++k)
    result.numbers.precision.diagonal().segment(widths.of[k].first, widths.of[k].count).array() +=
        std::pow(found.noise / found.tau[k], 2);
  result.numbers.precision /= found.noise * found.noise;
  result.numbers.of_unknowns = std::move(folded.of_unknowns);
  return result;
}

CalibrationResult beside(const CalibrationResult& fit, const Campaign& campaign,
                         const RandomEffects& random) {
  Robot robot = fit.robot;
  robot.effects.insert(robot.effects.end(), random.lasting.begin(), random.lasting.end());
  robot.effects.insert(robot.effects.end(), random.of_campaign.begin(), random.of_campaign.end());
  CalibrationOptions options;
  options.fitted_effects = static_cast<int>(fit.robot.effects.size());
  options.start_near(fit);
  CalibrationResult result = calibrate(robot, campaign, fit.set, options);
  const double of_position = campaign.reading_size().share_of_position();
  result.determined[0] += random.determined * of_position;
  result.determined[1] += random.determined * (1 - of_position);
  return result;
}

Campaign in_order_of_visits(Campaign campaign) {
  if (campaign.time_s.empty())
    for (int row = 0; row < campaign.rows(); ++row)
      campaign.time_s.push_back(campaign.line[row]);
  return campaign;
}

}  // namespace armtrue
