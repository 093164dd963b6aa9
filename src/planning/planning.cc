#include "armtrue/planning/planning.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/observation/fold.h"
#include "armtrue/observation/session_models.h"
#include "linear_algebra/decompositions.h"
#include "planning/choose_by_exchange.h"
#include "planning/information.h"

namespace armtrue {
namespace {

constexpr int kDrawsForZone = 200000;  // forward kinematics is cheap, and a zone is small

}  // namespace

PosePlanner::PosePlanner(const Robot& robot, const PlanOptions& options, const Campaign& given)
    : zone_(options.zone), cloud_(pose_cloud(robot, options, given)) {
  given_ = given_derivatives(cloud_, cloud_.robot);
  cloud_position_ = position_triangle(configurations(cloud_.poses));
  if (zone_) zone_position_ = position_triangle(zone_configurations());
}

std::vector<JointVector> PosePlanner::zone_configurations() const {
  const Robot& robot = cloud_.robot;
  const ChainEvaluator evaluator(robot.chain);
  std::vector<JointVector> drawn =
      random_configurations(robot, kDrawsForZone, std::nullopt, cloud_.options.seed);
  std::erase_if(drawn, [&](const JointVector& q) {
    return (evaluator.pose(q).translation - zone_->centre).norm() > zone_->radius ||
           !is_above_floor(cloud_, q);
  });
  if (drawn.empty())
    throw std::invalid_argument(
        "no configuration within the travel limits and above the floor has its point in the zone; "
        "enlarge or move the zone (its centre is in the instrument's frame)");
  return drawn;
}

namespace {

// A triangle of the whitened derivatives of all readings.
Eigen::MatrixXd triangle(const SessionModels& models) {
  const int p = models.unknowns();
  std::vector<Eigen::MatrixXd> factors;
  for (int g = 0; g < models.groups(); ++g) {
    const ObservationModel& model = models.model(g);
    factors.push_back(
        fold(model.at(Eigen::VectorXd::Zero(model.unknowns())), model, ReadingLaw{}).factor);
  }
  return models.join(factors).topLeftCorner(p, p);
}

}  // namespace

Eigen::MatrixXd PosePlanner::position_triangle(
    const std::vector<JointVector>& configurations) const {
  const Campaign read = points(cloud_, configurations);
  return triangle(SessionModels(read, cloud_.robot, cloud_.unknowns, {1.0, 1.0}, kAllEffects,
                                SessionModels::Split::by_target)) /
         std::sqrt(read.rows());
}

std::vector<PlannedPose> PosePlanner::plan(int count) const {
  if (count > kCloudSize)
    throw std::invalid_argument("more poses are asked for than there are candidates, " +
                                std::to_string(kCloudSize));
  // The elimination of the own parameters of earlier sessions correlates the places of targets:
  // then all unknowns are one group.
  const bool ties = rows_by_session(cloud_.given).size() > 1;
  const auto models_of = [&](const Campaign& campaign, SessionModels::Split split) {
    return SessionModels(campaign, cloud_.robot, cloud_.unknowns, sigma_of(cloud_, campaign),
                         kAllEffects, split);
  };
  const Campaign campaign = readings(cloud_, cloud_.poses);
  const SessionModels candidates = models_of(
      campaign, ties ? SessionModels::Split::by_session : SessionModels::Split::by_target);
  const UnknownGroups groups(candidates);
  GroupedDerivatives of_candidates = groups.derivatives(candidates);

  const std::vector<PlannedPose> seen = with_given(cloud_);
  const Campaign all = readings(cloud_, seen);
  const Scaling scaling(groups.triangles(models_of(all, groups.split())),
                        1 / std::sqrt(seen.size()));
  scaling.apply(of_candidates);
  GroupedDerivatives known = ties ? groups.of_one_group(given_)
                                  : groups.triangles(models_of(cloud_.given, groups.split()));
  scaling.apply(known);
  GroupedDerivatives aim;
  if (zone_) {
    const Campaign points_of_zone = points(cloud_, zone_configurations());
    aim = groups.triangles(SessionModels(points_of_zone, cloud_.robot, cloud_.unknowns, {1.0, 1.0},
                                         kAllEffects, groups.split()));
    scaling.apply(aim);
  }
  Information design(std::move(of_candidates), kCloudSize, known, aim);
  std::vector<PlannedPose> planned;
  for (int candidate : choose_by_exchange(design, kCloudSize, count))
    planned.push_back(cloud_.poses[candidate]);
  return planned;
}

std::vector<PlannedPose> PosePlanner::random(int count, std::uint64_t seed) const {
  return random_poses(cloud_, count, seed);
}

PlanQuality PosePlanner::quality(const std::vector<PlannedPose>& poses) const {
  const Campaign campaign = readings(cloud_, poses, Corners::all);
  const ReadingSigma sigma = sigma_of(cloud_, campaign);
  const Eigen::Index p = given_.cols();
  Eigen::MatrixXd rows(2 * p, p);
  rows << given_, triangle(SessionModels(campaign, cloud_.robot, cloud_.unknowns, sigma,
                                         kAllEffects, SessionModels::Split::by_target));
  const Eigen::MatrixXd all = upper_triangle(rows);

  PlanQuality quality;
  const Eigen::VectorXd s =
      sigma.position * Eigen::JacobiSVD<Eigen::MatrixXd>(all).singularValues();
  quality.observability = observability(s, cloud_.given.rows() + campaign.rows());
  const double infinity = std::numeric_limits<double>::infinity();
  if (s[p - 1] <= 1e-10 * s[0]) {
    quality.log_determinant = -infinity;
    quality.cloud_deviation = infinity;
    quality.zone_deviation = zone_ ? infinity : 0;
    return quality;
  }
  quality.log_determinant = 2 * all.diagonal().cwiseAbs().array().log().sum();
  quality.cloud_deviation = divided_by(cloud_position_, all).norm();
  quality.zone_deviation = zone_ ? divided_by(zone_position_, all).norm() : 0;
  return quality;
}

std::optional<int> PosePlanner::fewest_that_determine(int too_few, std::uint64_t seed) const {
  const auto is_enough = [&](int count) { return quality(random(count, seed)).determines_all(); };
  int enough = std::min(2 * too_few, kCloudSize);
  while (!is_enough(enough)) {
    if (enough == kCloudSize) return std::nullopt;
    too_few = enough;
    enough = std::min(2 * enough, kCloudSize);
  }
  while (enough - too_few > 1) {
    const int middle = (enough + too_few) / 2;
    (is_enough(middle) ? enough : too_few) = middle;
  }
  return enough;
}

}  // namespace armtrue
