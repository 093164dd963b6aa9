#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "programs/frame_list.h"
#include "programs/move_reader.h"
#include "programs/statement.h"
#include "programs/yaskawa/inform_flow.h"
#include "programs/yaskawa/inform_job.h"
#include "programs/yaskawa/inform_listing.h"
#include "programs/yaskawa/inform_parts.h"
#include "programs/yaskawa/inform_positions.h"

// Jobs of Yaskawa controllers, JBI files: "INFORM manual" and "Interface with an easy offline
// teaching system" of NX100, DX100 and later: positions of //POS, instructions of //INST.

namespace armtrue {
namespace {

// What begins a line that leaves the arm where it is and does not branch.
bool stands_between_inform_moves(const std::string& word) {
  return contains(
      {"",      "NOP",   "DOUT", "DIN",   "AOUT",    "PULSE", "TIMER", "WAIT",   "SET",   "SETE",
       "GETE",  "GETS",  "ADD",  "SUB",   "MUL",     "DIV",   "INC",   "DEC",    "CLEAR", "AND",
       "OR",    "NOT",   "XOR",  "SPEED", "ADVINIT", "MSG",   "ARCON", "ARCOF",  "WVON",  "WVOF",
       "SFTON", "SFTOF", "REFP", "CNVRT", "MSHIFT",  "CVAR",  "HAND",  "TOOLON", "TOOLOF"},
      word);
}

// Words of a move that may stand in an inserted one, too: speeds and accelerations.
bool is_speed_option(const std::string& word) {
  return contains({"V", "VR", "VE", "ACC", "DEC"}, word);
}

// A move as it stands in the job.
struct InformMove {
  Statement statement;
  char kind = 'J';  // J, L, C, S
  std::string position;
  std::string station, base;   // positions of the axes that move with it
  size_t begin = 0, end = 0;   // of the name of its position
  double blend = 0;            // [m], of CR
  bool stops = false;          // PL=0
  bool is_end_of_arc = false;  // FPT
  bool is_external = false;    // other axes than the robot's move
  bool ends_elsewhere = false;
  std::string obstacle;  // to points before it
  std::string why_not;   // followed; empty if it is
  bool follows = false;  // the arm stands at the target before

  void is_not_because(const std::string& reason) {
    if (why_not.empty()) why_not = reason;
  }
};

class InformReader : MoveReader {
 public:
  InformReader(RobotProgram& program, const KnownFrames& known, TargetParts parts)
      : MoveReader(program),
        known_(known),
        parts_(parts),
        original_(program.texts[0].text),
        text_(masked(original_, '\'', "\"")) {}

  void read() {
    find_name();
    const size_t instructions = inform_instructions(text_);
    for (size_t i = program_.own_texts; i < program_.texts.size(); ++i)
      if (is_inform_listing(program_.texts[i].name))
        read_inform_listing(program_.texts[i].text, listing_);
    const auto robot = inform_robot(text_);
    positions_ = inform_positions(std::string_view(text_).substr(0, instructions),
                                  robot ? listing_.pulses_of(*robot) : nullptr);
    const std::vector<Statement> statements = inform_lines(text_, instructions);
    flow_ = follow_inform(text_, statements);
    for (const Statement& statement : statements) {
      note_inform_changes(text_, statement, true, changes_);
      if (!is_inform_move(first_word(text_, statement))) keep_positions(statement);
    }
    read_others(statements);
    for (const Statement& statement : statements) read_statement(statement);
    end_arcs();
    for (const auto& [name, position] : positions_)
      if (position.point >= 0 && kept_.contains(name))
        program_.points[position.point].is_shared = true;
    program_.warnings = warnings_.list();
  }

 private:
  void find_name() {
    const size_t line = line_that_begins(text_, "//NAME");
    if (line == std::string::npos) return;
    TextCursor cursor(text_, line + 6, std::min(text_.find('\n', line), text_.size()));
    cursor.next();
    const size_t begin = cursor.at();
    size_t end = std::min(text_.find('\n', begin), text_.size());
    while (end > begin && is_blank(text_[end - 1])) --end;
    if (end > begin) program_.names.push_back({0, begin, end});
  }

  static std::string first_word(std::string_view text, const Statement& statement) {
    return TextCursor(text, statement.begin, statement.end).take_name();
  }

  // Another job of the folder.
  struct OtherJob {
    std::string text;  // by masked()
    std::vector<Statement> statements;
    bool is_called = false;
  };

