#include "programs/krl_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "armtrue/programs/division.h"
#include "armtrue/programs/matching.h"
#include "programs/krl_frame_texts.h"
#include "programs/krl_knots.h"
#include "programs/krl_pose.h"
#include "programs/krl_set_up.h"
#include "programs/krl_words.h"
#include "programs/program_warnings.h"
#include "programs/statement.h"
#include "programs/text_edit.h"

namespace armtrue {
namespace {

using Eigen::Vector3d;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Goes through the moves in order. Collects the edits of the .src; those of frames come at the end,
// when all that their moves want is known.
class KrlWriter {
 public:
  KrlWriter(const KrlProgram& program, const KrlSyntax& syntax, const Path& path,
            const Eigen::Matrix3Xd& corrected, const KrlCorrectionOptions& options)
      : program_(program),
        syntax_(syntax),
        path_(path),
        displacement_(corrected - path.position),
        options_(options),
        warnings_(program.src.name),
        frame_texts_(program, syntax) {
    ProgramWarnings unused(program.src.name);  // of frames that are not known: here names do
    const KnownFrames none;
    KrlSetUps followed(program, syntax, none, frames_, unused);
    for (const KrlMove& move : syntax.moves) set_ups_.push_back(followed.at(move));
  }

  CorrectedKrl write(const std::vector<KrlPlannedMove>& plans) {
    if (syntax_.absolute_accuracy_line)
      warnings_.add(
          syntax_.absolute_accuracy_line,
          "$ABS_ACCUR: the controller corrects the arm's geometry itself; measure and run "
          "with it in the same state, or both corrections add up");
    note_few_found(plans);
    for (size_t i = 0; i < plans.size(); ++i) write_move(syntax_.moves[i], plans[i]);
    for (TextEdit& edit : frame_texts_.edits()) edits_.push_back(std::move(edit));
    result_.src = apply_edits(program_.src.text, edits_, 0);
    if (program_.dat) result_.dat = apply_edits(program_.dat->text, edits_, 1);
    result_.warnings = warnings_.list();
    return std::move(result_);
  }

 private:
  std::string_view src(size_t begin, size_t end) const {
    return std::string_view(program_.src.text).substr(begin, end - begin);
  }
  void write_move(const KrlMove& move, const KrlPlannedMove& plan) {
    if (move.start_unknown) pose_ = unknown_krl_values();
    const bool circle = move.motion == KrlMotion::circle;
    if (std::isfinite(plan.end_place)) {
      ++result_.corrected;
      note_surroundings(move);
    } else {
      ++result_.left_alone;
      note_left_alone(move, plan);
    }
    if (circle && plan.known)
      write_circle(move, plan);
    else if (plan.known)
      write_line(move, plan);
    else
      leave(move);
    if (move.circle_angle) pose_ = unknown_krl_values();
  }

  // Keeps the text of a move that cannot be corrected. Its frames count as used, so that a named
  // point keeps its value for this move, and later moves inherit what they give.
  void leave(const KrlMove& move) {
    const bool circle = move.motion == KrlMotion::circle;
    const bool via = move.auxiliary.kind == KrlTargetKind::frame;
    const bool to = move.target.kind == KrlTargetKind::frame;
    KrlValues pose = pose_;
    if (via) frame_texts_.write(move.auxiliary, unknown_krl_values(), pose);
    pose = common(pose_, pose);
    if (to) frame_texts_.write(move.target, unknown_krl_values(), pose);
    pose_ = to && (via || !circle) ? pose : unknown_krl_values();
  }

  // Approach and retreat lie off the path. If most points do, the path is that of another program.
  void note_few_found(const std::vector<KrlPlannedMove>& plans) {
    int known = 0, found = 0, first_off = 0;
    for (size_t i = 0; i < plans.size(); ++i) {
      if (!plans[i].known) continue;
      const bool on_path = std::isfinite(plans[i].end_place);
      ++known;
      found += on_path;
      if (!on_path && first_off == 0) first_off = syntax_.moves[i].line;
    }
    if (2 * found < known)
      warnings_.add(first_off, fmt::format("only {} of the {} points of the program lie on the "
                                           "programmed path; is this the program of that path?",
                                           found, known));
  }

