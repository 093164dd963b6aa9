#include "programs/fanuc/fanuc_assignments.h"

#include <algorithm>
#include <utility>

#include "programs/arithmetic.h"
#include "programs/fanuc/fanuc_words.h"

namespace armtrue {
namespace {

constexpr int kUnknown = ProgramFlow::kUncertain;

// What begins a statement that only reads the registers to which it assigns nothing. All others may
// write into them, as SEARCH START[1] PR[3] does.
bool only_reads_registers(const std::string& word) {
  return contains(
      {"J",    "L",      "C",     "A",      "S",           "P",      "PR",  "R",  "SR", "AR", "IF",
       "WAIT", "UFRAME", "UTOOL", "OFFSET", "TOOL_OFFSET", "SELECT", "FOR", "DO", "GO", "AO"},
      word);
}

// What stands before a register that a move reads.
bool is_read_behind(const std::string& word) {
  return contains({"J", "L", "C", "A", "S", "P", "PR", "OFFSET", "TOOL_OFFSET", "VOFFSET"}, word);
}

bool is_move_word(const std::string& word) { return contains({"J", "L", "C", "A", "S"}, word); }

}  // namespace

FanucAssignments::FanucAssignments(std::string_view text, const std::vector<Statement>& statements,
                                   const ProgramFlow& flow, const FanucRegisters& listed,
                                   PositionOf position_of)
    : text_(text), listed_(listed), position_of_(std::move(position_of)) {
  for (const Statement& statement : statements) read_statement(statement);
  if (assignments_.empty()) return;
  std::map<Element, std::vector<ProgramFlow::Setting>> assigned;
  for (const Assignment& assignment : assignments_) set_elements(assignment, assigned);
  for (const auto& [element, of_element] : assigned) values_[element] = flow.follow({}, kUnknown);
  // Each round follows what depends on registers that the round before has followed.
  constexpr int kRounds = 8;
  for (int round = 0; round < kRounds && follow_round(flow); ++round) continue;
}

void FanucAssignments::read_statement(const Statement& statement) {
  std::string first, before;
  each_fanuc_word(text_, statement, [&](const std::string& word, size_t at, TextCursor& cursor) {
    if (first.empty()) first = word;
    const std::string last = std::exchange(before, word);
    if (calls_fanuc_program(word)) read_call(word, at, cursor);
    if (word != "PR" || cursor.next() != '[') return;
    const auto index = take_fanuc_index(cursor);
    if (index->number) named_.insert(*index->number);
    const bool is_assigned = cursor.take('=');
    if (is_assigned && at == statement.begin)
      assignments_.push_back({at, statement.begin, *index, cursor.at(), statement.end});
    else if (is_assigned || !only_reads_registers(first) ||
             (is_move_word(first) && !is_read_behind(last)))
      assign_any_way(at, *index);
  });
}

void FanucAssignments::assign_any_way(size_t at, const FanucIndex& to) {
  assignments_.push_back({at, at, to, 0, 0});
}

void FanucAssignments::read_call(const std::string& word, size_t at, TextCursor cursor) {
  // What runs beside this program assigns at any time.
  calls_.emplace_back(word == "RUN" ? 0 : at, cursor.take_name());
}

// Whether more is known than before.
bool FanucAssignments::follow_round(const ProgramFlow& flow) {
  std::map<Element, std::vector<ProgramFlow::Setting>> settings;
  for (const Assignment& assignment : assignments_) set_elements(assignment, settings);
  if (settings == settings_) return false;
  settings_ = settings;
  for (auto& [element, of_element] : settings) {
    bool is_run_beside = false;
    for (const auto& [at, name] : calls_) {
      if (!listed_.may_be_set_by(name, element.first)) continue;
      of_element.push_back({at, kUnknown});
      is_run_beside |= at == 0;
    }
    if (is_run_beside) of_element = {{0, kUnknown}};
    values_[element] = flow.follow(of_element, kUnknown);
  }
  return true;
}

void FanucAssignments::set_elements(
    const Assignment& assignment, std::map<Element, std::vector<ProgramFlow::Setting>>& settings) {
  const auto set = [&](double number, int element, int value) {
    settings[{number, element}].push_back({assignment.at, value});
  };
  const FanucIndex& to = assignment.to;
  if (!to.is_of_arm) return;
  if (!to.number) {
    for (const double number : named_)
      for (int element = 0; element < kElements; ++element) set(number, element, kUnknown);
  } else if (to.element == 0) {
    const std::array<int, kElements> value = whole_value(assignment);
    for (int element = 0; element < kElements; ++element) set(*to.number, element, value[element]);
  } else if (to.element <= kNumbers) {
    set(*to.number, to.element, sum(assignment));
  }
}

// LPOS-LPOS and JPOS-JPOS are zeros; so is a register less itself, whatever it held.
std::array<int, FanucAssignments::kElements> FanucAssignments::whole_value(
    const Assignment& assignment) {
  std::array<int, kElements> unknown;
  unknown.fill(kUnknown);
  TextCursor cursor(text_, assignment.value, assignment.end);
  struct Term {
    std::string name;
    std::optional<double> number;
    bool operator==(const Term&) const = default;
  };
  const auto take_term = [&] {
    Term term{cursor.take_name(), {}};
    if (cursor.next() != '[') return term;
    const auto index = take_fanuc_index(cursor);
    if (index->element == 0 && index->is_of_arm) term.number = index->number;
    if (!term.number) term.name.clear();
    return term;
  };
  const Term first = take_term();
  const bool is_difference = cursor.take('-');
  if (is_difference && take_term() != first) return unknown;
  cursor.take(';');
  if (!cursor.done()) return unknown;
  const bool is_register = first.name == "PR" && first.number;
  if (is_difference) {
    FanucRegister zeros{FanucRegister::Meaning::not_said, std::vector<double>(kNumbers, 0.0), ""};
    if (first.name == "LPOS") zeros.meaning = FanucRegister::Meaning::pose;
    if (first.name == "JPOS") zeros.meaning = FanucRegister::Meaning::joints;
    std::array<int, kElements> result = elements_of(zeros);
    if (is_register) result[kKind] = element_before({*first.number, kKind}, assignment.statement);
    return is_register || first.name == "LPOS" || first.name == "JPOS" ? result : unknown;
  }
  if (is_register) {
    for (int element = 0; element < kElements; ++element)
      unknown[element] = element_before({*first.number, element}, assignment.statement);
    return unknown;
  }
  const auto position =
      first.name == "P" && first.number ? position_of_(*first.number) : std::nullopt;
  return position ? elements_of(*position) : unknown;
}

// PR[5,3]=(PR[4,3]+50)
int FanucAssignments::sum(const Assignment& assignment) {
  TextCursor cursor(text_, assignment.value, assignment.end);
  const auto value = take_sum(cursor, [&](TextCursor& at) -> std::optional<double> {
    if (at.take_name() != "PR" || at.next() != '[') return std::nullopt;
    const auto index = take_fanuc_index(at);
    if (!index->number || index->element == 0 || !index->is_of_arm) return std::nullopt;
    return number_before({*index->number, index->element}, assignment.statement);
  });
  cursor.take(';');
  return value && cursor.done() ? index_of_number(*value) : kUnknown;
}

std::array<int, FanucAssignments::kElements> FanucAssignments::elements_of(
    const FanucRegister& value) {
  std::array<int, kElements> result;
  result[kKind] = index_of_kind({value.meaning, value.configuration, value.frame, value.tool});
  for (int i = 0; i < kNumbers; ++i) result[i + 1] = index_of_number(value.numbers[i]);
  return result;
}

// As an index.
int FanucAssignments::element_before(const Element& element, size_t statement) {
  if (element.second == kKind) {
    const auto kind = kind_before(element.first, statement);
    return kind ? index_of_kind(*kind) : kUnknown;
  }
  const auto value = number_before(element, statement);
  return value ? index_of_number(*value) : kUnknown;
}

// Steps of the statement itself stand where it begins.
std::optional<double> FanucAssignments::number_before(const Element& element,
                                                      size_t statement) const {
  if (const auto values = values_.find(element); values != values_.end()) {
    const int value = values->second.at(statement - 1);
    return value == kUnknown ? std::nullopt : std::optional(numbers_[value]);
  }
  const FanucRegister* const listed = listed_.find(element.first);
  return listed && element.second <= kNumbers ? std::optional(listed->numbers[element.second - 1])
                                              : std::nullopt;
}

std::optional<FanucAssignments::Kind> FanucAssignments::kind_before(double number,
                                                                    size_t statement) const {
  if (const auto values = values_.find({number, kKind}); values != values_.end()) {
    const int value = values->second.at(statement - 1);
    return value == kUnknown ? std::nullopt : std::optional(kinds_[value]);
  }
  const FanucRegister* const listed = listed_.find(number);
  return listed ? Kind{listed->meaning, listed->configuration, {}, {}} : Kind{};
}

int FanucAssignments::index_of_number(double value) {
  const auto [found, is_new] = of_numbers_.try_emplace(value, static_cast<int>(numbers_.size()));
  if (is_new) numbers_.push_back(value);
  return found->second;
}

int FanucAssignments::index_of_kind(const Kind& kind) {
  const auto [found, is_new] = of_kinds_.try_emplace(kind, static_cast<int>(kinds_.size()));
  if (is_new) kinds_.push_back(kind);
  return found->second;
}

std::optional<FanucRegister> FanucAssignments::find(double number, size_t statement) const {
  const auto kind = kind_before(number, statement);
  FanucRegister result;
  for (int element = 1; element < kElements; ++element)
    if (const auto value = number_before({number, element}, statement))
      result.numbers.push_back(*value);
  if (!kind || result.numbers.size() != kNumbers) return std::nullopt;
  result.meaning = kind->meaning;
  result.configuration = kind->configuration;
  result.frame = kind->frame;
  result.tool = kind->tool;
  return result;
}

}  // namespace armtrue
