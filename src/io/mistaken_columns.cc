#include "io/mistaken_columns.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <string_view>

#include "armtrue/text/input_error.h"

namespace armtrue {
namespace {

using Names = std::set<std::string, std::less<>>;

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

// `Time [s]`, `time_s` and `TIME` are one name.
std::string plain_name(std::string_view header) {
  static const Names kUnits{"s", "ms", "sec", "min", "h", "deg", "rad", "mrad"};
  std::string name = lower_case(header.substr(0, header.find_first_of("[(")));
  while (name.ends_with(' ') || name.ends_with('_')) name.pop_back();
  if (const size_t sign = name.find_last_of("_ ");
      sign != std::string::npos && kUnits.contains(name.substr(sign + 1)))
    name.resize(sign);
  std::erase_if(name, [](char c) { return c == ' ' || c == '_' || c == '-' || c == '.'; });
  return name;
}

Names names_of_orientations() {
  Names names{"a", "b", "c", "roll", "pitch", "yaw"};
  for (const char* axis : {"w", "x", "y", "z"})
    for (const char* quantity : {"q", "quat", "quaternion", "orientation"})
      names.insert(std::string(quantity) + axis);
  for (const char* axis : {"x", "y", "z"})
    for (const char* quantity : {"r", "rot", "rotation"})
      names.insert(std::string(quantity) + axis);
  for (const char row : {'1', '2', '3'})
    for (const char column : {'1', '2', '3'}) names.insert({'r', row, column});
  return names;
}

// What a column seems to hold, and the columns that are read as such; empty if it is nothing known.
std::string mistaken_for(const std::string& header, const AbsentQuantities& absent) {
  static const Names kOrientation = names_of_orientations();
  static const Names kTime{"t", "time", "timestamp", "datetime", "date/time"};
  static const Names kRepeat{"repeat", "rep", "repetition"};
  const std::string name = plain_name(header);
  if (absent.orientation && kOrientation.contains(name))
    return "an orientation, which is read from a_deg,b_deg,c_deg (R = Rz(a) Ry(b) Rx(c))";
  if (absent.time && kTime.contains(name)) return "a time, which is read from t_s";
  if (absent.repeat && kRepeat.contains(name)) return "a repeat, which is read from repeat";
  return "";
}

}  // namespace

void refuse_mistaken_columns(const CsvTable& table, const std::vector<std::string>& unknown,
                             const std::vector<std::string>& known,
                             const AbsentQuantities& absent) {
  for (const std::string& column : unknown) {
    const auto same = std::ranges::find_if(
        known, [&](const std::string& name) { return lower_case(name) == lower_case(column); });
    if (same != known.end() && !table.find(*same))
      throw InputError(table.source_name() + ": is '" + column + "' meant to be '" + *same +
                       "'? Rename it so, or remove it");
    if (const std::string what = mistaken_for(column, absent); !what.empty())
      throw InputError(
          table.source_name() + ": the column '" + column + "' looks like " + what +
          "; convert and rename it (import-readings does so with measured poses), or remove "
          "it");
  }
}

}  // namespace armtrue
