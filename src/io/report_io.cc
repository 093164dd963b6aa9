#include "armtrue/io/report_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "armtrue/io/source.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "io/effect_io.h"
#include "io/yaml_text.h"

namespace armtrue {
namespace {

// At spaces; what follows the first line is indented.
std::vector<std::string> in_lines(const std::string& text, size_t width) {
  std::vector<std::string> lines{""};
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > width)
      lines.push_back("   ");
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

YAML::Node text_or_null(const std::string& text) {
  return text.empty() ? YAML::Node(YAML::NodeType::Null) : YAML::Node(text);
}

YAML::Node stage_errors_node(const StageErrors& errors) {
  YAML::Node node;
  node["position_mm"] = error_node(errors.position, kMillimetre);
  if (errors.orientation) node["orientation_mrad"] = error_node(*errors.orientation, kMilliradian);
  return node;
}

YAML::Node stage_node(const Stage& stage, bool held_out) {
  YAML::Node node;
  node["name"] = stage.name;
  node["parameters"] = std::to_string(stage.parameters);
  node["training"] = stage_errors_node(stage.training);
  if (held_out) node["held_out"] = stage_errors_node(stage.held_out);
  return node;
}

YAML::Node noise_node(const NoiseFloor& noise) {
  static constexpr const char* kSources[] = {"replicates", "instrument", "none"};
  std::vector<std::pair<std::string, std::string>> entries{
      {"source", kSources[static_cast<int>(noise.source)]},
      {"position_mm", rounded(noise.position / kMillimetre)}};
  if (noise.orientation > 0)
    entries.emplace_back("orientation_mrad", rounded(noise.orientation / kMilliradian));
  return flow_map(entries);
}

YAML::Node rivals_node(const std::vector<Rival>& rivals) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (const Rival& rival : rivals) {
    YAML::Node node = effect_form_node(rival.effect);
    node["correlation"] = fmt::format("{:.3f}", rival.correlation);
    node["delta_ebic"] = fmt::format("{:.1f}", rival.delta_ebic);
    if (!rival.separated_by.empty()) node["separated_by"] = rival.separated_by;
    list.push_back(flow(node));
  }
  if (rivals.empty()) return flow(list);
  return list;
}

std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (size_t k = 0; k < items.size(); ++k)
    text += (k == 0 ? "" : k + 1 < items.size() ? ", " : " and ") + items[k];
  return text;
}

// Which change of the model these readings do not show.
std::string unidentifiable(const TracedEffect& traced, const Rival& rival) {
  const double apart = std::sqrt(std::max(0.0, 1.0 - rival.correlation * rival.correlation));
  std::string text = fmt::format(
      "more of '{}' and less of '{}'{}: they differ here by {:.2g} % of their size",
      describe(traced.effect), describe(rival.effect),
      rival.refitted.empty() ? "" : ", with " + listed(rival.refitted) + " refitted", 100 * apart);
  std::vector<std::string> readings;
  for (const std::string& reading : {traced.separated_by, rival.separated_by})
    if (!reading.empty() && (readings.empty() || readings.front() != reading))
      readings.push_back(reading);
  if (!readings.empty()) text += "; what would tell: " + readings.front();
  if (readings.size() > 1) text += "; or " + readings.back();
  return text;
}

DisplayUnit shown_in(const Robot& robot, const std::string& parameter) {
  return display_unit(unit_of_parameter(robot.chain, parameter));
}

// "0.8 mrad", "0.3 mm", "12 ppm".
std::string size_text(const Robot& robot, const std::string& parameter, double value) {
  const DisplayUnit unit = shown_in(robot, parameter);
  return fmt::format("{:.3g} {}", value / unit.si, unit.name);
}

std::string driver_text(const Effect& effect, double value) {
  switch (effect.driver.kind) {
    case DriverKind::joint_angle:
      return fmt::format("{:.0f} deg", value / kDegree);
    case DriverKind::time:
      return fmt::format("{:.0f} s", value);
    default:
      return fmt::format("{:.1f} degC", value);
  }
}

