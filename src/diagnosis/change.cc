#include "armtrue/diagnosis/change.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "calibration/fold.h"
#include "calibration/pose_influence.h"
#include "calibration/registration.h"
#include "calibration/session_models.h"
#include "campaign/sessions.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr double kIndistinguishable = 6;     // BIC
constexpr double kBlunderWeight = 0.25;      // some six standard deviations under Student's t
constexpr double kMaxBlunders = 0.3;         // of the rows
constexpr double kExchangeTolerance = 1e-6;  // BIC
constexpr size_t kMaxMoves = 4;              // more at once want a new calibration
constexpr int kMaxSteps = 30;

constexpr double kNothingKnown = std::numeric_limits<double>::infinity();

// An error of the previous calibration, or a move since.
struct Unknown {
  int parameter;
  int first, last;  // sessions in which it acts
  double deviation = kNothingKnown;

  bool acts_in(int session) const { return first <= session && session <= last; }
};

struct ChangeHypothesis {
  std::string what;
  std::vector<Unknown> moves;
};

struct Fit {
  Eigen::VectorXd x;            // errors, then moves
  Eigen::MatrixXd covariance;   // of x, if readings erred independently
  Eigen::MatrixXd by_pose;      // the same, clustered by pose
  std::vector<double> weights;  // of the rows
  Eigen::VectorXd chi_squares;  // of each pose
  double loss = 0;              // chi-square, or twice the negative log-likelihood
};

bool is_place_of_anchor(const KinematicChain& chain, int parameter) {
  const int k = parameter - first_anchor_parameter(chain);
  return k >= 0 && k % 4 < 3;
}

bool is_of_base(int parameter) { return parameter < kLinkParameters; }

// The parameters that the previous calibration found, and what may have been set up anew.
std::vector<int> parameters_of(const Robot& previous, const Campaign& campaign) {
  std::vector<int> parameters;
  const std::vector<int> own = own_parameters(previous);
  for (int k = 0; k < parameter_count(previous.chain); ++k)
    if (previous.std.contains(parameter_name(previous.chain, k)) ||
        std::ranges::count(own, k) > 0 || (k >= kToolParameters && k < kInstrumentScale) ||
        (campaign.has_distances() && is_place_of_anchor(previous.chain, k)))
      parameters.push_back(k);
  return parameters;
}

Robot start_of(const Robot& previous, const Campaign& campaign) {
  if (rows_by_session(campaign).size() == 1) return robot_at_row(previous, campaign, 0);
  IdentifiableSet bases;
  for (int k = 0; k < kLinkParameters; ++k) bases.kept.push_back(k);
  return starting_robot(previous, campaign, bases);
}

// Those of the parameters that these readings show.
std::vector<int> shown(Robot robot, const std::vector<int>& parameters, const Campaign& campaign) {
  robot.identify.clear();
  robot.identify_per_session.clear();
  for (int k : parameters) robot.identify.push_back(parameter_name(robot.chain, k));
  return choose_identifiable(robot, campaign).kept;
}

// The readings of a campaign against the previous robot and what is known of its parameters.
class Problem {
 public:
  Problem(const Robot& previous, const Campaign& campaign, const ReadingSigma& scale)
      : previous_(previous),
        start_(start_of(previous, campaign)),
        own_(own_parameters(start_)),
        models_(campaign, start_, parameters_of(start_, campaign), scale, 0),
        rows_by_pose_(rows_by_pose(campaign.pose)) {
    for (int s = 0; s < sessions(); ++s) {
      std::vector<int>& column = columns_.emplace_back(parameter_count(start_.chain), -1);
      for (int k = 0; k < models_.model(s).unknowns(); ++k)
        column[models_.model(s).geometric()[k]] = k;
    }
    count_replicates();
    enter_errors();
    enter_hypotheses();
  }

  int hypotheses() const { return static_cast<int>(hypotheses_.size()); }
  double equations() const { return equations_; }  // replicates counted once

