#include "armtrue/campaign/sighted_poses.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "armtrue/campaign/beam_sights.h"
#include "armtrue/campaign/views.h"
#include "armtrue/kinematics/contact.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/inverse.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/random.h"
#include "campaign/random_joints.h"

namespace armtrue {
namespace {

constexpr double kFewestOfImage = 1.0 / 3;  // the board's share: less shows its place badly
constexpr double kMostOfImage = 0.9;
constexpr double kMostTilt = 35 * kDegree;   // more blurs and hides corners
constexpr double kUsualTilt = 45 * kDegree;  // of a beam
constexpr int kTriesPerView = 400;
constexpr int kTriesPerBeam = 2000;

// Something that can be read, and how the arm comes to read it.
struct Sight {
  std::string name;  // SightedPose::name
  std::function<std::optional<JointVector>(const JointVector& start, Random&)> go_to;
  std::function<bool(const Pose& a_from_measured)> is_read;
  std::string hardly_read;  // what is wrong if hardly any configuration reads it
};

struct Disk {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double radius = 0;
};

Disk disk_about(const Contact& board) {
  Disk disk;
  for (const ArtefactPoint& point : board.points)
    disk.middle += point.position / static_cast<double>(board.points.size());
  for (const ArtefactPoint& point : board.points)
    disk.radius = std::max(disk.radius, (point.position - disk.middle).norm());
  return disk;
}

Eigen::Vector2d size_of_image(const Contact& camera) {
  if (!camera.image_size.isZero()) return camera.image_size;
  return 2 * camera.intrinsics.segment<2>(kCx).array() + 1;
}

// A turn by up to `most` about a random axis across z.
Eigen::Matrix3d random_tilt(double most, Random& random) {
  const double azimuth = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double tilt = random.uniform(0, most);
  return rotation_exp(tilt * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0));
}

Eigen::Matrix3d random_turn(Random& random) {
  return rotation_exp({0, 0, random.uniform(-std::numbers::pi, std::numbers::pi)});
}

// The board before the camera.
Pose camera_from_board(const Contact& camera, const Contact& board, Random& random) {
  const Disk disk = disk_about(board);
  const Eigen::Vector2d size = size_of_image(camera);
  const double share = random.uniform(kFewestOfImage, kMostOfImage);
  const double focal = camera.intrinsics.segment<2>(kFx).mean();
  const double depth = 2 * disk.radius * focal / (share * size.minCoeff());
  const Eigen::Matrix3d tilted = random_tilt(kMostTilt, random);
  const Eigen::Matrix3d rotation = tilted * random_turn(random);
  Eigen::Vector3d middle(0, 0, depth);
  for (int i = 0; i < 2; ++i)
    middle[i] = depth / camera.intrinsics[kFx + i] *
                ((size[i] - 1) / 2 - camera.intrinsics[kCx + i] +
                 random.uniform(-0.5, 0.5) * (size[i] - share * size.minCoeff()));
  return {rotation, middle - rotation * disk.middle};
}

std::optional<JointVector> go_to_board(const KinematicChain& chain, const View& view,
                                       const JointVector& start, Random& random) {
  const Contact &camera = chain.contacts[view.camera], &board = chain.contacts[view.board];
  const Pose seen = camera_from_board(camera, board, random);
  const Pose goal = camera.on_arm ? board.place * inverse(camera.place * seen)
                                  : camera.place * seen * inverse(board.place);
  return inverse_kinematics(chain, goal, std::vector{start});
}

bool shows_whole(const KinematicChain& chain, const View& view, const Pose& a_from_measured) {
  constexpr double kEdge = 5;  // px: a corner is found where its surroundings show
  for (int point = 0; point < std::ssize(chain.contacts[view.board].points); ++point)
    if (!shows(chain, view, a_from_measured, point, kEdge)) return false;
  return true;
}

std::vector<Sight> sights_of_boards(const KinematicChain& chain) {
  std::vector<Sight> sights;
  for (const View& view : views_of(chain))
    sights.push_back(
        {"",
         [&chain, view](const JointVector& start, Random& random) {
           return go_to_board(chain, view, start, random);
         },
         [&chain, view](const Pose& measured) { return shows_whole(chain, view, measured); },
         "hardly any configuration within the travel shows the whole board '" +
             chain.contacts[view.board].name + "' to the camera '" +
             chain.contacts[view.camera].name +
             "'; check their places, which way they face, and the size of the image"});
  return sights;
}

// From a random configuration the beam goes to the nearest point of the plane, turned in any
// direction about the plane's normal and about itself.
std::optional<JointVector> go_to_plane(const KinematicChain& chain, const BeamSight& sight,
                                       const JointVector& start, Random& random) {
  const Contact &beam = chain.contacts[sight.beam], &contact = chain.contacts[sight.contact];
  const ArtefactPoint& part = touched_part(contact, sight.point);
  const Eigen::Vector3d normal = contact.place.rotation * part.normal;
  const Eigen::Vector3d point = contact.place * part.position;
  const Pose end{Eigen::Matrix3d::Identity(), {0, 0, random.uniform(beam.range[0], beam.range[1])}};
  const Eigen::Vector3d here = ChainEvaluator(chain).pose(start) * (beam.place * end.translation);
  const Eigen::Matrix3d tilted =
      shortest_rotation(Eigen::Vector3d::UnitZ(), -normal) * random_tilt(kUsualTilt, random);
  const Pose a_from_end{tilted * random_turn(random), here - normal * normal.dot(here - point)};
  return inverse_kinematics(chain, a_from_end * inverse(beam.place * end), std::vector{start});
}

std::vector<Sight> sights_of_planes(const KinematicChain& chain) {
  std::vector<Sight> sights;
  for (const BeamSight& sight : beam_sights_of(chain))
    sights.push_back({sight.name,
                      [&chain, sight](const JointVector& start, Random& random) {
                        return go_to_plane(chain, sight, start, random);
                      },
                      [&chain, sight](const Pose& measured) {
                        return beam_reading_at(chain, sight, measured).has_value();
                      },
                      "hardly any configuration within the travel reads '" + sight.name +
                          "'; check the places of beam and plane, which way the plane faces, and "
                          "range_mm"});
  return sights;
}

}  // namespace

std::vector<SightedPose> random_sighted_poses(const KinematicChain& chain, Sensor sensor, int count,
                                              std::uint64_t seed) {
  constexpr int kAxesOfPose = 6;  // fewer reach few of the poses that are drawn
  const bool of_boards = sensor == Sensor::camera;
  const std::vector<Sight> sights = of_boards ? sights_of_boards(chain) : sights_of_planes(chain);
  const int most_tries = of_boards ? kTriesPerView : kTriesPerBeam;
  Random random(seed);
  const ChainEvaluator evaluator(chain);
  std::vector<SightedPose> poses;
  int tries = 0;  // since the last that was found
  while (std::ssize(poses) < count) {
    const Sight& sight = sights[poses.size() % sights.size()];
    if (++tries > most_tries) throw std::invalid_argument(sight.hardly_read);
    std::optional<JointVector> q = random_joints(chain, random);
    if (joint_count(chain) >= kAxesOfPose) q = sight.go_to(*q, random);
    if (!q || beyond_travel(chain, *q) || !sight.is_read(evaluator.pose(*q))) continue;
    poses.push_back({*q, sight.name});
    tries = 0;
  }
  return poses;
}

}  // namespace armtrue
