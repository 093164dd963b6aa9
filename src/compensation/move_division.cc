#include "armtrue/compensation/move_division.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "armtrue/compensation/program_joints.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/statistics/check_digits.h"
#include "armtrue/text/input_error.h"
#include "compensation/error_between.h"

namespace armtrue {
namespace {

// A controller reads ahead and blends over half a move: 1 mm is three cycles of 12 ms at 27 mm/s.
constexpr double kShortest = 1e-3;   // [m], between two points
constexpr double kMaxPieces = 16;    // of one piece, in one round
constexpr size_t kMaxPoints = 1000;  // of one move
// Check digits turn the tool by so much at each end of a piece: a joint that moves less may move in
// either direction [rad or m].
constexpr double kSureMotion = 2 * kMostMovedIfRounded * 1e-3 * kDegree;

// A point of a move: its end, a point before it, or one half-way along a piece of an arc.
struct Row {
  size_t move = 0;  // the end, in the targets of the program
  bool is_via = false;
  double t = 1;              // place on the way of the move
  bool is_placed = false;    // it stands at t; else where the program has it
  bool is_inserted = false;  // it is no point of the program

  size_t target() const { return is_via ? move - 1 : move; }
};

struct Travel {
  JointVector low, high;  // [rad or m]
};

// The joints whose direction or stroke counts.
std::vector<int> joints_with_backlash(const Robot& robot) {
  std::vector<int> joints;
  for (const Effect& effect : robot.effects)
    if (follows_motion(effect))
      joints.push_back(effect.driver.kind == DriverKind::arrival ||
                               effect.driver.kind == DriverKind::stroke
                           ? effect.driver.joint
                           : effect.driver.second_joint);
  return joints;
}

class MoveDivision {
 public:
  MoveDivision(const Robot& identified, const Robot& controller, const RobotProgram& text,
               const Program& program, const CompensationOptions& options, double tolerance)
      : identified_(identified),
        controller_(controller),
        text_(text),
        program_(program),
        options_(options),
        tolerance_(tolerance),
        joints_(program_joints(controller.chain, text.dialect->facts().counts_axis_3_from_arm)),
        with_backlash_(joints_with_backlash(identified)),
        closed_(text.targets.size()),
        doubtful_(text.targets.size()),
        why_(text.targets.size()),
        before_(text.targets.size(), 0) {
    for (size_t k = 0; k < text.targets.size(); ++k) {
      const ProgramTarget& target = text.targets[k];
      const bool is_via = target.motion == MotionKind::via && k + 1 < text.targets.size() &&
                          text.targets[k + 1].motion == MotionKind::arc;
      rows_.push_back({is_via ? k + 1 : k, is_via, is_via ? 0.5 : 1.0});
      closed_[k] = target.obstacle;
    }
  }

  DividedProgram run() {
    of_program_ = targets_ = compensate(identified_, controller_, program_, options_);
    const ErrorBetween of_program(identified_, controller_, program_, options_);
    for (size_t k = 0; k < targets_.size(); ++k) {
      ways_.push_back(of_program.intended_way(targets_, k));
      check_arc(k);
    }
    predict(program_);
    for (size_t k = 0; k < errors_.size(); ++k) before_[k] = errors_[k].largest;
    while (divide())
      while (true) {
        const Program divided = with_rows();
        if (!correct(divided) || drop_doubtful()) continue;
        predict(divided);
        break;
      }
    return result();
  }

 private:
  const ProgramTarget& of_text(size_t target) const { return text_.targets[target]; }
  bool is_arc(size_t target) const {
    return target > 0 && of_text(target).motion == MotionKind::arc &&
           of_text(target - 1).motion == MotionKind::via;
  }
  // Rows of a piece: its end, and of an arc its auxiliary point before it.
  size_t rows_of_piece(size_t target) const { return is_arc(target) ? 2 : 1; }
  double length(size_t target) const { return ways_[target]->length(); }

  // Arcs that cannot be divided whatever the text says.
  void check_arc(size_t k) {
    if (!ways_[k] || !is_arc(k) || !closed_[k].empty()) return;
    if (!program_.set_up.empty() && program_.set_up[k] != program_.set_up[k - 1])
      closed_[k] = "its points have different frames or tools";
    if (of_text(k).turning != ArcTurning::perhaps_through_via) return;
    constexpr double kSame = 0.1 * kDegree;
    const Pose via = base_of(k) * program_.poses[k - 1];
    const Pose there = ways_[k]->at(ways_[k]->arc->foot(via.translation));
    if (rotation_log(there.rotation.transpose() * via.rotation).norm() > kSame)
      closed_[k] = "the tool turns at its auxiliary point";
  }

