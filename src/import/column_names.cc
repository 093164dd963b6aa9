#include "import/column_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <set>

#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/edit_distance.h"
#include "armtrue/text/number_text.h"
#include "import/covariance_columns.h"
#include "import/plain_cell.h"

namespace armtrue {
namespace {

constexpr int kMostExternal = 6;

// Joint_1, joint 1 and JOINT1 are one name.
std::string plain_stem(std::string_view stem) {
  std::string plain = lower_case(stem);
  std::erase_if(plain, [](char c) { return c == ' ' || c == '_' || c == '-' || c == '.'; });
  return plain;
}

const std::map<std::string, ColumnUnit, std::less<>>& units() {
  static const auto kUnits = [] {
    std::map<std::string, ColumnUnit, std::less<>> units;
    const auto add = [&](UnitKind kind, double factor, const std::vector<std::string>& written) {
      for (const std::string& name : written) units[name] = {kind, factor};
    };
    add(UnitKind::length, kMillimetre,
        {"mm", "millimeter", "millimeters", "millimetre", "millimetres"});
    add(UnitKind::length, 1e-2, {"cm", "centimeter", "centimeters", "centimetre", "centimetres"});
    add(UnitKind::length, 1, {"m", "meter", "meters", "metre", "metres"});
    add(UnitKind::length, 1e-6, {"um", "\xC2\xB5m"});
    add(UnitKind::length, 25.4 * kMillimetre, {"in", "inch", "inches"});
    add(UnitKind::angle, kDegree,
        {"deg", "degs", "degree", "degrees", "\xC2\xB0", "\xB0"});  // the last in Latin-1
    add(UnitKind::angle, 1, {"rad", "rads", "radian", "radians"});
    add(UnitKind::angle, kMilliradian, {"mrad"});
    add(UnitKind::time, 1, {"s", "sec", "second", "seconds"});
    add(UnitKind::time, 1e-3, {"ms"});
    add(UnitKind::time, 1e-6, {"us"});
    add(UnitKind::time, 1e-9, {"ns"});
    add(UnitKind::time, 60, {"min"});
    add(UnitKind::time, 3600, {"h"});
    add(UnitKind::mass, 1, {"kg"});
    add(UnitKind::mass, 1e-3, {"g"});
    add(UnitKind::temperature, 1,
        {"c",
         "\xC2\xB0"
         "c",
         "degc"});
    add(UnitKind::force, 1, {"n", "newton", "newtons"});
    add(UnitKind::force, 1e3, {"kn"});
    add(UnitKind::force, 4.4482216152605, {"lbf"});
    return units;
  }();
  return kUnits;
}

// The names of quantities by plain_stem() of the headers that are known for them.
const std::map<std::string, KnownQuantity, std::less<>>& known_names() {
  static const auto kNames = [] {
    std::map<std::string, KnownQuantity, std::less<>> names;
    const auto add = [&](const std::string& quantity, UnitKind kind,
                         const std::vector<std::string>& written) {
      for (const std::string& name : written) names[name] = {quantity, kind};
    };
    for (int joint = 1; joint <= kMaxJoints; ++joint)
      for (const char* family : {"a", "j", "q", "joint", "axis", "achse", "gelenk", "axe"})
        add("q" + std::to_string(joint), UnitKind::encoder, {family + std::to_string(joint)});
    for (int axis = 1; axis <= kMostExternal; ++axis)
      add("e" + std::to_string(axis), UnitKind::encoder, {"e" + std::to_string(axis)});
    for (const char axis : std::string("xyz")) {
      const std::string name(1, axis);
      add(name, UnitKind::length,
          {name, "pos" + name, "position" + name, "poseposition" + name, name + "wert",
           "messwert" + name, "ist" + name, name + "ist", "istwert" + name});
      add("r" + name, UnitKind::angle, {"r" + name});
      add("f" + name, UnitKind::force,
          {"f" + name, "force" + name, "kraft" + name, "kraftf" + name});
    }
    for (const char axis : std::string("wxyz")) {
      const std::string name(1, axis);
      add("q" + name, UnitKind::none,
          {"q" + name, "quat" + name, "quaternion" + name, "orientation" + name,
           "poseorientation" + name});
    }
    for (const char digit : std::string("01234")) {
      const std::string name(1, digit);
      add("quat" + name, UnitKind::none, {"quat" + name, "quaternion" + name});
    }
    for (const char row : std::string("123"))
      for (const char column : std::string("123"))
        add(std::string("r") + row + column, UnitKind::none, {std::string("r") + row + column});
    for (const char* name : {"a", "b", "c", "roll", "pitch", "yaw"})
      add(name, UnitKind::angle, {name});
    add("pose", UnitKind::none,
        {"pose", "poseid", "posename", "point", "pointid", "pointname", "name", "id", "punkt",
         "punktid", "punktname", "punktnummer", "punktnr"});
    add("image", UnitKind::none, {"image", "imagefile", "imagename", "filename", "bild"});
    add("repeat", UnitKind::none, {"repeat", "wiederholung"});
    add("session", UnitKind::none, {"session"});
    add("target", UnitKind::none, {"target", "reflector", "reflektor"});
    add("t", UnitKind::time,
        {"t", "time", "timestamp", "datetime", "date/time", "zeit", "messzeit", "zeitstempel",
         "temps"});
    add("date", UnitKind::none, {"date", "datum"});
    add("payload", UnitKind::mass, {"payload", "nutzlast"});
    return names;
  }();
  return kNames;
}

std::optional<KnownQuantity> quantity_of_stem(std::string_view stem) {
  const std::string lower = lower_case(stem);
  if (lower.starts_with("temp_") && lower.size() > 5 &&
      std::ranges::all_of(lower, [](unsigned char c) { return std::isalnum(c) || c == '_'; }))
    return KnownQuantity{lower, UnitKind::temperature};
  const auto found = known_names().find(plain_stem(stem));
  if (found == known_names().end()) return std::nullopt;
  return found->second;
}

// What stands before the last brackets of a header and in them.
ColumnName in_brackets(std::string_view header) {
  if (header.empty() || (header.back() != ']' && header.back() != ')')) return {};
  const size_t open = header.find_last_of(header.back() == ']' ? "[" : "(");
  if (open == std::string_view::npos || open == 0) return {};
  const std::string_view unit = trimmed(header.substr(open + 1, header.size() - open - 2));
  std::string_view stem = trimmed(header.substr(0, open));
  while (!stem.empty() && stem.back() == '_') stem.remove_suffix(1);
  return {std::string(stem), std::string(unit)};
}

ColumnName unit_in_brackets(std::string_view header) {
  const ColumnName name = in_brackets(header);
  return name.stem.empty() || !find_unit(name.unit) ? ColumnName() : name;
}

ColumnName unit_behind_sign(std::string_view header) {
  const size_t sign = header.find_last_of("_ /,.-");
  if (sign == std::string_view::npos || sign == 0) return {};
  const std::string_view unit = header.substr(sign + 1);
  std::string_view stem = header.substr(0, sign);
  while (!stem.empty() && std::string_view("_ /,.-").find(stem.back()) != std::string_view::npos)
    stem.remove_suffix(1);
  if (stem.size() > 3 && stem.ends_with(" in")) stem.remove_suffix(3);
  const auto known = find_unit(unit);
  if (stem.empty() || !known) return {};
  const auto quantity = quantity_of_stem(stem);
  const bool is_of_force = quantity && quantity->kind == UnitKind::force;
  if (known->kind == UnitKind::force && !is_of_force) return {};  // X_N may be a nominal X
  return {std::string(stem), std::string(unit)};
}

}  // namespace

std::optional<ColumnUnit> find_unit(std::string_view text) {
  const auto found = units().find(lower_case(text));
  if (found == units().end()) return std::nullopt;
  return found->second;
}

ColumnName column_name(std::string_view header) {
  header = trimmed(header);
  ColumnName name = unit_in_brackets(header);
  if (name.stem.empty() && !known_names().contains(plain_stem(header)))
    name = unit_behind_sign(header);
  if (name.stem.empty()) name.stem = header;
  return name;
}

std::optional<ColumnName> unknown_unit(std::string_view header) {
  const ColumnName name = in_brackets(trimmed(header));
  if (name.stem.empty() || name.unit.empty() || find_unit(name.unit)) return std::nullopt;
  const auto quantity = quantity_of_stem(name.stem);
  if (!quantity || quantity->kind == UnitKind::none) return std::nullopt;
  return name;
}

std::optional<KnownQuantity> known_quantity(std::string_view header) {
  return quantity_of_stem(column_name(header).stem);
}

std::optional<KnownQuantity> stated_quantity(std::string_view ours) {
  const auto is_axis = [](char c) { return c >= '1' && c <= '3'; };
  if (ours.size() == 3 && ours[0] == 'r' && is_axis(ours[1]) && is_axis(ours[2]))  // of a matrix
    return KnownQuantity{std::string(ours), UnitKind::none};
  const ColumnName name = column_name(ours);
  std::optional<KnownQuantity> quantity = quantity_of_stem(name.stem);
  // Only armtrue's own names count here, not known names of others such as A1.
  if (quantity && quantity->name != name.stem) return std::nullopt;
  if (quantity && !name.unit.empty() && ours != our_column(quantity->name) &&
      !(quantity->kind == UnitKind::encoder && (name.unit == "deg" || name.unit == "mm")))
    return std::nullopt;
  return quantity;
}

std::string our_column(const std::string& quantity) {
  if (quantity.starts_with("temp_")) return quantity + "_c";
  if (quantity == "payload") return "payload_kg";
  if (quantity.starts_with("cov")) return our_covariance_column(quantity);
  const auto found = std::ranges::find_if(
      known_names(), [&](const auto& entry) { return entry.second.name == quantity; });
  switch (found == known_names().end() ? UnitKind::none : found->second.kind) {
    case UnitKind::length:
      return quantity + "_mm";
    case UnitKind::angle:
      return quantity + "_deg";
    case UnitKind::encoder:
      return quantity + (quantity.front() == 'e' ? "_mm" : "_deg");
    case UnitKind::time:
      return quantity + "_s";
    case UnitKind::force:
      return quantity + "_n";
    default:
      return quantity;
  }
}

int joint_number(std::string_view quantity) {
  const auto known = quantity_of_stem(quantity);
  if (!known || known->kind != UnitKind::encoder || known->name != quantity) return 0;
  return read_whole_number(known->name.substr(1)).value();
}

bool fits_kind(UnitKind quantity, UnitKind unit) {
  if (quantity == UnitKind::encoder) return unit == UnitKind::angle || unit == UnitKind::length;
  return quantity == unit;
}

bool looks_like_angle(std::string_view header, std::string_view unit) {
  const auto known = find_unit(unit);
  if (known && known->kind == UnitKind::angle) return true;
  if (const auto quantity = known_quantity(header))
    return quantity->kind == UnitKind::angle || quantity->kind == UnitKind::encoder ||
           quantity->name.starts_with('q');
  const std::string plain = plain_stem(column_name(header).stem);
  static const std::set<std::string, std::less<>> kWhole{"w", "p", "r", "o", "q0", "j0", "a0"};
  static constexpr std::array kParts{
      "angle", "rotat", "orient",  "quat",      "euler",  "roll",  "pitch",  "yaw",   "azimuth",
      "joint", "axis",  "theta",   "elevation", "alpha",  "beta",  "gamma",  "phi",   "omega",
      "kappa", "tilt",  "encoder", "heading",   "winkel", "achse", "gelenk", "zenith"};
  return kWhole.contains(plain) || plain.starts_with("rot") ||
         std::ranges::any_of(
             kParts, [&](const char* part) { return plain.find(part) != std::string::npos; });
}

}  // namespace armtrue
