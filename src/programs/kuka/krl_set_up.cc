#include "programs/kuka/krl_set_up.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "programs/frame_list.h"
#include "programs/kuka/krl_variables.h"
#include "programs/kuka/krl_words.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

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

bool is_same(const Pose& a, const Pose& b) {
  return a.rotation == b.rotation && a.translation == b.translation;
}

size_t before_statement(size_t statement) { return statement == 0 ? 0 : statement - 1; }

bool is_several(const HandedFrame& frame) { return frame.kind == HandedFrame::Kind::several; }

}  // namespace

KrlSetUps::KrlSetUps(const std::string& src, const KrlSyntax& syntax,
                     const ProgramNeighbours& neighbours, const KnownFrames& known,
                     std::vector<ProgramFrame>& frames, ProgramWarnings& warnings)
    : src_(src),
      syntax_(syntax),
      neighbours_(neighbours),
      known_(known),
      frames_(frames),
      warnings_(warnings) {}

KrlSetUps::List KrlSetUps::read() {
  follow_statements();
  List list;
  list.behind.emplace_back();
  for (const KrlSetUp& statement : syntax_.set_ups) list.behind.push_back(at(statement.end));
  for (const KrlMove& move : syntax_.moves) {
    const Settings with = with_of(move);
    list.of_moves.push_back(at(move.begin, with));
    list.not_followed.push_back(not_followed(list.of_moves.back()));
    list.are_of_callers.push_back(are_of_callers(move.begin, with));
  }
  leave_subprograms(list);
  for (const auto& [routine, frames] : neighbours_.begins)
    if (std::ranges::any_of(frames, is_several)) list.callers = neighbours_.callers.at(routine);
  std::set<std::string> names;
  for (const auto& of_part : interrupts_)
    for (const Interrupt& interrupt : of_part) names.insert(interrupt.name);
  list.interrupts = fmt::format("{}", fmt::join(names, ", "));
  return list;
}

// What depends on the frame before it is found a round after that.
void KrlSetUps::follow_statements() {
  constexpr int kRounds = 8;  // more frames in a chain, of no real program, would take long
  SettingsInOrder before;
  for (int round = 0; round < kRounds; ++round) {
    SettingsInOrder settings = follow_round();
    const bool is_last = !depends_on_itself_ || (round > 0 && settings == before);
    before = std::move(settings);
    is_followed_ = true;
    if (is_last) break;
  }
  find_interrupts(before);
}

KrlSetUps::SettingsInOrder KrlSetUps::follow_round() {
  SettingsInOrder settings;
  for (const KrlSetUp& statement : syntax_.set_ups)
    add(begins_krl_routine(statement.word) ? begin_of(statement) : set_by(statement), statement,
        settings);
  std::vector<ProgramFlow::Setting> fdats;
  ProgramFlow flow = syntax_.steps.flow();
  add_what_others_leave(settings, fdats);
  add_callers(flow, settings);
  add_fdats(flow, std::move(fdats), settings);
  follow(flow, settings);
  if (add_initial_frames(settings)) follow(flow, settings);
  SettingsInOrder result = settings;
  follow_without_callers(flow, settings);
  return result;
}

// The same with a value of no frame for what the callers hand on.
void KrlSetUps::follow_without_callers(const ProgramFlow& flow, SettingsInOrder& settings) {
  without_callers_ = values_;
  if (neighbours_.begins.empty()) return;
  for (const size_t part : {kBase, kTool}) {
    for (ProgramFlow::Setting& setting : settings[part])
      if (setting.at > src_.size()) setting.value = kOfCaller;
    without_callers_[part] = flow.follow(settings[part], kStart[part]);
  }
}

bool KrlSetUps::are_of_callers(size_t place, const Settings& of_move) const {
  return std::ranges::any_of(std::array{kBase, kTool}, [&](Part part) {
    const int value = values_[part].at(place);
    return !of_move[part] && value >= 0 && without_callers_[part].at(place) != value;
  });
}