// Of an amplitude: "mrad", or "mrad per K" of the factor.
std::string amplitude_unit(const Effect& effect, const Robot& robot) {
  const ParameterUnit moved = unit_of_parameter(robot.chain, effect.parameter);
  const std::string unit = display_unit(moved).name;
  const std::string of_factor = effect.driver.factor ? unit_of(*effect.driver.factor, moved) : "";
  return of_factor.empty() ? unit : unit + " per " + of_factor;
}

// "37.41 +- 0.03 cycles per turn, amplitude 0.21 +- 0.04 mrad, phase 41 deg".
std::string cycle_text(const Effect& effect, const Cycle& cycle, const Robot& robot) {
  const double unit = shown_in(robot, effect.parameter).si;
  const double half_width = 0.5 * (cycle.amplitude_ci95[1] - cycle.amplitude_ci95[0]);
  std::string frequency = fmt::format("{:g}", effect.shape.harmonic);
  if (cycle.frequency_std > 0) {
    const double of_frequency = 0.5 * (cycle.frequency_ci95[1] - cycle.frequency_ci95[0]);
    const int digits =
        static_cast<int>(std::clamp(std::ceil(1 - std::log10(of_frequency)), 0.0, 6.0));
    frequency = fmt::format("{:.{}f} +- {:.2g}", effect.shape.harmonic, digits, of_frequency);
  }
  return fmt::format("{} cycles per turn, amplitude {:.3g} +- {:.2g} {}, phase {:.0f} deg",
                     frequency, cycle.amplitude / unit, half_width / unit,
                     amplitude_unit(effect, robot), cycle.phase / kDegree);
}

// "a step of 0.33 mrad between 1580 and 1660 s".
std::string step_text(const TracedEffect& step, const Robot& robot) {
  const std::vector<Coefficient>& c = step.effect.coefficients;
  const std::string size =
      c.size() == 1 ? " of " + size_text(robot, step.effect.parameter, c.front().value) : "";
  const auto [low, high] = *step.step_ci95;
  return fmt::format("a step{} between {:.0f} and {:.0f} s", size, low, high);
}

// The course of an effect in words: "0.8 mrad peak at 90 deg, even".
std::string course(const Effect& effect, const std::vector<CurvePoint>& curve, const Robot& robot) {
  if (curve.empty()) return "";
  const auto peak =
      std::max_element(curve.begin(), curve.end(), [](const CurvePoint& a, const CurvePoint& b) {
        return std::abs(a.value) < std::abs(b.value);
      });
  std::string text = fmt::format("{} at {}", size_text(robot, effect.parameter, peak->value),
                                 driver_text(effect, peak->driver));
  if (effect.driver.kind != DriverKind::joint_angle) return text;
  double even = 0, odd = 0;
  for (size_t i = 0; i < curve.size(); ++i) {
    const double a = curve[i].value, b = curve[curve.size() - 1 - i].value;
    even += (a + b) * (a + b);
    odd += (a - b) * (a - b);
  }
  const bool about_zero = std::abs(curve.front().driver + curve.back().driver) <
                          0.1 * (curve.back().driver - curve.front().driver);
  if (about_zero && even > 9 * odd) text += ", even";
  if (about_zero && odd > 9 * even) text += ", odd";
  if (const auto cycle = strongest_cycle(curve))
    text +=
        fmt::format(", of which {:.0f} % is a cycle of {:.4g} per turn and {}", 100 * cycle->share,
                    cycle->per_turn, size_text(robot, effect.parameter, cycle->amplitude));
  return text;
}

// It entered because training poses that were left out gain by it.
std::string of_prediction(const HeldOutGain* gain) {
  if (!gain || gain->ci95[0] > 0) return "prediction improves";
  return "prediction improves for training poses left out, not clearly for the held-out ones";
}

std::string statement(const TracedEffect& effect, const HeldOutGain* gain) {
  if (!effect.from_catalogue) return of_prediction(gain) + "; no known cause";
  if (effect.incomplete)
    return "incomplete: what it leaves still follows the same driver, see the other effect on it";
  if (effect.indistinguishable.empty())
    return "cause shown: no other candidate explains these readings";
  return of_prediction(gain) + "; cause is one of the class under indistinguishable";
}

