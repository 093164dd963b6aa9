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

  std::string name, link;  ///< link: the one behind it
  Kind kind = Kind::fixed;
  bool has_encoder = true;          ///< false: it only follows others
  std::vector<ChainMimic> follows;  ///< of a URDF one; more where joints on one axis are one
  double shift = 0;                 ///< added to its value [rad or m]
  /// The frame of `link` in the frame before it, where the joint angle is 0. From child to parent
  /// (`backwards`) it is the inverse of the joint's origin. A joint that moves is then two: it
  /// turns where it is, the other way, as `link` its own child, and a fixed one leads on to its
  /// parent.
  Pose origin;
  bool backwards = false;
  bool is_ground = false;  ///< where a way with such joints ends to lead backwards; fixed
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
  /// Links that stand fixed to the base, beside the way or on it, turned or moved, as the frame of
  /// a controller often does. Links that stand together count once.
  std::vector<std::string> beside_base;
  std::string tool0;  ///< see tool0_beside_tip()
};

/// Reads the document with urdfdom and finds the way with KDL. Errors are those of parse_urdf().
UrdfChain read_urdf_chain(const std::string& text, const std::string& file, const UrdfEnds& ends);

/// The arm of a document whose way is `chain`. Errors are those of parse_urdf().
Robot robot_of(const UrdfChain& chain, const std::string& text, const std::string& file);

/// The same arm with the frames that robot_of() gives to the axes of a foreign document. It is seen
/// from R_0: the base of the result is its own R_0 in the frame that was R_0 before.
Robot with_frames_of_axes(const Robot& robot);

}  // namespace armtrue