void KrlSetUps::add(const Settings& set, const KrlSetUp& statement, SettingsInOrder& settings) {
  for (size_t part = 0; part < set.size(); ++part)
    if (set[part]) settings[part].push_back({statement.begin, *set[part]});
}

void KrlSetUps::follow(const ProgramFlow& flow, const SettingsInOrder& settings) {
  for (size_t part = 0; part < settings.size(); ++part)
    values_[part] = flow.follow(settings[part], kStart[part]);
}

// What a subprogram sets that an INTERRUPT or a TRIGGER calls may hold at any place from there on.
void KrlSetUps::find_interrupts(const SettingsInOrder& settings) {
  for (const auto& [name, places] : syntax_.steps.interrupts()) {
    const std::vector<Span> texts = texts_run_by(name);
    std::vector<ProgramFlow::Setting> starts;
    if (!syntax_.set_ups.empty()) starts.push_back({syntax_.set_ups[0].begin, 0});
    for (const size_t place : places) starts.push_back({place, 1});
    for (const Part part : {kBase, kTool, kMode}) {
      if (!may_be_set_by(name, part, settings, texts)) continue;
      const bool is_own = !texts.empty() && !syntax_.steps.called().contains(name);
      interrupts_[part].push_back(
          {name, is_own ? texts.front() : Span{}, syntax_.steps.flow().follow(starts, 0)});
    }
  }
}

// The text of a subprogram, and of those that it calls; empty if it stands in another program.
std::vector<KrlSetUps::Span> KrlSetUps::texts_run_by(const std::string& routine) const {
  std::map<std::string, Span> known;
  std::string last;
  for (const KrlSetUp& statement : syntax_.set_ups) {
    if (!begins_krl_routine(statement.word)) continue;
    if (!last.empty()) known[last].second = statement.begin;
    last = name_of(statement);
    known[last] = {statement.begin, src_.size()};
  }
  if (!known.contains(routine)) return {};
  const std::vector<KrlCall> calls = krl_calls(masked(src_, ';', "\""));
  std::vector<std::string> names{routine};
  std::vector<Span> texts;
  for (size_t i = 0; i < names.size(); ++i) {
    const Span text = known.at(names[i]);
    texts.push_back(text);
    for (const KrlCall& call : calls)
      if (text.first <= call.statement && call.statement < text.second &&
          known.contains(call.name) && std::ranges::find(names, call.name) == names.end())
        names.push_back(call.name);
  }
  return texts;
}

// Where it begins it sets nothing.
bool KrlSetUps::may_be_set_by(const std::string& interrupt, Part part,
                              const SettingsInOrder& settings,
                              const std::vector<Span>& texts) const {
  const auto left = neighbours_.leaves.find(interrupt);
  if (texts.empty())
    return left != neighbours_.leaves.end() &&
           left->second[part].kind != HandedFrame::Kind::as_before;
  return std::ranges::any_of(settings[part], [&](const ProgramFlow::Setting& setting) {
    return std::ranges::any_of(texts, [&](const Span& text) {
      return text.first < setting.at && setting.at < text.second;
    });
  });
}

bool KrlSetUps::is_interrupted(size_t part, size_t place) const {
  return std::ranges::any_of(interrupts_[part], [&](const Interrupt& interrupt) {
    const bool is_own = interrupt.own.first <= place && place < interrupt.own.second;
    return !is_own && interrupt.may_run.at(place) != 0;
  });
}

