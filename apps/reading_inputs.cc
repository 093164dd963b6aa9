#include "reading_inputs.h"

#include <fmt/format.h>

#include "armtrue/kinematics/units.h"

namespace armtrue::app {
namespace {

Scanner scanner_from_numbers(const std::vector<double>& numbers) {
  constexpr double kMostView = 150;  // deg
  const bool is_ahead = numbers[0] * numbers[1] > 0 && numbers[0] != numbers[1];
  if (!is_ahead || numbers[2] <= 0 || numbers[2] > kMostView)
    throw UsageError(fmt::format(
        "--profiles: the points lie ahead of the scanner, from one z to another in mm, neither 0, "
        "in an angle of view of up to {:g} deg: from,to,angle",
        kMostView));
  return {Eigen::Vector2d(numbers[0], numbers[1]) * kMillimetre, numbers[2] * kDegree};
}

}  // namespace

SightOptions add_reading_options(Command& command, ReadingArguments& arguments) {
  const Option points =
      command.flag("--points", arguments.points,
                   "Positions, without orientations, alone or beside the others below");
  const Option distances = command.flag(
      "--distances", arguments.distances,
      "Distances from the anchors of the robot file, as without any of these if it has some");
  const Option touches = command.flag("--touches", arguments.touches,
                                      "Touches of the contacts of the robot file, one in a pose");
  const Option beams =
      command.flag("--beams", arguments.beams,
                   "What the beams of the robot file read of its planes and faces, each of the "
                   "nearest in its range");
  const Option images = command.flag("--images", arguments.images,
                                     "What the cameras of the robot file see of its boards, whole "
                                     "in poses that are chosen for it");
  const Option profiles =
      command
          .numbers(
              "--profiles", arguments.profiles, 3, "from,to,angle in mm and deg",
              "Profiles of the planes and spheres of the robot file, 20 points at most, as far "
              "ahead of the line scanner and in such an angle of view")
          .excludes(points)
          .excludes(distances)
          .excludes(touches)
          .excludes(beams)
          .excludes(images);
  return {touches, beams, images, profiles};
}

ReadingKinds reading_kinds(const ReadingArguments& arguments) {
  ReadingKinds kinds;
  kinds.points = arguments.points;
  kinds.orientation = !arguments.points;
  kinds.distances = arguments.distances;
  kinds.touches = arguments.touches;
  kinds.beams = arguments.beams;
  kinds.images = arguments.images;
  if (!arguments.profiles.empty()) kinds.profiles = scanner_from_numbers(arguments.profiles);
  return kinds;
}

}  // namespace armtrue::app
