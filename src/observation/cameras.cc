#include "observation/cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/contact.h"
#include "armtrue/observation/observation.h"
#include "armtrue/statistics/random.h"
#include "armtrue/statistics/summary.h"
#include "armtrue/text/number_text.h"
#include "linear_algebra/decompositions.h"
#include "observation/nearer_half.h"

namespace armtrue {
namespace {

constexpr int kCornersOfHomography = 4;
constexpr int kMostImages = 200;  // of a camera and a board; more place them no better
constexpr int kFewestImages = 3;  // two motions about different axes, which hand-eye needs

// The corners of one board in one image, and where the arm is.
struct Image {
  Pose measured;                        // R_A from the measured frame
  std::vector<Eigen::Vector2d> corner;  // on the board [m]
  std::vector<Eigen::Vector2d> pixel;
};

struct Pair {
  int camera, board;
  auto operator<=>(const Pair&) const = default;
};

std::map<Pair, std::vector<Image>> images_of(const Robot& robot, const Campaign& campaign) {
  const std::vector<ContactPoint> matched = match_contacts(campaign, robot.chain);
  Robot arm = robot;
  arm.effects.clear();
  const RobotModel model(arm);
  std::map<std::tuple<Pair, int, int>, Image> images;
  for (int row = 0; row + 1 < campaign.rows(); ++row) {
    if (campaign.kind(row) != ReadingKind::pixel || campaign.touch[row].axis != 0 ||
        campaign.touch[row + 1].axis != 1 ||
        campaign.touch[row + 1].contact != campaign.touch[row].contact)
      continue;  // one coordinate of a corner alone
    const ContactPoint& seen = matched[campaign.touch[row].contact];
    const auto key = std::tuple(Pair{seen.contact, seen.board}, campaign.pose[row],
                                campaign.repeat.empty() ? 0 : campaign.repeat[row]);
    const auto [entry, is_new] = images.try_emplace(key);
    Image& image = entry->second;
    if (is_new) image.measured = model.pose(campaign.context(row));
    image.corner.emplace_back(
        robot.chain.contacts[seen.board].points[seen.point].position.head<2>());
    image.pixel.emplace_back(campaign.distance[row] / campaign.metre_per_pixel,
                             campaign.distance[row + 1] / campaign.metre_per_pixel);
  }
  std::map<Pair, std::vector<Image>> all;
  for (auto& [key, image] : images)
    if (std::ssize(image.corner) >= kCornersOfHomography)
      all[std::get<Pair>(key)].push_back(std::move(image));
  for (auto& [pair, of_pair] : all)
    if (const auto count = std::ssize(of_pair); count > kMostImages) {
      std::vector<Image> thinned;
      for (std::ptrdiff_t k = 0; k < kMostImages; ++k)
        thinned.push_back(std::move(of_pair[k * count / kMostImages]));
      of_pair = std::move(thinned);
    }
  return all;
}

// The direction (x, y, 1) that the camera sees in a pixel, by Newton's method.
Eigen::Vector2d direction_of(const Contact& camera, const Eigen::Vector2d& pixel) {
  constexpr int kSteps = 20;
  constexpr double kWidest = 1.5;  // rad from the line of sight, just below a right angle
  const Eigen::Vector2d plain =
      (pixel - camera.intrinsics.segment<2>(kCx)).cwiseQuotient(camera.intrinsics.segment<2>(kFx));
  Eigen::Vector2d direction = plain;
  if (const double angle = plain.norm(); camera.lens == Lens::fisheye && angle > 0)
    direction *= std::tan(std::min(angle, kWidest)) / angle;
  for (int step = 0; step < kSteps; ++step) {
    const PixelReading reading = project(camera.lens, camera.intrinsics, direction.homogeneous());
    const Eigen::Matrix2d slope = reading.by_point.leftCols<2>();
    const Eigen::Vector2d move = slope.inverse() * (pixel - reading.pixel);
    if (!move.allFinite() || move.norm() > 1) break;  // no inverse so far from the centre
    direction += move;
  }
  return direction;
}

// The unit vector h that makes |equations h| smallest. Of fewer equations than unknowns that is
// zero, and the last column of the Q of their transpose, at a tenth of the cost.
Eigen::VectorXd least_direction(const Eigen::MatrixXd& equations) {
  const Eigen::Index unknowns = equations.cols();
  if (equations.rows() < unknowns)
    return product(Eigen::HouseholderQR<Eigen::MatrixXd>(equations.transpose()).householderQ(),
                   Eigen::VectorXd(Eigen::VectorXd::Unit(unknowns, unknowns - 1)));
  return Eigen::JacobiSVD<Eigen::MatrixXd>(equations, Eigen::ComputeFullV)
      .matrixV()
      .col(unknowns - 1);
}

// The homography that takes these corners to their directions, by the direct linear transform, and
// its place in front of the camera.
std::optional<Pose> place_by_homography(const std::vector<Eigen::Vector2d>& corners,
                                        const std::vector<Eigen::Vector2d>& directions,
                                        const std::vector<int>& chosen) {
  double size = 0;
  for (int k : chosen) size = std::max(size, corners[k].norm());
  if (size == 0) return std::nullopt;
  Eigen::MatrixXd equations(2 * chosen.size(), 9);
  for (size_t i = 0; i < chosen.size(); ++i) {
    const Eigen::Vector3d corner = (corners[chosen[i]] / size).homogeneous();
    const Eigen::Vector2d& direction = directions[chosen[i]];
    const Eigen::Index row = 2 * i;
    equations.row(row) << corner.transpose(), 0, 0, 0, -direction.x() * corner.transpose();
    equations.row(row + 1) << 0, 0, 0, corner.transpose(), -direction.y() * corner.transpose();
  }
  const Eigen::VectorXd h = least_direction(equations);
  Eigen::Matrix3d columns;
  columns << h.segment<3>(0).transpose(), h.segment<3>(3).transpose(), h.segment<3>(6).transpose();
  columns.leftCols<2>() /= size;
  const double scale = (columns.col(0).norm() + columns.col(1).norm()) / 2;
  if (!(scale > 0)) return std::nullopt;
  columns /= columns(2, 2) < 0 ? -scale : scale;
  Eigen::Matrix3d axes;
  axes << columns.col(0), columns.col(1), columns.col(0).cross(columns.col(1));
  if (!axes.allFinite()) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::MatrixXd> nearest(axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d rotation = nearest.matrixU() * nearest.matrixV().transpose();
  if (rotation.determinant() < 0) return std::nullopt;
  return Pose{rotation, columns.col(2)};
}

// The corners of one image, from which the place of the board before the camera follows.
class BoardView {
 public:
  BoardView(const Contact& camera, const Image& image) : camera_(camera), image_(image) {
    for (const Eigen::Vector2d& pixel : image.pixel)
      directions_.push_back(direction_of(camera, pixel));
  }

  // Nothing if the corners lie on a line.
  std::optional<Pose> place() const {
    std::optional<Pose> best = best_of_fours();
    if (!best) return std::nullopt;
    std::vector<int> half = nearer_half(*best);
    for (int step = 0; step < kSteps; ++step) *best = refined(*best, half);
    half = nearer_half(*best);
    for (int step = 0; step < kSteps; ++step) *best = refined(*best, half);
    return best->rotation.allFinite() && best->translation.z() > 0 ? best : std::nullopt;
  }

 private:
  static constexpr int kSteps = 10;  // of Gauss and Newton, which settle in four or five

  double miss(const Pose& place, size_t k) const {
    const Eigen::Vector3d seen =
        place * Eigen::Vector3d(image_.corner[k].x(), image_.corner[k].y(), 0);
    return (project(camera_.lens, camera_.intrinsics, seen).pixel - image_.pixel[k]).norm();
  }

  std::vector<double> misses(const Pose& place) const {
    std::vector<double> all;
    for (size_t k = 0; k < image_.corner.size(); ++k) all.push_back(miss(place, k));
    return all;
  }

  std::vector<int> nearer_half(const Pose& place) const {
    const std::vector<double> all = misses(place);
    const double limit = median(all);
    std::vector<int> chosen;
    for (int k = 0; k < std::ssize(all); ++k)
      if (all[k] <= limit || std::ssize(all) <= 2 * kCornersOfHomography) chosen.push_back(k);
    return chosen;
  }

  std::optional<Pose> best_of_fours() const {
    constexpr int kTries = 60;  // with a third of wrong corners, 1e-6 to draw no right four
    const auto count = std::ssize(image_.corner);
    Random random(1);
    std::optional<Pose> best;
    double least = 0;
    const auto attempt = [&](const std::vector<int>& chosen) {
      const auto place = place_by_homography(image_.corner, directions_, chosen);
      if (!place) return;
      const double typical = median(misses(*place));
      if (!std::isfinite(typical) || (best && typical >= least)) return;
      best = place;
      least = typical;
    };
    std::vector<int> all(count);
    for (int k = 0; k < count; ++k) all[k] = k;
    attempt(all);
    for (int t = 0; t < kTries && count > kCornersOfHomography; ++t) {
      for (int k = 0; k < kCornersOfHomography; ++k)
        std::swap(all[k], all[k + random.next() % (count - k)]);
      attempt({all.begin(), all.begin() + kCornersOfHomography});
    }
    return best;
  }

  Pose refined(const Pose& place, const std::vector<int>& chosen) const {
    Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
    for (int k : chosen) {
      const Eigen::Vector3d turned =
          place.rotation * Eigen::Vector3d(image_.corner[k].x(), image_.corner[k].y(), 0);
      const PixelReading reading =
          project(camera_.lens, camera_.intrinsics, turned + place.translation);
      Eigen::Matrix<double, 2, 6> slope;
      slope << reading.by_point, -reading.by_point * cross_matrix(turned);
      information += slope.transpose() * slope;
      gradient += slope.transpose() * (image_.pixel[k] - reading.pixel);
    }
    information.diagonal() *= 1 + 1e-9;  // of four corners in one line, too
    const Eigen::VectorXd step =
        Eigen::LDLT<Eigen::MatrixXd>(information).solve(Eigen::VectorXd(gradient));
    if (!step.allFinite()) return place;
    return {rotation_exp(step.tail<3>()) * place.rotation, place.translation + step.head<3>()};
  }

  const Contact& camera_;
  const Image& image_;
  std::vector<Eigen::Vector2d> directions_;
};

// G C H = B of one image: G of the arm, H the board before the camera.
struct Loop {
  Pose arm, seen;
};

struct Places {
  Pose camera, board;
};

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  return u * svd.matrixV().transpose();
}

// Shah 2013: sum tr(B^T G C H) over the images is vec(B)^T K vec(C), K = sum of the Kronecker
// products of H^T and G, largest at the first singular vectors. Then G t_C - t_B = -t_G - G C t_H.
Places closed_form(const std::vector<Loop>& loops, const std::vector<int>& chosen) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(9, 9);
  for (int k : chosen)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        sum.block<3, 3>(3 * i, 3 * j) += loops[k].seen.rotation(j, i) * loops[k].arm.rotation;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d board, camera;
  for (int column = 0; column < 3; ++column) {
    board.col(column) = svd.matrixU().col(0).segment<3>(3 * column);
    camera.col(column) = svd.matrixV().col(0).segment<3>(3 * column);
  }
  if (camera.determinant() < 0) {
    camera = -camera;
    board = -board;
  }
  Places places;
  places.camera.rotation = nearest_rotation(camera);
  places.board.rotation = nearest_rotation(board);
  Eigen::MatrixXd equations(3 * chosen.size(), 6);
  Eigen::VectorXd right(3 * chosen.size());
  for (size_t i = 0; i < chosen.size(); ++i) {
    const Loop& loop = loops[chosen[i]];
    const Eigen::Index row = 3 * i;
    equations.block<3, 3>(row, 0) = loop.arm.rotation;
    equations.block<3, 3>(row, 3) = -Eigen::Matrix3d::Identity();
    right.segment<3>(row) =
        -loop.arm.translation - loop.arm.rotation * places.camera.rotation * loop.seen.translation;
  }
  const Eigen::VectorXd solution =
      Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(equations).solve(right);
  places.camera.translation = solution.head<3>();
  places.board.translation = solution.tail<3>();
  return places;
}

Pose mean_pose(const std::vector<Pose>& poses, const std::vector<int>& chosen) {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  for (int k : chosen) {
    rotation += poses[k].rotation;
    translation += poses[k].translation;
  }
  return {nearest_rotation(rotation), translation / static_cast<double>(chosen.size())};
}

// How far two places of a board are apart [m].
double apart(const Pose& a, const Pose& b) {
  constexpr double kLever = 1.0;  // m: by which a rotation counts as a distance
  return (a.translation - b.translation).norm() + kLever * (a.rotation - b.rotation).norm();
}

Pose robust_mean(const std::vector<Pose>& poses) {
  return fit_nearer_half(
      std::ssize(poses), 1,
      [&](const std::vector<int>& chosen) { return mean_pose(poses, chosen); },
      [&](const Pose& mean, int k) { return apart(mean, poses[k]); });
}

std::vector<Loop> loops_of(const Contact& camera, const std::vector<Image>& images) {
  std::vector<Loop> loops;
  for (const Image& image : images)
    if (const auto seen = BoardView(camera, image).place())
      loops.push_back({camera.on_arm ? image.measured : inverse(image.measured), *seen});
  return loops;
}

// Median distance at the board by which the model misses the corners [m].
double miss_of(const Contact& camera, const Contact& board, const std::vector<Image>& images,
               double metre_per_pixel) {
  std::vector<double> misses;
  for (const Image& image : images) {
    const Pose of_camera = camera.on_arm ? image.measured * camera.place : camera.place;
    const Pose of_board = board.on_arm ? image.measured * board.place : board.place;
    const Pose seen = inverse(of_camera) * of_board;
    for (size_t k = 0; k < image.corner.size(); ++k) {
      const Eigen::Vector3d point(image.corner[k].x(), image.corner[k].y(), 0);
      misses.push_back(
          (project(camera.lens, camera.intrinsics, seen * point).pixel - image.pixel[k]).norm() *
          metre_per_pixel);
    }
  }
  return median(std::move(misses));
}

}  // namespace

