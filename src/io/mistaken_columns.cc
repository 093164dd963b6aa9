#include "io/mistaken_columns.h"

#include <algorithm>
#include <set>
#include <string_view>

#include "armtrue/text/edit_distance.h"
#include "armtrue/text/input_error.h"

namespace armtrue {
namespace {

using Names = std::set<std::string, std::less<>>;

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

// Usual names of a column in English and German, in the form of plain_name().
struct OtherNames {
  const char* column;
  Names names;
};

const std::vector<OtherNames>& other_names() {
  static const std::vector<OtherNames> kOtherNames{
      {"payload_kg", {"payload", "payloadkg", "load", "loadkg", "payloadmass", "nutzlast", "traglast",
                      "last", "nutzlastkg", "traglastkg", "lastkg"}},
      {"session", {"station", "setup", "sessionid", "sessionname", "sitzung", "aufstellung",
                   "aufbau", "standort"}},
      {"t_s", {"zeit", "zeits", "zeitpunkt", "uhrzeit", "elapsed", "elapsedtime", "sekunden"}},
      {"repeat", {"run", "trial", "cycle", "wiederholung", "durchgang", "durchlauf"}},
      {"target", {"reflector", "reflektor", "smr", "marker", "prism", "prisma", "nest", "ball"}},
      {"anchor", {"anker", "ankerpunkt", "anchorpoint"}},
      {"contact", {"kontakt", "touch"}},
      {"sigma_mm", {"sigma", "std", "stdmm", "stddev", "stddevmm", "uncertainty", "uncertaintymm",
                    "unsicherheit", "unsicherheitmm"}},
  };
  return kOtherNames;
}

// The column of a component of a vector or of a joint: of force_x, Kraft_X, torque1, tau1.
std::string component_of(const std::string& name) {
  static const Names kForce{"f", "force", "kraft"};
  static const Names kTorque{"tau", "torque", "motortorque", "moment", "drehmoment", "motormoment"};
  static const Names kDirection{"direction", "richtung", "arrival"};
  std::string stem = name;
  for (const std::string_view unit : {"nm", "n"})
    if (stem.size() > unit.size() + 1 && stem.ends_with(unit))
      stem.resize(stem.size() - unit.size());
  if (stem.size() < 2) return "";
  const char last = stem.back();
  if (last >= 'x' && last <= 'z' && kForce.contains(stem.substr(0, stem.size() - 1)))
    return {'f', last, '_', 'n'};
  const std::string number = stem.substr(stem.find_last_not_of("0123456789") + 1);
  if (number.empty() || number.front() == '0') return "";
  stem.resize(stem.size() - number.size());
  if (kTorque.contains(stem)) return "tau" + number + "_nm";
  if (kDirection.contains(stem)) return "dir" + number;
  return "";
}

// temp_<where>_c of temp_motor, Temperatur_Motor or T_motor_C; a temperature alone names no place.
std::string temperature_of(const std::string& header) {
  std::string name = lower_case(header.substr(0, header.find_first_of("[(")));
  while (name.ends_with(' ') || name.ends_with('_')) name.pop_back();
  for (const char* unit : {"_degc", "_celsius", "_c", "_\xC2\xB0\x63", " c"})
    if (name.ends_with(unit)) name.resize(name.size() - std::string_view(unit).size());
  for (const std::string_view begin : {"temperature", "temperatur", "temp"}) {
    if (!name.starts_with(begin)) continue;
    std::string where = name.substr(begin.size());
    where.erase(0, where.find_first_not_of("_ -"));
    return "temp_" + (where.empty() ? "<where>" : where) + "_c";
  }
  return "";
}

// The column that is read in the place of an unknown one; empty if none is likely.
std::string likely_column(const std::string& header, const std::vector<std::string>& known) {
  const std::string name = plain_name(header);
  for (const OtherNames& other : other_names())
    if (other.names.contains(name)) return other.column;
  if (std::string component = component_of(name); !component.empty()) return component;
  if (std::string temperature = temperature_of(header); !temperature.empty()) return temperature;
  constexpr size_t kShortest = 4;  // shorter names differ by a letter from many others
  if (name.size() < kShortest) return "";
  const auto distance = [&](const std::string& column) {
    return edit_distance(plain_name(column), name);
  };
  const auto nearest = std::ranges::min_element(known, {}, distance);
  const bool is_slip = nearest != known.end() && plain_name(*nearest).size() >= kShortest &&
                       distance(*nearest) <= 1;
  return is_slip ? *nearest : "";
}

}  // namespace

std::vector<std::string> with_likely_columns(const CsvTable& table,
                                             const std::vector<std::string>& unknown,
                                             const std::vector<std::string>& known) {
  std::vector<std::string> texts;
  for (const std::string& header : unknown) {
    if (header.empty()) continue;
    const std::string likely = likely_column(header, known);
    // Temperatures, whose names are the user's, are read where payloads are.
    const std::string read = likely.starts_with("temp_") ? "payload_kg" : likely;
    const bool is_asked = !likely.empty() && likely != header && !table.find(likely) &&
                          std::ranges::find(known, read) != known.end();
    texts.push_back(is_asked ? header + " (did you mean " + likely + "?)" : header);
  }
  return texts;
}

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
