
#include "armtrue/io/products/certificate_io.h"
#include "armtrue/kinematics/units.h"
#include "io/products/error_nodes.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

YAML::Node about_node(const About& about) {
  YAML::Node node;
  node["robot"] = flow_map({{"type", about.type}, {"serial", about.serial}});
  node["operator"] = about.operator_name;
  node["date"] = about.date;
  node["place"] = about.place;
  node["instrument"] = flow_map({{"name", about.instrument},
                                 {"serial", about.instrument_serial},
                                 {"calibrated_until", about.calibrated_until}});
  return node;
}

YAML::Node largest_node(const Largest& largest, double unit) {
  return flow_map({{"value", rounded(largest.value / unit)}, {"pose", largest.pose}});
}

YAML::Node largest_node(const Largest& largest, double unit,
                        const std::optional<double>& expanded) {
  YAML::Node node = largest_node(largest, unit);
  if (expanded) node["expanded"] = rounded(*expanded / unit);
  return node;
}

YAML::Node set_node(const SetFigures& set, const Budget& budget) {
  YAML::Node node;
  node["poses"] = whole_number(set.poses);
  node["fewest_visits"] = whole_number(set.fewest_visits);
  node["ap_mm"] = largest_node(set.ap, kMillimetre, budget.expanded);
  node["rp_mm"] = largest_node(set.rp, kMillimetre, set.rp_expanded());
  if (set.rp_ci95) node["rp_mm"]["ci95"] = interval_node(*set.rp_ci95, kMillimetre);
  const auto add = [&](const char* key, const std::optional<Largest>& largest, double unit) {
    if (largest) node[key] = largest_node(*largest, unit);
  };
  add("ap_mrad", set.ap_turn, kMilliradian);
  add("rp_mrad", set.rp_turn, kMilliradian);
  add("vap_mm", set.vap, kMillimetre);
  add("vap_mrad", set.vap_turn, kMilliradian);
  add("drift_ap_mm", set.drift_ap, kMillimetre);
  add("drift_rp_mm", set.drift_rp, kMillimetre);
  add("drift_ap_mrad", set.drift_ap_turn, kMilliradian);
  add("drift_rp_mrad", set.drift_rp_turn, kMilliradian);
  return node;
}

YAML::Node budget_node(const Budget& budget) {
  YAML::Node node;
  for (const BudgetRow& row : budget.rows)
    node["rows"].push_back(flow_map({{"source", row.source},
                                     {"distribution", row.distribution},
                                     {"standard_mm", rounded(row.standard / kMillimetre)}}));
  node["combined_mm"] = rounded(budget.combined / kMillimetre);
  node["freedom"] = rounded_or_null(budget.freedom);
  node["k"] = rounded(budget.k);
  node["expanded_mm"] = rounded(budget.expanded / kMillimetre);
  return node;
}

YAML::Node path_node(const PathFigures& path, const Budget& budget) {
  YAML::Node node;
  node["passes"] = whole_number(path.passes);
  node["planes"] = whole_number(path.planes);
  node["planes_of_path"] = whole_number(path.of_path);
  node["at_mm"] = rounded(path.at / kMillimetre);
  if (path.rt) {
    node["rt_mm"] = rounded(*path.rt / kMillimetre);
    node["at_of_scatter_mm"] = rounded(path.at_of_scatter / kMillimetre);
    if (const auto expanded = path.rt_expanded()) {
      node["rt_expanded_mm"] = rounded(*expanded / kMillimetre);
      node["rt_ci95_mm"] = interval_node(*path.rt_ci95, kMillimetre);
    }
  }
  node["budget"] = budget_node(budget);
  return node;
}

YAML::Node axes_node(const Eigen::Vector3d& vector, double unit) {
  return flow_list(vector, [unit](double component) { return rounded(component / unit); });
}

YAML::Node pose_node(const PoseFigures& figures, const std::vector<JointName>& joints) {
  YAML::Node node;
  node["pose"] = figures.pose;
  node["visits"] = whole_number(figures.visits);
  node["directions"] = whole_number(figures.directions);
  node["ap_mm"] = rounded(figures.ap / kMillimetre);
  node["ap_axes_mm"] = axes_node(figures.ap_axes, kMillimetre);
  node["rp_mm"] = rounded(figures.rp / kMillimetre);
  if (figures.ap_turn) node["ap_axes_mrad"] = axes_node(*figures.ap_turn, kMilliradian);
  if (figures.rp_turn) node["rp_axes_mrad"] = axes_node(*figures.rp_turn, kMilliradian);
  if (figures.vap) node["vap_mm"] = rounded(*figures.vap / kMillimetre);
  if (figures.drift_ap) node["drift_ap_mm"] = rounded(*figures.drift_ap / kMillimetre);
  if (figures.drift_rp) node["drift_rp_mm"] = rounded(*figures.drift_rp / kMillimetre);
  const auto add = [&](const char* key, const std::optional<Eigen::Vector3d>& turn) {
    if (turn) node[key] = axes_node(*turn, kMilliradian);
  };
  add("vap_axes_mrad", figures.vap_turn);
  add("drift_ap_axes_mrad", figures.drift_ap_turn);
  add("drift_rp_axes_mrad", figures.drift_rp_turn);
  YAML::Node at(YAML::NodeType::Map);
  for (const auto& [column, value] : joint_columns(figures, joints))
    at[column] = number_in_form("{:.4f}", value);
  node["joints"] = flow(at);
  return flow(node);
}

YAML::Node differences_node(const std::vector<CertifiedChange>& differences, const char* name) {
  std::vector<YAML::Node> items;
  for (const CertifiedChange& difference : differences) {
    YAML::Node item = flow_map({{name, difference.name},
                                {"before_mm", rounded(difference.before / kMillimetre)},
                                {"now_mm", rounded(difference.now / kMillimetre)},
                                {"difference_mm", rounded(difference.difference / kMillimetre)}});
    if (difference.expanded) item["expanded_mm"] = rounded(*difference.expanded / kMillimetre);
    item["significant"] = boolean(difference.significant);
    items.push_back(item);
  }
  return list_node(items);
}

YAML::Node comparison_node(const Comparison& comparison) {
  YAML::Node node;
  node["date_before"] = comparison.date_before;
  node["figures"] = differences_node(comparison.figures, "figure");
  node["poses"] = differences_node(comparison.poses, "pose");
  return node;
}

}  // namespace

Document write_certificate(const Certificate& certificate,
                           const std::optional<Comparison>& comparison,
                           const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-certificate/1";
  root["provenance"] = provenance_node(provenance);
  if (certificate.has_poses()) root["robot"] = certificate.robot;
  root["about"] = about_node(certificate.about);
  if (certificate.tolerance)
    root["tolerance_mm"] = number_text(*certificate.tolerance, kMillimetre);
  if (certificate.decision) root["result"] = decision_name(*certificate.decision);
  if (!certificate.refitted.empty()) root["refitted"] = certificate.refitted;
  if (certificate.cube) root["cube"] = set_node(*certificate.cube, certificate.budget);
  if (certificate.has_poses()) root["all"] = set_node(certificate.all, certificate.budget);
  if (certificate.path) root["path"] = path_node(*certificate.path, *certificate.path_budget);
  if (certificate.has_poses()) root["budget"] = budget_node(certificate.budget);
  for (const PoseFigures& figures : certificate.poses)
    root["poses"].push_back(pose_node(figures, certificate.joints));
  root["notes"] = texts_node(certificate.notes);
  if (comparison) root["comparison"] = comparison_node(*comparison);
  return print_document(root);
}

}  // namespace armtrue
