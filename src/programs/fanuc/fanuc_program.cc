#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "armtrue/kinematics/units.h"
#include "programs/dialects.h"
#include "programs/fanuc/fanuc_assignments.h"
#include "programs/fanuc/fanuc_flow.h"
#include "programs/fanuc/fanuc_frames.h"
#include "programs/fanuc/fanuc_parts.h"
#include "programs/fanuc/fanuc_positions.h"
#include "programs/fanuc/fanuc_registers.h"
#include "programs/fanuc/fanuc_text.h"
#include "programs/fanuc/fanuc_words.h"
#include "programs/frame_list.h"
#include "programs/move_reader.h"
#include "programs/statement.h"

// Teach pendant programs of FANUC controllers as LS files: R-30iB operator's manual, "Motion
// instructions" and "Position data": /PROG, /MN with J, L, C and A moves, /POS.

namespace armtrue {
namespace {

// What begins a line that leaves the arm where it is and does not branch.
bool stands_between_fanuc_moves(const std::string& word) {
  return word.empty() ||
         contains({"DO",    "RO",      "AO",       "GO",         "SO",        "WO",
                   "UO",    "F",       "R",        "SR",         "PR",        "P",
                   "TIMER", "WAIT",    "OVERRIDE", "UFRAME_NUM", "UTOOL_NUM", "UFRAME",
                   "UTOOL", "PAYLOAD", "MESSAGE",  "UALM"},
                  word) ||
         word[0] == '$';
}

// Words of a motion instruction that may stand in an inserted one too: speeds over the way and how
// the point is passed. All others act once (SKIP, TB, DB, CALL), or are about time.
bool may_be_repeated(const std::string& word) {
  return contains({"L", "MM", "CM", "INCH", "DEG", "MIN", "SEC", "ACC", "PTH", "WJNT", "FINE",
                   "CNT", "MAX_SPEED", "WELD_SPEED", "R"},
                  word);
}

constexpr const char* kFanucPose[] = {"X", "Y", "Z", "W", "P", "R"};
constexpr const char* kFanucJoints[] = {"J1", "J2", "J3", "J4", "J5", "J6"};

class FanucReader : MoveReader {
 public:
  FanucReader(RobotProgram& program, const KnownFrames& known, TargetParts parts)
      : MoveReader(program),
        known_(known),
        parts_(parts),
        original_(program.texts[0].text),
        text_(masked_fanuc(original_)) {}

  void read() {
    find_name();
    const size_t moves = section("/MN"), positions = section("/POS");
    const size_t end = std::min(section("/END"), text_.size());
    if (positions < end) positions_ = fanuc_positions(original_, text_, positions, end);
    moves_no_arm_ = moves_other_groups_alone();
    if (moves_no_arm_)
      warnings_.add(line_at(text_, text_.find("DEFAULT_GR")),
                    "the program moves other groups than the arm's, which stands still; nothing to "
                    "correct");
    if (moves < text_.size()) read_moves(moves, std::min(positions, end));
    program_.warnings = warnings_.list();
  }

 private:
  size_t section(const char* word) const { return line_that_begins(text_, word); }

  void find_name() {
    const size_t prog = section("/PROG");
    if (prog == std::string::npos) return;
    TextCursor cursor(text_, prog + 5, std::min(text_.find('\n', prog), text_.size()));
    cursor.next();
    const size_t begin = cursor.at();
    if (!cursor.take_name().empty()) program_.names.push_back({0, begin, cursor.at()});
  }

  void read_moves(size_t begin, size_t end) {
    std::string part = text_.substr(0, std::min(end, text_.size()));
    begin = std::min(begin, part.size());  // /POS may stand before /MN
    std::replace_if(
        part.begin(), part.begin() + static_cast<long>(begin), [](char c) { return c != '\n'; },
        ' ');
    std::vector<Statement> statements;
    for (const Statement& line : joined_lines(part, begin)) {
      TextCursor cursor(part, line.begin, line.end);
      cursor.take_number();
      cursor.take(':');
      // A comment begins with !, //, or as --eg: does.
      if (cursor.next() != '!' && cursor.next() != '/' && cursor.next() != '-')
        statements.push_back({line.line, cursor.at(), line.end});
    }
    listed_.emplace(program_.texts.data() + program_.own_texts,
                    program_.texts.data() + program_.texts.size());
    for (const Statement& statement : statements) read_uses(part, statement);
    flow_ = fanuc_flow(part, statements);
    registers_.emplace(part, statements, flow_, *listed_,
                       [&](double number) { return as_register(number); });
    frames_.emplace(part, statements, flow_, *registers_, *listed_);
    for (const Statement& statement : statements) read_statement(part, statement);
    for (const auto& [id, position] : positions_)
      if (position.point >= 0) program_.points[position.point].is_shared = position.is_shared;
    for (ProgramPoint& point : program_.points) point.is_shared |= point.starts_from >= 0;
  }

