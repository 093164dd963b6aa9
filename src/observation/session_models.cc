#include "armtrue/observation/session_models.h"

#include <Eigen/Core>
#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "armtrue/campaign/sessions.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/summary.h"
#include "linear_algebra/decompositions.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

double median_ratio(const std::vector<double>& part, const std::vector<double>& whole) {
  if (whole.empty()) return 1.0;
  const double of_whole = median(whole);
  return of_whole > 0 ? median(part) / of_whole : 1.0;
}

bool contains(const std::vector<int>& parameters, int parameter) {
  return std::find(parameters.begin(), parameters.end(), parameter) != parameters.end();
}

// Base rotations that distances cannot observe: all three with one anchor; about the connecting
// line with two, for which the rotation about the axis nearest to that line is left out.
std::vector<int> unobservable_rotations(const Campaign& readings, const KinematicChain& chain,
                                        const Pose& common_from_own) {
  if (!readings.reads_one_number() || readings.has_touches()) return {};
  const std::vector<int> matched = match_anchors(readings, chain);
  std::set<int> seen;
  for (int row = 0; row < readings.rows(); ++row) {
    if (readings.kind(row) == ReadingKind::coordinate) return {};
    seen.insert(matched[readings.anchor.empty() ? 0 : readings.anchor[row]]);
  }
  constexpr int kTurns = kFirstBaseParameter + 3;
  if (seen.size() == 1) return {kTurns, kTurns + 1, kTurns + 2};
  if (seen.size() > 2) return {};
  const Eigen::Vector3d line = common_from_own.rotation * (chain.anchors[*seen.rbegin()].position -
                                                           chain.anchors[*seen.begin()].position);
  int along = 0;
  line.cwiseAbs().maxCoeff(&along);
  return {kTurns + along};
}

bool moves_target(const Effect& effect) {
  return owner_of(effect) == Owner::target || std::ranges::any_of(effect.members, moves_target);
}

constexpr int kNoTarget = -1;

}  // namespace

SessionModels::SessionModels(const Campaign& campaign, const Robot& robot,
                             const std::vector<int>& geometric, const ReadingSigma& sigma,
                             int fitted_effects, Split split)
    : campaign_(campaign), robot_(robot), geometric_(geometric) {
  find_groups(split);
  const auto count = std::ssize(rows_);
  if (by_target_ || count > 1 || robot.sessions.contains(session_name(campaign, 0))) {
    campaigns_.reserve(rows_.size());
    for (int g = 0; g < count; ++g) campaigns_.push_back(readings_of(g));
  }
  models_.reserve(rows_.size());
  Robot alone = robot;  // every model copies it: so without what models do not read
  alone.sessions.clear();
  if (count > 1) {
    alone.std.clear();
    alone.uncertainty.reset();
    alone.nominal.reset();
  }
  if (has_one_target_each_) alone.chain.targets.clear();
  for (int g = 0; g < count; ++g)
    enter_model(g, alone, campaigns_.empty() ? campaign : campaigns_[g], sigma, fitted_effects);
  find_runs();
  set_sigma(sigma);
}

// Targets come in the order of the sessions, those of one session in the order of their names.
void SessionModels::find_groups(Split split) {
  const int first = layout_of(robot_.chain).targets, end = first_anchor_parameter(robot_.chain);
  const auto places = std::ranges::count_if(
      geometric_, [&](int parameter) { return parameter >= first && parameter < end; });
  by_target_ =
      split == Split::by_target && !campaign_.target.empty() && 2 * places > std::ssize(geometric_);
  has_one_target_each_ = by_target_ && std::ranges::none_of(robot_.effects, moves_target);
  const std::vector<int> matched =
      by_target_ ? match_targets(campaign_, robot_.chain) : std::vector<int>{};
  int session = 0;
  for (const std::vector<int>& rows : rows_by_session(campaign_)) {
    std::map<int, std::vector<int>> rows_of_target;
    for (int row : rows)
      if (by_target_) rows_of_target[matched[campaign_.target[row]]].push_back(row);
    if (!by_target_) rows_of_target[kNoTarget] = rows;
    for (auto& [target, own] : rows_of_target) {
      rows_.push_back(std::move(own));
      session_of_.push_back(session);
      target_of_.push_back(target);
    }
    ++session;
  }
}

