#include "armtrue/io/products/mirror_io.h"

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/pose.h"
#include "armtrue/kinematics/units.h"
#include "io/products/error_nodes.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

NumberText millimetres(double value) { return rounded(value / kMillimetre); }

YAML::Node pass_node(const Pass& pass, const std::string& file, const std::vector<int>& lines) {
  const ClockFit& clock = pass.clock;
  YAML::Node node;
  node["file"] = file;
  node["samples"] = whole_number(pass.samples);
  node["lost_samples"] = whole_number(pass.lost);
  node["bad_samples"] = whole_number(pass.bad.size());
  constexpr size_t kNamed = 20;
  for (size_t i = 0; i < std::min(pass.bad.size(), kNamed); ++i)
    node["bad_lines"].push_back(whole_number(lines[pass.bad[i].sample]));
  if (!pass.bad.empty()) node["bad_lines"].SetStyle(YAML::EmitterStyle::Flow);
  node["longest_gap_s"] = rounded(pass.longest_gap);
  node["offset_s"] = number_in_form("{:.6f}", clock.offset);
  node["offset_std_s"] = rounded(clock.offset_deviation());
  const auto [low, high] = clock.offset_ci95();
  node["offset_ci95_s"] = flow_list({std::round(low * 1e6) / 1e6, std::round(high * 1e6) / 1e6});
  node["rate_ppm"] = rounded(clock.rate * 1e6);
  node["rate_std_ppm"] = rounded(std::sqrt(clock.covariance(1, 1)) * 1e6);
  const Pose& frame = clock.program_from_instrument;
  if (!frame.rotation.isIdentity(0) || !frame.translation.isZero(0)) {
    const Eigen::Vector3d abc = abc_from_rotation(frame.rotation);
    node["program_from_instrument"] =
        flow_map({{"x_mm", number_text(frame.translation[0], kMillimetre)},
                  {"y_mm", number_text(frame.translation[1], kMillimetre)},
                  {"z_mm", number_text(frame.translation[2], kMillimetre)},
                  {"a_deg", number_text(abc[0], kDegree)},
                  {"b_deg", number_text(abc[1], kDegree)},
                  {"c_deg", number_text(abc[2], kDegree)}});
  }
  return node;
}

YAML::Node force_record_node(const MirrorFindings::Force& force) {
  YAML::Node node;
  node["file"] = force.file;
  node["offset_s"] = number_in_form("{:.6f}", force.clock.offset);
  node["offset_std_s"] = rounded(force.clock.deviation);
  return flow(node);
}

YAML::Node accuracy_node(const PassAccuracy& accuracy, const FormError& form, double goal) {
  YAML::Node node;
  node["at_mm"] = millimetres(accuracy.path.at);
  node["rt_mm"] = accuracy.path.rt ? YAML::Node(millimetres(*accuracy.path.rt))
                                   : YAML::Node(YAML::NodeType::Null);
  node["planes"] = whole_number(accuracy.path.planes);
  for (size_t axis = 0; axis < 3; ++axis)
    node[std::string(1, "xyz"[axis]) + "_mm"] = error_node(accuracy.errors.axis[axis], kMillimetre);
  node["whole_mm"] = error_node(accuracy.errors.whole, kMillimetre);
  node["form_rms_mm"] = millimetres(form.rms);
  node["form_rms_ci95_mm"] = interval_node(form.ci95, kMillimetre);
  if (form.faster > 0) node["faster_rms_mm"] = millimetres(form.faster);
  node["goal_rms_mm"] = millimetres(goal);
  const std::optional<bool> held = form.holds(goal);
  node["goal_held"] = held ? boolean(*held) : YAML::Node("undecided");
  return node;
}

YAML::Node reduction_node(const Reduction& gained, const std::optional<FormReduction>& of_form) {
  const auto share = [](const std::optional<double>& value) {
    return value ? YAML::Node(rounded(*value)) : YAML::Node(YAML::NodeType::Null);
  };
  YAML::Node node;
  for (size_t axis = 0; axis < 3; ++axis)
    node[std::string(1, "xyz"[axis])] = share(gained.axis[axis]);
  node["whole"] = share(gained.whole);
  node["form"] = of_form ? YAML::Node(rounded(of_form->share)) : YAML::Node(YAML::NodeType::Null);
  if (of_form && of_form->ci95) node["form_ci95"] = interval_node(*of_form->ci95, 1);
  return flow(node);
}

YAML::Node engaged_node(const PathDeviation& deviation) {
  const auto instant_node = [](const std::optional<Instant>& instant) {
    return instant ? YAML::Node(number_in_form("{:.3f}", instant->time))
                   : YAML::Node(YAML::NodeType::Null);
  };
  YAML::Node list(YAML::NodeType::Sequence);
  for (const Engagement& engagement : deviation.engagement.intervals) {
    YAML::Node stretch;
    stretch["entry"] = instant_node(engagement.entry);
    stretch["exit"] = instant_node(engagement.exit);
    list.push_back(flow(stretch));
  }
  return list;
}

YAML::Node estimate_node(const std::optional<Estimate>& estimate, double unit) {
  if (!estimate) return YAML::Node(YAML::NodeType::Null);
  YAML::Node node;
  node["value"] = rounded(estimate->value / unit);
  node["std"] = rounded(estimate->std / unit);
  node["ci95"] = interval_node(estimate->ci95, unit);
  return flow(node);
}

