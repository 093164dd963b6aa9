#include "programs/abb/rapid_data.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>

#include "armtrue/kinematics/units.h"
#include "programs/abb/rapid_values.h"
#include "programs/arithmetic.h"
#include "programs/dialects.h"
#include "programs/frame_list.h"
#include "programs/point_numbers.h"

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
  int scope = 0, loops = 0;  // that are open
  for (const Statement& statement : statements)
    each_rapid_word(text_, statement, [&](const std::string& word, size_t at, TextCursor& cursor) {
      if (begins_rapid_routine(word)) {
        scopes_.open(at);
        scope = scopes_.at(at);
        declare_parameters(word, cursor, scope);
      } else if (word == "FOR") {
        ++loops;
        scopes_.open(at);
        scope = scopes_.at(at);
        names_.declare(cursor.take_name(), scope).is_parameter = true;  // with a value of its own
      } else if (word == "ENDFOR" && loops > 0) {
        --loops;
        scopes_.close(at);
        scope = scopes_.at(at);
      } else if (ends_rapid_routine(word)) {
        for (; loops >= 0; --loops) scopes_.close(at);
        loops = 0;
        scope = scopes_.at(at);
      } else if (is_rapid_declaration(word)) {
        declare(word, statement, cursor, scope);
        return true;
      }
      return false;
    });
  read_others(statements);
  for (const Statement& statement : statements) read_uses(statement);
}

// The modules of a task share the data that they declare outside of routines, but for LOCAL ones.
void RapidData::read_others(const std::vector<Statement>& own) {
  routines_.read(text_, own);
  std::vector<std::pair<std::string, std::vector<Statement>>> modules;
  for (size_t i = program_.own_texts; i < program_.texts.size(); ++i) {
    std::string text = masked(program_.texts[i].text, '!', "\"");
    std::vector<Statement> statements = split_statements(text, ';');
    bool is_in_routine = false;
    for (const Statement& statement : statements) {
      std::string before;
      each_rapid_word(text, statement, [&](const std::string& word, size_t, TextCursor& cursor) {
        is_in_routine = (is_in_routine || begins_rapid_routine(word)) && !ends_rapid_routine(word);
        const bool is_local = std::exchange(before, word) == "LOCAL";
        if (!is_rapid_declaration(word)) return false;
        if (is_in_routine || is_local) return true;
        const std::string type = cursor.take_name(), name = cursor.take_name();
        if (name.empty()) return true;
        if (cursor.take('{')) skip_indices(cursor);
        Datum& datum = of_others_[name];
        datum.is_of_others = true;
        datum.text = static_cast<int>(i);
        datum.line = line_at(program_.texts[i].text, statement, cursor.at());
        take_value(word, type, cursor, datum);
        return true;
      });
    }
    routines_.read(text, statements);
    modules.emplace_back(std::move(text), std::move(statements));
  }
  routines_.follow_calls();
  for (const auto& [text, statements] : modules) note_uses_of_others(text, statements);
}

// What another module does with global data: it may change them, or use points.
void RapidData::note_uses_of_others(const std::string& text,
                                    const std::vector<Statement>& statements) {
  std::set<std::string> own;  // names that mean something else there
  bool is_in_routine = false;
  for (const Statement& statement : statements)
    each_rapid_word(text, statement, [&](const std::string& word, size_t, TextCursor cursor) {
      is_in_routine = (is_in_routine || begins_rapid_routine(word)) && !ends_rapid_routine(word);
      if (!is_rapid_declaration(word) || is_in_routine) return false;
      cursor.take_name();
      const std::string name = cursor.take_name();
      if (find_of_others(name) == nullptr || names_.find(scopes_, name, 0)) own.insert(name);
      return false;
    });
  each_rapid_use(
      text, statements,
      [&](const Statement& statement, const std::string& word, size_t at, TextCursor cursor) {
        if (own.contains(word)) return;
        Datum* datum = names_.find(scopes_, word, 0);
        if (!datum) datum = find_of_others(word);
        if (!datum) return;
        datum->is_of_others = true;
        if (TextCursor ahead = cursor; !takes_rapid_assignment(ahead)) {
          note_handed(text, statement, at, cursor, *datum);
        } else if (!names_rapid_parameter(text, statement, at)) {
          ++datum->values;
          datum->is_lost = true;
          note_set_part(text, word, cursor, *datum);
        }
      });
}

