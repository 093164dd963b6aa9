#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/kinematics/joint_names.h"
#include "io/csv_table.h"

namespace armtrue {

/// The columns of the conditions at a pose: time, payload, force, directions of arrival, travels
/// since the last reversal, motor torques and temperatures (armtrue-formats(5)). Of one quantity
/// all columns are there, or none.
class ContextColumns {
 public:
  /// Throws InputError if a quantity is there in part.
  ContextColumns(const CsvTable& table, const std::vector<JointName>& joints);

  /// Appends the values of the current row of the table. Throws InputError for impossible values.
  void read(const CsvTable& table, Campaign& campaign) const;

  const std::vector<std::string>& temperature_names() const { return temperature_names_; }
  /// All columns of these quantities.
  const std::set<int>& used() const { return used_; }

 private:
  std::optional<int> time_, payload_;
  std::vector<std::optional<int>> force_, arrival_, motor_torque_;  // empty without these columns
  std::vector<std::optional<CsvTable::Quantity>> stroke_;
  std::vector<int> temperatures_;
  std::vector<std::string> temperature_names_;
  std::set<int> used_;
};

}  // namespace armtrue
