#include "armtrue/campaign/views.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include "armtrue/kinematics/contact.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/inverse.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/random.h"
#include "campaign/random_joints.h"

namespace armtrue {
namespace {

constexpr double kEdge = 5;                 // px: a corner is found where its surroundings show
constexpr double kFewestOfImage = 1.0 / 3;  // the board's share: less shows its place badly
constexpr double kMostOfImage = 0.9;
constexpr double kMostTilt = 35 * kDegree;  // more blurs and hides corners
constexpr int kTriesPerView = 400;

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

// The point in the axes of the camera.
Eigen::Vector3d seen_at(const KinematicChain& chain, const View& view, const Pose& a_from_measured,
                        int point) {
  const Contact &camera = chain.contacts[view.camera], &board = chain.contacts[view.board];
  const Pose a_from_camera = camera.on_arm ? a_from_measured * camera.place : camera.place;
  const Pose a_from_board = board.on_arm ? a_from_measured * board.place : board.place;
  return inverse(a_from_camera) * (a_from_board * board.points[point].position);
}

// The board before the camera.
Pose random_sight(const Contact& camera, const Contact& board, Random& random) {
  const Disk disk = disk_about(board);
  const Eigen::Vector2d size = size_of_image(camera);
  const double share = random.uniform(kFewestOfImage, kMostOfImage);
  const double focal = camera.intrinsics.segment<2>(kFx).mean();
  const double depth = 2 * disk.radius * focal / (share * size.minCoeff());
  const double azimuth = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double tilt = random.uniform(0, kMostTilt);
  const double turn = random.uniform(-std::numbers::pi, std::numbers::pi);
  const Eigen::Matrix3d rotation =
      rotation_exp(tilt * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0)) *
      rotation_exp({0, 0, turn});
  Eigen::Vector3d middle(0, 0, depth);
  for (int i = 0; i < 2; ++i)
    middle[i] = depth / camera.intrinsics[kFx + i] *
                ((size[i] - 1) / 2 - camera.intrinsics[kCx + i] +
                 random.uniform(-0.5, 0.5) * (size[i] - share * size.minCoeff()));
  return {rotation, middle - rotation * disk.middle};
}

bool shows_whole(const KinematicChain& chain, const View& view, const Pose& a_from_measured) {
  for (int point = 0; point < std::ssize(chain.contacts[view.board].points); ++point)
    if (!shows(chain, view, a_from_measured, point, kEdge)) return false;
  return true;
}

// Where the arm holds camera and board so, or nothing.
std::optional<JointVector> go_to(const KinematicChain& chain, const View& view, const Pose& sight,
                                 const JointVector& start) {
  const Contact &camera = chain.contacts[view.camera], &board = chain.contacts[view.board];
  const Pose goal = camera.on_arm ? board.place * inverse(camera.place * sight)
                                  : camera.place * sight * inverse(board.place);
  return inverse_kinematics(chain, goal, std::vector{start});
}

}  // namespace

std::vector<View> views_of(const KinematicChain& chain) {
  std::vector<View> views;
  std::string unplaced;
  for (int c = 0; c < std::ssize(chain.contacts); ++c)
    for (int b = 0; b < std::ssize(chain.contacts); ++b) {
      const Contact &camera = chain.contacts[c], &board = chain.contacts[b];
      if (camera.kind != ContactKind::camera || board.kind != ContactKind::board ||
          camera.on_arm == board.on_arm)
        continue;
      if (camera.is_placed && board.is_placed)
        views.push_back({c, b});
      else
        unplaced = (camera.is_placed ? board : camera).name;
    }
  if (!views.empty()) return views;
  throw std::invalid_argument(
      unplaced.empty()
          ? "the robot file has no camera and board of which one is on the arm and the other at "
            "rest; add them under 'cameras' and 'boards'"
          : "the robot file does not say where '" + unplaced +
                "' is; state x_mm to c_deg there, or take the product of a calibration, which has "
                "them");
}

bool shows(const KinematicChain& chain, const View& view, const Pose& a_from_measured, int point,
           double margin) {
  const Contact &camera = chain.contacts[view.camera], &board = chain.contacts[view.board];
  const Eigen::Vector3d seen = seen_at(chain, view, a_from_measured, point);
  const Eigen::Matrix3d of_camera =
      camera.on_arm ? a_from_measured.rotation * camera.place.rotation : camera.place.rotation;
  const Eigen::Matrix3d of_board =
      board.on_arm ? a_from_measured.rotation * board.place.rotation : board.place.rotation;
  const Eigen::Vector3d away = of_camera.transpose() * of_board.col(2);  // from the printed side
  return seen.dot(away) > 0 && is_in_image(camera, seen, margin);
}

Eigen::Vector2d pixel_of(const KinematicChain& chain, const View& view, const Pose& a_from_measured,
                         int point) {
  const Contact& camera = chain.contacts[view.camera];
  return project(camera.lens, camera.intrinsics, seen_at(chain, view, a_from_measured, point))
      .pixel;
}

std::vector<Viewpoint> random_viewpoints(const KinematicChain& chain, int count,
                                         std::uint64_t seed) {
  constexpr int kAxesOfPose = 6;  // fewer reach few of the poses that are drawn
  Random random(seed);
  const ChainEvaluator evaluator(chain);
  const std::vector<View> views = views_of(chain);
  std::vector<Viewpoint> viewpoints;
  int tries = 0;  // since the last that was found
  while (std::ssize(viewpoints) < count) {
    const View& view = views[viewpoints.size() % views.size()];
    if (++tries > kTriesPerView)
      throw std::invalid_argument(
          "hardly any configuration within the travel shows the whole board '" +
          chain.contacts[view.board].name + "' to the camera '" + chain.contacts[view.camera].name +
          "'; check their places, which way they face, and the size of the image");
    std::optional<JointVector> q = random_joints(chain, random);
    if (joint_count(chain) >= kAxesOfPose)
      q = go_to(chain, view,
                random_sight(chain.contacts[view.camera], chain.contacts[view.board], random), *q);
    if (!q || beyond_travel(chain, *q) || !shows_whole(chain, view, evaluator.pose(*q))) continue;
    viewpoints.push_back({*q, view});
    tries = 0;
  }
  return viewpoints;
}

}  // namespace armtrue