  // P[..] behind a line that no semicolon ends: the second point of a circle, as RoboDK writes it.
  static bool continues_circle(const std::string& part, const Statement& last, TextCursor cursor) {
    size_t end = last.end;
    while (end > last.begin && is_blank(part[end - 1])) --end;
    if (end == last.begin || part[end - 1] == ';') return false;
    TextCursor before(part, last.begin, end);
    before.take_number();
    before.take(':');
    if (before.take_name() != "C") return false;
    const std::string word = cursor.take_name();
    return (word == "P" || word == "PR") && cursor.next() == '[';
  }

  // One for each line; a line that begins with a colon, or with the second point of a circle,
  // continues the one before. A comment may hold quotes and semicolons.
  static std::vector<Statement> joined_lines(std::string& part, size_t begin) {
    std::vector<Statement> joined;
    for (const Statement& line : lines_of(part, begin)) {
      TextCursor cursor(part, line.begin, line.end);
      if (!joined.empty() &&
          (cursor.next() == ':' || continues_circle(part, joined.back(), cursor))) {
        std::replace(part.begin() + static_cast<long>(joined.back().end), part.begin() + line.begin,
                     '\n', ' ');
        joined.back().end = line.end;
      } else {
        joined.push_back(line);
      }
    }
    return joined;
  }

  // A[1] of a German listing is an output.
  static bool is_move(const std::string& word) {
    return word == "J" || word == "L" || word == "C" || word == "A" || word == "S";
  }

  // Positions in other statements than moves: P[1]=LPOS, PR[5]=P[1], P[R[1]]=PR[2].
  void read_uses(const std::string& part, const Statement& statement) {
    TextCursor first(part, statement.begin, statement.end);
    if (is_move(take_fanuc_word(first))) return;
    each_word(part, statement, [&](const std::string& word, size_t, TextCursor cursor) {
      if (word != "P" || !cursor.take('[')) return;
      const auto number = cursor.take_number();
      cursor.skip_to("=");
      const bool is_assigned = cursor.next() == '=';
      each_position(number, [&](FanucPosition& position) {
        (is_assigned ? position.is_changed : position.is_shared) = true;
      });
    });
  }

  // The position with a number, or all: P[R[1]] may be any.
  template <class With>
  void each_position(std::optional<double> number, With with) {
    if (number) return with(positions_[*number]);
    for (auto& [id, position] : positions_) with(position);
  }

  // `L P[3] 250mm/sec FINE`
  void read_statement(const std::string& part, const Statement& statement) {
    TextCursor cursor(part, statement.begin, statement.end);
    const std::string word = take_fanuc_word(cursor);
    if (!is_move(word) || cursor.done() || moves_no_arm_) {
      follows_ = follows_ && stands_between_fanuc_moves(word);
      return;
    }
    is_left_ = false;
    may_run_ = flow_.leads_to(statement.begin);
    const size_t targets = program_.targets.size();
    line_begin_ = line_begin(part, statement.begin);
    ends_at_target_ = true;
    read_move(part, statement, word);
    follows_ = ends_at_target_ && !is_left_ && program_.targets.size() > targets;
    for (size_t k = targets; k < program_.targets.size(); ++k)
      program_.targets[k].never_runs = !may_run_;
  }

  void leave(int line, const std::string& reason) {
    leave_move(line, reason, may_run_);
    is_left_ = true;
  }

  // P[3] in a move.
  struct PointOfMove {
    double id = 0;
    size_t begin = 0, end = 0;
    std::optional<FanucRegister> of_register{};  // PR[3]
  };

  // Offset,PR[1] along the axes of the user frame, Tool_Offset,PR[1] along those of the tool.
  struct Displacement {
    bool is_tool = false;
    Pose by{};
  };