  // Variables are common to all jobs, so any job may set one; frames count if this job or one that
  // it calls sets them. A called job without a text may set anything.
  void read_others(const std::vector<Statement>& statements) {
    std::multimap<std::string, OtherJob> others;  // by their names
    for (size_t i = program_.own_texts; i < program_.texts.size(); ++i) {
      OtherJob other{masked(program_.texts[i].text, '\'', "\""), {}};
      const auto name = inform_job_name(other.text);
      if (!name) continue;
      other.statements = inform_lines(other.text, inform_instructions(other.text));
      others.emplace(*name, std::move(other));
    }
    note_calls(text_, statements, others);
    for (const auto& [name, other] : others)
      for (const Statement& statement : other.statements)
        note_inform_changes(other.text, statement, other.is_called, changes_);
  }

  void note_calls(std::string_view text, const std::vector<Statement>& statements,
                  std::multimap<std::string, OtherJob>& others) {
    for (const Statement& statement : statements)
      for (const std::string& name : inform_calls(text, statement)) {
        const auto [begin, end] = others.equal_range(name);
        calls_ |= begin == end;
        for (auto other = begin; other != end; ++other)
          if (!std::exchange(other->second.is_called, true))
            note_calls(other->second.text, other->second.statements, others);
      }
  }

  // Positions that anything but a followed move uses must stay.
  void keep_positions(const Statement& statement) {
    each_word(text_, statement, [&](const std::string& word, size_t, const TextCursor&) {
      if (std::string name = inform_position_name(word); !name.empty())
        kept_.insert(std::move(name));
    });
  }

  void read_statement(const Statement& statement) {
    TextCursor cursor(text_, statement.begin, statement.end);
    if (cursor.next() == '*') {
      return interrupt();
    }
    const std::string word = cursor.take_name();
    may_run_ = flow_.steps.leads_to(statement.begin);
    if (is_inform_move(word)) return read_move(word, statement);
    if (is_other_inform_motion(word)) {
      leave(statement.line,
            word == "IMOV" ? "a relative move (IMOV)" : "this function is not followed: " + word);
      return interrupt();
    }
    if (!stands_between_inform_moves(word)) interrupt();
  }

  // The arm may come to the next move from elsewhere.
  void interrupt() {
    end_arcs();
    follows_ = false;
  }

  void leave(int line, const std::string& reason) { leave_move(line, reason, may_run_); }

  // What the words of a move say.
  InformMove move_of(const std::string& word, const Statement& statement) const {
    InformMove move;
    move.statement = statement;
    // The way of a coordinated move depends on the station. Where it ends does not: a user frame
    // stands in the room, and MTOOL is another type of position.
    const bool is_coordinated = word[0] == 'S';
    move.kind = is_coordinated ? 'J' : word.back();
    move.follows = follows_;
    each_word(text_, statement, [&](const std::string& part, size_t at, TextCursor& cursor) {
      if (at == statement.begin) return;
      const std::string name = inform_position_name(part);
      if (!name.empty()) {
        if (!move.position.empty()) return move.is_not_because("another robot moves with it");
        move.position = name;
        move.begin = at;
        move.end = cursor.at();
      } else if (part == "LP" || part == "P" || (part.starts_with("LP") && is_digit(part.back()))) {
        move.is_not_because("its point is a variable that is set as the job runs");
      } else if (is_numbered(part, "BC") || is_numbered(part, "BP")) {
        move.is_external = true;
        move.base = part;
      } else if (is_numbered(part, "EC") || is_numbered(part, "EX")) {
        move.is_external = true;
        move.station = inform_station_name(part);
      } else if (part == "CR" && cursor.take('=')) {
        move.blend = cursor.take_number().value_or(0) * kMillimetre;
      } else if (part == "PL") {
        cursor.take('=');
        move.stops = cursor.take_number().value_or(1) == 0;
      } else if (part == "FPT") {
        move.is_end_of_arc = true;
      } else if (part == "UNTIL") {
        move.ends_elsewhere = true;
        move.obstacle = "it has the option UNTIL";
      } else if (!is_inform_move(part) && !is_speed_option(part)) {
        move.obstacle = "it has the option " + part;
      }
    });
    if (move.is_external) move.obstacle = "external axes move with it";
    return move;
  }

