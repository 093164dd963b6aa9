#include "programs/fanuc/fanuc_registers.h"

#include <algorithm>
#include <array>

#include "programs/fanuc/fanuc_text.h"
#include "programs/fanuc/fanuc_words.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

constexpr std::array<const char*, 6> kPose{"X", "Y", "Z", "W", "P", "R"};
constexpr std::array<const char*, 6> kJoints{"J1", "J2", "J3", "J4", "J5", "J6"};

// An entry of a listing, as far as it is read.
struct ListedEntry {
  std::optional<double> group, number;
  std::map<std::string, double> numbers;  // by their names
  std::string configuration;
};

// Of an arm with other axes a position of six numbers says too little: it has none then.
FanucRegister register_of(const ListedEntry& entry) {
  constexpr size_t kNumbers = 6;
  FanucRegister result;
  const bool is_joints = entry.numbers.contains("J1");
  result.meaning = is_joints ? FanucRegister::Meaning::joints : FanucRegister::Meaning::pose;
  result.configuration = entry.configuration;
  for (const char* name : is_joints ? kJoints : kPose)
    if (const auto found = entry.numbers.find(name); found != entry.numbers.end())
      result.numbers.push_back(found->second);
  if (result.numbers.size() != kNumbers || entry.numbers.size() != kNumbers) result.numbers.clear();
  return result;
}

// Takes what the rest of a line says of an entry; `text` ends with the line.
void take_values(std::string_view text, TextCursor& cursor, ListedEntry& entry) {
  while (!cursor.done()) {
    const std::string name = take_fanuc_word(cursor);
    if (name.empty()) {
      cursor.step();
      continue;
    }
    if (!cursor.take(':') && !cursor.take('=')) continue;
    if (name == "CONFIG") {
      cursor.next();
      entry.configuration = text.substr(cursor.at());
      while (!entry.configuration.empty() && is_blank(entry.configuration.back()))
        entry.configuration.pop_back();
      return;
    }
    const auto value = cursor.take_number();
    if (value && name != "GROUP") entry.numbers[name] = *value;
  }
}

}  // namespace

bool is_fanuc_listing(const std::string& text) {
  return std::ranges::any_of(
      std::array{"]$POSREG", "]$MNUFRAME", "]$MNUTOOL"},
      [&](const char* name) { return text.find(name) != std::string::npos; });
}

FanucRegisters::FanucRegisters(const ProgramText* begin, const ProgramText* end) {
  for (const ProgramText* text = begin; text != end; ++text) {
    if (is_fanuc_listing(text->text)) {
      read_listing(text->text);
      continue;
    }
    if (text->name.starts_with(kFanucCall)) {
      Call& call = calls_[text->name.substr(kFanucCall.size())];
      call.registers.note(text->text, "PR");
      call.sets_frames = sets_fanuc_frames(text->text);
      continue;
    }
    const std::string other = masked_fanuc(text->text);
    changed_.note(other, "PR");
    changed_frames_.note(other, "UFRAME");
    changed_tools_.note(other, "UTOOL");
  }
}

// [*POSREG*]$POSREG  Storage: SHADOW  Access: RW  : ARRAY[1,100] OF Position Reg
//     [1,2] =   'approach'   Group: 1   Config: F U T, 0, 0, 0
//   X:   536.883   Y:    66.987   Z:   -94.208
//   W:     -.364   P:    -3.023   R:     -.199
void FanucRegisters::read_listing(const std::string& text) {
  ListedEntry entry;
  Listed* listed = nullptr;  // of the variable that is read
  const auto keep = [&] {
    if (!entry.number || !listed || entry.group != 1) return;
    FanucRegister result = register_of(entry);
    if (listed->contains(*entry.number)) result.numbers.clear();
    (*listed)[*entry.number] = result;
  };
  for (const Statement& line : lines_of(text)) {
    TextCursor cursor(text, line.begin, line.end);
    if (cursor.take('[')) {
      const auto first = cursor.take_number();
      const bool is_entry = first && cursor.take(',');
      const auto second = is_entry ? cursor.take_number() : std::nullopt;
      if (!first) {
        keep();
        entry.number.reset();
        cursor.skip_to("]");
        const std::string name = cursor.take(']') ? cursor.take_name() : "";
        listed = name == "$POSREG"     ? &registers_
                 : name == "$MNUFRAME" ? &frames_
                 : name == "$MNUTOOL"  ? &tools_
                                       : nullptr;
        continue;
      }
      if (!second || !cursor.take(']')) continue;
      keep();
      entry = {first, second, {}, ""};
      if (cursor.take('=') && cursor.take('\'')) {
        cursor.skip_to("'");
        cursor.take('\'');
      }
    }
    take_values(std::string_view(text).substr(0, line.end), cursor, entry);
  }
  keep();
}

// PR[1]=LPOS, PR[1:name]=.., PR[1,3]=.., PR[GP1:1,3:name]=..; PR[R[1]]=.. may be any.
std::set<std::string> fanuc_values_set_in(std::string_view program, std::string_view kind) {
  std::set<std::string> values;
  each_fanuc_word(program, {0, 0, program.size()},
                  [&](const std::string& word, size_t, TextCursor cursor) {
                    const size_t begin = cursor.at();
                    if (word != kind || !cursor.take('[')) return;
                    int depth = 1;
                    while (!cursor.done() && depth > 0 && cursor.next() != '\n') {
                      depth += cursor.next() == '[' ? 1 : cursor.next() == ']' ? -1 : 0;
                      cursor.step();
                    }
                    const size_t end = cursor.at();
                    if (cursor.take('='))
                      values.insert(word + std::string(program.substr(begin, end - begin)));
                  });
  return values;
}

bool sets_fanuc_frames(std::string_view program) {
  bool sets = false;
  each_fanuc_word(program, {0, 0, program.size()},
                  [&](const std::string& word, size_t, const TextCursor&) {
                    sets |= word == "CONDITION" || word.starts_with("UFRAME") ||
                            word.starts_with("UTOOL") || word.starts_with("$MNU");
                  });
  return sets;
}

void FanucRegisters::Changes::note(std::string_view program, std::string_view kind) {
  for (const std::string& name : fanuc_values_set_in(program, kind)) {
    TextCursor inside(name, name.find('[') + 1, name.size());
    const std::string group = inside.take_name();
    if (!group.empty() && (!group.starts_with("GP") || !inside.take(':')))
      is_any = true;  // R[1]
    else if (const auto number = inside.take_number(); !number)
      is_any = true;
    else if (group.empty() || group == "GP1")
      numbers.insert(*number);
  }
}

bool FanucRegisters::is_set_by_others(bool is_tool, double number) const {
  return (is_tool ? changed_tools_ : changed_frames_).contains(number);
}

const FanucRegister* FanucRegisters::find_frame(bool is_tool, double number) const {
  const Listed& listed = is_tool ? tools_ : frames_;
  const auto found = listed.find(number);
  if (found == listed.end() || found->second.is_joints() || found->second.numbers.empty())
    return nullptr;
  return &found->second;
}

bool FanucRegisters::may_be_set_by(const std::string& program, double number) const {
  const auto found = calls_.find(program);
  return found == calls_.end() || found->second.registers.contains(number);
}

bool FanucRegisters::may_set_frames(const std::string& program) const {
  const auto found = calls_.find(program);
  return found == calls_.end() || found->second.sets_frames;
}

const FanucRegister* FanucRegisters::find(double number) const {
  const auto found = registers_.find(number);
  if (changed_.contains(number) || found == registers_.end()) return nullptr;
  return found->second.numbers.empty() ? nullptr : &found->second;
}

}  // namespace armtrue
