#include "programs/krl_variables.h"

#include <algorithm>
#include <cmath>

namespace armtrue {
namespace {

bool is_equal(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

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

bool KrlValue::operator==(const KrlValue& other) const {
  for (int k = 0; k < kKrlComponents; ++k)
    if (!is_equal(point.values[k], other.point.values[k])) return false;
  for (size_t k = 0; k < point.axes.size(); ++k)
    if (!is_equal(point.axes[k], other.point.axes[k])) return false;
  return number == other.number && is_axes == other.is_axes &&
         point.status == other.point.status && point.turn == other.point.turn;
}

// From what is certain only certain values follow, so each round may be the last. A round finds the
// values that depend on those of the round before.
void KrlVariables::follow() {
  constexpr int kRounds = 8;  // more variables in a chain, of no real program, would take long
  bool is_changed = true;
  for (int round = 0; is_changed && round < kRounds; ++round) {
    is_changed = false;
    for (auto& [name, variable] : variables_) is_changed |= follow(name, variable);
  }
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
  variable.values = steps_.flow().follow(settings, ProgramFlow::kUncertain);
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
  return values_[static_cast<size_t>(value)];
}

bool KrlVariables::may_keep_more(const std::string& name, const KrlValue& value,
                                 bool with_turn) const {
  const auto variable = variables_.find(name);
  if (variable == variables_.end()) return false;
  const KrlFrame& point = value.point;
  const bool lacks_turn = with_turn && !value.is_axes && (!point.status || !point.turn);
  const auto states_more = [&](const KrlFrame& other) {
    const auto lacks = point.values.tail<6>().array().isNaN();
    return (lacks_turn && (other.status || other.turn)) ||
           (lacks && other.values.tail<6>().array().isFinite()).any();
  };
  return states_more(variable->second.declared) ||
         std::ranges::any_of(variable->second.set, [&](int number) {
           if (number != ProgramFlow::kUncertain)
             return states_more(values_[static_cast<size_t>(number)].point);
           return lacks_turn || point.values.tail<6>().array().isNaN().all();
         });
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
  const bool is_number = type == "REAL" || type == "INT";
  if (!component.empty() || is_number) {
    const std::optional<double> number = sum(cursor, before);
    if (!number || !cursor.done()) return std::nullopt;
    // A controller rounds what an INT is given.
    if (type == "INT" && *number != std::floor(*number)) return std::nullopt;
    if (is_number) return component.empty() ? std::optional(KrlValue{number, {}, false})
                                            : std::nullopt;
    const std::optional<KrlValue> value = value_at(name, before);
    return value ? with_component(*value, component, *number) : std::nullopt;
  }
  if (cursor.next() == '{') {
    const KrlAggregate aggregate = take_krl_aggregate(cursor);
    const KrlValue value{std::nullopt, aggregate.frame, aggregate.kind == KrlAggregateKind::axes};
    const bool is_point = aggregate.kind != KrlAggregateKind::other && cursor.done();
    return is_point && is_whole(value) ? std::optional(value) : std::nullopt;
  }
  const std::string other = cursor.take_name();
  if (other.empty() || !cursor.done()) return std::nullopt;
  const auto type_of_other = types_.find(other);
  if (type_of_other == types_.end() || type_of_other->second != type) return std::nullopt;
  const std::optional<KrlValue> value = value_at(other, before);
  return value && is_whole(*value) ? value : std::nullopt;
}

std::optional<KrlValue> KrlVariables::with_component(KrlValue value, const std::string& component,
                                                     double number) const {
  if (const int k = krl_component(component); k >= 0 && (k > 5 || !value.is_axes)) {
    value.point.values[k] = number * krl_unit(k);
    return value;
  }
  if (const int axis = axis_of(component); axis >= 0 && value.is_axes) {
    value.point.axes[static_cast<size_t>(axis)] = number;
    return value;
  }
  return std::nullopt;
}

// Sums and products. A quotient of two INT is a whole number, so quotients are not followed.
std::optional<double> KrlVariables::sum(TextCursor& cursor, size_t place) const {
  std::optional<double> result = product(cursor, place);
  while (result && (cursor.next() == '+' || cursor.next() == '-')) {
    const bool is_minus = cursor.take('-');
    if (!is_minus) cursor.take('+');
    const std::optional<double> next = product(cursor, place);
    if (!next) return std::nullopt;
    *result += is_minus ? -*next : *next;
  }
  return result;
}

std::optional<double> KrlVariables::product(TextCursor& cursor, size_t place) const {
  std::optional<double> result = factor(cursor, place);
  while (result && cursor.take('*')) {
    const std::optional<double> next = factor(cursor, place);
    if (!next) return std::nullopt;
    *result *= *next;
  }
  return result;
}

std::optional<double> KrlVariables::factor(TextCursor& cursor, size_t place) const {
  if (const auto number = cursor.take_number()) return number;
  if (cursor.take('-')) {
    const auto next = factor(cursor, place);
    return next ? std::optional(-*next) : std::nullopt;
  }
  const std::string name = cursor.take_name();
  if (name.empty()) return std::nullopt;
  const std::string component = cursor.take('.') ? cursor.take_name() : "";
  const std::optional<KrlValue> value = value_at(name, place);
  if (!value) return std::nullopt;
  if (component.empty()) return value->number;
  if (value->number) return std::nullopt;
  double found = std::nan("");
  if (const int k = krl_component(component); k >= 0 && (k > 5 || !value->is_axes))
    found = value->point.values[k] / krl_unit(k);
  else if (const int axis = axis_of(component); axis >= 0 && value->is_axes)
    found = value->point.axes[static_cast<size_t>(axis)];
  return std::isfinite(found) ? std::optional(found) : std::nullopt;
}

int KrlVariables::number_of(const KrlValue& value) {
  const auto found = std::ranges::find(values_, value);
  if (found == values_.end()) {
    values_.push_back(value);
    return static_cast<int>(values_.size()) - 1;
  }
  return static_cast<int>(found - values_.begin());
}

}  // namespace armtrue