// FDAT_ACT only keeps tool and base; BAS(#FRAMES), BAS(#PTP_PARAMS,..) and BAS(#CP_PARAMS,..) set
// them. Without an FDAT of this program they set what holds already. `kept`: calls of others that
// may change FDAT_ACT.
void KrlSetUps::add_fdats(const ProgramFlow& flow, std::vector<ProgramFlow::Setting> kept,
                          SettingsInOrder& settings) {
  bool is_kept = false;
  for (size_t i = 0; i < syntax_.set_ups.size(); ++i) {
    const KrlSetUp& statement = syntax_.set_ups[i];
    if (statement.word == "FDAT_ACT") {
      is_kept = true;
      kept.push_back({statement.begin, static_cast<int>(i)});
      if (is_without_bas(i)) add(read_fdat(statement, statement.begin), statement, settings);
    } else if (begins_krl_routine(statement.word) && begin_of(statement)[kBase]) {
      kept.push_back({statement.begin, *begin_of(statement)[kBase]});
    }
  }
  if (!is_kept) return;
  for (const auto& [routine, place] : behind_callers_of_) kept.push_back({place - 1, kNoFdat});
  const ProgramFlow::Values fdats = flow.follow(kept, kNoFdat);
  for (const KrlSetUp& statement : syntax_.set_ups) {
    if (!is_bas(statement, {"FRAMES", "PTP_PARAMS", "CP_PARAMS"})) continue;
    const int fdat = fdats.at(statement.begin);
    if (fdat == kUncertain)
      add({kUncertain, kUncertain, kUncertain}, statement, settings);
    else if (fdat != kNoFdat)
      add(read_fdat(syntax_.set_ups[fdat], statement.begin), statement, settings);
  }
}

// Whether no BAS with data of moves stands between an FDAT_ACT and the next move, as in a text that
// was shortened by hand: its FDAT is what the author means.
bool KrlSetUps::is_without_bas(size_t fdat) const {
  const auto next = std::ranges::upper_bound(syntax_.moves, syntax_.set_ups[fdat].begin, {},
                                             [](const KrlMove& move) { return move.begin; });
  const size_t end = next == syntax_.moves.end() ? src_.size() : next->begin;
  for (size_t i = fdat + 1; i < syntax_.set_ups.size(); ++i) {
    const KrlSetUp& statement = syntax_.set_ups[i];
    if (statement.begin > end || begins_krl_routine(statement.word)) return true;
    if (is_bas(statement, {"FRAMES", "PTP_PARAMS", "CP_PARAMS", "PTP_DAT", "CP_DAT"})) return false;
  }
  return true;
}

// BAS(#INITMOV,0) sets $BASE to $WORLD and $TOOL to TOOL_DATA[1]. Where nothing is stated before,
// --base and --tool are what the program runs with. Whether something was added.
bool KrlSetUps::add_initial_frames(SettingsInOrder& settings) {
  bool is_added = false;
  for (const KrlSetUp& statement : syntax_.set_ups) {
    if (!is_bas(statement, {"INITMOV"})) continue;
    const bool is_stated = values_[kBase].at(statement.begin) != kStart[kBase] ||
                           values_[kTool].at(statement.begin) != kStart[kTool];
    if (!is_stated) continue;
    add({number_of("BASE_DATA", 0, statement.begin), number_of("TOOL_DATA", 1, statement.begin),
         kStart[kMode]},
        statement, settings);
    is_added = true;
  }
  return is_added;
}

// Whether it calls BAS with one of these commands.
bool KrlSetUps::is_bas(const KrlSetUp& statement,
                       std::initializer_list<std::string_view> commands) const {
  if (statement.word != "BAS") return false;
  TextCursor cursor(src_, statement.begin, statement.end);
  cursor.take_name();
  return cursor.take('(') && cursor.take('#') && contains(commands, cursor.take_name());
}

// Other programs that call a routine of this one, as routines behind the text.
void KrlSetUps::add_callers(ProgramFlow& flow, SettingsInOrder& settings) {
  size_t place = src_.size();
  for (const auto& [routine, frames] : neighbours_.begins) {
    flow.add(ProgramFlow::Step::routine, ++place);
    for (size_t part = 0; part < frames.size(); ++part) {
      settings[part].push_back({place, handed(frames[part], part)});
    }
    flow.add(ProgramFlow::Step::call, ++place, routine);
    behind_callers_of_[routine] = place;
    flow.add(ProgramFlow::Step::end_routine, ++place);
  }
}

