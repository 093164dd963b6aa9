#include "armtrue/io/joint_target_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "armtrue/campaign/campaign.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "io/csv_cell.h"
#include "io/csv_table.h"
#include "io/joint_columns.h"

namespace armtrue {

JointTargetFile read_joint_target_file(const std::string& path,
                                       const std::vector<JointName>& joints) {
  Source source(path);
  CsvTable table(source, example_header("pose,", joints));
  const std::vector<std::string> names = encoder_names(joints);
  const auto pose = table.find("pose");
  const auto q = find_encoders(table, joints);
  if (!pose) table.fail_missing({"pose"});
  const auto is_found = [](const auto& column) { return column.has_value(); };
  if (std::ranges::none_of(q, is_found) && table.find_length("x"))
    throw InputError(fmt::format(
        "{}: has the points of poses and no joint values, which say how the arm stands; give {} to "
        "{}, as plan-poses writes them",
        source.name(), names.front(), names.back()));
  if (!has_all(table, q, names)) table.fail_missing(names, {*pose});
  const auto cell = [&](const std::optional<int>& column) {
    return column ? std::string(table.original(*column)) : std::string();
  };
  const auto beam = table.find("beam"), contact = table.find("contact"),
             touching = table.find("target");
  JointTargetFile file;
  std::vector<JointTarget>& targets = file.targets;
  std::map<std::string, int, std::less<>> lines;  // of each id
  while (table.next_row()) {
    if (table.is_empty(*pose)) table.fail(*pose, "is empty; every row needs the id of its pose");
    JointTarget& target = targets.emplace_back();
    target.pose = table.original(*pose);
    target.line = table.line_number();
    if (const auto [first, is_new] = lines.emplace(target.pose, target.line); !is_new)
      table.fail(*pose, table.quoted(*pose) + " stands in line " + std::to_string(first->second) +
                            " too; give every target an id of its own");
    target.q.resize(joints.size());
    for (size_t j = 0; j < joints.size(); ++j) target.q[j] = table.number(*q[j]);
    const std::string of_beam = cell(beam);
    target.contact = of_beam.empty() ? cell(contact) : BeamName(of_beam, cell(contact)).text();
    target.target = cell(touching);
  }
  if (targets.empty()) throw InputError(source.name() + ": has no row");
  file.name = source.name();
  file.sha256 = source.sha256();
  return file;
}

std::vector<JointTarget> read_joint_targets(const std::string& path,
                                            const std::vector<JointName>& joints) {
  return read_joint_target_file(path, joints).targets;
}

std::string write_joint_targets(const std::vector<JointTarget>& targets,
                                const std::vector<JointName>& joints) {
  const auto stated = [&](std::string JointTarget::*name) {
    return std::ranges::any_of(targets,
                               [&](const JointTarget& target) { return !(target.*name).empty(); });
  };
  const bool touched = stated(&JointTarget::contact), by_target = stated(&JointTarget::target);
  const bool by_beam = std::ranges::any_of(
      targets, [](const JointTarget& target) { return BeamName::is_one(target.contact); });
  std::string text = "pose";
  for (const JointName& joint : joints) text += "," + joint.encoder();
  text += std::string(by_beam ? ",beam" : "") + (touched ? ",contact" : "") +
          (by_target ? ",target" : "") + "\n";
  for (const JointTarget& target : targets) {
    text += csv_cell(target.pose);
    for (size_t j = 0; j < joints.size(); ++j)
      text += "," + number_text(target.q[j], joints[j].si());
    if (by_beam && BeamName::is_one(target.contact)) {
      const BeamName name(target.contact);
      text += "," + csv_cell(name.beam) + "," + csv_cell(name.contact);
    } else if (touched) {
      if (by_beam) text += ",";
      text += "," + csv_cell(target.contact);
    }
    if (by_target) text += "," + csv_cell(target.target);
    text += "\n";
  }
  return text;
}

}  // namespace armtrue
