#pragma once

#include <string>
#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Name of a driven joint in files and messages. The joints of the arm are q1, q2, ... in the order
/// of the chain. A link named E1 to E6 is an external axis, such as a rail; its joint is e1 to e6
/// and does not count in the numbers of the others.
struct JointName {
  std::string column;  ///< "q1", "e1"
  std::string axis;    ///< "1", "E1"
  bool is_length = false;
  /// For sentences: "3", or "3 (elbow)" if the name of its link does not end in this number.
  std::string words{};

  /// Whether it is an external axis, such as a rail or an axis of a positioner.
  bool is_external() const { return column.front() == 'e'; }
  /// The column of its encoder values: "q1_deg", "e1_mm".
  std::string encoder() const { return column + unit_ending(); }
  std::string unit_ending() const { return is_length ? "_mm" : "_deg"; }
  /// "deg", "mm".
  std::string unit() const { return is_length ? "mm" : "deg"; }
  /// The unit of the file in SI.
  double si() const;
};

/// The names of all driven joints, in the order of the chain.
std::vector<JointName> joint_names(const KinematicChain& chain);

/// The names of the usual arm, see is_six_axis_arm(). Files that are read without a robot file use
/// them.
const std::vector<JointName>& six_axis_names();

/// The columns of the encoder values, for messages: "q1_deg to q6_deg", "e1_mm, q1_deg to q6_deg".
std::string encoder_columns(const KinematicChain& chain);

}  // namespace armtrue
