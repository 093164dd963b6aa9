#include "armtrue/kinematics/board_pattern.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr int kMostPoints = 10000;  // of a board; more are none
constexpr std::array<std::pair<std::string_view, BoardKind>, 5> kKinds{{
    {"checkerboard", BoardKind::checkerboard},
    {"circles", BoardKind::circles},
    {"asymmetric-circles", BoardKind::asymmetric_circles},
    {"charuco", BoardKind::charuco},
    {"apriltag", BoardKind::tags},
}};
constexpr std::array<std::string_view, 9> kFamilies{"4x4",  "5x5",  "6x6",   "7x7",  "original",
                                                    "16h5", "25h9", "36h10", "36h11"};

std::vector<std::string> parts_of(std::string_view text) {
  std::vector<std::string> parts(1);
  for (char c : text)
    if (c == ':')
      parts.emplace_back();
    else
      parts.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return parts;
}

// 7x5.
std::optional<std::pair<int, int>> read_counts(const std::string& text) {
  const char* const end = text.data() + text.size();
  int columns = 0, rows = 0;
  const auto [cross, first] = std::from_chars(text.data(), end, columns);
  if (first != std::errc() || cross == end || *cross != 'x') return std::nullopt;
  const auto [last, second] = std::from_chars(cross + 1, end, rows);
  if (second != std::errc() || last != end) return std::nullopt;
  return std::pair(columns, rows);
}

// 30mm, 2.5cm, 0.03m.
std::optional<double> read_length(const std::string& text) {
  constexpr std::array<std::pair<std::string_view, double>, 3> kUnits{
      {{"mm", kMillimetre}, {"cm", 1e-2}, {"m", 1.0}}};
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [unit, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  for (const auto& [name, factor] : kUnits)
    if (std::string_view(unit, end - unit) == name) return value * factor;
  return std::nullopt;
}

// OpenCV's names, too: DICT_5X5_250, APRILTAG_36h11. The number of codes follows from the board.
std::string family_of(std::string text) {
  for (const std::string_view before : {"dict_", "apriltag_", "aruco_", "tag"})
    if (text.starts_with(before)) text.erase(0, before.size());
  return text.substr(0, text.find('_'));
}

class PatternReader {
 public:
  explicit PatternReader(std::string_view text) : parts_(parts_of(text)) { pattern_.text = text; }

  BoardPattern read() {
    read_kind();
    read_size();
    size_t next = 3;
    const bool has_markers =
        pattern_.kind == BoardKind::charuco || pattern_.kind == BoardKind::tags;
    if (pattern_.kind == BoardKind::tags) {
      pattern_.gap = length(next++, "the gap between two tags");
      pattern_.family = "36h11";
    } else if (has_markers) {
      pattern_.family = "4x4";
    }
    for (; next < parts_.size(); ++next) {
      const std::string& part = parts_[next];
      if (pattern_.kind == BoardKind::charuco && part == "legacy") {
        pattern_.is_legacy = true;
      } else if (has_markers && std::ranges::count(kFamilies, family_of(part)) > 0) {
        pattern_.family = family_of(part);
      } else if (has_markers && read_length(part)) {
        fail("'" + part + "' is one length too many; the size of the markers is not needed");
      } else if (has_markers) {
        fail("'" + part +
             "' is no family of markers; these are 4x4, 5x5, 6x6, 7x7, original, "
             "16h5, 25h9, 36h10, 36h11");
      } else {
        fail("'" + part + "' is too much");
      }
    }
    return pattern_;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::invalid_argument(
        "the board '" + pattern_.text + "': " + what +
        "; boards are checkerboard:9x6:25mm (inner corners), circles:7x6:20mm, "
        "asymmetric-circles:4x11:20mm, charuco:7x5:30mm:5x5 (squares), "
        "apriltag:6x6:40mm:12mm:36h11 (side, gap)");
  }

  void read_kind() {
    const std::string kind = parts_.front() == "chessboard" ? "checkerboard" : parts_.front();
    const auto* const found =
        std::ranges::find(kKinds, kind, [](const auto& k) { return k.first; });
    if (found == kKinds.end()) fail("'" + kind + "' is no kind of board");
    pattern_.kind = found->second;
  }

  void read_size() {
    const auto counts = parts_.size() > 1 ? read_counts(parts_[1]) : std::nullopt;
    if (!counts) fail("columns and rows, such as 9x6, stand behind the kind");
    std::tie(pattern_.columns, pattern_.rows) = *counts;
    const bool is_tags = pattern_.kind == BoardKind::tags;
    const int fewest = is_tags ? 1 : 3;
    for (int count : {pattern_.columns, pattern_.rows})
      if (count < fewest || count > kMostPoints / 4)
        fail(std::to_string(count) + " columns or rows are " +
             (count < fewest ? "too few; " + std::to_string(fewest) + " are the fewest"
                             : "more than a board has"));
    if (pattern_.columns * pattern_.rows > kMostPoints / (is_tags ? 4 : 1))
      fail("has more points than a board has");
    pattern_.pitch = length(2, is_tags ? "the side of a tag" : "the distance of its points");
  }

  double length(size_t part, const std::string& what) const {
    const auto read = part < parts_.size() ? read_length(parts_[part]) : std::nullopt;
    if (!read || *read <= 0)
      fail(what + ", above zero and with its unit, such as 25mm, is missing" +
           (part < parts_.size() ? ": '" + parts_[part] + "'" : ""));
    return *read;
  }

  std::vector<std::string> parts_;
  BoardPattern pattern_;
};

}  // namespace

BoardPattern board_pattern(std::string_view text) { return PatternReader(text).read(); }

std::vector<ArtefactPoint> points_of(const BoardPattern& pattern) {
  std::vector<ArtefactPoint> points;
  const auto add = [&](double x, double y) {
    points.push_back({std::to_string(points.size()), Eigen::Vector3d(x, y, 0) * pattern.pitch});
  };
  const int inner = pattern.kind == BoardKind::charuco ? 1 : 0;
  const double step = 1 + pattern.gap / pattern.pitch;
  for (int row = 0; row < pattern.rows - inner; ++row)
    for (int column = 0; column < pattern.columns - inner; ++column) {
      if (pattern.kind == BoardKind::tags) {
        const double x = step * column, y = step * row;
        add(x, y);
        add(x + 1, y);
        add(x + 1, y + 1);
        add(x, y + 1);
      } else if (pattern.kind == BoardKind::asymmetric_circles) {
        add(2 * column + row % 2, row);
      } else {
        add(column, row);
      }
    }
  return points;
}

bool is_symmetric(const BoardPattern& pattern) {
  switch (pattern.kind) {
    case BoardKind::checkerboard:  // turned, the squares have the other colour
      return (pattern.columns + pattern.rows) % 2 == 0;
    case BoardKind::circles:
      return true;
    case BoardKind::asymmetric_circles:  // turned, the shifted rows stand in the place of others
      return pattern.rows % 2 == 0;
    case BoardKind::charuco:
    case BoardKind::tags:
      return false;
  }
  return false;
}

}  // namespace armtrue