  // The displacement by PR[..] behind Offset or Tool_Offset, or by their condition. Nothing if the
  // register is not known, or turns: no manual says how the controller composes rotations.
  std::optional<Displacement> displacement(bool is_tool, const Statement& statement,
                                           TextCursor cursor) {
    const bool has_comma = cursor.take(',');
    std::optional<double> id;
    std::optional<FanucRegister> value;
    if (cursor.take_name() == "PR") {
      const auto index = take_fanuc_index(cursor);
      if (!index || !index->number || index->element != 0) return std::nullopt;
      value = registers_->find(*(id = index->number), statement.begin);
    } else if (const auto condition = frames_->condition(is_tool, statement.begin);
               condition && !has_comma) {
      value = registers_->find(*(id = condition->id), statement.begin);
      const auto then = registers_->find(condition->id, condition->statement);
      if (!then || !value || then->numbers != value->numbers) return std::nullopt;
    }
    if (!value || value->is_joints()) return std::nullopt;
    for (size_t i = 3; i < 6; ++i)
      if (value->numbers[i] != 0) return std::nullopt;
    if (value->meaning == FanucRegister::Meaning::not_said)
      warnings_.add(
          statement.line,
          fmt::format("the numbers that the program gives PR[{}] are taken for X, Y, Z, "
                      "W, P, R; if it holds joint angles, the correction of moves that it "
                      "displaces is for another place",
                      *id));
    const Eigen::Vector3d shift(value->numbers[0], value->numbers[1], value->numbers[2]);
    return Displacement{is_tool, {Eigen::Matrix3d::Identity(), shift * kMillimetre}};
  }

  // What PR[..]=P[3] copies.
  std::optional<FanucRegister> as_register(double number) {
    const auto found = positions_.find(number);
    if (found == positions_.end()) return std::nullopt;
    const FanucPosition& position = found->second;
    const bool is_joints = position.numbers.contains("J1");
    FanucRegister result{is_joints ? FanucRegister::Meaning::joints : FanucRegister::Meaning::pose,
                         {},
                         position.configuration,
                         position.frame,
                         position.tool};
    for (const char* const name : is_joints ? kFanucJoints : kFanucPose)
      if (const auto value = position.numbers.find(name); value != position.numbers.end())
        result.numbers.push_back(value->second.value);
    const bool has_others = position.numbers.size() != 6 || !position.others.empty();
    return position.is_changed || has_others || result.numbers.size() != 6 ? std::nullopt
                                                                           : std::optional(result);
  }

