#include "io/products/error_nodes.h"

#include "armtrue/kinematics/units.h"

namespace armtrue {

YAML::Node interval_node(const std::array<double, 2>& bounds, double unit) {
  return flow_list(bounds, [unit](double bound) { return rounded(bound / unit); });
}

YAML::Node lines_node(const std::vector<int>& lines) {
  return flow_list(lines, [](int line) { return whole_number(line); });
}

YAML::Node error_node(const ErrorSummary& errors, double unit) {
  return flow_map({{"mean", rounded(errors.mean / unit)},
                   {"rms", rounded(errors.rms / unit)},
                   {"p95", rounded(errors.p95 / unit)},
                   {"max", rounded(errors.max / unit)}});
}

YAML::Node axes_node(const std::vector<AxisErrors>& axes) {
  YAML::Node node;
  for (const AxisErrors& axis : axes)
    node[std::string(1, axis.axis)] = flow_map({{"mean", rounded(axis.mean / kMillimetre)},
                                                {"min", rounded(axis.min / kMillimetre)},
                                                {"max", rounded(axis.max / kMillimetre)}});
  return node;
}

YAML::Node errors_node(const PoseErrors& errors) {
  YAML::Node node;
  node["position_mm"] = error_node(errors.position, kMillimetre);
  if (errors.orientation) node["orientation_mrad"] = error_node(*errors.orientation, kMilliradian);
  node["axes_mm"] = axes_node(errors.axes);
  add_kinds(errors, node);
  return node;
}

void add_kinds(const PoseErrors& errors, YAML::Node node) {
  for (const KindErrors& own : errors.kinds)
    if (own.kind == kImages) {
      node["pixel_px"] = error_node(summarize(own.errors), errors.metre_per_pixel);
      node["mm_per_px"] = rounded(errors.metre_per_pixel / kMillimetre);
    }
  if (errors.kinds.size() < 2) return;
  for (const KindErrors& own : errors.kinds) {
    YAML::Node kind;
    kind["readings"] = whole_number(own.errors.size());
    kind["position_mm"] = error_node(summarize(own.errors), kMillimetre);
    node["by_kind"][own.kind] = kind;
  }
}

YAML::Node unseen_scale_node(const UnseenScale& scale) {
  return flow_map({{"mean_mm_per_100_ppm", rounded(scale.mean_cost() / kMillimetre)},
                   {"max_mm_per_100_ppm", rounded(scale.max_cost() / kMillimetre)}});
}

YAML::Node noise_node(const NoiseFloor& noise) {
  static constexpr const char* kSources[] = {"replicates", "instrument", "none"};
  std::vector<FlowEntry> entries{{"source", kSources[static_cast<int>(noise.source)]},
                                 {"position_mm", rounded(noise.position / kMillimetre)}};
  if (noise.orientation > 0)
    entries.emplace_back("orientation_mrad", rounded(noise.orientation / kMilliradian));
  return flow_map(entries);
}

YAML::Node floor_node(const NoiseFloor& noise, double floor) {
  const bool is_known = noise.source != NoiseFloor::Source::none;
  return rounded_or_null(is_known ? std::optional(floor / kMillimetre) : std::nullopt);
}

}  // namespace armtrue