Campaign SessionModels::readings_of(int group) const {
  Campaign readings = in_common_frame(campaign_.select(rows_[group]), robot_);
  if (by_target_) {
    readings.target_names = {robot_.chain.targets[target_of_[group]].name};
    std::ranges::fill(readings.target, 0);
  }
  if (!readings.session.empty()) {
    readings.session_names = {session_name(readings, 0)};
    std::ranges::fill(readings.session, 0);
  }
  return readings;
}

void SessionModels::enter_model(int group, const Robot& alone, const Campaign& readings,
                                const ReadingSigma& sigma, int fitted_effects) {
  const int session = session_of_[group], target = target_of_[group];
  Robot there = alone;
  if (const auto own = robot_.sessions.find(session_name(readings, 0));
      own != robot_.sessions.end())
    move_to(own->second, there);
  there.chain.base = robot_.chain.base;
  if (has_one_target_each_) there.chain.targets = {robot_.chain.targets[target]};
  if (rows_.size() > 1) there.std.clear();
  const std::vector<int> own = own_parameters(robot_);
  if (session == std::ssize(names_)) {
    names_.push_back(session_name(readings, 0));
    common_from_own_.push_back(common_from_session(robot_, names_.back()));
    std::vector<int>& shown = own_.emplace_back(own);
    const Campaign of_session =
        by_target_ ? campaign_.select(rows_by_session(campaign_)[session]) : Campaign{};
    for (int turn : unobservable_rotations(by_target_ ? of_session : readings, there.chain,
                                           common_from_own_.back()))
      std::erase(shown, turn);
  }
  const ParameterLayout layout = layout_of(robot_.chain);
  const int targets_end = first_anchor_parameter(robot_.chain);
  const int targets = target_count(robot_.chain);
  std::vector<int> parameters = session == 0 ? std::vector<int>{} : own_[session];
  for (int k : geometric_) {
    if (session > 0 && contains(own, k)) continue;
    const bool is_of_target = k >= layout.targets && k < targets_end;
    if (by_target_ && is_of_target && (k - layout.targets) / 3 != target) continue;
    // A robot with one target has lower indices of the parameters behind the targets.
    const int left_out = !has_one_target_each_ || k < layout.targets ? 0
                         : is_of_target                              ? target
                                                                     : targets - 1;
    parameters.push_back(k - 3 * left_out);
  }
  models_.emplace_back(readings, there, std::move(parameters), sigma, fitted_effects,
                       common_from_own_[session]);
  ratio_.push_back({median_ratio(readings.sigma_position, campaign_.sigma_position),
                    median_ratio(readings.sigma_orientation, campaign_.sigma_orientation)});
}

// Splits the unknowns of the first session into runs of one owner: the session, a target, or all
// groups.
void SessionModels::find_runs() {
  constexpr int kCommon = -1, kOwn = -2;
  const int targets_end = first_anchor_parameter(robot_.chain);
  const int first_target = layout_of(robot_.chain).targets;
  const std::vector<int> own = own_parameters(robot_);
  const auto owner_of = [&](int unknown) {  // kOwn, kCommon or a target
    if (unknown >= geometric_count()) return kCommon;
    const int parameter = geometric_[unknown];
    if (sessions() > 1 && contains(own, parameter)) return kOwn;
    if (!by_target_ || parameter < first_target || parameter >= targets_end) return kCommon;
    return (parameter - first_target) / 3;
  };
  runs_.resize(models_.size());
  for (int g = 0; g < groups(); ++g)
    if (const int s = session_of_[g]; s > 0)
      runs_[g].push_back({first_own(s), first_own(s + 1) - first_own(s)});
  for (int begin = 0, end = 0; begin < first_own(1); begin = end) {
    const int owner = owner_of(begin);
    while (end < first_own(1) && owner_of(end) == owner) ++end;
    for (int g = 0; g < groups(); ++g)
      if (owner == kCommon || (owner == kOwn ? session_of_[g] == 0 : target_of_[g] == owner))
        runs_[g].push_back({begin, end - begin});
  }
}