std::string in_words(const TracedEffect& traced, const HeldOutGain* gain,
                     const std::vector<CurvePoint>& curve, const Robot& robot) {
  const std::string words = traced.cycle       ? cycle_text(traced.effect, *traced.cycle, robot)
                            : traced.step_ci95 ? step_text(traced, robot)
                                               : course(traced.effect, curve, robot);
  std::string text = traced.effect.parameter + " depends on " + to_string(traced.effect.driver) +
                     (words.empty() ? "" : ", " + words) + "; " + statement(traced, gain);
  // A knock is no property of the robot.
  if (traced.effect.parameter.starts_with("base") &&
      traced.effect.driver.kind == DriverKind::time && traced.effect.shape.kind == ShapeKind::step)
    text += "; --new-session-at-s " + number_text(traced.effect.shape.at) +
            " makes a session of its own of what follows";
  const DriverKind driver = traced.effect.driver.kind;
  if ((driver == DriverKind::gravity_torque || driver == DriverKind::moment) &&
      !robot.bodies.empty())
    text += "; intervals are given the masses of the robot file, which they take as exact";
  return text;
}

YAML::Node curve_node(const Effect& effect, const std::vector<CurvePoint>& curve,
                      const Robot& robot) {
  const DisplayUnit unit = shown_in(robot, effect.parameter);
  const bool is_angle = effect.driver.kind == DriverKind::joint_angle;
  YAML::Node drivers, values, half_widths;
  for (const CurvePoint& point : curve) {
    drivers.push_back(fmt::format("{:.5g}", is_angle ? point.driver / kDegree : point.driver));
    values.push_back(rounded(point.value / unit.si));
    half_widths.push_back(rounded(point.half_width / unit.si));
  }
  YAML::Node node;
  node[is_angle                                 ? "driver_deg"
       : effect.driver.kind == DriverKind::time ? "driver_s"
                                                : "driver_c"] = flow(drivers);
  node["value_" + unit.name] = flow(values);
  node["half_width_" + unit.name] = flow(half_widths);
  if (const auto cycle = is_angle ? strongest_cycle(curve) : std::nullopt)
    node["strongest_cycle"] =
        flow_map({{"per_turn", fmt::format("{:.5g}", cycle->per_turn)},
                  {"resolution", rounded(cycle->resolution)},
                  {"amplitude_" + unit.name, rounded(cycle->amplitude / unit.si)},
                  {"share", rounded(cycle->share)}});
  return node;
}

// A value with its interval.
YAML::Node estimate_node(double value, double std, const std::array<double, 2>& ci95) {
  YAML::Node node, interval;
  const auto text = [](double number) { return fmt::format("{:.6g}", number); };
  for (double bound : ci95) interval.push_back(text(bound));
  node["value"] = text(value);
  node["std"] = rounded(std);
  node["ci95"] = flow(interval);
  return flow(node);
}

YAML::Node cycle_node(const TracedEffect& traced, const Robot& robot) {
  const double unit = shown_in(robot, traced.effect.parameter).si;
  const Cycle& cycle = *traced.cycle;
  YAML::Node node;
  if (cycle.frequency_std > 0)
    node["per_turn"] =
        estimate_node(traced.effect.shape.harmonic, cycle.frequency_std, cycle.frequency_ci95);
  const auto [low, high] = cycle.amplitude_ci95;
  node["amplitude"] =
      estimate_node(cycle.amplitude / unit, cycle.amplitude_std / unit, {low / unit, high / unit});
  node["amplitude"]["unit"] = amplitude_unit(traced.effect, robot);
  node["phase_deg"] = rounded(cycle.phase / kDegree);
  return node;
}