// A datum that a statement hands to what may change it. Of a tool or work object no value is stated
// that holds behind that, if it is a component: then --frame is no remedy.
void RapidData::note_handed(std::string_view text, const Statement& statement, size_t at,
                            TextCursor behind, Datum& datum) const {
  const std::string receiver = rapid_receiver(text, statement, at, behind);
  if (receiver.empty() || datum.is_constant) return;
  if (!routines_.may_change(receiver, rapid_type_of_part(datum.type, behind))) return;
  if (TextCursor part = behind; part.take('.') && part.take_name() == "TLOAD") return;
  datum.values += 2;
  datum.is_lost = true;
  datum.is_set_again |= behind.next() == '.';
}

// type NAME := [..]  or  type NAME{3} := [[..],[..],[..]]
void RapidData::declare(const std::string& kind, const Statement& statement, TextCursor cursor,
                        int scope) {
  const std::string type = cursor.take_name();
  cursor.next();
  const size_t at = cursor.at();
  const std::string name = cursor.take_name();
  if (name.empty()) return;
  const bool is_array = cursor.take('{');
  if (is_array) skip_indices(cursor);
  Datum& datum = names_.declare(name, scope);
  datum.line = line_at(program_.texts[0].text, statement, cursor.at());
  datum.is_lost |= is_array || !datum.type.empty();  // or declared twice
  // A routine gives its own variables their values each time that it begins.
  if (take_value(kind, type, cursor, datum) && kind == "VAR" && scope > 0)
    note_change(datum, at, cursor, statement.end);
}

// Behind the name. Returns whether there is a value.
bool RapidData::take_value(const std::string& kind, const std::string& type, TextCursor cursor,
                           Datum& datum) {
  datum.type = type;
  datum.is_constant = kind == "CONST";
  if (!cursor.take(':') || !cursor.take('=')) return false;
  ++datum.values;
  const ListItem item = take_item(cursor);
  if (item.kind == ListItem::Kind::list && cursor.done()) datum.list = item;
  if (item.kind == ListItem::Kind::number && cursor.done() && datum.is_constant)
    datum.number = item.value;
  return true;
}

// NAME(num n, PERS robtarget point \switch fast | wobjdata WObj, VAR num list{*})
void RapidData::declare_parameters(const std::string& kind, TextCursor cursor, int scope) {
  const std::string routine = take_rapid_routine(kind, cursor);
  const auto [procedure, is_new] = procedures_.try_emplace(routine);
  if (!is_new) procedure->second.clear();  // nobody knows which one is called
  const bool is_followed = is_new && kind == "PROC";
  each_rapid_parameter(text_, cursor, [&](const RapidParameter& parameter) {
    Datum& datum = names_.declare(parameter.name, scope);
    datum.type = parameter.type;
    datum.is_parameter = true;
    datum.routine = routine;
    datum.is_copied = parameter.mode.empty();
    if (!is_followed || parameter.is_optional) return;
    datum.position = procedure->second.size();
    procedure->second.push_back(&datum);
  });
}

std::optional<RoutineParameter> RapidData::parameter_at(const Statement& argument) {
  const Datum* const datum = find(name_of(argument), argument.begin);
  if (!datum || !datum->position || procedures_.at(datum->routine).empty()) return std::nullopt;
  return RoutineParameter{datum->routine, *datum->position};
}

std::vector<RoutineParameter> RapidData::points_handed_to(const std::string& procedure) const {
  std::vector<RoutineParameter> result;
  const auto found = procedures_.find(procedure);
  if (found == procedures_.end()) return result;
  for (const Datum* const datum : found->second)
    if (datum->is_copied && is_point_type(datum->type))
      result.push_back({procedure, *datum->position});
  return result;
}

bool RapidData::only_moves_use(const RoutineParameter& parameter) const {
  const Datum& datum = *procedures_.at(parameter.routine)[parameter.position];
  return datum.is_copied && datum.values == 0 && !datum.is_shared;
}