  void read_move(const std::string& word, const Statement& statement) {
    InformMove move = move_of(word, statement);
    if (move.position.empty()) {
      if (move.is_external && move.why_not.empty()) return;  // a station alone
      move.is_not_because("its point does not stand in the job");
    }
    if (const int shift = flow_.shift.at(statement.begin); shift != 0)
      move.is_not_because(shift == 1 ? "its point is shifted (SFTON)"
                                     : "its point may be shifted (SFTON)");
    if (move.why_not.empty()) move.why_not = why_not_usable(move.position);
    if (move.why_not.empty() && !move.base.empty() &&
        positions_.at(move.position).kind == InformPosition::Kind::pose)
      move.why_not = "the base moves with it (" + move.base + ")";
    const bool is_left = !move.why_not.empty();
    if (move.kind == 'C' && is_left) leave_arc();
    if (move.kind != 'C' || is_left) end_arcs();
    follows_ = !is_left && !move.ends_elsewhere;
    if (is_left) {
      keep_positions(statement);
      leave(statement.line, move.why_not);
    } else if (move.kind == 'C') {
      arcs_.push_back(move);
      if (move.ends_elsewhere || move.is_end_of_arc)
        end_arcs(move.is_end_of_arc && !move.ends_elsewhere);
    } else {
      add(move, move.kind == 'L' ? MotionKind::line : MotionKind::joint);
    }
  }

  static bool is_numbered(const std::string& word, const char* begin) {
    return word.size() > 2 && word.starts_with(begin) && is_digit(word.back());
  }

  // If one of its points is left alone, all points after its start are, too.
  void leave_arc() {
    const size_t first = std::min<size_t>(starts_arc_ ? 0 : 1, arcs_.size());
    for (size_t i = first; i < arcs_.size(); ++i) {
      keep_positions(arcs_[i].statement);
      leave(arcs_[i].statement.line, "another point of its arc is left alone");
    }
    arcs_.resize(first);
  }

  // MOVC stands at each of three points: a line leads to the first, the second is the auxiliary
  // point. With more of them, without FPT, the way is not that of arcs. `goes_on`: the last one
  // also begins the next arc.
  void end_arcs(bool goes_on = false) {
    const std::vector<InformMove> run = std::exchange(arcs_, {});
    const size_t first = starts_arc_ ? 0 : 1;  // behind FPT the arm stands at the first point
    for (size_t i = 0; i < run.size(); ++i) {
      const bool is_arc = run.size() == first + 2;
      add(run[i], i < first ? MotionKind::line
                  : !is_arc ? MotionKind::joint
                            : (i == first ? MotionKind::via : MotionKind::arc));
    }
    starts_arc_ = goes_on;
  }

  // Why a move to a position cannot be followed; empty if it can.
  std::string why_not_usable(const std::string& name) {
    const auto found = positions_.find(name);
    if (name[0] == 'P') {
      if (found == positions_.end())
        return "its point is a variable whose value does not stand in the job";
      if (changes_.is_any_variable || changes_.variables.contains(name))
        return "its point is a variable that is set as the job runs, by it or by another one of "
               "its folder";
      if (calls_) return "its point is a variable that a job which it calls may set";
    }
    if (found == positions_.end()) return "its position does not stand in //POS";
    InformPosition& position = found->second;
    if (!position.why_not.empty()) return position.why_not;
    if (position.kind == InformPosition::Kind::pose && parts_ == TargetParts::pose) {
      if (position.user && is_changed(changes_.users, *position.user))
        return fmt::format("USER[{}] is set as the job runs (MFRAME)", *position.user);
      if (position.tool && is_changed(changes_.tools, *position.tool))
        return fmt::format("TOOL[{}] is set as the job runs (SETTOOL)", *position.tool);
    }
    if (position.point < 0) add_point(name, position);
    return "";
  }

  static bool is_changed(const std::set<int>& changed, int number) {
    return changed.contains(number) || changed.contains(InformChanges::kAnyFrame);
  }

  void add_point(const std::string& name, InformPosition& position) {
    ProgramPoint point;
    point.name =
        original_.substr(position.begin, original_.find('=', position.begin) - position.begin);
    point.line = position.line;
    point.kind =
        position.kind == InformPosition::Kind::joints ? TargetKind::joints : TargetKind::cartesian;
    point.numbers = position.numbers;
    point.counts_per_unit = position.pulses_per_degree;
    point.begin = position.begin;
    point.end = position.end;
    point.is_shared = name[0] == 'P';  // other jobs use it, too
    position.point = static_cast<int>(program_.points.size());
    program_.points.push_back(point);
  }

