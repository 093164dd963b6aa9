#include "io/yaml/camera_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "armtrue/kinematics/board_pattern.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "io/yaml/link_io.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

constexpr std::array kPlaceKeys{"x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"};
constexpr std::array<const char*, kIntrinsics> kIntrinsicKeys{
    "fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2", "k3", "k4"};

bool has_lens(Lens lens, int intrinsic) {
  if (lens == Lens::pinhole) return intrinsic != kK4;
  return intrinsic != kP1 && intrinsic != kP2;
}

void read_mounting(YamlMap& map, Contact& contact) {
  if (!map.has("on"))
    map.fail("on", "is missing; write arm (fixed in the measured frame) or cell (at rest)");
  const std::string on = map.text("on");
  if (on != "arm" && on != "cell")
    map.fail("on", "'" + on + "' is none of arm (fixed in the measured frame) and cell (at rest)");
  contact.on_arm = on == "arm";
  contact.is_placed =
      std::ranges::any_of(kPlaceKeys, [&](const char* key) { return map.has(key); });
  if (!contact.is_placed) return;
  contact.place.translation = read_position(map);
  contact.place.rotation = read_rotation(map);
}

void read_image_size(YamlMap& map, Contact& camera) {
  if (!map.has("width_px") && !map.has("height_px")) return;
  camera.image_size = {map.number("width_px"), map.number("height_px")};
  constexpr double kMostPixels = 1e5;  // of a side
  const Eigen::Vector2d& size = camera.image_size;
  if (size.minCoeff() < 1 || size.maxCoeff() > kMostPixels || size != size.array().floor().matrix())
    map.fail("width_px",
             fmt::format("and height_px must be whole numbers of pixels, from 1 to {:.0f}",
                         kMostPixels));
}

// Corners of a grid, counted from 0, row by row: x along the columns, y along the rows.
void read_grid(YamlMap& map, Contact& contact) {
  constexpr double kMostCorners = 10000;  // of a board; more are none
  const double columns = map.number("columns"), rows = map.number("rows");
  const double pitch = map.number("pitch_mm") * kMillimetre;
  for (const auto& [key, count] : {std::pair("columns", columns), std::pair("rows", rows)})
    if (count < 2 || count != std::floor(count) || count > kMostCorners)
      map.fail(key, fmt::format("must be a whole number of corners, from 2 to {:.0f}", kMostCorners));
  if (columns * rows > kMostCorners) map.fail("rows", "times columns is more than a board has");
  if (pitch <= 0) map.fail("pitch_mm", "must be above zero");
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      contact.points.push_back(
          {std::to_string(contact.points.size()), Eigen::Vector3d(column, row, 0) * pitch});
}

// A board pattern in the form of import-readings --board.
void read_pattern(YamlMap& map, Contact& contact) {
  const std::string text = map.text("pattern");
  try {
    contact.points = points_of(board_pattern(text));
  } catch (const std::invalid_argument& error) {
    map.fail("pattern", error.what());
  }
}

// Whether the points span a plane: only then an image shows the pose of the board.
bool spans_plane(const std::vector<ArtefactPoint>& points) {
  constexpr double kFlat = 1e-3;  // of the length
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const ArtefactPoint& point : points)
    mean += point.position.head<2>() / static_cast<double>(points.size());
  for (const ArtefactPoint& point : points) {
    const Eigen::Vector2d from = point.position.head<2>() - mean;
    squares += from * from.transpose();
  }
  const double trace = squares.trace();
  return squares.determinant() > kFlat * kFlat * trace * trace;
}

void read_corners(YamlMap& map, Contact& contact) {
  YamlMap points = map.map("points");
  for (const std::string& name : points.keys()) {
    const std::vector<double> p = points.numbers(name, 2);
    contact.points.push_back({name, Eigen::Vector3d(p[0], p[1], 0) * kMillimetre});
  }
}

YAML::Node mounted_node(const Contact& contact, std::vector<FlowEntry> entries) {
  entries.insert(entries.begin(), {"on", contact.on_arm ? "arm" : "cell"});
  if (contact.is_placed) {
    std::vector<NumberText> values;
    for (double length : contact.place.translation)
      values.push_back(number_text(length, kMillimetre));
    for (const NumberText& angle : rotation_texts(contact.place.rotation)) values.push_back(angle);
    for (size_t k = 0; k < kPlaceKeys.size(); ++k) entries.emplace_back(kPlaceKeys[k], values[k]);
  }
  return flow_map(entries);
}

}  // namespace

Contact read_camera(const std::string& name, YamlMap map) {
  Contact camera;
  camera.name = name;
  camera.kind = ContactKind::camera;
  if (map.has("lens")) {
    const std::string lens = map.text("lens");
    if (lens != "pinhole" && lens != "fisheye")
      map.fail("lens", "'" + lens + "' is none of pinhole and fisheye");
    camera.lens = lens == "fisheye" ? Lens::fisheye : Lens::pinhole;
  }
  read_mounting(map, camera);
  for (int k = 0; k < kIntrinsics; ++k) {
    const char* const key = kIntrinsicKeys[k];
    if (!has_lens(camera.lens, k)) continue;
    camera.intrinsics[k] = k < kK1 ? map.number(key) : map.number(key, 0);
  }
  for (int k : {kFx, kFy})
    if (camera.intrinsics[k] <= 0)
      map.fail(
          kIntrinsicKeys[k],
          "must be above zero: the focal length in pixels, that in mm over the size of a pixel");
  read_image_size(map, camera);
  map.finish();
  return camera;
}

Contact read_board(const std::string& name, YamlMap map) {
  Contact board;
  board.name = name;
  board.kind = ContactKind::board;
  read_mounting(map, board);
  if (map.has("points"))
    read_corners(map, board);
  else if (map.has("pattern"))
    read_pattern(map, board);
  else
    read_grid(map, board);
  constexpr size_t kFewestPoints = 4;
  if (board.points.size() < kFewestPoints || !spans_plane(board.points))
    map.fail(
        "points",
        "are fewer than four, or lie on one line: an image of them shows neither the scale nor "
        "how the board is turned");
  map.finish();
  return board;
}

YAML::Node node_of_images(const Contact& contact) {
  if (contact.kind == ContactKind::camera) {
    std::vector<FlowEntry> entries{{"lens", contact.lens == Lens::fisheye ? "fisheye" : "pinhole"}};
    for (int k = 0; k < kIntrinsics; ++k)
      if (has_lens(contact.lens, k))
        entries.emplace_back(kIntrinsicKeys[k], number_text(contact.intrinsics[k]));
    if (!contact.image_size.isZero()) {
      entries.emplace_back("width_px", number_text(contact.image_size.x()));
      entries.emplace_back("height_px", number_text(contact.image_size.y()));
    }
    return mounted_node(contact, entries);
  }
  YAML::Node node = mounted_node(contact, {});
  for (const ArtefactPoint& point : contact.points)
    node["points"][point.name] =
        flow_list({point.position.x() / kMillimetre, point.position.y() / kMillimetre});
  return node;
}

}  // namespace armtrue
