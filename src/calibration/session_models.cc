#include "calibration/session_models.h"

#include <Eigen/Core>
#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/summary.h"
#include "campaign/sessions.h"
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
  if (!readings.has_distances() || readings.has_touches()) return {};
  const std::vector<int> matched = match_anchors(readings, chain);
  std::set<int> seen;
  for (int row = 0; row < readings.rows(); ++row) {
    if (readings.kind(row) == ReadingKind::coordinate) return {};
    seen.insert(matched[readings.anchor.empty() ? 0 : readings.anchor[row]]);
  }
  constexpr int kTurns = kBaseParameters + 3;
  if (seen.size() == 1) return {kTurns, kTurns + 1, kTurns + 2};
  if (seen.size() > 2) return {};
  const Eigen::Vector3d line = common_from_own.rotation * (chain.anchors[*seen.rbegin()].position -
                                                           chain.anchors[*seen.begin()].position);
  int along = 0;
  line.cwiseAbs().maxCoeff(&along);
  return {kTurns + along};
}

// Those of a further session: its own as far as they are shown, then what is common.
std::vector<int> further(const std::vector<int>& shown, const std::vector<int>& own,
                         const std::vector<int>& geometric) {
  std::vector<int> all = shown;
  for (int k : geometric)
    if (!contains(own, k)) all.push_back(k);
  return all;
}

}  // namespace

SessionModels::SessionModels(const Campaign& campaign, const Robot& robot,
                             const std::vector<int>& geometric, const ReadingSigma& sigma,
                             int fitted_effects)
    : campaign_(campaign), robot_(robot), rows_(rows_by_session(campaign)) {
  const size_t count = rows_.size();
  if (count > 1 || robot.sessions.contains(session_name(campaign, 0))) {
    campaigns_.reserve(count);
    for (const std::vector<int>& rows : rows_)
      campaigns_.push_back(in_common_frame(campaign.select(rows), robot));
  }
  const std::vector<int> own = own_parameters(robot);
  models_.reserve(count);
  for (size_t s = 0; s < count; ++s) {
    const Campaign& readings = campaigns_.empty() ? campaign : campaigns_[s];
    names_.push_back(session_name(readings, 0));
    common_from_own_.push_back(common_from_session(robot, names_.back()));
    Robot there = robot_at_row(robot, readings, 0);
    there.chain.base = robot.chain.base;
    std::vector<int>& shown = own_.emplace_back(own);
    for (int turn : unobservable_rotations(readings, there.chain, common_from_own_.back()))
      std::erase(shown, turn);
    models_.emplace_back(readings, there, s == 0 ? geometric : further(shown, own, geometric),
                         sigma, fitted_effects, common_from_own_.back());
    ratio_.push_back({median_ratio(readings.sigma_position, campaign.sigma_position),
                      median_ratio(readings.sigma_orientation, campaign.sigma_orientation)});
  }
  // The unknowns of the first session in turns of its own and of common ones.
  runs_.resize(count);
  const auto is_own = [&](int unknown) {
    return count > 1 && unknown < geometric_count() && contains(own, this->geometric()[unknown]);
  };
  for (int s = 1; s < sessions(); ++s)
    runs_[s].push_back({first_own(s), static_cast<int>(own_[s].size())});
  const int all = models_.front().unknowns();
  for (int begin = 0, end = 0; begin < all; begin = end) {
    while (end < all && is_own(end) == is_own(begin)) ++end;
    runs_.front().push_back({begin, end - begin});
    for (int s = 1; s < sessions() && !is_own(begin); ++s) runs_[s].push_back({begin, end - begin});
  }
  set_sigma(sigma);
}

Eigen::VectorXd SessionModels::unknowns_of(int session, const Eigen::VectorXd& x) const {
  Eigen::VectorXd own(models_[session].unknowns());
  int filled = 0;
  for (const Run& run : runs_[session]) {
    own.segment(filled, run.count) = x.segment(run.first, run.count);
    filled += run.count;
  }
  return own;
}

std::vector<int> SessionModels::geometric_unknowns() const {
  std::vector<int> indices(geometric_count());
  std::iota(indices.begin(), indices.end(), 0);
  for (int k = first_own(1); k < unknowns(); ++k) indices.push_back(k);
  return indices;
}

