#pragma once

#include <functional>
#include <string>
#include <vector>

#include "armtrue/kinematics/board_pattern.h"

namespace armtrue {

/// A point of a board in an image [px]. The centre of the first pixel is (0, 0).
struct SeenCorner {
  int point = 0;  ///< index into points_of() the pattern
  double u = 0, v = 0;
};

/// What an image shows of a board; no corners if it shows none.
struct ImageCorners {
  int width = 0, height = 0;        ///< [px]
  std::vector<SeenCorner> corners;  ///< in the order of their points
  std::string hint;                 ///< why the board may not be found, with the remedy; or empty
};

/// Finds the corners of a board in an image file. `explain`: where the board is not found, look for
/// the reason, too, which takes longer. Throws InputError for a file that is no image.
using FindCorners =
    std::function<ImageCorners(const BoardPattern&, const std::string& file, bool explain)>;

/// Names of the library that finds corners by OpenCV, and of its only function. It is a separate
/// library, loaded where images are read, because OpenCV depends on a hundred others. The function
/// leaves the message of an error in `error`.
inline constexpr const char* kCornerLibrary = "libarmtrue-images.so";
inline constexpr const char* kCornerFunction = "armtrue_find_corners";
extern "C" void armtrue_find_corners(const BoardPattern& pattern, const std::string& file,
                                     bool explain, ImageCorners& found, std::string& error);

}  // namespace armtrue
