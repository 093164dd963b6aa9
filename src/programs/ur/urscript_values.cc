#include "programs/ur/urscript_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "armtrue/kinematics/units.h"
#include "programs/arithmetic.h"
#include "programs/dialects.h"
#include "programs/frame_list.h"

namespace armtrue {
namespace {

constexpr int kDeepest = 4;         // calls and names in one another
constexpr int kDeepestNumber = 32;  // numbers that names stand for, in one another
constexpr int kMostElements = 64;   // given a value one after the other
constexpr int kShifted = -2;        // a target that is in no frame, and not where its point is

}  // namespace

void UrValues::read(const std::vector<Statement>& statements, const UrStructure& structure) {
  scopes_ = structure.scopes;
  flow_ = structure.flow;
  for (const UrParameter& parameter : structure.parameters) {
    Variable& variable = variables_.declare(parameter.name, parameter.scope);
    variable.parameter = parameter.parameter;
    parameters_[parameter.parameter.routine].push_back(&variable);
    moves_.insert(parameter.at);
  }
  for (const Statement& statement : statements) read_assignments(statement);
  read_returns(statements);
}

// def T(q): / return pose_trans(base, q) / end
void UrValues::read_returns(const std::vector<Statement>& statements) {
  for (size_t i = 0; i + 2 < statements.size(); ++i) {
    TextCursor head(text_, statements[i].begin, statements[i].end),
        body(text_, statements[i + 1].begin, statements[i + 1].end),
        tail(text_, statements[i + 2].begin, statements[i + 2].end);
    if (head.take_name() != "DEF") continue;
    const std::string name = head.take_name();
    const auto [known, is_new] = returns_.try_emplace(name);
    known->second.reset();
    if (!is_new || body.take_name() != "RETURN" || tail.take_name() != "END") continue;
    body.next();
    known->second = split_arguments(text_, body.at(), statements[i + 1].end, ";")[0];
    known->second->line = statements[i + 1].line;
  }
}

// Every NAME = VALUE outside of brackets, wherever it stands: `if x: a = 1 end`, `a = 1; b = 2`.
void UrValues::read_assignments(const Statement& statement) {
  TextCursor cursor(text_, statement.begin, statement.end);
  Assigned last;
  char before = ' ';
  int depth = 0;
  for (char c = cursor.next(); !cursor.done(); before = c, c = cursor.next()) {
    const std::string name = take_spelled(cursor);
    if (depth == 0 && !name.empty() && before != '.')
      last = {name, cursor.at(), upper(last.name) == "LOCAL"};
    if (!name.empty()) continue;
    const size_t at = cursor.at();
    cursor.step();
    depth += c == '(' || c == '[' ? 1 : c == ')' || c == ']' ? -1 : 0;
    if (c != '=') continue;
    const bool compares = cursor.take('=') || before == '<' || before == '>' || before == '!';
    if (depth == 0 && !compares && !last.name.empty())
      read_assignment(last, {statement.line, at, statement.end});
  }
}

// Names of the outermost functions are global. In the others, what is neither a parameter nor
// `local` is global, too, if that name is (URScript manual, scoping rules).
void UrValues::read_assignment(const Assigned& to, const Statement& from_equals) {
  TextCursor element(text_, to.end, from_equals.begin);
  const bool is_element = !element.done();
  std::optional<int> index = is_element ? take_index(element) : std::nullopt;
  if (!element.done()) index.reset();
  const int scope = scopes_.at(to.end);
  int declared = 0;
  variables_.find(scopes_, to.name, scope, &declared);
  if (to.is_local && scope > 0 && scopes_.parent(scope) > 0) declared = scope;
  if (declared != scope) declared = 0;
  Variable& variable = variables_.declare(to.name, declared);
  const Statement value = split_arguments(text_, from_equals.begin + 1, from_equals.end, ";")[0];
  variable.is_calculated =
      text_.substr(value.begin, value.end - value.begin).find('(') != std::string::npos;
  variable.assignments.push_back(
      {{from_equals.line, value.begin, value.end}, scope, is_element, index});
}

// [2]
std::optional<int> UrValues::take_index(TextCursor& cursor) const {
  if (!cursor.take('[')) return std::nullopt;
  const auto index = cursor.take_number();
  constexpr double kElements = 6;
  const bool is_one = index && *index >= 0 && *index < kElements && *index == std::floor(*index);
  return cursor.take(']') && is_one ? std::optional(static_cast<int>(*index)) : std::nullopt;
}

const UrValues::Assignment* UrValues::assignment_at(Variable& variable, size_t at) {
  if (variable.assignments.empty()) return nullptr;
  size_t index = 0;
  if (variable.assignments.size() > 1) {
    if (!variable.flow) {
      std::vector<ProgramFlow::Setting> settings;
      for (const Assignment& assignment : variable.assignments)
        settings.push_back({assignment.value.end, static_cast<int>(settings.size())});
      variable.flow = flow_.follow(std::move(settings));
    }
    const int value = variable.flow->at(at);
    if (value == ProgramFlow::kUncertain) return nullptr;
    index = static_cast<size_t>(value);
  }
  const Assignment& assignment = variable.assignments[index];
  return scopes_.contains(assignment.scope, scopes_.at(at)) ? &assignment : nullptr;
}

// NAME=p[..], NAME[2]=0.1, NAME[3]=NAME[3]+0.2: the literal with other numbers.
std::optional<UrValue> UrValues::with_elements(Variable& variable, const Assignment* assignment,
                                               const std::string& name, int depth) {
  std::vector<std::pair<int, double>> given;
  while (assignment && assignment->is_element) {
    if (!assignment->index || variable.assignments.size() == 1 || given.size() == kMostElements)
      return std::nullopt;
    const auto number = number_of(assignment->value);
    if (!number) return std::nullopt;
    given.emplace_back(*assignment->index, *number);
    assignment = assignment_at(variable, assignment->value.begin);
  }
  if (!assignment) return std::nullopt;
  auto value = assigned_value(*assignment, name, depth);
  if (!value || given.empty()) return value;
  if (value->near || value->literal + 1 < value->list.begin) return std::nullopt;
  if (!value->declared) value->declared = value->list;
  if (value->base >= 0 || !value->shift.isZero(0)) {
    const bool turns = std::ranges::any_of(given, [](const auto& to) { return to.first > 2; });
    if (turns || !count_from_base(*value)) return std::nullopt;
  }
  for (auto element = given.rbegin(); element != given.rend(); ++element)
    value->list.items[static_cast<size_t>(element->first)].value = element->second;
  return value;
}

// The numbers of a pose in a frame, or shifted, as they are in the base of the arm. Of one rotation
// there are several vectors: that of a controller is not known.
bool UrValues::count_from_base(UrValue& value) const {
  Pose frame;
  if (value.base >= 0) {
    if (!frames_[value.base].is_known) return false;
    frame = frames_[value.base].pose;
  }
  const std::vector<double> written = *value.list.numbers(6);
  Pose pose = urscript_dialect().pose_of_numbers(written);
  pose.translation += value.shift;
  const std::vector<double> numbers = urscript_dialect().numbers_of_pose(frame * pose, written);
  for (size_t i = 0; i < numbers.size(); ++i) value.list.items[i].value = numbers[i];
  value.base = -1;
  value.shift.setZero();
  value.before.clear();
  value.behind.clear();
  return true;
}

std::optional<size_t> UrValues::place_of_tool(const Statement& argument) {
  TextCursor cursor(text_, argument.begin, argument.end);
  Variable* const variable = find(take_spelled(cursor), argument.begin);
  if (!variable || !cursor.done() || variable->parameter) return std::nullopt;
  const Assignment* const assignment = assignment_at(*variable, argument.begin);
  if (!assignment || assignment->is_element) return std::nullopt;
  TextCursor value(text_, assignment->value.begin, assignment->value.end);
  const bool is_tool = value.take_name() == "GET_TCP_OFFSET" && value.take('(') && value.take(')');
  return is_tool && value.done() ? std::optional(assignment->value.begin) : std::nullopt;
}

// Sums, products and quotients of numbers, d2r(..), r2d(..), names of numbers and elements of
// points whose values are certain.
std::optional<double> UrValues::number_in(const Statement& part) {
  if (numbers_in_one_another_ == kDeepestNumber) return std::nullopt;
  const std::string_view text =
      std::string_view(original_).substr(part.begin, part.end - part.begin);
  const size_t first = text.find_first_not_of(" \t\r\n");
  // A number that takes the place of a sum over several lines would take the lines, too.
  if (first != text.npos && text.find('\n', first) < text.find_last_not_of(" \t\r\n"))
    return std::nullopt;
  ++numbers_in_one_another_;
  TextCursor cursor(text_, part.begin, part.end);
  const auto value = take_sum(cursor, [&](TextCursor& rest) { return take_named_number(rest); });
  --numbers_in_one_another_;
  return cursor.done() && value && std::isfinite(*value) ? value : std::nullopt;
}

// Each number is found once: the elements of a point may each be those of another point, and so on.
std::optional<double> UrValues::number_of(const Statement& expression) {
  const auto known = numbers_.find(expression.begin);
  if (known != numbers_.end()) return known->second;
  const auto value = number_in(expression);
  if (value) numbers_.emplace(expression.begin, *value);
  return value;
}

std::optional<double> UrValues::take_named_number(TextCursor& cursor) {
  const size_t begin = cursor.at();
  const std::string name = cursor.take_name();
  const size_t end = cursor.at();
  if (cursor.next() == '(') {
    if (name != "D2R" && name != "R2D") return std::nullopt;
    const size_t open = cursor.at(), close = closing(open, text_.size());
    const auto angle = number_of({0, open + 1, std::max(close, open + 1)});
    cursor = TextCursor(text_, std::min(close + 1, text_.size()), cursor.end());
    if (!angle) return std::nullopt;
    return name == "D2R" ? *angle * kDegree : *angle / kDegree;
  }
  if (cursor.next() == '[') {
    const auto index = take_index(cursor);
    auto point = index ? value_of({0, begin, end}) : std::nullopt;
    if (!point || point->is_inverse) return std::nullopt;
    if (point->base >= 0 || !point->shift.isZero(0))
      if (*index > 2 || !count_from_base(*point)) return std::nullopt;
    return point->list.items[static_cast<size_t>(*index)].value;
  }
  Variable* const variable = find(text_.substr(begin, end - begin), begin);
  if (!variable || variable->parameter) return std::nullopt;
  const Assignment* const assignment = assignment_at(*variable, begin);
  return assignment && !assignment->is_element ? number_of(assignment->value) : std::nullopt;
}

// [p1[0]+0.1, ..]: elements with brackets of their own.
std::optional<ListItem> UrValues::list_of_expressions(size_t begin, size_t end) const {
  int depth = 0;
  for (size_t at = begin; at < end; ++at) {
    depth += text_[at] == '[' ? 1 : text_[at] == ']' ? -1 : 0;
    if (depth == 0 && at + 1 < end) return std::nullopt;
  }
  if (depth != 0 || begin == end || text_[begin] != '[') return std::nullopt;
  ListItem list{ListItem::Kind::list, begin, end, 0, {}};
  for (const Statement& part : split_arguments(text_, begin + 1, end - 1, ","))
    list.items.push_back({ListItem::Kind::other, part.begin, part.end, 0, {}});
  return list;
}

// Elements that are no plain numbers.
void UrValues::find_numbers(ListItem& list) {
  if (list.kind != ListItem::Kind::list) return;
  for (ListItem& item : list.items) {
    if (item.kind != ListItem::Kind::other) continue;
    const auto value = number_of({0, item.begin, item.end});
    if (!value) return;
    item.kind = ListItem::Kind::number;
    item.value = *value;
  }
}

// A literal, another name, or pose_trans and pose_add with one of them in it, which stand for the
// name if the point is written out in a move. get_inverse_kin depends on the tool at its place.
std::optional<UrValue> UrValues::assigned_value(const Assignment& assignment,
                                                const std::string& name, int depth) {
  auto value = value_of(assignment.value, depth);
  if (!value || value->is_inverse) return std::nullopt;
  const bool is_expression = value->begin != assignment.value.begin || value->base >= 0;
  if (!value->variable.empty()) {
    if (!is_expression) return value;
    value->before = text_.substr(assignment.value.begin, value->begin - assignment.value.begin);
    value->behind = text_.substr(value->end, assignment.value.end - value->end);
    if (!value->declared) value->declared = value->list;
    return value;
  }
  if (is_expression) {
    value->literal = assignment.value.begin;
    value->literal_end = assignment.value.end;
  }
  value->name = value->variable = name;
  return value;
}

UrValues::Variable* UrValues::find(const std::string& name, size_t at) {
  const int scope = scopes_.at(at);
  int declared = 0;
  Variable* const variable = variables_.find(scopes_, name, scope, &declared);
  const bool is_here = declared == 0 || declared == scope;
  return is_here ? variable : nullptr;
}

bool UrValues::is_local(const Statement& argument) {
  TextCursor cursor(text_, argument.begin, argument.end);
  int declared = 0;
  variables_.find(scopes_, take_spelled(cursor), scopes_.at(argument.begin), &declared);
  return declared > 0 && cursor.done();
}

// For a frame whose pose is not known: an expression, or a name without a unique value. A name that
// this program never assigns may be a variable of the installation.
bool UrValues::is_calculated(const Statement& frame) {
  TextCursor cursor(text_, frame.begin, frame.end);
  const Variable* const variable =
      variables_.find(scopes_, take_spelled(cursor), scopes_.at(frame.begin));
  return !cursor.done() ||
         (variable && (variable->assignments.size() > 1 || variable->is_calculated));
}

// p[..] or [..]
std::optional<UrValue> UrValues::literal_in(const Statement& part) {
  TextCursor cursor(text_, part.begin, part.end);
  UrValue value;
  value.line = part.line;
  value.kind = TargetKind::joints;
  if (cursor.next() == 'p' || cursor.next() == 'P') {
    if (cursor.take_name() != "P") return std::nullopt;
    value.kind = TargetKind::cartesian;
  }
  cursor.next();
  value.literal = value.kind == TargetKind::joints ? cursor.at() : part.begin;
  size_t end = part.end;
  while (end > cursor.at() && is_blank(text_[end - 1])) --end;
  if (end > cursor.at() && text_[end - 1] == ';') --end;
  auto list = list_in(text_, cursor.at(), end);
  if (!list) list = list_of_expressions(cursor.at(), end);
  if (list) find_numbers(*list);
  if (!list || !list->numbers(6)) return std::nullopt;
  value.list = *list;
  value.literal_end = list->end;
  value.name = fmt::format("the point of line {}", part.line);
  return value;
}

std::vector<Statement> UrValues::arguments_in(int line, size_t open, size_t close) const {
  std::vector<Statement> arguments = split_arguments(text_, std::min(open + 1, close), close, ",");
  for (Statement& argument : arguments) argument.line = line;
  return arguments;
}

size_t UrValues::closing(size_t open, size_t end) const {
  int depth = 0;
  for (size_t i = open; i < end; ++i) {
    if (text_[i] == '(') ++depth;
    if (text_[i] == ')' && --depth == 0) return i;
  }
  return end;
}

std::string UrValues::why_not(const Statement& argument) {
  TextCursor cursor(text_, argument.begin, argument.end);
  const std::string name = take_spelled(cursor);
  Variable* const variable = variables_.find(scopes_, name, scopes_.at(argument.begin));
  if (!variable || !cursor.done()) return "its target is an expression or has no plain numbers";
  if (variable->parameter) return "its point is a parameter of the function";
  if (variable->assignments.size() > 1) return "its point is given several values";
  if (!find(name, argument.begin) || !assignment_at(*variable, argument.begin))
    return "its point is given its value in another function";
  return "its point is calculated at run time";
}

// A literal, a name, get_inverse_kin(pose, qnear), pose_trans(frame, pose) or pose_add(pose,
// shift).
std::optional<UrValue> UrValues::value_of(const Statement& argument, int depth) {
  if (auto literal = literal_in(argument)) {
    std::tie(literal->begin, literal->end) = std::pair(argument.begin, argument.end);
    return literal;
  }
  TextCursor cursor(text_, argument.begin, argument.end);
  const std::string name = cursor.take_name();
  if (cursor.done()) {
    const std::string as_spelled = spelled(name, cursor.at());
    Variable* const variable = find(as_spelled, argument.begin);
    if (!variable || depth > kDeepest) return std::nullopt;
    if (variable->handed && variable->assignments.empty())
      return value_of(*variable->handed, depth + 1);
    const Assignment* const assignment = assignment_at(*variable, argument.begin);
    if (!assignment) return std::nullopt;
    std::optional<UrValue> value = with_elements(*variable, assignment, as_spelled, depth + 1);
    if (value) std::tie(value->begin, value->end) = std::pair(argument.begin, argument.end);
    return value;
  }
  if (cursor.next() == '[' && depth <= kDeepest)
    return element_of(spelled(name, cursor.at()), argument, cursor);
  if (cursor.next() != '(' || depth > kDeepest) return std::nullopt;
  const size_t open = cursor.at(), close = closing(open, argument.end);
  TextCursor rest(text_, std::min(close + 1, argument.end), argument.end);
  if (!rest.done()) return std::nullopt;
  const std::vector<Statement> arguments = arguments_in(argument.line, open, close);
  if (returns_.contains(name)) return returned(name, arguments, depth);
  if (name == "GET_INVERSE_KIN") return inverse_of(arguments, depth);
  if (name == "POSE_ADD" && arguments.size() == 2) return shifted(arguments, depth);
  if (name != "POSE_TRANS" || arguments.size() != 2) return std::nullopt;
  auto value = value_of(arguments[1], depth + 1);
  if (!value || value->kind != TargetKind::cartesian || is_local(arguments[0])) return std::nullopt;
  if (!put_in_frame(*value, arguments[0], constant(arguments[0], depth + 1))) return std::nullopt;
  value->is_in_calculated_frame = !frames_[value->base].is_known && is_calculated(arguments[0]);
  return value;
}

// NAME[2] of NAME=[p[..],p[..],p[..]].
std::optional<UrValue> UrValues::element_of(const std::string& name, const Statement& argument,
                                            TextCursor cursor) {
  Variable* const variable = find(name, argument.begin);
  if (!variable || variable->parameter || !cursor.take('[')) return std::nullopt;
  const size_t begin = cursor.at();
  cursor.skip_to("]");
  const auto index = number_of({argument.line, begin, cursor.at()});
  if (!index || *index < 0 || *index != std::floor(*index) || !cursor.take(']') || !cursor.done())
    return std::nullopt;
  const Assignment* const assignment = assignment_at(*variable, argument.begin);
  if (!assignment || assignment->is_element) return std::nullopt;
  const auto list = list_of_expressions(assignment->value.begin, assignment->value.end);
  if (!list || *index >= static_cast<double>(list->items.size())) return std::nullopt;
  const ListItem& item = list->items[static_cast<size_t>(*index)];
  auto value = literal_in({assignment->value.line, item.begin, item.end});
  if (!value) return std::nullopt;
  value->name = value->variable = part_of(argument);
  std::tie(value->begin, value->end) = std::pair(argument.begin, argument.end);
  return value;
}

// FUNCTION(point), which returns the point in another frame: it stays a call.
std::optional<UrValue> UrValues::returned(const std::string& function,
                                          const std::vector<Statement>& arguments, int depth) {
  const std::optional<Statement>& expression = returns_.at(function);
  if (!expression) return std::nullopt;
  std::vector<std::optional<Statement>> before;
  for (const Variable* const variable : parameters_[function]) before.push_back(variable->handed);
  hand_over(function, arguments);
  const auto value = value_of(*expression, depth + 1);
  for (size_t i = 0; i < before.size(); ++i) parameters_[function][i]->handed = before[i];
  numbers_.clear();
  const bool is_in_call = value && std::ranges::any_of(arguments, [&](const Statement& argument) {
                            return argument.begin <= value->begin && value->end <= argument.end;
                          });
  return is_in_call ? value : std::nullopt;
}

// A frame in a frame: both must be known.
bool UrValues::put_in_frame(UrValue& value, const Statement& frame,
                            const std::optional<Pose>& pose) {
  const std::string name = part_of(frame);
  if (value.base < 0) {
    value.base = add_frame(frames_, known_, name, pose);
    return true;
  }
  const ProgramFrame inner = frames_[value.base];
  if (!inner.is_known || !(pose || is_given_frame(known_, upper(name)))) return false;
  const Pose outer = frames_[add_frame(frames_, known_, name, pose)].pose;
  value.base =
      add_frame(frames_, known_, fmt::format("{}, {}", name, inner.name), outer * inner.pose);
  return true;
}

// Whether a word begins a pose p[x, y, ..]: then it is no variable p, as it is in p[0].
bool UrValues::begins_pose(const std::string& word, TextCursor cursor) const {
  if (word != "P" || cursor.next() != '[') return false;
  int depth = 0;
  for (size_t at = cursor.at(); at < cursor.end(); ++at) {
    const char c = text_[at];
    depth += c == '[' || c == '(' ? 1 : c == ']' || c == ')' ? -1 : 0;
    if (depth == 0) return false;
    if (depth == 1 && c == ',') return true;
  }
  return false;
}

// Calls with(variable, scope in which it is declared).
template <class With>
void UrValues::each_variable(const Statement& argument, With with) {
  each_word(text_, argument, [&](const std::string& word, size_t at, TextCursor cursor) {
    if (begins_pose(word, cursor)) return;
    int declared = 0;
    const Variable* const variable =
        variables_.find(scopes_, text_.substr(at, word.size()), scopes_.at(at), &declared);
    with(variable, declared);
  });
}

bool UrValues::names_local(const Statement& argument) {
  bool found = false;
  each_variable(argument, [&](const Variable*, int declared) { found |= declared > 0; });
  return found;
}

bool UrValues::names_several(const Statement& argument) {
  bool found = false;
  each_variable(argument, [&](const Variable* variable, int) {
    found |= variable && variable->assignments.size() > 1;
  });
  return found;
}

// A pose that constants make: pose_trans, pose_add and pose_inv of them, too.
std::optional<Pose> UrValues::constant(const Statement& argument, int depth) {
  if (names_local(argument) || names_several(argument)) return std::nullopt;
  if (const auto value = value_of(argument, depth)) {
    if (value->kind != TargetKind::cartesian || value->near) return std::nullopt;
    Pose pose = urscript_dialect().pose_of_numbers(*value->list.numbers(6));
    pose.translation += value->shift;
    if (value->base < 0) return pose;
    const ProgramFrame& base = frames_[value->base];
    return base.is_known ? std::optional(base.pose * pose) : std::nullopt;
  }
  TextCursor cursor(text_, argument.begin, argument.end);
  const std::string name = cursor.take_name();
  if ((name != "POSE_INV" && name != "POSE_TRANS") || cursor.next() != '(' || depth > kDeepest)
    return std::nullopt;
  const size_t open = cursor.at(), close = closing(open, argument.end);
  const std::vector<Statement> arguments = arguments_in(argument.line, open, close);
  TextCursor rest(text_, std::min(close + 1, argument.end), argument.end);
  if (arguments.size() != (name == "POSE_INV" ? 1 : 2) || !rest.done()) return std::nullopt;
  const std::optional<Pose> first = constant(arguments[0], depth + 1);
  if (!first) return std::nullopt;
  if (name == "POSE_INV") return inverse(*first);
  const std::optional<Pose> second = constant(arguments[1], depth + 1);
  return second ? std::optional(*first * *second) : std::nullopt;
}

// pose_add(pose, shift): positions are added, in the frame that they count from. A shift with a
// rotation would rotate about the axes of the pose.
std::optional<UrValue> UrValues::shifted(const std::vector<Statement>& arguments, int depth) {
  auto value = value_of(arguments[0], depth + 1);
  if (!value || value->kind != TargetKind::cartesian || value->near) return std::nullopt;
  const std::optional<Pose> shift = constant(arguments[1], depth + 1);
  if (!shift || rotation_log(shift->rotation).norm() > 0) return std::nullopt;
  if (value->base >= 0 && !frames_[value->base].is_known) return std::nullopt;
  const Eigen::Matrix3d turn =
      value->base < 0 ? Eigen::Matrix3d::Identity() : frames_[value->base].pose.rotation;
  value->shift += turn.transpose() * shift->translation;
  return value;
}

// Where the arm is, which get_inverse_kin takes for qnear if it has none.
bool UrValues::is_place_of_arm(const Statement& argument) const {
  TextCursor cursor(text_, argument.begin, argument.end);
  const std::string name = cursor.take_name();
  const bool is_place =
      name == "GET_ACTUAL_JOINT_POSITIONS" || name == "GET_TARGET_JOINT_POSITIONS";
  return is_place && cursor.take('(') && cursor.take(')') && cursor.done();
}

// Its pose, near the joints of qnear.
std::optional<UrValue> UrValues::inverse_of(const std::vector<Statement>& arguments, int depth) {
  auto value = value_of(arguments[0], depth + 1);
  if (!value || value->kind != TargetKind::cartesian) return std::nullopt;
  value->is_inverse = true;
  for (size_t i = 1; i < arguments.size(); ++i) {
    Statement near = arguments[i];
    TextCursor cursor(text_, near.begin, near.end);
    const std::string name = cursor.take_name();
    if (cursor.take('=')) {
      if (name == "TCP") return std::nullopt;
      if (name != "QNEAR") continue;
      cursor.next();
      near.begin = cursor.at();
    } else if (i > 1) {
      constexpr size_t kTcp = 4;  // behind qnear and the largest errors
      if (i == kTcp) return std::nullopt;
      continue;
    }
    if (is_place_of_arm(near)) continue;
    const auto joints = value_of(near, depth + 1);
    if (!joints || joints->kind != TargetKind::joints) return std::nullopt;
    value->near = urscript_dialect().joints_of_numbers(*joints->list.numbers(6));
  }
  return value;
}

int UrValues::point_of(const UrValue& value, std::vector<ProgramPoint>& points) {
  return value.declared ? computed_point_of(value, points) : point_of_literal(value, points);
}

int UrValues::point_of_literal(const UrValue& value, std::vector<ProgramPoint>& points) {
  const bool is_named = !value.variable.empty();
  if (is_named) moves_.insert(value.begin);
  if (const auto known = points_.find(value.literal); is_named && known != points_.end())
    return known->second;
  ProgramPoint point;
  point.name = value.name;
  point.line = value.line;
  point.begin = value.literal;
  point.end = value.literal_end;
  point.kind = value.kind;
  for (const ListItem& item : (value.declared ? *value.declared : value.list).items)
    point.numbers.push_back({0, item.begin, item.end, item.value, ""});
  points.push_back(point);
  const int index = static_cast<int>(points.size()) - 1;
  if (is_named) points_[value.literal] = index;
  return index;
}

// Of a name whose elements were given other values, or that is made of another one: written out in
// the move.
int UrValues::computed_point_of(const UrValue& value, std::vector<ProgramPoint>& points) {
  const int declared = point_of_literal(value, points);
  ProgramPoint point = points[static_cast<size_t>(declared)];
  point.begin = value.begin;
  point.end = value.end;
  point.is_expression = true;
  point.starts_from = declared;
  point.before = value.before;
  point.behind = value.behind;
  for (size_t i = 0; i < point.numbers.size(); ++i)
    point.numbers[i] = {0, value.end, value.end, value.list.items[i].value, ""};
  points.push_back(point);
  return static_cast<int>(points.size()) - 1;
}

// pose_trans(POINT, SHIFT) and pose_add(POINT, SHIFT) start from POINT, and p[POINT[0]+0.1, ..]
// does. In pose_trans(FRAME, POINT) nothing is known of the frame; other functions may do anything.
void UrValues::leave(const Statement& argument, int tool) {
  if (TextCursor cursor(text_, argument.begin, argument.end); cursor.take_name(), cursor.done())
    return;
  for (Statement start = argument;;) {
    TextCursor cursor(text_, start.begin, start.end);
    const std::string name = cursor.take_name();
    if (name.empty() || cursor.next() != '(') {
      offsets_[start.begin] = {start.end, tool};
      return;
    }
    if (name != "POSE_TRANS" && name != "POSE_ADD" && name != "GET_INVERSE_KIN") return;
    start = arguments_in(start.line, cursor.at(), closing(cursor.at(), start.end))[0];
  }
}

// Variables that other statements than moves name.
std::set<UrValues::Variable*> UrValues::used_elsewhere(const std::vector<Statement>& statements,
                                                       const std::vector<ProgramTarget>& targets) {
  std::map<int, std::set<std::pair<int, int>>> frames;  // of points: frame and tool
  for (const ProgramTarget& target : targets)
    frames[target.point].insert(
        {target.before.translation.isZero(0) ? target.base : kShifted, target.tool});
  const auto follows = [&](const Variable& variable, int tool) {
    return std::ranges::all_of(points_of(variable), [&](int point) {
      return frames[point].empty() || frames[point] == std::set{std::pair(-1, tool)};
    });
  };
  std::set<Variable*> found;
  for (const Statement& statement : statements)
    each_word(text_, statement, [&](const std::string& word, size_t at, TextCursor cursor) {
      const bool is_named = cursor.take('=') && cursor.next() != '=';  // NAME=..
      const auto behind = offsets_.upper_bound(at);
      const bool is_offset = behind != offsets_.begin() && at < std::prev(behind)->second.end;
      if (is_named || moves_.contains(at) || begins_pose(word, cursor)) return;
      Variable* const variable =
          variables_.find(scopes_, text_.substr(at, word.size()), scopes_.at(at));
      if (variable && !(is_offset && follows(*variable, std::prev(behind)->second.tool)))
        found.insert(variable);
    });
  return found;
}

// Its literals that moves use.
std::vector<int> UrValues::points_of(const Variable& variable) const {
  std::vector<int> found;
  for (const Assignment& assignment : variable.assignments)
    for (auto point = points_.lower_bound(assignment.value.begin);
         point != points_.end() && point->first < assignment.value.end; ++point)
      found.push_back(point->second);
  return found;
}

void UrValues::finish(const std::vector<Statement>& statements,
                      const std::vector<ProgramTarget>& targets,
                      std::vector<ProgramPoint>& points) {
  for (const Variable* const variable : used_elsewhere(statements, targets))
    for (const int point : points_of(*variable)) points[point].is_shared = true;
}

// The part that says where a move ends. An offset of a point is none: what corrects the point
// would be wrong for it.
std::optional<Statement> UrValues::point_in(const Statement& argument, int depth) {
  TextCursor cursor(text_, argument.begin, argument.end);
  const std::string name = cursor.take_name();
  if (cursor.done()) return argument;
  if (cursor.next() != '(' || depth > kDeepest) return std::nullopt;
  const std::vector<Statement> arguments =
      arguments_in(argument.line, cursor.at(), closing(cursor.at(), argument.end));
  if (name == "GET_INVERSE_KIN") return point_in(arguments[0], depth + 1);
  const bool is_in_frame = name == "POSE_TRANS" && arguments.size() == 2;
  return is_in_frame ? point_in(arguments[1], depth + 1) : std::nullopt;
}

std::optional<RoutineParameter> UrValues::parameter_in(const Statement& argument) {
  const auto point = point_in(argument, 0);
  if (!point) return std::nullopt;
  TextCursor cursor(text_, point->begin, point->end);
  const Variable* const variable = find(take_spelled(cursor), point->begin);
  if (!variable || !variable->parameter) return std::nullopt;
  moves_.insert(point->begin);
  return variable->parameter;
}

void UrValues::hand_over(const std::string& function, const std::vector<Statement>& arguments) {
  numbers_.clear();  // they may be those of parameters
  for (Variable* const variable : parameters_[function])
    if (variable->parameter->position < arguments.size())
      variable->handed = arguments[variable->parameter->position];
    else
      variable->handed.reset();
}

void UrValues::note_uses(const std::vector<Statement>& statements,
                         const std::vector<ProgramTarget>& targets) {
  for (Variable* const variable : used_elsewhere(statements, targets)) variable->is_used = true;
}

bool UrValues::only_moves_use(const RoutineParameter& parameter) {
  return std::ranges::none_of(parameters_[parameter.routine], [&](const Variable* variable) {
    return variable->parameter == parameter &&
           (!variable->assignments.empty() || variable->is_used);
  });
}

}  // namespace armtrue