Eigen::VectorXd SessionModels::unknowns_of(int group, const Eigen::VectorXd& x) const {
  Eigen::VectorXd own(models_[group].unknowns());
  int filled = 0;
  for (const Run& run : runs_[group]) {
    own.segment(filled, run.count) = x.segment(run.first, run.count);
    filled += run.count;
  }
  return own;
}

std::vector<std::vector<Eigen::Index>> SessionModels::unknowns_by_groups() const {
  std::vector<std::vector<int>> groups_of(unknowns());
  for (int g = 0; g < groups(); ++g)
    for (const Run& run : runs_[g])
      for (int k = run.first; k < run.first + run.count; ++k) groups_of[k].push_back(g);
  std::map<std::vector<int>, std::vector<Eigen::Index>> unknowns_of;
  for (size_t k = 0; k < groups_of.size(); ++k) unknowns_of[groups_of[k]].push_back(k);
  std::vector<std::vector<Eigen::Index>> all;
  for (auto& [groups, unknowns] : unknowns_of) all.push_back(std::move(unknowns));
  return all;
}

std::vector<int> SessionModels::in_first_session(int group) const {
  const int session = session_of_[group];
  std::vector<int> unknowns;
  for (const Run& run : runs_[group])
    for (int k = run.first; k < run.first + run.count; ++k) {
      if (k < first_own(1)) {
        unknowns.push_back(k);
        continue;
      }
      const auto same = std::ranges::find(geometric_, own_[session][k - first_own(session)]);
      unknowns.push_back(same == geometric_.end() ? -1
                                                  : static_cast<int>(same - geometric_.begin()));
    }
  return unknowns;
}

std::vector<int> SessionModels::geometric_unknowns() const {
  std::vector<int> indices(geometric_count());
  std::iota(indices.begin(), indices.end(), 0);
  for (int k = first_own(1); k < unknowns(); ++k) indices.push_back(k);
  return indices;
}

std::vector<std::string> SessionModels::unknown_names() const {
  std::vector<std::string> names;
  for (int k : geometric_) names.push_back(parameter_name(robot_.chain, k));
  const std::vector<std::string> of_group = models_.front().unknown_names();
  names.insert(names.end(), of_group.begin() + models_.front().geometric_count(), of_group.end());
  for (int s = 1; s < sessions(); ++s)
    for (int k : own_[s])
      names.push_back("session " + names_[s] + " " + parameter_name(robot_.chain, k));
  return names;
}

double SessionModels::mean_square_value(int coefficient) const {
  double mean = 0;
  for (const ObservationModel& model : models_)
    mean += model.mean_square_value(coefficient) * model.rows() / rows();
  return mean;
}

Robot SessionModels::robot_at(const Eigen::VectorXd& x) const {
  Robot robot = models_.front().robot_at(unknowns_of(0, x));
  if (groups() > 1) {
    robot.std = robot_.std;
    robot.uncertainty = robot_.uncertainty;
    robot.nominal = robot_.nominal;
  }
  if (by_target_) {
    robot.chain.targets = robot_.chain.targets;
    const int first = layout_of(robot.chain).targets, end = first_anchor_parameter(robot.chain);
    for (int k = 0; k < geometric_count(); ++k)
      if (geometric_[k] >= first && geometric_[k] < end)
        move_parameter(robot.chain, geometric_[k], x[k]);
  }
  for (int g = 0; sessions() > 1 && g < groups(); ++g) {
    const int s = session_of_[g];
    if (g > 0 && session_of_[g - 1] == s) continue;
    KinematicChain chain = models_[g].robot_at(unknowns_of(g, x)).chain;
    Session& session = robot.sessions[names_[s]];
    const auto known = robot_.sessions.find(names_[s]);
    if (known != robot_.sessions.end()) session = known->second;
    session.base = inverse(common_from_own_[s]) * chain.base;
    for (int k : own_[s])
      if (is_zero_offset(chain, k)) session.zero.try_emplace(link_of_parameter(k));
    for (auto& [link, zero] : session.zero) zero = zero_of(chain.links[link]);
  }
  return robot;
}

void SessionModels::set_sigma(const ReadingSigma& sigma) {
  sigma_ = sigma;
  for (size_t g = 0; g < models_.size(); ++g)
    models_[g].set_sigma(
        {sigma.position * ratio_[g].position, sigma.orientation * ratio_[g].orientation});
}

