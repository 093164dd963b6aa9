#include "diagnosis/board_check.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <map>
#include <vector>

#include "armtrue/campaign/selection.h"
#include "armtrue/observation/observation.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

struct Corner {
  int point;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

using Image = std::vector<Corner>;

std::vector<Image> images_of(const Robot& robot, const Campaign& campaign, int board) {
  const std::vector<ContactPoint> matched = match_contacts(campaign, robot.chain);
  std::vector<Image> images;
  for (const std::vector<int>& rows : rows_by_image(campaign)) {
    std::map<int, Corner> corners;
    for (const int row : rows) {
      const Touch& touch = campaign.touch[row];
      const ContactPoint& seen = matched[touch.contact];
      if (seen.board != board) continue;
      Corner& corner = corners.try_emplace(seen.point, Corner{seen.point}).first->second;
      corner.pixel[touch.axis] = campaign.distance[row] / campaign.metre_per_pixel;
    }
    constexpr size_t kFewestCorners = 8;  // four fit any map
    if (corners.size() < kFewestCorners) continue;
    images.emplace_back();
    for (const auto& [point, corner] : corners) images.back().push_back(corner);
  }
  return images;
}

// Numbers the points of a grid row by row, with so many columns.
void set_columns(Contact& board, int columns) {
  const Eigen::Vector3d first = board.points[0].position;
  const double pitch = board.points[1].position.x() - first.x();
  for (int k = 0; k < std::ssize(board.points); ++k)
    board.points[k].position = first + pitch * Eigen::Vector3d(k % columns, k / columns, 0);
}

// The columns of the grid that the points of a board make, row by row; 0 if they make none.
int columns_of(const Contact& board) {
  constexpr double kSame = 1e-9;  // m
  const std::vector<ArtefactPoint>& points = board.points;
  int columns = 1;
  while (columns < std::ssize(points) &&
         std::abs(points[columns].position.y() - points[0].position.y()) < kSame)
    ++columns;
  if (columns < 2 || columns == std::ssize(points)) return 0;
  Contact grid = board;
  set_columns(grid, columns);
  for (size_t k = 0; k < points.size(); ++k)
    if (!points[k].position.isApprox(grid.points[k].position, kSame)) return 0;
  return columns;
}

// RMS distance of the corners from the best projective map of a grid with so many columns, by the
// direct linear transformation of centred and scaled coordinates (Hartley 1997).
double off_grid(const Image& image, int columns) {
  const auto count = static_cast<double>(image.size());
  const auto on_grid = [&](const Corner& c) {
    return Eigen::Vector2d(c.point % columns, static_cast<double>(c.point / columns));
  };
  Eigen::Vector2d middle = Eigen::Vector2d::Zero(), middle_on_grid = middle;
  for (const Corner& c : image) {
    middle += c.pixel / count;
    middle_on_grid += on_grid(c) / count;
  }
  double size = 0, size_on_grid = 0;
  for (const Corner& c : image) {
    size += (c.pixel - middle).norm() / count;
    size_on_grid += (on_grid(c) - middle_on_grid).norm() / count;
  }
  Eigen::MatrixXd equations = Eigen::MatrixXd::Zero(2 * std::ssize(image), 9);
  for (size_t k = 0; k < image.size(); ++k) {
    const Eigen::Vector3d from =
        ((on_grid(image[k]) - middle_on_grid) / size_on_grid).homogeneous();
    const Eigen::Vector2d to = (image[k].pixel - middle) / size;
    for (const int axis : {0, 1}) {
      const auto row = static_cast<Eigen::Index>(2 * k) + axis;
      equations.block<1, 3>(row, 3 * axis) = from;
      equations.block<1, 3>(row, 6) = -to[axis] * from;
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{
      Eigen::MatrixXd(equations.transpose() * equations)};
  const Eigen::VectorXd map = eigen.eigenvectors().col(0);
  double square = 0;
  for (const Corner& c : image) {
    const Eigen::Vector3d from = ((on_grid(c) - middle_on_grid) / size_on_grid).homogeneous();
    const double depth = map.tail<3>().dot(from);
    const Eigen::Vector2d at(map.head<3>().dot(from) / depth, map.segment<3>(3).dot(from) / depth);
    square += (size * at + middle - c.pixel).squaredNorm() / count;
  }
  return std::sqrt(square);
}

double median_off_grid(const std::vector<Image>& images, int columns) {
  std::vector<double> off;
  for (const Image& image : images) off.push_back(off_grid(image, columns));
  return median(off);
}

}  // namespace

std::optional<int> find_columns_of_board(const Robot& robot, const Campaign& campaign, int board) {
  constexpr int kMostColumns = 60;
  constexpr double kClearly = 5, kOff = 2;  // px: lenses bend less, and corners are found better
  const int stated = columns_of(robot.chain.contacts[board]);
  if (stated == 0) return std::nullopt;
  const std::vector<Image> images = images_of(robot, campaign, board);
  if (images.empty()) return std::nullopt;
  int best = stated;
  double least = median_off_grid(images, stated) / kClearly;
  if (least < kOff) return std::nullopt;
  for (int columns = 2; columns <= kMostColumns; ++columns) {
    const double off = median_off_grid(images, columns);
    if (columns == stated || !(off < least)) continue;
    best = columns;
    least = off;
  }
  return best == stated ? std::nullopt : std::optional(best);
}

}  // namespace armtrue
