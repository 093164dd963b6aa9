#pragma once

// Photographs of printed boards: what the corners of an image file come from.

#include <array>
#include <string>
#include <vector>

#include "imaging.h"

namespace armtrue_oracle {

/// A flat print: whether a place on it is white. Places in m, from the point that the robot file
/// calls 0: x to the right, y down. Outside it is the grey of a wall.
struct Print {
  std::vector<std::string> cells;  ///< rows of '#' (black) and '.' (white)
  double cell = 0;                 ///< their size [m]
  double left = 0, top = 0;        ///< of the upper left cell [m]
  bool disks = false;              ///< a '#' is a disk about the middle of its cell
  double radius = 0;               ///< of a disk [m]
};

/// A checkerboard of so many inner corners with a white border; the first inner square is black.
Print checkerboard(int columns, int rows, double pitch);

/// A checkerboard of squares whose white ones have a marker each. `markers`: rows of '#' and '.',
/// `bits` of each marker, as they are printed, without their black border. The origin is the first
/// inner corner; the marker is `bits + 2` of `cells_per_square` cells wide. The first square is
/// black unless `white_first`.
Print charuco(int columns, int rows, double pitch, const std::vector<std::string>& markers,
              int cells_per_square, bool white_first = false);

/// Markers on a grid, a gap of whole cells between them. The origin is the corner of the first.
Print tags(int columns, int rows, double side, int cells_of_gap,
           const std::vector<std::string>& markers);

/// Disks; in the asymmetric form every second row is shifted by one pitch and lies one pitch below,
/// the disks of a row lie two apart.
Print disks(int columns, int rows, double pitch, bool asymmetric);

struct Exposure {
  double blur_px = 0.7;     ///< standard deviation of the lens
  double noise_grey = 2.0;  ///< of each pixel, of 255
};

/// A camera that takes pictures of prints. Rays are bent as pixel_of() says.
class Photographer {
 public:
  explicit Photographer(const Eye& eye);

  /// A PGM file of the print at `seen`, its pose in the axes of the camera. Each pixel is a mean of
  /// places in it.
  std::string photograph(const Print& print, const KDL::Frame& seen, const Exposure& exposure,
                         Dice& dice) const;

 private:
  int width_, height_;
  std::vector<std::array<double, 2>> rays_;  // of the corners of the pixels, row by row
};

/// A pose of the arm, and the board before the camera there.
struct Sight {
  std::array<double, 6> q{};  // rad
  KDL::Frame seen;
};

/// Those of images_csv() without effects: all corners of the grid lie in the image.
std::vector<Sight> sights(const OracleArm& arm, const Eye& eye, const Grid& grid,
                          const ImagingPlan& plan, Dice& dice);

}  // namespace armtrue_oracle
