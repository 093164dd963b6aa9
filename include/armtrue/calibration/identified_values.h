#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// One geometric parameter before and after a calibration, as tables show it; SI.
struct IdentifiedValue {
  std::string name;
  DisplayUnit unit;  ///< in which files state it: mm, deg or 1
  /// Empty for a parameter that has no value of its own; see parameter_value().
  std::optional<double> nominal, value;
  std::optional<double> change;  ///< see parameter_change()
  std::optional<double> std;     ///< empty if the fit computes none
  /// 95 % interval of the value or, without one, of the change; Student's t with poses - 1 degrees
  /// of freedom.
  std::optional<std::array<double, 2>> ci95;
  std::optional<double> share_of_readings;  ///< empty without a prior: all
};

/// One for each of result.set.kept. `nominal`: the robot before the calibration; `poses`: of the
/// campaign.
std::vector<IdentifiedValue> identified_values(const Robot& nominal,
                                               const CalibrationResult& result, int poses);

/// The unit in which files state a parameter: mm, deg or 1.
DisplayUnit unit_in_files(const KinematicChain& chain, int parameter);

}  // namespace armtrue
