#include "armtrue/path/joint_path.h"

#include <cmath>
#include <cstdio>

#include "armtrue/effects/sampling.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/inverse.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

// Largest distance of a position from that at the angles of the path [m]; above it the angles are
// those of another robot.
constexpr double kMaxDisagreement = 10e-3;
constexpr int kStarts = 64;  // enough to find each of the eight branches of an arm

std::string text(double value, const char* unit) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.3f %s", value, unit);
  return buffer;
}

std::string degrees(double angle) { return text(angle / kDegree, "deg"); }

// What states the branch of the first sample, for messages.
std::string branch_by(const JointPathOptions& options, const std::string& columns) {
  return "start on another branch (" +
         (options.start_option.empty() ? "the columns " + columns : options.start_option) + ")";
}

Eigen::Matrix3d orientation_at(const Path& path, const ChainEvaluator& chain,
                               const JointPathOptions& options, Eigen::Index i,
                               const std::string& columns) {
  if (path.has_orientation())
    return rotation_from_abc(path.orientation(0, i), path.orientation(1, i),
                             path.orientation(2, i));
  if (options.orientation) return *options.orientation;
  if (path.has_joints()) return chain.pose(path.q.col(i)).rotation;
  if (options.start) return chain.pose(*options.start).rotation;
  throw UnreachableSample(
      i, "states neither an orientation (a_deg, b_deg, c_deg) nor joint angles (" + columns +
             "); add these or those columns to the path" +
             (options.start_option.empty()
                  ? ""
                  : ", or give " + options.orientation_option + ", or " + options.start_option +
                        " with joint angles near its first sample"));
}

void check_own_angles(const Path& path, const ChainEvaluator& chain, Eigen::Index i,
                      const std::string& columns) {
  const double apart = (chain.pose(path.q.col(i)).translation - path.position.col(i)).norm();
  if (apart > kMaxDisagreement)
    throw UnreachableSample(
        i, "its joint angles put the tool " + text(apart / kMillimetre, "mm") +
               " away from its position; the angles belong to another robot, base or tool: give "
               "the robot file they were made with, or take the columns " +
               columns + " out");
}

void check_travel(const KinematicChain& chain, const JointVector& q, Eigen::Index i,
                  const std::string& branch) {
  const std::optional<BeyondTravel> beyond = beyond_travel(chain, q);
  if (!beyond) return;
  const Link& link = chain.links[beyond->link];
  const auto shown = [&](double value) {
    return is_prismatic(link) ? text(value / kMillimetre, "mm") : degrees(value);
  };
  throw UnreachableSample(i, "joint " + link.name + " would stand at " + shown(beyond->value) +
                                 ", outside its travel of " + shown(link.min) + " to " +
                                 shown(link.max) + "; move the part, turn the tool or " + branch);
}

JointVector first_angles(const Path& path, const KinematicChain& chain, const Pose& wanted,
                         const JointPathOptions& options) {
  if (options.start) return *options.start;
  if (path.has_joints()) return path.q.col(0);
  const auto q = inverse_kinematics(chain, wanted, sample_joint_space(chain, kStarts));
  if (!q)
    throw UnreachableSample(
        0,
        "cannot be reached with this orientation within the travel of the joints; move the "
        "part or turn the tool");
  return *q;
}

}  // namespace

JointMatrix joint_path(const Path& programmed, const KinematicChain& chain,
                       const JointPathOptions& options) {
  const ChainEvaluator evaluator(chain);
  const std::string columns = encoder_columns(chain), branch = branch_by(options, columns);
  JointMatrix angles(joint_count(chain), programmed.samples());
  for (Eigen::Index i = 0; i < programmed.samples(); ++i) {
    if (programmed.has_joints()) check_own_angles(programmed, evaluator, i, columns);
    const Pose wanted{orientation_at(programmed, evaluator, options, i, columns),
                      programmed.position.col(i)};
    const JointVector start =
        i > 0 ? JointVector(angles.col(i - 1)) : first_angles(programmed, chain, wanted, options);
    const InverseResult found = inverse_kinematics(chain, wanted, start);
    if (!found.reached)
      throw UnreachableSample(i,
                              "cannot be reached with this orientation; the nearest the robot "
                              "comes is " +
                                  text(found.position_error / kMillimetre, "mm") + " and " +
                                  degrees(found.orientation_error) +
                                  " away; move the part, turn the tool or " + branch);
    check_travel(chain, found.q, i, branch);
    angles.col(i) = found.q;
  }
  return angles;
}

}  // namespace armtrue
