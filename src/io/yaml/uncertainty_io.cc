#include "io/yaml/uncertainty_io.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

// The number of rows of a lower triangle with so many numbers; 0 if it is not that of the
// parameters and the coefficients of none, some or all of the first effects.
Eigen::Index rows_of_root(size_t numbers, size_t parameters, const std::vector<Effect>& effects) {
  size_t rows = parameters;
  if (numbers == rows * (rows + 1) / 2) return rows;
  for (const Effect& effect : effects) {
    rows += effect.coefficients.size();
    if (numbers == rows * (rows + 1) / 2) return rows;
  }
  return 0;
}

// An uncertainty of nothing, though `std` states one. That of a parameter may be larger than its
// `std`: it contains those that the poses do not show.
void check_root(const YamlMap& map, const Uncertainty& uncertainty,
                const std::map<std::string, double>& deviations) {
  for (size_t k = 0; k < uncertainty.parameters.size(); ++k) {
    const std::string& name = uncertainty.parameters[k];
    const auto stated = deviations.find(name);
    if (stated != deviations.end() && stated->second > 0 &&
        uncertainty.root.row(static_cast<Eigen::Index>(k)).isZero(0))
      map.fail(
          "root",
          fmt::format("has no standard deviation of '{}', and 'std' states one: one of them was "
                      "changed by hand; calibrate again",
                      name));
  }
}

}  // namespace

Uncertainty read_uncertainty(YamlMap map, const KinematicChain& chain,
                             const std::vector<Effect>& effects,
                             const std::map<std::string, double>& deviations) {
  Uncertainty result;
  result.parameters = map.texts("parameters");
  for (const std::string& name : result.parameters)
    if (!find_parameter(chain, name))
      map.fail("parameters", "the robot has no parameter '" + name + "'");
  const std::vector<double> numbers = map.numbers("root");
  const Eigen::Index size = rows_of_root(numbers.size(), result.parameters.size(), effects);
  if (size == 0 && !(numbers.empty() && result.parameters.empty())) {
    size_t coefficients = 0;
    for (const Effect& effect : effects) coefficients += effect.coefficients.size();
    const size_t rows = result.parameters.size() + coefficients;
    map.fail("root",
             fmt::format("has {}, and the lower triangle of {} parameters and {} "
                         "coefficients of effects has {}: parameters or effects were added or "
                         "removed by hand; calibrate again, or remove the map 'uncertainty'",
                         counted(numbers.size(), "number"), result.parameters.size(), coefficients,
                         rows * (rows + 1) / 2));
  }
  result.root = Eigen::MatrixXd::Zero(size, size);
  auto next = numbers.begin();
  for (Eigen::Index row = 0; row < result.root.rows(); ++row)
    for (Eigen::Index column = 0; column <= row; ++column) result.root(row, column) = *next++;
  check_root(map, result, deviations);
  result.reading.position = map.number("reading_mm") * kMillimetre;
  result.reading.orientation = map.number("reading_mrad", 0) * kMilliradian;
  result.rest = map.number("rest_mm", 0) * kMillimetre;
  result.tail = map.number("reading_tail", 1);
  result.largest_variance = map.number("largest_variance_mm2") * kMillimetre * kMillimetre;
  result.largest_variance_of_point =
      map.number("largest_variance_of_point_mm2", 0) * kMillimetre * kMillimetre;
  const double poses = map.number("poses");
  if (result.reading.position < 0) map.fail("reading_mm", "must not be negative");
  if (result.rest < 0) map.fail("rest_mm", "must not be negative");
  if (result.tail < 1) map.fail("reading_tail", "must be 1 or more");
  if (result.largest_variance < 0) map.fail("largest_variance_mm2", "must not be negative");
  if (result.largest_variance_of_point < 0)
    map.fail("largest_variance_of_point_mm2", "must not be negative");
  if (poses < 1 || poses > 1e9) map.fail("poses", "must be from 1 to 1e9");
  result.poses = static_cast<int>(poses);
  map.finish();
  return result;
}

YAML::Node uncertainty_node(const Uncertainty& uncertainty) {
  YAML::Node node;
  node["parameters"] = flow(YAML::Node(uncertainty.parameters));
  YAML::Node root(YAML::NodeType::Sequence);
  for (Eigen::Index row = 0; row < uncertainty.root.rows(); ++row)
    for (Eigen::Index column = 0; column <= row; ++column)
      root.push_back(number_in_form("{:.5g}", uncertainty.root(row, column)));
  node["root"] = flow(root);
  node["reading_mm"] = rounded(uncertainty.reading.position / kMillimetre);
  if (uncertainty.reading.orientation > 0)
    node["reading_mrad"] = rounded(uncertainty.reading.orientation / kMilliradian);
  if (uncertainty.rest > 0) node["rest_mm"] = rounded(uncertainty.rest / kMillimetre);
  if (uncertainty.tail > 1) node["reading_tail"] = rounded(uncertainty.tail);
  node["largest_variance_mm2"] =
      rounded(uncertainty.largest_variance / (kMillimetre * kMillimetre));
  if (uncertainty.largest_variance_of_point > 0)
    node["largest_variance_of_point_mm2"] =
        rounded(uncertainty.largest_variance_of_point / (kMillimetre * kMillimetre));
  node["poses"] = whole_number(uncertainty.poses);
  return node;
}

}  // namespace armtrue
