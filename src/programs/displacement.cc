#include "armtrue/programs/displacement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/matching.h"
#include "armtrue/programs/way.h"
#include "armtrue/text/input_error.h"
#include "programs/program_warnings.h"

namespace armtrue {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

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
    for (size_t k = 0; k < program_.targets.size(); ++k) {
      if (!std::isfinite(place_[k])) continue;
      note_surroundings(k);
      commands_[k] = {true, program_.targets[k].q, program_.targets[k].q, displaced(k)};
      divide(k);
    }
    DisplacedProgram result;
    result.text = rewrite(program_, commands_, between_);
    result.corrected = static_cast<int>(
        std::ranges::count_if(place_, [](double place) { return std::isfinite(place); }));
    result.left_alone =
        program_.left_alone + static_cast<int>(program_.targets.size()) - result.corrected;
    for (const auto& list : {program_.warnings, warnings_.list(), result.text.warnings})
      result.warnings.insert(result.warnings.end(), list.begin(), list.end());
    return result;
  }

 private:
  const ProgramTarget& target(size_t k) const { return program_.targets[k]; }

  void find_places() {
    std::vector<size_t> known;
    for (size_t k = 0; k < program_.targets.size(); ++k)
      if (target(k).kind == TargetKind::cartesian) known.push_back(k);
    if (known.empty())
      throw InputError(
          fmt::format("{}: all its targets are joint angles; give a program with poses",
                      program_.texts[0].name));
    Eigen::Matrix3Xd points(3, static_cast<Index>(known.size()));
    for (size_t i = 0; i < known.size(); ++i)
      points.col(static_cast<Index>(i)) = target(known[i]).pose.translation;
    const Eigen::VectorXd places = places_in_order(path_.position, points, kPathMatchTolerance);
    if (places.array().isNaN().all()) {
      const NearestPoint nearest = nearest_to(path_.position, points);
      throw InputError(fmt::format(
          "{}: no target of the program lies on the programmed path; the nearest, in line {}, is "
          "{:.3f} mm off. Is this the program of that path, and are its coordinates in the frame "
          "of the program?",
          program_.texts[0].name, target(known[static_cast<size_t>(nearest.point)]).line,
          nearest.distance / kMillimetre));
    }
    place_.assign(program_.targets.size(), std::numeric_limits<double>::quiet_NaN());
    commands_.resize(program_.targets.size());
    for (size_t i = 0; i < known.size(); ++i) place_[known[i]] = places[static_cast<Index>(i)];
    const auto off = std::ranges::find_if(known, [&](size_t k) { return std::isnan(place_[k]); });
    const auto found = (places.array() == places.array()).count();
    if (2 * found < places.size())
      warnings_.add(target(*off).line, fmt::format("only {} of the {} poses of the program lie on "
                                                   "the programmed path; is this the program of "
                                                   "that path?",
                                                   found, places.size()));
  }

  // The path is that of one tool in one frame.
  void note_surroundings(size_t k) {
    const std::pair<int, int> set_up{target(k).base, target(k).tool};
    if (!first_) first_ = set_up;
    if (set_up != *first_)
      warnings_.add(target(k).line,
                    "its frame or tool is another one than of the first corrected move; its "
                    "coordinates were taken as they stand");
  }

  Pose displaced(size_t k) const {
    Pose pose = target(k).pose;
    pose.translation += at_place(displacement_, place_[k]);
    return pose;
  }

  // The way to a target, if it and all points before it lie on the path one behind the other.
  std::optional<Way> way_to(size_t k) const {
    const MotionKind motion = target(k).motion;
    const size_t points = motion == MotionKind::arc ? 2 : 1;
    if ((motion != MotionKind::line && motion != MotionKind::arc) || k < points) return {};
    for (size_t i = k - points; i < k; ++i)
      if (!(place_[i] <= place_[i + 1]) || !target(i + 1).follows_target) return {};
    Way way{target(k - points).pose, target(k).pose, std::nullopt, target(k).turning};
    if (motion == MotionKind::line) return way;
    if (target(k - 1).motion != MotionKind::via) return {};
    way.arc =
        arc_through(way.start.translation, target(k - 1).pose.translation, way.end.translation);
    return way.arc ? std::optional(way) : std::nullopt;
  }

  // t of a sample on the way, 0 to 1; nothing beside it.
  static std::optional<double> place_on(const Way& way, const Vector3d& sample) {
    const Vector3d chord = way.end.translation - way.start.translation;
    const double t = way.arc ? way.arc->foot(sample)
                             : chord.dot(sample - way.start.translation) / chord.squaredNorm();
    if (!(t > 0 && t < 1)) return std::nullopt;
    const double off = (way.at(t).translation - sample).norm();
    return off > kPathMatchTolerance ? std::nullopt : std::optional(t);
  }

  std::vector<Knot> knots_on(const Way& way, double from, double to) const {
    std::vector<Knot> knots{{0, at_place(displacement_, from)}};
    for (auto s = static_cast<Index>(std::ceil(from)); s < path_.samples() && s <= to; ++s)
      if (const auto t = place_on(way, path_.position.col(s)); t && *t > knots.back().t)
        knots.push_back({*t, displacement_.col(s)});
    knots.push_back({1, at_place(displacement_, to)});
    return knots;
  }

  void divide(size_t k) {
    const auto way = way_to(k);
    if (!way || way->length() == 0) return;
    const size_t first = k - (way->arc ? 2 : 1);
    const std::vector<Knot> knots = knots_on(*way, place_[first], place_[k]);
    const double length = way->length();
    std::vector<size_t> divisions;
    if (way->arc) {
      const double via = way->arc->foot(target(k - 1).pose.translation);
      const double shortest = std::max(options_.spacing / length, kShortestArc / way->arc->angle);
      divisions = divide_arc(*way->arc, via, knots, options_.tolerance, shortest);
    } else {
      divisions = divide_line(knots, options_.tolerance, options_.spacing / length);
    }
    // Within the radius of an end the arm leaves the way.
    std::erase_if(divisions, [&](size_t i) {
      const double t = knots[i].t;
      return t > 0 && t < 1 &&
             (t * length < target(first).blend || (1 - t) * length < target(k).blend);
    });
    if (divisions.size() < 3) return;
    if (!target(k).obstacle.empty())
      return warnings_.add(target(k).line,
                           "the correction bends along this move, but no points "
                           "are inserted: " +
                               target(k).obstacle);
    insert(k, *way, knots, divisions);
  }

  void insert(size_t k, const Way& way, const std::vector<Knot>& knots,
              const std::vector<size_t>& divisions) {
    const auto point_at = [&](double t) {
      Pose pose = way.at(t);
      pose.translation += displacement_at(knots, t);
      return pose;
    };
    const double length = way.length();
    for (size_t i = 1; i < divisions.size(); ++i) {
      const double last = knots[divisions[i - 1]].t, t = knots[divisions[i]].t;
      if (way.arc)
        between_.push_back({k - 1, point_at((last + t) / 2), std::nullopt, 0, MotionKind::via});
      if (i + 1 == divisions.size()) break;
      const double before = length * (t - last);
      const double behind = length * (knots[divisions[i + 1]].t - t);
      const double of_next = i + 2 == divisions.size() ? target(k).blend : kPassingShare * behind;
      between_.push_back({k, point_at(t), std::nullopt, passing_radius(before, behind, 0, of_next),
                          target(k).motion});
    }
  }

  const RobotProgram& program_;
  const Path& path_;
  const Eigen::Matrix3Xd displacement_;
  const DisplacementOptions options_;
  ProgramWarnings warnings_;
  std::vector<double> place_;  // of each target on the path, in samples; NaN: off the path
  std::vector<ProgramCommand> commands_;
  std::vector<ProgramPointBetween> between_;
  std::optional<std::pair<int, int>> first_;  // frame and tool of the first corrected target
};

}  // namespace

DisplacedProgram displace_program(const RobotProgram& program, const Path& programmed,
                                  const Eigen::Matrix3Xd& corrected,
                                  const DisplacementOptions& options) {
  return Displacement(program, programmed, corrected, options).run();
}

}  // namespace armtrue
