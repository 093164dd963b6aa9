#include "certification/visit_step.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

using Eigen::Index;

// Visits that are no random sample of their pose's scatter look like a step more often than F says.
constexpr double kChanceOfStep = 1e-8;
constexpr double kShareThatMatters = 0.5;  // of the squares
constexpr double kFewestInPart = 0.1;      // of the visits, on either side
constexpr size_t kFewestPlaces = 2;        // of one, the arm itself may have moved

// A visit with the residual of its place's mean taken off.
struct VisitInTime {
  int row;
  size_t place;
  double time;  // in the order of the visits, from 0 to 1
  Eigen::Vector3d residual;
};

std::vector<VisitInTime> visits_in_order(const Campaign& campaign, const Evaluation& evaluation,
                                         const std::vector<std::vector<int>>& places) {
  std::vector<VisitInTime> visits;
  for (size_t place = 0; place < places.size(); ++place) {
    const auto residual = [&](int row) -> Eigen::Vector3d {
      return evaluation.residuals[row].head<3>();
    };
    const Eigen::Vector3d mean = mean_of(places[place], residual);
    for (const int row : places[place]) {
      const double time = campaign.time_s.empty() ? campaign.line[row] : campaign.time_s[row];
      visits.push_back({row, place, time, residual(row) - mean});
    }
  }
  std::ranges::stable_sort(visits, {}, &VisitInTime::time);
  const double first = visits.front().time, last = visits.back().time;
  for (VisitInTime& visit : visits)
    visit.time = last > first ? (visit.time - first) / (last - first) : 0;
  return visits;
}

// What a cause moves at each place: three rows, a column for each unknown.
struct Cause {
  const char* words;
  std::vector<Eigen::Matrix3Xd> columns;
  Index unknowns() const { return columns.front().cols(); }
};

std::vector<Cause> causes_of(const Robot& robot, const Campaign& campaign,
                             const std::vector<std::vector<int>>& places) {
  Robot geometry = robot;  // turns the tool well enough, and needs no measured driver
  geometry.effects.clear();
  const RobotModel model(geometry);
  Cause shift{"the instrument or the foot of the robot", {}},
      frame = shift, reflector{"the reflector or the tool", {}};
  const Eigen::Vector3d middle =
      mean_of(places, [&](const auto& rows) { return campaign.position[rows.front()]; });
  for (const auto& rows : places) {
    const size_t row = rows.front();
    shift.columns.emplace_back(Eigen::Matrix3d::Identity());
    Eigen::Matrix3Xd moved(3, 6);
    moved << Eigen::Matrix3d::Identity(), -cross_matrix(campaign.position[row] - middle);
    frame.columns.push_back(moved);
    reflector.columns.emplace_back(model.pose(campaign.context(rows.front())).rotation);
  }
  std::vector<Cause> causes{shift, reflector};
  constexpr size_t kOfAFrame = 4;  // three places determine a frame, a fourth contradicts it
  if (places.size() >= kOfAFrame) causes.push_back(frame);
  return causes;
}

// Fall of the squares by shapes of time, each times the columns of a cause; the mean of a place
// takes its part of a shape.
struct Fall {
  double squares = 0;
  Eigen::VectorXd value;
};

Fall fall_by(const Cause& cause, const std::vector<VisitInTime>& visits,
             const Eigen::MatrixXd& shapes) {
  const Index unknowns = cause.unknowns(), count = shapes.cols();
  const size_t places = cause.columns.size();
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(places, count);
  Eigen::VectorXd of_place = Eigen::VectorXd::Zero(places);
  for (size_t i = 0; i < visits.size(); ++i) {
    mean.row(visits[i].place) += shapes.row(i);
    of_place[visits[i].place] += 1;
  }
  mean.array().colwise() /= of_place.array();
  std::vector<Eigen::MatrixXd> gram(places, Eigen::MatrixXd::Zero(count, count));
  std::vector<Eigen::Matrix3Xd> on(places, Eigen::Matrix3Xd::Zero(3, count));
  for (size_t i = 0; i < visits.size(); ++i) {
    const size_t place = visits[i].place;
    const Eigen::RowVectorXd shape = shapes.row(i) - mean.row(place);
    gram[place] += shape.transpose() * shape;
    on[place] += visits[i].residual * shape;
  }
  const Index size = unknowns * count;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  for (size_t place = 0; place < places; ++place) {
    const Eigen::Matrix3Xd& columns = cause.columns[place];
    const Eigen::MatrixXd own = columns.transpose() * columns;
    for (Index a = 0; a < count; ++a) {
      right.segment(a * unknowns, unknowns) += columns.transpose() * on[place].col(a);
      for (Index b = 0; b < count; ++b)
        normal.block(a * unknowns, b * unknowns, unknowns, unknowns) += gram[place](a, b) * own;
    }
  }
  const Eigen::VectorXd value =
      Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(normal).solve(right);
  return {right.dot(value), value};
}