  // Most likely errors of the previous parameters and sizes of the moves, those of the hypotheses
  // `moved`: Gauss-Newton on readings and what is known together, the rows' weights taken anew at
  // every step.
  Fit fit(const std::vector<int>& moved, const ReadingLaw& law) const;

  // With the bases of several sessions and what has moved, but without the previous errors.
  double mean_error(const std::vector<int>& moved, const Fit& fitted) const;

  Move described(const std::vector<int>& moved, size_t which, const Fit& fitted) const;
  std::vector<Move> stations(const Fit& fitted) const;
  double p_value(const std::vector<int>& moved, const Fit& fitted, double overdispersion) const;
  // By how much the chi-squares of the poses scatter more than those of independent readings would;
  // at least 1.
  double overdispersion(const Fit& fitted) const;
  // By how much readings that err alike within a pose widen the law of one of the moves; at
  // least 1.
  double widening(const std::vector<int>& moved, size_t which, const Fit& fitted) const;
  int poses() const { return rows_by_pose_.poses(); }
  int moves_in(const std::vector<int>& moved) const {
    return static_cast<int>(unknowns_of(moved).size() - errors_.size());
  }

 private:
  ParameterChange change_of(int parameter, double value, double deviation) const {
    const double half_width = student_t_975(poses() - 1) * deviation;
    return {parameter, value, deviation, {value - half_width, value + half_width}};
  }
  // Where the unknowns of one of the moves begin.
  Eigen::Index first_of(const std::vector<int>& moved, size_t which) const;
  int sessions() const { return models_.sessions(); }
  bool is_several() const { return sessions() > 1; }
  // Of several sessions, each has it for itself.
  bool is_own(int parameter) const {
    return is_several() && std::ranges::count(own_, parameter) > 0;
  }
  double deviation_of(int parameter) const {
    const auto found = start_.std.find(parameter_name(start_.chain, parameter));
    return found == start_.std.end() ? 0 : found->second;
  }
  double deviation_of(int parameter, int session) const;
  void count_replicates();
  void enter_errors();
  void enter_hypotheses();
  void enter_hypothesis(const std::string& what, const std::vector<int>& parameters, int first,
                        int last);
  std::vector<Unknown> unknowns_of(const std::vector<int>& moved) const;
  Eigen::VectorXd unknowns_of(int session, const std::vector<Unknown>& unknowns,
                              const Eigen::VectorXd& x) const;

  const Robot& previous_;
  const Robot start_;
  const std::vector<int> own_;  // of a session
  const SessionModels models_;
  std::vector<std::vector<int>> columns_;  // of each session's model, by parameter; -1: none
  std::vector<double> shares_;             // of each row in its pose and channel
  std::vector<double> session_shares_;     // of each session in its poses; 1: they are its alone
  const RowsByPose rows_by_pose_;
  std::vector<Unknown> errors_;
  std::vector<ChangeHypothesis> hypotheses_;
  double equations_ = 0, degrees_of_freedom_ = 0;
};

void Problem::count_replicates() {
  const Campaign& campaign = models_.campaign();
  const auto key = [&](int row) { return std::pair{campaign.pose[row], campaign.channel(row)}; };
  std::map<std::pair<int, int>, int> replicates;
  for (int row = 0; row < campaign.rows(); ++row) ++replicates[key(row)];
  for (int row = 0; row < campaign.rows(); ++row) shares_.push_back(1.0 / replicates[key(row)]);
  equations_ = static_cast<double>(replicates.size()) * models_.row_size();
  degrees_of_freedom_ = equations_;
  for (int s = 0; s < sessions(); ++s) {
    std::set<std::pair<int, int>> own;
    double share = 0;
    for (int row : models_.rows_of(s)) {
      own.insert(key(row));
      share += shares_[row];
    }
    session_shares_.push_back(share / static_cast<double>(own.size()));
  }
}