  void read_move(const std::string& part, const Statement& statement, const std::string& kind) {
    std::vector<PointOfMove> points;
    std::string other;
    bool follows_point = false, is_any = false, is_coordinated = false, is_passed = false;
    std::vector<Displacement> displacements;
    const auto is_because = [&](const std::string& reason) {
      if (other.empty()) other = reason;
    };
    const size_t wanted = kind == "C" ? 2 : 1;
    if (frames_->is_displaced(statement.begin)) is_because("the move is displaced (Touch Offset)");
    std::string before;  // the word before this one
    each_fanuc_word(part, statement, [&](const std::string& word, size_t at, TextCursor& cursor) {
      const std::string option = std::exchange(before, word);
      if (word == "INC") is_because("a relative move (INC)");
      if (word == "RTCP") is_because("its tool stands in the room (RTCP)");
      if (word == "SKIP") ends_at_target_ = false;
      is_passed |= word.starts_with("CNT") && word != "CNT0";
      const bool is_offset = word == "OFFSET" || word == "TOOL_OFFSET" || word == "VOFFSET";
      follows_point |= is_offset && other.empty();
      is_coordinated |= word == "COORD";
      if (is_offset) {
        const auto by = word == "VOFFSET" ? std::nullopt
                                          : displacement(word == "TOOL_OFFSET", statement, cursor);
        if (by)
          displacements.push_back(*by);
        else
          is_because("the move is displaced (" + word + ")" +
                     (word == "VOFFSET"
                          ? ""
                          : ", and no listing (--with POSREG.VA) says by how much, or it turns, or "
                            "the program sets its register"));
      }
      if ((word != "P" && word != "PR") || !cursor.take('[')) return;
      const auto id = cursor.take_number();
      cursor.skip_to("]");
      cursor.take(']');
      if (points.size() >= wanted) {
        if (word == "PR" && text_before(part, at) == ',' && !takes_register(option))
          is_because("what its option " + option + " does with a register is not known");
        return;
      }
      if (word == "P" && id) return points.push_back({*id, at, cursor.at()});
      is_any |= word == "P";
      auto of_register = word == "PR" && id ? registers_->find(*id, statement.begin) : std::nullopt;
      if (of_register) return points.push_back({*id, at, cursor.at(), std::move(of_register)});
      is_because(word == "PR"
                     ? "its point is a register, and no listing (--with POSREG.VA) has it, or the "
                       "program sets it"
                     : "its point has no plain number");
    });
    if (points.empty() && other.empty()) return;  // no move: a word of the same letter
    if (is_coordinated) {
      const std::string why_not = why_not_coordinated(points, statement.begin);
      is_because(why_not);
      follows_point &= why_not.empty();
    }
    if (other.empty() && points.size() != wanted) other = "it does not have the points of its kind";
    for (const PointOfMove& point : points)
      if (other.empty())
        other = point.of_register ? why_not_usable_register(point) : why_not_usable(point);
    for (const PointOfMove& point : points)
      if (other.empty() && !displacements.empty() && (kind == "C" || is_joints(point)))
        other = "an arc, or joint angles, are displaced";
    if (!other.empty()) {
      if (is_any) each_position({}, [](FanucPosition& position) { position.is_shared = true; });
      for (const PointOfMove& point : points)
        if (!follows_point && !point.of_register) positions_[point.id].is_shared = true;
      return leave(statement.line, other);
    }
    for (size_t i = 0; i < points.size(); ++i) {
      const bool is_auxiliary = i + 1 < points.size();
      ProgramTarget& target = points[i].of_register
                                  ? add_register_target(points[i], statement.line, is_auxiliary)
                                  : add_target(points[i], statement.line, is_auxiliary);
      if (!displacements.empty()) displace(displacements, target);
      target.motion =
          kind == "A" || kind == "S" ? MotionKind::arc : motion_of(kind[0], !is_auxiliary);
      target.turning = ArcTurning::perhaps_through_via;
      target.is_passed = is_passed;
      target.follows_target = i > 0 || (follows_ && (kind == "L" || kind == "C"));
      if (kind == "L" || i > 0) prepare_insertion(target, points, part, statement);
    }
  }

  // The last character before a place that is no blank.
  static char text_before(const std::string& part, size_t at) {
    while (at > 0 && is_blank(part[at - 1])) --at;
    return at > 0 ? part[at - 1] : '\0';
  }

  // Whether what an option does with a register behind it is known: it displaces, or it keeps where
  // the arm stops (Skip,LBL[1],PR[5]=LPOS).
  static bool takes_register(const std::string& option) {
    return option == "OFFSET" || option == "TOOL_OFFSET" || option == "VOFFSET" || option == "LBL";
  }

  // Why a move that is coordinated with a positioner (COORD) cannot be followed; empty if it can.
  // The positioner carries the frame, which is fixed only if the positioner is. No listing of user
  // frames says where it is then.
  std::string why_not_coordinated(const std::vector<PointOfMove>& points, size_t at) {
    if (positioner_moves())
      return "its motion is coordinated with a positioner (COORD), which carries its frame and "
             "moves";
    for (const PointOfMove& point : points) {
      if (point.of_register || is_joints(point)) continue;
      const auto number = frame_number(positions_[point.id], false, at);
      const bool is_of_world =
          number && (listed_->find_frame(false, *number) || frames_->set_value(false, *number, at));
      if (is_of_world && !is_given("UF", *number))
        return fmt::format(
            "its motion is coordinated with a positioner (COORD), which carries its frame; say "
            "where that stands: --frame UF[{}]=x,y,z,a,b,c",
            *number);
    }
    return "";
  }

  // Whether the positions do not all state the same for the axes beside the arm's.
  bool positioner_moves() const {
    const FanucPosition* first = nullptr;
    for (const auto& [id, position] : positions_) {
      if (position.line == 0) continue;  // only named
      if (!first) first = &position;
      if (position.others.empty() || position.others != first->others) return true;
    }
    return !first;
  }

  // Whether --frame has a frame or tool.
  bool is_given(const char* name, int number) const {
    return is_given_frame(known_, fmt::format("{}[{}]", name, number));
  }

  bool is_joints(const PointOfMove& point) {
    return point.of_register ? point.of_register->is_joints()
                             : positions_[point.id].numbers.contains("J1");
  }

