#include "armtrue/compensation/straight_moves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "compensation/error_between.h"

namespace armtrue {
namespace {

// A controller reads ahead and blends over half a move: 1 mm is three cycles of 12 ms at 27 mm/s.
constexpr double kShortest = 1e-3;      // [m], between two points
constexpr double kLargestBlend = 1e-2;  // [m]
constexpr double kBlendShare = 0.4;     // of the way to the next point
constexpr double kMaxPieces = 16;       // of one piece, in one round
constexpr size_t kMaxPoints = 1000;     // of one move

// A point of the program, or one before it: t = 1 and t < 1 on the way to a target.
struct Row {
  size_t target = 0;
  double t = 1;
};

class Straightening {
 public:
  Straightening(const Robot& identified, const Robot& controller, const RobotProgram& text,
                const Program& program, const CompensationOptions& options, double tolerance)
      : identified_(identified),
        controller_(controller),
        text_(text),
        program_(program),
        options_(options),
        tolerance_(tolerance),
        closed_(text.targets.size()),
        why_(text.targets.size()),
        before_(text.targets.size(), 0) {
    for (size_t k = 0; k < text.targets.size(); ++k) {
      rows_.push_back({k, 1});
      const ProgramTarget& target = text.targets[k];
      closed_[k] = target.motion == MotionKind::line ? target.obstacle : "it is circular";
    }
  }

  StraightenedProgram run() {
    targets_ = compensate(identified_, controller_, program_, options_);
    const ErrorBetween of_program(identified_, controller_, program_, options_);
    for (size_t k = 1; k < targets_.size(); ++k) {
      starts_.push_back(of_program.intended_start(targets_, k));
      ends_.push_back(of_program.intended_end(targets_, k));
    }
    predict(program_);
    for (size_t k = 0; k < errors_.size(); ++k) before_[k] = errors_[k].largest;
    while (divide())
      while (true) {
        const Program divided = with_rows();
        if (!correct(divided)) continue;
        predict(divided);
        break;
      }
    return result();
  }

 private:
  const ProgramTarget& of_text(size_t target) const { return text_.targets[target]; }
  double length(size_t target) const {
    return (ends_[target - 1].translation - starts_[target - 1].translation).norm();
  }

  void predict(const Program& divided) {
    errors_ = ErrorBetween(identified_, controller_, divided, options_).errors(targets_, ways());
  }

  Program with_rows() const {
    std::vector<int> from;
    for (const Row& row : rows_) from.push_back(static_cast<int>(row.target));
    Program result = select(program_, from);
    for (size_t i = 0; i < rows_.size(); ++i) {
      if (rows_[i].t == 1) continue;
      const size_t k = rows_[i].target;
      result.poses[i] = inverse(base_of(k)) * between(starts_[k - 1], ends_[k - 1], rows_[i].t);
      result.hinted[i] = false;
      result.configurations[i] = Configuration{};
    }
    return result;
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
      const Row row = rows_[static_cast<size_t>(error.row)];
      if (row.t == 1) throw UnreachableTarget(static_cast<int>(row.target), error.what());
      closed_[row.target] = "the controller's model does not reach a point on its way";
      drop_rows_of_closed();
      return false;
    }
    bool is_whole = true;
    for (size_t i = 0; i < rows_.size(); ++i) {
      if (rows_[i].t == 1 || targets_[i].is_corrected) continue;
      is_whole = false;
      const auto& notes = targets_[i].notes;
      closed_[rows_[i].target] = fmt::format("a point on its way stays as programmed ({})",
                                             notes.empty() ? "" : to_string(notes.front()));
    }
    drop_rows_of_closed();
    return is_whole;
  }

  void drop_rows_of_closed() {
    std::erase_if(rows_, [&](const Row& row) { return row.t < 1 && !closed_[row.target].empty(); });
  }

  // A row begins where the one before ends.
  double start_of(size_t i) const {
    return i > 0 && rows_[i - 1].target == rows_[i].target ? rows_[i - 1].t : 0;
  }

  // The shares of the path at which the blend of the start ends and that of the end begins.
  double first_of(size_t target) const {
    return std::min(0.5, of_text(target - 1).blend / std::max(length(target), kShortest));
  }
  double last_of(size_t target) const {
    return std::max(0.5, 1 - of_text(target).blend / std::max(length(target), kShortest));
  }

  std::vector<WayToRow> ways() const {
    std::vector<WayToRow> result;
    for (size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      WayToRow way{of_text(row.target).motion, of_text(row.target).follows_target, 0, 1};
      if (row.target > 0 && way.motion == MotionKind::line) {
        const double start = start_of(i), size = row.t - start;
        way.from = (first_of(row.target) - start) / size;
        way.to = (last_of(row.target) - start) / size;
      }
      if (way.motion == MotionKind::arc)
        way.is_known = row.target > 1 && of_text(row.target - 1).follows_target;
      result.push_back(way);
    }
    return result;
  }

  // Inserts rows in moves with too large an error; returns whether it inserted any.
  bool divide() {
    std::vector<Row> rows;
    std::ranges::fill(why_, "");
    for (size_t i = 0; i < rows_.size(); ++i) {
      if (errors_[i].largest > tolerance_)
        for (double t : new_points(i)) rows.push_back({rows_[i].target, t});
      rows.push_back(rows_[i]);
    }
    const bool is_divided = rows.size() > rows_.size();
    rows_ = std::move(rows);
    if (is_divided) refuse_too_many();
    return is_divided;
  }