  void predict(const Program& divided) {
    errors_ =
        ErrorBetween(identified_, controller_, divided, options_).errors(targets_, ways_of_rows());
  }

  Program with_rows() const {
    std::vector<int> from;
    for (const Row& row : rows_) from.push_back(static_cast<int>(row.target()));
    Program result = select(program_, from);
    for (size_t i = 0; i < rows_.size(); ++i) {
      if (!rows_[i].is_placed) continue;
      const size_t k = rows_[i].move;
      result.poses[i] = inverse(base_of(k)) * ways_[k]->at(rows_[i].t);
      if (program_.states_external) result.visits.q[i] = external_at(k, rows_[i].t);
      result.hinted[i] = false;
      result.configurations[i] = Configuration{};
    }
    find_ways(result);
    return result;
  }

  // The rows of a move come one behind the other; the first one where the move begins.
  void find_ways(Program& divided) const {
    if (program_.ways.empty()) return;
    divided.ways = program_.ways;
    for (size_t i = 0; i < rows_.size(); ++i) {
      const size_t k = rows_[i].move;
      const bool is_first = i == 0 || rows_[i - 1].move != k;
      const int begin = program_.node[k + 1 - rows_of_piece(k)];
      divided.node.push_back(program_.node[rows_[i].target()]);
      if (rows_[i].is_inserted) {
        divided.node.back() = static_cast<int>(divided.ways.size());
        divided.ways.emplace_back();
      }
      divided.ways[divided.node.back()] =
          is_first ? program_.ways[begin] : std::vector{divided.node[i - 1]};
    }
  }

  // Joints with the external axes at t on the way to a target, which move evenly.
  JointVector external_at(size_t target, double t) const {
    const JointRows& q = program_.visits.q;
    JointVector here = q[target - rows_of_piece(target)];
    joints_->move_external(here, q[target], t);
    return here;
  }

  const Pose& base_of(size_t target) const {
    return program_.set_ups.empty() ? options_.base
                                    : program_.set_ups[set_up_of(program_, target)].base;
  }

  // Corrects all rows. Moves with a point that is not corrected lose their points; then the result
  // is false.
  bool correct(const Program& divided) {
    try {
      targets_ = compensate(identified_, controller_, divided, options_);
    } catch (const UnreachableTarget& error) {
      const Row row = rows_[error.row];
      if (!row.is_placed) {
        UnreachableTarget of_program(static_cast<int>(row.target()), error.what());
        for (const auto& [other, why] : error.out_of_reach)
          if (const Row& of = rows_[other]; !of.is_placed)
            of_program.out_of_reach.emplace_back(of.target(), why);
        throw of_program;
      }
      closed_[row.move] = "the controller's model does not reach a point on its way";
      drop_rows_of_closed();
      return false;
    }
    bool is_whole = true;
    for (size_t i = 0; i < rows_.size(); ++i) {
      if (!rows_[i].is_placed || targets_[i].is_corrected) continue;
      is_whole = false;
      const auto& notes = targets_[i].notes;
      closed_[rows_[i].move] = fmt::format("a point on its way stays as programmed ({})",
                                           notes.empty() ? "" : to_string(notes.front()));
    }
    drop_rows_of_closed();
    return is_whole;
  }

  void drop_rows_of_closed() {
    std::erase_if(rows_,
                  [&](const Row& row) { return row.is_inserted && !closed_[row.move].empty(); });
    for (Row& row : rows_) row.is_placed &= closed_[row.move].empty();
  }

  // Takes out the points at which the direction of a joint with backlash is in doubt, and closes
  // their surroundings; returns whether there was one.
  bool drop_doubtful() {
    constexpr double kClosed = 0.25;  // of the shorter piece beside the point, on both sides
    if (with_backlash_.empty()) return false;
    const std::vector<Travel> of_moves = travels();
    std::vector<Row> rows;
    for (size_t i = 0; i < rows_.size(); ++i) {
      Row row = rows_[i];
      if (row.is_inserted && !row.is_via && (is_doubtful(i, of_moves[row.move]) || spoils_end(i))) {
        const double nearest = std::min(row.t - start_of(i), end_behind(i) - row.t);
        doubtful_[row.move].emplace_back(row.t - kClosed * nearest,
                                         spoils_end(i) ? 1 : row.t + kClosed * nearest);
        if (is_arc(row.move)) rows.pop_back();
        continue;
      }
      if (row.is_via && row.is_placed) {
        const bool is_first = rows.empty() || rows.back().move != row.move;
        row.is_placed = !is_first || rows_[i + 1].is_inserted;  // else the arc is whole again
        row.t = ((is_first ? 0 : rows.back().t) + rows_[i + 1].t) / 2;
      }
      rows.push_back(row);
    }
    const bool is_dropped = rows.size() < rows_.size();
    rows_ = std::move(rows);
    return is_dropped;
  }

