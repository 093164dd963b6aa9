#include "armtrue/identification/change.h"

#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "armtrue/identification/evaluation.h"
#include "armtrue/identification/identifiability.h"
#include "armtrue/identification/statistics.h"
#include "armtrue/kinematics/parameters.h"
#include "fold.h"
#include "sessions.h"

namespace armtrue {
namespace {

constexpr double kIndistinguishable = 6;  // BIC
constexpr double kBlunderWeight = 0.25;   // some six standard deviations under Student's t
constexpr double kMostBlunders = 0.3;     // of the rows
constexpr int kMaxSteps = 30;

double probability_above(double chi_square, double degrees_of_freedom) {
  return boost::math::cdf(
      boost::math::complement(boost::math::chi_squared(degrees_of_freedom), chi_square));
}

// Unknowns that are free, as places in the model's list; none: nothing has moved.
struct Hypothesis {
  std::string what;
  std::vector<int> free;
};

// The readings of a campaign against the previous robot and what is known of its parameters.
struct Problem {
  ObservationModel model;
  Eigen::VectorXd deviations;  // of the unknowns; 0: not identified, so held unless free
  std::vector<double> shares;  // of each row in its pose and channel
  double equations = 0;        // replicates counted once
};

struct Fit {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;
  std::vector<double> weights;  // of the rows
  double loss = 0;              // chi-square, or twice the negative log-likelihood
};

bool is_place_of_anchor(const KinematicChain& chain, int parameter) {
  const int k = parameter - first_anchor_parameter(chain);
  return k >= 0 && k % 4 < 3;
}

Problem make_problem(const Robot& previous, const Campaign& campaign, const ReadingScale& scale) {
  std::vector<int> unknowns;
  std::vector<double> deviations;
  for (int k = 0; k < parameter_count(previous.chain); ++k) {
    const auto found = previous.std.find(parameter_name(previous.chain, k));
    const bool of_set_up = k < kLinkParameters || (k >= kToolParameters && k < kInstrumentScale) ||
                           (campaign.has_distances() && is_place_of_anchor(previous.chain, k));
    if (found == previous.std.end() && !of_set_up) continue;
    unknowns.push_back(k);
    deviations.push_back(found == previous.std.end() ? 0 : found->second);
  }
  Problem problem{ObservationModel(campaign, previous, unknowns, scale, false),
                  Eigen::Map<Eigen::VectorXd>(deviations.data(), std::ssize(deviations)),
                  {},
                  0};
  std::map<std::pair<int, int>, int> replicates;
  const auto key = [&](int row) { return std::pair{campaign.pose[row], campaign.channel(row)}; };
  for (int row = 0; row < campaign.rows(); ++row) ++replicates[key(row)];
  for (int row = 0; row < campaign.rows(); ++row)
    problem.shares.push_back(1.0 / replicates[key(row)]);
  problem.equations = static_cast<double>(replicates.size()) * problem.model.row_size();
  return problem;
}

// What of the base these readings show: of distances from one anchor, its translation.
std::vector<int> visible_of_base(Robot robot, const Campaign& campaign) {
  robot.identify = {"base"};
  return choose_identifiable(robot, campaign).kept;
}

// The base, the tool, one anchor of several and every identified parameter of a link; only what
// moves these readings.
std::vector<Hypothesis> moves_of(const Robot& previous, const Problem& problem) {
  const ObservationModel& model = problem.model;
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
  Eigen::MatrixXd block(model.row_size(), model.unknowns() + 1);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(model.unknowns());
  for (int row = 0; row < model.rows(); ++row) {
    at.block(row, block);
    squares += block.leftCols(model.unknowns()).colwise().squaredNorm().transpose();
  }
  const std::vector<int> visible = visible_of_base(previous, model.campaign());
  const int first_anchor = first_anchor_parameter(previous.chain);
  Hypothesis base{"base", {}}, tool{"tool", {}};
  std::vector<Hypothesis> links, anchors(previous.chain.anchors.size());
  for (int k = 0; k < model.unknowns(); ++k) {
    const int parameter = model.geometric()[k];
    if (squares[k] <= 1e-12 * squares.maxCoeff()) continue;
    if (parameter < kLinkParameters) {
      if (std::ranges::count(visible, parameter) > 0) base.free.push_back(k);
    } else if (parameter < kToolParameters)
      links.push_back({parameter_name(previous.chain, parameter), {k}});
    else if (parameter < kInstrumentScale)
      tool.free.push_back(k);
    else if (is_place_of_anchor(previous.chain, parameter))
      anchors[(parameter - first_anchor) / 4].free.push_back(k);
  }
  std::vector<Hypothesis> moves{base, tool};
  for (size_t a = 0; a < anchors.size() && anchors.size() > 1; ++a) {  // a single one is the base
    anchors[a].what = "anchor " + previous.chain.anchors[a].name;
    moves.push_back(anchors[a]);
  }
  std::erase_if(moves, [](const Hypothesis& move) { return move.free.empty(); });
  moves.insert(moves.end(), links.begin(), links.end());
  return moves;
}

// Most likely errors of the previous parameters and sizes of what is free: Gauss-Newton on readings
// and priors together, the rows' weights taken anew at every step.
Fit fit(const Problem& problem, const Hypothesis& hypothesis, const ReadingLaw& law) {
  const ObservationModel& model = problem.model;
  const int size = model.row_size(), equations = model.rows() * size;
  const auto is_free = [&](int k) { return std::ranges::count(hypothesis.free, k) > 0; };
  std::vector<int> active;
  for (int k = 0; k < model.unknowns(); ++k)
    if (problem.deviations[k] > 0 || is_free(k)) active.push_back(k);
  const int count = static_cast<int>(active.size());

  Fit result{Eigen::VectorXd::Zero(model.unknowns()), {}, {}, 0};
  result.weights.assign(model.rows(), 1.0);
  Eigen::MatrixXd block(size, model.unknowns() + 1);
  for (int step = 0;; ++step) {
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(equations + count, count);
    Eigen::VectorXd residual = Eigen::VectorXd::Zero(equations + count);
    const ObservationModel::At at = model.at(result.x);
    double loss = 0;
    for (int row = 0; row < model.rows(); ++row) {
      at.block(row, block);
      const double squared_norm = block.rightCols<1>().squaredNorm();
      // The first step is one of least squares: where a parameter has moved, the residuals before
      // it say nothing about blunders.
      if (step > 0) result.weights[row] = law.weight(squared_norm, size);
      loss += problem.shares[row] * law.loss(squared_norm, size);
      const double root = std::sqrt(problem.shares[row] * result.weights[row]);
      for (int i = 0; i < count; ++i)
        jacobian.col(i).segment(row * size, size) = root * block.col(active[i]);
      residual.segment(row * size, size) = root * block.rightCols<1>();
    }
    for (int i = 0; i < count; ++i)
      if (!is_free(active[i])) {
        const double deviation = problem.deviations[active[i]];
        jacobian(equations + i, i) = 1 / deviation;
        residual[equations + i] = -result.x[active[i]] / deviation;
        loss += residual[equations + i] * residual[equations + i];
      }
    const bool settled = std::abs(loss - result.loss) <= 1e-7 * (1 + loss);
    result.loss = loss;
    // Columns of unit norm: m and rad differ by orders of magnitude.
    const Eigen::VectorXd unit = jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse();
    const Eigen::MatrixXd scaled = jacobian * unit.asDiagonal();
    if ((step > 1 && settled) || step == kMaxSteps) {
      result.covariance =
          unit.asDiagonal() *
          Eigen::MatrixXd(
              (scaled.transpose() * scaled).completeOrthogonalDecomposition().pseudoInverse()) *
          unit.asDiagonal();
      Eigen::MatrixXd all = Eigen::MatrixXd::Zero(model.unknowns(), model.unknowns());
      all(active, active) = result.covariance;
      result.covariance = all;
      return result;
    }
    const Eigen::VectorXd change =
        unit.asDiagonal() *
        Eigen::VectorXd(scaled.completeOrthogonalDecomposition().solve(residual));
    for (int i = 0; i < count; ++i) result.x[active[i]] += change[i];
  }
}

std::vector<int> find_blunders(const Problem& problem, const std::vector<Hypothesis>& moves) {
  const ReadingLaw law{4.0};
  const double price = std::log(problem.equations);
  Fit best = fit(problem, {}, law);
  for (const Hypothesis& move : moves) {
    Fit other = fit(problem, move, law);
    other.loss += price * static_cast<double>(move.free.size());
    if (other.loss < best.loss) best = std::move(other);
  }
  std::vector<int> blunders;
  for (int row = 0; row < problem.model.rows(); ++row)
    if (best.weights[row] < kBlunderWeight) blunders.push_back(row);
  if (static_cast<double>(blunders.size()) > kMostBlunders * problem.model.rows()) return {};
  return blunders;
}

Campaign without(const Campaign& campaign, const std::vector<int>& rows) {
  std::vector<int> others;
  for (int row = 0; row < campaign.rows(); ++row)
    if (!std::ranges::binary_search(rows, row)) others.push_back(row);
  return campaign.select(others);
}

Move test_move(const Problem& problem, const Hypothesis& hypothesis, double loss_of_nothing,
               size_t moves) {
  const Fit fitted = fit(problem, hypothesis, {});
  const double freedom = static_cast<double>(hypothesis.free.size());
  const double fall = std::max(0.0, loss_of_nothing - fitted.loss);
  Move move{.what = hypothesis.what, .changes = {}};
  for (int k : hypothesis.free)
    // From the previous value, which was not exact itself.
    move.changes.push_back({problem.model.geometric()[k], fitted.x[k],
                            std::hypot(std::sqrt(fitted.covariance(k, k)), problem.deviations[k])});
  move.delta_bic = fall - freedom * std::log(problem.equations);
  move.p_value = std::min(1.0, static_cast<double>(moves) * probability_above(fall, freedom));
  move.p_value_left = probability_above(fitted.loss, std::max(1.0, problem.equations - freedom));
  return move;
}

double mean_error(const Robot& robot, const Campaign& campaign) {
  return summarize(evaluate(robot, campaign).position).mean;
}

Robot moved_robot(const Problem& problem, const Move& move) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(problem.model.unknowns());
  for (const ParameterChange& change : move.changes)
    x[std::ranges::find(problem.model.geometric(), change.parameter) -
      problem.model.geometric().begin()] = change.value;
  return problem.model.robot_at(x);
}

}  // namespace