std::vector<Statement> RapidData::arguments_of_call(TextCursor cursor, size_t end) const {
  std::vector<Statement> arguments;
  for (const Statement& part : split_arguments(text_, cursor.at(), end, ",")) {
    const Statement argument = split_arguments(text_, part.begin, part.end, "\\")[0];
    if (argument.begin == argument.end) continue;
    TextCursor name(text_, argument.begin, argument.end);
    if (!name.take_name().empty() && takes_rapid_assignment(name)) return {};
    arguments.push_back(argument);
  }
  return arguments;
}

// Assignments, and the points that other statements than moves use. A routine may change what is
// handed to it, unless that is a constant or the routine gets a copy.
void RapidData::read_uses(const Statement& statement) {
  bool is_assignment = false, is_move = false, is_followed = false;
  std::vector<Statement> copied;  // what a procedure gets a copy of
  each_rapid_word(text_, statement, [&](const std::string& word, size_t at, TextCursor& cursor) {
    const bool is_declaration = is_rapid_declaration(word);
    for (int i = 0; is_declaration && i < 2; ++i) cursor.take_name();
    is_assignment |= is_declaration || word == "RETURN";
    if (is_declaration) return false;
    const bool is_instruction = cursor.next() != '(' && cursor.next() != ':';
    if (is_instruction && find_rapid_move(word)) return true;
    if (is_instruction && is_other_rapid_move(word, cursor)) is_move = true;
    is_followed |= routines_.contains(word);
    for (const RoutineParameter& parameter : points_handed_to(word))
      if (const auto arguments = arguments_of_call(cursor, statement.end);
          is_instruction && parameter.position < arguments.size() &&
          is_point_text(arguments[parameter.position]))
        copied.push_back(arguments[parameter.position]);
    if (note_assignment(statement, word, at, cursor)) {
      is_assignment = true;
      return false;
    }
    Datum* const datum = find(word, at);
    if (!datum || cursor.next() == ':') return false;
    const auto is_here = [&](const Statement& part) { return part.begin <= at && at < part.end; };
    if (!datum->is_parameter && std::ranges::any_of(copied, is_here)) return false;
    note_handed(text_, statement, at, cursor, *datum);
    if (!is_point_type(datum->type)) return false;
    datum->is_shared = true;
    if (cursor.next() == '.') return false;
    if (!is_move)
      uses_.push_back(
          {{line_at(program_.texts[0].text, statement, at), word, !is_assignment && !is_followed},
           datum});
    return false;
  });
}

bool RapidData::is_displaced(const Statement& argument) const {
  const std::string first = TextCursor(text_, argument.begin, argument.end).take_name();
  return first == "OFFS" || first == "RELTOOL";
}

// A name, or one that is displaced: no other function may change it.
bool RapidData::is_point_text(const Statement& argument) const {
  return is_displaced(argument) || name_of(argument).find('(') == std::string::npos;
}

// NAME := .., NAME.trans.x := .., NAME{2} := ..
bool RapidData::note_assignment(const Statement& statement, const std::string& word, size_t at,
                                TextCursor cursor) {
  const TextCursor behind = cursor;
  if (!takes_rapid_assignment(cursor) || names_rapid_parameter(text_, statement, at)) return false;
  Datum* const known = find(word, at);
  Datum& datum = known ? *known : names_.declare(word, 0);
  ++datum.values;
  note_set_part(text_, word, behind, datum);
  note_change(datum, at, behind, statement.end);
  return true;
}

// `behind`: behind the name that is assigned. The load of a tool moves nothing.
void RapidData::note_set_part(std::string_view text, const std::string& name, TextCursor behind,
                              Datum& datum) {
  if (!datum.type.empty() && !is_frame_type(datum.type)) return;
  const size_t begin = behind.at();
  takes_rapid_assignment(behind);
  std::string part = upper(text.substr(begin, behind.at() - begin));
  std::erase_if(part, [](unsigned char c) { return std::isspace(c) != 0 || c == ':' || c == '='; });
  if (part.starts_with(".TLOAD")) return;
  each_word(text, {0, behind.at(), behind.end()},
            [&](const std::string& word, size_t, const TextCursor&) {
              datum.is_set_again |= word == name;  // t.tframe.trans.z := t.tframe.trans.z + 5
            });
  for (const std::string& other : datum.set_parts)
    datum.is_set_again |= part.starts_with(other) || other.starts_with(part);
  datum.set_parts.push_back(part);
}