  // The path is that of one tool in one frame.
  void note_surroundings(const KrlMove& move) {
    const KrlSetUps::SetUp& set_up = set_ups_[static_cast<size_t>(&move - syntax_.moves.data())];
    if (!first_) first_ = {set_up, move.line};
    const auto& [first, line] = *first_;
    if (first.base != set_up.base)
      warnings_.add(move.line, fmt::format("$BASE is another one than for the first corrected move "
                                           "(line {}); its coordinates were taken as they stand",
                                           line));
    if (first.tool != set_up.tool)
      warnings_.add(move.line, fmt::format("$TOOL is another one than for the first corrected move "
                                           "(line {}); the record shows the point of one tool",
                                           line));
    if (set_up.is_external_tcp)
      warnings_.add(move.line,
                    "its tool stands in the room (#TCP): the path is that of the part, and turns "
                    "with it");
    if (move.in_loop)
      warnings_.add(move.line, "stands in a loop; every turn gets the correction of the first");
  }

  void note_left_alone(const KrlMove& move, const KrlPlannedMove& plan) {
    const auto what = [&]() -> std::string {
      if (plan.known) return "ends off the path";
      if (move.relative) return "relative to the (corrected) point before it";
      const bool by_target =
          move.motion != KrlMotion::circle || move.auxiliary.kind == KrlTargetKind::frame;
      switch (by_target ? move.target.kind : move.auxiliary.kind) {
        case KrlTargetKind::axes:
          return "axis angles, which need the robot";
        case KrlTargetKind::undeclared:
          return "its point is declared neither here nor in " +
                 (program_.dat ? program_.dat->name : "a .dat beside this file");
        case KrlTargetKind::reassigned:
          return "its point is given a value more than once, or in a way not understood";
        case KrlTargetKind::expression:
          return "its target is not understood";
        case KrlTargetKind::frame:
          break;
      }
      return "coordinates are left out and the point before is not known";
    };
    warnings_.add(move.line, "left alone: " + what());
  }

  KrlValues displaced(KrlValues pose, double place) const {
    if (std::isfinite(place)) pose.head<3>() += at_place(displacement_, place);
    return pose;
  }

  // The reason why no moves can be inserted before this one; empty if they can.
  std::string obstacle(const KrlMove& move, const KrlPlannedMove& plan) const {
    if (move.in_spline_block) return "a spline block";
    if (move.after_trigger) return "a TRIGGER refers to this move";
    const KrlValues& given = frame_texts_.frame(move.target).values;
    for (int i = 3; i < kKrlComponents; ++i)
      if (std::isfinite(given[i]) && !(std::isfinite(plan.start[i]) && std::isfinite(plan.end[i])))
        return "the orientation or an external axis before it is not known";
    return "";
  }

  void write_line(const KrlMove& move, const KrlPlannedMove& plan) {
    const Vector3d start = position(plan.start), end = position(plan.end);
    const bool on_path = std::isfinite(plan.start_place) || std::isfinite(plan.end_place);
    if (move.motion == KrlMotion::line && on_path && start.allFinite() && start != end)
      insert_on_line(move, plan);
    write_end(move, plan);
  }

