// Images of boards: corners against where a photograph has them, and from photographs to an arm.

#include <gmock/gmock.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/images/find_corners.h"
#include "armtrue/import/import_images.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/board_pattern.h"
#include "armtrue/text/input_error.h"
#include "photograph.h"
#include "support/temporary_file.h"

namespace armtrue::image_test {
namespace {

using namespace armtrue_oracle;

// As OpenCV prints them: the first of DICT_4X4_50, and of AprilTag's 36h11.
const std::vector<std::string> kFourByFour{
    ".#..#.#.##..##.#", "####.....##..#.#", "##..##..##.#..#.", ".##..##.#.###..#",
    "#.#.#.##.##....#", "#....##...##..#.", ".##....###.#...#", "..###.##....##.#",
    ".......#..#..#.#", "..##....#.#.#..#", ".....##..##.###.", "###.###..#.##...",
    "####...#.#..#...", "##.#.#.#####....", "##.##.##.#..###.", "##.##..###.....#",
    "#.###..##..##.#."};
// Published codes of AprilTag 36h11, row by row, the first bit the highest; 1 is white.
const std::vector<std::uint64_t> kTag36h11{0xd5d628584, 0xd97f18b49, 0xdd280910e,
                                           0xe479e9c98, 0xebcbca822, 0xf31dab3ac};

std::vector<std::string> published_tags() {
  std::vector<std::string> tags;
  for (std::uint64_t code : kTag36h11) {
    std::string& tag = tags.emplace_back();
    for (int bit = 35; bit >= 0; --bit) tag += (code >> bit) & 1 ? '.' : '#';
  }
  return tags;
}

ImageCorners found_in(const std::string& pattern, const std::string& image, bool explain = false) {
  ImageCorners found;
  std::string error;
  armtrue_find_corners(board_pattern(pattern), TemporaryFile(image).path, explain, found, error);
  if (!error.empty()) throw InputError(error);
  return found;
}

Eye camera() {
  Eye eye;
  eye.width = 640;
  eye.height = 480;
  eye.fx = 600;
  eye.fy = 602;
  eye.cx = 322.3;
  eye.cy = 236.8;
  eye.distortion = {-0.12, 0.08, 0.0007, -0.0004, 0.01};
  return eye;
}

// The middle of the points before the camera, tilted and turned.
KDL::Frame sight(const std::vector<ArtefactPoint>& points, double depth, double turn) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const ArtefactPoint& point : points)
    middle += point.position / static_cast<double>(points.size());
  const KDL::Rotation rotation =
      KDL::Rotation::RotX(0.35) * KDL::Rotation::RotY(-0.3) * KDL::Rotation::RotZ(turn);
  return {rotation,
          KDL::Vector(0.01, -0.015, depth) - rotation * KDL::Vector(middle.x(), middle.y(), 0)};
}

struct Misses {
  int found = 0, all = 0;
  double rms = 0, worst = 0, mean_u = 0, mean_v = 0;
};

Misses misses(const ImageCorners& found, const std::string& pattern, const Eye& eye,
              const KDL::Frame& seen) {
  const std::vector<ArtefactPoint> points = points_of(board_pattern(pattern));
  Misses result;
  result.all = static_cast<int>(points.size());
  for (const SeenCorner& corner : found.corners) {
    const Eigen::Vector3d& point = points[static_cast<size_t>(corner.point)].position;
    const auto [u, v] = pixel_of(eye, seen * KDL::Vector(point.x(), point.y(), 0));
    const double miss = std::hypot(corner.u - u, corner.v - v);
    result.rms += miss * miss;
    result.worst = std::max(result.worst, miss);
    result.mean_u += corner.u - u;
    result.mean_v += corner.v - v;
    ++result.found;
  }
  if (result.found == 0) return result;
  result.rms = std::sqrt(result.rms / result.found);
  result.mean_u /= result.found;
  result.mean_v /= result.found;
  return result;
}

struct Board {
  std::string pattern;
  Print print;
  double worst;  // px that a corner may be off
};

std::vector<Board> boards() {
  return {
      {"checkerboard:9x6:25mm", checkerboard(9, 6, 0.025), 0.15},
      {"charuco:7x5:30mm", charuco(7, 5, 0.03, kFourByFour, 8), 0.25},
      {"apriltag:3x2:60mm:22.5mm", tags(3, 2, 0.06, 3, published_tags()), 0.25},
      {"circles:7x6:25mm", disks(7, 6, 0.025, false), 0.3},
      {"asymmetric-circles:4x11:20mm", disks(4, 11, 0.02, true), 0.3},
  };
}

