#include "armtrue/campaign/turns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"

namespace armtrue {
namespace {

// Further outside its stated travel no arm stands: stops are some degrees beyond the limits of the
// software, and limits in files are rounded.
constexpr double kFarOutside = 30 * kDegree;
// What the span of readings within one turn may grow by chance when it is cut elsewhere: the
// distance between neighbours among some tens of readings.
constexpr double kNeighbours = 20 * kDegree;
constexpr double kSamePlace = 0.1 * kDegree;  // as of replicates

double outside(double q, const std::array<double, 2>& travel) {
  return std::max({travel[0] - q, q - travel[1], 0.0});
}

// A turn nearer to the middle of the travel. Two ways to count one turn differ by no more: angles
// that are further away are an error of the export.
double nearer_to_middle(double q, const std::array<double, 2>& travel) {
  const double turns = std::round((q - 0.5 * (travel[0] + travel[1])) / kTurn);
  return q - kTurn * std::clamp(turns, -1.0, 1.0);
}

// The values of one joint.
struct Angles {
  int joint;
  std::array<double, 2> travel;
  std::vector<double> given, moved;

  static double span(const std::vector<double>& values) {
    const auto [least, largest] = std::ranges::minmax(values);
    return largest - least;
  }

  bool count_one_turn() const {
    if (span(given) > kTurn + kSamePlace) return false;
    for (size_t k = 0; k < given.size(); ++k)
      if (outside(given[k], travel) > kFarOutside && outside(moved[k], travel) == 0) return true;
    return false;
  }
};

Angles angles_of(const JointRows& q, int joint, const Link& link) {
  Angles angles{joint, travel(link), {}, {}};
  angles.given.reserve(q.size());
  angles.moved.reserve(q.size());
  for (const auto& values : q) {
    const double given = values[joint];
    angles.given.push_back(given);
    const double moved = nearer_to_middle(given, angles.travel);
    const bool moves = outside(given, angles.travel) > 0 && outside(moved, angles.travel) == 0;
    angles.moved.push_back(moves ? moved : given);
  }
  return angles;
}

bool states_travel(const Link& link) { return std::isfinite(link.min) && std::isfinite(link.max); }

// The values that become those of the first reading of their pose.
void join_poses(const std::vector<int>& pose, Angles& angles) {
  std::vector<double> first;  // of each pose; NaN before it is read
  for (size_t k = 0; k < pose.size(); ++k) {
    const size_t number = pose[k];
    if (number >= first.size()) first.resize(number + 1, std::nan(""));
    double &value = angles.moved[k], &reference = first[number];
    if (std::isnan(reference)) reference = value;
    const double turns = kTurn * std::round((value - reference) / kTurn);
    if (std::abs(value - turns - reference) < kSamePlace) value -= turns;
  }
}

}  // namespace

bool is_within_one_turn(const Link& link) {
  if (link.joint != JointKind::revolute) return false;
  const auto [least, largest] = travel(link);
  return largest - least <= kTurn + kSamePlace;
}

std::vector<MovedByTurns> move_into_travel(JointRows& q, const std::vector<int>& pose,
                                           const KinematicChain& chain) {
  if (q.empty()) return {};
  std::vector<int> joints;
  for (int j = 0; j < joint_count(chain); ++j)
    if (joint_link(chain, j).joint == JointKind::revolute) joints.push_back(j);
  // A controller counts all its joints alike, so those without a stated travel are judged together;
  // one after another, as the angles of many readings take much memory.
  double grows = 0;
  for (int j : joints) {
    if (states_travel(joint_link(chain, j))) continue;
    const Angles angles = angles_of(q, j, joint_link(chain, j));
    if (angles.count_one_turn())
      grows += Angles::span(angles.moved) - Angles::span(angles.given) - kNeighbours;
  }
  std::vector<MovedByTurns> result;
  for (int j : joints) {
    const Link& link = joint_link(chain, j);
    Angles angles = angles_of(q, j, link);
    if (!angles.count_one_turn() || (!states_travel(link) && grows > 0))
      angles.moved = angles.given;
    if (is_within_one_turn(link)) join_poses(pose, angles);
    MovedByTurns moved{angles.joint};
    for (size_t k = q.size(); k-- > 0;) {
      if (angles.moved[k] == angles.given[k]) continue;
      ++moved.rows;
      moved.first = static_cast<int>(k);
      moved.as_given = angles.given[k];
      moved.as_read = angles.moved[k];
      q[k][angles.joint] = angles.moved[k];
    }
    if (moved.rows > 0) result.push_back(moved);
  }
  return result;
}

std::string moved_text(const std::vector<MovedByTurns>& moved, const std::vector<JointName>& joints,
                       const std::vector<int>& lines) {
  std::string names;
  int rows = 0;
  for (const MovedByTurns& of_joint : moved) {
    names += (names.empty() ? "" : ", ") + joints[of_joint.joint].column;
    rows += of_joint.rows;
  }
  const MovedByTurns& example = moved.front();
  return fmt::format(
      "{} of {} read a whole turn nearer to the travel of the joint, as in line {} "
      "{:.7g} deg as {:.7g} deg; the travel is that of the robot file, +-180 deg where it states "
      "none",
      counted(rows, "angle"), names, lines[example.first], example.as_given / kDegree,
      example.as_read / kDegree);
}

}  // namespace armtrue
