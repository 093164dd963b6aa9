#include "io/yaml/effect_io.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "armtrue/kinematics/names.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {

std::pair<std::string, double> inner_unit(const Driver& driver, const KinematicChain& chain) {
  if (is_travel(driver, chain)) return {"_mm", kMillimetre};
  return is_angle_or_travel(driver.kind) ? std::pair{"_deg", kDegree} : std::pair{"_s", 1.0};
}

const char* key_of_begin(const Effect& effect) {
  if (!counts_from(effect.shape.kind)) return nullptr;
  switch (effect.driver.kind) {
    case DriverKind::time:
      return "from_s";
    case DriverKind::temperature:
      return "from_degc";
    default:
      return nullptr;
  }
}

Shape read_shape(YamlMap& map) {
  const auto shape = parse_shape(map.text("shape"));
  if (!shape)
    map.fail("shape",
             "'" + map.text("shape") +
                 "' is none of linear, harmonic <n>, sign, step, kink, exponential, pre-sliding, "
                 "series");
  return *shape;
}

void read_series(YamlMap series, bool two_drivers, Shape& shape) {
  const std::string basis = series.text("basis");
  if (basis == "cosine")
    shape.basis = SeriesBasis::cosine;
  else if (basis == "spline")
    shape.basis = SeriesBasis::spline;
  else if (basis == "fourier")
    shape.basis = SeriesBasis::fourier;
  else if (basis == "saturating")
    shape.basis = SeriesBasis::saturating;
  else if (basis == "bump")
    shape.basis = SeriesBasis::bump;
  else if (basis == "polynomial")
    shape.basis = SeriesBasis::polynomial;
  else
    series.fail("basis",
                "'" + basis + "' is none of cosine, spline, fourier, saturating, bump, polynomial");
  const double count = series.number("count");
  const bool polynomial = shape.basis == SeriesBasis::polynomial;
  const int least = shape.basis == SeriesBasis::spline ? 3 : 1;
  const int most = polynomial ? 9 : two_drivers ? 30 : 1000;
  if (count != std::floor(count) || count < least || count > most)
    series.fail("count", "must be a whole number from " + std::to_string(least) + " to " +
                             std::to_string(most));
  shape.count = static_cast<int>(count);
  const auto read_range = [&](const std::string& key, int driver) {
    const std::vector<double> range = series.numbers(key, 2);
    if (range[0] >= range[1]) series.fail(key, "must ascend");
    shape.low[driver] = range[0];
    shape.high[driver] = range[1];
  };
  // In a catalogue these stand on the range of the campaign, or of the travel.
  const bool may_lack_range = polynomial || shape.basis == SeriesBasis::saturating;
  if (shape.basis != SeriesBasis::fourier && (!may_lack_range || series.has("range"))) {
    read_range("range", 0);
    if (two_drivers || polynomial) read_range("second_range", 1);
    if (polynomial) read_range("third_range", 2);
  }
  series.finish();
}

namespace {

// The sessions in their order, and the first one with the effect.
void read_sessions(YamlMap& map, Effect& effect) {
  std::vector<std::string>& sessions = effect.driver.sessions;
  sessions = map.texts("sessions");
  const std::string since = map.name("since");
  const int found = find_name(sessions, since).value_or(0);
  if (found == 0) map.fail("since", "'" + since + "' is none of 'sessions' after the first");
  effect.shape.at = found - 0.5;
}

}  // namespace

Effect read_effect_form(YamlMap& map, const KinematicChain& chain) {
  Effect effect;
  effect.parameter = map.text("parameter");
  if (!first_parameter(chain, effect.parameter))
    map.fail("parameter", "the robot has no parameter '" + to_string(effect.parameter) + "'");
  const auto driver = parse_driver(map.name("driver"));
  if (!driver) map.fail("driver", "'" + map.text("driver") + "' is none of " + kDriverForms);
  effect.driver = *driver;
  if (std::max(driver->joint, driver->second_joint) >= joint_count(chain))
    map.fail("driver", "'" + map.text("driver") + "': the robot has " +
                           std::to_string(joint_count(chain)) + " driven joints");
  effect.shape = read_shape(map);
  if (effect.shape.kind == ShapeKind::series)
    read_series(map.map("series"), effect.driver.is_pair(), effect.shape);
  if (const std::string why = why_invalid(effect.parameter, effect.driver, effect.shape);
      !why.empty())
    map.fail("driver", why);
  if (is_polynomial(effect.shape) && effect.shape.low == effect.shape.high)
    map.fail("series", "a polynomial needs the keys range, second_range and third_range, in m");
  if (effect.shape.kind == ShapeKind::series && effect.shape.basis == SeriesBasis::saturating &&
      effect.shape.low == effect.shape.high)
    map.fail("series",
             "the basis saturating needs the key range: -T and T, in the unit of the driver");
  const auto [suffix, unit] = inner_unit(effect.driver, chain);
  if (driver->kind == DriverKind::session)
    read_sessions(map, effect);
  else if (has_at(effect.shape.kind))
    effect.shape.at = map.number("at" + suffix) * unit;
  else if (const char* key = key_of_begin(effect))
    effect.shape.at = map.number(key, 0.0);
  if (has_tau(effect.shape.kind)) {
    effect.shape.tau = map.number("tau" + suffix) * unit;
    if (effect.shape.tau <= 0) map.fail("tau" + suffix, "must be above zero");
  }
  return effect;
}

