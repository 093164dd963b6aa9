#include "armtrue/programs/displacement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/programs/way.h"
#include "armtrue/text/input_error.h"
#include "programs/division.h"
#include "programs/matching.h"
#include "programs/program_warnings.h"

namespace armtrue {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kOff = std::numeric_limits<double>::quiet_NaN();

class Displacement {
 public:
  Displacement(const RobotProgram& program, const Path& path, const Eigen::Matrix3Xd& corrected,
               const DisplacementOptions& options)
      : program_(program),
        path_(path),
        displacement_(corrected - path.position),
        options_(options),
        warnings_(program.texts[0].name) {}

  DisplacedProgram run() {
    find_places();
    note_few_found();
    for (size_t k = 0; k < program_.targets.size(); ++k) note(k);
    find_commands();
    for (size_t k = 0; k < program_.targets.size(); ++k) divide(k);
    DisplacedProgram result;
    result.text = rewrite(program_, commands_, between_, options_.by);
    if (program_.own_model_line > 0)
      result.warnings.push_back(fmt::format(
          "{}:{}: {}: the controller corrects the arm's geometry itself; measure and run with it "
          "in the same state, or both corrections add up",
          program_.texts[program_.own_model_text].name, program_.own_model_line,
          program_.dialect->facts().own_model));
    result.left_alone = program_.left_alone;
    for (size_t k = 0; k < program_.targets.size(); ++k) {
      result.corrected += is_found(k);
      result.left_alone += !is_found(k) && target(k).motion != MotionKind::via;
    }
    for (const auto& list : {program_.warnings, warnings_.list(), result.text.warnings})
      result.warnings.insert(result.warnings.end(), list.begin(), list.end());
    return result;
  }

 private:
  const ProgramTarget& target(size_t k) const { return program_.targets[k]; }
  bool is_found(size_t k) const { return std::isfinite(place_[k]); }

  void find_places() {
    for (size_t k = 0; k < program_.targets.size(); ++k)
      if (target(k).kind == TargetKind::cartesian) known_.push_back(k);
    if (known_.empty())
      throw InputError(
          fmt::format("{}: all its targets are joint angles; give a program with poses, of UR the "
                      ".script beside a .urp",
                      program_.texts[0].name));
    Eigen::Matrix3Xd points(3, known_.size());
    for (size_t i = 0; i < known_.size(); ++i) points.col(i) = target(known_[i]).pose.translation;
    const Eigen::VectorXd places = places_in_order(path_.position, points, kPathMatchTolerance);
    if (places.array().isNaN().all()) {
      const NearestPoint nearest = nearest_to(path_.position, points);
      const Vector3d point = points.col(nearest.point) / kMillimetre;
      throw InputError(fmt::format(
          "{}: no point of the program lies on the programmed path; the nearest, in line {} at "
          "({:.3f}, {:.3f}, {:.3f}) mm, is {:.3f} mm off. Is this the program of that path, not "
          "corrected before, and are its coordinates in the frame of the program?",
          program_.texts[0].name, target(known_[nearest.point]).line, point.x(), point.y(),
          point.z(), nearest.distance / kMillimetre));
    }
    place_.assign(program_.targets.size(), kOff);
    for (size_t i = 0; i < known_.size(); ++i) place_[known_[i]] = places[i];
  }

  // Approach and retreat lie off the path. If most points do, the path is that of another program.
  void note_few_found() {
    const auto found = std::ranges::count_if(known_, [&](size_t k) { return is_found(k); });
    if (2 * found >= static_cast<std::ptrdiff_t>(known_.size())) return;
    const size_t off = *std::ranges::find_if(known_, [&](size_t k) { return !is_found(k); });
    warnings_.add(target(off).line,
                  fmt::format("only {} of the {} points of the program lie on the programmed path; "
                              "is this the program of that path?",
                              found, known_.size()));
  }

