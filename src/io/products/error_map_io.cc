#include "armtrue/io/products/error_map_io.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "io/csv_cell.h"
#include "io/products/error_nodes.h"
#include "io/yaml/yaml_text.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kMapDecimals = 6;

// Names of the columns of the causes: the first is the geometry, the last may be the controller's.
std::vector<std::string> cause_columns(const ErrorMap& map) {
  std::vector<std::string> names{"geometry_mm"};
  for (size_t k = 1; k < map.causes.size(); ++k)
    names.push_back(k <= map.effects ? fmt::format("effect{}_mm", k) : "controller_effects_mm");
  return names;
}

void add_number(std::string& line, double value) {
  line += ',';
  line += decimal_text(value, kMapDecimals);
}

void add_if_known(std::string& line, const std::optional<double>& value, double unit) {
  if (value)
    add_number(line, *value / unit);
  else
    line += ',';
}

void add_row(std::string& line, const ErrorMap& map, size_t row,
             const std::vector<JointName>& joints) {
  const MapPoint& point = map.points[row];
  line += csv_cell(map.names[row]);
  for (double x : point.position) add_number(line, x / kMillimetre);
  for (size_t j = 0; j < joints.size(); ++j)
    if (point.q)
      add_number(line, (*point.q)[j] / joints[j].si());
    else
      line += ',';
  if (point.is_predicted) {
    for (double x : point.error) add_number(line, x / kMillimetre);
    add_number(line, point.error.norm() / kMillimetre);
    add_number(line, point.turn / kMilliradian);
    add_number(line, point.left_by_constants / kMillimetre);
  } else {
    line += ",,,,,,";
  }
  add_if_known(line, point.after, kMillimetre);
  add_if_known(line, point.deviation, kMillimetre);
  add_if_known(line, point.leverage, 1);
  for (size_t cause = 0; cause < map.causes.size(); ++cause)
    if (point.is_predicted)
      add_number(line, map.part(row, cause).norm() / kMillimetre);
    else
      line += ',';
  for (size_t k = 0; k < point.notes.size(); ++k)
    line += (k == 0 ? "," : " ") + to_string(point.notes[k]);
  line += point.notes.empty() ? ",\n" : "\n";
}

YAML::Node vector_node(const Eigen::Vector3d& vector) {
  return flow_map({{"x", decimal_text(vector.x(), kMapDecimals)},
                   {"y", decimal_text(vector.y(), kMapDecimals)},
                   {"z", decimal_text(vector.z(), kMapDecimals)}});
}

// In mm, without the digits that only rounding makes.
double plain_mm(double metres) { return std::round(1e6 * metres / kMillimetre) / 1e6; }

std::vector<double> in_mm(const Eigen::Vector3d& v) {
  return {plain_mm(v.x()), plain_mm(v.y()), plain_mm(v.z())};
}

// A box as --box-mm takes it, in mm.
std::vector<double> box_of(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  std::vector<double> box;
  for (int axis = 0; axis < 3; ++axis)
    for (double end : {low[axis], high[axis]}) box.push_back(plain_mm(end));
  return box;
}

YAML::Node placement_node(const PartPlace& placement) {
  YAML::Node node;
  node["box_mm"] = flow_list(box_of(placement.low, placement.high));
  node["mean_mm"] = rounded(placement.mean / kMillimetre);
  return flow(node);
}

YAML::Node point_node(const ErrorMap& map, int number) {
  const size_t k = number;
  YAML::Node node;
  node["pose"] = map.names[k];
  node["at_mm"] = flow_list(in_mm(map.points[k].position));
  node["before_mm"] = rounded(map.points[k].error.norm() / kMillimetre);
  return flow(node);
}

YAML::Node causes_node(const ErrorMap& map, const ErrorMapSummary& summary) {
  const std::vector<std::string> columns = cause_columns(map);
  YAML::Node list(YAML::NodeType::Sequence);
  for (size_t k = 0; k < columns.size(); ++k) {
    YAML::Node node;
    node["column"] = columns[k];
    node["cause"] = summary.causes[k].cause;
    node["mean_mm"] = rounded(summary.causes[k].mean / kMillimetre);
    node["max_mm"] = rounded(summary.causes[k].max / kMillimetre);
    node["share"] = rounded(summary.causes[k].share);
    list.push_back(flow(node));
  }
  return list;
}

YAML::Node grid_node(const Grid& grid) {
  YAML::Node node;
  node["box_mm"] = flow_list(box_of(grid.low, grid.high));
  node["points"] = flow_list(std::vector<double>(grid.count.begin(), grid.count.end()));
  return flow(node);
}

YAML::Node placements_node(const ErrorMapSummary& summary) {
  YAML::Node node;
  node["part_mm"] = flow_list(in_mm(summary.part));
  node["best_before"] = placement_node(*summary.best_before);
  node["worst_before"] = placement_node(*summary.worst_before);
  if (summary.best_after) node["best_after"] = placement_node(*summary.best_after);
  if (summary.worst_after) node["worst_after"] = placement_node(*summary.worst_after);
  return node;
}

}  // namespace