// What is left by the drift of the same cause that explains most.
double left_by_drift(const Cause& cause, const std::vector<VisitInTime>& visits, double all) {
  const Index rows = visits.size();
  Eigen::VectorXd time(rows);
  for (Index i = 0; i < rows; ++i) time[i] = visits[i].time;
  Eigen::MatrixXd cubic(rows, 3);
  cubic << time, time.cwiseAbs2(), time.array().cube().matrix();
  double most = fall_by(cause, visits, cubic).squares;
  for (const double constant : {0.02, 0.05, 0.1, 0.2})  // of the campaign
    most =
        std::max(most, fall_by(cause, visits, (-time.array() / constant).exp().matrix()).squares);
  return all - most;
}

struct Step {
  const Cause* cause = nullptr;
  size_t first = 0;  // visit behind it
  Fall fall;
  double p_value = 1;
};

Step best_step(const std::vector<Cause>& causes, const std::vector<VisitInTime>& visits,
               double all) {
  constexpr size_t kMostTimes = 200;  // that are tried
  const size_t least = std::max<size_t>(
      2, static_cast<size_t>(std::ceil(kFewestInPart * static_cast<double>(visits.size()))));
  const size_t stride = visits.size() / kMostTimes + 1;
  Step best;
  int tried = 0;
  const auto p_value = [&](const Cause& cause, double fall) {
    const auto unknowns = static_cast<double>(cause.unknowns());
    const double freedom = 3 * static_cast<double>(visits.size() - cause.columns.size()) - unknowns;
    if (freedom < 1 || fall >= all) return 1.0;
    return fisher_f_above(fall / unknowns * freedom / (all - fall), unknowns, freedom);
  };
  const auto look = [&](size_t first) {
    if (first < least || first + least > visits.size() ||
        visits[first].time == visits[first - 1].time)
      return;
    Eigen::VectorXd later = Eigen::VectorXd::Zero(visits.size());
    later.tail(visits.size() - first).setOnes();
    for (const Cause& cause : causes) {
      ++tried;
      const Fall fall = fall_by(cause, visits, later);
      const double p = p_value(cause, fall.squares);
      if (p < best.p_value) best = {&cause, first, fall, p};
    }
  };
  for (size_t first = least; first + least <= visits.size(); first += stride) look(first);
  if (best.cause && stride > 1)
    for (size_t first = best.first - std::min(best.first, stride), end = best.first + stride;
         first < end; ++first)
      look(first);
  best.p_value *= tried;
  return best;
}

// The longest step at a place [m].
double size_of(const Step& step) {
  double longest = 0;
  for (const Eigen::Matrix3Xd& columns : step.cause->columns)
    longest = std::max(longest, (columns * step.fall.value).norm());
  return longest;
}

}  // namespace

std::optional<std::string> find_visit_step(const Robot& robot, const Campaign& campaign,
                                           const Evaluation& evaluation,
                                           const std::vector<std::vector<int>>& places) {
  if (places.size() < kFewestPlaces) return std::nullopt;
  const std::vector<VisitInTime> visits = visits_in_order(campaign, evaluation, places);
  double all = 0;
  for (const VisitInTime& visit : visits) all += visit.residual.squaredNorm();
  if (all == 0) return std::nullopt;
  const std::vector<Cause> causes = causes_of(robot, campaign, places);
  const Step step = best_step(causes, visits, all);
  if (!step.cause || step.p_value >= kChanceOfStep || step.fall.squares < kShareThatMatters * all ||
      left_by_drift(*step.cause, visits, all) <= all - step.fall.squares)
    return std::nullopt;
  const size_t row = visits[step.first].row;
  const std::string from =
      campaign.time_s.empty()
          ? fmt::format("line {}", campaign.line[row])
          : fmt::format("t_s = {:.10g} (line {})", campaign.time_s[row], campaign.line[row]);
  return fmt::format(
      "from {} on, the visits stand up to {:.3g} mm beside the earlier ones of their poses, all by "
      "one motion of {}; it makes {:.0f} % of the squares of their scatter: was it knocked? RP and "
      "AP contain this step; measure the poses again, or certify the visits before it and behind "
      "it apart",
      from, size_of(step) / kMillimetre, step.cause->words, 100 * step.fall.squares / all);
}

}  // namespace armtrue
