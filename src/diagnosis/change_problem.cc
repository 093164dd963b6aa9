#include "diagnosis/change_problem.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/observation/registration.h"
#include "linear_algebra/decompositions.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr double kNothingKnown = std::numeric_limits<double>::infinity();

bool is_place_of_anchor(const KinematicChain& chain, int parameter) {
  const int k = parameter - first_anchor_parameter(chain);
  return k >= 0 && parameter < first_contact_parameter(chain) && k % 4 < 3;
}

bool is_of_base(int parameter) { return parameter < kFirstLinkParameter; }

// The parameters of a contact, as indices; none unless it is touched, or reads, or is seen.
std::vector<int> of_touched_contact(const KinematicChain& chain, const Campaign& campaign,
                                    int contact) {
  const std::vector<ContactPoint> matched = match_contacts(campaign, chain);
  const bool is_touched = std::ranges::any_of(campaign.touch, [&](const Touch& touch) {
    return touch.contact >= 0 &&
           (matched[touch.contact].contact == contact || matched[touch.contact].beam == contact ||
            matched[touch.contact].board == contact);
  });
  if (!is_touched) return {};
  std::vector<int> parameters = parameters_of_contact(chain.contacts[contact]);
  for (int& k : parameters) k += first_contact_parameter(chain) + kParametersOfContact * contact;
  return parameters;
}

// The parameters that the previous calibration found, and those of base, tool, anchors and
// contacts, which may have been set up anew.
std::vector<int> parameters_of(const Robot& previous, const Campaign& campaign) {
  std::vector<int> parameters;
  const std::vector<int> own = own_parameters(previous);
  const ParameterLayout layout = layout_of(previous.chain);
  for (int k = 0; k < first_contact_parameter(previous.chain); ++k)
    if (previous.std.contains(parameter_name(previous.chain, k)) ||
        std::ranges::count(own, k) > 0 || layout.is_of_tool(k) ||
        (campaign.reads_one_number() && is_place_of_anchor(previous.chain, k)))
      parameters.push_back(k);
  for (int c = 0; c < std::ssize(previous.chain.contacts); ++c) {
    const std::vector<int> touched = of_touched_contact(previous.chain, campaign, c);
    parameters.insert(parameters.end(), touched.begin(), touched.end());
  }
  return parameters;
}

// Whether each session has a base of its own: if there are several, or one that the previous robot
// does not know. Readings without sessions are from the known place.
bool has_own_bases(const Robot& previous, const Campaign& campaign) {
  return rows_by_session(campaign).size() > 1 ||
         (!campaign.session.empty() && !previous.sessions.contains(session_name(campaign, 0)));
}

Robot start_of(const Robot& previous, const Campaign& campaign) {
  if (!has_own_bases(previous, campaign)) return robot_at_row(previous, campaign, 0);
  std::vector<int> bases(kFirstLinkParameter);
  std::iota(bases.begin(), bases.end(), 0);
  return starting_robot(previous, campaign, bases);
}

// Those of the parameters that these readings can show.
std::vector<int> shown(Robot robot, const std::vector<int>& parameters, const Campaign& campaign) {
  robot.identify.clear();
  robot.identify_per_session.clear();
  for (int k : parameters) robot.identify.push_back(parameter_name(robot.chain, k));
  return choose_identifiable(robot, campaign).kept;
}

// Degrees of freedom of the spread that the previous calibration left. Readings of a pose share the
// error of the model there, so each pose counts once. `numbers_of_touches`: that a pose of touches
// reads; 0 if there are none.
double freedom_of_spread(const Robot& previous, double numbers_of_touches) {
  constexpr double kSpreadIsExact = 1e9;
  if (!previous.uncertainty) return kSpreadIsExact;
  const Uncertainty& known = *previous.uncertainty;
  const double axes = numbers_of_touches > 0          ? numbers_of_touches
                      : known.reading.orientation > 0 ? 6
                                                      : 3;
  return std::max(1.0, axes * known.poses - static_cast<double>(known.parameters.size()));
}

}  // namespace

