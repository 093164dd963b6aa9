#include "urdf/urdf_patch.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "armtrue/effects/sampling.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/urdf/urdf_io.h"
#include "urdf/link_frames.h"
#include "urdf/urdf_chain.h"
#include "urdf/xml_origins.h"

namespace armtrue {
namespace {

// No calibration moves a frame of a link farther.
constexpr double kSameArm = 50 * kMillimetre, kSameArmAngle = 5 * kDegree;
constexpr double kSameOrigin = 1e-13;  // [m], of matrix entries: below the digits of a file
constexpr double kExact = 1e-9;        // [m, rad]
constexpr int kPosesChecked = 50;

double angle_between(const Pose& a, const Pose& b) {
  return Eigen::AngleAxisd(a.rotation.transpose() * b.rotation).angle();
}

// Frames of the driven links in R_A where all joint angles are 0.
std::vector<Pose> frames_at_zero(const KinematicChain& chain) {
  std::vector<Pose> frames;
  Pose frame = chain.base;
  for (const Link& link : chain.links) {
    frame = frame * link_transform(link);
    if (link.joint != JointKind::fixed) frames.push_back(frame);
  }
  return frames;
}

// The tool in the frame of the last driven link.
Pose tool_behind_joints(const KinematicChain& chain) {
  Pose tool;
  const auto first = static_cast<size_t>(link_of_joint(chain, joint_count(chain) - 1)) + 1;
  for (size_t j = first; j < chain.links.size(); ++j) tool = tool * link_transform(chain.links[j]);
  return tool * chain.tool;
}

Pose tip_at_zero(const KinematicChain& chain) {
  return frames_at_zero(chain).back() * tool_behind_joints(chain);
}

constexpr const char* kTakeThisArm =
    "calibrate the robot that convert-robot --to yaml makes of this URDF, with the same --base and "
    "--tip";

// Why a chain is no calibration of the nominal one with the same frames; empty if it is one.
std::string why_another_arm(const KinematicChain& own, const KinematicChain& nominal) {
  const auto same_kinds = [](const Link& a, const Link& b) { return a.joint == b.joint; };
  if (!std::ranges::equal(own.links, nominal.links, same_kinds))
    return fmt::format("with other joints; {}", kTakeThisArm);
  const std::vector<Pose> frames = frames_at_zero(own), expected = frames_at_zero(nominal);
  for (size_t j = 0; j < frames.size(); ++j) {
    const double distance = (frames[j].translation - expected[j].translation).norm();
    const double angle = angle_between(frames[j], expected[j]);
    const int joint = static_cast<int>(j);
    if (joint_link(own, joint).sign == joint_link(nominal, joint).sign && distance < kSameArm &&
        angle < kSameArmAngle)
      continue;
    return fmt::format(
        "or its R_0 does not stand in --base: at joint {} the frames stand {:.4g} mm and {:.3g} "
        "deg apart; name the link where R_0 stands, or {}",
        j + 1, distance / kMillimetre, angle / kDegree, kTakeThisArm);
  }
  return "";
}

// The last frame may stand anywhere on its axis: here as far along it as that of `nominal`.
void slide_last_frame(KinematicChain& chain, const KinematicChain& nominal) {
  const int last = joint_count(chain) - 1;
  if (joint_count(nominal) != last + 1) return;
  Link& link = chain.links[static_cast<size_t>(link_of_joint(chain, last))];
  const double way = joint_link(nominal, last).r - link.r;
  link.r += way;
  chain.tool.translation.z() -= way;
}

// The robot, with frames as those of `nominal`, and its base where the document has it.
struct RobotOfDocument {
  Robot robot;
  Pose nominal_base;
};

// A robot that was made of the document has its frames already. Any other file of the arm gets
// them, if it is seen from the base of the document.
RobotOfDocument with_frames_of_document(const Robot& robot, const Robot& nominal,
                                        const std::string& file) {
  const auto problem = [&](const Robot& own, const Pose& base) {
    KinematicChain chain = own.chain;
    chain.base = base;
    return why_another_arm(chain, nominal.chain);
  };
  if (problem(robot, nominal.chain.base).empty()) return {robot, nominal.chain.base};
  RobotOfDocument result{with_frames_of_axes(robot), {}};
  slide_last_frame(result.robot.chain, nominal.chain);
  Pose& base = result.robot.chain.base;
  result.nominal_base = base;
  if (const std::string why = problem(result.robot, base); !why.empty())
    throw InputError(
        fmt::format("{}: is another arm than the robot '{}', {}", file, robot.name, why));
  base = robot.chain.base * base;
  return result;
}

bool same_origin(const Pose& a, const Pose& b) {
  return (a.translation - b.translation).cwiseAbs().maxCoeff() < kSameOrigin &&
         (a.rotation - b.rotation).cwiseAbs().maxCoeff() < kSameOrigin;
}

// The frame of each link behind a driven joint moves with the frame of the arm that it is fixed to.
std::map<std::string, Pose> changed_origins(const UrdfChain& chain, const Robot& robot,
                                            const Robot& nominal) {
  const std::vector<Pose> from = frames_at_zero(nominal.chain), to = frames_at_zero(robot.chain);
  std::map<std::string, Pose> origins;
  const auto change = [&](const ChainJoint& joint, const Pose& origin) {
    if (!same_origin(origin, joint.origin)) origins[joint.name] = origin;
  };
  Pose old_frame, frame;
  size_t driven = 0;
  for (size_t k = 0; k < chain.joints.size(); ++k) {
    const ChainJoint& joint = chain.joints[k];
    old_frame = old_frame * joint.origin;
    Pose next = frame * joint.origin;
    if (joint.is_driven()) {
      next = to[driven] * inverse(from[driven]) * old_frame;
      change(joint, inverse(frame) * next);
      ++driven;
    } else if (k + 1 == chain.joints.size() && driven == to.size()) {
      change(joint, inverse(frame) * tip_at_zero(robot.chain));
    }
    frame = next;
  }
  return origins;
}

FrameShift shift_of(const Pose& from, const Pose& to) {
  return {(from.translation - to.translation).norm(), angle_between(from, to)};
}

bool same_frame(const Pose& a, const Pose& b) {
  return (a.translation - b.translation).norm() < kExact && angle_between(a, b) < kExact;
}

}  // namespace

ChainPatch patch_of(const UrdfChain& chain, const Robot& nominal, const Robot& robot,
                    const UrdfKept& kept, const std::string& file) {
  const RobotOfDocument own = with_frames_of_document(robot, nominal, file);
  ChainPatch patch{own.robot, {}, {}, {}};
  KinematicChain& wanted = patch.robot.chain;
  if (kept.base) wanted.base = own.nominal_base;
  // The tool in the file is that of its flange, whatever the calibration made of the flange's link.
  if (kept.tool) {
    const int last = link_of_joint(wanted, joint_count(wanted) - 1);
    for (size_t j = static_cast<size_t>(last) + 1; j < wanted.links.size(); ++j)
      wanted.links[j] = nominal.chain.links[j];
    wanted.tool = nominal.chain.tool;
  }
  const Pose tool = tool_behind_joints(wanted), old_tool = tool_behind_joints(nominal.chain);
  const bool ends_driven = chain.joints.back().is_driven();
  if (ends_driven && !same_frame(tool, old_tool))
    throw InputError(file + ": '" + chain.joints.back().link +
                     "' turns with the last joint, so no origin can hold the tool; --tip names a "
                     "link that is fixed behind it, or --keep-tool leaves the tool out");
  patch.origins = changed_origins(chain, patch.robot, nominal);
  patch.base = shift_of(own.nominal_base, wanted.base);
  patch.tool = shift_of(old_tool, tool);
  return patch;
}

void require_same_arm(const Robot& wanted, const Robot& written, const std::string& file) {
  const ChainEvaluator expected(wanted.chain), found(written.chain);
  for (const JointVector& q : sample_joint_space(wanted.chain, kPosesChecked))
    if (!same_frame(expected.pose(q), found.pose(q)))
      throw InputError(file +
                       ": the arm that is written is not the same to 1e-9 m, as where a length is "
                       "too large for that; check the origins of the document");
}

PatchedUrdf write_into_urdf(const Robot& robot, const std::string& document,
                            const std::string& file, const UrdfEnds& ends, const UrdfKept& kept) {
  const UrdfChain chain = read_urdf_chain(document, file, ends);
  const ChainPatch patch = patch_of(chain, robot_of(chain, document, file), robot, kept, file);
  PatchedUrdf result{with_origins(document, patch.origins, file), patch.base, patch.tool};
  require_same_arm(patch.robot, parse_urdf(result.text, file, ends), file);
  return result;
}

}  // namespace armtrue