// A function in an expression may run at any place of its statement.
void KrlSetUps::add_what_others_leave(SettingsInOrder& settings,
                                      std::vector<ProgramFlow::Setting>& fdats) {
  if (neighbours_.leaves.empty()) return;
  for (const KrlCall& call : krl_calls(masked(src_, ';', "\""))) {
    const auto found = neighbours_.leaves.find(call.name);
    if (found == neighbours_.leaves.end()) continue;
    for (size_t part = 0; part < found->second.size(); ++part) {
      const HandedFrame& frame = found->second[part];
      if (frame.kind == HandedFrame::Kind::as_before) continue;
      settings[part].push_back(
          {call.place(), call.is_statement ? handed(frame, part) : kUncertain});
      fdats.push_back({call.place(), kNoFdat});
    }
  }
}

// The value of what another program hands on. Its name may mean another frame here.
int KrlSetUps::handed(const HandedFrame& frame, size_t part) {
  if (frame.kind == HandedFrame::Kind::several) return kUncertain;
  if (frame.kind == HandedFrame::Kind::calculated) return kCalculated;
  if (frame.kind == HandedFrame::Kind::as_before) return kStart[part];
  if (part == kMode) return frame.name == "#TCP" ? 1 : frame.name == "#BASE" ? 0 : kAnyMode;
  const bool means_the_same =
      is_krl_frame_list(frame.name) && !syntax_.set_frames.contains(frame.name);
  int index = means_the_same ? add_name(frame.name, 0) : -1;
  const auto is_it = [&] {
    return index >= 0 &&
           (!frame.pose || (frames_[index].is_known && is_same(*frame.pose, frames_[index].pose)));
  };
  for (int number = 1; !is_it(); ++number)
    index = add(fmt::format("{} of another program{}", frame.name,
                            number == 1 ? "" : fmt::format(" ({})", number)),
                frame.pose);
  return index;
}

HandedFrame KrlSetUps::as_handed(int value, size_t part) const {
  using enum HandedFrame::Kind;
  if (value == kUncertain) return {several, "", {}};
  if (value == kCalculated) return {calculated, "", {}};
  if (part == kMode) {
    if (value == kAnyMode) return {};
    return {stated, value == 1 ? "#TCP" : "#BASE", {}};
  }
  if (value == kStart[part]) return {};
  const ProgramFrame& frame = frames_[value];
  if (frame.is_known) return {stated, frame.name, frame.pose};
  // A calculated value may differ at each calculation.
  if (is_krl_frame_list(frame.name)) return {stated, frame.name, {}};
  return {calculated, "", {}};
}

HandedFrames KrlSetUps::all_as_handed(size_t place) const {
  HandedFrames frames;
  for (size_t part = 0; part < values_.size(); ++part)
    frames.push_back(
        as_handed(is_interrupted(part, place) ? kUncertain : values_[part].at(place), part));
  return frames;
}

HandedFrames KrlSetUps::handed_on(size_t statement) const {
  return all_as_handed(before_statement(statement));
}

HandedFrames KrlSetUps::left_by(const std::string& routine) const {
  return all_as_handed(behind_callers_of_.at(routine));
}

HandedFrames KrlSetUps::any_frames() { return {{}, {}, {HandedFrame::Kind::stated, "", {}}}; }

// The frames with which a subprogram begins that nothing here calls, or that an interrupt calls.
KrlSetUps::Settings KrlSetUps::begin_of(const KrlSetUp& definition) const {
  const std::string name = name_of(definition);
  if (syntax_.steps.interrupts().contains(name)) return {kUncertain, kUncertain, kStart[kMode]};
  if (const auto handed = neighbours_.begins.find(name); handed != neighbours_.begins.end())
    return handed->second == any_frames() ? Settings{kStart[kBase], kStart[kTool], kAnyMode}
                                          : Settings{};
  if (syntax_.steps.called().contains(name)) return {};
  return {kStart[kBase], kStart[kTool], kStart[kMode]};
}

std::string KrlSetUps::name_of(const KrlSetUp& definition) const {
  return krl_head(src_, {definition.line, definition.begin, definition.end})->name;
}