ReadingLaw SessionModels::law_of(int group, const ReadingLaw& law) const {
  if (groups() == 1 || law.variance.empty()) return law;
  ReadingLaw own{law.degrees_of_freedom, {}, law.most_counted};
  for (int row : rows_[group]) own.variance.push_back(law.variance[row]);
  return own;
}

std::vector<Eigen::Vector2d> SessionModels::squared_norms(const Eigen::VectorXd& x) const {
  std::vector<Eigen::Vector2d> norms(rows());
  for (int g = 0; g < groups(); ++g) {
    const std::vector<Eigen::Vector2d> own =
        armtrue::squared_norms(models_[g].at(unknowns_of(g, x)), models_[g]);
    for (size_t i = 0; i < own.size(); ++i) norms[rows_[g][i]] = own[i];
  }
  return norms;
}

void SessionModels::scatter(int group, const Eigen::Ref<const Eigen::MatrixXd>& block,
                            Eigen::Ref<Eigen::MatrixXd> out) const {
  int taken = 0;
  for (const Run& run : runs_[group]) {
    out.middleCols(run.first, run.count) = block.middleCols(taken, run.count);
    taken += run.count;
  }
  out.rightCols<1>() = block.rightCols<1>();
}

SessionModels::At::At(const SessionModels& models, const Eigen::VectorXd& x) : models_(models) {
  for (int g = 0; g < models.groups(); ++g)
    groups_.push_back(models.model(g).at(models.unknowns_of(g, x)));
  if (models.groups() == 1) return;
  places_.resize(models.rows());
  for (int g = 0; g < models.groups(); ++g)
    for (int own = 0; own < std::ssize(models.rows_of(g)); ++own)
      places_[models.rows_of(g)[own]] = {g, own};
}

void SessionModels::At::block(int row, Eigen::Ref<Eigen::MatrixXd> out) const {
  if (places_.empty()) {
    own_block(row, out);
    return;
  }
  Eigen::MatrixXd block(out.rows(), models_.model(group_of(row)).unknowns() + 1);
  own_block(row, block);
  out.setZero();
  models_.scatter(group_of(row), block, out);
}

std::vector<std::vector<int>> SessionModels::At::replicates_among(std::span<const int> rows) const {
  std::vector<std::vector<int>> replicates;
  std::map<std::pair<int, int>, size_t> known;  // by group and prediction
  for (int row : rows) {
    const int group = group_of(row);
    const ObservationModel& model = models_.model(group);
    bool is_new = true;
    if (model.has_replicates()) {
      const int prediction = model.prediction_of(places_.empty() ? row : places_[row].row);
      const auto [place, entered] = known.try_emplace({group, prediction}, replicates.size());
      is_new = entered;
      if (!is_new) replicates[place->second].push_back(row);
    }
    if (is_new) replicates.push_back({row});
  }
  return replicates;
}

SessionModels::At SessionModels::at(const Eigen::VectorXd& x) const { return At(*this, x); }

Eigen::MatrixXd SessionModels::blocks() const {
  const int size = row_size();
  Eigen::MatrixXd all(rows() * size, unknowns() + 1);
  const At at = this->at(Eigen::VectorXd::Zero(unknowns()));
  for_ordered_blocks<int>(
      rows(), kRowsPerBlock,
      [&](int begin, int end) {
        for (int row = begin; row < end; ++row) at.block(row, all.middleRows(row * size, size));
        return 0;
      },
      [](int) {});
  return all;
}

Eigen::MatrixXd SessionModels::join(const std::vector<Eigen::MatrixXd>& factors) const {
  if (factors.size() == 1) return factors.front();
  Eigen::Index height = 0;
  for (const Eigen::MatrixXd& factor : factors) height += factor.rows();
  const Eigen::Index columns = unknowns() + 1;
  Eigen::MatrixXd stacked = Eigen::MatrixXd::Zero(std::max(height, columns), columns);
  Eigen::Index top = 0;
  for (int g = 0; g < groups(); ++g) {
    const Eigen::MatrixXd& factor = factors[g];
    scatter(g, factor, stacked.middleRows(top, factor.rows()));
    top += factor.rows();
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(stacked);
  return qr.matrixQR().topRows(columns).triangularView<Eigen::Upper>();
}

}  // namespace armtrue