// 0: as exact as the model; infinite in a session that the previous robot does not know.
double Problem::deviation_of(int parameter, int session) const {
  const auto known = previous_.sessions.find(models_.name(session));
  if (is_of_base(parameter) || known == previous_.sessions.end()) return kNothingKnown;
  const auto own = known->second.std.find(parameter_name(start_.chain, parameter));
  return own == known->second.std.end() ? deviation_of(parameter) : own->second;
}

void Problem::enter_errors() {
  for (int k : models_.geometric()) {
    const double deviation = deviation_of(k);
    if (!is_own(k) && deviation > 0) errors_.push_back({k, 0, sessions() - 1, deviation});
  }
  for (int s = 0; is_several() && s < sessions(); ++s) {
    std::vector<int> free;
    for (int k : models_.own(s)) {
      const double deviation = deviation_of(k, s);
      if (deviation == kNothingKnown)
        free.push_back(k);
      else if (deviation > 0)
        errors_.push_back({k, s, s, deviation});
    }
    const Campaign readings = models_.campaign().select(models_.rows_of(s));
    free = shown(robot_at_row(start_, readings, 0), free, readings);
    const auto count = static_cast<double>(free.size());
    if (count >= readings.rows() * models_.row_size())
      throw std::invalid_argument(
          readings.source + ": the readings of session '" + models_.name(s) +
          "' only place its base; measure more poses in it, or leave it out");
    degrees_of_freedom_ -= count * session_shares_[s];
    for (int k : free) errors_.push_back({k, s, s});
  }
}

void Problem::enter_hypothesis(const std::string& what, const std::vector<int>& parameters,
                               int first, int last) {
  ChangeHypothesis hypothesis{what, {}};
  for (int k : parameters) hypothesis.moves.push_back({k, first, last, kNothingKnown});
  if (!parameters.empty()) hypotheses_.push_back(hypothesis);
}

// The base, the tool, one anchor of several and every identified parameter of a link; only what
// moves these readings.
void Problem::enter_hypotheses() {
  const int first_anchor = first_anchor_parameter(start_.chain);
  const auto count = static_cast<int>(start_.chain.anchors.size());
  for (int s = 0; s < sessions(); ++s) {
    const ObservationModel& model = models_.model(s);
    const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
    Eigen::MatrixXd block(model.row_size(), model.unknowns() + 1);
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(model.unknowns());
    for (int row = 0; row < model.rows(); ++row) {
      at.block(row, block);
      squares += block.leftCols(model.unknowns()).colwise().squaredNorm().transpose();
    }
    std::vector<int> tool, links;
    std::vector<std::vector<int>> anchors(count);
    for (int k : models_.geometric()) {
      if (is_of_base(k) || squares[columns_[s][k]] <= 1e-12 * squares.maxCoeff()) continue;
      if (k < kToolParameters)
        links.push_back(k);
      else if (k < kInstrumentScale)
        tool.push_back(k);
      else if (is_place_of_anchor(start_.chain, k))
        anchors[(k - first_anchor) / 4].push_back(k);
    }
    const int last = sessions() - 1;
    if (!is_several()) {
      std::vector<int> base(kLinkParameters);
      std::iota(base.begin(), base.end(), kBaseParameters);
      enter_hypothesis("base", shown(start_, base, model.campaign()), s, last);
    }
    enter_hypothesis("tool", tool, s, last);
    for (int a = 0; a < count && (count > 1 || models_.campaign().has_coordinates);
         ++a)  // a single one is the base
      enter_hypothesis("anchor " + start_.chain.anchors[a].name, anchors[a], s, last);
    for (int k : links)
      if (!is_own(k))
        enter_hypothesis(parameter_name(start_.chain, k), {k}, s, last);
      else if (deviation_of(k, s) != kNothingKnown)
        enter_hypothesis(parameter_name(start_.chain, k), {k}, s, s);
  }
}

std::vector<Unknown> Problem::unknowns_of(const std::vector<int>& moved) const {
  std::vector<Unknown> unknowns = errors_;
  for (int k : moved)
    unknowns.insert(unknowns.end(), hypotheses_[k].moves.begin(), hypotheses_[k].moves.end());
  return unknowns;
}

