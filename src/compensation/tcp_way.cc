#include "compensation/tcp_way.h"

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"
#include "compensation/joint_correction.h"

namespace armtrue {
namespace {

// The number of waypoints of a way. They stand at 1 - (1 - k / n)^2 of it, the last two n^-2 apart.
int count_of_waypoints(const TcpWay& part) {
  constexpr double kLengthOfOne = 1e-2, kTurnOfOne = 1 * kDegree;
  constexpr double kFewest = 4, kMost = 32;
  const Pose start = part.way.at(part.from), end = part.way.at(part.to);
  const double length = (part.to - part.from) * part.way.length();
  const double turn = rotation_log(start.rotation.transpose() * end.rotation).norm();
  return static_cast<int>(
      std::clamp(std::ceil(std::max(length / kLengthOfOne, turn / kTurnOfOne)), kFewest, kMost));
}

}  // namespace

ProgramMotion motion_to(const Program& program, size_t row) {
  return row < program.motions.size() ? program.motions[row] : ProgramMotion{};
}

std::optional<JointVector> joints_on(const ProgramArm& controller, const Program& program,
                                     const Context& context, const Way& way, double t,
                                     const JointsOfEnds& ends, double share, JointVector near) {
  if (program.states_external) {
    const ProgramJoints& joints = controller.program_joints();
    joints.move_external(near, ends.from);
    joints.move_external(near, ends.to, share);
  }
  const JointCorrection found = joints_of_pose(controller, context, way.at(t), near);
  return found.is_reached ? std::optional(found.q) : std::nullopt;
}

std::vector<Waypoint> waypoints(const ProgramArm& controller, const Program& program,
                                const Context& context, const TcpWay& part,
                                const JointsOfEnds& ends) {
  constexpr double kSame = 0.1 * kDegree;  // [rad or m]
  const std::vector<Waypoint> row_alone{{1, ends.to}};
  const int count = count_of_waypoints(part);
  std::vector<Waypoint> found;
  JointVector q = ends.from;
  for (int k = 1; k <= count; ++k) {
    const double left = 1 - static_cast<double>(k) / count;
    const double share = 1 - left * left;
    const double t = part.from + share * (part.to - part.from);
    const auto here = joints_on(controller, program, context, part.way, t, ends, share, q);
    if (!here) return row_alone;
    q = *here;
    found.push_back({share, q});
  }
  if ((q - ends.to).cwiseAbs().maxCoeff() > kSame) return row_alone;
  found.back().q = ends.to;
  return found;
}

}  // namespace armtrue