  // What stands beside the points of an inserted move.
  void prepare_insertion(ProgramTarget& target, const std::vector<PointOfMove>& points,
                         const std::string& part, const Statement& statement) {
    const size_t behind = points.back().end;
    target.obstacle = why_not_inserted(points, part, {statement.line, behind, statement.end});
    if (!target.obstacle.empty()) return;
    std::string rest = original_.substr(behind, statement.end - behind);
    if (const size_t fine = upper(rest).find("FINE"); fine != std::string::npos)
      rest.replace(fine, 4, "CNT100");
    while (!rest.empty() && is_blank(rest.back())) rest.pop_back();
    ProgramInsertion& beside = target.insertion;
    beside.at = line_begin_;
    beside.before = original_.substr(line_begin_, points[0].begin - line_begin_);
    beside.behind = rest;
    beside.line_end = line_end(original_, line_begin_);
    if (points.size() == 1) return;
    beside.middle = original_.substr(points[0].end, points[1].begin - points[0].end);
  }

  std::string why_not_inserted(const std::vector<PointOfMove>& points, const std::string& part,
                               const Statement& options) {
    for (const PointOfMove& point : points) {
      if (point.of_register) return "its point is a register";
      if (positions_[point.id].numbers.contains("J1")) return "its point is joint angles";
    }
    if (original_.substr(options.begin, options.end - options.begin).find('\n') !=
        std::string::npos)
      return "it has more than one line";
    char before = ' ';
    for (TextCursor cursor(part, options.begin, options.end); !cursor.done();) {
      std::string word = take_fanuc_word(cursor);
      if (word.empty()) {
        before = cursor.next();
        cursor.step();
        continue;
      }
      if (before != '/' && (word == "SEC" || word == "MSEC")) return "its speed is a time";
      while (!word.empty() && is_digit(word.back())) word.pop_back();
      if (!may_be_repeated(word)) return "it has the option " + word;
      before = ' ';
    }
    const FanucPosition& here = positions_[points.back().id];
    if (program_.targets.size() <= points.size() || here.numbers.size() + here.others.size() == 6)
      return "";
    // Axes beyond the arm's.
    const auto start = program_.targets.end() - static_cast<long>(points.size()) - 1;
    const size_t point = start->point;
    if (program_.points[point].is_expression) return "its start is a register";
    const FanucPosition& before_it = positions_[ids_of_points_[point]];
    bool is_same = before_it.others == here.others;
    for (const auto& [name, value] : here.numbers) {
      const auto found = before_it.numbers.find(name);
      if (name[0] == 'E')
        is_same &= found != before_it.numbers.end() && found->second.value == value.value;
    }
    if (is_same) return "";
    return "external axes or another group move";
  }

  // Why a move to a point cannot be followed; empty if it can.
  std::string why_not_usable(const PointOfMove& of_move) {
    FanucPosition& position = positions_[of_move.id];
    if (position.is_changed) return "its point is given several values, or changed at run time";
    if (position.numbers.empty()) return "its point has no numbers in /POS";
    if (position.point < 0) add_point(of_move.id, position);
    if (position.point < 0) return "its point has no plain numbers";
    return is_joints(of_move) || parts_ != TargetParts::pose ? "" : why_frames_not_certain(of_move);
  }

  // Why it is not certain in which frame and with which tool a point is, or where these are; empty
  // if it is. A register is in the active ones.
  std::string why_frames_not_certain(const PointOfMove& of_move) {
    for (const bool is_tool : {false, true}) {
      const bool is_active = of_move.of_register || is_in_active(positions_[of_move.id], is_tool);
      const auto number = is_active ? frames_->active(is_tool, of_move.begin)
                                    : frame_number(positions_[of_move.id], is_tool, of_move.begin);
      if (number) {
        if (const std::string why = why_not_certain(is_tool, *number, of_move.begin); !why.empty())
          return why;
      } else if (is_active) {
        return fmt::format(
            "its {0} is in the active {1}{2}, and which it is, {3}_NUM does not say for certain",
            of_move.of_register ? "register" : "point", is_tool ? "tool" : "frame",
            of_move.of_register ? "" : " (F)", is_tool ? "UTOOL" : "UFRAME");
      }
    }
    return "";
  }

