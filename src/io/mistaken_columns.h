#pragma once

#include <string>
#include <vector>

#include "io/csv_table.h"

namespace armtrue {

/// Quantities that a file could have and does not have.
struct AbsentQuantities {
  bool orientation = false, time = false, repeat = false;
};

/// Refuses columns that would be ignored although the user counts on them: throws InputError if one
/// of `unknown` is one of `known` in another case, or has a usual name of a quantity that is
/// absent, such as roll, r11 or time_s.
void refuse_mistaken_columns(const CsvTable& table, const std::vector<std::string>& unknown,
                             const std::vector<std::string>& known, const AbsentQuantities& absent);

/// For each of `unknown`: itself or, if it seems to stand for a column that is read and that the
/// file lacks, such as payload for payload_kg, itself with the question whether it does. A column
/// without a name, as a comma at the end of each line makes one, is left out.
std::vector<std::string> with_likely_columns(const CsvTable& table,
                                             const std::vector<std::string>& unknown,
                                             const std::vector<std::string>& known);

}  // namespace armtrue