int RapidData::point_at(const Statement& argument, TargetKind kind, int line, std::string& why_not,
                        int depth) {
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
    return added(add_point(*list, kind, fmt::format("the point of line {}", line), line, 0), *list);
  TextCursor cursor(text_, argument.begin, argument.end);
  const std::string first = cursor.take_name();
  if ((first == "OFFS" || first == "RELTOOL") && cursor.next() == '(' && kind != TargetKind::joints)
    return displaced_point(first, argument, kind, line, why_not, depth);
  Datum* const datum = find(first, argument.begin);
  const auto element = take_element(cursor);
  if (!element)
    return refuse("its point is an element of an array, whose index is no plain number");
  if (!cursor.done())
    return refuse("its target is an expression; it starts from points as they are declared");
  if (datum && datum->is_parameter) return refuse("its point is a parameter of the routine");
  const bool is_assigned = datum && !datum->changes.empty() &&
                           (datum->values != 1 || datum->list.kind != ListItem::Kind::list);
  if (is_assigned && kind == TargetKind::cartesian && element->empty() &&
      datum->type == "ROBTARGET")
    if (const int point = add_assigned_point(*datum, argument, line); point >= 0) return point;
  const ListItem* const list = datum ? list_of(*datum, *element) : nullptr;
  if (!list)
    return refuse(
        "its point is not declared here; give the module that declares it, or a folder "
        "with it: --with");
  if (datum->values != 1)
    return refuse("its point is given several values, or changed at run time");
  if (datum->type != (kind == TargetKind::joints ? "JOINTTARGET" : "ROBTARGET"))
    return refuse("its point is of another type");
  const auto known = datum->points.find(*element);
  if (known != datum->points.end()) return known->second;
  std::string name;
  for (size_t i = argument.begin; i < argument.end; ++i)
    if (!is_blank(text_[i])) name += text_[i];
  const int point = add_point(*list, kind, name, datum->line, datum->text);
  if (point >= 0) datum->points[*element] = point;
  return added(point, *list);
}

// {2}, {1,n}, or none. Nothing if an index is not certain.
std::optional<RapidData::Element> RapidData::take_element(TextCursor& cursor) {
  Element element;
  if (!cursor.take('{')) return element;
  const size_t begin = cursor.at();
  cursor.skip_to("}");
  for (const Statement& part : split_arguments(text_, begin, cursor.at(), ",")) {
    const auto index = constant_in(part);
    if (!index || *index < 1 || *index != std::floor(*index)) return std::nullopt;
    element.push_back(static_cast<size_t>(*index));
  }
  return cursor.take('}') ? std::optional(element) : std::nullopt;
}

// Null if the array has no such element.
const ListItem* RapidData::list_of(const Datum& datum, const Element& element) {
  const ListItem* list = &datum.list;
  for (const size_t index : element) {
    if (list->kind != ListItem::Kind::list || index > list->items.size()) return nullptr;
    list = &list->items[index - 1];
  }
  return list;
}

// Offs(p10,0,0,100), RelTool(p10,0,0,100\Rx:=..\Ry:=..\Rz:=..). Numbers, or constants.
std::optional<RapidData::Displacement> RapidData::displacement_of(const std::string& function,
                                                                  const Statement& argument) {
  TextCursor last(text_, argument.end - 1, argument.end);
  if (!last.take(')')) return std::nullopt;
  const size_t open = text_.find('(', argument.begin);
  const std::vector<Statement> parts = split_arguments(text_, open + 1, argument.end - 1, ",");
  constexpr size_t kParts = 4;
  if (parts.size() != kParts) return std::nullopt;
  Displacement result;
  for (size_t i = 0; i < kParts; ++i) {
    const std::vector<Statement> pieces =
        split_arguments(text_, parts[i].begin, parts[i].end, "\\");
    for (size_t k = 1; k < pieces.size(); ++k) {
      TextCursor cursor(text_, pieces[k].begin, pieces[k].end);
      const std::string name = cursor.take_name();
      const bool is_turn = name.size() == 2 && name[0] == 'R' && name[1] >= 'X' && name[1] <= 'Z';
      if (!is_turn || function != "RELTOOL" || !cursor.take(':') || !cursor.take('='))
        return std::nullopt;
      cursor.next();
      const auto angle = constant_in({0, cursor.at(), pieces[k].end});
      if (!angle) return std::nullopt;
      result.turn[name[1] - 'X'] = *angle * kDegree;
    }
    if (i == 0) {
      result.point = pieces[0];
      continue;
    }
    const auto length = constant_in(pieces[0]);
    if (!length) return std::nullopt;
    result.shift[i - 1] = *length * kMillimetre;
  }
  return result;
}