  // Why a user frame or a tool has perhaps another value than the listed one; empty if it has not.
  std::string why_not_certain(bool is_tool, int number, size_t at) const {
    const char* const name = is_tool ? "UTOOL" : "UFRAME";
    if (frames_->is_changed(is_tool, number, at))
      return fmt::format("{}[{}] is set at run time", name, number);
    const char* const option = is_tool ? "UT" : "UF";
    if (!listed_->find_frame(is_tool, number) || is_given(option, number) ||
        frames_->set_value(is_tool, number, at) || !listed_->is_set_by_others(is_tool, number))
      return "";
    return fmt::format("another program sets {}[{}]; say where it is: --frame {}[{}]=x,y,z,a,b,c",
                       name, number, option, number);
  }

  std::optional<int> frame_number(const FanucPosition& position, bool is_tool, size_t at) const {
    if (is_in_active(position, is_tool)) return frames_->active(is_tool, at);
    return is_tool ? position.tool : position.frame;
  }

  static bool is_in_active(const FanucPosition& position, bool is_tool) {
    return is_tool ? position.has_active_tool : position.is_in_active_frame;
  }

  void add_point(double id, FanucPosition& position) {
    ProgramPoint point;
    point.name = fmt::format("P[{}]", id);
    point.line = position.line;
    const bool is_joints = position.numbers.contains("J1");
    point.kind = is_joints ? TargetKind::joints : TargetKind::cartesian;
    for (int i = 0; i < 6; ++i) {
      const auto number = position.numbers.find(is_joints ? kFanucJoints[i] : kFanucPose[i]);
      if (number == position.numbers.end() && !is_joints) return;
      if (number == position.numbers.end())
        point.numbers.emplace_back();  // of an arm of fewer axes: it has no place in the text
      else
        point.numbers.push_back(number->second);
    }
    point.begin = position.begin;
    point.end = position.end;
    if (position.configuration_place) point.configuration.push_back(*position.configuration_place);
    position.point = keep(point, id);
  }

  // Returns its index.
  int keep(const ProgramPoint& point, double id) {
    program_.points.push_back(point);
    ids_of_points_.push_back(id);
    return static_cast<int>(program_.points.size()) - 1;
  }

  ProgramTarget& add_target(const PointOfMove& of_move, int line, bool is_auxiliary) {
    const FanucPosition& position = positions_[of_move.id];
    ProgramTarget& target = add(of_move, line, is_auxiliary, position.point, position.configuration,
                                frame_number(position, false, of_move.begin),
                                frame_number(position, true, of_move.begin));
    target.other_axes = position.others;
    for (const auto& [name, number] : position.numbers)
      if (name[0] == 'E') target.other_axes[name] = number.value;
    return target;
  }

  ProgramTarget& add(const PointOfMove& of_move, int line, bool is_auxiliary, int point,
                     const std::string& configuration, std::optional<int> frame,
                     std::optional<int> tool) {
    ProgramTarget target;
    target.line = line;
    target.begin = of_move.begin;
    target.end = of_move.end;
    if (frame) target.base = add_frame_of(false, *frame, line, of_move.begin);
    if (tool) target.tool = add_frame_of(true, *tool, line, of_move.begin);
    if (program_.points[point].kind == TargetKind::cartesian) {
      target.configuration = fanuc_configuration(configuration);
      target.configuration.continues = is_auxiliary;
    }
    return add_target_at(std::move(target), point);
  }

  // A register is in the active frame, and has no place in the text.
  std::string why_not_usable_register(const PointOfMove& of_move) {
    const FanucRegister& of = *of_move.of_register;
    if (of.meaning == FanucRegister::Meaning::not_said ||
        (!of.is_joints() && of.configuration.empty()))
      return "its register has no CONFIG that is known";
    if (!is_joints(of_move)) {
      if (const std::string why = why_frames_not_certain(of_move); !why.empty()) return why;
      if ((of.frame && of.frame != frames_->active(false, of_move.begin)) ||
          (of.tool && of.tool != frames_->active(true, of_move.begin)))
        return "its register is a copy of a position in another frame, or of another tool";
    }
    const bool has_more = std::ranges::any_of(positions_, [](const auto& position) {
      return position.second.numbers.size() + position.second.others.size() > 6;
    });
    return has_more || moves_other_groups() ? "its register says nothing of the other axes" : "";
  }

  // DEFAULT_GROUP = 1,1,*,*,*; in German DEFAULT_GRUP: the groups that the program may move, and
  // the arm is the first of them.
  std::string groups() const {
    const size_t at = text_.find("DEFAULT_GR"), begin = text_.find('=', at);
    const size_t end = std::min(text_.find(';', at), text_.find('\n', at));
    return begin < end ? text_.substr(begin + 1, end - begin - 1) : "";
  }

