#pragma once

#include <string>

#include "armtrue/images/find_corners.h"
#include "armtrue/import/import_io.h"

namespace armtrue {

/// A folder of images of a board.
struct ImageFolder {
  std::string folder;
  BoardPattern pattern;
  std::string camera;  ///< its name in the robot file; empty if the file has one camera
};

/// The pixels of the board in the images of a folder, as a campaign before bind_touches().
/// `joints`: a table of joint angles, one row for each image: its column `image` names the file, or
/// the rows are in the order of the names, in which numbers count as numbers (img2 before img10).
/// An image that shows no board is left out with a warning. Throws InputError for a folder without
/// images, images of different sizes, rows that do not fit them, and if no image shows the board.
ImportedReadings import_images(const ImageFolder& folder, const std::string& joints,
                               const ImportOptions& options, const FindCorners& find_corners);

}  // namespace armtrue
