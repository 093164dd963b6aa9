#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

enum class BoardKind {
  checkerboard,        ///< inner corners of a chessboard
  circles,             ///< centres of circles on a square grid
  asymmetric_circles,  ///< the same, every second row shifted by half a pitch
  charuco,             ///< inner corners of a chessboard with a marker in each white square
  tags,                ///< corners of markers on a square grid: AprilTag, ArUco
};

/// How a board is printed, as OpenCV describes its boards.
struct BoardPattern {
  BoardKind kind = BoardKind::checkerboard;
  int columns = 0, rows = 0;  ///< as OpenCV counts: corners, circles, squares (charuco), tags
  double pitch = 0;           ///< of corners, circles or squares; the side of a tag [m]
  double gap = 0;             ///< between tags [m]
  std::string family;  ///< of markers: 4x4, 5x5, 6x6, 7x7, original, 16h5, 25h9, 36h10, 36h11
  /// A charuco board of OpenCV before 4.6: with an even number of rows, its first square is white.
  bool is_legacy = false;
  std::string text;  ///< as the user wrote it
};

/// A pattern as users write it: `checkerboard:9x6:25mm`, `circles:7x6:20mm`,
/// `asymmetric-circles:4x11:20mm`, `charuco:7x5:30mm:5x5`, `apriltag:6x6:40mm:12mm:36h11`. Throws
/// std::invalid_argument with the remedy.
BoardPattern board_pattern(std::string_view text);

/// The points of a board that images show, named by their numbers from 0, row by row; of each tag
/// its corners, clockwise from the upper left one. x points along the rows, y down the columns.
std::vector<ArtefactPoint> points_of(const BoardPattern& pattern);

/// Whether the points look the same if the board is turned by half a turn: an image does not show
/// which end is which.
bool is_symmetric(const BoardPattern& pattern);

}  // namespace armtrue
