#include "report/parameters_table.h"

#include <fmt/format.h>

#include "armtrue/calibration/identified_values.h"
#include "armtrue/text/number_text.h"
#include "report/page.h"

namespace armtrue {
namespace {

std::string cell(const std::optional<double>& si, const IdentifiedValue& row, const char* column) {
  return keyed_value(si, row.unit.si, "parameters:" + row.name + "/" + column);
}

}  // namespace

std::string parameters_table(const Robot& nominal, const CalibrationResult& result, int poses,
                             const std::string& robot_key) {
  std::vector<TableRow> rows;
  for (const IdentifiedValue& row : identified_values(nominal, result, poses))
    rows.push_back(
        {escaped(row.name), row.unit.name, cell(row.nominal, row, "nominal"),
         cell(row.value, row, "value"), cell(row.change, row, "change"),
         row.std ? keyed(rounded(*row.std / row.unit.si), robot_key + "std/" + row.name) : "-",
         row.share_of_readings ? keyed(fmt::format("{:.2f}", *row.share_of_readings),
                                       robot_key + "calibration/share_of_readings/" + row.name)
                               : "1"});
  return table({"parameter", "unit", "nominal", "new", "change", "standard deviation",
                "share of the readings"},
               rows);
}

}  // namespace armtrue