YAML::Node traced_node(const TracedEffect& traced, const HeldOutGain* gain,
                       const std::vector<CurvePoint>& curve, const Robot& robot) {
  YAML::Node node = effect_node(traced.effect, robot.chain);
  std::vector<std::pair<std::string, std::string>> evidence{
      {"delta_ebic", rounded(traced.evidence.delta_ebic)},
      {"p_value", rounded(traced.evidence.p_value)},
      {"cross_validated_gain", rounded(traced.evidence.cross_validated_gain)},
      {"cross_validated_gain_std", rounded(traced.evidence.cross_validated_gain_error)}};
  if (gain) evidence.emplace_back("held_out_gain_mm", rounded(gain->position / kMillimetre));
  YAML::Node evidence_node = flow_map(evidence);
  if (gain) {
    YAML::Node interval;
    for (double bound : gain->ci95) interval.push_back(rounded(bound / kMillimetre));
    evidence_node["held_out_gain_ci95_mm"] = flow(interval);
  }
  node["evidence"] = evidence_node;
  const VarianceShare& share = traced.variance_share;
  YAML::Node share_interval;
  for (double bound : share.ci95) share_interval.push_back(rounded(bound));
  node["variance_share"] = rounded(share.value);
  node["variance_share_ci95"] = flow(share_interval);
  node["may_lead"] = share.may_lead ? "true" : "false";
  node["indistinguishable"] = rivals_node(traced.indistinguishable);
  if (!traced.ruled_out.empty()) node["ruled_out"] = rivals_node(traced.ruled_out);
  for (const Rival& rival : traced.indistinguishable)
    node["unidentifiable"].push_back(unidentifiable(traced, rival));
  if (!traced.separated_by.empty()) node["separated_by"] = traced.separated_by;
  if (traced.cycle) node["cycle"] = cycle_node(traced, robot);
  if (traced.step_ci95) {
    YAML::Node interval;
    for (double bound : *traced.step_ci95) interval.push_back(number_text(bound));
    node["at_s_ci95"] = flow(interval);
  }
  node["description"] = in_words(traced, gain, curve, robot);
  if (!curve.empty() && traced.effect.shape.kind == ShapeKind::series)
    node["curve"] = curve_node(traced.effect, curve, robot);
  return node;
}

// What each effect explains, and whether these poses tell which explains most.
std::string shares_table(const std::vector<TracedEffect>& effects) {
  if (effects.empty()) return "";
  std::string table = "share of the variance that the effects explain";
  table += effects.size() > 1 ? ", 95 %\n" : "\n";
  std::vector<std::string> leading;
  for (const TracedEffect& traced : effects) {
    const auto& [share, ci95, may_lead] = traced.variance_share;
    table += fmt::format("{:>7.1f} %  ", 100 * share);
    if (effects.size() > 1)
      table += fmt::format("{:>3.0f} to {:>3.0f}  ", 100 * ci95[0], 100 * ci95[1]);
    table += describe(traced.effect) + "\n";
    const std::string place = traced.effect.parameter + " by " + to_string(traced.effect.driver);
    if (may_lead && std::find(leading.begin(), leading.end(), place) == leading.end())
      leading.push_back(place);
  }
  if (leading.size() > 1)
    table += "these poses do not tell which explains most: " + listed(leading) + "\n";
  return table;
}

YAML::Node nested_node(const NestedValidation& nested, const std::vector<TracedEffect>& effects) {
  const auto in_mm = [](double value) { return rounded(value / kMillimetre); };
  YAML::Node node = flow_map({{"folds", std::to_string(nested.folds)},
                              {"before_mm", in_mm(nested.before.mean)},
                              {"before_se_mm", in_mm(nested.before.error)},
                              {"after_mm", in_mm(nested.after.mean)},
                              {"after_se_mm", in_mm(nested.after.error)},
                              {"gain_mm", in_mm(nested.gain.mean)},
                              {"gain_se_mm", in_mm(nested.gain.error)}});
  YAML::Node found_again(YAML::NodeType::Sequence);
  for (size_t k = 0; k < effects.size(); ++k)
    found_again.push_back(flow_map({{"parameter", effects[k].effect.parameter},
                                    {"driver", to_string(effects[k].effect.driver)},
                                    {"folds", std::to_string(nested.found_again[k])}}));
  node["found_again"] = flow(found_again);
  return node;
}

