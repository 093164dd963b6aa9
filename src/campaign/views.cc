#include "armtrue/campaign/views.h"

#include <stdexcept>

#include "armtrue/campaign/campaign.h"
#include "armtrue/kinematics/contact.h"

namespace armtrue {
namespace {

// The point in the axes of the camera.
Eigen::Vector3d seen_at(const KinematicChain& chain, const View& view, const Pose& a_from_measured,
                        int point) {
  const Contact &camera = chain.contacts[view.camera], &board = chain.contacts[view.board];
  const Pose a_from_camera = camera.on_arm ? a_from_measured * camera.place : camera.place;
  const Pose a_from_board = board.on_arm ? a_from_measured * board.place : board.place;
  return inverse(a_from_camera) * (a_from_board * board.points[point].position);
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

std::vector<std::string> corner_names(const KinematicChain& chain, const View& view) {
  const Contact &camera = chain.contacts[view.camera], &board = chain.contacts[view.board];
  std::vector<std::string> names;
  for (const ArtefactPoint& point : board.points)
    names.push_back(PixelName(camera.name, board.name, point.name).text());
  return names;
}

}  // namespace armtrue
