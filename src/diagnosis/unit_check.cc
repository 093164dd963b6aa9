#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/diagnosis/log_check.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"

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

std::string in_lines(const Campaign& campaign, const std::vector<int>& rows) {
  const std::string first =
      campaign.line.empty() ? "" : fmt::format(", the first in line {}", campaign.line[rows[0]]);
  return fmt::format("{} of {} rows{}", rows.size(), campaign.rows(), first);
}

bool is_one_number(const Eigen::Vector3d& point) {
  return point.x() == point.y() && point.y() == point.z();
}

// What instruments write where they measured nothing: 0, 0, 0 or -9999, -9999, -9999.
std::string check_empty_points(const Campaign& campaign) {
  std::vector<int> rows;
  for (int row = 0; row < campaign.rows(); ++row)
    if (is_one_number(campaign.position[row])) rows.push_back(row);
  if (rows.empty()) return "";
  return fmt::format(
      "{}, have the same number in x, y and z, {:.10g} mm: was nothing measured there? Leave these "
      "cells empty",
      in_lines(campaign, rows), campaign.position[rows[0]].x() / kMillimetre);
}

// Points of one cell do not lie a hundred times nearer to the origin than all others, unless they
// are in another unit.
std::string check_mixed_lengths(const Campaign& campaign) {
  constexpr double kFarApart = 100;
  constexpr size_t kFewestMixed = 2;
  std::vector<std::pair<double, int>> far;  // from the origin, and the row
  for (int row = 0; row < campaign.rows(); ++row)
    if (!is_one_number(campaign.position[row]))
      far.emplace_back(campaign.position[row].norm(), row);
  std::ranges::sort(far);
  size_t nearer = 0;
  for (size_t k = 1; k < far.size(); ++k)
    if (far[k].first > kFarApart * far[k - 1].first) nearer = k;
  if (nearer < kFewestMixed || far.size() - nearer < kFewestMixed) return "";
  std::vector<int> rows;
  for (size_t k = 0; k < nearer; ++k) rows.push_back(far[k].second);
  std::ranges::sort(rows);
  return fmt::format(
      "{}, lie within {:.4g} mm of the origin, and all others {:.4g} mm or more from it: are these "
      "rows in m, or those in mm? Convert them to one unit",
      in_lines(campaign, rows), far[nearer - 1].first / kMillimetre,
      far[nearer].first / kMillimetre);
}

// Rows in which all joints stand within 6.3 deg of zero, at several places, among others.
std::string check_mixed_angles(const Campaign& campaign, const std::vector<JointName>& joints,
                               double most) {
  constexpr size_t kFewestMixed = 3;
  constexpr double kSamePlace = 0.1 * kDegree;
  std::vector<int> rows, places;
  const auto is_same = [&](int a, int b) {
    return (campaign.q[a] - campaign.q[b]).cwiseAbs().maxCoeff() < kSamePlace;
  };
  for (int row = 0; row < campaign.rows(); ++row) {
    double farthest = 0;
    for (size_t j = 0; j < joints.size(); ++j)
      if (!joints[j].is_length) farthest = std::max(farthest, std::abs(campaign.q[row][j]));
    if (farthest > most) continue;
    rows.push_back(row);
    if (std::ranges::none_of(places, [&](int place) { return is_same(place, row); }))
      places.push_back(row);
  }
  if (places.size() < kFewestMixed || std::ssize(rows) == campaign.rows()) return "";
  return fmt::format(
      "{}, have all joint angles within {:.3g} deg of zero, and the others do not: are these rows "
      "in rad? Convert them",
      in_lines(campaign, rows), most / kDegree);
}

// No joint turns so fast from one visit to the next, in most of them, unless the times are in
// another unit.
std::string check_speeds(const Campaign& campaign, const std::vector<JointName>& joints) {
  constexpr double kFastest = 3600 * kDegree;  // rad/s; the last joint of a small arm turns by 3000
  if (campaign.time_s.empty()) return "";
  std::vector<double> speeds;
  for (int row = 1; row < campaign.rows(); ++row) {
    const double passed = std::abs(campaign.time_s[row] - campaign.time_s[row - 1]);
    double turned = 0;
    for (size_t j = 0; j < joints.size(); ++j)
      if (!joints[j].is_length)
        turned = std::max(turned, std::abs(campaign.q[row][j] - campaign.q[row - 1][j]));
    if (passed > 0 && turned > 0) speeds.push_back(turned / passed);
  }
  if (std::ssize(speeds) < kFewestRows || median(speeds) < kFastest) return "";
  return fmt::format(
      "a joint turns by {:.3g} deg/s from row to row (median), faster than any does: is the unit "
      "of "
      "the times right?",
      median(speeds) / kDegree);
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
  const auto add = [&](const std::string& doubt) {
    if (!doubt.empty()) doubts.push_back(doubt);
  };
  if (angles.turning >= kBent) add(check_mixed_angles(campaign, joints, kRadians));
  if (angles.turning >= kBent) add(check_speeds(campaign, joints));
  if (campaign.position.empty()) return doubts;
  add(check_empty_points(campaign));
  add(check_mixed_lengths(campaign));
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
