#include "io/products/traced_effect_text.h"

#include <cmath>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/tracing/description.h"
#include "io/products/error_nodes.h"
#include "io/yaml/effect_io.h"

namespace armtrue {
namespace {

YAML::Node rivals_node(const std::vector<Rival>& rivals, const KinematicChain& chain) {
  std::vector<YAML::Node> list;
  for (const Rival& rival : rivals) {
    YAML::Node node = effect_form_node(rival.effect, chain);
    node["correlation"] = number_in_form("{:.3f}", rival.correlation);
    if (std::isfinite(rival.delta_ebic))  // not where a fit is exact
      node["delta_ebic"] = number_in_form("{:.1f}", rival.delta_ebic);
    if (!rival.separated_by.empty()) node["separated_by"] = rival.separated_by;
    list.push_back(flow(node));
  }
  return list_node(list);
}

YAML::Node curve_node(const Effect& effect, const std::vector<CurvePoint>& curve,
                      const Robot& robot) {
  const DisplayUnit unit = display_unit(robot.chain, effect.parameter);
  const bool is_angle = effect.driver.kind == DriverKind::joint_angle;
  const bool travels = is_travel(effect.driver, robot.chain);
  YAML::Node node;
  add_driver_and_value(curve,
                       travels                                  ? DisplayUnit{kMillimetre, "mm"}
                       : is_angle                               ? DisplayUnit{kDegree, "deg"}
                       : effect.driver.kind == DriverKind::time ? DisplayUnit{1, "s"}
                                                                : DisplayUnit{1, "c"},
                       unit, node);
  add_half_width(curve, unit, node);
  if (const auto cycle = is_angle ? strongest_cycle(curve) : std::nullopt)
    node["strongest_cycle"] =
        flow_map({travels ? FlowEntry{"length_mm", rounded(kTurn / cycle->per_turn / kMillimetre)}
                          : FlowEntry{"per_turn", number_in_form("{:.5g}", cycle->per_turn)},
                  {"resolution", rounded(cycle->resolution)},
                  {"amplitude_" + unit.name, rounded(cycle->amplitude / unit.si)},
                  {"share", rounded(cycle->share)}});
  return node;
}

// A value with its interval.
YAML::Node estimate_node(double value, double std, const std::array<double, 2>& ci95) {
  YAML::Node node;
  const auto text = [](double number) { return number_in_form("{:.6g}", number); };
  node["value"] = text(value);
  node["std"] = rounded(std);
  node["ci95"] = flow_list(ci95, text);
  return flow(node);
}

YAML::Node cycle_node(const TracedEffect& traced, const Robot& robot) {
  const double unit = display_unit(robot.chain, traced.effect.parameter).si;
  const Cycle& cycle = *traced.cycle;
  YAML::Node node;
  if (is_length(traced.effect.driver, robot.chain))
    node["length_mm"] = rounded(kTurn / traced.effect.shape.harmonic / kMillimetre);
  else if (cycle.frequency_std > 0)
    node["per_turn"] =
        estimate_node(traced.effect.shape.harmonic, cycle.frequency_std, cycle.frequency_ci95);
  const auto [low, high] = cycle.amplitude_ci95;
  node["amplitude"] =
      estimate_node(cycle.amplitude / unit, cycle.amplitude_std / unit, {low / unit, high / unit});
  node["amplitude"]["unit"] = amplitude_unit(traced.effect, robot);
  node["phase_deg"] = rounded(cycle.phase / kDegree);
  return node;
}

}  // namespace

void add_driver_and_value(const std::vector<CurvePoint>& curve, const DisplayUnit& driver,
                          const DisplayUnit& value, YAML::Node& node) {
  node["driver_" + driver.name] = flow_list(curve, [&](const CurvePoint& point) {
    return number_in_form("{:.5g}", point.driver / driver.si);
  });
  node["value_" + value.name] =
      flow_list(curve, [&](const CurvePoint& point) { return rounded(point.value / value.si); });
}

void add_half_width(const std::vector<CurvePoint>& curve, const DisplayUnit& value,
                    YAML::Node& node) {
  node["half_width_" + value.name] = flow_list(
      curve, [&](const CurvePoint& point) { return rounded(point.half_width / value.si); });
}

YAML::Node traced_node(const TracedEffect& traced, const HeldOutGain* gain,
                       const std::vector<CurvePoint>& curve, const Robot& robot) {
  YAML::Node node = effect_node(traced.effect, robot.chain);
  std::vector<FlowEntry> evidence{
      {"delta_ebic", rounded(traced.evidence.delta_ebic)},
      {"p_value", rounded(traced.evidence.p_value)},
      {"cross_validated_gain", rounded(traced.evidence.cross_validated_gain)},
      {"cross_validated_gain_std", rounded(traced.evidence.cross_validated_gain_error)}};
  if (gain) evidence.emplace_back("held_out_gain_mm", rounded(gain->position / kMillimetre));
  YAML::Node evidence_node = flow_map(evidence);
  if (gain) {
    evidence_node["held_out_gain_ci95_mm"] = interval_node(gain->ci95, kMillimetre);
  }
  node["evidence"] = evidence_node;
  const VarianceShare& share = traced.variance_share;
  node["variance_share"] = rounded(share.value);
  node["variance_share_ci95"] = interval_node(share.ci95, 1);
  node["may_lead"] = boolean(share.may_lead);
  node["indistinguishable"] = rivals_node(traced.indistinguishable, robot.chain);
  if (!traced.ruled_out.empty()) node["ruled_out"] = rivals_node(traced.ruled_out, robot.chain);
  for (const Rival& rival : traced.indistinguishable)
    node["unidentifiable"].push_back(unidentifiable(traced, rival));
  for (const Effect& member : traced.shared_with)
    node["shared_with"].push_back(to_string(member.parameter));
  if (!traced.separated_by.empty()) node["separated_by"] = traced.separated_by;
  if (traced.cycle) node["cycle"] = cycle_node(traced, robot);
  if (traced.step_ci95) {
    const auto [suffix, unit] = inner_unit(traced.effect.driver, robot.chain);
    node["at" + suffix + "_ci95"] =
        flow_list(*traced.step_ci95, [si = unit](double bound) { return number_text(bound, si); });
  }
  if (gain) node["confirmed"] = boolean(gain->confirmed());
  node["sentence"] = for_the_cell(traced, gain, robot);
  node["description"] = in_words(traced, gain, curve, robot);
  if (!curve.empty() && traced.effect.shape.kind == ShapeKind::series)
    node["curve"] = curve_node(traced.effect, curve, robot);
  return node;
}

YAML::Node not_separable_node(const std::vector<RankedCandidate>& candidates) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (const RankedCandidate& candidate : candidates) {
    YAML::Node node = flow_map({{"name", candidate.effect.name},
                                {"parameter", to_string(candidate.effect.parameter)},
                                {"driver", to_string(candidate.effect.driver)}});
    if (!candidate.separated_by.empty()) node["separated_by"] = candidate.separated_by;
    list.push_back(node);
  }
  return list;
}

}  // namespace armtrue