ChangeResult detect_change(const Robot& calibrated, const ReadingScale& spread,
                           const Campaign& campaign) {
  if (rows_by_session(campaign).size() > 1)
    throw std::invalid_argument(
        "the measurements are of several sessions; what has moved is asked of one at a time: give "
        "the rows of one");
  const Robot previous = robot_at_row(calibrated, campaign, 0);
  if (previous.std.empty())
    throw std::invalid_argument(
        "the previous robot states no 'std' of its parameters; give one that calibrate or "
        "close-loop --robot-out has written");
  ChangeResult result;
  result.scale = spread;
  const NoiseFloor noise = noise_floor(previous, campaign, evaluate(previous, campaign));
  if (noise.source == NoiseFloor::Source::replicates) {
    result.scale.position = std::max(spread.position, noise.position);
    result.scale.orientation = std::max(spread.orientation, noise.orientation);
  }
  const auto need = [](double deviation, const char* what, const char* key) {
    if (!(deviation > 0))
      throw std::invalid_argument("the spread of " + std::string(what) +
                                  " that the previous calibration left is not known; add '" + key +
                                  "' to the 'noise' of the previous robot");
  };
  need(result.scale.position, "positions", "position_mm");
  if (campaign.has_orientation())
    need(result.scale.orientation, "orientations", "orientation_mrad");

  const Problem all = make_problem(previous, campaign, result.scale);
  result.blunders = find_blunders(all, moves_of(previous, all));
  const Campaign sound = without(campaign, result.blunders);
  const Problem problem = make_problem(previous, sound, result.scale);
  const std::vector<Hypothesis> hypotheses = moves_of(previous, problem);

  const double loss = fit(problem, {}, {}).loss;
  result.p_value = probability_above(loss, problem.equations);
  result.holds = result.p_value >= kChangeSignificance;
  for (const Hypothesis& hypothesis : hypotheses)
    result.moves.push_back(test_move(problem, hypothesis, loss, hypotheses.size()));
  std::ranges::stable_sort(result.moves, std::ranges::greater{}, &Move::delta_bic);
  const Move& best = result.moves.front();
  for (const Move& move : result.moves)
    result.indistinguishable +=
        &move != &best && move.delta_bic > best.delta_bic - kIndistinguishable;
  result.before = mean_error(previous, sound);
  result.after = mean_error(moved_robot(problem, best), sound);
  return result;
}

}  // namespace armtrue