  // The path is that of one tool in one frame.
  void note(size_t k) {
    const ProgramTarget& here = target(k);
    if (!is_found(k)) {
      if (here.kind == TargetKind::joints)
        warnings_.add(here.line, "left alone: joint angles, which need the robot");
      else if (here.motion != MotionKind::via)
        warnings_.add(here.line, "left alone: ends off the path");
      return;
    }
    if (!first_) first_ = k;
    const ProgramTarget& first = target(*first_);
    const auto warn_of = [&](const std::string& what, const char* but) {
      warnings_.add(here.line, fmt::format("{} is another one than of the first corrected move "
                                           "(line {}); {}",
                                           what, first.line, but));
    };
    const DialectFacts& facts = program_.dialect->facts();
    if (first.base != here.base) warn_of(facts.frame, "its coordinates were taken as they stand");
    if (first.tool != here.tool) warn_of(facts.tool, "the record shows the point of one tool");
    if (here.is_room_tool)
      warnings_.add(here.line,
                    "its tool stands in the room (#TCP): the path is that of the part, and turns "
                    "with it");
    if (here.is_in_loop)
      warnings_.add(here.line, "stands in a loop; every turn gets the correction of the first");
  }

  // A point off the path keeps its text: coordinates that it leaves out are those of the point
  // before.
  void find_commands() {
    commands_.resize(program_.targets.size());
    for (size_t k = 0; k < program_.targets.size(); ++k) {
      const ProgramTarget& here = target(k);
      if (here.kind == TargetKind::joints) continue;
      Pose pose = here.pose;
      const ProgramPoint& point = program_.points[here.point];
      const bool is_moved = !is_found(k) && !point.is_expression;
      for (int i = 0; i < 3; ++i)
        if (is_moved && !point.numbers[i].is_written())
          pose.translation[i] = commanded_before(k, i).value_or(pose.translation[i]);
      pose.translation += displacement_of(k);
      commands_[k] = {true, here.q, here.q, pose, {}};
    }
  }

  // A coordinate where the move to a target starts, if all its starts have the same.
  std::optional<double> commanded_before(size_t k, int coordinate) const {
    std::optional<double> common;
    for (size_t start : target(k).starts) {
      if (start >= k) return {};  // the turn before of a loop
      const double here = commands_[start].pose.translation[coordinate];
      if (common.value_or(here) != here) return {};
      common = here;
    }
    return common;
  }

  Vector3d displacement_of(size_t k) const {
    return is_found(k) ? at_place(displacement_, place_[k]) : Vector3d::Zero();
  }

  // The way to a target from the one before, or before its auxiliary point, that lies on the path
  // whole or, of a straight move that comes from there in any case, in part.
  std::optional<Way> way_to(size_t k) const {
    const bool is_arc = target(k).motion == MotionKind::arc;
    if (!is_arc && target(k).motion != MotionKind::line) return {};
    if (target(k).ends_elsewhere || k < (is_arc ? 2 : 1) ||
        (is_arc && target(k - 1).motion != MotionKind::via))
      return {};
    const size_t first = start_of(k), next = first + 1;
    if (target(first).kind == TargetKind::joints || target(k).kind == TargetKind::joints) return {};
    if (target(first).base != target(k).base || target(first).tool != target(k).tool) return {};
    Way way{target(first).pose, target(k).pose, std::nullopt, target(k).turning};
    if (!target(k).has_orientation) way.start.rotation = way.end.rotation;
    if (is_arc) {
      way.arc =
          arc_through(way.start.translation, target(k - 1).pose.translation, way.end.translation);
      if (!way.arc) return {};
    }
    if (way.length() == 0) return {};
    if (is_found(first) && is_found(k)) {
      if (!(place_[first] <= place_[k])) return {};
      return target(next).follows_target || is_on_path(way, place_[first], place_[k])
                 ? std::optional(way)
                 : std::nullopt;
    }
    const bool is_begun = is_found(first) || is_found(k);
    return !is_arc && is_begun && target(next).follows_target ? std::optional(way) : std::nullopt;
  }

  // The target at which the move to k begins.
  size_t start_of(size_t k) const { return k - (target(k).motion == MotionKind::arc ? 2 : 1); }

  // Whether the path between two of its places coincides with the way, so that the arm drove it.
  bool is_on_path(const Way& way, double from, double to) const {
    for (auto s = static_cast<Index>(std::ceil(from)); s <= static_cast<Index>(to); ++s)
      if (!place_on(way, path_.position.col(s))) return false;
    return true;
  }

