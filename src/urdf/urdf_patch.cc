#include "urdf/urdf_patch.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/effects/sampling.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/urdf/urdf_io.h"
#include "urdf/link_frames.h"
#include "urdf/xml_origins.h"

namespace armtrue {
namespace {

using Eigen::Vector3d;

// A calibration moves a frame of a link less.
constexpr double kSameArm = 50 * kMillimetre, kSameArmAngle = 5 * kDegree;
// A calibration changes lengths of the last links less: readings hardly tell them from the tool.
constexpr double kSameLength = 5 * kMillimetre;
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
    if (is_driven(link)) frames.push_back(frame);
  }
  return frames;
}

// The tool in the frame of the last driven link.
Pose tool_behind_joints(const KinematicChain& chain) {
  Pose tool;
  const int first = link_of_joint(chain, joint_count(chain) - 1) + 1;
  for (int j = first; j < link_count(chain); ++j) tool = tool * link_transform(chain.links[j]);
  return tool * chain.tool;
}

Pose tip_at_zero(const KinematicChain& chain) {
  return frames_at_zero(chain).back() * tool_behind_joints(chain);
}

constexpr const char* kTakeThisArm =
    "calibrate the robot that convert-robot --to yaml makes of this URDF, with the same --base and "
    "--tip";

// How far two frames of a joint stand apart [m, rad]. The last one may stand anywhere on its axis,
// turned by any angle about it.
struct Apart {
  double distance, angle;
};

Apart frames_apart(const Pose& own, const Pose& expected, bool is_last) {
  const Vector3d between = own.translation - expected.translation;
  if (!is_last) return {between.norm(), angle_between(own, expected)};
  const Vector3d z = expected.rotation.col(2), own_z = own.rotation.col(2);
  return {(between - z * z.dot(between)).norm(), std::atan2(z.cross(own_z).norm(), z.dot(own_z))};
}

// Why a chain is no calibration of the nominal one with the same frames; empty if it is one.
std::string why_another_arm(const KinematicChain& own, const KinematicChain& nominal) {
  const auto same_kinds = [](const Link& a, const Link& b) { return a.joint == b.joint; };
  if (!std::ranges::equal(own.links, nominal.links, same_kinds))
    return fmt::format("with other joints; {}", kTakeThisArm);
  const std::vector<Pose> frames = frames_at_zero(own), expected = frames_at_zero(nominal);
  for (int j = 0; j < std::ssize(frames); ++j) {
    const auto [distance, angle] =
        frames_apart(frames[j], expected[j], j + 1 == std::ssize(frames));
    const int joint = j;
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

// Whether the last frame is where that of `nominal` is on its axis, within what a calibration
// changes, and the links behind it are the same.
bool has_last_frame_of(const KinematicChain& chain, const KinematicChain& nominal) {
  const auto is_near = [](const Link& own, const Link& other) {
    const Vector3d lengths(own.d - other.d, own.r - other.r, 0);
    const Vector3d angles(own.alpha - other.alpha, own.theta - other.theta, own.beta - other.beta);
    const auto from_turn = [](double angle) { return std::remainder(angle, 2 * std::numbers::pi); };
    return lengths.cwiseAbs().maxCoeff() < kSameLength &&
           angles.unaryExpr(from_turn).cwiseAbs().maxCoeff() < kSameArmAngle;
  };
  const size_t last = link_of_joint(chain, joint_count(chain) - 1);
  return std::equal(chain.links.begin() + last, chain.links.end(), nominal.links.begin() + last,
                    is_near);
}

// Slides and turns the last frame on its axis until it stands behind that of the joint before as
// that of `nominal` does, and gives the links behind it their values there. What is left is the
// tool.
void take_last_frame_of(const KinematicChain& nominal, KinematicChain& chain) {
  const size_t last = link_of_joint(chain, joint_count(chain) - 1);
  const double turn = nominal.links[last].theta - chain.links[last].theta;
  const double slide = nominal.links[last].r - chain.links[last].r;
  const Pose moved{Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix(),
                   slide * Vector3d::UnitZ()};
  const Pose tool = inverse(moved) * tool_behind_joints(chain);
  chain.links[last].theta = nominal.links[last].theta;
  chain.links[last].r = nominal.links[last].r;
  std::copy(nominal.links.begin() + last + 1, nominal.links.end(), chain.links.begin() + last + 1);
  chain.tool = {};
  chain.tool = inverse(tool_behind_joints(chain)) * tool;
}

// The robot, with frames as those of `nominal`, and its base where the document has it.
struct RobotOfDocument {
  Robot robot;
  Pose nominal_base;
};

// A robot that was made of the document has its frames already, except the last one in files of
// older versions of convert-robot, which laid it elsewhere on its axis. Any other file of the arm
// gets the frames, seen from the base of the document.
RobotOfDocument with_frames_of_document(const Robot& robot, const Robot& nominal,
                                        const std::string& file) {
  RobotOfDocument result{robot, nominal.chain.base};
  const auto problem = [&] {
    KinematicChain chain = result.robot.chain;
    chain.base = result.nominal_base;
    return why_another_arm(chain, nominal.chain);
  };
  if (problem().empty()) {
    if (!has_last_frame_of(robot.chain, nominal.chain))
      take_last_frame_of(nominal.chain, result.robot.chain);
    return result;
  }
  result.robot = with_frames_of_axes(robot);
  result.nominal_base = result.robot.chain.base;
  if (const std::string why = problem(); !why.empty())
    throw InputError(
        fmt::format("{}: is another arm than the robot '{}', {}", file, robot.name, why));
  take_last_frame_of(nominal.chain, result.robot.chain);
  result.robot.chain.base = robot.chain.base * result.nominal_base;
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
      change(joint, inverse(frame) * tip_at_zero(robot.chain) *
                        inverse(tip_at_zero(nominal.chain)) * old_frame);
    }
    frame = next;
  }
  return origins;
}

