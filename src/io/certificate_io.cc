#include "armtrue/io/certificate_io.h"

#include <chrono>
#include <cmath>
#include <cstdio>

#include "armtrue/io/source.h"
#include "armtrue/kinematics/units.h"
#include "io/yaml/yaml_map.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

constexpr double kMicrometre = 1e-6;

std::string filled_text(YamlMap& map, const std::string& key) {
  const std::string text = map.text(key);
  if (text.find_first_not_of(" \t\n") == std::string::npos) map.fail(key, "is empty; fill it in");
  return text;
}

// YYYY-MM-DD, so that texts compare as dates do.
std::string date_text(YamlMap& map, const std::string& key) {
  const std::string text = filled_text(map, key);
  int year = 0, month = 0, day = 0, used = 0;
  const bool is_read =
      text.size() == 10 &&
      std::sscanf(text.c_str(), "%4d-%2d-%2d%n", &year, &month, &day, &used) == 3 && used == 10;
  const std::chrono::year_month_day date{std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!is_read || text.find_first_not_of("0123456789-") != std::string::npos || !date.ok())
    map.fail(key, "'" + text + "' is no date; write YYYY-MM-DD, such as 2026-03-31");
  return text;
}

double not_negative(YamlMap& map, const std::string& key) {
  const double value = map.number(key);
  if (value < 0) map.fail(key, "must not be below zero");
  return value;
}

void read_instrument_errors(YamlMap& map, About& about) {
  if (map.has("noise_mm") == map.has("mpe_um"))
    map.fail(map.has("noise_mm") ? "mpe_um" : "noise_mm",
             "give either noise_mm, one standard deviation per axis, or mpe_um: {constant, per_m}, "
             "the maximum permissible error");
  if (map.has("noise_mm")) {
    about.stated.noise = not_negative(map, "noise_mm") * kMillimetre;
    if (*about.stated.noise == 0) map.fail("noise_mm", "no instrument is without noise");
  } else {
    YamlMap mpe = map.map("mpe_um");
    about.stated.mpe_constant = not_negative(mpe, "constant") * kMicrometre;
    about.stated.mpe_per_metre = not_negative(mpe, "per_m") * kMicrometre;
    if (about.stated.mpe_constant + about.stated.mpe_per_metre == 0)
      map.fail("mpe_um", "no instrument is without error");
    mpe.finish();
  }
  if (!map.has("range_mm")) return;
  about.range = map.number("range_mm") * kMillimetre;
  if (*about.range <= 0) map.fail("range_mm", "must be above zero");
}

void read_instrument(YamlMap map, About& about) {
  about.instrument = filled_text(map, "name");
  about.instrument_serial = filled_text(map, "serial");
  about.calibrated_until = date_text(map, "calibrated_until");
  if (about.calibrated_until < about.date)
    map.fail("calibrated_until", "is before the date of the measurement, " + about.date +
                                     "; have the instrument calibrated and measure again");
  read_instrument_errors(map, about);
  map.finish();
}

void read_temperature(YamlMap map, StatedUncertainty& stated) {
  stated.temperature_half_width = not_negative(map, "within_k");
  stated.expansion = not_negative(map, "expansion_um_per_m_k") * kMicrometre;
  stated.length = not_negative(map, "length_mm") * kMillimetre;
  map.finish();
}

About parse_about(const std::string& text, const std::string& file) {
  YamlMap document = read_document(text, file, {"armtrue-about/1"});
  About about;
  YamlMap robot = document.map("robot");
  about.type = filled_text(robot, "type");
  about.serial = filled_text(robot, "serial");
  robot.finish();
  about.operator_name = filled_text(document, "operator");
  about.date = date_text(document, "date");
  about.place = filled_text(document, "place");
  read_instrument(document.map("instrument"), about);
  about.stated.mounting = not_negative(document, "mounting_mm") * kMillimetre;
  read_temperature(document.map("temperature"), about.stated);
  document.finish();
  return about;
}

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

YAML::Node largest_node(const Largest& largest, double unit, double expanded) {
  YAML::Node node = largest_node(largest, unit);
  node["expanded"] = rounded(expanded / unit);
  return node;
}

YAML::Node set_node(const SetFigures& set, const Budget& budget) {
  YAML::Node node;
  node["poses"] = std::to_string(set.poses);
  node["fewest_visits"] = std::to_string(set.fewest_visits);
  node["ap_mm"] = largest_node(set.ap, kMillimetre, budget.expanded);
  node["rp_mm"] = largest_node(set.rp, kMillimetre, set.rp_expanded());
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
  node["freedom"] = text_or_null(std::isfinite(budget.freedom) ? rounded(budget.freedom) : "");
  node["k"] = rounded(budget.k);
  node["expanded_mm"] = rounded(budget.expanded / kMillimetre);
  return node;
}

