#include "armtrue/io/products/parameters_io.h"

#include <algorithm>
#include <cmath>

#include "armtrue/calibration/identified_values.h"
#include "armtrue/text/number_text.h"
#include "armtrue/tracing/loop.h"
#include "io/csv_cell.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

struct FittedCoefficient {
  std::string name;
  const Effect* effect;
  size_t number;
};

// The coefficients among the unknowns, in their order.
std::vector<FittedCoefficient> fitted_coefficients(const CalibrationResult& result) {
  size_t left = result.shared - result.set.kept.size();
  std::vector<FittedCoefficient> coefficients;
  for (const Effect& effect : result.robot.effects)
    for (size_t k = 0; k < effect.coefficients.size() && left > 0; ++k, --left)
      coefficients.push_back({describe(effect) + ": " + effect.coefficients[k].name, &effect, k});
  return coefficients;
}

// An exact number, a statistic, or an empty cell.
void add(const std::optional<double>& si, double unit, std::string& line) {
  line += ',';
  if (si) line += number_text(*si, unit);
}
void add_rounded(const std::optional<double>& si, double unit, std::string& line) {
  line += ',';
  if (si) line += rounded(*si / unit);
}

std::string row_of(const IdentifiedValue& row) {
  std::string line = csv_cell(row.name) + "," + row.unit.name;
  add(row.nominal, row.unit.si, line);
  add(row.value, row.unit.si, line);
  add(row.change, row.unit.si, line);
  add_rounded(row.std, row.unit.si, line);
  for (const size_t end : {0, 1})
    add(row.ci95 ? std::optional((*row.ci95)[end]) : std::nullopt, row.unit.si, line);
  return line + "," + number_in_form("{:.2f}", row.share_of_readings.value_or(1)) + "\n";
}

// The value that the same coefficient had in the nominal robot.
std::optional<double> nominal_of(const Robot& nominal, const FittedCoefficient& coefficient) {
  const Effect& effect = *coefficient.effect;
  for (const Effect& before : nominal.effects)
    if (describe(before) == describe(effect) && coefficient.number < before.coefficients.size())
      return before.coefficients[coefficient.number].value;
  return std::nullopt;
}

std::string row_of(const FittedCoefficient& fitted, const std::optional<double>& nominal,
                   double share, const KinematicChain& chain) {
  const Coefficient& c = fitted.effect->coefficients[fitted.number];
  std::string line =
      csv_cell(fitted.name) + "," + coefficient_unit(*fitted.effect, fitted.number, chain);
  add(nominal, 1, line);
  add(c.value, 1, line);
  add(nominal ? std::optional(c.value - *nominal) : std::nullopt, 1, line);
  add_rounded(c.std > 0 ? std::optional(c.std) : std::nullopt, 1, line);
  for (const double bound : c.ci95) add(c.std > 0 ? std::optional(bound) : std::nullopt, 1, line);
  return line + "," + number_in_form("{:.2f}", share) + "\n";
}

}  // namespace

std::string write_parameters(const Robot& nominal, const CalibrationResult& result, int poses) {
  std::string text =
      "parameter,unit,nominal,value,change,std,ci95_low,ci95_high,share_of_readings\n";
  for (const IdentifiedValue& row : identified_values(nominal, result, poses)) text += row_of(row);
  Eigen::Index unknown = result.set.kept.size();
  for (const FittedCoefficient& coefficient : fitted_coefficients(result))
    text += row_of(coefficient, nominal_of(nominal, coefficient),
                   result.share_of_readings[unknown++], result.robot.chain);
  return text;
}

std::string write_correlations(const CalibrationResult& result) {
  std::vector<std::string> names;
  for (const int parameter : result.set.kept)
    names.push_back(parameter_name(result.robot.chain, parameter));
  for (const FittedCoefficient& coefficient : fitted_coefficients(result))
    names.push_back(coefficient.name);
  std::string text = "parameter";
  for (const std::string& name : names) text += "," + csv_cell(name);
  const Eigen::MatrixXd& covariance = result.covariance;
  for (int i = 0; i < std::ssize(names); ++i) {
    text += "\n" + csv_cell(names[i]);
    for (int j = 0; j < std::ssize(names); ++j) {
      text += ",";
      const bool is_known = std::max(i, j) < covariance.rows();
      const double scale = is_known ? std::sqrt(covariance(i, i) * covariance(j, j)) : 0.0;
      if (scale > 0) text += decimal_text(std::clamp(covariance(i, j) / scale, -1.0, 1.0), 6);
    }
  }
  return text + "\n";
}

}  // namespace armtrue