// A subprogram that nothing here calls, and that states no frames, has those of a caller elsewhere;
// if the text states frames before it, they are hardly those of --base and --tool.
void KrlSetUps::leave_subprograms(List& list) const {
  const auto is_stated = [](const SetUp& set_up) { return set_up.base >= 0 || set_up.tool >= 0; };
  bool is_stated_before = false, is_stated_here = false;
  size_t next = 0;
  for (size_t i = 0; i < syntax_.moves.size(); ++i) {
    for (; next < syntax_.moves[i].set_ups; ++next) {
      if (begins_krl_routine(syntax_.set_ups[next].word)) {
        is_stated_before |= is_stated_here;
        is_stated_here = false;
      }
      is_stated_here |= is_stated(list.behind[next + 1]);
    }
    SetUp& here = list.of_moves[i];
    here.is_uncertain |= is_stated_before && !is_stated_here && !is_stated(here);
  }
}

KrlSetUps::SetUp KrlSetUps::at(size_t place, const Settings& of_move) const {
  std::array<int, 3> settings{};
  bool may_be_interrupted = false;
  for (size_t part = 0; part < settings.size(); ++part) {
    settings[part] = of_move[part].value_or(values_[part].at(place));
    may_be_interrupted |= !of_move[part] && is_interrupted(part, place);
  }
  if (may_be_interrupted) return {-1, -1, settings[kMode] == 1, true, false, true};
  const bool is_calculated = std::ranges::find(settings, kCalculated) != settings.end();
  const bool is_uncertain = std::ranges::find(settings, kUncertain) != settings.end();
  if (!is_calculated && !is_uncertain)
    return {settings[kBase], settings[kTool], settings[kMode] == 1};
  return {-1, -1, settings[kMode] == 1, true, is_calculated};
}

KrlSetUps::Settings KrlSetUps::with_of(const KrlMove& move) {
  Settings settings;
  if (const auto& block = move.spline_block)
    read_with(block->begin, block->end, block->line, settings);
  read_with(move.keyword_end, move.end, move.line, settings);
  return settings;
}

KrlSetUps::Settings KrlSetUps::set_by(const KrlSetUp& statement) {
  const std::string& word = statement.word;
  Settings settings;
  if (word == "BAS")
    read_bas(compact(text(statement.begin, statement.end)), statement.begin, settings);
  else if (word[0] == '$')
    assign(word, statement.begin, statement.end, statement.line, settings);
  return settings;
}

// An external kinematic system carries the base that BAS(#EX_BASE,n) sets.
void KrlSetUps::read_bas(const std::string& spelled, size_t at, Settings& settings) {
  if (spelled.starts_with("BAS(#EX_BASE,")) settings[kBase] = add(spelled, std::nullopt);
  for (const Part part : {kBase, kTool}) {
    const std::string begin = part == kTool ? "BAS(#TOOL," : "BAS(#BASE,";
    if (!spelled.starts_with(begin)) continue;
    const char* const list = part == kTool ? "TOOL_DATA" : "BASE_DATA";
    std::string number = spelled.substr(begin.size());
    if (number.ends_with(')')) number.pop_back();
    settings[part] = number_in(list, number, spelled, at);
  }
}

// `number`: of a frame of a list, also a variable. `spelled`: what to name where it is not known.
int KrlSetUps::number_in(const char* list, const std::string& number, const std::string& spelled,
                         size_t at) {
  constexpr double kMost = 1000;
  const std::optional<double> value = syntax_.variables->number_at(number, at);
  if (!value || *value != std::floor(*value) || !(std::abs(*value) < kMost))
    return add_not_followed(spelled);
  return number_of(list, static_cast<int>(*value), at);
}

// An FDAT as it is declared, or with the value that the text gives it.
std::optional<KrlFdat> KrlSetUps::fdat_at(const std::string& name, size_t place) const {
  const auto declared = syntax_.fdats.find(name);
  return declared != syntax_.fdats.end() ? declared->second
                                         : syntax_.variables->fdat_at(name, place);
}