std::string write_error_map(const ErrorMap& map, const std::vector<JointName>& joints) {
  std::string text = "pose,x_mm,y_mm,z_mm";
  for (const JointName& joint : joints) text += "," + joint.encoder();
  text += ",dx_mm,dy_mm,dz_mm,before_mm,before_mrad,constants_only_mm,after_mm,std_mm,leverage";
  for (const std::string& column : cause_columns(map)) text += "," + column;
  text += ",note\n";
  for_ordered_blocks<std::string>(
      static_cast<int>(map.points.size()), kRowsPerBlock,
      [&](int begin, int end) {
        std::string block;
        for (int row = begin; row < end; ++row) add_row(block, map, row, joints);
        return block;
      },
      [&](const std::string& block) { text += block; });
  return text;
}

Document write_error_map_summary(const ErrorMap& map, const ErrorMapSummary& summary,
                                 const PredictionConditions& conditions,
                                 const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-error-map/1";
  root["provenance"] = provenance_node(provenance);
  root["robot"] = conditions.robot;
  root["controller"] = conditions.controller;
  root["sentence"] = error_map_sentence(map, summary);
  root["points"] = whole_number(map.points.size());
  root["predicted"] = whole_number(summary.predicted);
  if (map.grid) root["grid"] = grid_node(*map.grid);
  root["before_mm"] = error_node(summary.before, kMillimetre);
  root["before_mrad"] = error_node(summary.turn, kMilliradian);
  root["constants_only_mm"] = error_node(summary.left_by_constants, kMillimetre);
  if (summary.after) root["after_mm"] = error_node(*summary.after, kMillimetre);
  if (summary.deviation) root["std_mm"] = error_node(*summary.deviation, kMillimetre);
  root["causes"] = causes_node(map, summary);
  YAML::Node direction;
  direction["mean_mm"] = vector_node(summary.mean_error / kMillimetre);
  direction["axis"] = vector_node(summary.axis);
  direction["share"] = rounded(summary.axis_share);
  root["direction"] = direction;
  root["best"] = point_node(map, summary.best);
  root["worst"] = point_node(map, summary.worst);
  if (summary.best_before) root["placements"] = placements_node(summary);
  YAML::Node notes(YAML::NodeType::Map);
  for (CommandNote note : map_notes()) notes[to_string(note)] = whole_number(count_of(map, note));
  root["notes"] = flow(notes);
  root["assumed"] = texts_node(conditions.assumed);
  root["not_applied"] = texts_node(conditions.not_applied);
  return print_document(root);
}

std::string error_map_table(const ErrorMap& map, const ErrorMapSummary& summary) {
  std::string text = error_map_sentence(map, summary) + "\n";
  text += fmt::format("{:<60}{:>10}{:>10}{:>8}\n", "error", "mean_mm", "max_mm", "share");
  const auto line = [&](const std::string& what, double mean, double max,
                        const std::string& share) {
    text += fmt::format("{:<60}{:>10.3g}{:>10.3g}{:>8}\n", what, mean / kMillimetre,
                        max / kMillimetre, share);
  };
  line("before", summary.before.mean, summary.before.max, "");
  for (const CauseSummary& cause : summary.causes)
    line("  " + cause.cause, cause.mean, cause.max, fmt::format("{:.0f} %", 100 * cause.share));
  line("left with the identified constants alone", summary.left_by_constants.mean,
       summary.left_by_constants.max, "");
  if (summary.after) {
    line("left with constants and effects", summary.after->mean, summary.after->max, "");
    line("  of it, uncertainty of the model", summary.deviation->mean, summary.deviation->max, "");
  }
  const Eigen::Vector3d mean = summary.mean_error / kMillimetre;
  text += fmt::format(
      "direction: {:.0f} % of the squared error lies along ({:.2f}, {:.2f}, {:.2f}); the "
      "mean error is ({:.3f}, {:.3f}, {:.3f}) mm\n",
      100 * summary.axis_share, summary.axis.x(), summary.axis.y(), summary.axis.z(), mean.x(),
      mean.y(), mean.z());
  const auto place = [&](const char* what, const std::optional<PartPlace>& placement) {
    if (placement)
      text += fmt::format("{:<60}{:>10.3g}  {:g}\n", what, placement->mean / kMillimetre,
                          fmt::join(box_of(placement->low, placement->high), ","));
  };
  if (summary.best_before)
    text += fmt::format("{:<60}{:>10}  {}\n",
                        fmt::format("a part of {:g} mm", fmt::join(in_mm(summary.part), " x ")),
                        "mean_mm", "x0,x1,y0,y1,z0,z1 in mm");
  place("  stands best, as it is", summary.best_before);
  place("  stands worst, as it is", summary.worst_before);
  place("  stands best, with constants and effects", summary.best_after);
  place("  stands worst, with constants and effects", summary.worst_after);
  return text;
}

}  // namespace armtrue
