#include "import/presets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "armtrue/io/source.h"
#include "import/column_names.h"
#include "import/plain_cell.h"
#include "import/shipped_presets.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {
namespace {

// Bounds of a preset. Each placeholder of a header multiplies the time of a match.
constexpr size_t kMostSeparators = 8, kMostColumns = 1000, kMostOfHeader = 200, kMostPlaces = 2;

size_t places_in(std::string_view header) {
  size_t places = 0;
  for (std::string_view place : {"*", "{n}", "{k}", "{joint}"})
    for (size_t at = header.find(place); at != header.npos; at = header.find(place, at + 1))
      ++places;
  return places;
}

TableForm read_form(YamlMap& map) {
  const std::string form = map.text("form", "header");
  for (const auto& [word, which] :
       {std::pair("header", TableForm::header),
        std::pair("spatial-analyzer", TableForm::spatial_analyzer),
        std::pair("motive", TableForm::motive), std::pair("vicon", TableForm::vicon),
        std::pair("qualisys", TableForm::qualisys)})
    if (form == word) return which;
  map.fail("form",
           "'" + form + "' is none of header, spatial-analyzer, motive, vicon and qualisys");
}

PresetColumn read_column(YamlMap map, bool holds_joints) {
  PresetColumn column{map.text("header"), map.text("is"), map.text("unit", ""),
                      map.text("beside", "")};
  if (column.header.empty()) map.fail("header", "is empty");
  if (column.header.size() > kMostOfHeader || places_in(column.header) > kMostPlaces)
    map.fail("header",
             fmt::format("has at most {} characters, and {} of *, {{n}}, {{k}} and {{joint}}",
                         kMostOfHeader, kMostPlaces));
  const bool counts_joints = column.header.find("{k}") != std::string::npos ||
                             column.header.find("{n}") != std::string::npos ||
                             column.header.find("{joint}") != std::string::npos;
  const bool is_listed = column.quantity == "q" || column.quantity == "cov";
  if (column.quantity == "q" && !holds_joints)
    map.fail("is", "'q' is a joint angle; a preset of points has none");
  if (!is_listed && !stated_quantity(column.quantity))
    map.fail("is",
             "'" + column.quantity +
                 "' is nothing that a reading has; give t, x, y, z, qw, qx, qy, qz, rx, ry, "
                 "rz, r11 to r33, pose, target, payload, dir1, temp_NAME or, of joint angles, q");
  if (is_listed && !counts_joints)
    map.fail("header", "'" + column.header +
                           "' does not say which joint: put {n} where the number stands that "
                           "counts from 1, {k} from 0, or {joint} for its name");
  if (!is_listed && counts_joints) map.fail("header", "only columns of 'q' and 'cov' are counted");
  if (!column.unit.empty() && column.unit != kOnlyByOption && !find_unit(column.unit))
    map.fail("unit",
             "'" + column.unit +
                 "' is no unit; known are mm, cm, m, um, in, deg, rad, mrad, s, ms, us, ns, "
                 "min, h, kg, C and, where the file itself may be wrong, by option");
  const auto quantity = stated_quantity(column.quantity);
  const auto unit = find_unit(column.unit);
  if (quantity && unit && !fits_kind(quantity->kind, unit->kind))
    map.fail("unit", "'" + column.unit + "' is no unit of '" + column.quantity + "'");
  map.finish();
  return column;
}

bool is_number_sign(unsigned char c) { return std::isdigit(c) != 0; }

int lower(unsigned char c) { return std::tolower(c); }

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
  return trimmed(header.substr(0, header.find_last_of("([")));
}

}  // namespace

const std::vector<Preset>& presets() {
  static const std::vector<Preset> kPresets = [] {
    std::vector<Preset> shipped;
    for (const char* const text : kShippedPresets)
      shipped.push_back(parse_preset(text, "config/presets"));
    return shipped;
  }();
  return kPresets;
}

Preset parse_preset(const std::string& text, const std::string& file) {
  YamlMap document = read_document(text, file, {"armtrue-preset/1"});
  Preset preset;
  preset.name = document.name("name");
  const std::string of = document.text("of");
  if (of != "points" && of != "joints")
    document.fail("of", "'" + of + "' is neither points nor joints");
  preset.holds_joints = of == "joints";
  preset.form = read_form(document);
  preset.separators = document.text("separators", ",;\t");
  if (preset.separators.empty() || preset.separators.size() > kMostSeparators)
    document.fail("separators", fmt::format("lists 1 to {} signs", kMostSeparators));
  preset.comments = document.text("comments", "");
  const std::string sparse = document.text("sparse", "no");
  if (sparse != "yes" && sparse != "no")
    document.fail("sparse", "'" + sparse + "' is neither yes nor no");
  preset.is_sparse = sparse == "yes";
  if (preset.is_sparse && !preset.holds_joints)
    document.fail("sparse", "is about rows without joint angles, and these are points");
  for (const YamlMap& column : document.maps("columns"))
    preset.columns.push_back(read_column(column, preset.holds_joints));
  if (preset.columns.empty() || preset.columns.size() > kMostColumns)
    document.fail("columns", fmt::format("lists 1 to {} columns", kMostColumns));
  document.finish();
  return preset;
}

Preset read_preset(const std::string& path) {
  Source source(path);
  return parse_preset(source.read_all(), source.name());
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