// FDAT_ACT=FP1, FDAT_ACT={TOOL_NO 1,BASE_NO 3,IPO_FRAME #BASE}. `place`: where it takes effect.
KrlSetUps::Settings KrlSetUps::read_fdat(const KrlSetUp& statement, size_t place) {
  const std::string spelled = compact(text(statement.begin, statement.end));
  const std::string value(behind_equals(spelled));
  TextCursor cursor(src_, src_.find('=', statement.begin) + 1, statement.end);
  Settings settings;
  if (!spelled.starts_with("FDAT_ACT="))
    set_not_followed("FDAT_ACT", settings);
  else
    set_fdat(value, cursor.next() == '{' ? take_krl_fdat(cursor) : fdat_at(value, statement.begin),
             {statement.line, place}, settings);
  return settings;
}

// `name`: of the FDAT, or what states it.
void KrlSetUps::set_fdat(const std::string& name, const std::optional<KrlFdat>& fdat,
                         const Statement& statement, Settings& settings) {
  if (name.empty()) return;
  if ((!fdat || !fdat->tool || !fdat->base) && syntax_.changed.contains(name))
    return set_not_followed(name, settings);
  if (!fdat || !fdat->tool || !fdat->base) {
    if (undeclared_.emplace(statement.line, name).second)
      warnings_.add(statement.line, "the tool and base of '" + name + "' are not declared as FDAT");
    settings[kTool] = add("TOOL_DATA[" + name + ".TOOL_NO]", std::nullopt);
    settings[kBase] = add("BASE_DATA[" + name + ".BASE_NO]", std::nullopt);
    return;
  }
  settings[kTool] = number_of("TOOL_DATA", *fdat->tool, statement.begin);
  settings[kBase] = number_of("BASE_DATA", *fdat->base, statement.begin);
  settings[kMode] = fdat->is_external_tcp ? 1 : 0;
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
  const std::string spelled = compact(text(begin, end));
  const std::string value(behind_equals(spelled));
  if (value.empty()) return;
  if (name == "$IPO_MODE") {
    const std::string name_of_fdat = fdat_of(value);
    const auto fdat = fdat_at(name_of_fdat, begin);
    settings[kMode] = value == "#TCP" || (fdat && fdat->is_external_tcp) ? 1 : 0;
    if (!fdat && syntax_.changed.contains(name_of_fdat)) settings[kMode] = kUncertain;
    return;
  }
  const Part part = name == "$TOOL" ? kTool : kBase;
  std::optional<int>& setting = settings[part];
  if (!spelled.starts_with(name + "=")) {
    setting = with_component(part, spelled, begin);
  } else if (const std::string fdat = fdat_of(value); !fdat.empty()) {
    Settings of_fdat;
    set_fdat(fdat, fdat_at(fdat, begin), {line, begin}, of_fdat);
    if (of_fdat[kMode] == 1) settings[kMode] = 1;
    setting = of_fdat[part];
  } else if (const auto kept = kept_in(value, part, begin)) {
    setting = kept;
  } else {
    setting = frame_of(src_.find('=', begin) + 1, end, begin);
  }
}

// $BASE.Z=5, $BASE.Z=$BASE.Z+15.
int KrlSetUps::with_component(Part part, const std::string& spelled, size_t place) {
  if (is_given_frame(known_, spelled)) return add(spelled, std::nullopt);
  const int held = held_before(part, place);
  if (held >= 0 && !frames_[held].is_known && !not_followed_.contains(held)) return held;
  const std::string component = spelled.substr(0, spelled.find('='));
  const size_t point = component.find('.');
  const int index = point == std::string::npos ? -1 : krl_component(component.substr(point + 1));
  if (held == kUncertain || not_followed_.contains(held) || index < 0 || index > 5)
    return add_not_followed(spelled);
  const Eigen::Vector3d abc = abc_from_rotation(frames_[held].pose.rotation);
  KrlFrame frame;
  frame.values.head<3>() = frames_[held].pose.translation;
  frame.values.segment<3>(3) = abc;
  std::string value(behind_equals(spelled));
  const bool is_sum = value.starts_with(component);
  if (is_sum) value.replace(0, component.size(), "0");
  const std::optional<double> number = syntax_.variables->number_at(value, place);
  const bool is_scaled = is_sum && value.size() > 1 && value[1] != '+' && value[1] != '-';
  if (!number || is_scaled) return add_not_followed(spelled);
  frame.values[index] = (is_sum ? frame.values[index] : 0) + *number * krl_unit(index);
  return add_value(frames_[held].name + " with " + component, *krl_pose(frame));
}

