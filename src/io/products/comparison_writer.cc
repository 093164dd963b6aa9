
#include "armtrue/io/products/comparison_io.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "io/products/error_nodes.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

const char* word_of(InRuns in) {
  return in == InRuns::both ? "both" : in == InRuns::before ? "before" : "after";
}

const char* word_of(Shared shared) {
  switch (shared) {
    case Shared::all:
      return "same";
    case Shared::some:
      return "partly the same";
    case Shared::none:
      return "other";
    case Shared::unknown:
      break;
  }
  return "unknown";
}

// The ending of the keys of a parameter, such as _mm of `change_mm`; empty without a unit.
std::string ending_of(const DisplayUnit& unit) { return unit.name == "1" ? "" : "_" + unit.name; }

void add_number(const NumberChange& number, double unit, const std::string& ending,
                YAML::Node& node) {
  if (number.before) node["before" + ending] = number_text(*number.before, unit);
  if (number.after) node["after" + ending] = number_text(*number.after, unit);
  if (number.change) node["change" + ending] = rounded(*number.change / unit);
  if (number.std) node["std" + ending] = rounded(*number.std / unit);
  if (number.ci95) node["ci95" + ending] = interval_node(*number.ci95, unit);
  if (!number.p_value) return;
  node["p_value"] = rounded(*number.p_value);
  node["moved"] = boolean(number.moved());
}

YAML::Node parameter_node(const ComparedParameter& parameter) {
  YAML::Node node;
  node["parameter"] = parameter.name;
  node["owner"] = parameter.of_arm ? "arm" : "station";
  node["in"] = word_of(parameter.in);
  add_number(parameter.number, parameter.unit.si, ending_of(parameter.unit), node);
  if (parameter.at_tool) node["at_tool_mm"] = rounded(*parameter.at_tool / kMillimetre);
  return flow(node);
}

YAML::Node effect_node(const ComparedEffect& effect) {
  YAML::Node node;
  node["name"] = effect.effect.name;
  node["parameter"] = effect.effect.parameter;
  node["driver"] = effect.effect.driver;
  node["shape"] = effect.effect.shape;
  node["owner"] = effect.effect.of_arm() ? "arm" : "station";
  node["in"] = word_of(effect.in);
  if (effect.in == InRuns::both) node["same_shape"] = boolean(effect.same_inner);
  std::vector<YAML::Node> coefficients;
  for (size_t k = 0; k < effect.numbers.size(); ++k) {
    YAML::Node one;
    one["name"] = effect.effect.coefficients[k].name;
    if (!effect.effect.coefficients[k].unit.empty())
      one["unit"] = effect.effect.coefficients[k].unit;
    add_number(effect.numbers[k], 1, "", one);
    coefficients.push_back(flow(one));
  }
  node["coefficients"] = list_node(coefficients);
  return node;
}

YAML::Node curve_node(const RemainderCurve& curve) {
  const auto value = [&](double si) { return rounded(si / curve.unit.si); };
  const std::string ending = ending_of(curve.unit);
  YAML::Node node;
  node["parameter"] = curve.parameter;
  node["driver" + curve.name.unit_ending()] =
      flow_list(curve.q, [&](double q) { return number_in_form("{:.5g}", q / curve.name.si()); });
  node["before" + ending] = flow_list(curve.before, value);
  node["after" + ending] = flow_list(curve.after, value);
  node["rms_before" + ending] = value(curve.rms_before);
  node["rms_after" + ending] = value(curve.rms_after);
  node["rms_change" + ending] = value(curve.rms_change);
  return node;
}