  void insert_on_line(const KrlMove& move, const KrlPlannedMove& plan) {
    const Vector3d start = position(plan.start), end = position(plan.end);
    std::vector<Knot> knots = knots_on_line(plan, path_, displacement_);
    // The part of a displacement along the line does not bend it: it moves the knot along the line.
    const Vector3d along = (end - start).normalized();
    for (size_t k = 0; k < knots.size(); ++k) {
      const double forward = along.dot(knots[k].displacement);
      knots[k].displacement -= forward * along;
      knots[k].t += forward / (end - start).norm();
      if (k > 0) knots[k].t = std::max(knots[k].t, knots[k - 1].t);
    }
    const std::vector<size_t> divisions =
        divide_line(knots, options_.tolerance, options_.spacing / (end - start).norm());
    if (!may_insert(move, plan, divisions.size() - 2)) return;
    for (size_t i = 1; i + 1 < divisions.size(); ++i) {
      const Knot& knot = knots[divisions[i]];
      KrlValues pose = between(plan.start, plan.end, std::clamp(knot.t, 0.0, 1.0));
      pose.head<3>() = start + knot.t * (end - start) + knot.displacement;
      insert(move,
             std::string(src(move.keyword_end, move.target.begin)) +
                 frame_texts_.text(move.target, pose, pose_),
             false);
    }
  }

  // An end on the path gets every component as planned, whatever the move before it inherits now;
  // an end off the path keeps its text.
  void write_end(const KrlMove& move, const KrlPlannedMove& plan) {
    frame_texts_.write(
        move.target,
        std::isfinite(plan.end_place) ? displaced(plan.end, plan.end_place) : unknown_krl_values(),
        pose_);
  }

  void write_circle(const KrlMove& move, const KrlPlannedMove& plan) {
    const auto arc =
        arc_through(position(plan.start), position(plan.auxiliary), position(plan.end));
    if (!arc || move.circle_angle || !std::isfinite(plan.start_place) ||
        !std::isfinite(plan.end_place)) {
      write_circle_points(move, plan);
      return;
    }
    const std::vector<Knot> knots = knots_on_arc(plan, *arc, path_, displacement_);
    const double via = arc->foot(position(plan.auxiliary));
    const std::vector<size_t> divisions = divide_arc(*arc, via, knots, options_.tolerance,
                                                     options_.spacing / (arc->radius * arc->angle));
    if (may_insert(move, plan, divisions.size() - 2)) {
      write_pieces(move, plan, *arc, knots, divisions);
      return;
    }
    KrlValues auxiliary = unknown_krl_values();
    auxiliary.head<3>() = position(plan.auxiliary) + displacement_at(knots, via);
    write_auxiliary(move, auxiliary);
    write_end(move, plan);
  }

  // Writes a displaced arc as pieces that end at the `divisions` among the knots: circular pieces,
  // or lines where a piece is straight. The last piece is the move itself; the others are inserted.
  void write_pieces(const KrlMove& move, const KrlPlannedMove& plan, const Arc& arc,
                    const std::vector<Knot>& knots, const std::vector<size_t>& divisions) {
    const auto displaced_at = [&](double t) {
      KrlValues pose = between(plan.start, plan.end, t);
      pose.head<3>() = arc.at(t) + displacement_at(knots, t);
      return pose;
    };
    for (size_t i = 1; i < divisions.size(); ++i) {
      const size_t first = divisions[i - 1], last = divisions[i];
      const bool straight = is_straight(arc, knots, first, last, options_.tolerance);
      KrlValues auxiliary = displaced_at((knots[first].t + knots[last].t) / 2);
      // The auxiliary points of the pieces give the components that the one of the move gives.
      for (int k = 3; k < kKrlComponents; ++k)
        if (!std::isfinite(frame_texts_.frame(move.auxiliary).values[k])) auxiliary[k] = kUnknown;
      if (i + 1 < divisions.size())
        insert_piece(move, auxiliary, displaced_at(knots[last].t), straight);
      else
        write_last_piece(move, plan, auxiliary, straight);
    }
  }

  void insert_piece(const KrlMove& move, const KrlValues& auxiliary, const KrlValues& end,
                    bool straight) {
    std::string points(src(move.keyword_end, move.auxiliary.begin));
    if (!straight) {
      KrlValues via_pose = pose_;
      points += frame_texts_.text(move.auxiliary, auxiliary, via_pose);
      points += src(move.auxiliary.end, move.target.begin);
      pose_ = common(pose_, via_pose);
    }
    insert(move, points + frame_texts_.text(move.target, end, pose_), straight);
  }