YAML::Node not_separable_node(const std::vector<RankedCandidate>& candidates) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (const RankedCandidate& candidate : candidates) {
    YAML::Node node = flow_map({{"name", candidate.effect.name},
                                {"parameter", candidate.effect.parameter},
                                {"driver", to_string(candidate.effect.driver)}});
    if (!candidate.separated_by.empty()) node["separated_by"] = candidate.separated_by;
    list.push_back(node);
  }
  return list;
}

// "change_mm" or "change_deg", with its deviation and interval.
YAML::Node change_node(const KinematicChain& chain, const ParameterChange& change) {
  const bool is_length = parameter_unit(change.parameter) == ParameterUnit::metre;
  const double unit = is_length ? kMillimetre : kDegree;
  const std::string suffix = is_length ? "_mm" : "_deg";
  YAML::Node node, interval;
  for (double bound : change.ci95) interval.push_back(rounded(bound / unit));
  node["parameter"] = parameter_name(chain, change.parameter);
  node["change" + suffix] = rounded(change.value / unit);
  node["std" + suffix] = rounded(change.std / unit);
  node["ci95" + suffix] = flow(interval);
  return flow(node);
}

YAML::Node move_node(const KinematicChain& chain, const Move& move) {
  YAML::Node node;
  if (move.changes.size() == 1) {
    node = change_node(chain, move.changes.front());
  } else {
    node["parameter"] = move.what;
    for (const ParameterChange& change : move.changes)
      node["changes"].push_back(change_node(chain, change));
  }
  for (const std::string& session : move.sessions) node["sessions"].push_back(session);
  node["p_value"] = rounded(move.p_value);
  return node;
}

// A move of the robot, as part of an explanation.
YAML::Node explaining_node(const KinematicChain& chain, const Move& move) {
  YAML::Node node = move_node(chain, move);
  node["delta_bic"] = rounded(move.delta_bic);
  node["p_value_left"] = rounded(move.p_value_left);
  return node;
}

YAML::Node list_node(const std::vector<YAML::Node>& items) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (const YAML::Node& item : items) list.push_back(item);
  return items.empty() ? flow(list) : list;
}

// The strongest absorbers of one parameter.
std::string absorbers(const KinematicChain& chain, const AbsorbedParameter& absorbed) {
  if (absorbed.absorbed_by.empty()) return "moves nothing that was measured";
  std::string text;
  constexpr size_t kMost = 4;
  for (size_t i = 0; i < std::min(kMost, absorbed.absorbed_by.size()); ++i) {
    text += (i ? ", " : "") + parameter_name(chain, absorbed.absorbed_by[i].first);
  }
  if (absorbed.absorbed_by.size() > kMost)
    text += fmt::format(" and {} more", absorbed.absorbed_by.size() - kMost);
  return text;
}

YAML::Node zone_node(const WeightedZone& weighted_zone) {
  const auto& [zone, inside] = weighted_zone;
  return flow_map({{"x_mm", number_text(zone.centre.x(), kMillimetre)},
                   {"y_mm", number_text(zone.centre.y(), kMillimetre)},
                   {"z_mm", number_text(zone.centre.z(), kMillimetre)},
                   {"radius_mm", number_text(zone.radius, kMillimetre)},
                   {"readings_inside", std::to_string(inside)}});
}

