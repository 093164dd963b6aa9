#pragma once

#include <map>
#include <string>
#include <vector>

#include "import/column_mapping.h"

namespace armtrue {

/// The units of the columns of a table: from their names, the row of units, --unit and the options
/// for all lengths, angles or times.
class ColumnUnits {
 public:
  /// `joints` of the robot or of the table; all must outlive this.
  ColumnUnits(const PlainTable& table, const ImportNames& names, const ImportOptions& options,
              const std::vector<JointName>& joints)
      : table_(table), names_(names), options_(options), joints_(joints) {}

  /// Sets unit and factor of a column. Throws InputError for a unit that does not fit the quantity,
  /// for two different units, and for a unit in doubt (kOnlyByOption).
  void find(const std::string& quantity, MappedColumn& column);

  /// Throws InputError, with the options that help, if find() found no unit of some columns.
  void refuse_missing() const;

  /// The name of the quantity in measured poses. Of a joint the robot or --column decides whether
  /// it is in deg or in mm.
  std::string wanted_column(const std::string& quantity) const;

 private:
  bool is_clock_time(int k) const;
  [[noreturn]] void refuse_doubted_unit(const std::string& name) const;
  bool fits_robot(const std::string& quantity, UnitKind kind) const;
  UnitKind kind_for_all(const std::string& quantity, UnitKind kind) const;
  std::string unit_for_all(UnitKind kind) const;

  const PlainTable& table_;
  const ImportNames& names_;
  const ImportOptions& options_;
  const std::vector<JointName>& joints_;
  std::map<UnitKind, std::string> without_unit_;  // their names in quotes
};

}  // namespace armtrue
