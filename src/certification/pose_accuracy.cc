#include "armtrue/certification/pose_accuracy.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "armtrue/kinematics/pose.h"
#include "armtrue/statistics/random.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

struct Repeatability {
  double rp = 0;
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
};

// Of rotation vectors, from rotation matrices with components up to 1.
Eigen::Vector3d resolved_turn(const Eigen::Vector3d& spread) {
  return spread.unaryExpr([](double axis) { return resolved(axis, 1); });
}

Repeatability repeatability(const std::vector<Visit>& visits) {
  const auto n = static_cast<int>(visits.size());
  const Eigen::Vector3d mean = mean_of(visits, &Visit::attained);
  Eigen::Matrix3Xd apart(3, n);
  for (Eigen::Index j = 0; j < n; ++j) apart.col(j) = visits[j].attained - mean;
  const Eigen::VectorXd l = apart.colwise().norm().transpose();
  const double s = std::sqrt((l.array() - l.mean()).square().sum() / (n - 1));
  const double rp = resolved(l.mean() + 3 * s, mean.norm());
  if (rp == 0) return {};
  return {rp, apart * apart.transpose()};
}

// 3 S of the rotation vectors from the first visit to each, by axis of R_A.
Eigen::Vector3d turn_repeatability(const std::vector<Visit>& visits) {
  Eigen::Matrix3Xd turns(3, visits.size());
  for (Eigen::Index j = 0; j < turns.cols(); ++j)
    turns.col(j) = rotation_log(*visits[j].orientation * visits.front().orientation->transpose());
  const Eigen::Vector3d mean = turns.rowwise().mean();
  return resolved_turn(
      3 * ((turns.colwise() - mean).rowwise().squaredNorm() / static_cast<double>(turns.cols() - 1))
              .cwiseSqrt());
}

void add_directions(const std::vector<Visit>& visits, PoseFigures& figures) {
  std::map<Direction, std::vector<Visit>> from;
  for (const Visit& visit : visits)
    if (visit.arrival != Direction{}) from[visit.arrival].push_back(visit);
  figures.directions = static_cast<int>(from.size());
  std::vector<Eigen::Vector3d> means, turns;
  for (const auto& [direction, group] : from)
    if (group.size() >= 2) {
      means.push_back(mean_of(group, &Visit::attained));
      turns.push_back(mean_of(group, &Visit::turn_error));
    }
  if (means.size() < 2) return;
  figures.vap = 0.0;
  for (const Eigen::Vector3d& a : means)
    for (const Eigen::Vector3d& b : means)
      figures.vap = std::max(*figures.vap, resolved((a - b).norm(), a.norm()));
  if (!visits.front().orientation) return;
  figures.vap_turn = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& a : turns)
    for (const Eigen::Vector3d& b : turns)
      figures.vap_turn = figures.vap_turn->cwiseMax(resolved_turn((a - b).cwiseAbs()));
}

void add_drift(std::vector<Visit> visits, PoseFigures& figures) {
  if (visits.size() < 4 || !visits.front().time_s) return;
  std::ranges::stable_sort(visits, {}, [](const Visit& visit) { return *visit.time_s; });
  const std::ptrdiff_t half = visits.size() / 2;
  const std::vector<Visit> first(visits.begin(), visits.begin() + half);
  const std::vector<Visit> last(visits.end() - half, visits.end());
  const double size = mean_of(visits, &Visit::attained).norm();
  figures.drift_ap = resolved(
      std::abs(mean_of(last, &Visit::error).norm() - mean_of(first, &Visit::error).norm()), size);
  figures.drift_rp = std::abs(repeatability(last).rp - repeatability(first).rp);
  if (!visits.front().orientation) return;
  figures.drift_ap_turn = resolved_turn(
      (mean_of(last, &Visit::turn_error) - mean_of(first, &Visit::turn_error)).cwiseAbs());
  figures.drift_rp_turn = (turn_repeatability(last) - turn_repeatability(first)).cwiseAbs();
}