YAML::Node calibration_node(const CalibrationResult& result, const Campaign& campaign) {
  const Robot& robot = result.robot;
  YAML::Node node;
  node["converged"] = result.converged ? "true" : "false";
  node["iterations"] = std::to_string(result.iterations);
  node["poses"] = std::to_string(campaign.pose_ids.size());
  node["rows"] = std::to_string(campaign.rows());
  node["unknowns"] = std::to_string(result.names.size());
  node["rank"] = std::to_string(result.rank);
  node["condition"] = rounded(result.condition);
  YAML::Node observability;
  for (size_t k = 0; k < result.observability.size(); ++k)
    observability["O" + std::to_string(k + 1)] = rounded(result.observability[k]);
  node["observability"] = flow(observability);
  std::vector<std::pair<std::string, std::string>> spread{
      {"position_mm", rounded(result.spread.position / kMillimetre)}};
  if (campaign.has_orientation())
    spread.emplace_back("orientation_mrad", rounded(result.spread.orientation / kMilliradian));
  node["residual_spread"] = flow_map(spread);
  node["residual_law"] = result.degrees_of_freedom > 0
                             ? fmt::format("student-t {:g}", result.degrees_of_freedom)
                             : std::string("normal");
  node["training"] = stage_errors_node([&] {
    const Evaluation evaluation = evaluate(robot, campaign);
    StageErrors errors{summarize(evaluation.position), std::nullopt};
    if (!evaluation.orientation.empty()) errors.orientation = summarize(evaluation.orientation);
    return errors;
  }());
  YAML::Node identified(YAML::NodeType::Sequence);
  for (int k : result.set.kept) identified.push_back(parameter_name(robot.chain, k));
  node["identified"] = flow(identified);
  for (const AbsorbedParameter& absorbed : result.set.absorbed)
    node["absorbed"][parameter_name(robot.chain, absorbed.parameter)] =
        absorbers(robot.chain, absorbed);
  return node;
}

}  // namespace

std::string write_calibration(const CalibrationResult& result, const Campaign& campaign,
                              const Provenance& provenance,
                              const std::optional<WeightedZone>& weighted_zone) {
  YAML::Node root = robot_node(result.robot, provenance);
  root["calibration"] = calibration_node(result, campaign);
  if (weighted_zone) root["calibration"]["zone"] = zone_node(*weighted_zone);
  return print_document(root);
}

std::string write_summary(const Evaluation& evaluation, const Robot& robot,
                          const Campaign& campaign, const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-summary/1";
  root["provenance"] = provenance_node(provenance);
  root["robot"] = robot.name;
  root["poses"] = std::to_string(campaign.pose_ids.size());
  root["rows"] = std::to_string(campaign.rows());
  root["skipped_rows"] = std::to_string(campaign.skipped_rows);
  root["noise_floor"] = noise_node(noise_floor(robot, campaign, evaluation));
  root["position_mm"] = error_node(summarize(evaluation.position), kMillimetre);
  if (!evaluation.orientation.empty())
    root["orientation_mrad"] = error_node(summarize(evaluation.orientation), kMilliradian);
  YAML::Node axes;
  for (int i = 0; i < campaign.reading_size().position; ++i) {
    double sum = 0, low = 1e300, high = -1e300;
    for (const auto& residual : evaluation.residuals) {
      sum += residual[i];
      low = std::min(low, residual[i]);
      high = std::max(high, residual[i]);
    }
    axes[std::string(1, campaign.has_distances() ? 'l' : "xyz"[i])] =
        flow_map({{"mean", rounded(sum / kMillimetre / static_cast<double>(campaign.rows()))},
                  {"min", rounded(low / kMillimetre)},
                  {"max", rounded(high / kMillimetre)}});
  }
  root["axes_mm"] = axes;
  return print_document(root);
}

std::string write_ranking(const TraceResult& result, const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-ranking/1";
  root["provenance"] = provenance_node(provenance);
  root["effects"] = YAML::Node(YAML::NodeType::Sequence);
  for (const TracedEffect& traced : result.effects)
    root["effects"].push_back(traced_node(traced, nullptr, {}, result.fit.robot));
  root["remaining"] = flow_map(
      {{"best_delta_ebic", rounded(result.best_score)}, {"p_value", rounded(result.remaining_p)}});
  for (const RankedCandidate& ranked : result.ranking)
    root["candidates"].push_back(
        flow_map({{"name", ranked.effect.name},
                  {"parameter", ranked.effect.parameter},
                  {"driver", to_string(ranked.effect.driver)},
                  {"shape", to_string(ranked.effect.shape)},
                  {"degrees_of_freedom", std::to_string(ranked.degrees_of_freedom)},
                  {"left", rounded(ranked.unexplained_share)},
                  {"delta_ebic", rounded(ranked.score)}}));
  root["not_separable"] = not_separable_node(result.not_separable);
  return print_document(root);
}