YAML::Node arm_node(const RunComparison& found, const KinematicChain& chain) {
  const ArmDifference& arm = *found.arm;
  YAML::Node node, at;
  node["poses"] = whole_number(arm.q.size());
  node["mean_mm"] = rounded(arm.mean / kMillimetre);
  node["rms_mm"] = rounded(arm.rms / kMillimetre);
  node["max_mm"] = rounded(arm.max / kMillimetre);
  if (arm.hidden.freedom > 0)
    node["rms_elsewhere_mm"] = rounded(arm.rms * arm.times_elsewhere() / kMillimetre);
  if (!found.largest_pose.empty()) node["largest_pose"] = found.largest_pose;
  const std::vector<JointName> names = joint_names(chain);
  for (size_t j = 0; j < names.size(); ++j)
    at[names[j].encoder()] = number_in_form("{:.4f}", arm.q[arm.largest][j] / names[j].si());
  node["largest_at"] = flow(at);
  if (arm.by_chance) node["by_chance_mm"] = rounded(*arm.by_chance / kMillimetre);
  if (arm.p_value) {
    node["p_value"] = rounded(*arm.p_value);
    node["moved"] = boolean(arm.moved());
  }
  if (const auto seen = found.smallest_seen())
    node["smallest_seen_mm"] = rounded(*seen / kMillimetre);
  if (found.by_readings) {
    node["p_value_of_readings"] = rounded(found.by_readings->p_value);
    node["p_value_beside_scale"] = rounded(found.by_readings->p_value_beside_scale);
  }
  if (arm.p_value_of_noise) node["p_value_of_noise"] = rounded(*arm.p_value_of_noise);
  if (arm.scale) {
    YAML::Node scale;
    scale["um_per_m"] = rounded(arm.scale->ratio / 1e-6);
    scale["left_mm"] = rounded(arm.scale->mean / kMillimetre);
    scale["p_value"] = rounded(arm.scale->p_value);
    node["scale"] = flow(scale);
  }
  if (!arm.left_out.empty()) node["left_out"] = texts_node(arm.left_out);
  return node;
}

YAML::Node errors_node(const RunErrors& errors) {
  YAML::Node node;
  if (!errors.verdict.empty()) node["verdict"] = errors.verdict;
  if (!errors.sentence.empty()) node["sentence"] = errors.sentence;
  node["poses"] = whole_number(errors.poses);
  for (const auto& [key, value] :
       {std::pair("before_mm", errors.before), std::pair("after_mm", errors.after),
        std::pair("floor_mm", errors.floor)})
    if (value) node[key] = rounded(*value / kMillimetre);
  return node;
}

YAML::Node run_node(const RunFile& run) {
  YAML::Node node;
  node["file"] = run.name;
  if (run.robot) node["robot"] = run.robot->robot.name;
  if (!run.provenance.command.empty()) {
    node["command"] = run.provenance.command;
    node["version"] = run.provenance.version;
  }
  return node;
}

}  // namespace

Document write_comparison(const RunComparison& found, const std::vector<std::string>& notes,
                          const RunFile& before, const RunFile& after,
                          const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-comparison/1";
  root["provenance"] = provenance_node(provenance);
  root["sentence"] = found.sentence;
  if (found.arms == ComparedArms::two) root["two_arms"] = boolean(true);
  const std::optional<bool> moved = found.arm_moved();
  root["arm_moved"] = moved ? boolean(*moved) : text_or_null("");
  if (const std::string why = found.undecided(); !why.empty()) root["undecided"] = why;
  root["before"] = run_node(before);
  root["after"] = run_node(after);
  root["readings"] = word_of(found.readings);
  root["notes"] = texts_node(notes);
  root["tested"] = whole_number(found.tested);
  root["untested"] = texts_node(found.untested);
  if (found.arm) {
    const KinematicChain& chain = after.robot->robot.chain;
    root["arm"] = arm_node(found, chain);
    std::vector<YAML::Node> parameters, curves;
    for (const ComparedParameter& parameter : found.parameters)
      parameters.push_back(parameter_node(parameter));
    for (const RemainderCurve& curve : found.remainder) curves.push_back(curve_node(curve));
    root["parameters"] = list_node(parameters);
    root["held_apart"] = texts_node(found.held_apart);
    root["remainder"] = list_node(curves);
  }
  std::vector<YAML::Node> effects;
  for (const ComparedEffect& effect : found.effects) effects.push_back(effect_node(effect));
  root["effects"] = list_node(effects);
  if (found.errors) {
    root["errors"]["before"] = errors_node((*found.errors)[0]);
    root["errors"]["after"] = errors_node((*found.errors)[1]);
  }
  return print_document(root);
}

}  // namespace armtrue
