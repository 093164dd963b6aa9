#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "programs/abb/rapid_data.h"
#include "programs/abb/rapid_values.h"

// Points, tools and work objects that assignments give constants: w.uframe:=[[..],[..]],
// p.trans.z:=120, p:=q.

namespace armtrue {
namespace {

constexpr size_t kMostChanges = 256;     // of one datum
constexpr int kMostDepthOfRecords = 24;  // of components and of data that stand for one another

using RecordFields = std::vector<std::pair<std::string, std::string>>;  // names and types

// The components of a type, in their order (RAPID reference manual, data types); null of a number.
const RecordFields* fields_of(const std::string& type) {
  static const std::map<std::string, RecordFields> kFields{
      {"TOOLDATA", {{"ROBHOLD", "BOOL"}, {"TFRAME", "POSE"}, {"TLOAD", "LOADDATA"}}},
      {"WOBJDATA",
       {{"ROBHOLD", "BOOL"},
        {"UFPROG", "BOOL"},
        {"UFMEC", "STRING"},
        {"UFRAME", "POSE"},
        {"OFRAME", "POSE"}}},
      {"ROBTARGET",
       {{"TRANS", "POS"}, {"ROT", "ORIENT"}, {"ROBCONF", "CONFDATA"}, {"EXTAX", "EXTJOINT"}}},
      {"POSE", {{"TRANS", "POS"}, {"ROT", "ORIENT"}}},
      {"POS", {{"X", "NUM"}, {"Y", "NUM"}, {"Z", "NUM"}}},
      {"ORIENT", {{"Q1", "NUM"}, {"Q2", "NUM"}, {"Q3", "NUM"}, {"Q4", "NUM"}}},
      {"CONFDATA", {{"CF1", "NUM"}, {"CF4", "NUM"}, {"CF6", "NUM"}, {"CFX", "NUM"}}},
      {"EXTJOINT",
       {{"EAX_A", "NUM"},
        {"EAX_B", "NUM"},
        {"EAX_C", "NUM"},
        {"EAX_D", "NUM"},
        {"EAX_E", "NUM"},
        {"EAX_F", "NUM"}}}};
  const auto found = kFields.find(type);
  return found == kFields.end() ? nullptr : &found->second;
}

bool begins_with(const RapidPath& path, const RapidPath& begin) {
  return path.size() >= begin.size() && std::equal(begin.begin(), begin.end(), path.begin());
}

RapidPath with_field(RapidPath path, const std::string& field) {
  path.push_back(field);
  return path;
}

// .TRANS.Z; nothing if an index stands in it.
std::optional<RapidPath> take_path(TextCursor& cursor) {
  RapidPath path;
  while (cursor.take('.')) path.push_back(cursor.take_name());
  return cursor.next() == '{' ? std::nullopt : std::optional(path);
}

}  // namespace

// An assignment of which `behind` stands behind the name.
void RapidData::note_change(Datum& datum, size_t at, TextCursor behind, size_t end) {
  const auto path = take_path(behind);
  behind.take(':');
  if (!path || !behind.take('=') || datum.changes.size() == kMostChanges) {
    datum.is_lost = true;
    return;
  }
  behind.next();
  datum.changes.push_back({at, *path, {0, behind.at(), end}});
}

std::optional<ListItem> RapidData::record_at(Datum& datum, size_t place) {
  const bool is_followed = flow_ && !datum.is_lost && !datum.is_parameter && !datum.is_of_others &&
                           datum.text == 0 && fields_of(datum.type);
  return is_followed ? component_at(datum, {}, datum.type, place, 0) : std::nullopt;
}

// Of a component that is assigned as a whole, or with a record that holds it; else of each of its
// own components.
std::optional<ListItem> RapidData::component_at(Datum& datum, const RapidPath& path,
                                                const std::string& type, size_t place, int depth) {
  if (depth > kMostDepthOfRecords) return std::nullopt;
  const auto sets_part = [&](const Datum::Change& change) {
    return change.path.size() > path.size() && begins_with(change.path, path);
  };
  if (std::ranges::any_of(datum.changes, sets_part))
    return record_of(type, [&](const std::string& field, const std::string& of_field, size_t) {
      return component_at(datum, with_field(path, field), of_field, place, depth + 1);
    });
  std::vector<size_t> setting;  // changes that set it
  for (size_t i = 0; i < datum.changes.size(); ++i)
    if (begins_with(path, datum.changes[i].path)) setting.push_back(i);
  if (setting.empty()) {
    const auto item = item_in(datum.list, datum.type, path);
    return item ? evaluated(*item, type, place, depth + 1) : std::nullopt;
  }
  auto [known, is_new] = datum.flows.try_emplace(setting);
  if (is_new) {
    std::vector<ProgramFlow::Setting> settings;
    for (const size_t i : setting) settings.push_back({datum.changes[i].at, static_cast<int>(i)});
    known->second = flow_->follow(std::move(settings));
  }
  const int last = known->second.at(place);
  if (last == ProgramFlow::kUncertain) return std::nullopt;
  const Datum::Change& change = datum.changes[static_cast<size_t>(last)];
  if (change.at == 0) return std::nullopt;
  const RapidPath rest(path.begin() + static_cast<long>(change.path.size()), path.end());
  return value_in(change.value, type_in(datum.type, change.path), rest, change.at - 1, depth + 1);
}

// A record of what `of_field` gives for each of its components; nothing if one is not known.
template <class OfField>
std::optional<ListItem> RapidData::record_of(const std::string& type, OfField of_field) {
  const RecordFields* const fields = fields_of(type);
  if (!fields) return std::nullopt;
  ListItem record{ListItem::Kind::list, 0, 0, 0, {}};
  for (size_t i = 0; i < fields->size(); ++i) {
    const auto& [field, type_of_field] = (*fields)[i];
    const auto item = of_field(field, type_of_field, i);
    // A load moves nothing, and no text names a mechanical unit and a frame that it moves.
    if (!item && type_of_field != "LOADDATA" && type_of_field != "STRING") return std::nullopt;
    record.items.push_back(item.value_or(ListItem{}));
  }
  return record;
}

std::string RapidData::type_in(const std::string& type, const RapidPath& path) {
  std::string result = type;
  for (const std::string& name : path) {
    const RecordFields* const fields = fields_of(result);
    if (!fields) return "";
    const auto found = std::ranges::find(*fields, name, &RecordFields::value_type::first);
    if (found == fields->end()) return "";
    result = found->second;
  }
  return result;
}

std::optional<ListItem> RapidData::item_in(const ListItem& record, const std::string& type,
                                           const RapidPath& path) {
  const ListItem* item = &record;
  std::string of_item = type;
  for (const std::string& name : path) {
    const RecordFields* const fields = fields_of(of_item);
    if (!fields || item->items.size() != fields->size()) return std::nullopt;
    const auto found = std::ranges::find(*fields, name, &RecordFields::value_type::first);
    if (found == fields->end()) return std::nullopt;
    item = &item->items[static_cast<size_t>(found - fields->begin())];
    of_item = found->second;
  }
  return *item;
}

// The item of a list that is written: its numbers may be expressions.
std::optional<ListItem> RapidData::evaluated(const ListItem& item, const std::string& type,
                                             size_t place, int depth) {
  if (item.kind == ListItem::Kind::other)
    return item.begin < item.end ? value_in({0, item.begin, item.end}, type, {}, place, depth + 1)
                                 : std::nullopt;
  if (item.kind == ListItem::Kind::number)
    return type == "NUM" ? std::optional(item) : std::nullopt;
  const RecordFields* const fields = fields_of(type);
  if (!fields || item.items.size() != fields->size()) return std::nullopt;
  return record_of(type, [&](const std::string&, const std::string& of_field, size_t i) {
    return evaluated(item.items[i], of_field, place, depth + 1);
  });
}

// The component `path` of an expression of a type: a list, a number, or a datum of the type.
std::optional<ListItem> RapidData::value_in(const Statement& expression, const std::string& type,
                                            const RapidPath& path, size_t place, int depth) {
  if (depth > kMostDepthOfRecords) return std::nullopt;
  const std::string of_component = type_in(type, path);
  if (const auto list = list_in(text_, expression.begin, expression.end)) {
    const auto item = item_in(*list, type, path);
    return item ? evaluated(*item, of_component, place, depth + 1) : std::nullopt;
  }
  ListItem result{ListItem::Kind::other, expression.begin, expression.end, 0, {}};
  if (type == "BOOL") return bool_of(result, 0) ? std::optional(result) : std::nullopt;
  if (type == "NUM") {
    const auto number = constant_in(expression, place, depth + 1);
    result.kind = ListItem::Kind::number;
    result.value = number.value_or(0);
    return number ? std::optional(result) : std::nullopt;
  }
  TextCursor cursor(text_, expression.begin, expression.end);
  return cursor.next() == 0 ? std::nullopt : named_component(cursor, type, path, place, depth);
}

// q, q.trans: of a datum of another name, or of the same one before the place.
std::optional<ListItem> RapidData::named_component(TextCursor& cursor, const std::string& type,
                                                   const RapidPath& path, size_t place, int depth) {
  const size_t at = cursor.at();
  Datum* const datum = find(cursor.take_name(), at);
  auto whole = take_path(cursor);
  if (!datum || !whole || !cursor.done() || datum->is_lost || datum->is_parameter ||
      datum->is_of_others || datum->text != 0 || type_in(datum->type, *whole) != type)
    return std::nullopt;
  datum->is_taken = true;
  whole->insert(whole->end(), path.begin(), path.end());
  return component_at(*datum, *whole, type_in(type, path), place, depth + 1);
}

// p.trans.z in a sum.
std::optional<double> RapidData::number_of_component(Datum& datum, TextCursor& cursor, size_t place,
                                                     int depth) {
  const auto path = take_path(cursor);
  if (!path || datum.is_lost || datum.is_parameter || datum.is_of_others || datum.text != 0 ||
      type_in(datum.type, *path) != "NUM")
    return std::nullopt;
  const auto item = component_at(datum, *path, "NUM", place, depth + 1);
  return item ? std::optional(item->value) : std::nullopt;
}

// A point that assignments give its numbers: written out in the move.
int RapidData::add_assigned_point(Datum& datum, const Statement& argument, int line) {
  const auto record = record_at(datum, argument.begin);
  if (!record) return -1;
  ProgramPoint point;
  point.name = name_of(argument);
  point.line = line;
  point.begin = argument.begin;
  point.end = argument.end;
  point.is_expression = true;
  const auto add = [&](std::vector<ProgramNumber>& numbers, const ListItem& from) {
    for (const ListItem& item : from.items)
      numbers.push_back({0, argument.end, argument.end, item.value, ""});
  };
  const std::vector<ListItem>& parts = record->items;
  if (!is_rapid_quaternion(parts[1])) return -1;
  add(point.numbers, parts[0]);
  add(point.numbers, parts[1]);
  add(point.configuration, parts[2]);
  for (const ListItem& axis : parts[3].items)
    point.behind += (point.behind.empty() ? ",[" : ",") + fmt::format("{:.9G}", axis.value);
  point.behind += "]]";
  program_.points.push_back(point);
  const int index = static_cast<int>(program_.points.size()) - 1;
  external_[index] = *parts[3].numbers(6);
  return index;
}

}  // namespace armtrue
