#include <fmt/format.h>

#include <chrono>

#include "armtrue/io/products/certificate_io.h"
#include "armtrue/io/source.h"
#include "armtrue/kinematics/units.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {
namespace {

constexpr double kMicrometre = 1e-6;

std::string filled_text(YamlMap& map, const std::string& key) {
  const std::string text = map.text(key);
  if (text.find_first_not_of(" \t\n") == std::string::npos) map.fail(key, "is empty; fill it in");
  return text;
}

// YYYY-MM-DD, so that texts compare as dates do.
std::string date_text(YamlMap& map, const std::string& key) {
  const std::string text = filled_text(map, key);
  int year = 0, month = 0, day = 0, used = 0;
  const bool is_read =
      text.size() == 10 &&
      std::sscanf(text.c_str(), "%4d-%2d-%2d%n", &year, &month, &day, &used) == 3 && used == 10;
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month),
                                         std::chrono::day(day)};
  if (!is_read || text.find_first_not_of("0123456789-") != std::string::npos || !date.ok())
    map.fail(key, "'" + text + "' is no date; write YYYY-MM-DD, such as 2026-03-31");
  return text;
}

double not_negative(YamlMap& map, const std::string& key) {
  const double value = map.number(key);
  if (value < 0) map.fail(key, "must not be below zero");
  return value;
}

void read_instrument_errors(YamlMap& map, About& about) {
  if (map.has("noise_mm") == map.has("mpe_um"))
    map.fail(map.has("noise_mm") ? "mpe_um" : "noise_mm",
             "give either noise_mm, one standard deviation per axis, or mpe_um: {constant, per_m}, "
             "the maximum permissible error");
  if (map.has("noise_mm")) {
    about.stated.noise = not_negative(map, "noise_mm") * kMillimetre;
    if (*about.stated.noise == 0) map.fail("noise_mm", "no instrument is without noise");
  } else {
    YamlMap mpe = map.map("mpe_um");
    about.stated.mpe_constant = not_negative(mpe, "constant") * kMicrometre;
    about.stated.mpe_per_metre = not_negative(mpe, "per_m") * kMicrometre;
    if (about.stated.mpe_constant + about.stated.mpe_per_metre == 0)
      map.fail("mpe_um", "no instrument is without error");
    mpe.finish();
  }
  if (!map.has("range_mm")) return;
  about.range = map.number("range_mm") * kMillimetre;
  if (*about.range <= 0) map.fail("range_mm", "must be above zero");
}

void read_instrument(YamlMap map, About& about) {
  about.instrument = filled_text(map, "name");
  about.instrument_serial = filled_text(map, "serial");
  about.calibrated_until = date_text(map, "calibrated_until");
  if (about.calibrated_until < about.date)
    map.fail("calibrated_until", "is before the date of the measurement, " + about.date +
                                     "; have the instrument calibrated and measure again");
  read_instrument_errors(map, about);
  map.finish();
}

void read_temperature(YamlMap map, StatedUncertainty& stated) {
  stated.temperature_half_width = not_negative(map, "within_k");
  // um per m and K: an arm of carbon fibre or invar has some tenths, plastics have 200. 11.7 in mm
  // is 0.0117. 0: none.
  constexpr double kLeastExpansion = 0.1, kMostExpansion = 300;
  const double expansion = not_negative(map, "expansion_um_per_m_k");
  if (expansion > 0 && (expansion < kLeastExpansion || expansion > kMostExpansion))
    map.fail("expansion_um_per_m_k",
             fmt::format("is {:.4g}, and that of an arm lies between {:g} and {:g}: is it in "
                         "another unit? Give it in um per m and K, such as 11.7 for steel, or 0 if "
                         "the arm does not expand",
                         expansion, kLeastExpansion, kMostExpansion));
  stated.expansion = expansion * kMicrometre;
  stated.length = not_negative(map, "length_mm") * kMillimetre;
  map.finish();
}

About parse_about(const std::string& text, const std::string& file) {
  YamlMap document = read_document(text, file, {"armtrue-about/1"});
  About about;
  YamlMap robot = document.map("robot");
  about.type = filled_text(robot, "type");
  about.serial = filled_text(robot, "serial");
  robot.finish();
  about.operator_name = filled_text(document, "operator");
  about.date = date_text(document, "date");
  about.place = filled_text(document, "place");
  read_instrument(document.map("instrument"), about);
  about.stated.mounting = not_negative(document, "mounting_mm") * kMillimetre;
  read_temperature(document.map("temperature"), about.stated);
  document.finish();
  return about;
}

CertifiedValue certified_pose(YamlMap& pose, double expanded) {
  CertifiedValue value{pose.text("pose"), not_negative(pose, "ap_mm") * kMillimetre, expanded};
  if (!pose.has("joints")) return value;
  YamlMap joints = pose.map("joints");
  for (const std::string& column : joints.keys()) value.joints[column] = joints.number(column);
  return value;
}

CertifiedValue certified_value(YamlMap map, const std::string& name) {
  CertifiedValue value{name, not_negative(map, "value") * kMillimetre, {}};
  if (map.has("expanded")) value.expanded = not_negative(map, "expanded") * kMillimetre;
  return value;
}

void read_set(YamlMap map, const std::string& prefix, std::vector<CertifiedValue>& values) {
  values.push_back(certified_value(map.map("ap_mm"), prefix + "ap"));
  values.push_back(certified_value(map.map("rp_mm"), prefix + "rp"));
}

void read_path_figures(YamlMap map, std::vector<CertifiedValue>& values) {
  const auto mm = [](YamlMap& from, const char* key) {
    return not_negative(from, key) * kMillimetre;
  };
  YamlMap budget = map.map("budget");
  values.push_back({"at", mm(map, "at_mm"), mm(budget, "expanded_mm")});
  if (!map.has("rt_mm")) return;
  values.push_back({"rt", mm(map, "rt_mm"), {}});
  if (map.has("rt_expanded_mm")) values.back().expanded = mm(map, "rt_expanded_mm");
}

}  // namespace

AboutFile read_about(const std::string& path) {
  Source source(path);
  AboutFile file;
  file.name = source.name();
  file.about = parse_about(source.read_all(), file.name);
  file.sha256 = source.sha256();
  return file;
}

CertificateFile read_certificate(const std::string& path) {
  Source source(path);
  CertificateFile file;
  file.name = source.name();
  YamlMap document = read_document(source.read_all(), file.name, {"armtrue-certificate/1"});
  file.sha256 = source.sha256();
  YamlMap about = document.map("about");
  YamlMap robot = about.map("robot");
  file.values.serial = robot.text("serial");
  file.values.type = robot.text("type", "");
  file.values.date = date_text(about, "date");
  if (document.has("path")) read_path_figures(document.map("path"), file.values.figures);
  if (document.has("path") && !document.has("all")) return file;
  read_set(document.map("all"), "", file.values.figures);
  if (document.has("cube")) read_set(document.map("cube"), "cube ", file.values.figures);
  YamlMap budget = document.map("budget");
  const double expanded = not_negative(budget, "expanded_mm") * kMillimetre;
  for (YamlMap& pose : document.maps("poses"))
    file.values.poses.push_back(certified_pose(pose, expanded));
  return file;
}

}  // namespace armtrue
