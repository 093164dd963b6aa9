#include "armtrue/io/products/loop_io.h"

#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/intervals.h"
#include "armtrue/tracing/description.h"
#include "io/products/error_nodes.h"
#include "io/products/gross_poses_text.h"
#include "io/products/traced_effect_text.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

YAML::Node stage_node(const Stage& stage, bool held_out) {
  YAML::Node node;
  node["name"] = stage.name;
  node["parameters"] = whole_number(stage.parameters);
  node["training"] = errors_node(stage.training);
  if (held_out) node["held_out"] = errors_node(stage.held_out);
  return node;
}

YAML::Node data_node(const LoopResult& result, const TraceOptions& options) {
  YAML::Node data =
      flow_map({{"poses", whole_number(result.training_poses + result.held_out_poses)},
                {"rows", whole_number(result.rows)},
                {"held_out_poses", whole_number(result.held_out_poses)},
                {"seed", whole_number(options.seed)}});
  if (result.of_distances) data["measured"] = "distances";
  if (result.of_touches) data["measured"] = "touches";
  data["excluded_rows"] = lines_node(result.excluded_rows);
  if (!result.not_judged_rows.empty()) data["not_judged_rows"] = lines_node(result.not_judged_rows);
  if (!result.gross_poses.empty()) data["gross_poses"] = gross_poses_node(result.gross_poses);
  return data;
}

YAML::Node before_after_node(const LoopResult& result) {
  const bool held_out = result.held_out_poses > 0;
  const auto if_held_out = [&](double value) {
    return rounded_or_null(held_out ? std::optional(value) : std::nullopt);
  };
  YAML::Node before_after;
  before_after["before_mm"] = if_held_out(result.before / kMillimetre);
  before_after["after_mm"] = if_held_out(result.after / kMillimetre);
  if (result.after_arm) before_after["after_arm_mm"] = rounded(*result.after_arm / kMillimetre);
  if (result.after_readings)
    before_after["after_readings_mm"] = rounded(*result.after_readings / kMillimetre);
  before_after["floor_mm"] = floor_node(result.noise, result.floor);
  before_after["reducible_removed"] = if_held_out(result.reducible_removed);
  if (held_out) before_after["gain_ci95_mm"] = interval_node(result.gain_ci95, kMillimetre);
  if (result.noise.source == NoiseFloor::Source::replicates)
    before_after["floor_ci95_mm"] =
        interval_node(deviation_ci95(result.floor, result.noise.degrees_of_freedom), kMillimetre);
  if (held_out) before_after["reducible_removed_ci95"] = interval_node(result.removed_ci95, 1);
  return flow(before_after);
}

YAML::Node rejected_node(const RejectedModel& rejected) {
  YAML::Node node, effects;
  for (const std::string& effect : rejected.effects) effects.push_back(effect);
  node["after_mm"] = rounded(rejected.after / kMillimetre);
  node["gain_ci95_mm"] = interval_node(rejected.gain_ci95, kMillimetre);
  node["effects"] = effects;
  return node;
}

YAML::Node joint_curve_node(const JointCurve& curve, const Robot& robot) {
  const KinematicChain& chain = robot.chain;
  const bool travels = is_prismatic(chain.links[link_of_joint(chain, curve.joint)]);
  const Parameter parameter = parameter_name(chain, zero_offset(chain, curve.joint));
  const DisplayUnit unit = display_unit(chain, parameter);
  YAML::Node node;
  node["parameter"] = to_string(parameter);
  add_driver_and_value(curve.points,
                       travels ? DisplayUnit{kMillimetre, "mm"} : DisplayUnit{kDegree, "deg"}, unit,
                       node);
  node["named_" + unit.name] =
      flow_list(curve.named, [&](double named) { return rounded(named / unit.si); });
  add_half_width(curve.points, unit, node);
  return node;
}

YAML::Node nested_node(const NestedValidation& nested, const std::vector<TracedEffect>& effects) {
  const auto in_mm = [](double value) { return rounded(value / kMillimetre); };
  YAML::Node node = flow_map({{"folds", whole_number(nested.folds)},
                              {"before_mm", in_mm(nested.before.mean)},
                              {"before_se_mm", in_mm(nested.before.error)},
                              {"after_mm", in_mm(nested.after.mean)},
                              {"after_se_mm", in_mm(nested.after.error)},
                              {"gain_mm", in_mm(nested.gain.mean)},
                              {"gain_se_mm", in_mm(nested.gain.error)}});
  YAML::Node found_again(YAML::NodeType::Sequence);
  for (size_t k = 0; k < effects.size(); ++k)
    found_again.push_back(flow_map({{"parameter", to_string(effects[k].effect.parameter)},
                                    {"driver", to_string(effects[k].effect.driver)},
                                    {"folds", whole_number(nested.found_again[k])}}));
  node["found_again"] = flow(found_again);
  return node;
}

}  // namespace