FrameShift shift_of(const Pose& from, const Pose& to) {
  return {(from.translation - to.translation).norm(), angle_between(from, to), {}};
}

bool same_frame(const Pose& a, const Pose& b) {
  return (a.translation - b.translation).norm() < kExact && angle_between(a, b) < kExact;
}

}  // namespace

ChainPatch patch_of(const UrdfChain& chain, const Robot& nominal, const Robot& robot,
                    const UrdfKept& kept, const std::string& file) {
  const RobotOfDocument own = with_frames_of_document(robot, nominal, file);
  ChainPatch patch{own.robot, {}, {}, {}, {}};
  KinematicChain& wanted = patch.robot.chain;
  if (kept.base) wanted.base = own.nominal_base;
  const Pose old_tool = tool_behind_joints(nominal.chain);
  // A link that turns with the last joint stands on its axis: no origin moves it from there.
  const bool has_no_place = chain.joints.back().is_driven();
  if (has_no_place && !kept.tool) {
    patch.tool_left_out = shift_of(old_tool, tool_behind_joints(wanted));
    patch.tool_left_out.of_link = chain.joints.back().link;
  }
  // A tool that is kept is relative to the nominal flange, so the links behind the last joint are
  // kept with it.
  if (kept.tool || has_no_place) {
    const int last = link_of_joint(wanted, joint_count(wanted) - 1);
    for (int j = last + 1; j < link_count(wanted); ++j) wanted.links[j] = nominal.chain.links[j];
    wanted.tool = nominal.chain.tool;
  }
  const Pose tool = tool_behind_joints(wanted);
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
  const auto follows = [](const ChainJoint& joint) { return !joint.follows.empty(); };
  if (!robot.chain.couplings.empty() || std::ranges::any_of(chain.joints, follows))
    throw InputError(file +
                     ": joints follow others (mimic), and the origins of a document hold no "
                     "errors of these; write a document of its own: --to urdf alone");
  if (std::ranges::any_of(chain.joints, &ChainJoint::is_ground))
    throw InputError(file +
                     ": the way from --base to --tip leads back through joints, and is two arms; "
                     "keep their model as YAML, which all commands read");
  const ChainPatch patch = patch_of(chain, robot_of(chain, document, file), robot, kept, file);
  PatchedUrdf result{with_origins(document, patch.origins, file), patch.base, patch.tool,
                     patch.tool_left_out};
  require_same_arm(patch.robot, parse_urdf(result.text, file, ends), file);
  return result;
}

}  // namespace armtrue