Eigen::VectorXd Problem::unknowns_of(int session, const std::vector<Unknown>& unknowns,
                                     const Eigen::VectorXd& x) const {
  Eigen::VectorXd own = Eigen::VectorXd::Zero(models_.model(session).unknowns());
  for (size_t i = 0; i < unknowns.size(); ++i)
    if (unknowns[i].acts_in(session)) own[columns_[session][unknowns[i].parameter]] += x[i];
  return own;
}

Fit Problem::fit(const std::vector<int>& moved, const ReadingLaw& law) const {
  const std::vector<Unknown> unknowns = unknowns_of(moved);
  const int size = models_.row_size(), equations = models_.rows() * size;
  const auto count = static_cast<int>(unknowns.size());
  Fit result{Eigen::VectorXd::Zero(count), {}, {}, {}, Eigen::VectorXd::Zero(poses()), 0};
  result.weights.assign(models_.rows(), 1.0);
  for (int step = 0;; ++step) {
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(equations + count, count);
    Eigen::VectorXd residual = Eigen::VectorXd::Zero(equations + count);
    double loss = 0;
    for (int s = 0; s < sessions(); ++s) {
      const ObservationModel& model = models_.model(s);
      const ObservationModel::At at = model.at(unknowns_of(s, unknowns, result.x));
      Eigen::MatrixXd block(size, model.unknowns() + 1);
      for (int own = 0; own < model.rows(); ++own) {
        const int row = models_.rows_of(s)[own];
        at.block(own, block);
        const double squared_norm = block.rightCols<1>().squaredNorm();
        // The first step is one of least squares: where a parameter has moved, the residuals before
        // it say nothing about blunders.
        if (step > 0) result.weights[row] = law.weight(squared_norm, size);
        loss += shares_[row] * law.loss(squared_norm, size);
        const double root = std::sqrt(shares_[row] * result.weights[row]);
        for (int i = 0; i < count; ++i)
          if (unknowns[i].acts_in(s))
            jacobian.col(i).segment(row * size, size) =
                root * block.col(columns_[s][unknowns[i].parameter]);
        residual.segment(row * size, size) = root * block.rightCols<1>();
      }
    }
    for (int i = 0; i < count; ++i) {
      jacobian(equations + i, i) = 1 / unknowns[i].deviation;
      residual[equations + i] = -result.x[i] / unknowns[i].deviation;
      loss += residual[equations + i] * residual[equations + i];
    }
    const bool settled = std::abs(loss - result.loss) <= 1e-7 * (1 + loss);
    result.loss = loss;
    // Columns of unit norm: m and rad differ by orders of magnitude.
    const Eigen::VectorXd unit = jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse();
    const Eigen::MatrixXd scaled = jacobian * unit.asDiagonal();
    if ((step > 1 && settled) || step == kMaxSteps) {
      const Eigen::MatrixXd root = inverse_root(jacobian.transpose() * jacobian);
      result.covariance = root * root.transpose();
      const Eigen::MatrixXd shown = jacobian * root;
      InfluenceSums sums;
      for (int pose = 0; pose < poses(); ++pose) {
        const int first = rows_by_pose_.first[pose], next = rows_by_pose_.first[pose + 1];
        std::vector<int> own;
        for (int k = first; k < next; ++k)
          for (int i = 0; i < size; ++i) own.push_back(rows_by_pose_.row[k] * size + i);
        const Eigen::VectorXd left = residual(own);
        result.chi_squares[pose] = left.squaredNorm();
        sums.add(influence_of_pose(shown(own, Eigen::all), left));
      }
      const auto known = shown.bottomRows(count);
      result.by_pose =
          root * (sums.covariance(1, 1) + known.transpose() * known) * root.transpose();
      return result;
    }
    result.x += unit.asDiagonal() *
                Eigen::VectorXd(scaled.completeOrthogonalDecomposition().solve(residual));
  }
}

