#include "armtrue/campaign/sights.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "armtrue/campaign/beam_sights.h"
#include "armtrue/campaign/views.h"
#include "armtrue/kinematics/approach.h"
#include "armtrue/kinematics/contact.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/inverse.h"
#include "armtrue/kinematics/units.h"
#include "campaign/random_joints.h"

namespace armtrue {
namespace {

constexpr double kFewestOfImage = 1.0 / 3;  // the board's share: less shows its place badly
constexpr double kMostOfImage = 0.9;
constexpr double kMostTilt = 35 * kDegree;   // more blurs and hides corners
constexpr double kUsualTilt = 45 * kDegree;  // of a beam or a scanner
constexpr int kTriesPerSight = 2000;
constexpr int kAxesOfPose = 6;  // fewer reach few of the poses that are drawn

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

// From a random configuration to the pose that is drawn; an arm of fewer axes stays there.
std::optional<JointVector> go_to_pose(const KinematicChain& chain, const Pose& a_from_measured,
                                      const JointVector& start) {
  if (joint_count(chain) < kAxesOfPose) return start;
  return inverse_kinematics(chain, a_from_measured, std::vector{start});
}

std::optional<JointVector> go_to_board(const KinematicChain& chain, const View& view,
                                       const JointVector& start, Random& random) {
  const Contact &camera = chain.contacts[view.camera], &board = chain.contacts[view.board];
  const Pose seen = camera_from_board(camera, board, random);
  const Pose goal = camera.on_arm ? board.place * inverse(camera.place * seen)
                                  : camera.place * seen * inverse(board.place);
  return go_to_pose(chain, goal, start);
}

bool shows_whole(const KinematicChain& chain, const View& view, const Pose& a_from_measured) {
  constexpr double kEdge = 5;  // px: a corner is found where its surroundings show
  for (int point = 0; point < std::ssize(chain.contacts[view.board].points); ++point)
    if (!shows(chain, view, a_from_measured, point, kEdge)) return false;
  return true;
}

// A pose whose z axis ends on a surface, in `end`, turned in any direction about the normal and
// about itself. `here`: the point from which the arm comes, in R_A.
Pose random_look(const Contact& contact, int point, const Eigen::Vector3d& here, Random& random) {
  const ArtefactPoint& part = touched_part(contact, point);
  Eigen::Vector3d place = contact.place * part.position;
  Eigen::Vector3d normal = contact.place.rotation * part.normal;
  if (part.kind == ContactKind::sphere) {
    normal = (here - place).normalized();
    place += contact.radius * normal;
  } else {
    place = here - normal * normal.dot(here - place);
  }
  const Eigen::Matrix3d tilted =
      shortest_rotation(Eigen::Vector3d::UnitZ(), -normal) * random_tilt(kUsualTilt, random);
  return {tilted * random_turn(random), place};
}

// `from`: the measured frame from that which looks along its z axis; it reads lengths in `range`.
std::optional<JointVector> go_to_look(const KinematicChain& chain, const Contact& contact,
                                      int point, const Pose& from, const Eigen::Vector2d& range,
                                      const JointVector& start, Random& random) {
  const Pose end{Eigen::Matrix3d::Identity(), {0, 0, random.uniform(range[0], range[1])}};
  const Eigen::Vector3d here = ChainEvaluator(chain).pose(start) * (from * end.translation);
  const Pose a_from_end = random_look(contact, point, here, random);
  return go_to_pose(chain, a_from_end * inverse(from * end), start);
}

std::optional<JointVector> go_to_touch(const KinematicChain& chain, const TouchSight& sight,
                                       const JointVector& start) {
  const ChainEvaluator evaluator(chain);
  const auto pose_at = [&](const JointVector& q, PoseJacobian& jacobian) {
    return evaluator.pose(q, jacobian);
  };
  const auto miss = [&](const Eigen::Vector3d& place, Eigen::MatrixX3d& gradients) {
    return off_surface(chain, sight, place, gradients);
  };
  return touching_joints(chain, pose_at, touching_point(chain, sight), miss, start);
}

}  // namespace

std::vector<Sight> sights_of_instrument() {
  return {{.go_to = [](const JointVector& start, Random&) { return std::optional(start); },
           .is_read = [](const JointVector&, const Pose&) { return true; },
           .hardly_read = "hardly any configuration within the travel of the joints keeps the "
                          "joints that follow others within theirs"}};
}

std::vector<Sight> sights_of_boards(const KinematicChain& chain) {
  std::vector<Sight> sights;
  for (const View& view : views_of(chain))
    sights.push_back(
        {.go_to = [&chain, view](
                      const JointVector& start,
                      Random& random) { return go_to_board(chain, view, start, random); },
         .is_read = [&chain, view](
                        const JointVector&,
                        const Pose& measured) { return shows_whole(chain, view, measured); },
         .hardly_read = "hardly any configuration within the travel shows the whole board '" +
                        chain.contacts[view.board].name + "' to the camera '" +
                        chain.contacts[view.camera].name +
                        "'; check their places, which way they face, and the size of the image"});
  return sights;
}

std::vector<Sight> sights_of_beams(const KinematicChain& chain) {
  std::vector<Sight> sights;
  for (const BeamSight& sight : beam_sights_of(chain)) {
    const Contact& beam = chain.contacts[sight.beam];
    sights.push_back(
        {.contact = sight.name,
         .go_to =
             [&chain, &beam, sight](const JointVector& start, Random& random) {
               return go_to_look(chain, chain.contacts[sight.contact], sight.point, beam.place,
                                 beam.range, start, random);
             },
         .is_read =
             [&chain, sight](const JointVector&, const Pose& measured) {
               return beam_reading_at(chain, sight, measured).has_value();
             },
         .hardly_read = "hardly any configuration within the travel reads '" + sight.name +
                        "'; check the places of beam and plane, which way the plane faces, and "
                        "range_mm"});
  }
  return sights;
}

std::vector<Sight> sights_of_scanner(const KinematicChain& chain, const Scanner& scanner) {
  constexpr int kFewestPoints = 3;
  const std::vector<int> contacts = scanned_contacts(chain);
  Pose ahead;
  if (scanner.range.sum() < 0) ahead.rotation = rotation_exp({0, std::numbers::pi, 0});
  std::vector<Sight> sights;
  for (const int contact : contacts)
    sights.push_back(
        {.go_to =
             [&chain, scanner, ahead, contact](const JointVector& start, Random& random) {
               return go_to_look(chain, chain.contacts[contact], -1, ahead,
                                 scanner.range.cwiseAbs(), start, random);
             },
         .is_read =
             [&chain, scanner, contacts, contact](const JointVector&, const Pose& measured) {
               return std::ranges::count(profile_at(chain, scanner, contacts, measured), contact,
                                         &ScannedPoint::contact) >= kFewestPoints;
             },
         .hardly_read = "hardly any configuration within the travel shows '" +
                        chain.contacts[contact].name +
                        "' to the line scanner; check its place, which way a plane faces, the "
                        "tool, and what the scanner sees"});
  return sights;
}

std::vector<Sight> sights_of_touches(const KinematicChain& chain,
                                     const std::vector<TouchSight>& touches) {
  std::vector<Sight> sights;
  for (const TouchSight& touch : touches)
    sights.push_back(
        {.contact = touch.name,
         .target = touch.target < 0 ? "" : chain.targets[touch.target].name,
         .go_to = [&chain, touch](const JointVector& start,
                                  Random&) { return go_to_touch(chain, touch, start); },
         .is_read = [&chain, touch](const JointVector& q,
                                    const Pose&) { return is_on_its_side(chain, touch, q); },
         .hardly_read = "hardly any configuration within the travel touches a contact; check the "
                        "places of the contacts, and which way planes face",
         .is_needed = false});
  return sights;
}

namespace {

// A configuration that reads it; nothing if hardly any does.
std::optional<JointVector> configuration_of(const Sight& sight, const KinematicChain& chain,
                                            Random& random) {
  const ChainEvaluator evaluator(chain);
  for (int tries = 0; tries < kTriesPerSight; ++tries) {
    const std::optional<JointVector> q = sight.go_to(random_joints(chain, random), random);
    if (q && !beyond_travel(chain, *q) && sight.is_read(*q, evaluator.pose(*q))) return q;
  }
  return std::nullopt;
}

}  // namespace

std::vector<PlannedPose> random_sighted_poses(const KinematicChain& chain,
                                              std::vector<std::vector<Sight>> kinds, int count,
                                              std::uint64_t seed) {
  Random random(seed);
  std::vector<PlannedPose> poses;
  std::vector<size_t> next(kinds.size(), 0);  // sight of each kind
  while (std::ssize(poses) < count) {
    const size_t kind = poses.size() % kinds.size();
    std::vector<Sight>& sights = kinds[kind];
    next[kind] %= sights.size();
    const Sight& sight = sights[next[kind]];
    if (const auto q = configuration_of(sight, chain, random)) {
      poses.push_back({*q, sight.contact, sight.target});
      ++next[kind];
      continue;
    }
    if (sight.is_needed || sights.size() == 1) throw std::invalid_argument(sight.hardly_read);
    sights.erase(sights.begin() + static_cast<std::ptrdiff_t>(next[kind]));
  }
  return poses;
}

}  // namespace armtrue