// Offs moves along the axes of the work object; RelTool along those of the tool, and turns about x,
// then the new y, then the new z (RAPID reference manual).
int RapidData::displaced_point(const std::string& function, const Statement& argument,
                               TargetKind kind, int line, std::string& why_not, int depth) {
  constexpr int kMostDepth = 16;  // displacements in one another
  const auto displacement = depth < kMostDepth ? displacement_of(function, argument) : std::nullopt;
  if (!displacement) {
    why_not = "its target is an expression; it starts from points as they are declared";
    return -1;
  }
  const auto& [declared, shift, turn] = *displacement;
  const int from = point_at(declared, kind, line, why_not, depth + 1);
  if (from < 0) return -1;
  ProgramPoint point = program_.points[from];
  const auto stated_external = external_.find(from);
  std::optional<std::vector<double>> external;
  if (stated_external != external_.end()) external = stated_external->second;
  const bool is_nested = point.is_expression;  // Offs(Offs(..),..): no move goes to the inner one
  if (is_nested) {
    external_.erase(from);
    program_.points.pop_back();
  }
  std::vector<double> numbers = values_of(point.numbers);
  Pose pose = rapid_dialect().pose_of_numbers(numbers);
  using Eigen::AngleAxisd;
  if (function == "OFFS")
    pose.translation += shift;
  else
    pose = pose * Pose{(AngleAxisd(turn[0], Eigen::Vector3d::UnitX()) *
                        AngleAxisd(turn[1], Eigen::Vector3d::UnitY()) *
                        AngleAxisd(turn[2], Eigen::Vector3d::UnitZ()))
                           .toRotationMatrix(),
                       shift};
  numbers = rapid_dialect().numbers_of_pose(pose, numbers);
  for (size_t i = 0; i < numbers.size(); ++i)
    point.numbers[i] = {0, argument.end, argument.end, numbers[i], ""};
  point.name = text_.substr(argument.begin, argument.end - argument.begin);
  point.line = line;
  point.text = 0;
  point.begin = argument.begin;
  point.end = argument.end;
  point.is_expression = true;
  if (!is_nested) point.starts_from = from;
  program_.points.push_back(point);
  const int index = static_cast<int>(program_.points.size()) - 1;
  if (external) external_[index] = *external;
  return index;
}

// A number: sums and products of numbers and constants, in brackets or not.
std::optional<double> RapidData::constant_in(const Statement& argument, std::optional<size_t> place,
                                             int depth) {
  TextCursor cursor(text_, argument.begin, argument.end);
  const auto value = take_sum(cursor, [&](TextCursor& rest) -> std::optional<double> {
    const size_t at = rest.at();
    Datum* const datum = find(rest.take_name(), at);
    if (datum && place && rest.next() == '.')
      return number_of_component(*datum, rest, *place, depth);
    if (!datum || datum->is_parameter || datum->values != 1) return std::nullopt;
    return datum->number;
  });
  return cursor.done() ? value : std::nullopt;
}