  // t of a sample on the way, 0 to 1, and that of the end if it is there; nothing beside it.
  static std::optional<double> place_on(const Way& way, const Vector3d& sample) {
    const Vector3d chord = way.end.translation - way.start.translation;
    const double share = kPathMatchTolerance / way.length();
    double t = way.arc ? way.arc->foot(sample)
                       : chord.dot(sample - way.start.translation) / chord.squaredNorm();
    if (way.arc && t > kTurn / way.arc->angle - share) t -= kTurn / way.arc->angle;
    if (!(t >= -share && t <= 1 + share)) return {};
    if ((way.at(t).translation - sample).norm() > kPathMatchTolerance) return {};
    return t <= share ? 0 : t >= 1 - share ? 1 : t;
  }

  // The displacement along the way to target k; 0 at an end off the path.
  std::vector<Knot> knots_on(const Way& way, size_t k) const {
    const size_t first = start_of(k);
    std::vector<Knot> inside;
    const auto add = [&](Index s) {
      const auto t = place_on(way, path_.position.col(s));
      if (t && *t > 0 && *t < 1) inside.push_back({*t, displacement_.col(s)});
      return t.has_value();
    };
    const auto begin = static_cast<Index>(std::ceil(found_before(k)));
    const auto end = std::min<Index>(static_cast<Index>(found_from(k)) + 1, path_.samples());
    if (is_found(first)) {
      for (Index s = begin; s < end; ++s)
        if (!add(s) && !is_found(k)) break;
    } else {
      for (Index s = end; s-- > begin;)
        if (!add(s)) break;
      std::ranges::reverse(inside);
    }
    std::vector<Knot> knots{{0, displacement_of(first)}};
    for (const Knot& knot : inside)
      if (knot.t > knots.back().t) knots.push_back(knot);
    knots.push_back({1, displacement_of(k)});
    return knots;
  }

  // The places of the last end of a move on the path before target k, and of the next from it on.
  double found_before(size_t k) const {
    for (size_t i = start_of(k) + 1; i-- > 0;)
      if (is_found(i)) return place_[i];
    return 0;
  }
  double found_from(size_t k) const {
    for (size_t i = k; i < place_.size(); ++i)
      if (is_found(i)) return place_[i];
    return static_cast<double>(path_.samples());
  }

  void divide(size_t k) {
    const auto way = way_to(k);
    if (!way) return note_undivided_arc(k);
    const size_t first = start_of(k);
    std::vector<Knot> knots = knots_on(*way, k);
    if (std::ranges::all_of(knots, [](const Knot& knot) { return knot.displacement.isZero(0); }))
      return;
    const double length = way->length();
    std::vector<size_t> divisions;
    if (way->arc) {
      const double via = way->arc->foot(target(k - 1).pose.translation);
      commands_[k - 1].pose.translation =
          target(k - 1).pose.translation + displacement_at(knots, via);
      const double shortest =
          target(k).insertion.before_line.empty()
              ? std::max(options_.spacing / length, kShortestArc / way->arc->angle)
              : options_.spacing / length;
      divisions = divide_arc(*way->arc, via, knots, options_.tolerance, shortest);
    } else {
      move_along(*way, knots);
      divisions = divide_line(knots, options_.tolerance, options_.spacing / length);
    }
    // Within the radius of an end the arm leaves the way.
    std::erase_if(divisions, [&](size_t i) {
      const double t = knots[i].t;
      return i > 0 && i + 1 < knots.size() &&
             (t * length < target(first).blend || (1 - t) * length < target(k).blend);
    });
    if (divisions.size() < 3) return;
    if (const std::string why = obstacle(first, k); !why.empty())
      return warnings_.add(
          target(k).line,
          "the correction bends along this move, but no points are inserted: " + why);
    insert(k, *way, knots, divisions);
  }

  // An arc that cannot be followed: its points are corrected one by one.
  void note_undivided_arc(size_t k) {
    if (target(k).motion != MotionKind::arc || target(k).ends_elsewhere) return;
    if (k > 0 && (is_found(k) || is_found(k - 1)))
      warnings_.add(target(k).line,
                    "an arc that starts or ends off the path: only its points are corrected, what "
                    "lies between follows");
  }

  // The component of a displacement along a line does not bend it: it moves the knot along the
  // line.
  static void move_along(const Way& way, std::vector<Knot>& knots) {
    const Vector3d along = (way.end.translation - way.start.translation).normalized();
    for (size_t i = 0; i < knots.size(); ++i) {
      const double forward = along.dot(knots[i].displacement);
      knots[i].displacement -= forward * along;
      knots[i].t += forward / way.length();
      if (i > 0) knots[i].t = std::max(knots[i].t, knots[i - 1].t);
    }
  }