namespace {

// Names of the coefficients in the order of the writer; empty if `count` does not fit the effect.
std::vector<std::string> names_by_place(const Effect& effect, size_t count) {
  const size_t members =
      effect.driver.kind == DriverKind::moment ? 1 : group_size(effect.parameter);
  if (count % members != 0) return {};
  const std::vector<std::string> values =
      value_names(effect.shape, static_cast<int>(count / members));
  if (values.size() * members != count) return {};
  if (members == 1) return values;
  std::vector<std::string> names;
  for (size_t i = 0; i < members; ++i)
    for (const std::string& value : values)
      names.push_back(values.size() == 1 ? kTwistNames[i] : kTwistNames[i] + (" " + value));
  return names;
}

// A coefficient and the unit of the parameter that it moves, as the file states it.
struct Entry {
  Coefficient coefficient;
  std::string unit;
};

// Sorts the entries into the order `names`, if their names are these. Other names are labels: the
// entries keep their order. Throws InputError for one of `names` in another place, and for an
// amplitude or a phase.
void put_in_order(const YamlMap& map, const std::vector<std::string>& names,
                  std::vector<Entry>& entries) {
  if (names.size() < 2) return;
  std::vector<Entry> in_order;
  for (const std::string& name : names)
    for (const Entry& entry : entries)
      if (entry.coefficient.name == name) in_order.push_back(entry);
  if (in_order.size() == names.size()) entries = std::move(in_order);
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  for (size_t k = 0; k < names.size(); ++k) {
    const std::string& name = entries[k].coefficient.name;
    const bool is_of_other_place = name != names[k] && std::ranges::count(names, name) > 0;
    if (is_of_other_place || name == "amplitude" || name == "phase")
      map.fail("coefficients", "'" + name + "' stands in the place of '" + names[k] +
                                   "'; write in this order: " + list);
  }
}

void check_units(const YamlMap& map, const Effect& effect, const KinematicChain& chain,
                 const std::vector<Entry>& entries) {
  for (size_t k = 0; k < entries.size(); ++k) {
    const std::string &unit = entries[k].unit, of_parameter = si_unit_moved(effect, k, chain);
    if ((unit == "m" || unit == "rad") && unit != of_parameter)
      map.fail("coefficients", "the unit '" + unit + "' is not that of " + to_string(effect.parameter) +
                                   ", which this coefficient moves in " + of_parameter);
  }
}

}  // namespace

Effect read_effect(YamlMap map, const KinematicChain& chain) {
  Effect effect = read_effect_form(map, chain);
  effect.name = map.text("name");
  if (map.has("family")) {
    effect.family = Family{map.text("family"), map.number("typical")};
    if (effect.family->typical <= 0) map.fail("typical", "must be above zero");
  }
  const std::string of_instrument = map.text("may_be_instrument", "false");
  if (of_instrument != "true" && of_instrument != "false")
    map.fail("may_be_instrument", "'" + of_instrument + "' is neither true nor false");
  effect.may_be_instrument = of_instrument == "true";
  if (map.has("mean")) {
    if (!effect.may_be_instrument && effect.parameter != Parameter("instrument.scale"))
      map.fail("mean", "is of an effect with may_be_instrument: true, or on instrument.scale");
    effect.mean = map.number("mean") * display_unit(chain, effect.parameter).si;
  }
  if (map.has("measured")) {
    const std::vector<double> range = map.numbers("measured", 2);
    if (!can_be_bounded(effect) || range[0] > range[1])
      map.fail("measured",
               "is the lowest and highest value of the driver of an effect of one joint angle, of "
               "the time or of one temperature");
    effect.driver_range = {range[0], range[1]};
  }
  std::vector<Entry> entries;
  for (YamlMap& entry : map.maps("coefficients")) {
    Coefficient& c = entries.emplace_back().coefficient;
    c.name = entry.text("name", "c");
    c.value = entry.number("value");
    c.std = entry.number("std", 0);
    if (entry.has("ci95")) {
      const std::vector<double> interval = entry.numbers("ci95", 2);
      c.ci95 = {interval[0], interval[1]};
    }
    const std::string unit = entry.text("unit", ""), moved = unit.substr(0, unit.find('/'));
    if (!std::ranges::count(std::array{"", "m", "rad", "m or rad", "1"}, moved))
      entry.fail("unit", "'" + unit + "' is not read: values are in SI units, here in m or rad");
    entries.back().unit = moved;
    entry.finish();
  }
  put_in_order(map, names_by_place(effect, entries.size()), entries);
  for (const Entry& entry : entries) effect.coefficients.push_back(entry.coefficient);
  check_units(map, effect, chain, entries);
  // Statements of close-loop about an effect; the prediction does not depend on them.
  for (const char* key :
       {"evidence", "indistinguishable", "ruled_out", "shared_with", "cause", "description",
        "curve", "cycle", "unidentifiable", "separated_by", "variance_share", "variance_share_ci95",
        "may_lead", "at_s_ci95", "at_deg_ci95", "at_mm_ci95", "confirmed", "sentence"})
    map.ignore(key);
  map.finish();
  return effect;
}

}  // namespace armtrue