  bool moves_other_groups() const {
    const std::string mask = groups();
    return mask.find('1', std::min(mask.find(','), mask.size())) != std::string::npos;
  }

  // `*,1,*,*,*`: the arm stands still in all of its moves.
  bool moves_other_groups_alone() const {
    const std::string mask = groups();
    return moves_other_groups() && mask.substr(0, mask.find(',')).find('*') != std::string::npos;
  }

  ProgramTarget& add_register_target(const PointOfMove& of_move, int line, bool is_auxiliary) {
    const FanucRegister& of = *of_move.of_register;
    const std::optional<int> frame = frames_->active(false, of_move.begin),
                             tool = frames_->active(true, of_move.begin);
    const auto text = [](std::optional<int> number) {
      return number ? fmt::format("{}", *number) : "F";
    };
    ProgramPoint point;
    point.name = fmt::format("UF : {}, UT : {},", text(frame), text(tool));
    if (!of.is_joints()) point.name += fmt::format("\tCONFIG : '{}',", of.configuration);
    point.name += "\n";
    point.line = line;
    point.begin = of_move.begin;
    point.end = of_move.end;
    point.kind = of.is_joints() ? TargetKind::joints : TargetKind::cartesian;
    point.is_expression = true;
    for (const double number : of.numbers)
      point.numbers.push_back({0, of_move.end, of_move.end, number, ""});
    ProgramTarget& target =
        add(of_move, line, is_auxiliary, keep(point, 0), of.configuration, frame, tool);
    target.remark = "the register is written into the program, as it is listed or set there";
    return target;
  }

  // That of --frame, as the program has set it, or as it is listed. UF[0] is the world frame, UT[0]
  // the flange.
  int add_frame_of(bool is_tool, int number, int line, size_t at) {
    const char* const option = is_tool ? "UT" : "UF";
    std::string name = fmt::format("{}[{}]", option, number);
    const std::vector<double>* numbers = nullptr;
    if (const FanucRegister* const found = listed_->find_frame(is_tool, number))
      numbers = &found->numbers;
    if (const FanucFrames::SetFrame* const set = frames_->set_value(is_tool, number, at);
        set && !is_given(option, number)) {
      numbers = &set->numbers;
      name += fmt::format(" of line {}", set->line);
    }
    std::optional<Pose> pose;
    if (number == 0) pose = Pose{};
    if (numbers && number > 0) {
      pose = program_.frames[add_frame_of(is_tool, 0, line, at)].pose *
             fanuc_dialect().pose_of_numbers(*numbers);
      if (!is_tool && !is_given("UF", 0) && pose->translation.norm() > 0)
        warnings_.add(line,
                      "the user frame counts from FANUC's world frame, which is taken to be "
                      "R_0 of the robot file; if it is not, such as at the height of axis 2, say "
                      "where it is: --frame 'UF[0]=x,y,z,a,b,c'");
    }
    return add_frame(program_.frames, known_, name, pose);
  }

  // The move keeps its options: its point becomes another one.
  void displace(const std::vector<Displacement>& displacements, ProgramTarget& target) {
    for (const Displacement& displacement : displacements)
      (displacement.is_tool ? target.behind : target.before) = displacement.by;
    target.pose = target.before * target.pose * target.behind;
    ProgramPoint point = program_.points[target.point];
    point.starts_from = target.point;
    target.point = keep(point, ids_of_points_[point.starts_from]);
  }

  const KnownFrames& known_;
  const TargetParts parts_;
  const std::string original_;
  std::string text_;
  std::map<double, FanucPosition> positions_;
  std::vector<double> ids_of_points_;
  ProgramFlow flow_;
  std::optional<FanucRegisters> listed_;
  std::optional<FanucAssignments> registers_;
  std::optional<FanucFrames> frames_;
  size_t line_begin_ = 0;       // of the move that is read
  bool ends_at_target_ = true;  // the move that is read
  bool moves_no_arm_ = false;   // only other groups
  bool is_left_ = false;        // the move that is read is left alone
  bool may_run_ = true;         // the move; else no way leads to it
  bool follows_ = false;        // the arm stands at the last target
};

}  // namespace

void parse_fanuc_program(RobotProgram& program, const KnownFrames& known, TargetParts parts) {
  FanucReader(program, known, parts).read();
}

}  // namespace armtrue
