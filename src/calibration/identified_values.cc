#include "armtrue/calibration/identified_values.h"

#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/distributions.h"

namespace armtrue {

DisplayUnit unit_in_files(const KinematicChain& chain, int parameter) {
  switch (parameter_unit(chain, parameter)) {
    case ParameterUnit::metre:
      return {kMillimetre, "mm"};
    case ParameterUnit::radian:
      return {kDegree, "deg"};
    case ParameterUnit::pixel:
      return {1, "px"};
    case ParameterUnit::one:
      break;
  }
  return {1, "1"};
}

std::vector<IdentifiedValue> identified_values(const Robot& nominal,
                                               const CalibrationResult& result, int poses) {
  const KinematicChain &before = nominal.chain, &after = result.robot.chain;
  const double wide = student_t_975(poses - 1);
  std::vector<IdentifiedValue> values;
  for (size_t k = 0; k < result.set.kept.size(); ++k) {
    const int parameter = result.set.kept[k];
    IdentifiedValue& row = values.emplace_back();
    row.name = parameter_name(after, parameter);
    row.unit = unit_in_files(after, parameter);
    row.nominal = parameter_value(before, parameter);
    row.value = parameter_value(after, parameter);
    row.change = parameter_change(before, after, parameter);
    if (const auto std = result.robot.std.find(row.name); std != result.robot.std.end())
      row.std = std->second;
    const auto centre = row.value ? row.value : row.change;
    if (row.std && centre) row.ci95 = {*centre - wide * *row.std, *centre + wide * *row.std};
    const Eigen::Index unknown = k;
    if (result.prior_weight.size() > unknown && result.prior_weight[unknown] != 0)
      row.share_of_readings = result.share_of_readings[unknown];
  }
  return values;
}

}  // namespace armtrue
