#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/kinematics/pose.h"

namespace armtrue {

/// The largest chain. Vectors by joint and Jacobians have this capacity and need no allocation.
inline constexpr int kMaxJoints = 16;
inline constexpr int kMaxLinks = 24;
inline constexpr int kMaxCouplings = 8;

/// Encoder values of the driven joints in the order of the chain, as the controller shows them:
/// [rad] of a revolute joint, [m] of a prismatic one. Empty unless a size is given.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;

/// Encoder values of many samples, a column each.
using JointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints>;

/// How a link moves: about its z axis, along it, or not at all.
enum class JointKind { revolute, prismatic, fixed };

/// One link in Khalil's modified Denavit-Hartenberg convention with Hayati's beta:
///     R_{j-1} from R_j = Rot(y, beta) Rot(x, alpha) Trans(x, d) Rot(z, theta_j) Trans(z, r_j),
/// where theta_j = theta + sign * q_j of a revolute and r_j = r + sign * q_j of a prismatic joint.
/// Angles rad, lengths m.
/// Source: Khalil and Dombre, "Modeling, Identification and Control of Robots"; Hayati 1985 for
/// beta.
struct Link {
  std::string name;
  double alpha = 0, d = 0, theta = 0, r = 0, beta = 0;
  double sign = 1;                                        ///< direction of the encoder: +1 or -1
  double min = -std::numeric_limits<double>::infinity();  ///< travel of the encoder [rad or m]
  double max = std::numeric_limits<double>::infinity();
  JointKind joint = JointKind::revolute;
  bool has_encoder = true;  ///< false: the joint only follows others, see Coupling
};

/// A joint moves another, as the rods of a parallelogram or a screw do. A joint adds to its theta
/// (r of a prismatic one), times `sign`, its encoder value, if it has one, and
///     sum of coefficient * v   over the couplings of its link as `follower`,
/// where v is the value of the joint of the link `followed`: how far that link has moved,
///     v = sign * (theta_j - from)   (r_j of a prismatic one),
/// the encoder value of an exact arm. So a zero error, a compliance or a backlash of the followed
/// link moves the follower too.
struct Coupling {
  int follower = 0, followed = 0;  ///< links, 0-based
  double coefficient = 0;          ///< [rad or m of the follower per rad or m of the followed]
  double from = 0;                 ///< theta or r of the followed link where v is 0 [rad or m]
};

/// Whether the joint of a link has an encoder. Numbers of joints count these alone.
inline bool is_driven(const Link& link) {
  return link.joint != JointKind::fixed && link.has_encoder;
}

/// Whether the joint of a link slides: its value is a length [m], not an angle.
inline bool is_prismatic(const Link& link) { return link.joint == JointKind::prismatic; }

/// Returns the travel {min, max} of a joint [rad or m]; a missing limit is replaced by -pi or +pi
/// of a revolute joint. Robot files state both limits of a prismatic one.
inline std::array<double, 2> travel(const Link& link) {
  return {std::isfinite(link.min) ? link.min : -std::numbers::pi,
          std::isfinite(link.max) ? link.max : std::numbers::pi};
}

/// A reflector, fixed in the measured frame [m].
struct Target {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

/// Fixed end of a draw-wire or ball-bar, in R_A [m]. The reading is |p - position| + zero, where p
/// is a target or the origin of the measured frame.
struct Anchor {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double zero = 0;
};

/// What the tool touches. In the axes of the contact, a touch reads
///     point     the three coordinates of the touching point: a socket that holds a ball
///     plane     the height above z = 0
///     sphere    the distance from the origin, less the radius
///     artefact  one of these, of one of several points, planes (its faces) and spheres (its balls)
///               whose places in the artefact are known: a scale bar, a ball plate, a cube. Of
///               faces and balls the contact's radius, that of the touching ball, is taken off, too
/// A beam on the arm points along z of its axes and reads the distance along z from its origin to a
/// plane or a face. A camera reads the pixel of a point of a board, two numbers; one of the two is
/// on the arm, the other at rest. The axes of a camera: x to the right of the image, y down, z
/// along its line of sight.
enum class ContactKind { point, artefact, plane, sphere, board, camera, beam };

/// Whether it is a board or a camera, which may be on the arm.
constexpr bool is_of_images(ContactKind kind) {
  return kind == ContactKind::board || kind == ContactKind::camera;
}

/// Whether the tool touches it, or a beam ends on it.
constexpr bool is_touched(ContactKind kind) {
  return !is_of_images(kind) && kind != ContactKind::beam;
}

/// How a lens distorts, see project().
enum class Lens { pinhole, fisheye };

/// Intrinsic parameters of a camera: focal lengths and principal point [px], then coefficients of
/// the distortion.
inline constexpr int kIntrinsics = 10;
using Intrinsics = Eigen::Matrix<double, kIntrinsics, 1>;
enum IntrinsicIndex { kFx, kFy, kCx, kCy, kK1, kK2, kP1, kP2, kK3, kK4 };

/// A point, a face or a ball of an artefact, or a point of a board, in its axes [m]; those of a
/// board have z = 0.
struct ArtefactPoint {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of a face: any point in it
  ContactKind kind = ContactKind::point;               ///< point, plane (a face) or sphere (a ball)
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   ///< of a face: unit, outwards
  double radius = 0;                                   ///< of a ball
};

/// A thing at rest in R_A that the point of the tool touches, a camera or a board, at rest or on
/// the arm, or a beam on the arm. Its place may be unknown.
struct Contact {
  std::string name;
  ContactKind kind = ContactKind::point;
  Pose place;                         ///< R_A from the contact; measured frame from it if on_arm
  double radius = 0;                  ///< of a sphere, or of the ball that touches an artefact [m]
  bool radius_is_known = false;       ///< of the touching ball: it is not identified
  std::vector<ArtefactPoint> points;  ///< of an artefact or a board
  Eigen::Vector2d range{0, 0};        ///< least and largest reading of a beam [m]; 0: not stated
  bool on_arm = false;                ///< fixed in the measured frame: a beam, a camera or a board
  Lens lens = Lens::pinhole;          ///< of a camera, and its numbers
  Intrinsics intrinsics = Intrinsics::Zero();
  Eigen::Vector2d image_size = Eigen::Vector2d::Zero();  ///< width and height [px]; 0: not stated
  /// False: place and radius are unknown; a calibration finds them.
  bool is_placed = true;
};

/// A chain of links, driven, following and fixed in any order, between the frame R_A of the
/// instrument and the measured frame on the tool. At most kMaxLinks links, kMaxJoints of them
/// driven.
struct KinematicChain {
  Pose base;                ///< R_A from R_0
  std::vector<Link> links;  ///< R_n is the frame of the last
  Pose tool;                ///< R_n from the measured frame
  std::vector<Target> targets;
  std::vector<Anchor> anchors;
  std::vector<Contact> contacts;
  std::vector<Coupling> couplings;  ///< at most kMaxCouplings
};

inline int link_count(const KinematicChain& chain) { return static_cast<int>(chain.links.size()); }
inline int target_count(const KinematicChain& chain) {
  return static_cast<int>(chain.targets.size());
}
inline int anchor_count(const KinematicChain& chain) {
  return static_cast<int>(chain.anchors.size());
}
inline int contact_count(const KinematicChain& chain) {
  return static_cast<int>(chain.contacts.size());
}

/// Number of the driven joints.
int joint_count(const KinematicChain& chain);

/// The link that a joint (0-based) drives. Throws std::out_of_range if there is no such joint.
int link_of_joint(const KinematicChain& chain, int joint);
inline const Link& joint_link(const KinematicChain& chain, int joint) {
  return chain.links[link_of_joint(chain, joint)];
}

/// The joint (0-based) that drives a link; -1 of a link without an encoder.
int joint_of_link(const KinematicChain& chain, int link);

/// A joint outside the travel that its link states.
struct BeyondTravel {
  int link = 0;      ///< 0-based
  double value = 0;  ///< encoder value, or the value of a joint that only follows others [rad or m]
};

/// The first such joint, of the driven ones before those that follow others.
std::optional<BeyondTravel> beyond_travel(const KinematicChain& chain, const JointVector& q);

/// The couplings, as indices, in an order in which the value of a joint is complete before others
/// follow it. Throws std::invalid_argument if a joint follows itself through others, or if a
/// coupling is not between two links that move.
std::vector<int> coupling_order(const KinematicChain& chain);

/// Motion of theta or r of each link per unit motion of that of `link`, by the couplings [rad or m
/// per rad or m]; 1 for `link` itself, 0 for links that do not follow it.
std::vector<double> moved_with(const KinematicChain& chain, int link);

/// Value of the joint of each link at encoder values q: the encoder value, if it has one, plus what
/// its couplings add [rad or m]; 0 for a fixed link.
std::vector<double> joint_values(const KinematicChain& chain, const JointVector& q);

/// Whether the chain is the usual arm: six revolute joints, then one fixed link.
bool is_six_axis_arm(const KinematicChain& chain);

/// Links of such an arm: seven, all parameters zero, without names; the last one is fixed.
std::vector<Link> six_axis_links();

}  // namespace armtrue
