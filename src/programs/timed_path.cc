#include "armtrue/programs/timed_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "armtrue/kinematics/pose.h"
#include "armtrue/programs/way.h"
#include "programs/program_warnings.h"

namespace armtrue {
namespace {

// Moves that follow one another.
struct MovesInARow {
  struct Move {
    Way way;
    size_t target;
  };
  std::vector<Move> moves;
  double length() const {
    double sum = 0;
    for (const Move& move : moves) sum += move.way.length();
    return sum;
  }
};

// The way of the move that ends at target k, if it is straight or circular and its start is known.
std::optional<Way> way_of(const RobotProgram& program, size_t k) {
  const ProgramTarget& end = program.targets[k];
  const bool is_arc = end.motion == MotionKind::arc;
  const size_t points = is_arc ? 2 : 1;
  if ((!is_arc && end.motion != MotionKind::line) || k < points || end.ends_elsewhere) return {};
  const ProgramTarget &start = program.targets[k - points], &next = program.targets[k - points + 1];
  if (is_arc && next.motion != MotionKind::via) return {};
  if (start.kind == TargetKind::joints || end.kind == TargetKind::joints || !next.follows_target ||
      start.base != end.base || start.tool != end.tool)
    return {};
  Way way{start.pose, end.pose, std::nullopt, end.turning};
  if (!start.has_orientation) way.start.rotation = way.end.rotation;
  if (is_arc) {
    way.arc = arc_through(way.start.translation, next.pose.translation, way.end.translation);
    if (!way.arc) return {};
  }
  return way;
}

std::vector<MovesInARow> rows_of(const RobotProgram& program) {
  std::vector<MovesInARow> rows;
  std::optional<size_t> last;  // target at which the row ends
  for (size_t k = 0; k < program.targets.size(); ++k) {
    const ProgramTarget& target = program.targets[k];
    if (target.motion == MotionKind::via) continue;
    const std::optional<Way> way = target.never_runs ? std::nullopt : way_of(program, k);
    const size_t start = k - (target.motion == MotionKind::arc ? 2 : 1);
    if (way && last != start) rows.emplace_back();
    if (way) rows.back().moves.push_back({*way, k});
    last = way ? std::optional(k) : std::nullopt;
  }
  std::erase_if(rows, [](const MovesInARow& row) { return row.length() == 0; });
  return rows;
}

// Way and time of a motion from a stop to the next one: speeds up, keeps the feed, slows down.
class StopToStop {
 public:
  StopToStop(double length, const ProgramSpeed& speed)
      : length_(length),
        acceleration_(speed.acceleration),
        feed_(std::min(speed.feed, std::sqrt(length * speed.acceleration))),
        ramp_(feed_ / acceleration_) {}

  double duration() const { return feed_ > 0 ? length_ / feed_ + ramp_ : 0; }

  double time_at(double s) const {
    if (2 * s > length_) return duration() - time_at(length_ - s);
    const double ramp_length = feed_ * ramp_ / 2;
    return s < ramp_length ? std::sqrt(2 * s / acceleration_) : ramp_ / 2 + s / feed_;
  }

  double way_at(double t) const {
    if (2 * t > duration()) return length_ - way_at(duration() - t);
    return t < ramp_ ? acceleration_ * t * t / 2 : feed_ * (t - ramp_ / 2);
  }

 private:
  double length_, acceleration_, feed_, ramp_;
};

// Samples of a row of moves.
class Sampler {
 public:
  Sampler(const RobotProgram& program, const ProgramSpeed& speed)
      : program_(program), speed_(speed) {}

  Path path_of(const MovesInARow& row) {
    const auto& moves = row.moves;
    stand(moves.front().way.start);
    for (size_t first = 0; first < moves.size();) {
      size_t last = first;
      while (last + 1 < moves.size() && passes(moves[last].target)) ++last;
      move(moves, first, last);
      first = last + 1;
    }
    stand(moves.back().way.end);
    return path(row);
  }

 private:
  bool passes(size_t k) const {
    return program_.targets[k].is_passed || program_.targets[k].blend > 0;
  }

