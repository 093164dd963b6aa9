#include "programs/krl_set_up.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "programs/frame_list.h"
#include "programs/krl_words.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

// In place of the number of a statement.
constexpr size_t kWith = std::numeric_limits<size_t>::max();

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

// What stands behind the first `=`.
std::string_view behind_equals(std::string_view text) {
  const size_t equals = text.find('=');
  return equals == std::string_view::npos ? "" : text.substr(equals + 1);
}

// FP1 of STOOL2(FP1), SBASE(FP1), SIPOMODE(FP1.IPO_FRAME); empty of anything else.
std::string fdat_of(const std::string& value) {
  for (const std::string function : {"STOOL2(", "STOOL(", "SBASE(", "SIPOMODE(", "SIPO_MODE("})
    if (value.starts_with(function) && value.ends_with(")"))
      return value.substr(function.size(), value.find_first_of(".)") - function.size());
  return "";
}

bool is_definition(const std::string& word) { return word == "DEF" || word == "DEFFCT"; }

}  // namespace

KrlSetUps::KrlSetUps(const std::string& src, const KrlSyntax& syntax, const KnownFrames& known,
                     std::vector<ProgramFrame>& frames, ProgramWarnings& warnings)
    : src_(src), syntax_(syntax), known_(known), frames_(frames), warnings_(warnings) {
  for (size_t i = 0; i < syntax.set_ups.size(); ++i) {
    const KrlSetUp& statement = syntax.set_ups[i];
    if (statement.word != "DEF") continue;
    TextCursor cursor(src, statement.begin, statement.end);
    while (cursor.take_name() != "DEF") {  // GLOBAL
    }
    subprograms_[cursor.take_name()] = i + 1;
  }
}

KrlSetUps::List KrlSetUps::read() {
  List list{{}, {set_up(now_)}};
  const auto apply_until = [&](size_t count) {
    for (size_t i = list.behind.size() - 1; i < count; ++i) {
      apply(i);
      list.behind.push_back(set_up(now_));
    }
  };
  for (const KrlMove& move : syntax_.moves) {
    apply_until(move.set_ups);
    list.of_moves.push_back(at(move));
  }
  apply_until(syntax_.set_ups.size());
  return list;
}

KrlSetUps::SetUp KrlSetUps::set_up(const Settings& settings) {
  return {settings[kBase].value, settings[kTool].value, settings[kMode].value == 1};
}

KrlSetUps::SetUp KrlSetUps::at(const KrlMove& move) {
  if (set_before_ && now_[kBase].value < 0 && now_[kTool].value < 0) {
    warn(move.line,
         "this DEF states no $BASE and no $TOOL, and one before it does; --base and --tool are "
         "taken");
    set_before_ = false;
  }
  Settings settings = now_;
  by_ = kWith;
  if (const auto& block = move.spline_block)
    read_with(block->begin, block->end, block->line, settings);
  read_with(move.keyword_end, move.end, move.line, settings);
  note_use(settings, move.line);
  return set_up(settings);
}

// What is set within a loop is set within the loops around it too.
void KrlSetUps::note_use(const Settings& settings, int line) {
  for (size_t part = 0; part < settings.size(); ++part) {
    if (const auto call = lines_of_calls_.extract(settings[part].by); !call.empty())
      warn(call.mapped(), "a frame is set in the subprogram that it calls, and taken as set");
    for (auto loop = loops_.rbegin(); loop != loops_.rend(); ++loop) {
      int& of_loop = loop->line_of_move[part];
      if (of_loop > 0 || settings[part].by != loop->begin[part].by) break;
      of_loop = line;
    }
  }
}

void KrlSetUps::end_loop() {
  if (loops_.empty()) return;
  const Loop& loop = loops_.back();
  for (size_t part = 0; part < now_.size(); ++part)
    if (loop.line_of_move[part] > 0 && now_[part].value != loop.begin[part].value)
      warn(loop.line_of_move[part],
           fmt::format("its loop sets {} behind it; that of the first turn is taken",
                       part == kBase   ? "$BASE"
                       : part == kTool ? "$TOOL"
                                       : "$IPO_MODE"));
  loops_.pop_back();
}

void KrlSetUps::apply(size_t index) {
  const KrlSetUp& statement = syntax_.set_ups[index];
  const std::string& word = statement.word;
  if (is_definition(word)) {
    set_before_ |= now_[kBase].value >= 0 || now_[kTool].value >= 0;
    now_ = kNothing;
    return loops_.clear();
  }
  if (begins_krl_loop(word)) return loops_.push_back({now_, {}});
  if (ends_krl_loop(word)) return end_loop();
  by_ = index + 1;
  if (word == "BAS")
    read_bas(without_blanks(text(statement.begin, statement.end)));
  else if (word == "FDAT_ACT")
    set_fdat(without_blanks(behind_equals(text(statement.begin, statement.end))), statement.line,
             now_);
  else if (word[0] == '$')
    assign(word, statement.begin, statement.end, statement.line, now_);
  else
    return call(statement);
  const bool is_set = std::ranges::find(now_, by_, &Setting::by) != now_.end();
  if (is_set && statement.is_conditional)
    warn(statement.line, "a frame is set under a condition, and taken as set");
}