Robot with_cameras_placed(Robot robot, const Campaign& campaign, FitContacts which) {
  std::vector<Contact>& contacts = robot.chain.contacts;
  const std::map<Pair, std::vector<Image>> images = images_of(robot, campaign);
  std::vector<Pair> pairs;  // those of most images first
  for (const auto& [pair, of_pair] : images) pairs.push_back(pair);
  std::ranges::stable_sort(pairs, [&](const Pair& a, const Pair& b) {
    return images.at(a).size() > images.at(b).size();
  });
  if (which == FitContacts::unplaced) {
    const bool all_near = std::ranges::all_of(pairs, [&](const Pair& pair) {
      const Contact &camera = contacts[pair.camera], &board = contacts[pair.board];
      return camera.is_placed && board.is_placed &&
             miss_of(camera, board, images.at(pair), campaign.metre_per_pixel) < kFarContact;
    });
    if (all_near) return robot;
  }
  std::vector<bool> known(contacts.size(), false);
  for (size_t left = pairs.size(); left > 0; --left) {
    // A camera or a board whose partner has a place follows it; else both are new.
    auto next = std::ranges::find_if(
        pairs, [&](const Pair& pair) { return known[pair.camera] != known[pair.board]; });
    if (next == pairs.end()) next = pairs.begin();
    const Pair pair = *next;
    pairs.erase(next);
    if (known[pair.camera] && known[pair.board]) continue;
    Contact &camera = contacts[pair.camera], &board = contacts[pair.board];
    const std::vector<Loop> loops = loops_of(camera, images.at(pair));
    if (std::ssize(loops) < kFewestImages)
      throw std::invalid_argument(fmt::format(
          "{}: the camera '{}' shows the board '{}' in {}, and places follow from {} or "
          "more, in poses that turn about different axes; take more, or leave these out",
          campaign.source, camera.name, board.name, counted(loops.size(), "image"), kFewestImages));
    std::vector<Pose> places;
    if (known[pair.camera]) {
      for (const Loop& loop : loops) places.push_back(loop.arm * camera.place * loop.seen);
      board.place = robust_mean(places);
    } else if (known[pair.board]) {
      for (const Loop& loop : loops)
        places.push_back(inverse(loop.arm) * board.place * inverse(loop.seen));
      camera.place = robust_mean(places);
    } else {
      const Places found = fit_nearer_half(
          std::ssize(loops), kFewestImages,
          [&](const std::vector<int>& chosen) { return closed_form(loops, chosen); },
          [&](const Places& of, int k) {
            return apart(loops[k].arm * of.camera * loops[k].seen, of.board);
          });
      camera.place = found.camera;
      board.place = found.board;
    }
    camera.is_placed = board.is_placed = known[pair.camera] = known[pair.board] = true;
  }
  return robot;
}

}  // namespace armtrue