Document write_loop(const LoopResult& result, const TraceOptions& options,
                    const Provenance& provenance, const std::string& next_poses) {
  const Robot& robot = result.trace.fit.robot;
  YAML::Node root;
  root["format"] = "armtrue-loop/1";
  root["provenance"] = provenance_node(provenance);
  root["verdict"] = to_string(result.verdict);
  root["sentence"] = verdict_in_words(result);
  root["noise_floor"] = noise_node(result.noise);
  root["data"] = data_node(result, options);
  const bool held_out = result.held_out_poses > 0;
  for (const Stage& stage : result.stages) root["stages"].push_back(stage_node(stage, held_out));
  if (!robot.sessions.empty()) root["sessions"] = sessions_node(robot);
  root["effects"] = YAML::Node(YAML::NodeType::Sequence);
  for (size_t k = 0; k < result.trace.effects.size(); ++k)
    root["effects"].push_back(traced_node(result.trace.effects[k],
                                          k < result.gains.size() ? &result.gains[k] : nullptr,
                                          result.curves[k], robot));
  if (result.trace.effects.empty()) root["effects"] = flow(root["effects"]);
  root["before_after"] = before_after_node(result);
  if (held_out) root["before_after"]["outside_p"] = rounded(result.outside_p);
  if (result.worst)
    root["worst_held_out"] = flow_map(
        {{"pose", result.worst->pose}, {"after_mm", rounded(result.worst->error / kMillimetre)}});
  if (!result.contradicted_rows.empty()) {
    root["contradicted"]["rows"] = lines_node(result.contradicted_rows);
    root["contradicted"]["after_mm"] = rounded(result.after_sound / kMillimetre);
  }
  if (!result.gross_held_out.empty())
    root["gross_held_out"]["poses"] = gross_poses_node(result.gross_held_out);
  if (result.are_blunders)
    root["gross_held_out"]["after_mm"] = rounded(result.after_sound / kMillimetre);
  if (result.scale) root["unseen_scale"] = unseen_scale_node(*result.scale);
  for (const Effect& effect : result.held)
    root["held_by_priors"].push_back(effect_node(effect, robot.chain));
  for (const std::string& effect : result.without_gain) root["without_gain"].push_back(effect);
  if (result.rejected) root["rejected"] = rejected_node(*result.rejected);
  for (const Part& part : result.parts)
    root["arm_and_station"].push_back(flow_map({{"what", part.what},
                                                {"owner", part.of_arm ? "arm" : "station"},
                                                {"rms_mm", rounded(part.position / kMillimetre)}}));
  if (result.applied) {
    root["predictor"] = stage_node(result.applied->stage, held_out);
    for (const GroupShare& group : result.applied->groups)
      root["without_name"].push_back(flow_map({{"group", group.name},
                                               {"owner", group.of_arm ? "arm" : "station"},
                                               {"of_noise", rounded(group.of_noise)}}));
    for (const JointCurve& curve : result.joints)
      root["joint_curves"].push_back(joint_curve_node(curve, result.applied->fit.robot));
  }
  if (result.nested) root["nested_cv"] = nested_node(*result.nested, result.trace.effects);
  YAML::Node remaining;
  remaining["lack_of_fit_p"] = rounded_or_null(result.lack_of_fit);
  remaining["pattern"] = text_or_null(result.pattern);
  remaining["pattern_p"] = rounded(result.trace.remaining_p);
  if (!result.explanation.empty()) remaining["explanation"] = result.explanation;
  root["remaining"] = flow(remaining);
  const NullRun& null_run = result.trace.null_run;
  root["null_run"] = flow_map({{"flips", whole_number(null_run.flips)},
                               {"false_add_rate", rounded(null_run.false_add_rate)},
                               {"delta_ebic_95", rounded_or_null(null_run.score_95)}});
  root["not_separable"] = not_separable_node(result.trace.not_separable);
  root["next_poses"] = text_or_null(next_poses);
  return print_document(root);
}

}  // namespace armtrue