  // The end of the piece behind that of row i.
  double end_behind(size_t i) const { return rows_[i + rows_of_piece(rows_[i].move)].t; }

  // Whether no command is right at the end of the move behind an inserted point: without the point
  // it may be.
  bool spoils_end(size_t i) const {
    const size_t end = i + rows_of_piece(rows_[i].move);
    return !rows_[end].is_inserted && misses_by_direction(end);
  }

  // A command that is right for neither direction of a joint.
  bool misses_by_direction(size_t i) const {
    return std::ranges::count(targets_[i].notes, CommandNote::arrival) > 0;
  }

  // A joint that hardly moves on the whole move keeps its direction.
  bool is_doubtful(size_t i, const Travel& travel) const {
    if (misses_by_direction(i)) return true;
    const JointVector& pace = targets_[i].pace;
    if (pace.size() == 0) return false;
    return std::ranges::any_of(with_backlash_, [&](int j) {
      return std::abs(pace[j]) < kSureMotion && travel.high[j] - travel.low[j] > kSureMotion;
    });
  }

  // Where the joints of each move stand at its points.
  std::vector<Travel> travels() const {
    std::vector<Travel> result(text_.targets.size());
    for (size_t i = 0; i < rows_.size(); ++i) {
      Travel& travel = result[rows_[i].move];
      if (travel.low.size() == 0) travel.low = travel.high = targets_[i > 0 ? i - 1 : 0].programmed;
      travel.low = travel.low.cwiseMin(targets_[i].programmed);
      travel.high = travel.high.cwiseMax(targets_[i].programmed);
    }
    return result;
  }

  // A piece begins where the one before ends.
  double start_of(size_t i) const {
    const size_t rows = rows_of_piece(rows_[i].move);
    return i >= rows && rows_[i - rows].move == rows_[i].move ? rows_[i - rows].t : 0;
  }

  // The share of the whole way at which the arm may leave it at its end and has reached it behind
  // its start: a controller reduces a blend to half of the way to the next point.
  double blend_at_end(size_t target) const {
    return std::min(0.5, of_text(target).blend / std::max(length(target), kShortest));
  }
  double blend_at_start(size_t target) const {
    return std::min(
        0.5, of_text(target - rows_of_piece(target)).blend / std::max(length(target), kShortest));
  }

  // So no point may stand within twice the blend of an end, or the corner becomes sharper.
  double first_of(size_t target) const { return 2 * blend_at_start(target); }
  double last_of(size_t target) const { return 1 - 2 * blend_at_end(target); }

  std::vector<WayToRow> ways_of_rows() const {
    std::vector<WayToRow> result;
    for (size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      WayToRow way{of_text(row.target()).follows_target};
      if (ways_[row.target()]) {
        const double start = start_of(i), size = row.t - start;
        way.from = (blend_at_start(row.move) - start) / size;
        way.to = (1 - blend_at_end(row.move) - start) / size;
      }
      if (of_text(row.target()).motion == MotionKind::arc)
        way.is_known &= row.move > 1 && of_text(row.move - 1).follows_target;
      result.push_back(way);
    }
    return result;
  }

  // Puts rows before those whose way errs by too much; returns whether there is a new one.
  bool divide() {
    std::vector<Row> rows;
    std::ranges::fill(why_, "");
    for (size_t i = 0; i < rows_.size(); ++i) {
      if (errors_[i].largest > tolerance_) add_pieces(i, new_points(i), rows);
      rows.push_back(rows_[i]);
    }
    const bool is_divided = rows.size() > rows_.size();
    rows_ = std::move(rows);
    if (is_divided) refuse_too_many();
    return is_divided;
  }

  // The rows before row i that end at the points.
  void add_pieces(size_t i, const std::vector<double>& points, std::vector<Row>& rows) const {
    const size_t move = rows_[i].move;
    if (!is_arc(move) || points.empty()) {
      for (double t : points) rows.push_back({move, false, t, true, true});
      return;
    }
    Row last_via = rows.back();  // of the piece that is divided, which keeps its end
    rows.pop_back();
    double start = start_of(i);
    for (double t : points) {
      rows.push_back({move, true, (start + t) / 2, true, true});
      rows.push_back({move, false, t, true, true});
      start = t;
    }
    last_via.t = (start + rows_[i].t) / 2;
    last_via.is_placed = true;
    rows.push_back(last_via);
  }