  void add(const InformMove& move, MotionKind motion) {
    const InformPosition& position = positions_.at(move.position);
    ProgramTarget target;
    target.line = move.statement.line;
    target.begin = move.begin;
    target.end = move.end;
    target.motion = motion;
    target.blend = move.blend;
    target.is_passed = !move.stops;
    target.turning = ArcTurning::perhaps_through_via;
    target.never_runs = !may_run_;
    target.follows_target =
        motion == MotionKind::arc || (move.follows && motion != MotionKind::joint);
    if (position.kind == InformPosition::Kind::pose) {
      const bool is_straight = move.kind != 'J';
      target.configuration = position.configuration;
      target.configuration.continues = is_straight && move.follows;
      target.configuration.is_weak = is_straight && !move.follows;
    }
    if (position.user)
      target.base = add_frame(program_.frames, known_, fmt::format("USER[{}]", *position.user),
                              pose_of(listing_.user(*position.user)));
    if (position.tool)
      target.tool = add_frame(program_.frames, known_, fmt::format("TOOL[{}]", *position.tool),
                              pose_of(listing_.tool(*position.tool)));
    if (motion == MotionKind::arc)
      target.obstacle = "an arc of MOVC is not divided";
    else if (motion == MotionKind::line)
      prepare_insertion(move, position, target);
    note_other_axes(move.station, "station axis", target);
    note_other_axes(inform_station_name(move.base), "base axis", target);
    add_target_at(std::move(target), position.point);
  }

  std::optional<Pose> pose_of(const std::optional<std::vector<double>>& numbers) const {
    if (!numbers) return std::nullopt;
    return program_.dialect->pose_of_numbers(*numbers);
  }

  void note_other_axes(const std::string& name, const char* kind, ProgramTarget& target) const {
    const auto position = positions_.find(name);
    if (position == positions_.end()) return;
    for (size_t i = 0; i < position->second.numbers.size(); ++i)
      target.other_axes[fmt::format("{} {}", kind, i + 1)] = position->second.numbers[i].value;
  }

  void prepare_insertion(const InformMove& move, const InformPosition& position,
                         ProgramTarget& target) const {
    target.obstacle = move.obstacle;
    if (position.kind == InformPosition::Kind::joints)
      target.obstacle = "its point is joint angles";
    if (move.kind == 'C') target.obstacle = "an arc begins at its end";
    if (!target.obstacle.empty()) return;
    ProgramInsertion& beside = target.insertion;
    beside.at = line_begin(original_, move.statement.begin);
    beside.before = original_.substr(beside.at, move.begin - beside.at);
    beside.behind = without_passing(original_.substr(move.end, move.statement.end - move.end));
    beside.line_end = line_end(original_, beside.at);
  }

  // The rest of a move without how exactly it passes its point (PL, CR).
  static std::string without_passing(std::string rest) {
    while (!rest.empty() && is_blank(rest.back())) rest.pop_back();
    const Statement whole{0, 0, rest.size()};
    std::vector<std::pair<size_t, size_t>> places;
    each_word(rest, whole, [&](const std::string& word, size_t at, TextCursor& cursor) {
      if (word != "PL" && word != "CR") return;
      cursor.take('=');
      cursor.take_number();
      places.emplace_back(at, cursor.at());
    });
    for (auto place = places.rbegin(); place != places.rend(); ++place) {
      size_t begin = place->first;
      while (begin > 0 && is_blank(rest[begin - 1])) --begin;
      rest.erase(begin, place->second - begin);
    }
    return rest;
  }

  const KnownFrames& known_;
  const TargetParts parts_;
  const std::string original_;
  const std::string text_;
  InformListing listing_;
  std::map<std::string, InformPosition> positions_;
  InformFlow flow_;
  InformChanges changes_;         // of variables, and of frames and tools
  std::set<std::string> kept_;    // positions that must stay
  bool calls_ = false;            // jobs that are not there
  std::vector<InformMove> arcs_;  // MOVC one after the other
  bool starts_arc_ = false;       // the arm stands at the end of an arc that FPT ended
  bool may_run_ = true;           // the statement; else no way leads to it
  bool follows_ = false;          // the arm stands at the last target
};

}  // namespace

void parse_inform_program(RobotProgram& program, const KnownFrames& known, TargetParts parts) {
  InformReader(program, known, parts).read();
}

}  // namespace armtrue