// The value before a statement.
int KrlSetUps::held_at(Part part, size_t place) {
  depends_on_itself_ = true;
  return is_followed_ ? values_[part].at(before_statement(place)) : kUncertain;
}

// The frame before a statement; kUncertain if it is not known.
int KrlSetUps::held_before(Part part, size_t place) {
  const int held = held_at(part, place);
  return held < 0 ? kUncertain : held;
}

// `place`: of the statement that sets it.
int KrlSetUps::frame_of(size_t begin, size_t end, size_t place) {
  TextCursor cursor(src_, begin, end);
  const std::string spelled = compact(text(begin, end));
  const std::vector<Statement> factors = split_arguments(src_, begin, end, ":");
  if (factors.size() > 1) return product_of(factors, spelled, place);
  if (cursor.next() == '{') {
    const KrlAggregate aggregate = take_krl_aggregate(cursor);
    if (aggregate.kind == KrlAggregateKind::frame && cursor.done())
      return add(spelled, krl_pose(aggregate.frame));
    return add_not_followed(spelled);
  }
  if (spelled == "$BASE" || spelled == "$TOOL") {
    const int held = held_before(spelled == "$TOOL" ? kTool : kBase, place);
    return held == kUncertain ? add_not_followed(spelled) : held;
  }
  if (spelled == "$NULLFRAME" || spelled == "$WORLD") return add(spelled, Pose{});
  for (const char* const list : {"BASE_DATA", "TOOL_DATA"})
    if (spelled.starts_with(std::string(list) + "[") && spelled.ends_with(']')) {
      const size_t from = std::string_view(list).size() + 1;
      return number_in(list, spelled.substr(from, spelled.size() - from - 1), spelled, place);
    }
  return add_name(spelled, place);
}

// BASE_DATA[1]:{X 0,Y 0,Z 10,A 0,B 0,C 0}. If a factor is not known, that one.
int KrlSetUps::product_of(const std::vector<Statement>& factors, const std::string& spelled,
                          size_t place) {
  if (is_given_frame(known_, spelled)) return add(spelled, std::nullopt);
  Pose product;
  std::string name;
  for (const Statement& factor : factors) {
    const int index = frame_of(factor.begin, factor.end, place);
    if (not_followed_.contains(index)) return add_not_followed(spelled);
    if (index == kUncertain || !frames_[index].is_known) return index;
    product = product * frames_[index].pose;
    name += (name.empty() ? "" : ":") + frames_[index].name;
  }
  return add(name, product);
}

// With the value that this program gives it: the only one, or the one that it has at a place.
int KrlSetUps::add_name(const std::string& name, size_t place) {
  if (name == "BASE_DATA[0]" || name == "TOOL_DATA[0]") return add(name, Pose{});
  if (const auto set = syntax_.set_frames.find(name);
      set != syntax_.set_frames.end() && !is_given_frame(known_, name))
    return value_at(name, set->second, place);
  if (const auto found = syntax_.frame_names.find(name); found != syntax_.frame_names.end())
    return add(name, krl_pose(syntax_.frames[found->second]));
  if (is_given_frame(known_, name)) return add(name, std::nullopt);
  if (const auto value = syntax_.variables->value_at(name, place))
    if (const auto pose = krl_pose(value->point)) return add_value(name, *pose);
  TextCursor cursor(name, 0, name.size());
  const bool may_change = syntax_.changed.contains(cursor.take_name());
  if (cursor.next() == '[') cursor.skip_to("]");
  cursor.take(']');
  // One of a list is the one that --frame states, whatever sets it in part.
  const bool is_calculated = !cursor.done() || (may_change && !is_krl_frame_list(name));
  return is_calculated ? add_not_followed(name) : add(name, std::nullopt);
}