ChangeProblem::ChangeProblem(const Robot& previous, const Campaign& campaign,
                             const ReadingSigma& sigma)
    : previous_(previous),
      own_bases_(has_own_bases(previous, campaign)),
      start_(start_of(previous, campaign)),
      own_(own_parameters(start_)),
      models_(campaign, start_, parameters_of(start_, campaign), sigma, 0),
      rows_by_pose_(grouped_rows(campaign.pose)) {
  for (int s = 0; s < sessions(); ++s) {
    std::vector<int>& column = columns_.emplace_back(parameter_count(start_.chain), -1);
    for (int k = 0; k < models_.model(s).unknowns(); ++k)
      column[models_.model(s).geometric()[k]] = k;
  }
  count_replicates();
  enter_errors();
  enter_hypotheses();
  Eigen::Index unknowns = std::ssize(errors_);
  for (const Hypothesis& hypothesis : hypotheses_) {
    first_of_moves_.push_back(unknowns);
    unknowns += std::ssize(hypothesis.moves);
  }
  Fit nothing;
  nothing.x = Eigen::VectorXd::Zero(unknowns);
  at_start_ = sums_of(all_unknowns(), {}, false, nothing);
}

void ChangeProblem::count_replicates() {
  const Campaign& campaign = models_.campaign();
  using Key = std::pair<int, int>;
  const auto key = [&](int row) { return Key{campaign.pose[row], campaign.channel(row)}; };
  const auto sorted_keys = [&](const std::vector<int>& rows) {
    std::vector<Key> keys;
    keys.reserve(rows.size());
    for (int row : rows) keys.push_back(key(row));
    std::ranges::sort(keys);
    return keys;
  };
  const auto count_different = [](std::vector<Key> keys) {
    return static_cast<double>(std::unique(keys.begin(), keys.end()) - keys.begin());
  };
  std::vector<int> all(campaign.rows());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<Key> keys = sorted_keys(all);
  // Not std::ranges: clang 14, which builds the fuzzers, cannot compile its subranges.
  for (int row : all) {
    const auto [first, last] = std::equal_range(keys.begin(), keys.end(), key(row));
    shares_.push_back(1.0 / static_cast<double>(last - first));
  }
  equations_ = count_different(keys) * models_.row_size();
  degrees_of_freedom_ = equations_;
  for (int s = 0; s < sessions(); ++s) {
    double share = 0;
    for (int row : models_.rows_of(s)) share += shares_[row];
    session_shares_.push_back(share / count_different(sorted_keys(models_.rows_of(s))));
  }
}

double ChangeProblem::deviation_of(int parameter) const {
  const std::string name = parameter_name(start_.chain, parameter);
  if (const auto& known = previous_.uncertainty) {
    const auto place = std::ranges::find(known->parameters, name);
    if (place != known->parameters.end())
      return known->root.row(place - known->parameters.begin()).norm();
  }
  const auto found = start_.std.find(name);
  return found == start_.std.end() ? 0 : found->second;
}

// 0: no uncertainty; infinite in a session that the previous robot does not know.
double ChangeProblem::deviation_of(int parameter, int session) const {
  const auto known = previous_.sessions.find(models_.name(session));
  if (is_of_base(parameter) || known == previous_.sessions.end()) return kNothingKnown;
  const auto own = known->second.std.find(parameter_name(start_.chain, parameter));
  return own == known->second.std.end() ? deviation_of(parameter) : own->second;
}