// Turned in all directions but those that a symmetric board hides; with blur and noise.
TEST(Images, CornersAreWhereThePhotographHasThem) {
  const Eye eye = camera();
  const Photographer photographer(eye);
  Dice dice(3);
  for (const Board& board : boards()) {
    const BoardPattern pattern = board_pattern(board.pattern);
    for (double turn : {0.1, 2.6}) {
      if (is_symmetric(pattern) && std::abs(turn) > 1.5) continue;
      const KDL::Frame seen = sight(points_of(pattern), 0.42, turn);
      const std::string image = photographer.photograph(board.print, seen, {}, dice);
      const ImageCorners found = found_in(board.pattern, image);
      EXPECT_EQ(found.width, 640);
      EXPECT_EQ(found.height, 480);
      const Misses miss = misses(found, board.pattern, eye, seen);
      std::printf(
          "%-30s turn %4.1f: %3d of %3d corners, rms %.3f px, worst %.3f, mean %+.3f %+.3f\n",
          board.pattern.c_str(), turn, miss.found, miss.all, miss.rms, miss.worst, miss.mean_u,
          miss.mean_v);
      EXPECT_EQ(miss.found, miss.all) << board.pattern;
      EXPECT_LT(miss.worst, board.worst) << board.pattern;
    }
  }
}

// Boards of Kalibr count their tags from below. Those of OpenCV before 4.6 begin with white if they
// have an even number of rows, and count the same markers.
TEST(Images, BoardsOfOtherPrintersAreUnderstood) {
  const Eye eye = camera();
  const Photographer photographer(eye);
  Dice dice(4);
  const std::vector<std::string> tag = published_tags();
  const std::string pattern = "apriltag:3x2:60mm:22.5mm";
  const KDL::Frame seen = sight(points_of(board_pattern(pattern)), 0.42, 0.4);
  const Print kalibr = tags(3, 2, 0.06, 3, {tag[3], tag[4], tag[5], tag[0], tag[1], tag[2]});
  const Misses miss = misses(found_in(pattern, photographer.photograph(kalibr, seen, {}, dice)),
                             pattern, eye, seen);
  EXPECT_EQ(miss.found, 24);
  EXPECT_LT(miss.worst, 0.25);

  const std::string now = "charuco:7x4:30mm", before = "charuco:7x4:30mm:legacy";
  const KDL::Frame there = sight(points_of(board_pattern(now)), 0.42, 0.4);
  const std::string legacy =
      photographer.photograph(charuco(7, 4, 0.03, kFourByFour, 8, true), there, {}, dice);
  const Misses of_legacy = misses(found_in(before, legacy), before, eye, there);
  EXPECT_EQ(of_legacy.found, 18);
  EXPECT_LT(of_legacy.worst, 0.25);
  const ImageCorners wrong = found_in(now, legacy, true);
  EXPECT_TRUE(wrong.corners.empty());
  EXPECT_THAT(wrong.hint, testing::HasSubstr("add ':legacy'"));
}

// What is asked for and what is printed differ: no corner, and the reason.
TEST(Images, AnotherBoardIsNotTakenForThisOne) {
  const Eye eye = camera();
  const Photographer photographer(eye);
  Dice dice(5);
  const auto hint = [&](const std::string& asked, const std::string& printed, const Print& print) {
    const KDL::Frame seen = sight(points_of(board_pattern(printed)), 0.42, 0.4);
    const ImageCorners found =
        found_in(asked, photographer.photograph(print, seen, {}, dice), true);
    EXPECT_TRUE(found.corners.empty()) << asked << " in an image of " << printed;
    return found.hint;
  };
  const Print seven_by_five = charuco(7, 5, 0.03, kFourByFour, 8);
  EXPECT_THAT(hint("charuco:5x7:30mm", "charuco:7x5:30mm", seven_by_five),
              testing::HasSubstr("do not lie as on a board of 5x7"));
  EXPECT_THAT(hint("charuco:7x5:30mm:6x6", "charuco:7x5:30mm", seven_by_five),
              testing::HasSubstr("of the family 4x4"));
  EXPECT_THAT(hint("apriltag:3x2:60mm:10mm", "apriltag:3x2:60mm:22.5mm",
                   tags(3, 2, 0.06, 3, published_tags())),
              testing::HasSubstr("measure side and gap"));
  EXPECT_EQ(hint("checkerboard:8x5:25mm", "checkerboard:9x6:25mm", checkerboard(9, 6, 0.025)), "");
}

