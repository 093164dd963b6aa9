#include "sessions.h"

#include <Eigen/QR>
#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>

#include "armtrue/identification/statistics.h"

namespace armtrue {
namespace {

constexpr int kFewestRowsOfSession = 50;

std::string session_name(const Campaign& campaign, int row) {
  return campaign.session.empty() ? "" : campaign.session_names[campaign.session[row]];
}

double median_ratio(const std::vector<double>& part, const std::vector<double>& whole) {
  const double of_whole = median(whole);
  return of_whole > 0 ? median(part) / of_whole : 1.0;
}

// Those of a further session: all of its base, and what is common.
std::vector<int> with_whole_base(const std::vector<int>& geometric) {
  std::vector<int> all(kLinkParameters);
  std::iota(all.begin(), all.end(), kBaseParameters);
  for (int k : geometric)
    if (k >= kLinkParameters) all.push_back(k);
  return all;
}

}  // namespace

std::vector<std::vector<int>> rows_by_session(const Campaign& campaign) {
  std::vector<std::vector<int>> sessions(std::max<size_t>(1, campaign.session_names.size()));
  for (int row = 0; row < campaign.rows(); ++row)
    sessions[campaign.session.empty() ? 0 : campaign.session[row]].push_back(row);
  std::erase_if(sessions, [](const std::vector<int>& rows) { return rows.empty(); });
  if (sessions.empty()) sessions.emplace_back();
  return sessions;
}

std::vector<int> thinned_rows(const Campaign& campaign, int count) {
  std::vector<int> chosen;
  for (const std::vector<int>& rows : rows_by_session(campaign)) {
    const long available = static_cast<long>(rows.size());
    const long share = campaign.rows() > 0 ? count * available / campaign.rows() : 0;
    const long kept = std::min(available, std::max<long>(share, kFewestRowsOfSession));
    for (long i = 0; i < kept; ++i) chosen.push_back(rows[i * available / kept]);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

Robot robot_at_row(const Robot& robot, const Campaign& campaign, int row) {
  Robot there = robot;
  there.sessions.clear();
  if (row >= campaign.rows()) return there;
  const auto found = robot.sessions.find(session_name(campaign, row));
  if (found != robot.sessions.end()) there.chain.base = found->second;
  return there;
}

void require_one_session(const Campaign& training, const Campaign& held_out) {
  std::set<std::string> names;
  for (const Campaign* campaign : {&training, &held_out})
    for (int session : campaign->session) names.insert(campaign->session_names[session]);
  if (names.size() > 1)
    throw std::invalid_argument(
        "the measurements are of " + std::to_string(names.size()) +
        " sessions with a base frame each; effects are traced in one session at a time: calibrate "
        "on all of them, then trace the rows of one");
}

SessionModels::SessionModels(const Campaign& campaign, const Robot& robot,
                             const std::vector<int>& geometric, const ReadingScale& scale,
                             bool fit_effects)
    : campaign_(campaign), robot_(robot), rows_(rows_by_session(campaign)) {
  const size_t count = rows_.size();
  if (count > 1) {
    campaigns_.reserve(count);
    for (const std::vector<int>& rows : rows_) campaigns_.push_back(campaign.select(rows));
  }
  const int own_base = static_cast<int>(
      std::count_if(geometric.begin(), geometric.end(), [](int k) { return k < kLinkParameters; }));
  models_.reserve(count);
  for (size_t s = 0; s < count; ++s) {
    const Campaign& readings = count > 1 ? campaigns_[s] : campaign;
    names_.push_back(readings.rows() > 0 ? session_name(readings, 0) : "");
    models_.emplace_back(readings, robot_at_row(robot, readings, 0),
                         s == 0 ? geometric : with_whole_base(geometric), scale, fit_effects);
    ratio_.push_back({median_ratio(readings.sigma_position, campaign.sigma_position),
                      median_ratio(readings.sigma_orientation, campaign.sigma_orientation)});
    const int first_unknowns = models_.front().unknowns();
    if (count == 1) {
      runs_.push_back({{0, first_unknowns}});
      continue;
    }
    std::vector<Run> runs{
        s == 0 ? Run{0, own_base} : Run{first_unknowns + 6 * (static_cast<int>(s) - 1), 6},
        {own_base, first_unknowns - own_base}};
    std::erase_if(runs, [](const Run& run) { return run.count == 0; });
    runs_.push_back(std::move(runs));
  }
  set_scale(scale);
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
  for (int k = models_.front().unknowns(); k < unknowns(); ++k) indices.push_back(k);
  return indices;
}

std::vector<std::string> SessionModels::unknown_names() const {
  std::vector<std::string> names = models_.front().unknown_names();
  for (int s = 1; s < sessions(); ++s)
    for (int k = 0; k < 6; ++k)
      names.push_back("session " + names_[s] + " " +
                      parameter_name(robot_.chain, kBaseParameters + k));
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
  for (int s = 0; sessions() > 1 && s < sessions(); ++s)
    robot.sessions[names_[s]] = models_[s].robot_at(unknowns_of(s, x)).chain.base;
  return robot;
}

void SessionModels::set_scale(const ReadingScale& scale) {
  scale_ = scale;
  for (size_t s = 0; s < models_.size(); ++s)
    models_[s].set_scale(
        {scale.position * ratio_[s].position, scale.orientation * ratio_[s].orientation});
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

Eigen::MatrixXd SessionModels::blocks() const {
  const int size = row_size();
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(rows() * size, unknowns() + 1);
  for (int s = 0; s < sessions(); ++s) {
    const ObservationModel& model = models_[s];
    const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
    Eigen::MatrixXd block(size, model.unknowns() + 1);
    for (int row = 0; row < model.rows(); ++row) {
      at.block(row, block);
      auto out = all.middleRows(rows_[s][row] * size, size);
      int taken = 0;
      for (const Run& run : runs_[s]) {
        out.middleCols(run.first, run.count) = block.middleCols(taken, run.count);
        taken += run.count;
      }
      out.rightCols<1>() = block.rightCols<1>();
    }
  }
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
    auto out = stacked.middleRows(top, factor.rows());
    int taken = 0;
    for (const Run& run : runs_[s]) {
      out.middleCols(run.first, run.count) = factor.middleCols(taken, run.count);
      taken += run.count;
    }
    out.rightCols<1>() = factor.rightCols<1>();
    top += factor.rows();
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(stacked);
  return qr.matrixQR().topRows(columns).triangularView<Eigen::Upper>();
}

}  // namespace armtrue
