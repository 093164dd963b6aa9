// Tables that instruments and controllers exported.

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "armtrue/import/import_io.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/text/number_text.h"
#include "fuzz/memory_file.h"
#include "fuzz/targets.h"

namespace armtrue::fuzz {
namespace {

// The robots that options may name.
std::optional<Robot> robot_named(const std::string& name) {
  static const auto shipped = [](const char* file) {
    return read_robot(std::string(ARMTRUE_CONFIG) + "/robots/" + file).robot;
  };
  static const std::map<std::string, Robot> robots{{"ur5e", shipped("ur5e.yaml")},
                                                   {"kr360", shipped("kr360.yaml")},
                                                   {"rail", shipped("kr360-rail.yaml")}};
  const auto found = robots.find(name);
  return found == robots.end() ? std::nullopt : std::optional(found->second);
}

// The command line lets only finite numbers through.
std::optional<double> finite_number(const std::string& text) {
  const auto value = read_number(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

// What import-readings is called with: words such as join=time, preset=ur-rtde, unit=X=mm.
ImportOptions options_from(const std::string& text) {
  ImportOptions options;
  std::map<std::string, std::string> words;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) {
    const size_t equals = std::min(word.find('='), word.size());
    const std::string value = word.substr(std::min(equals + 1, word.size()));
    const std::string name = word.substr(0, equals);
    if (name == "column") options.columns.push_back(value);
    if (name == "unit") options.units.push_back(value);
    if (name == "ignore") options.ignored.push_back(value);
    if (name == "joint") options.joint_of_link["shoulder_link"] = value;
    const std::vector<std::string> formats = import_presets();
    if (name == "preset" && std::ranges::find(formats, value) != formats.end())
      options.presets.push_back(value);
    words[name] = value;
  }
  // The command line lets only these words through.
  const auto choose = [&words](const char* name, std::initializer_list<const char*> known) {
    for (const char* word : known)
      if (words[name] == word) return words[name];
    return std::string();
  };
  options.length_unit = choose("length", {"mm", "cm", "m", "um", "in"});
  options.angle_unit = choose("angle", {"deg", "rad", "mrad"});
  options.time_unit = choose("time", {"s", "ms", "us", "ns", "min", "h"});
  options.angles = choose("angles", {"abc", "rpy", "rotvec"});
  options.quaternion = choose("quaternion", {"wxyz", "xyzw"});
  options.decimal = choose("decimal", {"point", "comma"});
  options.join = choose("join", {"id", "order", "time", "stops"});
  options.body = words["body"];
  options.robot = robot_named(words["robot"]);
  options.clock_offset_s = finite_number(words["offset"]);
  if (const auto gap = finite_number(words["gap"]); gap && *gap > 0) options.max_gap_s = *gap;
  return options;
}

// A first line `options: join=time preset=ur-rtde unit=X=mm ...` holds what import-readings is
// called with. Behind a zero byte stands the controller's table.
void read_exported_table(const std::string& bytes) {
  ImportOptions options;
  std::string tables = bytes;
  if (const std::string first = bytes.substr(0, bytes.find('\n')); first.starts_with("options:")) {
    tables = bytes.substr(std::min(first.size() + 1, bytes.size()));
    options = options_from(first.substr(8));
  }
  const size_t zero = tables.find('\0');
  const MemoryFile points(tables.substr(0, zero));
  const ImportedReadings readings =
      zero == std::string::npos
          ? import_readings(points.path(), options)
          : import_readings(points.path(), MemoryFile(tables.substr(zero + 1)).path(), options);
  // What is imported can be read.
  read_campaign(MemoryFile(write_campaign(readings.campaign, readings.joints)).path(),
                readings.joints);
}

constexpr Target kExportedTables[] = {{"import", read_exported_table}};

}  // namespace

std::span<const Target> exported_table_targets() { return kExportedTables; }

}  // namespace armtrue::fuzz
