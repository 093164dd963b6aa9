// The only file that sees OpenCV.

#include "armtrue/images/find_corners.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "armtrue/text/input_error.h"

namespace armtrue {
namespace {

using Points = std::vector<cv::Point2f>;

constexpr int kFewestPixels = 32;  // of a side: three squares of a board are not to be seen in less
constexpr int kFewestCorners = 4;  // from which the place of a board follows

// Decoders of JPEG fill what is missing with grey. The data of a scan hold neither marker.
bool is_cut_off(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!bytes.starts_with("\xFF\xD8")) return false;
  const size_t scan = bytes.rfind("\xFF\xDA");
  return scan == std::string::npos || bytes.find("\xFF\xD9", scan) == std::string::npos;
}

// Decoders write to standard error what they think of a file; the caller says what is wrong with
// it.
class Silence {
 public:
  Silence() : saved_(dup(STDERR_FILENO)) {
    const int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere < 0) return;
    dup2(nowhere, STDERR_FILENO);
    close(nowhere);
  }
  ~Silence() {
    if (saved_ < 0) return;
    dup2(saved_, STDERR_FILENO);
    close(saved_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  int saved_;
};

// Grey, as the sensor has it: what EXIF says of the orientation of the camera would turn some.
cv::Mat read_image(const std::string& file) {
  cv::Mat image;
  try {
    const Silence silence;
    image = cv::imread(file,
                       cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty() || is_cut_off(file))
    throw InputError(file +
                     ": is no image that can be read, or only the begin of one; copy it again from "
                     "the camera, or take it out of the folder");
  if (std::min(image.cols, image.rows) < kFewestPixels)
    throw InputError(file + ": is an image of " + std::to_string(image.cols) + " x " +
                     std::to_string(image.rows) +
                     " pixels, which shows no board; export it in full size, or take it out of the "
                     "folder");
  if (image.depth() != CV_8U)  // 12 bits in 16 would be dark
    cv::normalize(image, image, 0, 255, cv::NORM_MINMAX, CV_8U);
  return image;
}

// ---- grids, which have no ids

// A grid of corners as OpenCV found it, row by row, from any of its corners.
class SeenGrid {
 public:
  SeenGrid(Points points, int columns, int rows)
      : points_(std::move(points)), columns_(columns), rows_(rows) {}

  const Points& points() const { return points_; }
  const cv::Point2f& at(int column, int row) const { return points_[row * columns_ + column]; }

  // The board is seen from its front: x to the right, y down.
  void make_right_handed() {
    if ((at(columns_ - 1, 0) - at(0, 0)).cross(at(0, rows_ - 1) - at(0, 0)) > 0) return;
    for (int row = 0; row < rows_; ++row)
      std::reverse(points_.begin() + row * columns_, points_.begin() + (row + 1) * columns_);
  }

  void turn_by_half() { std::ranges::reverse(points_); }

  void turn_by_quarter() {
    Points turned;
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column)
        turned.push_back(at(row, columns_ - 1 - column));
    points_ = std::move(turned);
  }

  double right() const { return at(columns_ - 1, 0).x - at(0, 0).x; }

 private:
  Points points_;
  int columns_, rows_;
};

double brightness(const cv::Mat& image, const SeenGrid& grid, int column) {
  const cv::Point2f centre =
      (grid.at(column, 0) + grid.at(column + 1, 0) + grid.at(column, 1) + grid.at(column + 1, 1)) /
      4;
  constexpr int kAround = 1;  // px
  const cv::Rect inside(0, 0, image.cols, image.rows);
  const cv::Rect about(cvRound(centre.x) - kAround, cvRound(centre.y) - kAround, 2 * kAround + 1,
                       2 * kAround + 1);
  return cv::mean(image(about & inside))[0];
}

// From the corner whose inner square is black; where both ends look the same, from the one that is
// to the left.
void start_grid(const cv::Mat& image, const BoardPattern& pattern, SeenGrid& grid) {
  grid.make_right_handed();
  if (pattern.kind == BoardKind::checkerboard && !is_symmetric(pattern)) {
    if (brightness(image, grid, 0) > brightness(image, grid, 1)) grid.turn_by_half();
    return;
  }
  if (pattern.columns != pattern.rows) {
    if (grid.right() < 0) grid.turn_by_half();
    return;
  }
  SeenGrid best = grid;
  for (int turn = 0; turn < 3; ++turn) {
    grid.turn_by_quarter();
    if (grid.right() > best.right()) best = grid;
  }
  grid = best;
}

std::vector<SeenCorner> numbered(const Points& points) {
  std::vector<SeenCorner> corners;
  for (int k = 0; k < std::ssize(points); ++k) corners.push_back({k, points[k].x, points[k].y});
  return corners;
}

std::vector<SeenCorner> find_grid(const cv::Mat& image, const BoardPattern& pattern) {
  const cv::Size size(pattern.columns, pattern.rows);
  Points points;
  bool is_found = false;
  if (pattern.kind == BoardKind::checkerboard) {
    is_found = cv::findChessboardCornersSB(image, size, points,
                                           cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY);
  } else {
    const int form = pattern.kind == BoardKind::circles ? cv::CALIB_CB_SYMMETRIC_GRID
                                                        : cv::CALIB_CB_ASYMMETRIC_GRID;
    is_found = cv::findCirclesGrid(image, size, points, form);
    if (!is_found)
      is_found = cv::findCirclesGrid(image, size, points, form | cv::CALIB_CB_CLUSTERING);
  }
  if (!is_found || std::ssize(points) != size.area()) return {};
  if (pattern.kind == BoardKind::asymmetric_circles) return numbered(points);
  SeenGrid grid(std::move(points), pattern.columns, pattern.rows);
  start_grid(image, pattern, grid);
  return numbered(grid.points());
}

// ---- markers

struct Family {
  const char* name;
  int bits;                                       // of a side, without the black border
  std::vector<std::pair<int, int>> dictionaries;  // number of codes, OpenCV's number; rising
};

const std::vector<Family>& families() {
  using namespace cv::aruco;
  static const std::vector<Family> kFamilies{
      {"4x4",
       4,
       {{50, DICT_4X4_50}, {100, DICT_4X4_100}, {250, DICT_4X4_250}, {1000, DICT_4X4_1000}}},
      {"5x5",
       5,
       {{50, DICT_5X5_50}, {100, DICT_5X5_100}, {250, DICT_5X5_250}, {1000, DICT_5X5_1000}}},
      {"6x6",
       6,
       {{50, DICT_6X6_50}, {100, DICT_6X6_100}, {250, DICT_6X6_250}, {1000, DICT_6X6_1000}}},
      {"7x7",
       7,
       {{50, DICT_7X7_50}, {100, DICT_7X7_100}, {250, DICT_7X7_250}, {1000, DICT_7X7_1000}}},
      {"original", 5, {{1024, DICT_ARUCO_ORIGINAL}}},
      {"16h5", 4, {{30, DICT_APRILTAG_16h5}}},
      {"25h9", 5, {{35, DICT_APRILTAG_25h9}}},
      {"36h10", 6, {{2320, DICT_APRILTAG_36h10}}},
      {"36h11", 6, {{587, DICT_APRILTAG_36h11}}},
  };
  return kFamilies;
}

const Family& family_of(const BoardPattern& pattern) {
  return *std::ranges::find(families(), pattern.family, &Family::name);
}

struct Marker {
  cv::Point2f place;  // on the board, its upper left corner
  Points corners;     // in the image, clockwise from the upper left one

  cv::Point2f centre() const {  // where the diagonals meet
    const cv::Point2f a = corners[2] - corners[0], b = corners[3] - corners[1];
    const double along = (corners[1] - corners[0]).cross(b) / a.cross(b);
    return corners[0] + static_cast<float>(along) * a;
  }
  double side() const {  // the shortest [px]
    double shortest = cv::norm(corners[3] - corners[0]);
    for (size_t k = 0; k < 3; ++k)
      shortest = std::min(shortest, cv::norm(corners[k + 1] - corners[k]));
    return shortest;
  }
};
using Markers = std::map<int, Marker>;  // by number of code

// Where the markers stand, in squares of a charuco board, or sides of a tag. Rows from above,
// codes rising along the rows; a charuco board begins with black.
std::vector<cv::Point2f> places_of(const BoardPattern& pattern) {
  std::vector<cv::Point2f> places;
  const bool is_charuco = pattern.kind == BoardKind::charuco;
  const double step = is_charuco ? 1 : 1 + pattern.gap / pattern.pitch;
  const int white = pattern.is_legacy && pattern.rows % 2 == 0 ? 0 : 1;
  for (int row = 0; row < pattern.rows; ++row)
    for (int column = 0; column < pattern.columns; ++column)
      if (!is_charuco || (row + column) % 2 == white)
        places.emplace_back(cv::Point2d(step * column, step * row));
  return places;
}

Markers find_markers(const cv::Mat& image, const BoardPattern& pattern, const Family& family) {
  const std::vector<cv::Point2f> places = places_of(pattern);
  const auto fits = [&](const auto& dictionary) { return dictionary.first >= std::ssize(places); };
  const auto dictionary = std::ranges::find_if(family.dictionaries, fits);
  if (dictionary == family.dictionaries.end())
    throw InputError("the board '" + pattern.text + "' has " + std::to_string(places.size()) +
                     " markers, and the family " + family.name + " has " +
                     std::to_string(family.dictionaries.back().first) +
                     "; correct columns and rows, or the family");
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->minMarkerPerimeterRate = 0.01;  // of the image: many small markers in a large one
  std::vector<Points> quads;
  std::vector<int> ids;
  cv::aruco::detectMarkers(image, cv::aruco::getPredefinedDictionary(dictionary->second), quads,
                           ids, parameters);
  Markers markers;
  for (size_t k = 0; k < ids.size(); ++k)
    if (ids[k] < std::ssize(places) && std::ranges::count(ids, ids[k]) == 1)
      markers[ids[k]] = {places[ids[k]], quads[k]};
  return markers;
}

cv::Point2f mapped(const cv::Mat& homography, const cv::Point2f& point) {
  Points to;
  cv::perspectiveTransform(Points{point}, to, homography);
  return to.front();
}

// Half the side of the window in which a corner is refined: it keeps clear of the next corner.
int window(double pixels) {
  constexpr int kLeastPixels = 2, kMostPixels = 9;
  return std::clamp(static_cast<int>(pixels), kLeastPixels, kMostPixels);
}

// Nothing if the image shows another corner than the one that was expected there.
std::optional<cv::Point2f> refined(const cv::Mat& image, const cv::Point2f& expected, int half) {
  const auto margin = static_cast<float>(half + 2);
  if (expected.x < margin || expected.y < margin ||
      expected.x > static_cast<float>(image.cols - 1) - margin ||
      expected.y > static_cast<float>(image.rows - 1) - margin)
    return std::nullopt;
  Points point{expected};
  cv::cornerSubPix(image, point, {half, half}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-3});
  if (cv::norm(point.front() - expected) > half) return std::nullopt;
  return point.front();
}

constexpr double kOffItsPlace = 0.5;  // of a side; a lens bends a board by less

double median_of(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
  return values[values.size() / 2];
}

// The markers that lie as they do on the board. `by_corners`: by those of tags, whose side is
// known.
Markers those_in_place(const Markers& markers, bool by_corners) {
  static const std::array<cv::Point2f, 4> kCorners{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  const cv::Point2f middle(0.5, 0.5);
  Points on_board, in_image;
  std::vector<double> sides;
  for (const auto& [id, marker] : markers) {
    sides.push_back(marker.side());
    for (size_t k = 0; k < (by_corners ? 4 : 1); ++k) {
      on_board.push_back(marker.place + (by_corners ? kCorners[k] : middle));
      in_image.push_back(by_corners ? marker.corners[k] : marker.centre());
    }
  }
  if (std::ssize(on_board) < kFewestCorners) return {};
  const cv::Mat homography =
      cv::findHomography(on_board, in_image, cv::RANSAC, kOffItsPlace * median_of(sides));
  if (homography.empty()) return {};
  Markers kept = markers;
  std::erase_if(kept, [&](const auto& entry) {
    const Marker& marker = entry.second;
    const auto is_off = [&](const cv::Point2f& own, const cv::Point2f& seen) {
      return cv::norm(mapped(homography, marker.place + own) - seen) > kOffItsPlace * marker.side();
    };
    if (!by_corners) return is_off(middle, marker.centre());
    for (size_t k = 0; k < 4; ++k)
      if (is_off(kCorners[k], marker.corners[k])) return true;
    return false;
  });
  return kept;
}

// Tags as their makers print them: OpenCV turns AprilTags by half a turn, and boards of Kalibr
// count rows from below. Which of these it is shows where the tags lie, so each gets the place that
// it has on the board, and the corner that is its upper left one there.
Markers tags_in_place(const Markers& seen, const BoardPattern& pattern) {
  const std::vector<cv::Point2f> places = places_of(pattern);
  Markers best;
  for (const bool from_below : {false, true})
    for (int turn = 0; turn < 4; ++turn) {
      Markers markers;
      for (const auto& [id, marker] : seen) {
        const int row = id / pattern.columns, column = id % pattern.columns;
        const int own = (from_below ? pattern.rows - 1 - row : row) * pattern.columns + column;
        Marker& turned = markers[own] = {places[own], marker.corners};
        std::ranges::rotate(turned.corners, turned.corners.begin() + turn);
      }
      if (Markers kept = those_in_place(markers, true); kept.size() > best.size())
        best = std::move(kept);
    }
  return best;
}

Markers in_place(const Markers& seen, const BoardPattern& pattern) {
  return pattern.kind == BoardKind::tags ? tags_in_place(seen, pattern)
                                         : those_in_place(seen, false);
}

double grey(const cv::Mat& image, const cv::Point2d& at) {
  const int u = static_cast<int>(std::floor(at.x)), v = static_cast<int>(std::floor(at.y));
  const double s = at.x - u, t = at.y - v;
  const auto value = [&](int x, int y) -> double { return image.at<uchar>(y, x); };
  return (1 - t) * ((1 - s) * value(u, v) + s * value(u + 1, v)) +
         t * ((1 - s) * value(u, v + 1) + s * value(u + 1, v + 1));
}

struct Line {
  cv::Point2d through, along;
};

// The line on which the black side of a tag ends, `half` pixels about where it was expected. Blur
// rounds a corner off, and moves no side.
std::optional<Line> side_between(const cv::Mat& image, const cv::Point2d& from,
                                 const cv::Point2d& to, int half) {
  constexpr int kPlaces = 24;                   // of a side
  constexpr double kBegin = 0.15, kEnd = 0.85;  // of it: the rest is the corners'
  constexpr double kStep = 0.5;                 // px
  const cv::Point2d along = (to - from) / cv::norm(to - from), out(along.y, -along.x);
  const cv::Rect2d inside(half + 2, half + 2, image.cols - 2 * half - 5, image.rows - 2 * half - 5);
  std::vector<cv::Point2f> edge;
  for (int k = 0; k < kPlaces; ++k) {
    const cv::Point2d at = from + (kBegin + (kEnd - kBegin) * k / (kPlaces - 1)) * (to - from);
    if (!inside.contains(at)) return std::nullopt;
    double sum = 0, moment = 0;
    for (double t = -half; t <= half; t += kStep) {
      const double rise =
          std::max(0.0, grey(image, at + (t + kStep) * out) - grey(image, at + (t - kStep) * out));
      sum += rise;
      moment += rise * t;
    }
    if (sum > 0) edge.emplace_back(at + moment / sum * out);
  }
  if (std::ssize(edge) < kPlaces / 2) return std::nullopt;
  cv::Vec4f line;
  cv::fitLine(edge, line, cv::DIST_HUBER, 0, 0.01, 0.01);
  return Line{{line[2], line[3]}, {line[0], line[1]}};
}

// The corners of a tag, where its sides meet; none if they are not whole in the image.
Points where_sides_meet(const cv::Mat& image, Points corners, int half) {
  constexpr int kRounds = 2;  // the first finds the sides, the second is about them
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Line> sides;
    for (size_t k = 0; k < 4; ++k)
      if (const auto side = side_between(image, corners[k], corners[(k + 1) % 4], half))
        sides.push_back(*side);
    if (sides.size() < 4) return {};
    for (size_t k = 0; k < 4; ++k) {
      const Line &a = sides[(k + 3) % 4], &b = sides[k];
      const double parallel = a.along.cross(b.along);
      const cv::Point2d meet =
          a.through + (b.through - a.through).cross(b.along) / parallel * a.along;
      if (!(cv::norm(meet - cv::Point2d(corners[k])) <= half)) return {};
      corners[k] = meet;
    }
  }
  return corners;
}

std::vector<SeenCorner> corners_of_tags(const cv::Mat& image, const BoardPattern& pattern,
                                        const Markers& markers) {
  const double cell = 1.0 / (family_of(pattern).bits + 2);  // of a side: the border
  const double clear = 0.6 * std::min(cell, pattern.gap / pattern.pitch);
  std::vector<SeenCorner> corners;
  for (const auto& [id, marker] : markers) {
    int number = 4 * id;
    for (const cv::Point2f& corner :
         where_sides_meet(image, marker.corners, window(clear * marker.side())))
      corners.push_back({number++, corner.x, corner.y});
  }
  return corners;
}

bool lie_on_a_line(const Points& points) {
  constexpr double kFlat = 1e-3;
  cv::Point2d mean(0, 0);
  for (const cv::Point2f& point : points)
    mean += cv::Point2d(point) / static_cast<double>(points.size());
  double xx = 0, xy = 0, yy = 0;
  for (const cv::Point2f& point : points) {
    const cv::Point2d from = cv::Point2d(point) - mean;
    xx += from.x * from.x;
    xy += from.x * from.y;
    yy += from.y * from.y;
  }
  return xx * yy - xy * xy <= kFlat * (xx + yy) * (xx + yy);
}

// The side of the markers in the units of places_of(), as their centres, of which four must lie on
// no line, and their corners show it; nothing otherwise.
std::optional<double> side_on_board(const Markers& markers) {
  const cv::Point2f middle(0.5, 0.5);
  Points on_board, in_image;
  for (const auto& [id, marker] : markers) {
    on_board.push_back(marker.place + middle);
    in_image.push_back(marker.centre());
  }
  if (std::ssize(markers) < kFewestCorners || lie_on_a_line(on_board)) return std::nullopt;
  const cv::Mat to_board = cv::findHomography(in_image, on_board);
  if (to_board.empty()) return std::nullopt;
  std::vector<double> sides;
  for (const auto& [id, marker] : markers)
    for (const cv::Point2f& corner : marker.corners)
      sides.push_back(std::sqrt(2) * cv::norm(mapped(to_board, corner) - marker.place - middle));
  return median_of(sides);
}

// Of each inner corner two white squares have a marker; from their corners follows where it is.
std::vector<SeenCorner> corners_of_charuco(const cv::Mat& image, const BoardPattern& pattern,
                                           const Markers& markers) {
  std::map<std::pair<int, int>, const Marker*> at;
  for (const auto& [id, marker] : markers)
    at[{cvRound(marker.place.x), cvRound(marker.place.y)}] = &marker;
  const double side = side_on_board(markers).value_or(0);
  constexpr double kLeastSide = 0.3, kMostSide = 0.97;  // more or less is printed on no board
  if (side < kLeastSide || side > kMostSide) return {};
  const auto edge = static_cast<float>((1 - side) / 2), far = static_cast<float>(1 - edge);
  const std::array<cv::Point2f, 4> own{{{edge, edge}, {far, edge}, {far, far}, {edge, far}}};
  std::vector<SeenCorner> corners;
  for (int row = 1; row < pattern.rows; ++row)
    for (int column = 1; column < pattern.columns; ++column) {
      Points from, to;
      double shortest = image.cols;
      for (const auto& square : {std::pair(column - 1, row - 1), std::pair(column, row - 1),
                                 std::pair(column - 1, row), std::pair(column, row)}) {
        const auto found = at.find(square);
        if (found == at.end()) continue;
        shortest = std::min(shortest, found->second->side());
        for (size_t k = 0; k < 4; ++k) {
          from.push_back(found->second->place + own[k]);
          to.push_back(found->second->corners[k]);
        }
      }
      if (from.size() < 8) continue;
      const cv::Mat local = cv::findHomography(from, to);
      if (local.empty()) continue;
      const cv::Point2f expected = mapped(local, cv::Point(column, row));
      const int half = window(0.8 * edge / side * shortest);
      if (const auto corner = refined(image, expected, half))
        corners.push_back({(row - 1) * (pattern.columns - 1) + column - 1, corner->x, corner->y});
    }
  return corners;
}

// Whether the gap of a board of tags is what the pattern says, as far as the image shows it.
bool has_stated_gap(const BoardPattern& pattern, const Markers& markers) {
  constexpr double kOff = 0.05;  // of a side; lenses and blur change it by 0.02
  const auto side = pattern.kind == BoardKind::tags ? side_on_board(markers) : std::nullopt;
  return !side || std::abs(*side - 1) < kOff;
}

// Why an image with markers does not show this board.
std::string hint_for(const cv::Mat& image, const BoardPattern& pattern, size_t seen, size_t fit) {
  const std::string size = std::to_string(pattern.columns) + "x" + std::to_string(pattern.rows);
  if (std::cmp_greater_equal(seen, kFewestCorners) && fit < seen) {
    BoardPattern other = pattern;
    other.is_legacy = !pattern.is_legacy;
    if (pattern.kind == BoardKind::charuco && pattern.rows % 2 == 0) {
      const size_t lie = in_place(find_markers(image, other, family_of(other)), other).size();
      if (lie > fit && lie >= kFewestCorners)
        return pattern.is_legacy
                   ? "the board begins with black, as OpenCV prints it since 4.6; leave out "
                     "':legacy'"
                   : "the board begins with white, as OpenCV before 4.6 printed it; add ':legacy'";
    }
    return "an image shows " + std::to_string(seen) +
           " of its markers, and they do not lie as on a "
           "board of " +
           size + "; count columns and rows again, columns first" +
           (pattern.kind == BoardKind::tags ? ", and measure side and gap" : "");
  }
  if (seen >= kFewestCorners)
    return "the gap between its tags is not that of the board; measure side and gap";
  for (const Family& family : families()) {
    if (family.name == pattern.family) continue;
    BoardPattern other = pattern;
    other.family = family.name;
    try {
      if (in_place(find_markers(image, other, family), other).size() >= kFewestCorners)
        return "its markers are of the family " + other.family + "; write that behind the lengths";
    } catch (const InputError&) {  // has not as many markers
    }
  }
  return "";
}

void find_with_markers(const cv::Mat& image, const BoardPattern& pattern, bool explain,
                       ImageCorners& found) {
  const Markers all = find_markers(image, pattern, family_of(pattern));
  const Markers markers = in_place(all, pattern);
  const size_t seen = all.size();
  // Of another board most may fit, shifted by a square. A tenth is what is read wrongly at most.
  const size_t elsewhere = seen - markers.size();
  if (elsewhere <= std::max<size_t>(1, seen / 10) && !markers.empty() &&
      has_stated_gap(pattern, markers))
    found.corners = pattern.kind == BoardKind::tags ? corners_of_tags(image, pattern, markers)
                                                    : corners_of_charuco(image, pattern, markers);
  if (found.corners.size() < kFewestCorners) {
    found.corners.clear();
    if (explain) found.hint = hint_for(image, pattern, seen, markers.size());
  }
}

ImageCorners find(const BoardPattern& pattern, const std::string& file, bool explain) {
  cv::setNumThreads(1);  // the same bytes on every machine
  cv::setRNGSeed(1);
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  const cv::Mat image = read_image(file);
  ImageCorners found;
  found.width = image.cols;
  found.height = image.rows;
  if (pattern.kind == BoardKind::charuco || pattern.kind == BoardKind::tags)
    find_with_markers(image, pattern, explain, found);
  else
    found.corners = find_grid(image, pattern);
  constexpr double kSteps = 1e4;  // of a pixel: finer than any image shows
  for (SeenCorner& corner : found.corners)
    for (double* value : {&corner.u, &corner.v}) *value = std::round(*value * kSteps) / kSteps;
  return found;
}

}  // namespace

void armtrue_find_corners(const BoardPattern& pattern, const std::string& file, bool explain,
                          ImageCorners& found, std::string& error) {
  try {
    found = find(pattern, file, explain);
  } catch (const std::exception& failure) {
    error = failure.what();
  }
}

}  // namespace armtrue
