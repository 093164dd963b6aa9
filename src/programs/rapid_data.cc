#include "programs/rapid_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "programs/frame_list.h"
#include "programs/program_values.h"
#include "programs/rapid_values.h"

namespace armtrue {
namespace {

bool is_point_type(const std::string& type) { return type == "ROBTARGET" || type == "JOINTTARGET"; }
bool is_frame_type(const std::string& type) { return type == "WOBJDATA" || type == "TOOLDATA"; }

// Behind the indices of an array, {2} or {3,2}.
void skip_indices(TextCursor& cursor) {
  cursor.skip_to("}");
  cursor.take('}');
}

}  // namespace

void RapidData::read(const std::vector<Statement>& statements) {
  int scope = 0;
  for (const Statement& statement : statements)
    each_rapid_word(text_, statement, [&](const std::string& word, size_t at, TextCursor& cursor) {
      if (begins_rapid_routine(word)) {
        scopes_.open(at);
        scope = scopes_.at(at);
        declare_parameters(cursor, scope);
      } else if (ends_rapid_routine(word)) {
        scopes_.close(at);
        scope = scopes_.at(at);
      } else if (word == "CONST" || word == "PERS" || word == "VAR") {
        declare(word, statement, cursor, scope);
        return true;
      }
      return false;
    });
  for (const Statement& statement : statements) read_uses(statement);
  forget_changed_frames(statements);
}

// type NAME := [..]  or  type NAME{3} := [[..],[..],[..]]
void RapidData::declare(const std::string& kind, const Statement& statement, TextCursor cursor,
                        int scope) {
  const std::string type = cursor.take_name(), name = cursor.take_name();
  if (name.empty()) return;
  if (cursor.take('{')) skip_indices(cursor);
  Datum& datum = names_.declare(name, scope);
  datum.type = type;
  datum.is_constant = kind == "CONST";
  datum.line = line_at(program_.texts[0].text, statement, cursor.at());
  if (!cursor.take(':') || !cursor.take('=')) return;
  ++datum.values;
  const ListItem list = take_item(cursor);
  if (list.kind == ListItem::Kind::list && cursor.done()) datum.list = list;
}

// NAME(num n, PERS robtarget point \switch fast | wobjdata WObj, VAR num list{*})
void RapidData::declare_parameters(TextCursor cursor, int scope) {
  std::string routine;
  for (std::string word = cursor.take_name(); !word.empty(); word = cursor.take_name())
    routine = word;
  if (!cursor.take('(')) return;
  const size_t begin = cursor.at();
  cursor.skip_to(")");
  for (const Statement& part : split_arguments(text_, begin, cursor.at(), ",|\\")) {
    TextCursor words(text_, part.begin, part.end);
    std::string type, name;
    for (std::string word = words.take_name(); !word.empty(); word = words.take_name())
      type = std::exchange(name, word);
    if (name.empty()) continue;
    Datum& datum = names_.declare(name, scope);
    datum.type = type;
    datum.is_parameter = true;
    datum.routine = routine;
  }
}

// Tools and work objects that are handed to a routine that gives its parameter a value.
void RapidData::forget_changed_frames(const std::vector<Statement>& statements) {
  std::set<std::string> changing;
  names_.each([&](const Datum& datum) {
    if (datum.is_parameter && datum.values > 0 && is_frame_type(datum.type))
      changing.insert(datum.routine);
  });
  for (const Statement& statement : statements) {
    bool is_called = false;
    each_rapid_word(text_, statement, [&](const std::string& word, size_t at, const TextCursor&) {
      if (Datum* const datum = find(word, at); is_called && datum && is_frame_type(datum->type))
        datum->values += 2;
      is_called |= changing.contains(word);
      return false;
    });
  }
}

// Assignments, and the points that other statements than moves use. What is no constant may be
// changed where it is handed to a routine.
void RapidData::read_uses(const Statement& statement) {
  bool is_assignment = false, is_move = false;
  each_rapid_word(text_, statement, [&](const std::string& word, size_t at, TextCursor& cursor) {
    const bool is_declaration = word == "CONST" || word == "PERS" || word == "VAR";
    for (int i = 0; is_declaration && i < 2; ++i) cursor.take_name();
    is_assignment |= is_declaration || word == "RETURN";
    if (is_declaration) return false;
    const bool is_instruction = cursor.next() != '(' && cursor.next() != ':';
    if (is_instruction && find_rapid_move(word)) return true;
    if (is_instruction && is_other_rapid_move(word)) is_move = true;
    if (note_assignment(word, at, cursor)) {
      is_assignment = true;
      return false;
    }
    Datum* const datum = find(word, at);
    if (!datum || !is_point_type(datum->type) || cursor.next() == ':') return false;
    datum->is_shared = true;
    if (cursor.next() == '.') return false;
    if (!is_assignment && !datum->is_constant) datum->values += 2;
    if (!is_move) uses_.push_back({line_at(program_.texts[0].text, statement, at), word, datum});
    return false;
  });
}

// NAME := .., NAME.trans.x := .., NAME{2} := ..
bool RapidData::note_assignment(const std::string& word, size_t at, TextCursor cursor) {
  while (true) {
    if (cursor.take('.'))
      cursor.take_name();
    else if (cursor.take('{'))
      skip_indices(cursor);
    else
      break;
  }
  if (!cursor.take(':') || !cursor.take('=')) return false;
  Datum* const datum = find(word, at);
  ++(datum ? *datum : names_.declare(word, 0)).values;
  return true;
}

int RapidData::point_at(const Statement& argument, TargetKind kind, int line,
                        std::string& why_not) {
  const auto refuse = [&](const char* reason) {
    why_not = reason;
    return -1;
  };
  const auto added = [&](int point, const ListItem& list) {
    if (point >= 0) return point;
    const bool is_turned_wrong = kind == TargetKind::cartesian && list.items.size() == 4 &&
                                 list.items[1].numbers(4) && !is_rapid_quaternion(list.items[1]);
    return refuse(is_turned_wrong ? "the length of its quaternion is not 1"
                                  : "its point has no plain numbers");
  };
  if (const auto list = list_in(text_, argument.begin, argument.end))
    return added(add_point(*list, kind, fmt::format("the point of line {}", line), line), *list);
  TextCursor cursor(text_, argument.begin, argument.end);
  Datum* const datum = find(cursor.take_name(), argument.begin);
  size_t element = 0;
  if (cursor.take('{')) {
    const auto index = cursor.take_number();
    if (!index || !cursor.take('}'))
      return refuse("its point is an element of an array, whose index is no plain number");
    const bool is_there =
        datum && *index >= 1 && *index <= static_cast<double>(datum->list.items.size());
    element = is_there ? static_cast<size_t>(*index) : SIZE_MAX;
  }
  if (!cursor.done())
    return refuse("its target is an expression; it starts from points as they are declared");
  if (datum && datum->is_parameter) return refuse("its point is a parameter of the routine");
  if (!datum || element == SIZE_MAX)
    return refuse("its point is not declared here; give it plain numbers in this module");
  if (datum->values != 1)
    return refuse("its point is given several values, or changed at run time");
  if (datum->type != (kind == TargetKind::joints ? "JOINTTARGET" : "ROBTARGET"))
    return refuse("its point is of another type");
  const auto known = datum->points.find(element);
  if (known != datum->points.end()) return known->second;
  std::string name;
  for (size_t i = argument.begin; i < argument.end; ++i)
    if (!is_blank(text_[i])) name += text_[i];
  const ListItem& list = element == 0 ? datum->list : datum->list.items[element - 1];
  const int point = add_point(list, kind, name, datum->line);
  if (point >= 0) datum->points[element] = point;
  return added(point, list);
}

int RapidData::add_point(const ListItem& list, TargetKind kind, const std::string& name, int line) {
  ProgramPoint point;
  point.name = name;
  point.line = line;
  point.begin = list.begin;
  point.end = list.end;
  point.kind = kind;
  const auto add = [](std::vector<ProgramNumber>& numbers, const ListItem& from) {
    for (const ListItem& item : from.items)
      numbers.push_back({0, item.begin, item.end, item.value, ""});
  };
  const std::vector<ListItem>& parts = list.items;
  if (kind == TargetKind::joints) {
    if (parts.size() != 2 || !parts[0].numbers(6)) return -1;
    add(point.numbers, parts[0]);
    constexpr double kNoAxis = 1e8;  // 9E9
    for (const ProgramNumber& number : point.numbers)
      if (!(std::abs(number.value) < kNoAxis)) return -1;
  } else {
    if (parts.size() != 4 || !parts[0].numbers(3) || !parts[2].numbers(4)) return -1;
    if (!is_rapid_quaternion(parts[1])) return -1;
    add(point.numbers, parts[0]);
    add(point.numbers, parts[1]);
    add(point.configuration, parts[2]);
  }
  program_.points.push_back(point);
  const int index = static_cast<int>(program_.points.size()) - 1;
  if (const auto values = parts.back().numbers(6)) external_[index] = *values;
  return index;
}

void RapidData::leave(const Statement& argument) {
  TextCursor cursor(text_, argument.begin, argument.end);
  Datum* const datum = find(cursor.take_name(), argument.begin);
  if (cursor.take('{')) skip_indices(cursor);
  if (datum && cursor.done()) datum->is_shared = true;
}

std::vector<std::pair<int, std::string>> RapidData::finish() {
  names_.each([&](const Datum& datum) {
    for (const auto& [element, point] : datum.points)
      program_.points[static_cast<size_t>(point)].is_shared = datum.is_shared;
  });
  std::vector<std::pair<int, std::string>> others;
  for (const Use& use : uses_) {
    const bool is_known =
        std::ranges::find(others, use.name, &std::pair<int, std::string>::second) != others.end();
    if (!is_known && use.datum->points.empty() && use.datum->list.kind == ListItem::Kind::list)
      others.emplace_back(use.line, use.name);
  }
  return others;
}

// The list of a tool or work object; null if this text does not say it. A routine may be called
// with several.
const ListItem* RapidData::value_of(const Statement& argument, const char* type, TargetKind kind,
                                    std::string& why_not) {
  int scope = 0;
  const Datum* const datum =
      names_.find(scopes_, name_of(argument), scopes_.at(argument.begin), &scope);
  if (scope > 0) why_not = why_not_of_routine(kind);
  const bool is_certain = datum && datum->values == 1 && datum->type == type &&
                          datum->list.kind == ListItem::Kind::list;
  return is_certain && scope == 0 ? &datum->list : nullptr;
}

int RapidData::room_frame() { return add_frame(program_.frames, known_, "WOBJ0", Pose{}); }

// [robhold, ufprog, "ufmec", uframe, oframe]
int RapidData::work_object_at(const Statement& argument, TargetKind kind, std::string& why_not) {
  const std::string name = name_of(argument);
  std::optional<Pose> pose;
  if (name == "WOBJ0") pose = Pose{};
  const ListItem* const list = value_of(argument, "WOBJDATA", kind, why_not);
  if (!why_not.empty()) return -1;
  if (list && list->items.size() == 5) {
    const std::vector<ListItem>& parts = list->items;
    const auto user = rapid_pose(parts[3]), object = rapid_pose(parts[4]);
    if (user && object) pose = *user * *object;
    if (is_word(parts[0], "TRUE")) why_not = "the robot holds the work object";
    if (is_word(parts[1], "FALSE")) why_not = "a mechanical unit moves the work object";
  }
  return add_frame(program_.frames, known_, name, pose);
}

// [robhold, tframe, tload]
int RapidData::tool_at(const Statement& argument, TargetKind kind, std::string& why_not) {
  const std::string name = name_of(argument);
  std::optional<Pose> pose;
  if (name == "TOOL0") pose = Pose{};
  const ListItem* const list = value_of(argument, "TOOLDATA", kind, why_not);
  if (!why_not.empty()) return -1;
  if (list && list->items.size() == 3) {
    pose = rapid_pose(list->items[1]);
    if (is_word(list->items[0], "FALSE")) why_not = "its tool stands in the room";
  }
  return add_frame(program_.frames, known_, name, pose);
}

}  // namespace armtrue
