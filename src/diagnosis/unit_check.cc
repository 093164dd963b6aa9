#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/diagnosis/log_check.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr int kFewestRows = 5;

struct Angles {
  double farthest = 0, widest = 0;  // from zero, and from row to row [rad]
  size_t joint = 0;                 // of the farthest one
  int turning = 0;                  // joints that turn
};

Angles angles_of(const Campaign& campaign, const std::vector<JointName>& joints) {
  constexpr double kTurns = 1e-3;  // rad; less is a joint that stands
  Angles angles;
  for (size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].is_length) continue;
    double low = campaign.q[0][j], high = low;
    for (const JointVector& q : campaign.q) {
      low = std::min(low, q[j]);
      high = std::max(high, q[j]);
    }
    angles.turning += high - low > kTurns;
    angles.widest = std::max(angles.widest, high - low);
    if (const double most = std::max(-low, high); most > angles.farthest) {
      angles.farthest = most;
      angles.joint = j;
    }
  }
  return angles;
}

// The diagonal of the box around the points [m].
double extent_of(const Campaign& campaign) {
  Eigen::Vector3d low = campaign.position[0], high = low;
  for (const Eigen::Vector3d& point : campaign.position) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  return (high - low).norm();
}

}  // namespace

std::vector<std::string> check_units(const Campaign& campaign,
                                     const std::vector<JointName>& joints) {
  constexpr double kMostTurns = 4 * 2 * std::numbers::pi, kRadians = 2 * std::numbers::pi * kDegree;
  constexpr double kLargest = 50, kSmallest = 0.01;  // m: an arm on a long rail; a fixed point
  constexpr double kMoves = 10 * kDegree;
  constexpr int kBent = 3;
  std::vector<std::string> doubts;
  if (campaign.rows() < kFewestRows || campaign.q[0].size() < std::ssize(joints)) return doubts;
  const Angles angles = angles_of(campaign, joints);
  if (angles.farthest > kMostTurns)
    doubts.push_back(fmt::format(
        "{}_deg reaches {:.4g} deg, {:.3g} turns: is the unit of the joint angles right?",
        joints[angles.joint].column, angles.farthest / kDegree,
        angles.farthest / (2 * std::numbers::pi)));
  const bool are_radians = angles.turning >= kBent && angles.farthest <= kRadians;
  if (are_radians)
    doubts.push_back(fmt::format("all joint angles lie within {:.3g} deg of zero: are they in rad?",
                                 angles.farthest / kDegree));
  if (campaign.position.empty()) return doubts;
  const double extent = extent_of(campaign);
  if (extent > kLargest)
    doubts.push_back(
        fmt::format("the points lie up to {:.3g} m from each other, farther than arms "
                    "reach: is the unit of their lengths right?",
                    extent));
  if (extent < kSmallest && angles.widest > kMoves)
    doubts.push_back(fmt::format(
        "the points lie within {:.3g} mm of each other, while a joint turns by {:.3g} deg: is the "
        "unit of their lengths right?",
        extent / kMillimetre, angles.widest / kDegree));
  return doubts;
}

}  // namespace armtrue