// Pose, session and reflector: one point to which the robot returns.
using Place = std::array<int, 3>;

std::string label(const Campaign& campaign, int row) {
  std::string text = campaign.pose_ids[campaign.pose[row]];
  if (!campaign.target.empty()) text += ", " + campaign.target_names[campaign.target[row]];
  if (campaign.session_names.size() > 1)
    text += ", session " + campaign.session_names[campaign.session[row]];
  return text;
}

Visit visit_of(const Campaign& campaign, const Evaluation& evaluation, int row) {
  const auto& residual = evaluation.residuals[row];
  Visit visit;
  visit.attained = campaign.position[row];
  visit.error = residual.head<3>();
  if (campaign.has_orientation()) {
    visit.orientation = campaign.orientation[row].toRotationMatrix();
    visit.turn_error = residual.tail<3>();
  }
  if (!campaign.arrival.empty()) visit.arrival = campaign.arrival[row];
  if (!campaign.time_s.empty()) visit.time_s = campaign.time_s[row];
  visit.q = campaign.q[row];
  return visit;
}

void take_larger(std::optional<Largest>& largest, const std::optional<double>& value,
                 const std::string& pose) {
  if (value && (!largest || *value > largest->value)) largest = {*value, pose};
}

std::optional<double> largest_turn(const std::optional<Eigen::Vector3d>& turn) {
  if (!turn) return std::nullopt;
  return turn->cwiseAbs().maxCoeff();
}

}  // namespace

double resolved(double spread, double size) {
  constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
  return spread > kRounding * size ? spread : 0;
}

std::array<double, 2> repeatability_ci95(double repeatability, int n, Eigen::Index places,
                                         const Eigen::Matrix3d& squares) {
  if (repeatability == 0) return {0, 0};
  constexpr int kDraws = 20000;
  constexpr double kTail = 0.025;
  // Axes that are independent of each other, and as wide as the visits along them.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(squares);
  const Eigen::Vector3d width = axes.eigenvalues().cwiseMax(0).cwiseSqrt();
  Random random(1);
  const auto draw = [&] { return Eigen::Vector3d(width.cwiseProduct(random.normal3())); };
  const auto mean_and_three_deviations = [](const Eigen::VectorXd& l) {
    const double size = static_cast<double>(l.size());
    return l.mean() + 3 * std::sqrt((l.array() - l.mean()).square().sum() / (size - 1));
  };
  Eigen::VectorXd many(kDraws);
  for (double& length : many) length = draw().norm();
  std::vector<double> of_few;
  Eigen::Matrix3Xd visits(3, n);
  for (int k = 0; k < kDraws; ++k) {
    for (auto visit : visits.colwise()) visit = draw();
    const Eigen::Vector3d mean = visits.rowwise().mean();
    of_few.push_back(mean_and_three_deviations((visits.colwise() - mean).colwise().norm()));
  }
  std::ranges::sort(of_few);
  const auto quantile = [&](double share) {
    return of_few[std::min<size_t>(static_cast<size_t>(share * kDraws), kDraws - 1)];
  };
  const double most = quantile(std::pow(1 - kTail, 1 / static_cast<double>(places)));
  const double scale = repeatability * mean_and_three_deviations(many);
  return {scale / most, scale / quantile(kTail)};
}

PoseFigures pose_figures(const std::string& pose, const std::vector<Visit>& visits) {
  if (visits.size() < 2) throw std::invalid_argument("pose " + pose + " has fewer than two visits");
  PoseFigures figures;
  figures.pose = pose;
  figures.visits = static_cast<int>(visits.size());
  figures.q = visits.front().q;
  figures.ap_axes = mean_of(visits, &Visit::error);
  figures.ap = figures.ap_axes.norm();
  const Repeatability repeats = repeatability(visits);
  figures.rp = repeats.rp;
  figures.squared_scatter = repeats.squares.trace();
  figures.squares = repeats.squares;
  if (visits.front().orientation) {
    figures.ap_turn = mean_of(visits, &Visit::turn_error);
    figures.rp_turn = turn_repeatability(visits);
  }
  add_directions(visits, figures);
  add_drift(visits, figures);
  return figures;
}