double Problem::mean_error(const std::vector<int>& moved, const Fit& fitted) const {
  std::vector<Unknown> unknowns = unknowns_of(moved);
  Eigen::VectorXd x = fitted.x;
  for (size_t i = 0; i < unknowns.size(); ++i)
    if (unknowns[i].deviation != kNothingKnown) x[i] = 0;
  double sum = 0;
  for (int s = 0; s < sessions(); ++s) {
    const ObservationModel::At at = models_.model(s).at(unknowns_of(s, unknowns, x));
    for (int row = 0; row < models_.model(s).rows(); ++row)
      sum += at.residual(row).head<3>().norm();
  }
  return sum / models_.rows();
}

Move Problem::described(const std::vector<int>& moved, size_t which, const Fit& fitted) const {
  const ChangeHypothesis& hypothesis = hypotheses_[moved[which]];
  Move move{.what = hypothesis.what, .sessions = {}, .changes = {}, .indistinguishable = {}};
  Eigen::Index k = first_of(moved, which);
  for (const Unknown& unknown : hypothesis.moves) {
    const double variance = std::max(fitted.covariance(k, k), fitted.by_pose(k, k));
    move.changes.push_back(change_of(unknown.parameter, fitted.x[k++], std::sqrt(variance)));
  }
  const Unknown& any = hypothesis.moves.front();
  for (int s = any.first; any.last - any.first < sessions() - 1 && s <= any.last; ++s)
    move.sessions.push_back(models_.name(s));
  return move;
}

// The law of the difference from the known base: the deviations of both.
std::vector<Move> Problem::stations(const Fit& fitted) const {
  std::vector<Move> moves;
  for (int s = 0; is_several() && s < sessions(); ++s) {
    const auto known = previous_.sessions.find(models_.name(s));
    if (known == previous_.sessions.end()) continue;
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
    std::vector<int> places, parameters;
    for (size_t i = 0; i < errors_.size(); ++i)
      if (is_of_base(errors_[i].parameter) && errors_[i].acts_in(s)) {
        places.push_back(static_cast<int>(i));
        parameters.push_back(errors_[i].parameter);
      }
    covariance(parameters, parameters) = fitted.covariance(places, places);
    const Pose own_from_common = inverse(models_.common_from_own(s));
    const Pose base =
        own_from_common * models_.model(s).robot_at(unknowns_of(s, errors_, fitted.x)).chain.base;
    Eigen::Matrix<double, 6, 1> change;
    change << base.translation - known->second.base.translation,
        rotation_log(base.rotation * known->second.base.rotation.transpose());
    Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = own_from_common.rotation;
    covariance = (turn * covariance * turn.transpose()).eval();
    Move move{
        .what = "base", .sessions = {models_.name(s)}, .changes = {}, .indistinguishable = {}};
    for (int k : parameters) {
      const auto own = known->second.std.find(parameter_name(start_.chain, k));
      covariance(k, k) +=
          std::pow(own == known->second.std.end() ? deviation_of(k) : own->second, 2);
      move.changes.push_back(change_of(k, change[k], std::sqrt(covariance(k, k))));
    }
    const Eigen::VectorXd seen = change(parameters);
    const double chi_square =
        seen.dot(Eigen::MatrixXd(covariance(parameters, parameters)).ldlt().solve(seen));
    move.p_value = std::min(
        1.0, sessions() * chi_squared_above(chi_square, static_cast<double>(parameters.size())));
    if (move.p_value < kChangeSignificance) moves.push_back(move);
  }
  return moves;
}

// With the mean of the chi-square law and the scatter of the poses (Satterthwaite 1946).
double Problem::p_value(const std::vector<int>& moved, const Fit& fitted,
                        double overdispersion) const {
  const double freedom = std::max(1.0, degrees_of_freedom_ - moves_in(moved));
  return chi_squared_above(fitted.loss / overdispersion, freedom / overdispersion);
}