int RapidData::add_point(const ListItem& list, TargetKind kind, const std::string& name, int line,
                         int text) {
  ProgramPoint point;
  point.text = text;
  point.name = name;
  point.line = line;
  point.begin = list.begin;
  point.end = list.end;
  point.kind = kind;
  const auto add = [&](std::vector<ProgramNumber>& numbers, const ListItem& from) {
    for (const ListItem& item : from.items)
      numbers.push_back({text, item.begin, item.end, item.value, ""});
  };
  const std::vector<ListItem>& parts = list.items;
  if (kind == TargetKind::joints) {
    if (parts.size() != 2 || !parts[0].numbers(6)) return -1;
    add(point.numbers, parts[0]);
    for (const ProgramNumber& number : point.numbers)
      if (!is_rapid_axis(number.value)) return -1;
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

void RapidData::leave(const Statement& argument, const ProgramTarget* in_frames) {
  if (in_frames && is_displaced(argument))
    offsets_.push_back({argument, {in_frames->base, in_frames->tool}});
  else
    keep(argument);
}

// What corrects a point in one frame would displace its offsets in another one the wrong way.
void RapidData::keep_starts_in_other_frames() {
  std::map<int, std::set<FramesOfMove>> frames;  // of points
  for (const ProgramTarget& target : program_.targets)
    frames[target.point].insert({target.base, target.tool});
  for (const Offset& offset : offsets_)
    each_word(text_, offset.argument, [&](const std::string& word, size_t at, const TextCursor&) {
      Datum* const datum = find(word, at);
      if (!datum) return;
      for (const auto& [element, point] : datum->points)
        datum->is_shared |= !frames[point].empty() && frames[point] != std::set{offset.frames};
    });
}

void RapidData::keep(const Statement& argument) {
  each_word(text_, argument, [&](const std::string& word, size_t at, const TextCursor&) {
    if (Datum* const datum = find(word, at)) datum->is_shared = true;
  });
}

std::vector<RapidData::Use> RapidData::finish() {
  keep_starts_in_other_frames();
  const auto mark = [&](const Datum& datum, int point) {
    program_.points[point].is_shared = datum.is_shared;
    program_.points[point].is_of_others = datum.is_of_others;
  };
  names_.each([&](const Datum& datum) {
    for (const auto& [element, point] : datum.points) mark(datum, point);
  });
  for (const auto& [name, datum] : of_others_)
    for (const auto& [element, point] : datum.points) mark(datum, point);
  std::vector<Use> others;
  for (const auto& [use, datum] : uses_) {
    if (!datum->points.empty() || datum->is_taken || datum->list.kind != ListItem::Kind::list)
      continue;
    const auto known = std::ranges::find(others, use.name, &Use::name);
    if (known == others.end())
      others.push_back(use);
    else
      known->may_move |= use.may_move;
  }
  return others;
}

// Of a tool or work object; null if this text does not state it. Calls of a routine may hand on
// several.
RapidData::FrameList RapidData::value_of(const Statement& argument, const char* type,
                                         TargetKind kind, std::string& why_not) {
  TextCursor cursor(text_, argument.begin, argument.end);
  const std::string name = cursor.take_name();
  int scope = 0;
  Datum* datum = names_.find(scopes_, name, scopes_.at(argument.begin), &scope);
  if (!datum) datum = find_of_others(name);
  if (scope > 0) why_not = why_not_of_routine(kind);
  const bool is_given = is_given_frame(known_, name);
  const bool is_assigned = datum && scope == 0 && !datum->changes.empty() && datum->type == type &&
                           !datum->is_lost && !datum->is_of_others && datum->text == 0 &&
                           cursor.done();
  if (is_assigned && needs_frame(kind) && (!is_given || datum->is_set_again))
    return assigned_frame(*datum, name, argument.begin, why_not);
  // --frame states one value.
  if (datum && datum->is_set_again && needs_frame(kind))
    why_not = "its tool or work object is given several values, or changed at run time";
  const auto element = take_element(cursor);
  if (!element && needs_frame(kind))
    why_not = "its tool or work object is an element of an array, whose index is no plain number";
  const bool is_certain = datum && element && cursor.done() && datum->values == 1 &&
                          datum->type == type && datum->list.kind == ListItem::Kind::list;
  const ListItem* const list = is_certain && scope == 0 ? list_of(*datum, *element) : nullptr;
  if (!list) return {};
  return {*list, datum->text, ""};
}

// As its assignments make it at a place. --frame states one value: no remedy where it has several.
RapidData::FrameList RapidData::assigned_frame(Datum& datum, const std::string& name, size_t place,
                                               std::string& why_not) {
  std::vector<std::string> lines;
  for (const Datum::Change& change : datum.changes)
    if (const std::string line = fmt::format("{}", line_at(program_.texts[0].text, change.at));
        std::ranges::find(lines, line) == lines.end())
      lines.push_back(line);
  const std::string all = fmt::format("{}", fmt::join(lines, ", "));
  if (const auto list = record_at(datum, place)) return {list, 0, name + " of line " + all};
  why_not = fmt::format("its tool or work object {} is changed in line{} {}", name,
                        lines.size() > 1 ? "s" : "", all);
  if (!datum.is_set_again)
    why_not += "; if it is always the same, say where it is: --frame " + name + "=..";
  return {};
}

// Another pose with the same name gets another one.
int RapidData::add_frame_named(std::string name, const std::optional<Pose>& pose) {
  for (;; name += "'") {
    const int index = add_frame(program_.frames, known_, name, pose);
    const ProgramFrame& frame = program_.frames[index];
    const bool is_it =
        !pose || !frame.is_known ||
        (frame.pose.translation == pose->translation && frame.pose.rotation == pose->rotation);
    if (is_it) return index;
  }
}

// Of a frame with a name. The controller refuses a quaternion of another length.
std::optional<Pose> RapidData::pose_of(const ListItem& list, const std::string& name,
                                       TargetKind kind, std::string& why_not) const {
  const auto pose = rapid_pose(list);
  if (!pose && needs_frame(kind) && !is_given_frame(known_, name))
    why_not = list.items.size() == 2 && list.items[0].numbers(3) && list.items[1].numbers(4)
                  ? "the length of the quaternion of its tool or work object is not 1"
                  : "its tool or work object has no plain numbers; say where it is: --frame " +
                        name + "=..";
  return pose;
}

// [finep, pzone_tcp, pzone_ori, ..]
double RapidData::radius_of_zone(const Statement& argument) {
  const Datum* const datum = find(name_of(argument), argument.begin);
  const bool is_certain = datum && datum->values == 1 && datum->type == "ZONEDATA";
  std::optional<ListItem> zone = list_in(text_, argument.begin, argument.end);
  if (is_certain) zone = datum->list;
  if (!zone) return datum ? 0 : radius_of_rapid_zone(name_of(argument));
  const std::vector<ListItem>& parts = zone->items;
  const bool is_passed =
      parts.size() == 7 && bool_of(parts[0], is_certain ? datum->text : 0) == false;
  return is_passed && parts[1].kind == ListItem::Kind::number ? parts[1].value * kMillimetre : 0;
}

RapidData::Frame RapidData::room_frame() {
  return {add_frame(program_.frames, known_, "WOBJ0", Pose{}), false};
}

// [robhold, ufprog, "ufmec", uframe, oframe]
RapidData::Frame RapidData::work_object_at(const Statement& argument, TargetKind kind,
                                           std::string& why_not) {
  const std::string name = name_of(argument);
  if (name == "WOBJ0") return room_frame();
  Frame frame;
  std::optional<Pose> pose;
  const FrameList found = value_of(argument, "WOBJDATA", kind, why_not);
  if (!why_not.empty()) return frame;
  if (found.list && found.list->items.size() == 5) {
    const std::vector<ListItem>& parts = found.list->items;
    const auto user = pose_of(parts[3], name, kind, why_not),
               object = pose_of(parts[4], name, kind, why_not);
    if (user && object) pose = *user * *object;
    frame.is_held = bool_of(parts[0], found.text);
    if (bool_of(parts[1], found.text) == false) why_not = "a mechanical unit moves the work object";
  }
  frame.index = found.name.empty() ? add_frame(program_.frames, known_, name, pose)
                                   : add_frame_named(found.name, pose);
  return frame;
}

// [robhold, tframe, tload]
RapidData::Frame RapidData::tool_at(const Statement& argument, TargetKind kind,
                                    std::string& why_not) {
  const std::string name = name_of(argument);
  Frame frame;
  std::optional<Pose> pose;
  if (name == "TOOL0") pose = Pose{};
  const FrameList found = value_of(argument, "TOOLDATA", kind, why_not);
  if (!why_not.empty()) return frame;
  if (found.list && found.list->items.size() == 3) {
    pose = pose_of(found.list->items[1], name, kind, why_not);
    frame.is_held = bool_of(found.list->items[0], found.text);
  }
  frame.index = found.name.empty() ? add_frame(program_.frames, known_, name, pose)
                                   : add_frame_named(found.name, pose);
  return frame;
}

}  // namespace armtrue