std::vector<std::string> SessionModels::unknown_names() const {
  std::vector<std::string> names = models_.front().unknown_names();
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
  for (int s = 0; sessions() > 1 && s < sessions(); ++s) {
    KinematicChain chain = models_[s].robot_at(unknowns_of(s, x)).chain;
    Session& session = robot.sessions[names_[s]];
    const auto known = robot_.sessions.find(names_[s]);
    if (known != robot_.sessions.end()) session = known->second;
    session.base = inverse(common_from_own_[s]) * chain.base;
    for (int k : own_[s])
      if (is_zero_offset(chain, k)) session.theta.try_emplace(link_of_parameter(k));
    for (auto& [link, theta] : session.theta) theta = zero_of(chain.links[link]);
  }
  return robot;
}

void SessionModels::set_sigma(const ReadingSigma& sigma) {
  sigma_ = sigma;
  for (size_t s = 0; s < models_.size(); ++s)
    models_[s].set_sigma(
        {sigma.position * ratio_[s].position, sigma.orientation * ratio_[s].orientation});
}

ReadingLaw SessionModels::law_of(int session, const ReadingLaw& law) const {
  if (sessions() == 1 || law.variance.empty()) return law;
  ReadingLaw own{law.degrees_of_freedom};
  for (int row : rows_[session]) own.variance.push_back(law.variance[row]);
  return own;
}

std::vector<Eigen::Vector2d> SessionModels::squared_norms(const Eigen::VectorXd& x) const {
  std::vector<Eigen::Vector2d> norms(rows());
  for (int s = 0; s < sessions(); ++s) {
    const std::vector<Eigen::Vector2d> own =
        armtrue::squared_norms(models_[s].at(unknowns_of(s, x)), models_[s]);
    for (size_t i = 0; i < own.size(); ++i) norms[rows_[s][i]] = own[i];
  }
  return norms;
}

void SessionModels::scatter(int session, const Eigen::Ref<const Eigen::MatrixXd>& block,
                            Eigen::Ref<Eigen::MatrixXd> out) const {
  int taken = 0;
  for (const Run& run : runs_[session]) {
    out.middleCols(run.first, run.count) = block.middleCols(taken, run.count);
    taken += run.count;
  }
  out.rightCols<1>() = block.rightCols<1>();
}

SessionModels::At::At(const SessionModels& models, const Eigen::VectorXd& x) : models_(models) {
  for (int s = 0; s < models.sessions(); ++s)
    sessions_.push_back(models.model(s).at(models.unknowns_of(s, x)));
  if (models.sessions() == 1) return;
  places_.resize(models.rows());
  for (int s = 0; s < models.sessions(); ++s)
    for (size_t own = 0; own < models.rows_of(s).size(); ++own)
      places_[models.rows_of(s)[own]] = {s, static_cast<int>(own)};
}

void SessionModels::At::block(int row, Eigen::Ref<Eigen::MatrixXd> out) const {
  if (places_.empty()) {
    sessions_.front().block(row, out);
    return;
  }
  const auto [session, own] = places_[row];
  Eigen::MatrixXd block(out.rows(), models_.model(session).unknowns() + 1);
  sessions_[session].block(own, block);
  out.setZero();
  models_.scatter(session, block, out);
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
  for (int s = 0; s < sessions(); ++s) {
    const Eigen::MatrixXd& factor = factors[s];
    scatter(s, factor, stacked.middleRows(top, factor.rows()));
    top += factor.rows();
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(stacked);
  return qr.matrixQR().topRows(columns).triangularView<Eigen::Upper>();
}

Eigen::MatrixXd SessionModels::sum(const std::vector<Eigen::MatrixXd>& informations) const {
  if (informations.size() == 1) return informations.front();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(unknowns(), unknowns());
  for (int s = 0; s < sessions(); ++s) {
    int column = 0;
    for (const Run& right : runs_[s]) {
      int row = 0;
      for (const Run& left : runs_[s]) {
        sum.block(left.first, right.first, left.count, right.count) +=
            informations[s].block(row, column, left.count, right.count);
        row += left.count;
      }
      column += right.count;
    }
  }
  return sum;
}

}  // namespace armtrue