  // Places at which the way to a row is divided; none, with the reason in why_, if it cannot be.
  std::vector<double> new_points(size_t i) {
    const Row& row = rows_[i];
    std::string& why = why_[row.move];
    const auto refuse = [&](const std::string& reason) {
      if (why.empty()) why = reason;
      return std::vector<double>{};
    };
    if (!closed_[row.move].empty()) return refuse(closed_[row.move]);
    const double error = errors_[i].largest;
    if (std::isinf(error)) return refuse("the controller's model cannot follow it");
    // A damped end is missed whatever stands before it.
    double at_ends = 0;
    for (size_t k = 0; k <= rows_of_piece(row.move); ++k)
      at_ends = std::max(at_ends, targets_[i - k].after.position);
    if (error <= std::max(tolerance_, 1.5 * at_ends))
      return refuse("a point on it is not reached exactly, near a singular posture");
    const double start = start_of(i), size = row.t - start;
    const double shortest = shortest_share(row.move, size);
    const bool is_step = errors_[i].step_to > errors_[i].step_from;
    if (2 * shortest > 1)
      return refuse(is_step            ? "a joint reverses, and its backlash is a step"
                    : is_arc(row.move) ? "it bends within 5 deg of its arc"
                                       : "it bends within 1 mm");
    const double apart = size * shortest;
    const double first = std::max(first_of(row.move), start + apart);
    const double last = std::min(last_of(row.move), row.t - apart);
    if (first > last)
      return refuse("a point within twice the zone of an end would make its corner sharper");
    constexpr double kRounding = 1 - 1e-9;
    std::vector<double> points;
    for (double share : is_step ? around_step(errors_[i], shortest) : even_shares(error, shortest))
      if (const double t = beside_doubtful(row.move, std::clamp(start + size * share, first, last));
          t >= first && t <= last && (points.empty() || t - points.back() >= kRounding * apart))
        points.push_back(t);
    return points.empty() ? refuse("a joint reverses, and its backlash is a step") : points;
  }

  // The place on the way of a move that is nearest to t among those without doubt.
  double beside_doubtful(size_t move, double t) const {
    double from = t, to = t;  // of the doubtful part around t
    for (bool is_wider = true; is_wider;) {
      is_wider = false;
      for (const auto& [low, high] : doubtful_[move]) {
        if (low >= to || high <= from || (low >= from && high <= to)) continue;
        is_wider = true;
        from = std::min(from, low);
        to = std::max(to, high);
      }
    }
    return t - from < to - t ? from : to;
  }

  // The part of a piece, which has the size `size` of a move, that is as long as the shortest.
  double shortest_share(size_t move, double size) const {
    const double share = kShortest / (size * length(move));
    return is_arc(move) ? std::max(share, kShortestArc / (size * ways_[move]->arc->angle)) : share;
  }

  // Shares of a way at which it is divided evenly: the error of a bend falls with the square.
  std::vector<double> even_shares(double error, double shortest) const {
    const double wanted = std::ceil(std::sqrt(1.1 * error / tolerance_));
    const double most = std::floor(1 / shortest);
    const int pieces = static_cast<int>(std::min({std::max(wanted, 2.0), kMaxPieces, most}));
    std::vector<double> shares;
    for (int k = 1; k < pieces; ++k) shares.push_back(static_cast<double>(k) / pieces);
    return shares;
  }

  // On both sides of a step, at least the shortest piece apart and from the ends.
  static std::vector<double> around_step(const WayError& error, double shortest) {
    const double middle = 0.5 * (error.step_from + error.step_to);
    const double half = 0.5 * std::max(error.step_to - error.step_from, shortest);
    std::vector<double> shares;
    for (double share : {middle - half, middle + half})
      if (share >= shortest && share <= 1 - shortest) shares.push_back(share);
    if (shares.empty()) shares.push_back(0.5);
    return shares;
  }

  void refuse_too_many() const {
    size_t count = 0;
    for (size_t i = 0; i < rows_.size(); ++i) {
      if (rows_[i].is_via) continue;
      count = rows_[i].is_inserted ? count + 1 : 0;
      if (count > kMaxPoints)
        throw InputError(
            fmt::format("{}:{}: more than {} points would have to be inserted in this move for an "
                        "error of {:g} "
                        "mm between points; take a larger tolerance",
                        text_.texts[0].name, of_text(rows_[i].move).line, kMaxPoints,
                        tolerance_ / kMillimetre));
    }
  }