double Problem::overdispersion(const Fit& fitted) const {
  const double n = poses();
  if (n < 2) return 1;
  Eigen::VectorXd equations = Eigen::VectorXd::Zero(poses());
  for (int pose = 0; pose < poses(); ++pose)
    for (int k = rows_by_pose_.first[pose]; k < rows_by_pose_.first[pose + 1]; ++k)
      equations[pose] += shares_[rows_by_pose_.row[k]] * models_.row_size();
  const double mean = fitted.chi_squares.sum() / equations.sum();
  const double variance = n / (n - 1) * (fitted.chi_squares - mean * equations).squaredNorm();
  return std::max(1.0, variance / (2 * equations.sum()));
}

double Problem::widening(const std::vector<int>& moved, size_t which, const Fit& fitted) const {
  const Eigen::Index first = first_of(moved, which);
  const auto count = static_cast<Eigen::Index>(hypotheses_[moved[which]].moves.size());
  const Eigen::VectorXd ratio =
      fitted.by_pose.diagonal()
          .segment(first, count)
          .cwiseQuotient(fitted.covariance.diagonal().segment(first, count));
  return std::max(1.0, ratio.mean());
}

Eigen::Index Problem::first_of(const std::vector<int>& moved, size_t which) const {
  size_t first = errors_.size();
  for (size_t i = 0; i < which; ++i) first += hypotheses_[moved[i]].moves.size();
  return static_cast<Eigen::Index>(first);
}

std::vector<int> find_blunders(const Problem& problem) {
  const ReadingLaw law{4.0};
  const double price = std::log(problem.equations());
  Fit best = problem.fit({}, law);
  const auto is_off = [](double weight) { return weight < kBlunderWeight; };
  if (std::ranges::none_of(best.weights, is_off)) return {};
  for (int k = 0; k < problem.hypotheses(); ++k) {
    Fit other = problem.fit({k}, law);
    other.loss += price * problem.moves_in({k});
    if (other.loss < best.loss) best = std::move(other);
  }
  std::vector<int> blunders;
  for (size_t row = 0; row < best.weights.size(); ++row)
    if (is_off(best.weights[row])) blunders.push_back(static_cast<int>(row));
  if (static_cast<double>(blunders.size()) >
      kMaxBlunders * static_cast<double>(best.weights.size()))
    return {};
  return blunders;
}

Campaign without(const Campaign& campaign, const std::vector<int>& rows) {
  std::vector<int> others;
  for (int row = 0; row < campaign.rows(); ++row)
    if (!std::ranges::binary_search(rows, row)) others.push_back(row);
  return campaign.select(others);
}

// Hypotheses that are true together.
struct Explanation {
  std::vector<int> moved;
  Fit fit;
  double bic;
};

Explanation explain(const Problem& problem, const std::vector<int>& moved) {
  Explanation explanation{moved, problem.fit(moved, {}), 0};
  explanation.bic = explanation.fit.loss + problem.moves_in(moved) * std::log(problem.equations());
  return explanation;
}

// With each of the other hypotheses besides; by BIC, best first.
std::vector<Explanation> each_beside(const Problem& problem, const std::vector<int>& moved) {
  std::vector<Explanation> explanations;
  for (int k = 0; k < problem.hypotheses(); ++k) {
    if (std::ranges::count(moved, k) > 0) continue;
    std::vector<int> more = moved;
    more.push_back(k);
    explanations.push_back(explain(problem, more));
  }
  std::ranges::stable_sort(explanations, {}, &Explanation::bic);
  return explanations;
}

std::vector<int> all_but(std::vector<int> moved, size_t which) {
  moved.erase(moved.begin() + static_cast<std::ptrdiff_t>(which));
  return moved;
}

