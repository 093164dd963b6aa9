#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/kinematics/joint_names.h"
#include "io/csv_table.h"

namespace armtrue {

/// The columns of the encoder values, one per joint; nothing where one is missing. Throws
/// InputError if the file has the joint columns of a robot with another number of joints, and names
/// both.
std::vector<std::optional<CsvTable::Quantity>> find_encoders(const CsvTable& table,
                                                             const std::vector<JointName>& joints);

/// `stroke1_deg` or `stroke1_mm` of the k-th joint (0-based) in the order of the chain.
std::vector<std::optional<CsvTable::Quantity>> find_strokes(const CsvTable& table,
                                                            const std::vector<JointName>& joints);
std::vector<std::string> stroke_columns(const std::vector<JointName>& joints);

/// `dir1`, `tau1_nm`, ... of every joint in the order of the chain.
std::vector<std::string> numbered_columns(const std::string& before,
                                          const std::vector<JointName>& joints,
                                          const std::string& after = "");

/// Names of the columns of the encoder values.
std::vector<std::string> encoder_names(const std::vector<JointName>& joints);

/// "pose,q1_deg,...,q6_deg", for the error of an empty file.
std::string example_header(const std::string& before, const std::vector<JointName>& joints,
                           const std::string& after = "");

}  // namespace armtrue
