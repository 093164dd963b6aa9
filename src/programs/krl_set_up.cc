#include "programs/krl_set_up.h"

#include <fmt/format.h>

#include <cmath>

#include "programs/frame_list.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

std::string without_blanks(std::string_view text) {
  std::string result;
  for (char c : text)
    if (!is_blank(c)) result += c;
  return upper(result);
}

std::optional<Pose> pose_of(const KrlFrame& frame) {
  const KrlValues& v = frame.values;
  if (!v.head<6>().array().isFinite().all()) return std::nullopt;
  return Pose{rotation_from_abc(v[3], v[4], v[5]), v.head<3>()};
}

// The text between the brackets of SBASE(FP1).
std::string argument_of(const std::string& text, const std::string& function) {
  if (!text.starts_with(function + "(") || !text.ends_with(")")) return "";
  return text.substr(function.size() + 1, text.size() - function.size() - 2);
}

}  // namespace

KrlSetUps::SetUp KrlSetUps::at(const KrlMove& move) {
  for (; next_ < move.set_ups; ++next_) apply(syntax_.set_ups[next_]);
  if (set_before_ && now_.base < 0 && now_.tool < 0) {
    warnings_.add(move.line,
                  "this DEF states no $BASE and no $TOOL, and one before it does; --base and "
                  "--tool are taken");
    set_before_ = false;
  }
  SetUp set_up = now_;
  read_with(move, set_up);
  return set_up;
}

void KrlSetUps::apply(const KrlSetUp& statement) {
  const std::string_view text = std::string_view(src_).substr(0, statement.end);
  const std::string spelled = without_blanks(text.substr(statement.begin));
  const size_t equals = text.find('=', statement.begin);
  if (statement.word == "DEF" || statement.word == "DEFFCT") {
    set_before_ |= now_.base >= 0 || now_.tool >= 0;
    now_ = {};
    return;
  }
  int KrlSetUps::SetUp::*part = nullptr;
  int frame = -1;
  if (statement.word == "BAS") {
    for (const bool is_tool : {false, true}) {
      const std::string begin = is_tool ? "BAS(#TOOL," : "BAS(#BASE,";
      if (!spelled.starts_with(begin)) continue;
      part = is_tool ? &SetUp::tool : &SetUp::base;
      TextCursor cursor(spelled, begin.size(), spelled.size());
      const auto number = cursor.take_number();
      const char* const list = is_tool ? "TOOL_DATA" : "BASE_DATA";
      frame = number && std::abs(*number) < 1000 && cursor.take(')')
                  ? number_of(list, static_cast<int>(*number))
                  : add(spelled, std::nullopt);
    }
    if (!part) return;
  } else if (equals == std::string_view::npos) {
    return;
  } else if (statement.word == "FDAT_ACT") {
    apply(without_blanks(text.substr(equals + 1)), statement.line, now_);
  } else if (statement.word == "$IPO_MODE") {
    now_.is_external_tcp = spelled.ends_with("#TCP");
  } else if (spelled.starts_with(statement.word + "=")) {
    part = statement.word == "$TOOL" ? &SetUp::tool : &SetUp::base;
    frame = frame_of(equals + 1, statement.end, statement.line, statement.word == "$TOOL");
  } else {  // one component, $BASE.X=1
    part = statement.word == "$TOOL" ? &SetUp::tool : &SetUp::base;
    frame = add(spelled, std::nullopt);
  }
  if (part) now_.*part = frame;
  if (statement.is_conditional)
    warnings_.add(statement.line, "a frame is set under a condition, and taken as set");
}

void KrlSetUps::apply(const std::string& name, int line, SetUp& set_up) {
  const auto found = syntax_.fdats.find(name);
  if (found == syntax_.fdats.end() || !found->second.tool || !found->second.base) {
    warnings_.add(line, "the tool and base of '" + name + "' are not declared as FDAT");
    set_up.base = set_up.tool = add(name, std::nullopt);
    return;
  }
  set_up.tool = number_of("TOOL_DATA", *found->second.tool);
  set_up.base = number_of("BASE_DATA", *found->second.base);
  set_up.is_external_tcp = found->second.is_external_tcp;
}

// WITH $TOOL = STOOL2(FP1), $BASE = SBASE(FP1)
void KrlSetUps::read_with(const KrlMove& move, SetUp& set_up) {
  const std::string rest =
      upper(std::string_view(src_).substr(move.keyword_end, move.end - move.keyword_end));
  for (const bool is_tool : {false, true}) {
    const size_t name = rest.find(is_tool ? "$TOOL" : "$BASE");
    if (name == std::string::npos) continue;
    TextCursor cursor(rest, name + 5, rest.size());
    if (!cursor.take('=')) continue;
    size_t begin = cursor.at(), end = begin;
    int depth = 0;
    for (; end < rest.size() && (depth > 0 || rest[end] != ','); ++end)
      depth += rest[end] == '{' || rest[end] == '('   ? 1
               : rest[end] == '}' || rest[end] == ')' ? -1
                                                      : 0;
    const int frame =
        frame_of(move.keyword_end + begin, move.keyword_end + end, move.line, is_tool);
    (is_tool ? set_up.tool : set_up.base) = frame;
  }
}

int KrlSetUps::frame_of(size_t begin, size_t end, int line, bool is_tool) {
  TextCursor cursor(src_, begin, end);
  const std::string spelled = without_blanks(std::string_view(src_).substr(begin, end - begin));
  if (cursor.next() == '{') {
    const KrlAggregate aggregate = take_krl_aggregate(cursor);
    if (aggregate.kind == KrlAggregateKind::frame && cursor.done())
      return add(spelled, pose_of(aggregate.frame));
    return add(spelled, std::nullopt);
  }
  for (const char* function : {"STOOL2", "STOOL", "SBASE"})
    if (const std::string name = argument_of(spelled, function); !name.empty()) {
      SetUp of_fdat;
      apply(name, line, of_fdat);
      return is_tool ? of_fdat.tool : of_fdat.base;
    }
  if (spelled == "$NULLFRAME" || spelled == "$WORLD" || spelled == "BASE_DATA[0]" ||
      spelled == "TOOL_DATA[0]")
    return add(spelled, Pose{});
  if (const auto name = syntax_.frame_names.find(spelled); name != syntax_.frame_names.end())
    return add(spelled, pose_of(syntax_.frames[static_cast<size_t>(name->second)]));
  return add(spelled, std::nullopt);
}

int KrlSetUps::number_of(const char* list, int number) {
  const std::string name = fmt::format("{}[{}]", list, number);
  return add(name, number == 0 ? std::optional(Pose{}) : std::nullopt);
}

int KrlSetUps::add(const std::string& name, const std::optional<Pose>& pose) {
  return add_frame(frames_, known_, name, pose);
}

}  // namespace armtrue