void KrlSetUps::call(const KrlSetUp& statement) {
  if (!subprograms_.contains(statement.word)) return;
  const Settings effect = effect_of(statement.word);
  for (size_t part = 0; part < effect.size(); ++part) {
    if (effect[part].by == 0) continue;
    if (effect[part].value != now_[part].value) lines_of_calls_[by_] = statement.line;
    now_[part] = {effect[part].value, by_};
  }
}

KrlSetUps::Settings KrlSetUps::effect_of(const std::string& subprogram) {
  constexpr int kMostCalls = 100;  // within one another
  const auto [known, is_new] = effects_.try_emplace(subprogram);
  if (!is_new || calls_ == kMostCalls) return known->second;
  const Settings before = std::exchange(now_, kNothing);
  const std::vector<Loop> loops = std::exchange(loops_, {});
  const size_t by = by_;
  ++calls_;
  for (size_t i = subprograms_[subprogram];
       i < syntax_.set_ups.size() && !is_definition(syntax_.set_ups[i].word); ++i)
    apply(i);
  --calls_;
  by_ = by;
  loops_ = loops;
  return effects_[subprogram] = std::exchange(now_, before);
}

void KrlSetUps::read_bas(const std::string& spelled) {
  for (const Part part : {kBase, kTool}) {
    const std::string begin = part == kTool ? "BAS(#TOOL," : "BAS(#BASE,";
    if (!spelled.starts_with(begin)) continue;
    TextCursor cursor(spelled, begin.size(), spelled.size());
    const auto number = cursor.take_number();
    const char* const list = part == kTool ? "TOOL_DATA" : "BASE_DATA";
    const bool is_plain = number && std::abs(*number) < 1000 && cursor.take(')');
    set(part, is_plain ? number_of(list, static_cast<int>(*number)) : add(spelled, std::nullopt),
        now_);
  }
}

void KrlSetUps::set_fdat(const std::string& name, int line, Settings& settings) {
  if (name.empty()) return;
  const auto found = syntax_.fdats.find(name);
  if (found == syntax_.fdats.end() || !found->second.tool || !found->second.base) {
    warn(line, "the tool and base of '" + name + "' are not declared as FDAT");
    for (const Part part : {kBase, kTool}) set(part, add(name, std::nullopt), settings);
    return;
  }
  set(kTool, number_of("TOOL_DATA", *found->second.tool), settings);
  set(kBase, number_of("BASE_DATA", *found->second.base), settings);
  set(kMode, found->second.is_external_tcp, settings);
}

// WITH $TOOL = STOOL2(FP1), $BASE = SBASE(FP1)
void KrlSetUps::read_with(size_t begin, size_t end, int line, Settings& settings) {
  TextCursor cursor(src_, begin, end);
  while (!cursor.done())
    if (!is_letter(cursor.next()))
      cursor.step();
    else if (cursor.take_name() == "WITH")
      break;
  for (const Statement& part : split_arguments(src_, cursor.at(), end, ",")) {
    const std::string name = TextCursor(src_, part.begin, part.end).take_name();
    if (contains({"$BASE", "$TOOL", "$IPO_MODE"}, name))
      assign(name, part.begin, part.end, line, settings);
  }
}

// $BASE={..}, $TOOL=TOOL_DATA[1], $IPO_MODE=#TCP; also one component, $BASE.X=1.
void KrlSetUps::assign(const std::string& name, size_t begin, size_t end, int line,
                       Settings& settings) {
  const std::string spelled = without_blanks(text(begin, end));
  const std::string value(behind_equals(spelled));
  if (value.empty()) return;
  if (name == "$IPO_MODE") {
    const auto fdat = syntax_.fdats.find(fdat_of(value));
    const bool is_of_fdat = fdat != syntax_.fdats.end() && fdat->second.is_external_tcp;
    return set(kMode, value == "#TCP" || is_of_fdat, settings);
  }
  const Part part = name == "$TOOL" ? kTool : kBase;
  if (!spelled.starts_with(name + "=")) return set(part, add(spelled, std::nullopt), settings);
  if (const std::string fdat = fdat_of(value); !fdat.empty()) {
    Settings of_fdat = kNothing;
    set_fdat(fdat, line, of_fdat);
    if (of_fdat[kMode].value == 1) set(kMode, 1, settings);
    return set(part, of_fdat[part].value, settings);
  }
  set(part, frame_of(src_.find('=', begin) + 1, end), settings);
}

void KrlSetUps::set(Part part, int value, Settings& settings) const {
  settings[part] = {value, by_};
}

int KrlSetUps::frame_of(size_t begin, size_t end) {
  TextCursor cursor(src_, begin, end);
  const std::string spelled = without_blanks(text(begin, end));
  if (cursor.next() == '{') {
    const KrlAggregate aggregate = take_krl_aggregate(cursor);
    if (aggregate.kind == KrlAggregateKind::frame && cursor.done())
      return add(spelled, pose_of(aggregate.frame));
    return add(spelled, std::nullopt);
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

void KrlSetUps::warn(int line, const std::string& text) {
  if (calls_ == 0) warnings_.add(line, text);
}

std::string_view KrlSetUps::text(size_t begin, size_t end) const {
  return std::string_view(src_).substr(begin, end - begin);
}

}  // namespace armtrue
