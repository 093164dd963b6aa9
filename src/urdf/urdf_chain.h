#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/kinematics/pose.h"
#include "armtrue/urdf/urdf_io.h"

namespace armtrue {

/// The joint that another one follows (mimic).
struct ChainMimic {
  std::string joint;
  double multiplier = 1, offset = 0;  ///< [rad or m]
};

/// One joint between base and tip.
struct ChainJoint {
  enum class Kind { fixed, revolute, prismatic, other };

  bool moves() const { return kind == Kind::revolute || kind == Kind::prismatic; }
  bool is_driven() const { return moves() && has_encoder; }

  std::string name, link;  ///< `link`: its child
  Kind kind = Kind::fixed;
  bool has_encoder = true;          ///< false: it only follows others
  std::vector<ChainMimic> follows;  ///< one in a URDF; more after joints on one axis were merged
  double shift = 0;                 ///< added to its value [rad or m]
  /// The frame of `link` in the frame before it, where the joint angle is 0. A chain that leads
  /// from child to parent (`backwards`) has the inverse of the joint's origin. A joint that moves
  /// becomes two there: one with the identity that turns the other way, whose `link` is the child
  /// itself, and a fixed one that leads on to the parent.
  Pose origin;
  bool backwards = false;
  bool is_ground = false;  ///< fixed; the chain leads backwards up to here, and forwards from here
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of a joint that moves in its frame, unit
  bool limited = false;
  bool lacks_travel = false;  ///< it is limited, but the document does not say how
  double min = 0, max = 0;    ///< [rad or m]
  double mass_kg = 0;         ///< of `link`; 0: none stated
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

/// The chain of a URDF from base to tip.
struct UrdfChain {
  std::string robot;  ///< its name
  std::string base;   ///< link
  std::vector<ChainJoint> joints;
  /// Links that are fixed to the base, beside the chain or on it, at another pose, such as the
  /// frame of a controller. Links at one pose count once.
  std::vector<std::string> beside_base;
  std::string tool0;  ///< see tool0_beside_tip()
};

/// Reads the document with urdfdom and finds the chain with KDL. Throws as parse_urdf().
UrdfChain read_urdf_chain(const std::string& text, const std::string& file, const UrdfEnds& ends);

/// The arm of a document whose chain is `chain`. Throws as parse_urdf().
Robot robot_of(const UrdfChain& chain, const std::string& text, const std::string& file);

/// What a joint that write_urdf() writes copies of the position of another [rad or m].
struct WrittenMimic {
  int followed = 0;
  double multiplier = 0, offset = 0;
};

/// One for each coupling of a link that follows others, then those that what it follows demands.
std::vector<WrittenMimic> written_mimics(const KinematicChain& chain, int link);

/// The same arm with the frames that robot_of() gives to the axes of a foreign document. It is seen
/// from R_0: the base of the result is its own R_0 in the frame that was R_0 before.
Robot with_frames_of_axes(const Robot& robot);

}  // namespace armtrue
