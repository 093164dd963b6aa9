#include "yaml_text.h"

#include <fmt/format.h>

#include "armtrue/kinematics/parameters.h"

namespace armtrue {
namespace {

const char* basis_name(SeriesBasis basis) {
  switch (basis) {
    case SeriesBasis::cosine:
      return "cosine";
    case SeriesBasis::spline:
      return "spline";
    case SeriesBasis::saturating:
      return "saturating";
    case SeriesBasis::bump:
      return "bump";
    case SeriesBasis::fourier:
      break;
  }
  return "fourier";
}

}  // namespace

YAML::Node flow_map(const std::vector<std::pair<std::string, std::string>>& entries) {
  YAML::Node node(YAML::NodeType::Map);
  for (const auto& [key, value] : entries) node[key] = value;
  return flow(node);
}

YAML::Node flow_list(const std::vector<double>& values) {
  YAML::Node node(YAML::NodeType::Sequence);
  for (double value : values) node.push_back(number_text(value));
  return flow(node);
}

std::string rounded(double value) { return fmt::format("{:.4g}", value); }

YAML::Node error_node(const ErrorSummary& errors, double unit) {
  return flow_map({{"mean", rounded(errors.mean / unit)},
                   {"rms", rounded(errors.rms / unit)},
                   {"p95", rounded(errors.p95 / unit)},
                   {"max", rounded(errors.max / unit)}});
}

std::string unit_of_parameter(const Robot& robot, const std::string& parameter) {
  const auto index = find_parameter(robot.chain, parameter);
  if (!index) return "m or rad";
  switch (parameter_unit(*index)) {
    case ParameterUnit::metre:
      return "m";
    case ParameterUnit::radian:
      return "rad";
    case ParameterUnit::one:
      break;
  }
  return "1";
}

YAML::Node effect_form_node(const Effect& effect) {
  YAML::Node node;
  node["name"] = effect.name;
  node["parameter"] = effect.parameter;
  node["driver"] = to_string(effect.driver);
  node["shape"] = to_string(effect.shape);
  const Shape& shape = effect.shape;
  if (shape.kind == ShapeKind::step) node["at_s"] = number_text(shape.at);
  if (shape.kind == ShapeKind::exponential) node["tau_s"] = number_text(shape.tau);
  if (shape.kind == ShapeKind::series) {
    YAML::Node series;
    series["basis"] = basis_name(shape.basis);
    series["count"] = std::to_string(shape.count);
    if (shape.basis != SeriesBasis::fourier) {
      series["range"] = flow_list({shape.low[0], shape.high[0]});
      if (effect.driver.is_pair())
        series["second_range"] = flow_list({shape.low[1], shape.high[1]});
    }
    node["series"] = flow(series);
  }
  return node;
}

YAML::Node effect_node(const Effect& effect, const std::string& unit_of_parameter) {
  YAML::Node node = effect_form_node(effect);
  const Shape& shape = effect.shape;
  std::string driver_unit;
  if (shape.kind == ShapeKind::linear) driver_unit = unit_of(effect.driver.kind);
  const std::string factor_unit = effect.driver.factor ? unit_of(*effect.driver.factor) : "";
  if (!driver_unit.empty() && !factor_unit.empty()) driver_unit += " ";
  driver_unit += factor_unit;
  std::string unit = unit_of_parameter;
  if (!driver_unit.empty())
    unit +=
        driver_unit.find(' ') == std::string::npos ? "/" + driver_unit : "/(" + driver_unit + ")";
  for (const Coefficient& c : effect.coefficients) {
    YAML::Node coefficient;
    coefficient["name"] = c.name;
    coefficient["value"] = number_text(c.value);
    if (c.std > 0) {
      coefficient["std"] = fmt::format("{:.4g}", c.std);
      YAML::Node interval;
      for (double bound : c.ci95) interval.push_back(fmt::format("{:.5g}", bound));
      coefficient["ci95"] = flow(interval);
    }
    coefficient["unit"] = unit;
    node["coefficients"].push_back(flow(coefficient));
  }
  return node;
}

YAML::Node provenance_node(const Provenance& provenance) {
  YAML::Node node;
  node["command"] = provenance.command;
  node["version"] = provenance.version;
  for (const auto& [file, sha256] : provenance.inputs)
    node["inputs"].push_back(flow_map({{"file", file}, {"sha256", sha256}}));
  return node;
}

std::string print_document(const YAML::Node& root) {
  YAML::Emitter emitter;
  emitter.SetIndent(2);
  emitter << root;
  return std::string(emitter.c_str()) + "\n";
}

}  // namespace armtrue
