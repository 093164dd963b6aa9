#pragma once

#include <string>
#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// How files and messages call a driven joint. The joints of the arm are q1, q2, ... in the order
/// of the chain; a link named E1 to E6, an external axis such as a rail, is e1 to e6, and the
/// numbers of the others skip it.
struct JointName {
  std::string column;  ///< "q1", "e1"
  std::string axis;    ///< "1", "E1"
  bool is_length = false;

  /// Whether it is an external axis, such as a rail or an axis of a positioner.
  bool is_external() const { return column.front() == 'e'; }
  /// The column of its encoder values: "q1_deg", "e1_mm".
  std::string encoder() const { return column + unit_ending(); }
  std::string unit_ending() const { return is_length ? "_mm" : "_deg"; }
  /// "deg", "mm".
  std::string unit() const { return is_length ? "mm" : "deg"; }
  /// One of the file's units in SI.
  double si() const;
};

/// Of every driven joint, in the order of the chain.
std::vector<JointName> joint_names(const KinematicChain& chain);

/// Of the usual arm, see is_six_axis_arm(): files that no robot file comes with are its.
const std::vector<JointName>& six_axis_names();

/// The columns of the encoder values, for messages: "q1_deg to q6_deg", "e1_mm, q1_deg to q6_deg".
std::string encoder_columns(const KinematicChain& chain);

}  // namespace armtrue
