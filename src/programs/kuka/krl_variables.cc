#include "programs/kuka/krl_variables.h"

#include <algorithm>
#include <cmath>

#include "programs/arithmetic.h"

namespace armtrue {
namespace {

// Of A1 to A6; -1 of anything else.
int axis_of(const std::string& name) {
  return name.size() == 2 && name[0] == 'A' && name[1] >= '1' && name[1] <= '6' ? name[1] - '1'
                                                                                : -1;
}

bool is_whole(const KrlValue& value) {
  const auto is_finite = [](double number) { return std::isfinite(number); };
  return value.is_axes ? std::ranges::all_of(value.point.axes, is_finite)
                       : value.point.values.head<6>().array().isFinite().all();
}

}  // namespace

// Certain values give certain values, so any round may be the last. A round finds the values that
// depend on those of the round before.
void KrlVariables::follow() {
  constexpr int kRounds = 8;  // more variables in a chain, of no real program, would take long
  bool is_changed = true;
  for (auto& [name, variable] : variables_) note_what_stays(variable);
  for (int round = 0; is_changed && round < kRounds; ++round) {
    is_changed = false;
    for (auto& [name, variable] : variables_) is_changed |= follow(name, variable);
  }
  for (auto& [name, variable] : variables_) note_what_is_stated(variable);
}

std::optional<KrlFdat> KrlVariables::fdat_at(const std::string& name, size_t place) const {
  if (const std::optional<KrlValue> value = value_at(name, place)) return value->fdat;
  const auto variable = variables_.find(name);
  return variable == variables_.end() ? std::nullopt : variable->second.stays;
}

std::optional<double> KrlVariables::number_at(std::string_view expression, size_t place) const {
  TextCursor cursor(expression, 0, expression.size());
  const std::optional<double> number = sum(cursor, place);
  return cursor.done() ? number : std::nullopt;
}

void KrlVariables::note_what_stays(Variable& variable) const {
  std::optional<KrlFdat> stays = variable.declared.fdat;
  for (const KrlChange& change : variable.changes) {
    TextCursor cursor(src_, change.begin, change.end);
    cursor.take_name();
    const std::string component =
        change.is_assignment && cursor.take('.') ? cursor.take_name() : "";
    if (!stays || component.empty() || component == "IPO_FRAME") return;
    if (component == "TOOL_NO") stays->tool.reset();
    if (component == "BASE_NO") stays->base.reset();
  }
  variable.stays = stays;
}

bool KrlVariables::follow(const std::string& name, Variable& variable) {
  std::vector<int> set;
  for (const KrlChange& change : variable.changes) {
    const std::optional<KrlValue> value = set_by(name, change);
    set.push_back(value ? number_of(*value) : ProgramFlow::kUncertain);
  }
  if (variable.is_followed && set == variable.set) return false;
  std::vector<ProgramFlow::Setting> settings;
  for (size_t i = 0; i < set.size(); ++i) settings.push_back({variable.changes[i].begin, set[i]});
  variable.values = steps_.follow(std::move(settings));
  variable.set = std::move(set);
  return variable.is_followed = true;
}

std::optional<KrlValue> KrlVariables::value_at(const std::string& name, size_t place) const {
  if (const auto constant = constants_.find(name); constant != constants_.end())
    return constant->second;
  const auto variable = variables_.find(name);
  if (variable == variables_.end() || !variable->second.is_followed) return std::nullopt;
  const int value = variable->second.values.at(place);
  if (value == ProgramFlow::kUncertain) return std::nullopt;
  return values_[value];
}

const std::vector<KrlChange>& KrlVariables::changes_of(const std::string& name) const {
  static const std::vector<KrlChange> kNone;
  const auto found = variables_.find(name);
  return found == variables_.end() ? kNone : found->second.changes;
}

void KrlVariables::note_what_is_stated(Variable& variable) const {
  const auto note = [&](const KrlFrame& point) {
    variable.states_turn |= point.status || point.turn;
    for (size_t i = 0; i < variable.states_external.size(); ++i)
      variable.states_external[i] |= std::isfinite(point.values[i + 6]);
  };
  note(variable.declared.point);
  for (size_t i = 0; i < variable.set.size(); ++i)
    if (variable.set[i] != ProgramFlow::kUncertain)
      note(values_[variable.set[i]].point);
    else if (!sets_coordinate(variable.changes[i]))
      variable.is_anything = true;
}

// XP1.X=.., of a coordinate or an axis of the arm: whatever its value is, it states nothing else.
bool KrlVariables::sets_coordinate(const KrlChange& change) const {
  TextCursor cursor(src_, change.begin, change.end);
  cursor.take_name();
  if (!change.is_assignment || !cursor.take('.')) return false;
  const std::string component = cursor.take_name();
  const int k = krl_component(component);
  return cursor.take('=') && (axis_of(component) >= 0 || (k >= 0 && k < 6));
}

bool KrlVariables::may_keep_more(const std::string& name, const KrlValue& value,
                                 bool with_turn) const {
  const auto found = variables_.find(name);
  if (found == variables_.end()) return false;
  const std::string& type = types_.at(name);
  if (type == "FRAME") return false;
  const Variable& variable = found->second;
  const KrlFrame& point = value.point;
  if (with_turn && !value.is_axes && (!point.status || !point.turn) &&
      (variable.states_turn || variable.is_anything))
    return true;
  if (type == "POS") return false;
  bool states_any = false;
  for (size_t i = 0; i < variable.states_external.size(); ++i) {
    const bool states_this = std::isfinite(point.values[i + 6]);
    if (variable.states_external[i] && !states_this) return true;
    states_any |= states_this;
  }
  return variable.is_anything && !states_any && has_external_;
}

// NAME={..}, NAME=OTHER, NAME.X=.., NAME=.. of a number.
std::optional<KrlValue> KrlVariables::set_by(const std::string& name,
                                             const KrlChange& change) const {
  if (!change.is_assignment || change.begin == 0) return std::nullopt;
  const size_t before = change.begin - 1;  // where the statement has not run yet
  TextCursor cursor(src_, change.begin, change.end);
  cursor.take_name();
  const std::string component = cursor.take('.') ? cursor.take_name() : "";
  if (!cursor.take('=')) return std::nullopt;
  const std::string& type = types_.at(name);
  if (type == "FDAT") return fdat_set_by(name, component, cursor, before);
  const bool is_number = type == "REAL" || type == "INT";
  if (!component.empty() || is_number) {
    const std::optional<double> number = sum(cursor, before);
    if (!number || !cursor.done()) return std::nullopt;
    // A controller rounds what an INT is given.
    if (type == "INT" && *number != std::floor(*number)) return std::nullopt;
    if (is_number)
      return component.empty() ? std::optional(KrlValue{number, {}, false}) : std::nullopt;
    const std::optional<KrlValue> value = value_at(name, before);
    return value ? with_component(*value, component, *number) : std::nullopt;
  }
  const std::optional<KrlValue> value = point(cursor, type, before);
  return cursor.done() ? value : std::nullopt;
}

// {..}, another FDAT, or one component of it.
std::optional<KrlValue> KrlVariables::fdat_set_by(const std::string& name,
                                                  const std::string& component, TextCursor cursor,
                                                  size_t place) const {
  KrlValue result;
  if (component.empty()) {
    result.fdat = cursor.next() == '{' ? take_krl_fdat(cursor) : fdat_at(cursor.take_name(), place);
    return result.fdat && cursor.done() ? std::optional(result) : std::nullopt;
  }
  result.fdat = fdat_at(name, place);
  if (!result.fdat) return std::nullopt;
  if (component == "IPO_FRAME") {
    if (!cursor.take('#')) return std::nullopt;
    result.fdat->is_external_tcp = cursor.take_name() == "TCP";
  } else if (component == "TOOL_NO" || component == "BASE_NO") {
    const std::optional<double> number = sum(cursor, place);
    if (!number || *number != std::floor(*number)) return std::nullopt;
    (component == "TOOL_NO" ? result.fdat->tool : result.fdat->base) = static_cast<int>(*number);
  } else {
    return result;
  }
  return cursor.done() ? std::optional(result) : std::nullopt;
}

// {..}, a name of the same type, or for a FRAME a product of them.
std::optional<KrlValue> KrlVariables::point(TextCursor& cursor, const std::string& type,
                                            size_t place) const {
  std::vector<std::optional<KrlValue>> factors;
  bool is_of_type = true;
  do {
    std::optional<KrlValue> value;
    if (cursor.next() == '{') {
      const KrlAggregate aggregate = take_krl_aggregate(cursor);
      if (aggregate.kind == KrlAggregateKind::other) return std::nullopt;
      value = {std::nullopt, aggregate.frame, aggregate.kind == KrlAggregateKind::axes};
    } else if (const std::string name = cursor.take_name(); name == "$NULLFRAME") {
      value.emplace().point.values.head<6>().setZero();
      is_of_type = type == "FRAME";
    } else {
      value = value_at(name, place);
      const auto of_name = types_.find(name);
      is_of_type = of_name != types_.end() && of_name->second == type;
    }
    if (!value || value->number || !is_whole(*value)) return std::nullopt;
    factors.push_back(value);
  } while (cursor.take(':'));
  if (factors.size() == 1) return is_of_type ? factors[0] : std::nullopt;
  const std::optional<Pose> pose = product_of(factors);
  if (!pose || (type != "FRAME" && type != "POS" && type != "E6POS")) return std::nullopt;
  KrlValue result;
  result.point.values.head<3>() = pose->translation;
  result.point.values.segment<3>(3) = abc_from_rotation(pose->rotation);
  return result;
}

std::optional<Pose> KrlVariables::product_of(const std::vector<std::optional<KrlValue>>& factors) {
  Pose pose;
  for (const std::optional<KrlValue>& factor : factors) {
    if (!factor || factor->number || factor->is_axes || !is_whole(*factor)) return std::nullopt;
    const KrlValues& v = factor->point.values;
    const bool is_first = &factor == &factors.front();
    if (!is_first &&
        (factor->point.status || factor->point.turn || v.tail<6>().array().isFinite().any()))
      return std::nullopt;
    pose = pose * Pose{rotation_from_abc(v[3], v[4], v[5]), v.head<3>()};
  }
  return pose;
}

std::optional<KrlValue> KrlVariables::with_component(KrlValue value, const std::string& component,
                                                     double number) const {
  if (const int k = krl_component(component); k >= 0 && (k > 5 || !value.is_axes)) {
    value.point.values[k] = number * krl_unit(k);
    return value;
  }
  if (const int axis = axis_of(component); axis >= 0 && value.is_axes) {
    value.point.axes[axis] = number;
    return value;
  }
  return std::nullopt;
}

// A quotient of two INT is a whole number, so quotients are not followed.
std::optional<double> KrlVariables::sum(TextCursor& cursor, size_t place) const {
  return take_sum(
      cursor, [&](TextCursor& rest) { return take_named_number(rest, place); },
      Quotient::not_followed);
}

// A number, or a component of a point or an FDAT.
std::optional<double> KrlVariables::take_named_number(TextCursor& cursor, size_t place) const {
  const std::string name = cursor.take_name();
  if (name.empty()) return std::nullopt;
  const std::string component = cursor.take('.') ? cursor.take_name() : "";
  const std::optional<KrlValue> value = value_at(name, place);
  if (!value || value->number.has_value() != component.empty()) return std::nullopt;
  if (value->number) return value->number;
  double found = std::nan("");
  if (const std::optional<KrlFdat>& fdat = value->fdat; fdat) {
    const std::optional<int> of_list = component == "TOOL_NO"   ? fdat->tool
                                       : component == "BASE_NO" ? fdat->base
                                                                : std::nullopt;
    if (of_list) found = *of_list;
  } else if (const int k = krl_component(component); k >= 0 && (k > 5 || !value->is_axes)) {
    found = value->point.values[k] / krl_unit(k);
  } else if (const int axis = axis_of(component); axis >= 0 && value->is_axes) {
    found = value->point.axes[axis];
  }
  return std::isfinite(found) ? std::optional(found) : std::nullopt;
}

int KrlVariables::number_of(const KrlValue& value) {
  constexpr double kNone = -1e300;  // no number of a program
  const KrlFrame& point = value.point;
  const KrlFdat fdat = value.fdat.value_or(KrlFdat{});
  std::vector<double> key{value.number.value_or(kNone),
                          value.is_axes ? 1.0 : 0.0,
                          point.status ? *point.status : kNone,
                          point.turn ? *point.turn : kNone,
                          value.fdat ? 1.0 : 0.0,
                          fdat.is_external_tcp ? 1.0 : 0.0,
                          fdat.tool ? *fdat.tool : kNone,
                          fdat.base ? *fdat.base : kNone};
  key.insert(key.end(), point.values.begin(), point.values.end());
  key.insert(key.end(), point.axes.begin(), point.axes.end());
  for (double& number : key)
    if (std::isnan(number)) number = kNone;
  const auto [known, is_new] = numbers_.try_emplace(std::move(key), values_.size());
  if (is_new) values_.push_back(value);
  return known->second;
}

}  // namespace armtrue
