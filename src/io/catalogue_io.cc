#include "armtrue/io/catalogue_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

#include "armtrue/io/source.h"
#include "armtrue/kinematics/units.h"
#include "io/yaml/effect_io.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {
namespace {

// The joints that an entry names.
std::vector<int> read_joints(YamlMap& map, bool of_a_joint) {
  std::vector<int> joints;
  if (map.has("joints")) {
    if (!of_a_joint) map.fail("joints", "only alpha, d, theta, r and beta belong to joints");
    for (const std::string& text : map.texts("joints")) {
      const auto driver = parse_driver("joint-angle " + text);
      if (!driver || driver->is_pair())
        map.fail("joints", fmt::format("'{}' is no joint from 1 to {}", text, kMaxJoints));
      joints.push_back(driver->joint);
    }
  }
  return joints;
}

// Driver and driver_joint of an entry; its joints are known.
void read_driver(YamlMap& map, CatalogueEntry& entry) {
  std::string driver = map.name("driver");
  for (const auto& [word, which] : {std::pair{" own", CatalogueEntry::Joint::own},
                                    std::pair{" previous", CatalogueEntry::Joint::previous},
                                    std::pair{" next", CatalogueEntry::Joint::next}})
    if (const size_t at = (driver + " ").find(std::string(word) + " "); at != std::string::npos) {
      if (entry.joints.empty() && !entry.of_every_joint)
        map.fail("driver", "'" + driver + "' needs a parameter of a joint");
      if (std::ranges::any_of(driver, [](unsigned char c) { return std::isdigit(c) != 0; }))
        map.fail("driver", "'" + driver +
                               "': own, previous and next stand for the only joint of a driver; "
                               "give numbers, in an entry for each joint");
      entry.driver_joint = which;
      driver.replace(at, std::string(word).size(), " 1");
    }
  // "temperature" without a name stands for every sensor of the campaign.
  constexpr std::string_view kAnySensor = " * temperature";
  std::optional<Driver> parsed;
  if (driver == "temperature") {
    parsed = Driver{DriverKind::temperature, -1, -1, ""};
  } else if (driver.ends_with(kAnySensor)) {
    parsed = parse_driver(driver + " any");
    if (parsed) parsed->where.clear();
  } else {
    parsed = parse_driver(driver);
  }
  if (!parsed)
    map.fail("driver", "'" + driver + "' is no driver; give one of " + kDriverForms +
                           ", where own, previous and next may stand for the <j> of one alone, and "
                           "temperature for every sensor");
  entry.driver = *parsed;
  if (entry.driver_joint == CatalogueEntry::Joint::none && parsed->joint >= 0)
    entry.driver_joint = CatalogueEntry::Joint::fixed;
}

Usual read_usual(YamlMap& map) {
  const std::string usual = map.text("usual", "rare");
  if (usual == "most arms") return Usual::most_arms;
  if (usual == "some") return Usual::some;
  if (usual != "rare") map.fail("usual", "'" + usual + "' is none of most arms, some and rare");
  return Usual::rare;
}

void read_family(YamlMap& map, CatalogueEntry& entry) {
  entry.family = map.text("family", "");
  const auto sizes = {std::pair{"typical_mrad", kMilliradian}, {"typical_mm", kMillimetre}};
  for (const auto& [key, unit] : sizes) {
    if (!map.has(key)) continue;
    if (entry.family.empty()) map.fail(key, "is the size of a family; name it under 'family'");
    entry.typical = map.number(key) * unit;
    if (entry.typical <= 0) map.fail(key, "must be above zero");
  }
  const std::string together = map.text("only_together", "no");
  if (together != "yes" && together != "no")
    map.fail("only_together", "'" + together + "' is neither yes nor no");
  entry.only_together = together == "yes";
  if ((entry.only_together || entry.alike) && entry.family.empty())
    map.fail(entry.alike ? "sign" : "only_together",
             "is about the effects of a family; name it under 'family'");
  if (!entry.family.empty() && entry.typical == 0)
    map.fail("family", "needs the typical size of a member, as typical_mrad or typical_mm");
}

CatalogueEntry read_entry(YamlMap map) {
  CatalogueEntry entry;
  entry.name = map.text("name");
  entry.parameter = parameter_of_catalogue(map.text("parameter"));
  const bool of_a_joint = entry.parameter.of_each && entry.parameter.owner == Owner::link;
  if (entry.parameter.owner == Owner::several)
    map.fail("parameter",
             "'" + map.text("parameter") +
                 "' is none of alpha, d, theta, r and beta, no group (base, tool, "
                 "target) and no single one such as base.rx, arm.scale or instrument.scale");
  entry.joints = read_joints(map, of_a_joint);
  entry.of_every_joint = of_a_joint && !map.has("joints");
  read_driver(map, entry);
  entry.shape = read_shape(map);
  if (entry.shape.kind == ShapeKind::series)
    read_series(map.map("series"), entry.driver.is_pair(), entry.shape);
  if (const std::string why = why_invalid(entry.parameter, entry.driver, entry.shape); !why.empty())
    map.fail("driver", why);
  const bool of_angle = has_at(entry.shape.kind) && entry.driver.kind == DriverKind::joint_angle;
  if ((has_at(entry.shape.kind) || entry.shape.kind == ShapeKind::exponential) && !of_angle &&
      entry.driver.kind != DriverKind::time)
    map.fail("shape", "'" + to_string(entry.shape) +
                          "' follows time or a joint angle here, over which t* and tau are "
                          "searched; take such a driver or another shape");
  if (map.has("cycle_mm")) {
    if (entry.shape.kind != ShapeKind::harmonic || entry.driver.kind != DriverKind::range)
      map.fail("cycle_mm", "is about the shape harmonic and the driver range");
    const std::vector<double> cycle = map.numbers("cycle_mm", 2);
    if (cycle[0] <= 0 || cycle[0] >= cycle[1]) map.fail("cycle_mm", "must ascend, above zero");
    entry.cycle = {cycle[0] * kMillimetre, cycle[1] * kMillimetre};
  }
  const std::string sign = map.text("sign", "any");
  if (sign != "any" && sign != "positive" && sign != "alike")
    map.fail("sign", "'" + sign + "' is none of any, positive and alike");
  entry.only_positive = sign == "positive";
  entry.alike = sign == "alike";
  if (map.has("most_of_length")) {
    const bool is_length = is_arm_scale(entry.parameter) ||
                           is_link_parameter(entry.parameter, LinkParameter::d) ||
                           is_link_parameter(entry.parameter, LinkParameter::r);
    if (!is_length)
      map.fail("most_of_length", "is about lengths: give the parameter d, r or arm.scale");
    entry.most_of_length = map.number("most_of_length");
    if (entry.most_of_length == 0) map.fail("most_of_length", "must not be zero");
  }
  entry.usual = read_usual(map);
  read_family(map, entry);
  entry.in_words = map.text("in_words", "");
  entry.separated_by = map.text("separated_by", "");
  map.finish();
  return entry;
}

}  // namespace

Catalogue parse_catalogue(const std::string& text, const std::string& file) {
  YamlMap document = read_document(text, file, {"armtrue-catalogue/1"});
  Catalogue catalogue;
  for (const YamlMap& entry : document.maps("effects")) catalogue.push_back(read_entry(entry));
  if (catalogue.empty()) document.fail("effects", "is empty");
  document.finish();
  return catalogue;
}

Catalogue read_catalogue(const std::string& path) {
  Source source(path);
  return parse_catalogue(source.read_all(), source.name());
}

}  // namespace armtrue