YAML::Node path_node(const PathFigures& path, const Budget& budget) {
  YAML::Node node;
  node["passes"] = std::to_string(path.passes);
  node["planes"] = std::to_string(path.planes);
  node["at_mm"] = rounded(path.at / kMillimetre);
  if (path.rt) {
    node["rt_mm"] = rounded(*path.rt / kMillimetre);
    node["rt_expanded_mm"] = rounded(path.rt_expanded() / kMillimetre);
  }
  node["budget"] = budget_node(budget);
  return node;
}

YAML::Node axes_node(const Eigen::Vector3d& vector, double unit) {
  YAML::Node node(YAML::NodeType::Sequence);
  for (double component : vector) node.push_back(rounded(component / unit));
  return flow(node);
}

YAML::Node pose_node(const PoseFigures& figures) {
  YAML::Node node;
  node["pose"] = figures.pose;
  node["visits"] = std::to_string(figures.visits);
  node["directions"] = std::to_string(figures.directions);
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
  return flow(node);
}

YAML::Node differences_node(const std::vector<Difference>& differences, const char* name) {
  std::vector<YAML::Node> items;
  for (const Difference& difference : differences)
    items.push_back(flow_map({{name, difference.name},
                              {"before_mm", rounded(difference.before / kMillimetre)},
                              {"now_mm", rounded(difference.now / kMillimetre)},
                              {"difference_mm", rounded(difference.difference / kMillimetre)},
                              {"expanded_mm", rounded(difference.expanded / kMillimetre)},
                              {"significant", difference.significant ? "true" : "false"}}));
  return list_node(items);
}

YAML::Node comparison_node(const Comparison& comparison) {
  YAML::Node node;
  node["date_before"] = comparison.date_before;
  node["figures"] = differences_node(comparison.figures, "figure");
  node["poses"] = differences_node(comparison.poses, "pose");
  return node;
}

CertifiedValue certified_value(YamlMap map, const std::string& name) {
  return {name, not_negative(map, "value") * kMillimetre,
          not_negative(map, "expanded") * kMillimetre};
}

void read_set(YamlMap map, const std::string& prefix, std::vector<CertifiedValue>& values) {
  values.push_back(certified_value(map.map("ap_mm"), prefix + "ap"));
  values.push_back(certified_value(map.map("rp_mm"), prefix + "rp"));
}

}  // namespace

AboutFile read_about(const std::string& path) {
  Source source(path);
  AboutFile file;
  file.name = source.name();
  file.about = parse_about(source.read_all(), file.name);
  file.sha256 = source.sha256();
  return file;
}

std::string write_certificate(const Certificate& certificate,
                              const std::optional<Comparison>& comparison,
                              const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-certificate/1";
  root["provenance"] = provenance_node(provenance);
  root["robot"] = certificate.robot;
  root["about"] = about_node(certificate.about);
  if (certificate.tolerance) root["tolerance_mm"] = rounded(*certificate.tolerance / kMillimetre);
  if (certificate.decision) root["result"] = decision_name(*certificate.decision);
  if (!certificate.refitted.empty()) root["refitted"] = certificate.refitted;
  if (certificate.cube) root["cube"] = set_node(*certificate.cube, certificate.budget);
  root["all"] = set_node(certificate.all, certificate.budget);
  if (certificate.path) root["path"] = path_node(*certificate.path, *certificate.path_budget);
  root["budget"] = budget_node(certificate.budget);
  for (const PoseFigures& figures : certificate.poses) root["poses"].push_back(pose_node(figures));
  std::vector<YAML::Node> notes;
  for (const std::string& note : certificate.notes) notes.emplace_back(note);
  root["notes"] = list_node(notes);
  if (comparison) root["comparison"] = comparison_node(*comparison);
  return print_document(root);
}

CertificateFile read_certificate(const std::string& path) {
  Source source(path);
  CertificateFile file;
  file.name = source.name();
  YamlMap document = read_document(source.read_all(), file.name, {"armtrue-certificate/1"});
  file.sha256 = source.sha256();
  YamlMap about = document.map("about");
  file.values.serial = about.map("robot").text("serial");
  file.values.date = date_text(about, "date");
  read_set(document.map("all"), "", file.values.figures);
  if (document.has("cube")) read_set(document.map("cube"), "cube ", file.values.figures);
  YamlMap budget = document.map("budget");
  const double expanded = not_negative(budget, "expanded_mm") * kMillimetre;
  for (YamlMap& pose : document.maps("poses"))
    file.values.poses.push_back(
        {pose.text("pose"), not_negative(pose, "ap_mm") * kMillimetre, expanded});
  return file;
}

}  // namespace armtrue