  DividedProgram result() const {
    DividedProgram found;
    found.between.tolerance = tolerance_;
    std::vector<double> after(text_.targets.size(), 0);
    std::vector<int> inserted(text_.targets.size(), 0);
    for (size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      const size_t k = row.move;
      if (!row.is_via && !(errors_[i].largest <= after[k])) after[k] = errors_[i].largest;
      if (!row.is_inserted) found.targets.push_back(row.is_placed ? own_via(row) : targets_[i]);
      if (!row.is_placed) continue;
      inserted[k] += !row.is_via;
      const MotionKind motion = row.is_via ? MotionKind::via : of_text(k).motion;
      std::vector<double> external =
          external_between(of_text(k - rows_of_piece(k)), of_text(k), row.t);
      if (program_.states_external)
        external = joints_->external_numbers(targets_[i].q, std::move(external));
      found.inserted.push_back({row.target(), targets_[i].pose,
                                joints_ ? joints_->arm_of(targets_[i].q) : targets_[i].q,
                                row.is_via ? 0 : blend_at(i), motion, std::move(external)});
      found.between.points.push_back(targets_[i]);
    }
    for (size_t k = 0; k < text_.targets.size(); ++k) {
      const MotionKind motion = of_text(k).motion;
      if (motion != MotionKind::line && motion != MotionKind::arc) continue;
      if (std::isnan(after[k]))
        ++found.between.unknown;
      else
        found.between.moves.push_back(
            {k, before_[k], after[k], inserted[k], after[k] > tolerance_ ? why_[k] : ""});
    }
    return found;
  }

  // An auxiliary point as it is without the division, which may have moved it.
  const CorrectedTarget& own_via(const Row& row) const { return of_program_[row.target()]; }

  // Blend of an inserted end of a piece: the room that both its sides have.
  double blend_at(size_t i) const {
    const size_t rows = rows_of_piece(rows_[i].move);
    const Row &row = rows_[i], &next = rows_[i + rows];
    const double before = length(row.move) * (row.t - start_of(i));
    const double behind = length(row.move) * (next.t - row.t);
    const double of_next = next.is_inserted ? kPassingShare * behind : of_text(row.move).blend;
    const double of_last =
        start_of(i) == 0 ? of_text(row.move - rows).blend : kPassingShare * before;
    return passing_radius(before, behind, of_last, of_next);
  }

  const Robot &identified_, &controller_;
  const RobotProgram& text_;
  const Program& program_;
  const CompensationOptions& options_;
  const double tolerance_;
  const std::optional<ProgramJoints> joints_;
  std::vector<Row> rows_;
  std::vector<int> with_backlash_;
  std::vector<std::string> closed_;  // of each target: why no point may be inserted; else empty
  // Of each target, parts of its way in which no point may be inserted.
  std::vector<std::vector<std::pair<double, double>>> doubtful_;
  std::vector<std::string> why_;     // of each target: why it is above the tolerance
  std::vector<double> before_;       // of each target
  std::vector<std::optional<Way>> ways_;  // of each target: as the program means it, R_0 from TCP
  std::vector<CorrectedTarget> of_program_, targets_;  // without inserted points; of the rows
  std::vector<WayError> errors_;
};

}  // namespace

BetweenPointsSummary summarize(const BetweenPoints& between) {
  BetweenPointsSummary summary;
  std::vector<double> before, after;
  for (const MoveBetweenPoints& move : between.moves) {
    summary.divided += move.inserted > 0;
    summary.inserted += move.inserted;
    if (std::isfinite(move.before)) before.push_back(move.before);
    if (std::isfinite(move.after)) after.push_back(move.after);
  }
  if (!before.empty()) summary.before = summarize(before);
  if (!after.empty()) summary.after = summarize(after);
  return summary;
}

DividedProgram divide_moves(const Robot& identified, const Robot& controller,
                            const RobotProgram& text, const Program& program,
                            const CompensationOptions& options, double tolerance) {
  if (!options.tool_is_measured)
    return MoveDivision(identified, controller, text, program, options, tolerance).run();
  CompensationOptions own = options;
  const Program with_tool = with_measured_tool(identified, program, own);
  return MoveDivision(identified, controller, text, with_tool, own, tolerance).run();
}

}  // namespace armtrue