// Probability of so large a fall by the move `which` of `more`, were there none.
double p_value(const Problem& problem, const Explanation& fewer, const Explanation& more,
               size_t which) {
  const double fall = std::max(0.0, fewer.fit.loss - more.fit.loss);
  const double freedom = std::max(1, problem.moves_in(more.moved) - problem.moves_in(fewer.moved));
  const double widening = problem.widening(more.moved, which, more.fit);
  double p = chi_squared_above(fall, freedom);
  if (widening > 1)
    p = std::max(
        p, fisher_f_above(fall / (freedom * widening), freedom, std::max(1, problem.poses() - 1)));
  return std::min(1.0, problem.hypotheses() * p);
}

// Puts others in the place of those that were taken while that is better.
void exchange(const Problem& problem, Explanation& current) {
  for (size_t k = 0, kept = 0; kept < current.moved.size() && current.moved.size() > 1;
       k = (k + 1) % current.moved.size()) {
    Explanation other = each_beside(problem, all_but(current.moved, k)).front();
    ++kept;
    if (other.bic >= current.bic - kExchangeTolerance) continue;
    current = std::move(other);
    kept = 0;
  }
}

void drop_superfluous(const Problem& problem, Explanation& current) {
  for (size_t k = 0; k < current.moved.size();) {
    Explanation fewer = explain(problem, all_but(current.moved, k));
    if (p_value(problem, fewer, current, k) < kChangeSignificance)
      ++k;
    else
      current = std::move(fewer);
  }
}

Explanation find_moves(const Problem& problem) {
  Explanation current = explain(problem, {});
  const double independent = 1;  // the scatter of the poses is known once what moved is taken out
  while (problem.p_value(current.moved, current.fit, independent) < kChangeSignificance &&
         current.moved.size() < kMaxMoves) {
    Explanation more = each_beside(problem, current.moved).front();
    if (more.bic >= current.bic) break;
    current = std::move(more);
    exchange(problem, current);
  }
  return current;
}

Move tested(const Problem& problem, const Explanation& explanation, size_t which,
            const Explanation& without, double overdispersion) {
  Move move = problem.described(explanation.moved, which, explanation.fit);
  move.delta_bic = without.bic - explanation.bic;
  move.p_value = p_value(problem, without, explanation, which);
  move.p_value_left = problem.p_value(explanation.moved, explanation.fit, overdispersion);
  return move;
}

std::vector<Move> with_rivals(const Problem& problem, const Explanation& found,
                              double overdispersion) {
  std::vector<Move> moves;
  for (size_t k = 0; k < found.moved.size(); ++k) {
    const Explanation without = explain(problem, all_but(found.moved, k));
    Move& move = moves.emplace_back(tested(problem, found, k, without, overdispersion));
    for (const Explanation& rival : each_beside(problem, without.moved))
      if (rival.bic < found.bic + kIndistinguishable &&
          std::ranges::count(found.moved, rival.moved.back()) == 0)
        move.indistinguishable.push_back(
            tested(problem, rival, without.moved.size(), without, overdispersion));
  }
  return moves;
}

}  // namespace

ChangeResult detect_change(const Robot& calibrated, const ReadingSigma& spread,
                           const Campaign& campaign) {
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

  result.blunders = find_blunders(Problem(calibrated, campaign, result.scale));
  const Campaign sound = without(campaign, result.blunders);
  const Problem problem(calibrated, sound, result.scale);
  const Explanation nothing = explain(problem, {});
  Explanation found = find_moves(problem);
  // How poses scatter where nothing has moved is seen once what may have moved is taken out.
  const double overdispersion = problem.overdispersion(found.fit);
  result.p_value = problem.p_value({}, nothing.fit, overdispersion);
  result.holds = result.p_value >= kChangeSignificance;
  if (result.holds)
    found = nothing;
  else
    drop_superfluous(problem, found);
  result.moved = with_rivals(problem, found, overdispersion);
  result.p_value_left = problem.p_value(found.moved, found.fit, overdispersion);
  result.stations = problem.stations(found.fit);
  result.before = problem.mean_error({}, nothing.fit);
  result.after = problem.mean_error(found.moved, found.fit);
  return result;
}

}  // namespace armtrue
