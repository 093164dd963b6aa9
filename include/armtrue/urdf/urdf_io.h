#pragma once

#include <map>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"

namespace armtrue {

/// A URDF document (metres, radians): `world` is R_A, `base_link` R_0, then one link for each link
/// of the chain and `tool` for the measured frame. The seven link entries are also kept as
/// attributes that other readers ignore, so that reading the document back gives the same numbers
/// to the last digit.
std::string write_urdf(const Robot& robot);

/// The keys of the robot file that URDF cannot hold and this robot has.
std::vector<std::string> lost_in_urdf(const Robot& robot);

/// The links between which a URDF is the arm. An empty base is the root. An empty tip is the end of
/// the only branch with driven joints: branches without one are ignored.
struct UrdfEnds {
  std::string base, tip;
};

/// Reads a URDF with 1 to 10 revolute or prismatic joints from base to tip: urdfdom parses it, KDL
/// finds the way.
/// The frame of the base is R_A, that of the tip the measured frame. Links written by write_urdf
/// come back as they were; any other arm gets Khalil's frames from the common normals of its axes,
/// with beta where two are nearly parallel. Throws InputError: no valid URDF, macros that are not
/// expanded, an end that no branch or several have, other driven joints.
Robot parse_urdf(const std::string& text, const std::string& file, const UrdfEnds& ends = {});

/// Links that stand fixed beside the base, turned or moved, as the frame of a controller may.
std::vector<std::string> frames_beside_base(const std::string& text, const std::string& file,
                                            const UrdfEnds& ends);

/// The joint above each link, by name of the link: robots that parse_urdf() makes keep the names of
/// the links, and joint states under ROS those of the joints. Throws InputError: no valid XML.
std::map<std::string, std::string> urdf_joint_of_link(const std::string& text,
                                                      const std::string& file);

/// What write_into_urdf() leaves as the document has it.
struct UrdfKept {
  bool base = false, tool = false;
};

/// How far a frame lies from where it was.
struct FrameShift {
  double distance = 0;  ///< [m]
  double angle = 0;     ///< [rad]
};

struct PatchedUrdf {
  std::string text;
  FrameShift base, tool;  ///< 0 if kept
};

/// The document with the geometry of `robot`: the frame from base to tip is that of the robot at
/// all joint angles, to 1e-9 m. Only `xyz` and `rpy` of the origins of joints change, every other
/// byte stays. The robot is one that parse_urdf() made of this document, calibrated or not, or any
/// other of the same arm whose R_0 stands in the base of `ends`. Throws InputError as parse_urdf(),
/// and where the robot is another arm, or the document has no fixed joint behind the last driven
/// one that could hold the tool.
PatchedUrdf write_into_urdf(const Robot& robot, const std::string& document,
                            const std::string& file, const UrdfEnds& ends, const UrdfKept& kept);

}  // namespace armtrue