  std::string obstacle(size_t first, size_t k) const {
    const auto& numbers = program_.points[target(k).point].numbers;
    const bool is_turned = std::any_of(numbers.begin() + 3, numbers.end(),
                                       [](const ProgramNumber& n) { return n.is_written(); });
    const bool is_known = target(first).has_orientation && target(k).has_orientation;
    if (target(k).obstacle.empty() && is_turned && !is_known)
      return "the orientation before it is not known";
    return target(k).obstacle;
  }

  void insert(size_t k, const Way& way, const std::vector<Knot>& knots,
              const std::vector<size_t>& divisions) {
    const size_t first = start_of(k);
    const auto add = [&](size_t row, const Knot& knot, double blend, MotionKind motion) {
      const double t = std::clamp(knot.t, 0.0, 1.0);
      Pose pose = way.at(t);
      if (!way.arc)
        pose.translation += (knot.t - t) * (way.end.translation - way.start.translation);
      pose.translation += knot.displacement;
      between_.push_back(
          {row, pose, std::nullopt, blend, motion, external_between(target(first), target(k), t)});
    };
    const double length = way.length();
    for (size_t i = 1; i < divisions.size(); ++i) {
      const size_t from = divisions[i - 1], to = divisions[i];
      const double last = knots[from].t, t = knots[to].t;
      const bool is_end = i + 1 == divisions.size();
      const bool is_line = !way.arc || (!target(k).insertion.before_line.empty() &&
                                        is_straight(*way.arc, knots, from, to, options_.tolerance));
      if (way.arc && (!is_line || is_end)) {
        const double middle = (last + t) / 2;
        add(k - 1, {middle, displacement_at(knots, middle)}, 0, MotionKind::via);
        between_.back().is_left_out = is_line;
      }
      if (is_end) break;
      const double before = length * (t - last);
      const double behind = length * (knots[divisions[i + 1]].t - t);
      const double of_next = i + 2 == divisions.size() ? target(k).blend : kPassingShare * behind;
      add(k, knots[to], passing_radius(before, behind, 0, of_next),
          is_line ? MotionKind::line : MotionKind::arc);
    }
  }

  const RobotProgram& program_;
  const Path& path_;
  const Eigen::Matrix3Xd displacement_;
  const DisplacementOptions options_;
  ProgramWarnings warnings_;
  std::vector<size_t> known_;    // targets whose position is known
  std::vector<double> place_;    // of each target on the path, in samples; kOff: off the path
  std::optional<size_t> first_;  // corrected target
  std::vector<ProgramCommand> commands_;
  std::vector<ProgramPointBetween> between_;
};

}  // namespace

bool lies_on_corrected(const RobotProgram& program, const Eigen::Matrix3Xd& programmed,
                       const Eigen::Matrix3Xd& corrected) {
  // FANUC states positions to 1.5 um in each coordinate, and less than that shows nothing.
  constexpr double kOn = 2.6e-6, kOff = 6e-6;  // [m]
  std::vector<Vector3d> targets;
  for (const ProgramTarget& target : program.targets)
    if (target.kind == TargetKind::cartesian) targets.push_back(target.pose.translation);
  if (targets.empty()) return false;
  Eigen::Matrix3Xd points(3, targets.size());
  for (size_t i = 0; i < targets.size(); ++i) points.col(i) = targets[i];
  const auto distances = [&](const Eigen::Matrix3Xd& path) {
    const Eigen::VectorXd places = places_in_order(path, points, kPathMatchTolerance);
    Eigen::VectorXd result(places.size());
    for (Index i = 0; i < places.size(); ++i)
      result[i] = std::isfinite(places[i]) ? (at_place(path, places[i]) - points.col(i)).norm()
                                           : kPathMatchTolerance;
    return result;
  };
  const Eigen::VectorXd own = distances(programmed), other = distances(corrected);
  Index on_own = 0, on_other = 0;
  for (Index i = 0; i < own.size(); ++i) {
    on_own += own[i] < kOn && other[i] > kOff;
    on_other += other[i] < kOn && own[i] > kOff;
  }
  return on_other > on_own;
}

DisplacedProgram displace_program(const RobotProgram& program, const Path& programmed,
                                  const Eigen::Matrix3Xd& corrected,
                                  const DisplacementOptions& options) {
  return Displacement(program, programmed, corrected, options).run();
}

}  // namespace armtrue