  // Places at which the move to a row is divided; empty if it cannot be divided, and why_ is the
  // reason.
  std::vector<double> new_points(size_t i) {
    const Row& row = rows_[i];
    std::string& why = why_[row.target];
    const auto refuse = [&](const std::string& reason) {
      if (why.empty()) why = reason;
      return std::vector<double>{};
    };
    if (!closed_[row.target].empty()) return refuse(closed_[row.target]);
    const double error = errors_[i].largest;
    if (std::isinf(error)) return refuse("the controller's model cannot follow it");
    // A damped end is not reached, whatever points are inserted before it.
    const double at_ends = std::max(targets_[i].after.position, targets_[i - 1].after.position);
    if (error <= std::max(tolerance_, 1.5 * at_ends))
      return refuse("a point on it is not reached exactly, near a singular posture");
    const double start = start_of(i), size = row.t - start;
    const double way = size * length(row.target);
    const bool is_step = errors_[i].step_to > errors_[i].step_from;
    if (way < 2 * kShortest)
      return refuse(is_step ? "a joint reverses, and its backlash is a step"
                            : "it bends within 1 mm");
    std::vector<double> points;
    for (double share : is_step ? around_step(errors_[i], way) : even_shares(error, way))
      if (const double t = start + size * share;
          t > first_of(row.target) && t < last_of(row.target))
        points.push_back(t);
    if (points.empty()) return refuse("it bends within the blend of an end");
    return points;
  }

  // Shares of a path that divide it evenly: the error of a bend falls with the square of their
  // number.
  std::vector<double> even_shares(double error, double way) const {
    const double wanted = std::ceil(std::sqrt(1.1 * error / tolerance_));
    const double most = std::floor(way / kShortest);
    const int pieces = static_cast<int>(std::min({std::max(wanted, 2.0), kMaxPieces, most}));
    std::vector<double> shares;
    for (int k = 1; k < pieces; ++k) shares.push_back(static_cast<double>(k) / pieces);
    return shares;
  }

  // On both sides of a step, at least the shortest piece apart and from the ends.
  static std::vector<double> around_step(const WayError& error, double way) {
    const double shortest = kShortest / way;
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
      count = rows_[i].t < 1 ? count + 1 : 0;
      if (count > kMaxPoints)
        throw InputError(
            fmt::format("{}:{}: more than {} points would have to be inserted in this move for an "
                        "error of {:g} "
                        "mm between points; take a larger tolerance",
                        text_.texts[0].name, of_text(rows_[i].target).line, kMaxPoints,
                        tolerance_ / kMillimetre));
    }
  }

  StraightenedProgram result() const {
    StraightenedProgram found;
    std::vector<double> after(text_.targets.size(), 0);
    std::vector<int> inserted(text_.targets.size(), 0);
    for (size_t i = 0; i < rows_.size(); ++i) {
      const size_t k = rows_[i].target;
      if (!(errors_[i].largest <= after[k])) after[k] = errors_[i].largest;
      if (rows_[i].t == 1) {
        found.targets.push_back(targets_[i]);
        continue;
      }
      ++inserted[k];
      found.inserted.push_back({k, targets_[i].pose, targets_[i].q, blend_at(i)});
    }
    for (size_t k = 0; k < text_.targets.size(); ++k) {
      const MotionKind motion = of_text(k).motion;
      if (motion != MotionKind::line && motion != MotionKind::arc) continue;
      if (std::isnan(after[k]))
        ++found.unknown;
      else
        found.moves.push_back(
            {k, before_[k], after[k], inserted[k], after[k] > tolerance_ ? why_[k] : ""});
    }
    return found;
  }

  // Blend of an inserted point: as large as both sides allow.
  double blend_at(size_t i) const {
    const Row &row = rows_[i], &next = rows_[i + 1];
    const double before = length(row.target) * (row.t - start_of(i));
    const double behind = length(row.target) * (next.t - row.t);
    const double of_next = next.t == 1 ? of_text(row.target).blend : kBlendShare * behind;
    const double of_last = start_of(i) == 0 ? of_text(row.target - 1).blend : kBlendShare * before;
    return std::max(1e-5, std::min({kBlendShare * before, kBlendShare * behind, behind - of_next,
                                    before - of_last, kLargestBlend}));
  }

  const Robot &identified_, &controller_;
  const RobotProgram& text_;
  const Program& program_;
  const CompensationOptions& options_;
  const double tolerance_;
  std::vector<Row> rows_;
  std::vector<std::string> closed_;  // of each target: why no point may be inserted; else empty
  std::vector<std::string> why_;     // of each target: why it is above the tolerance
  std::vector<double> before_;       // of each target
  std::vector<Pose> starts_, ends_;  // of the intended ways to targets 1 and on, R_0 from TCP
  std::vector<CorrectedTarget> targets_;  // of the rows
  std::vector<WayError> errors_;
};

}  // namespace

StraightenedProgram straighten_moves(const Robot& identified, const Robot& controller,
                                     const RobotProgram& text, const Program& program,
                                     const CompensationOptions& options, double tolerance) {
  if (!options.tool_is_measured)
    return Straightening(identified, controller, text, program, options, tolerance).run();
  CompensationOptions own = options;
  const Program with_tool = with_measured_tool(identified, program, own);
  return Straightening(identified, controller, text, with_tool, own, tolerance).run();
}

}  // namespace armtrue