std::vector<TracedEffect> read_findings(const std::string& path, const KinematicChain& chain) {
  Source source(path);
  YamlMap document =
      read_document(source.read_all(), source.name(), {"armtrue-ranking/1", "armtrue-loop/1"});
  std::vector<TracedEffect> found;
  for (YamlMap& entry : document.maps("effects")) {
    TracedEffect& traced = found.emplace_back();
    traced.separated_by = entry.text("separated_by", "");
    for (YamlMap& other : entry.maps("indistinguishable")) {
      Rival& rival = traced.indistinguishable.emplace_back();
      rival.effect = read_effect_form(other, chain);
      rival.effect.name = other.text("name", "rival");
      rival.correlation = other.number("correlation", 0);
      rival.delta_ebic = other.number("delta_ebic", 0);
      rival.separated_by = other.text("separated_by", "");
      other.finish();
    }
    traced.effect = read_effect(entry, chain);
  }
  return found;
}

std::string write_change(const ChangeResult& result, const Robot& previous,
                         const Campaign& campaign, const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-change/1";
  root["provenance"] = provenance_node(provenance);
  root["robot"] = previous.name;
  root["holds"] = result.holds ? "true" : "false";
  root["p_value"] = rounded(result.p_value);
  root["poses"] = std::to_string(campaign.pose_ids.size());
  root["rows"] = std::to_string(campaign.rows());
  YAML::Node excluded(YAML::NodeType::Sequence);
  for (int row : result.blunders) excluded.push_back(std::to_string(campaign.line[row]));
  root["excluded_rows"] = flow(excluded);
  std::vector<std::pair<std::string, std::string>> spread{
      {"position_mm", rounded(result.scale.position / kMillimetre)}};
  if (campaign.has_orientation())
    spread.emplace_back("orientation_mrad", rounded(result.scale.orientation / kMilliradian));
  root["spread"] = flow_map(spread);
  root["mean_error_mm"] = flow_map({{"before", rounded(result.before / kMillimetre)},
                                    {"after", rounded(result.after / kMillimetre)}});
  std::vector<YAML::Node> moved, indistinguishable, stations;
  for (const Move& move : result.moved) {
    moved.push_back(explaining_node(previous.chain, move));
    for (const Move& rival : move.indistinguishable) {
      YAML::Node& node = indistinguishable.emplace_back(explaining_node(previous.chain, rival));
      node["instead_of"] = move.what;
    }
  }
  for (const Move& station : result.stations)
    stations.push_back(move_node(previous.chain, station));
  root["moved"] = list_node(moved);
  root["indistinguishable"] = list_node(indistinguishable);
  root["p_value_left"] = rounded(result.p_value_left);
  if (!campaign.session_names.empty()) root["stations"] = list_node(stations);
  return print_document(root);
}