YAML::Node line_node(const ForceLine& line) {
  YAML::Node node;
  node["k_mm_n"] = estimate_node(line.k, kMillimetre);
  node["r2"] = rounded(line.r2);
  return flow(node);
}

// Slope of the measured deviation on the one that the robot file predicts from the force; 1 is
// ideal.
YAML::Node line_of_robot(const ForceLine& line) {
  YAML::Node node;
  node["measured_over_predicted"] = estimate_node(line.k, 1);
  node["r2"] = rounded(line.r2);
  return flow(node);
}

YAML::Node force_node(const ForceLaw& law) {
  YAML::Node node;
  for (size_t axis = 0; axis < 3; ++axis)
    node[std::string(1, "xyz"[axis])] = line_node(law.axis[axis]);
  node["magnitude"] = line_node(law.magnitude);
  node["rank"] = whole_number(law.rank);
  node["condition"] = rounded(law.condition);
  for (const ForceDirection& direction : law.directions) {
    YAML::Node entry;
    entry["direction"] =
        flow_list({direction.direction[0], direction.direction[1], direction.direction[2]});
    entry["rms_n"] = rounded(direction.rms);
    if (direction.compliance)
      for (size_t axis = 0; axis < 3; ++axis)
        entry["compliance_mm_n"][std::string(1, "xyz"[axis])] =
            estimate_node((*direction.compliance)[axis], kMillimetre);
    else
      entry["compliance_mm_n"] = YAML::Node(YAML::NodeType::Null);
    node["directions"].push_back(entry);
  }
  node["reversals"] = flow(YAML::Node(YAML::NodeType::Sequence));
  for (const ReversalStep& reversal : law.reversals) {
    YAML::Node entry;
    for (const Eigen::Index axis : reversal.axes)
      entry["axes"].push_back(std::string(1, "xyz"[axis]));
    entry["axes"].SetStyle(YAML::EmitterStyle::Flow);
    for (size_t axis = 0; axis < 3; ++axis)
      entry["step_mm"][std::string(1, "xyz"[axis])] =
          estimate_node(reversal.step[axis], kMillimetre);
    node["reversals"].push_back(entry);
  }
  return node;
}

}  // namespace

Document write_mirror(const MirrorFindings& findings, const Provenance& provenance) {
  const auto& [result, options, files, lines, forces, accuracy, form, before, form_before,
               deviation_before, from_executed, force, robot, goal, reversals] = findings;
  YAML::Node root;
  root["format"] = "armtrue-mirror/1";
  root["provenance"] = provenance_node(provenance);
  for (size_t p = 0; p < files.size(); ++p) {
    YAML::Node pass = pass_node(result.passes[p], files[p], lines[p]);
    if (!forces.empty()) pass["force_record"] = force_record_node(forces[p]);
    root["passes"].push_back(pass);
  }
  const bool spline = options.points == CorrectionPoints::spline;
  std::vector<FlowEntry> filter{{"kind", spline ? "smoothing-spline" : "butterworth"}};
  if (!spline) filter.emplace_back("order", whole_number(options.order));
  filter.emplace_back("cut_off_hz", rounded(result.cutoff));
  filter.emplace_back("chosen", options.cutoff ? "given" : "auto");
  root["filter"] = flow_map(filter);
  const PathDeviation& deviation = result.deviation;
  root["noise"] = flow_map({{"sample_mm", millimetres(deviation.noise)},
                            {"largest_mm", millimetres(largest_of_noise(findings))}});
  if (files.size() > 1) {
    root["noise"]["pass_to_pass_mm"] = millimetres(deviation.spread);
    root["noise"]["pass_to_pass_ci95_mm"] = interval_node(deviation.spread_ci95, kMillimetre);
  }
  root["deviation_mm"] = error_node(result.before, kMillimetre);
  if (result.uncorrected) root["uncorrected_mean_mm"] = millimetres(*result.uncorrected);
  root["expected_after_mean_mm"] = millimetres(result.expected_after);
  root["expected_after_if"] = result.expected_if();
  if (options.clock.fit_frame) root["frame_uncertain_mm"] = millimetres(result.frame.rms());
  root["breaks_s"] = flow_list(deviation.breaks, [&time = deviation.time](Eigen::Index b) {
    return number_in_form("{:.3f}", time[b]);
  });
  if (reversals) {
    YAML::Node list(YAML::NodeType::Sequence);
    for (const MirrorFindings::Reversal& reversal : *reversals)
      list.push_back(
          flow_map({{"t_s", number_in_form("{:.3f}", reversal.time)}, {"joint", reversal.joint}}));
    root["joint_reversals"] = list;
  }
  root["correction"] =
      flow_map({{"gain", rounded(result.gain)},
                {"points", whole_number(result.points.size())},
                {"largest_mm", millimetres(result.correction.colwise().norm().maxCoeff())},
                {"clipped_samples", whole_number(result.clipped)},
                {"unrecorded_samples", whole_number(result.unrecorded)}});
  root["accuracy"] = accuracy_node(accuracy, form, goal);
  if (before) {
    root["before"] = accuracy_node(*before, *form_before, goal);
    root["reduction"] = reduction_node(reduction(before->errors, accuracy.errors),
                                       form_reduction(*form_before, form));
  }
  if (!deviation.engagement.intervals.empty()) root["engaged_s"] = engaged_node(deviation);
  if (force) root["force"] = force_node(*force);
  if (robot) root["robot"] = line_of_robot(*robot);
  return print_document(root);
}

}  // namespace armtrue
