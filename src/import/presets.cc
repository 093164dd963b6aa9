#include "import/presets.h"

#include <algorithm>
#include <cctype>

#include "import/plain_cell.h"

namespace armtrue {
namespace {

constexpr std::string_view kComments = "#/%";

// A further preset is a further entry here, and a word in apps/import-readings.cc.
std::vector<Preset> all_presets() {
  return {
      {"spatialanalyzer",
       false,
       TableForm::spatial_analyzer,
       ",",
       "/",
       false,
       {{"Point", "pose", "", ""},
        {"X", "x", "", ""},
        {"Y", "y", "", ""},
        {"Z", "z", "", ""},
        {"Time", "t", "", ""}}},
      {"optitrack",
       false,
       TableForm::motive,
       ",",
       "",
       false,
       {{"Time (Seconds)", "t", "s", ""},
        {"Position X", "x", "", ""},
        {"Position Y", "y", "", ""},
        {"Position Z", "z", "", ""},
        {"Rotation X", "qx", "", ""},
        {"Rotation Y", "qy", "", ""},
        {"Rotation Z", "qz", "", ""},
        {"Rotation W", "qw", "", ""}}},
      {"vicon",
       false,
       TableForm::vicon,
       ",;\t",
       "",
       false,
       {{"Time", "t", "s", ""},
        {"TX", "x", "", ""},
        {"TY", "y", "", ""},
        {"TZ", "z", "", ""},
        {"X", "x", "", ""},
        {"Y", "y", "", ""},
        {"Z", "z", "", ""},
        {"RW", "qw", "", ""},
        {"RX", "qx", "", "RW"},
        {"RY", "qy", "", "RW"},
        {"RZ", "qz", "", "RW"},
        {"RX", "rx", "", ""},
        {"RY", "ry", "", ""},
        {"RZ", "rz", "", ""}}},
      {"rostopic-poses",
       false,
       TableForm::header,
       ",",
       "",
       false,
       {{"*header.stamp", "t", "ns", ""},
        {"%time", "t", "ns", ""},
        {"*pose.position.x", "x", "m", ""},
        {"*pose.position.y", "y", "m", ""},
        {"*pose.position.z", "z", "m", ""},
        {"*.translation.x", "x", "m", ""},
        {"*.translation.y", "y", "m", ""},
        {"*.translation.z", "z", "m", ""},
        {"*pose.orientation.x", "qx", "", ""},
        {"*pose.orientation.y", "qy", "", ""},
        {"*pose.orientation.z", "qz", "", ""},
        {"*pose.orientation.w", "qw", "", ""},
        {"*.rotation.x", "qx", "", ""},
        {"*.rotation.y", "qy", "", ""},
        {"*.rotation.z", "qz", "", ""},
        {"*.rotation.w", "qw", "", ""},
        {"*pose.covariance{k}", "cov", "", ""}}},
      {"plotjuggler-poses",
       false,
       TableForm::header,
       ",",
       "",
       false,
       {{"__time", "t", "s", ""},
        {"*/position/x", "x", "m", ""},
        {"*/position/y", "y", "m", ""},
        {"*/position/z", "z", "m", ""},
        {"*/translation/x", "x", "m", ""},
        {"*/translation/y", "y", "m", ""},
        {"*/translation/z", "z", "m", ""},
        {"*/orientation/x", "qx", "", ""},
        {"*/orientation/y", "qy", "", ""},
        {"*/orientation/z", "qz", "", ""},
        {"*/orientation/w", "qw", "", ""},
        {"*/rotation/x", "qx", "", ""},
        {"*/rotation/y", "qy", "", ""},
        {"*/rotation/z", "qz", "", ""},
        {"*/rotation/w", "qw", "", ""},
        {"*pose/covariance[{k}]", "cov", "", ""}}},
      {"ur-rtde",
       true,
       TableForm::header,
       " ",
       kComments,
       false,
       {{"timestamp", "t", "s", ""}, {"actual_q_{k}", "q", "rad", ""}}},
      {"kuka-trace",
       true,
       TableForm::header,
       ";\t,",
       "",
       false,
       {{"Zeit", "t", "s", ""},
        {"AxisPos_Act{n}", "q", kOnlyByOption, ""},
        {"AxisPos_CmdIpo{n}", "q", kOnlyByOption, ""}}},
      {"rostopic-joints",
       true,
       TableForm::header,
       ",",
       "",
       false,
       {{"*header.stamp", "t", "ns", ""},
        {"%time", "t", "ns", ""},
        {"field.position{k}", "q", "", "field.name"}}},
      {"plotjuggler-joints",
       true,
       TableForm::header,
       ",",
       "",
       true,
       {{"__time", "t", "s", ""}, {"*/{joint}/position", "q", "", ""}}},
  };
}

bool is_number_sign(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

int lower(char c) { return std::tolower(static_cast<unsigned char>(c)); }

bool fits(std::string_view pattern, std::string_view text, std::string& captured) {
  if (pattern.empty()) return text.empty();
  const bool is_joint = pattern.starts_with("{joint}");
  const bool is_number = pattern.starts_with("{k}") || pattern.starts_with("{n}");
  if (pattern.front() != '*' && !is_joint && !is_number)
    return !text.empty() && lower(text.front()) == lower(pattern.front()) &&
           fits(pattern.substr(1), text.substr(1), captured);
  const std::string_view rest = pattern.substr(is_joint ? 7 : is_number ? 3 : 1);
  for (size_t length = pattern.front() == '*' ? 0 : 1; length <= text.size(); ++length) {
    const std::string_view part = text.substr(0, length);
    if (is_number && !std::ranges::all_of(part, is_number_sign)) return false;
    if (is_joint && part.find('/') != std::string_view::npos) return false;
    if (!fits(rest, text.substr(length), captured)) continue;
    if (pattern.front() != '*') captured = part;
    return true;
  }
  return false;
}

// "timestamp (s)" is read as "timestamp".
std::string_view without_unit(std::string_view header) {
  if (header.empty() || (header.back() != ')' && header.back() != ']')) return header;
  return trim_blanks(header.substr(0, header.find_last_of("([")));
}

}  // namespace

const std::vector<Preset>& presets() {
  static const std::vector<Preset> kPresets = all_presets();
  return kPresets;
}

const Preset* find_preset(std::string_view name) {
  const auto found = std::ranges::find(presets(), name, &Preset::name);
  return found == presets().end() ? nullptr : &*found;
}

PresetFit fit_of(const PresetColumn& column, std::string_view header) {
  std::string captured;
  if (fits(column.header, header, captured) || fits(column.header, without_unit(header), captured))
    return {&column, captured};
  return {};
}

bool is_in_preset(const Preset& preset, std::string_view header) {
  return std::ranges::any_of(preset.columns, [&](const PresetColumn& column) {
    return fit_of(column, header).column != nullptr;
  });
}

}  // namespace armtrue
