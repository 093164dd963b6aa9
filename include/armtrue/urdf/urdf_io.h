#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"

namespace armtrue {

/// A URDF document (metres, radians): `world` is R_A, `base_link` R_0, then one link for each link
/// of the chain and `tool` for the measured frame. The parameters of each link are also stored as
/// attributes, which other readers ignore, so that the document reads back with exactly the same
/// numbers.
std::string write_urdf(const Robot& robot);

/// The keys of this robot's file that URDF cannot hold.
std::vector<std::string> lost_in_urdf(const Robot& robot);

/// The first and the last link of the arm in a URDF. An empty base is the root. An empty tip is the
/// end of the only branch with driven joints; branches without driven joints are ignored.
struct UrdfEnds {
  std::string base, tip;
};

/// Reads a URDF with 1 to 16 revolute or prismatic joints from base to tip. urdfdom parses it; KDL
/// finds the chain. Links written by write_urdf() come back unchanged, between the frames of base
/// and tool. Any other arm gets Khalil's frames from the common normals of its axes, with beta
/// where two are nearly parallel: the frame of the base is R_A, that of the tip the frame of the
/// last, fixed link, and tool is 0. R_0 has the axes of R_A and stands there, or beside it where
/// link 1 does not lead from there to axis 1 (`base`). If the path from base to tip leads down one
/// arm and up another, `ground_link` is where both stand. Throws InputError for an invalid URDF,
/// macros that are not expanded, an end that no branch or several branches have, or other driven
/// joints.
Robot parse_urdf(const std::string& text, const std::string& file, const UrdfEnds& ends = {});

/// Links that are fixed to the base with a rotation or translation, on the way to the arm or beside
/// it. One of them may be the base frame of the controller. None in a document of write_urdf(),
/// whose base_link is R_0.
std::vector<std::string> frames_beside_base(const std::string& text, const std::string& file,
                                            const UrdfEnds& ends);

/// Position of R_0 relative to the base of a document, in its axes [m]; 0 for a document of
/// write_urdf().
Eigen::Vector3d foot_beside_base(const std::string& text, const std::string& file,
                                 const UrdfEnds& ends);

/// The link `tool0`, with any prefix, if it is fixed after the last joint at another place than the
/// tip: descriptions after ROS-Industrial have the flange of the controller there. Else empty.
std::string tool0_beside_tip(const std::string& text, const std::string& file,
                             const UrdfEnds& ends);

/// Links whose joint has limits of 0 and 0: its travel was not entered and is read as unlimited.
std::vector<std::string> links_without_travel(const std::string& text, const std::string& file,
                                              const UrdfEnds& ends);

/// Sentences on what a user may have meant otherwise: frames beside the base and the flange, two
/// arms as one chain, joints without travel. `robot`: parse_urdf() of the text.
std::vector<std::string> doubts_of_urdf(const Robot& robot, const std::string& text,
                                        const std::string& file, const UrdfEnds& ends);

/// The parent joint of each link, by name of the link. Robots of parse_urdf() have the names of the
/// links; joint states under ROS have those of the joints. Throws InputError for invalid XML.
std::map<std::string, std::string> urdf_joint_of_link(const std::string& text,
                                                      const std::string& file);

/// Frames of the document that write_into_urdf() does not change.
struct UrdfKept {
  bool base = false, tool = false;
};

/// Change of the place of a frame.
struct FrameShift {
  double distance = 0;  ///< [m]
  double angle = 0;     ///< [rad]
  std::string of_link;  ///< of tool_left_out: the link of the tip
};

/// The result of write_into_urdf(), write_into_ur_calibration() and write_into_ur_conf().
struct PatchedUrdf {
  std::string text;
  FrameShift base, tool;  ///< change of the base and of the tool; 0 if kept
  /// Shift of a tool that the document cannot hold, because its tip turns with the last joint and
  /// so lies on the axis: the tool is kept, and this shift is not written.
  FrameShift tool_left_out;
};

/// The document with the geometry of `robot`: the frame from base to tip is that of the robot at
/// all joint angles, to 1e-9 m. Only `xyz` and `rpy` of the origins of joints change, every other
/// byte stays. The robot comes from parse_urdf() of this document, calibrated or not, or is any
/// other model of the same arm whose R_0 is fixed to the base of `ends`. Throws InputError as
/// parse_urdf(), and if the robot is another arm.
PatchedUrdf write_into_urdf(const Robot& robot, const std::string& document,
                            const std::string& file, const UrdfEnds& ends, const UrdfKept& kept);

}  // namespace armtrue
