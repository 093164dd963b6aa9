#include <fmt/format.h>

#include <algorithm>

#include "armtrue/text/input_error.h"
#include "io/import/column_mapping.h"

namespace armtrue {
namespace {

struct NamePair {
  std::string left, right;
};

// q1_deg=A1 is split at its first =, A1=deg at its last: their names may hold one.
NamePair split_pair(const std::string& option, const std::string& text, size_t sign) {
  if (sign == std::string::npos || sign == 0 || sign + 1 == text.size())
    throw InputError(option + " '" + text + "': expected two names, such as " +
                     (option == "--unit" ? "A1=deg" : "q1_deg=A1"));
  return {text.substr(0, sign), text.substr(sign + 1)};
}

bool matches(const std::string& pattern, const std::string& name) {
  if (!pattern.ends_with('*')) return pattern == name;
  return name.starts_with(pattern.substr(0, pattern.size() - 1));
}

}  // namespace

ImportNames::ImportNames(const ImportOptions& options) : ignored_(options.ignored) {
  for (const std::string& text : options.columns) {
    const NamePair pair = split_pair("--column", text, text.find('='));
    const auto quantity = stated_quantity(pair.left);
    if (!quantity)
      throw InputError(
          "--column '" + text + "': '" + pair.left +
          "' is no column of measured poses that this command writes; write OUR=THEIRS "
          "with pose, repeat, session, target, t_s, q1_deg, x_mm, a_deg, roll, rx, qw, "
          "payload_kg or temp_NAME_c on the left");
    if (maps(quantity->name))
      throw InputError("--column: two columns are named for " + our_column(quantity->name) +
                       "; leave one out");
    if (!quantities_.insert({pair.right, quantity->name}).second)
      throw InputError("--column: '" + pair.right + "' is named twice; leave one out");
    named_.push_back(pair.right);
  }
  for (const std::string& text : options.units) {
    const NamePair pair = split_pair("--unit", text, text.rfind('='));
    if (!find_unit(pair.right))
      throw InputError("--unit '" + text + "': '" + pair.right +
                       "' is no unit; known are mm, cm, m, um, in, deg, rad, mrad, s, ms, us, ns, "
                       "min, h, kg, C");
    if (!units_.insert({pair.left, pair.right}).second)
      throw InputError("--unit: '" + pair.left + "' is named twice; leave one out");
    named_.push_back(pair.left);
  }
  named_.insert(named_.end(), ignored_.begin(), ignored_.end());
}

void ImportNames::add_preset(const std::string& preset) {
  if (preset != "ur-rtde") return;
  has_preset_ = true;
  const auto add = [&](const std::string& header, const std::string& quantity,
                       const std::string& unit) {
    quantities_.insert({header, quantity});
    units_.insert({header, unit});
  };
  for (int joint = 0; joint < 6; ++joint)
    add(fmt::format("actual_q_{}", joint), fmt::format("q{}", joint + 1), "rad");
  add("timestamp", "t", "s");
}

bool ImportNames::is_known(std::string_view header) const {
  const auto quantity = known_quantity(header);
  return quantities_.contains(header) ||
         (quantity && (quantity->kind == UnitKind::length || quantity->kind == UnitKind::angle));
}

bool ImportNames::is_ignored(const std::string& header) const {
  return std::ranges::any_of(ignored_,
                             [&](const std::string& pattern) { return matches(pattern, header); });
}

const std::string* ImportNames::quantity_of(const std::string& header) const {
  const auto found = quantities_.find(header);
  return found == quantities_.end() ? nullptr : &found->second;
}

const std::string* ImportNames::unit_of(const std::string& header) const {
  const auto found = units_.find(header);
  return found == units_.end() ? nullptr : &found->second;
}

bool ImportNames::maps(const std::string& quantity) const {
  return std::ranges::any_of(quantities_,
                             [&](const auto& entry) { return entry.second == quantity; });
}

void ImportNames::check_all_found(const std::vector<const PlainTable*>& tables) const {
  for (const std::string& name : named_) {
    const bool found = std::ranges::any_of(tables, [&](const PlainTable* table) {
      return std::ranges::any_of(
          table->columns, [&](const PlainColumn& column) { return matches(name, column.name); });
    });
    if (!found)
      throw InputError(tables.front()->file + ": the options name the column '" + name +
                       "', which no header has; write it as it stands there");
  }
}

}  // namespace armtrue