void ChangeProblem::enter_errors() {
  for (int k : models_.geometric()) {
    const double deviation = deviation_of(k);
    if (!is_own(k) && deviation > 0) errors_.push_back({k, 0, sessions() - 1, deviation});
  }
  correlate_errors();
  for (int s = 0; own_bases_ && s < sessions(); ++s) {
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

// Readings determine places and links only relative to each other: taken as independent, their
// errors would hide most moves. Those of the bases of sessions, which follow, are independent.
void ChangeProblem::correlate_errors() {
  if (!previous_.uncertainty) return;
  const std::vector<std::string>& known = previous_.uncertainty->parameters;
  std::vector<Eigen::Index> rows;
  for (const Unknown& error : errors_) {
    const auto found = std::ranges::find(known, parameter_name(start_.chain, error.parameter));
    if (found == known.end()) break;
    rows.push_back(found - known.begin());
  }
  if (rows.empty()) return;
  const Eigen::MatrixXd root = previous_.uncertainty->root(rows, Eigen::all);
  const Eigen::LLT<Eigen::MatrixXd> llt{Eigen::MatrixXd(root * root.transpose())};
  if (llt.info() != Eigen::Success) return;
  const Eigen::Index count = rows.size();
  correlated_ = llt.matrixL().solve(Eigen::MatrixXd::Identity(count, count));
}

void ChangeProblem::enter_hypothesis(const std::string& what, const std::vector<int>& parameters,
                                     int first, int last) {
  Hypothesis hypothesis{what, {}};
  for (int k : parameters) hypothesis.moves.push_back({k, first, last, kNothingKnown});
  if (!parameters.empty()) hypotheses_.push_back(hypothesis);
}

// By the name with which those of its parameters begin: "contact plate", "beam laser", "camera
// eye".
void ChangeProblem::enter_contact(const std::vector<int>& parameters, int first, int last) {
  if (parameters.empty()) return;
  const std::string name = parameter_name(start_.chain, parameters.front());
  enter_hypothesis(name.substr(0, name.rfind('.')), parameters, first, last);
}

// Whether one camera or board alone is at rest, and on the arm: it then is what base, or tool,
// moves, and has the name of its own.
std::array<bool, 2> ChangeProblem::named_by_images() const {
  if (!models_.campaign().has_pixels_only()) return {false, false};
  std::array<int, 2> things{};
  for (int c = 0; c < std::ssize(start_.chain.contacts); ++c)
    if (!of_touched_contact(start_.chain, models_.campaign(), c).empty())
      ++things[start_.chain.contacts[c].on_arm ? 1 : 0];
  return {things[0] == 1, things[1] == 1};
}

// Parameters that move none of these readings are left out.
void ChangeProblem::enter_hypotheses() {
  const int first_anchor = first_anchor_parameter(start_.chain);
  const int count = anchor_count(start_.chain);
  for (int s = 0; s < sessions(); ++s) {
    const ObservationModel& model = models_.model(s);
    const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(model.unknowns());
    for_ordered_blocks<Eigen::VectorXd>(
        model.rows(), kRowsPerBlock,
        [&](int begin, int end) {
          Eigen::MatrixXd rows((end - begin) * model.row_size(), model.unknowns() + 1);
          at.blocks(begin, end - begin, rows);
          return Eigen::VectorXd(
              rows.leftCols(model.unknowns()).colwise().squaredNorm().transpose());
        },
        [&](const Eigen::VectorXd& of_block) { squares += of_block; });
    const ParameterLayout layout = layout_of(start_.chain);
    std::vector<int> tool, links;
    std::vector<std::vector<int>> anchors(count);
    for (int k : models_.geometric()) {
      if (is_of_base(k) || squares[columns_[s][k]] <= 1e-12 * squares.maxCoeff()) continue;
      if (k < layout.tool)
        links.push_back(k);
      else if (layout.is_of_tool(k))
        tool.push_back(k);
      else if (is_place_of_anchor(start_.chain, k))
        anchors[(k - first_anchor) / 4].push_back(k);
    }
    const int last = sessions() - 1;
    const std::array<bool, 2> named = named_by_images();
    if (!own_bases_ && !named[0]) {
      std::vector<int> base(kParametersPerPose);
      std::iota(base.begin(), base.end(), kFirstBaseParameter);
      enter_hypothesis("base", shown(start_, base, model.campaign()), s, last);
    }
    if (!named[1]) enter_hypothesis("tool", tool, s, last);
    for (int c = 0; c < std::ssize(start_.chain.contacts); ++c)
      enter_contact(of_touched_contact(start_.chain, models_.campaign(), c), s, last);
    for (int a = 0; a < count && (count > 1 || models_.campaign().has_coordinates());
         ++a)  // a single one is the base
      enter_hypothesis("anchor " + start_.chain.anchors[a].name, anchors[a], s, last);
    for (int k : links)
      if (!is_own(k))
        enter_hypothesis(parameter_name(start_.chain, k), {k}, s, last);
      else if (deviation_of(k, s) != kNothingKnown)
        enter_hypothesis(parameter_name(start_.chain, k), {k}, s, s);
  }
}

std::vector<ChangeProblem::Unknown> ChangeProblem::unknowns_of(
    const std::vector<int>& moved) const {
  std::vector<Unknown> unknowns = errors_;
  for (int k : moved)
    unknowns.insert(unknowns.end(), hypotheses_[k].moves.begin(), hypotheses_[k].moves.end());
  return unknowns;
}

Eigen::VectorXd ChangeProblem::unknowns_of(int session, const std::vector<Unknown>& unknowns,
                                           const Eigen::VectorXd& x) const {
  Eigen::VectorXd own = Eigen::VectorXd::Zero(models_.model(session).unknowns());
  for (size_t i = 0; i < unknowns.size(); ++i)
    if (unknowns[i].acts_in(session)) own[columns_[session][unknowns[i].parameter]] += x[i];
  return own;
}

double ChangeProblem::mean_error(const std::vector<int>& moved, const Fit& fitted) const {
  std::vector<Unknown> unknowns = unknowns_of(moved);
  Eigen::VectorXd x = fitted.x;
  for (size_t i = 0; i < unknowns.size(); ++i)
    if (unknowns[i].deviation != kNothingKnown) x[i] = 0;
  double sum = 0;
  for (int s = 0; s < sessions(); ++s) {
    const ObservationModel& model = models_.model(s);
    const ObservationModel::At at = model.at(unknowns_of(s, unknowns, x));
    for_ordered_blocks<double>(
        model.rows(), kRowsPerBlock,
        [&](int begin, int end) {
          std::vector<Eigen::Matrix<double, 6, 1>> residuals(end - begin);
          at.residuals(begin, residuals);
          double of_block = 0;
          for (const auto& residual : residuals) of_block += residual.head<3>().norm();
          return of_block;
        },
        [&](double of_block) { sum += of_block; });
  }
  return sum / models_.rows();
}

Move ChangeProblem::described(const std::vector<int>& moved, size_t which,
                              const Fit& fitted) const {
  const Hypothesis& hypothesis = hypotheses_[moved[which]];
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

// The covariance of the difference from the known base is the sum of the covariances of both.
std::vector<Move> ChangeProblem::stations(const Fit& fitted) const {
  std::vector<Move> moves;
  for (int s = 0; own_bases_ && s < sessions(); ++s) {
    const auto known = previous_.sessions.find(models_.name(s));
    if (known == previous_.sessions.end()) continue;
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
    std::vector<int> places, parameters;
    for (int i = 0; i < std::ssize(errors_); ++i)
      if (is_of_base(errors_[i].parameter) && errors_[i].acts_in(s)) {
        places.push_back(i);
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

double ChangeProblem::p_value(const std::vector<int>& moved, const Fit& fitted,
                              double overdispersion) const {
  const double freedom = std::max(1.0, degrees_of_freedom_ - moves_in(moved));
  const double rows = models_.rows();
  const double touches = models_.campaign().has_touches() ? rows / poses() : 0;
  return fisher_f_above(fitted.loss / freedom, freedom / overdispersion,
                        freedom_of_spread(previous_, touches));
}

double ChangeProblem::overdispersion(const Fit& fitted) const {
  const double n = poses();
  if (n < 2) return 1;
  const ChiSquares& of = fitted.chi_squares;
  const double mean = of.c / of.e;
  const double squares = std::max(0.0, of.cc - 2 * mean * of.ce + mean * mean * of.ee);
  const double scale = std::max(1.0, mean);  // of all residuals, which the loss shows
  return std::max(1.0, n / (n - 1) * squares / (2 * of.e * scale * scale));
}

double ChangeProblem::widening(const std::vector<int>& moved, size_t which,
                               const Fit& fitted) const {
  const Eigen::Index first = first_of(moved, which);
  const Eigen::Index count = hypotheses_[moved[which]].moves.size();
  const Eigen::VectorXd ratio =
      fitted.by_pose.diagonal()
          .segment(first, count)
          .cwiseQuotient(fitted.covariance.diagonal().segment(first, count));
  return std::max(1.0, ratio.mean());
}

Eigen::Index ChangeProblem::first_of(const std::vector<int>& moved, size_t which) const {
  size_t first = errors_.size();
  for (size_t i = 0; i < which; ++i) first += hypotheses_[moved[i]].moves.size();
  return first;
}

}  // namespace armtrue