TEST(Images, FilesThatAreNoImageAreNamed) {
  const auto error_of = [](const std::string& content) -> std::string {
    try {
      found_in("checkerboard:9x6:25mm", content);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  Dice dice(6);
  const Photographer photographer(camera());
  const std::string image = photographer.photograph(
      checkerboard(9, 6, 0.025),
      sight(points_of(board_pattern("checkerboard:9x6:25mm")), 0.42, 0.4), {}, dice);
  EXPECT_EQ(error_of(image), "no error");
  for (const std::string& wrong :
       {std::string(), std::string("no image"), image.substr(0, image.size() / 2),
        image.substr(0, 20), std::string("\x89PNG\r\n\x1a\n"), std::string("\xFF\xD8\xFF\xE0")})
    EXPECT_THAT(error_of(wrong),
                testing::HasSubstr("is no image that can be read, or only the begin"));
  EXPECT_THAT(error_of("P5\n1 1\n255\n\x7F"), testing::HasSubstr("1 x 1 pixels"));
}

// From photographs to camera and board: an arm as its robot file says, a focal length of a data
// sheet, nothing known of where camera and board are.
TEST(Images, PhotographsShowWhereCameraAndBoardAre) {
  const std::string pattern = "charuco:7x5:30mm";
  Eye eye = camera();
  eye.place = KDL::Frame(KDL::Rotation::RPY(0.1, -0.2, 0.3), {0.05, -0.03, 0.08});
  Grid grid;
  grid.columns = 6;
  grid.rows = 4;
  grid.pitch = 0.03;
  grid.place = KDL::Frame(KDL::Rotation::RPY(3.0, 0.1, 0.4), {1.9, 0.2, 0.8});
  Dice dice(7);
  const std::string arm = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
  const Photographer photographer(eye);
  std::string name = (std::filesystem::temp_directory_path() / "armtrue-photos-XXXXXX").string();
  const std::string folder = mkdtemp(name.data());
  std::string joints = "q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,q6_rad\n";
  int number = 0;
  for (const Sight& sight : sights(read_arm(arm), eye, grid,
                                   {.poses = 14, .near = 0.3, .far = 0.45, .tilt = 0.5}, dice)) {
    std::ofstream(folder + "/" + std::to_string(++number) + ".pgm", std::ios::binary)
        << photographer.photograph(charuco(7, 5, 0.03, kFourByFour, 8), sight.seen, {}, dice);
    for (size_t j = 0; j < 6; ++j) {
      char text[32];
      std::snprintf(text, sizeof text, "%s%.15g", j > 0 ? "," : "", sight.q[j]);
      joints += text;
    }
    joints += "\n";
  }
  const ImportedReadings readings =
      import_images({folder, board_pattern(pattern), ""}, TemporaryFile(joints).path, {},
                    [](const BoardPattern& of, const std::string& file, bool explain) {
                      ImageCorners found;
                      std::string error;
                      armtrue_find_corners(of, file, explain, found, error);
                      EXPECT_EQ(error, "");
                      return found;
                    });
  std::filesystem::remove_all(folder);
  EXPECT_TRUE(readings.warnings.empty());
  EXPECT_GT(readings.campaign.rows(), 14 * 24 * 9 / 10);  // at the edge markers are cut off

  Robot robot = read_robot(arm).robot;
  Contact lens, board;
  lens.name = "eye";
  lens.kind = ContactKind::camera;
  lens.on_arm = true;
  lens.intrinsics.head<4>() << 620, 620, 320, 240;
  board.name = "board";
  board.kind = ContactKind::board;
  board.points = points_of(board_pattern(pattern));
  lens.is_placed = board.is_placed = false;
  robot.chain.contacts = {lens, board};
  robot.identify = {"base", "tool", "camera *"};
  robot.noise.pixel = 0.1;
  const TemporaryFile file(write_campaign(readings.campaign));
  Campaign campaign = read_campaign(file.path, robot.chain).campaign;
  bind_touches(campaign, robot.chain);
  const CalibrationResult fit = calibrate(robot, campaign);
  const std::vector<Contact>& found = fit.robot.chain.contacts;
  const auto apart = [](const Pose& pose, const KDL::Frame& truth) {
    return (pose.translation - Eigen::Vector3d(truth.p.x(), truth.p.y(), truth.p.z())).norm();
  };
  std::printf("camera %.3f mm, board %.3f mm off, fx %.2f of %.2f, spread %.3f px\n",
              1e3 * apart(found[0].place, eye.place), 1e3 * apart(found[1].place, grid.place),
              found[0].intrinsics[kFx], eye.fx, fit.spread.position / campaign.metre_per_pixel);
  EXPECT_LT(apart(found[0].place, eye.place), 1e-3);
  EXPECT_LT(apart(found[1].place, grid.place), 1e-3);
  EXPECT_NEAR(found[0].intrinsics[kFx], eye.fx, 1.5);
  EXPECT_NEAR(found[0].intrinsics[kCx], eye.cx, 1.5);
}

}  // namespace
}  // namespace armtrue::image_test