  void add(double time, const Pose& pose) {
    times_.push_back(time);
    poses_.push_back(pose);
  }

  void stand(const Pose& pose) {
    const auto count = static_cast<int>(std::lround(speed_.standstill / speed_.period));
    const double begin = times_.empty() ? -speed_.period : times_.back();
    for (int i = 1; i <= count; ++i) add(begin + i * speed_.period, pose);
  }

  // From the start of a move to the end of a later one, without a stop. Samples stand on the grid
  // of the period and at each point; one of the grid that is nearer to a point than half a period
  // is left out.
  void move(const std::vector<MovesInARow::Move>& moves, size_t first, size_t last) {
    double length = 0;
    for (size_t m = first; m <= last; ++m) length += moves[m].way.length();
    const StopToStop motion(length, speed_);
    const double begin = times_.back();
    double done = 0;  // the way before this move
    for (size_t m = first; m <= last; ++m) {
      const Way& way = moves[m].way;
      const double whole = way.length();
      if (whole == 0) continue;
      const double end = motion.time_at(std::min(done + whole, length));
      for (double t = motion.time_at(done) + speed_.period; t < end - speed_.period / 2;
           t += speed_.period)
        add(begin + t, way.at(std::clamp((motion.way_at(t) - done) / whole, 0.0, 1.0)));
      done += whole;
      add(begin + end, way.end);
    }
  }

  Path path(const MovesInARow& row) const {
    const bool has_orientations = std::ranges::all_of(
        row.moves, [&](const auto& move) { return program_.targets[move.target].has_orientation; });
    const auto samples = static_cast<Eigen::Index>(times_.size());
    Path result;
    result.time = Eigen::Map<const Eigen::VectorXd>(times_.data(), samples);
    result.position.resize(Eigen::NoChange, samples);
    if (has_orientations) result.orientation.resize(Eigen::NoChange, samples);
    for (Eigen::Index i = 0; i < samples; ++i) {
      result.position.col(i) = poses_[i].translation;
      if (has_orientations) result.orientation.col(i) = abc_from_rotation(poses_[i].rotation);
    }
    return result;
  }

  const RobotProgram& program_;
  const ProgramSpeed speed_;
  std::vector<double> times_;
  std::vector<Pose> poses_;
};

std::string words_of(const RobotProgram& program, const MovesInARow& row) {
  const int first = program.targets[row.moves.front().target].line;
  const int last = program.targets[row.moves.back().target].line;
  return first == last ? fmt::format("line {}", first) : fmt::format("lines {} to {}", first, last);
}

std::vector<std::string> warnings_of(const RobotProgram& program,
                                     const std::vector<MovesInARow>& rows,
                                     const MovesInARow& longest) {
  ProgramWarnings warnings(program.texts[0].name);
  for (const MovesInARow& row : rows)
    if (&row != &longest)
      warnings.add(program.targets[row.moves.front().target].line,
                   "no part of the path, which is that of " + words_of(program, longest) +
                       ": the way between is not straight or circular, or not known");
  for (const MovesInARow::Move& move : longest.moves)
    if (program.targets[move.target].is_in_loop)
      warnings.add(program.targets[move.target].line,
                   "stands in a loop; the path has one turn of it");
  std::vector<std::string> all = program.warnings;
  const std::vector<std::string> own = warnings.list();
  all.insert(all.end(), own.begin(), own.end());
  return all;
}

}  // namespace

TimedProgram timed_path(const RobotProgram& program, const ProgramSpeed& speed) {
  const std::vector<MovesInARow> rows = rows_of(program);
  if (rows.empty())
    throw InputError(program.texts[0].name +
                     ": no straight or circular move between two poses in one frame and with one "
                     "tool; moves of joints have no way that the program states: give the trace of "
                     "the controller as the path");
  const auto longest = std::ranges::max_element(rows, {}, &MovesInARow::length);
  return {Sampler(program, speed).path_of(*longest), warnings_of(program, rows, *longest)};
}

}  // namespace armtrue