std::string write_loop(const LoopResult& result, const TraceOptions& options,
                       const Provenance& provenance, const std::string& next_poses) {
  const Robot& robot = result.trace.fit.robot;
  YAML::Node root;
  root["format"] = "armtrue-loop/1";
  root["provenance"] = provenance_node(provenance);
  root["verdict"] = to_string(result.verdict);
  root["noise_floor"] = noise_node(result.noise);
  YAML::Node data =
      flow_map({{"poses", std::to_string(result.training_poses + result.held_out_poses)},
                {"rows", std::to_string(result.rows)},
                {"held_out_poses", std::to_string(result.held_out_poses)},
                {"seed", std::to_string(options.seed)}});
  if (result.of_distances) data["measured"] = "distances";
  YAML::Node excluded(YAML::NodeType::Sequence);
  for (int line : result.excluded_rows) excluded.push_back(std::to_string(line));
  data["excluded_rows"] = flow(excluded);
  root["data"] = data;
  const bool held_out = result.held_out_poses > 0;
  for (const Stage& stage : result.stages) root["stages"].push_back(stage_node(stage, held_out));
  if (!robot.sessions.empty()) root["sessions"] = sessions_node(robot);
  root["effects"] = YAML::Node(YAML::NodeType::Sequence);
  for (size_t k = 0; k < result.trace.effects.size(); ++k)
    root["effects"].push_back(traced_node(result.trace.effects[k],
                                          k < result.gains.size() ? &result.gains[k] : nullptr,
                                          result.curves[k], robot));
  if (result.trace.effects.empty()) root["effects"] = flow(root["effects"]);
  const auto if_held_out = [&](double value) {
    return text_or_null(held_out ? rounded(value) : "");
  };
  YAML::Node before_after;
  before_after["before_mm"] = if_held_out(result.before / kMillimetre);
  before_after["after_mm"] = if_held_out(result.after / kMillimetre);
  before_after["floor_mm"] = rounded(result.floor / kMillimetre);
  before_after["reducible_removed"] = if_held_out(result.reducible_removed);
  YAML::Node interval;
  for (double bound : result.gain_ci95) interval.push_back(rounded(bound / kMillimetre));
  if (held_out) before_after["gain_ci95_mm"] = flow(interval);
  before_after = flow(before_after);
  root["before_after"] = before_after;
  if (result.predictor) root["predictor"] = stage_node(result.predictor->stage, held_out);
  if (result.nested) root["nested_cv"] = nested_node(*result.nested, result.trace.effects);
  YAML::Node remaining;
  remaining["lack_of_fit_p"] = text_or_null(result.lack_of_fit ? rounded(*result.lack_of_fit) : "");
  remaining["pattern"] = text_or_null(result.pattern);
  remaining["pattern_p"] = rounded(result.trace.remaining_p);
  root["remaining"] = flow(remaining);
  const NullRun& null_run = result.trace.null_run;
  root["null_run"] = flow_map({{"flips", std::to_string(null_run.flips)},
                               {"false_add_rate", rounded(null_run.false_add_rate)},
                               {"delta_ebic_95", rounded(null_run.score_95)}});
  root["not_separable"] = not_separable_node(result.trace.not_separable);
  root["next_poses"] = text_or_null(next_poses);
  return print_document(root);
}

std::vector<std::string> effect_descriptions(const LoopResult& result) {
  std::vector<std::string> descriptions;
  for (size_t k = 0; k < result.trace.effects.size(); ++k)
    descriptions.push_back(in_words(result.trace.effects[k],
                                    k < result.gains.size() ? &result.gains[k] : nullptr,
                                    result.curves[k], result.trace.fit.robot));
  return descriptions;
}

std::string before_after_table(const LoopResult& result) {
  std::string table = fmt::format("{:<44} {:>6} {:>12} {:>12} {:>12}\n", "stage", "unkn.",
                                  "training", "held-out", "held-out");
  table +=
      fmt::format("{:<44} {:>6} {:>12} {:>12} {:>12}\n", "", "", "mean mm", "mean mm", "max mm");
  const auto if_held_out = [&](double value) {
    return result.held_out_poses > 0 ? fmt::format("{:.4f}", value / kMillimetre) : "-";
  };
  for (const Stage& stage : stages_and_predictor(result)) {
    const std::vector<std::string> name = in_lines(stage.name, 44);
    table += fmt::format("{:<44} {:>6} {:>12.4f} {:>12} {:>12}\n", name.front(), stage.parameters,
                         stage.training.position.mean / kMillimetre,
                         if_held_out(stage.held_out.position.mean),
                         if_held_out(stage.held_out.position.max));
    for (size_t k = 1; k < name.size(); ++k) table += name[k] + "\n";
  }
  table += fmt::format("{:<44} {:>6} {:>12} {:>12.4f}\n", "noise floor", "", "",
                       result.floor / kMillimetre);
  table += shares_table(result.trace.effects);
  if (const auto& nested = result.nested)
    table += fmt::format(
        "{:<44} {:>6} {:>12} {:>12.4f} before, {:.4f} after (standard errors {:.4f}, {:.4f})\n",
        fmt::format("nested cross-validation, {} folds", nested->folds), "", "",
        nested->before.mean / kMillimetre, nested->after.mean / kMillimetre,
        nested->before.error / kMillimetre, nested->after.error / kMillimetre);
  table += fmt::format("verdict: {}\n", to_string(result.verdict));
  return table;
}

}  // namespace armtrue
