#include "armtrue/campaign/split.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "armtrue/kinematics/evaluator.h"
#include "linear_algebra/decompositions.h"
#include "statistics/shuffle.h"

namespace armtrue {
namespace {

Split without_poses(const std::vector<int>& pose_of_row, const std::set<int>& held_out) {
  Split split;
  for (int row = 0; row < std::ssize(pose_of_row); ++row)
    (held_out.contains(pose_of_row[row]) ? split.held_out : split.training).push_back(row);
  return split;
}

}  // namespace

Split split_by_pose(const Campaign& campaign, double share, std::uint64_t seed) {
  const std::vector<int> pose = campaign.pose_by_id();
  std::map<int, std::set<int>> sessions_of;
  for (int row = 0; row < campaign.rows(); ++row)
    sessions_of[pose[row]].insert(campaign.session.empty() ? 0 : campaign.session[row]);
  std::map<int, double> all, taken;  // poses by session
  std::vector<int> poses;
  for (const auto& [id, sessions] : sessions_of) {
    poses.push_back(id);
    for (int session : sessions) ++all[session];
  }
  shuffle(poses, seed);
  const double most = std::max(1.0 / 3, share);
  const auto leaves_enough = [&](int session) { return taken[session] + 1 <= most * all[session]; };
  std::set<int> held_out;
  for (int id : poses) {
    if (std::ssize(held_out) == std::lround(share * static_cast<double>(poses.size()))) break;
    const std::set<int>& sessions = sessions_of[id];
    if (all.size() > 1 && !std::ranges::all_of(sessions, leaves_enough)) continue;
    for (int session : sessions) ++taken[session];
    held_out.insert(id);
  }
  return without_poses(pose, held_out);
}

Split split_by_region(const Robot& robot, const Campaign& campaign, double share,
                      std::uint64_t seed) {
  const std::vector<int> pose = campaign.pose_by_id();
  const ChainEvaluator chain(robot.chain);
  std::map<int, Eigen::Vector3d> point_of_pose;
  for (int row = 0; row < campaign.rows(); ++row)
    point_of_pose.try_emplace(pose[row], chain.pose(campaign.q[row]).translation);
  const auto poses = static_cast<double>(point_of_pose.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& [id, point] : point_of_pose) mean += point / poses;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& [id, point] : point_of_pose)
    scatter += (point - mean) * (point - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{Eigen::MatrixXd(scatter)};
  const Eigen::Index choice = (seed + 5) % 6;
  Eigen::Vector3d direction = eigen.eigenvectors().col(2 - choice / 2);
  // The sign of an eigenvector is arbitrary.
  Eigen::Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  if ((direction[largest] < 0) != (choice % 2 == 1)) direction = -direction;
  std::vector<std::pair<double, int>> along;
  for (const auto& [id, point] : point_of_pose)
    along.emplace_back(-direction.dot(point - mean), id);
  std::sort(along.begin(), along.end());
  along.resize(std::lround(share * poses));
  std::set<int> held_out;
  for (const auto& [distance, id] : along) held_out.insert(id);
  return without_poses(pose, held_out);
}

}  // namespace armtrue