// kUncertain if it is not certain, and where it has what the controller has before the program.
int KrlSetUps::value_at(const std::string& name, const KrlSetFrame& frame, size_t place) {
  const auto [values, is_new] = of_set_frames_.try_emplace(name);
  if (!is_new) return values->second.at(place);
  const auto add_frame_of = [&](int index) {
    return add_value(name, *krl_pose(syntax_.frames[index]));
  };
  const int before = frame.before < 0 ? kUncertain : add_frame_of(frame.before);
  std::vector<ProgramFlow::Setting> settings;
  for (const int index : frame.values)
    settings.push_back({syntax_.frames[index].begin, add_frame_of(index)});
  for (const size_t call : frame.lost_at) settings.push_back({call, kUncertain});
  values->second = syntax_.steps.flow().follow(settings, before);
  return values->second.at(place);
}

// OLD=$BASE keeps a frame, and $BASE=OLD sets it again; kStart if the program did not set it
// before.
std::optional<int> KrlSetUps::kept_in(const std::string& name, Part part, size_t place) {
  if (is_given_frame(known_, name)) return std::nullopt;
  const std::string keeping = name + (part == kTool ? "=$TOOL" : "=$BASE");
  std::vector<ProgramFlow::Setting> settings;
  bool keeps_any = false;
  for (const KrlChange& change : syntax_.variables->changes_of(name)) {
    const bool keeps = change.is_assignment && compact(text(change.begin, change.end)) == keeping;
    settings.push_back({change.begin, keeps ? held_at(part, change.begin) : kUncertain});
    keeps_any |= keeps;
  }
  if (!keeps_any) return std::nullopt;
  const int kept = syntax_.steps.flow().follow(settings, kUncertain).at(place);
  return kept == kUncertain ? std::nullopt : std::optional(kept);
}

int KrlSetUps::number_of(const char* list, int number, size_t place) {
  return add_name(fmt::format("{}[{}]", list, number), place);
}

int KrlSetUps::add(const std::string& name, const std::optional<Pose>& pose) {
  return add_frame(frames_, known_, name, pose);
}

// One of several poses of a name; each has one name.
int KrlSetUps::add_value(const std::string& name, const Pose& pose) {
  std::map<std::vector<double>, int>& known = values_of_names_[name];
  std::vector<double> numbers(pose.rotation.reshaped().begin(), pose.rotation.reshaped().end());
  numbers.insert(numbers.end(), pose.translation.begin(), pose.translation.end());
  const auto [value, is_other] = known.try_emplace(std::move(numbers), kUncertain);
  if (is_other)
    value->second =
        add(known.size() == 1 ? name : fmt::format("{} (value {})", name, known.size()), pose);
  return value->second;
}

// A frame that the program calculates: moves in it are left, unless --frame gives it.
int KrlSetUps::add_not_followed(const std::string& spelled) {
  const int frame = add(spelled, std::nullopt);
  if (!frames_[frame].is_known) not_followed_.insert(frame);
  return frame;
}

void KrlSetUps::set_not_followed(const std::string& fdat, Settings& settings) {
  settings[kTool] = add_not_followed("TOOL_DATA[" + fdat + ".TOOL_NO]");
  settings[kBase] = add_not_followed("BASE_DATA[" + fdat + ".BASE_NO]");
}

std::string KrlSetUps::not_followed(const SetUp& set_up) const {
  for (const int frame : {set_up.base, set_up.tool})
    if (not_followed_.contains(frame)) return frames_[frame].name;
  return "";
}

std::string_view KrlSetUps::text(size_t begin, size_t end) const {
  return std::string_view(src_).substr(begin, end - begin);
}

}  // namespace armtrue