CampaignFigures figures_of(const Campaign& campaign, const Evaluation& evaluation) {
  if (campaign.reads_one_number())
    throw std::invalid_argument("pose accuracy needs points, x_mm, y_mm and z_mm, in all rows");
  const std::vector<int> order = campaign.pose_by_id();
  std::map<Place, std::vector<Visit>> visits;
  std::map<Place, std::string> names;
  // A stay: rows without another pose between them, whatever their reflector.
  int stay = 0;
  std::map<Place, int> last_stay;
  std::map<Place, bool> left;
  for (int row = 0; row < campaign.rows(); ++row) {
    const Place place{order[row], campaign.target.empty() ? 0 : campaign.target[row],
                      campaign.session.empty() ? 0 : campaign.session[row]};
    visits[place].push_back(visit_of(campaign, evaluation, row));
    names.emplace(place, label(campaign, row));
    if (row > 0 && campaign.pose[row] != campaign.pose[row - 1]) ++stay;
    left.emplace(place, true);
    if (const auto [last, is_first] = last_stay.emplace(place, stay); !is_first) {
      if (last->second == stay) left[place] = false;
      last->second = stay;
    }
  }
  CampaignFigures result;
  for (const auto& [place, list] : visits) {
    if (!left[place]) result.not_left.push_back(names[place]);
    if (list.size() >= 2)
      result.poses.push_back(pose_figures(names[place], list));
    else
      result.single.push_back(names[place]);
  }
  return result;
}

SetFigures largest_of(const std::vector<PoseFigures>& poses) {
  if (poses.empty()) throw std::invalid_argument("there are no poses");
  SetFigures set;
  set.poses = static_cast<int>(poses.size());
  set.fewest_visits = poses.front().visits;
  set.ap.value = set.rp.value = -1;
  int visits = 0;  // of the pose with the largest RP
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const PoseFigures& figures : poses) {
    set.fewest_visits = std::min(set.fewest_visits, figures.visits);
    if (figures.ap > set.ap.value) set.ap = {figures.ap, figures.pose};
    squares += figures.squares;
    if (figures.rp > set.rp.value) {
      set.rp = {figures.rp, figures.pose};
      visits = figures.visits;
    }
    take_larger(set.ap_turn, largest_turn(figures.ap_turn), figures.pose);
    take_larger(set.rp_turn, largest_turn(figures.rp_turn), figures.pose);
    take_larger(set.vap, figures.vap, figures.pose);
    take_larger(set.drift_ap, figures.drift_ap, figures.pose);
    take_larger(set.drift_rp, figures.drift_rp, figures.pose);
    take_larger(set.vap_turn, largest_turn(figures.vap_turn), figures.pose);
    take_larger(set.drift_ap_turn, largest_turn(figures.drift_ap_turn), figures.pose);
    take_larger(set.drift_rp_turn, largest_turn(figures.drift_rp_turn), figures.pose);
  }
  if (visits > 2)
    set.rp_ci95 = repeatability_ci95(set.rp.value, visits, std::ssize(poses), squares);
  return set;
}

Scatter scatter_of(const std::vector<PoseFigures>& poses) {
  double squares = 0, freedom = 0;
  for (const PoseFigures& figures : poses) {
    squares += figures.squared_scatter;
    freedom += 3.0 * (figures.visits - 1);
  }
  if (freedom <= 0) throw std::invalid_argument("there are no repeated visits");
  return {std::sqrt(squares / freedom), freedom};
}

}  // namespace armtrue
