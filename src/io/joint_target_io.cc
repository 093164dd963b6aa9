#include "armtrue/io/joint_target_io.h"

#include <array>
#include <map>
#include <optional>

#include "armtrue/io/csv_table.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"

namespace armtrue {
namespace {

std::string angle_name(int j) { return "q" + std::to_string(j + 1); }

}  // namespace

std::vector<JointTarget> read_joint_targets(const std::string& path) {
  Source source(path);
  CsvTable table(source, "pose,q1_deg,...,q6_deg");
  std::vector<std::string> missing;
  const auto pose = table.find("pose");
  if (!pose) missing.emplace_back("pose");
  std::array<std::optional<CsvTable::Quantity>, kJoints> q;
  for (int j = 0; j < kJoints; ++j)
    if (!(q[j] = table.find_angle(angle_name(j)))) missing.push_back(angle_name(j) + "_deg");
  if (!missing.empty()) table.fail_missing(missing);
  std::vector<JointTarget> targets;
  std::map<std::string, int, std::less<>> lines;  // of each id
  while (table.next_row()) {
    if (table.is_empty(*pose)) table.fail(*pose, "is empty; every row needs the id of its pose");
    JointTarget& target = targets.emplace_back();
    target.pose = table.text(*pose);
    target.line = table.line_number();
    if (const auto [first, is_new] = lines.emplace(target.pose, target.line); !is_new)
      table.fail(*pose, table.quoted(*pose) + " stands in line " + std::to_string(first->second) +
                            " too; give every target an id of its own");
    for (int j = 0; j < kJoints; ++j) target.q[j] = table.number(*q[j]);
  }
  if (targets.empty()) throw InputError(source.name() + ": has no row");
  return targets;
}

std::string write_joint_targets(const std::vector<JointTarget>& targets) {
  std::string text = "pose";
  for (int j = 0; j < kJoints; ++j) text += "," + angle_name(j) + "_deg";
  text += "\n";
  for (const JointTarget& target : targets) {
    text += target.pose;
    for (int j = 0; j < kJoints; ++j) text += "," + number_text(target.q[j], kDegree);
    text += "\n";
  }
  return text;
}

}  // namespace armtrue
