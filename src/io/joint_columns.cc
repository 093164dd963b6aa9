#include "io/joint_columns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"

namespace armtrue {
namespace {

using JointQuantity = std::optional<CsvTable::Quantity>;

JointQuantity find_joint(const CsvTable& table, const std::string& name, bool is_length) {
  return is_length ? table.find_length(name) : table.find_angle(name);
}

// Number of columns q1, q2, ... that the file has without a gap, in any unit.
size_t count_of_arm(const CsvTable& table) {
  size_t count = 0;
  const auto has = [&](size_t number) {
    const std::string name = fmt::format("q{}", number);
    return table.find_angle(name) || table.find_length(name);
  };
  while (has(count + 1)) ++count;
  return count;
}

// A file with fewer columns q1, q2, ... is not taken for that of another robot.
constexpr size_t kFewestOfAnArm = 2;

void require_number(const CsvTable& table, const std::vector<JointName>& joints) {
  const size_t expected = std::ranges::count_if(
      joints, [](const JointName& joint) { return joint.column.front() == 'q'; });
  const size_t found = count_of_arm(table);
  if (found == expected || found < kFewestOfAnArm) return;
  const bool scattered = std::ranges::any_of(joints, [&](const JointName& joint) {
    return joint.column.front() == 'q' &&
           std::cmp_greater(*read_whole_number(joint.column.substr(1)), found + 1) &&
           find_joint(table, joint.column, joint.is_length);
  });
  if (scattered) return;  // one is missing or misspelt
  throw InputError(
      fmt::format("{}: has {}, q1 to q{}, and the robot has {}: {}; give the robot of these "
                  "joints, or the columns that it needs",
                  table.source_name(), counted(found, "joint column"), found, joints.size(),
                  fmt::join(encoder_names(joints), ", ")));
}

}  // namespace

std::vector<JointQuantity> find_encoders(const CsvTable& table,
                                         const std::vector<JointName>& joints) {
  require_number(table, joints);
  std::vector<JointQuantity> found;
  for (const JointName& joint : joints)
    found.push_back(find_joint(table, joint.column, joint.is_length));
  return found;
}

std::vector<JointQuantity> find_strokes(const CsvTable& table,
                                        const std::vector<JointName>& joints) {
  std::vector<JointQuantity> found;
  for (const JointName& joint : joints)
    found.push_back(find_joint(table, fmt::format("stroke{}", found.size() + 1), joint.is_length));
  return found;
}

std::vector<std::string> stroke_columns(const std::vector<JointName>& joints) {
  std::vector<std::string> names;
  for (const JointName& joint : joints)
    names.push_back(fmt::format("stroke{}{}", names.size() + 1, joint.unit_ending()));
  return names;
}

std::vector<std::string> numbered_columns(const std::string& before,
                                          const std::vector<JointName>& joints,
                                          const std::string& after) {
  std::vector<std::string> names;
  for (size_t j = 1; j <= joints.size(); ++j)
    names.push_back(fmt::format("{}{}{}", before, j, after));
  return names;
}

std::vector<std::string> encoder_names(const std::vector<JointName>& joints) {
  std::vector<std::string> names;
  for (const JointName& joint : joints) names.push_back(joint.encoder());
  return names;
}

std::string example_header(const std::string& before, const std::vector<JointName>& joints,
                           const std::string& after) {
  const std::string last = joints.size() > 1 ? ",...," + joints.back().encoder() : "";
  return before + joints.front().encoder() + last + after;
}

}  // namespace armtrue