  void write_last_piece(const KrlMove& move, const KrlPlannedMove& plan, const KrlValues& auxiliary,
                        bool straight) {
    if (straight) {
      KrlValues unused = pose_;
      frame_texts_.write(move.auxiliary, unknown_krl_values(), unused);
      edits_.push_back(
          {0, move.begin, move.target.begin,
           line_keyword(move) + std::string(src(move.keyword_end, move.auxiliary.begin))});
    } else {
      write_auxiliary(move, auxiliary);
    }
    write_end(move, plan);
  }

  void write_auxiliary(const KrlMove& move, const KrlValues& auxiliary) {
    KrlValues pose = pose_;
    frame_texts_.write(move.auxiliary, auxiliary, pose);
    pose_ = common(pose_, pose);
  }

  // Displaces the points of a circle, each by its own displacement, and divides nothing.
  void write_circle_points(const KrlMove& move, const KrlPlannedMove& plan) {
    KrlValues auxiliary = unknown_krl_values();
    if (std::isfinite(plan.auxiliary_place))
      auxiliary.head<3>() = displaced(plan.auxiliary, plan.auxiliary_place).head<3>();
    write_auxiliary(move, auxiliary);
    write_end(move, plan);
    if (std::isfinite(plan.auxiliary_place) || std::isfinite(plan.end_place))
      warnings_.add(move.line,
                    "CIRC that starts or ends off the path, or has an angle: only its points are "
                    "corrected, what lies between follows");
  }

  bool may_insert(const KrlMove& move, const KrlPlannedMove& plan, size_t count) {
    if (count == 0) return false;
    const std::string reason = obstacle(move, plan);
    if (reason.empty()) return true;
    warnings_.add(move.line,
                  "the correction bends along this move, but no points are inserted: " + reason);
    return false;
  }

  static std::string line_keyword(const KrlMove& move) { return move.spline ? "SLIN" : "LIN"; }

  // Inserts a move of the same kind (or a straight one) to `points`, blended into the next, on a
  // line of its own before the move.
  void insert(const KrlMove& move, const std::string& points, bool straight) {
    std::string line(src(move.line_begin, move.begin));
    line += straight ? line_keyword(move) : std::string(src(move.begin, move.keyword_end));
    const std::string_view rest = src(move.target.end, move.end);
    line += points;
    line += rest;
    line += krl_blending(rest, move);
    line += line_end(program_.src.text, move.end);
    edits_.push_back({0, move.line_begin, move.line_begin, line});
    ++result_.inserted;
    if (move.in_inline_form)
      warnings_.add(move.line,
                    "points are inserted in an inline form; changing it on the pendant drops them");
  }

  const KrlProgram& program_;
  const KrlSyntax& syntax_;
  const Path& path_;
  const Eigen::Matrix3Xd displacement_;
  const KrlCorrectionOptions options_;
  ProgramWarnings warnings_;
  KrlFrameTexts frame_texts_;
  std::vector<TextEdit> edits_;
  KrlValues pose_ = unknown_krl_values();  // the end of the moves so far, as written
  std::vector<ProgramFrame> frames_;       // that the program names
  std::vector<KrlSetUps::SetUp> set_ups_;  // of each move
  std::optional<std::pair<KrlSetUps::SetUp, int>> first_;  // of the first corrected move; its line
  CorrectedKrl result_;
};

}  // namespace

CorrectedKrl write_corrected_krl(const KrlProgram& program, const KrlSyntax& syntax,
                                 const std::vector<KrlPlannedMove>& plans, const Path& programmed,
                                 const Eigen::Matrix3Xd& corrected,
                                 const KrlCorrectionOptions& options) {
  return KrlWriter(program, syntax, programmed, corrected, options).write(plans);
}

}  // namespace armtrue
