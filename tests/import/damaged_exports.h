#pragma once

// Exports in the formats of the presets, and what may happen to them on the way. No digit changes.

#include <algorithm>
#include <cstdio>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "import/presets.h"

namespace armtrue::import_damage_test {

inline constexpr int kColumns = 10, kRows = 5;
inline constexpr int kKinds = 14;  // of damage

// The cells of an export, and what may happen to them on the way.
struct Sheet {
  std::vector<std::vector<std::string>> lines;
  size_t header = 0, first_row = 1;
  char separator = ',';
  std::string end = "\n";
  bool has_names = true;  // otherwise nothing tells one column from another

  std::string text() const {
    std::string text;
    for (const auto& line : lines) {
      for (size_t k = 0; k < line.size(); ++k)
        (text += k ? std::string(1, separator) : "") += line[k];
      text += end;
    }
    return text;
  }

  void damage(std::mt19937_64& random) {
    const auto below = [&](unsigned long limit) { return random() % limit; };
    const size_t row = first_row + below(kRows), width = lines[first_row].size();
    const size_t column = 1 + below(width - 1);
    std::string& cell = lines[row][column];
    switch (below(kKinds)) {
      case 0:  // a separator is lost
        lines[row][column - 1] += cell;
        lines[row].erase(lines[row].begin() + static_cast<long>(column));
        break;
      case 1:
        lines[row].insert(lines[row].begin() + static_cast<long>(column), "");
        break;
      case 2:
        lines.erase(lines.begin() + static_cast<long>(row));
        break;
      case 3:
        if (column < lines[header].size())
          lines[header][column] = lines[header][1 + below(lines[header].size() - 1)];
        break;
      case 4:
        if (first_row > 0) lines.erase(lines.begin() + static_cast<long>(below(first_row)));
        break;
      case 5:
        if (column < lines[header].size())
          lines[header][column] = lines[header][column].substr(0, lines[header][column].find(' '));
        break;
      case 6:  // another decimal sign
        for (char& c : cell) c = c == '.' ? ',' : c == ',' ? '.' : c;
        break;
      case 7:
        cell = std::vector<std::string>{"n/a", "", "nan", "--", "1e999", "12.5 mm"}[below(6)];
        break;
      case 8:
        lines.insert(lines.begin() + static_cast<long>(row), std::vector<std::string>{""});
        break;
      case 9:
        cell += '"';
        break;
      case 10:
        end = "\r\n";
        break;
      case 11:
        lines.insert(lines.begin() + static_cast<long>(row),
                     std::vector<std::string>{"# a comment", "1", "2"});
        break;
      case 12: {  // columns in another order
        const size_t other = below(width);
        for (auto& line : lines)
          if (has_names && line.size() == width) std::swap(line[column], line[other]);
        break;
      }
      default:  // the export was cut
        lines.back().resize(1 + below(width - 1));
    }
  }
};

inline std::string fixed(double value, int decimals) {
  char digits[40];
  std::snprintf(digits, sizeof digits, "%.*f", decimals, value);
  return digits;
}

// Random numbers in mm and deg.
inline std::vector<double> random_row(std::mt19937_64& random) {
  std::vector<double> row;
  for (int c = 1; c < kColumns; ++c)
    row.push_back(
        static_cast<double>(static_cast<long>(random() % (c <= 3 ? 5000000 : 3600000)) - 1700000) /
        (c <= 3 ? 1000 : 10000));
  return row;
}

// An export in the format of a preset, and the other table, whole. Rows are joined in their order.
class PresetExport {
 public:
  PresetExport(const Preset& preset, unsigned seed) : preset_(preset), random_(seed) {
    for (int r = 0; r < kRows; ++r) truth_.push_back(random_row(random_));
    if (preset.name == "spatialanalyzer")
      spatial_analyzer();
    else if (preset.name == "optitrack")
      optitrack();
    else if (preset.name == "vicon")
      vicon();
    else if (preset.name == "qualisys")
      qualisys();
    else if (preset.holds_joints)
      joints();
    else
      ros_poses();
  }

  const std::vector<std::vector<double>>& truth() const { return truth_; }
  std::string text() const { return sheet_.text(); }
  void damage() { sheet_.damage(random_); }
  std::string other_table() const {
    Sheet other;
    other.lines.push_back(preset_.holds_joints
                              ? std::vector<std::string>{"X [mm]", "Y [mm]", "Z [mm]"}
                              : std::vector<std::string>{"A1 [deg]", "A2 [deg]", "A3 [deg]",
                                                         "A4 [deg]", "A5 [deg]", "A6 [deg]"});
    for (const auto& row : truth_) {
      std::vector<std::string>& line = other.lines.emplace_back();
      for (size_t c = preset_.holds_joints ? 0 : 3; c < (preset_.holds_joints ? 3u : 9u); ++c)
        line.push_back(fixed(row[c], c < 3 ? 3 : 4));
    }
    return other.text();
  }

 private:
  using Line = std::vector<std::string>;

  void begin_rows() {
    sheet_.header = sheet_.lines.size() - 1;
    sheet_.first_row = sheet_.lines.size();
  }
  Line point(int row, double unit_mm) const {
    Line cells;
    for (size_t c = 0; c < 3; ++c)
      cells.push_back(fixed(truth_[static_cast<size_t>(row)][c] / unit_mm, unit_mm > 1 ? 6 : 3));
    return cells;
  }
  static void add(Line& line, const Line& more) {
    line.insert(line.end(), more.begin(), more.end());
  }

  void spatial_analyzer() {
    sheet_.has_names = false;
    sheet_.lines = {{"// SpatialAnalyzer"}, {"// AXES = CARTESIAN: X", "  Y", "  Z (mm)"}};
    begin_rows();
    for (int r = 0; r < kRows; ++r) {
      Line line{"Cell", "Main", "P" + std::to_string(r)};
      add(line, point(r, 1));
      line.push_back("02/12/25 16:38:0" + std::to_string(r));
      sheet_.lines.push_back(line);
    }
  }

  void optitrack() {
    sheet_.lines = {{"Format Version", "1.23", "Rotation Type", "Quaternion", "Length Units",
                     "Meters", "Coordinate Space", "Global"},
                    {""}};
    for (const char* words : {"Type Rigid-Body Rigid-Body", "Name tool tool", "ID a a"}) {
      std::istringstream in(words);
      std::string label, first, second;
      in >> label >> first >> second;
      std::replace(first.begin(), first.end(), '-', ' ');
      Line line{"", label};
      line.insert(line.end(), 8, first);
      sheet_.lines.push_back(line);
    }
    Line kinds{"", ""};
    kinds.insert(kinds.end(), 4, "Rotation");
    kinds.insert(kinds.end(), 3, "Position");
    kinds.push_back("Mean Marker Error");
    sheet_.lines.push_back(kinds);
    sheet_.lines.push_back({"Frame", "Time (Seconds)", "X", "Y", "Z", "W", "X", "Y", "Z", ""});
    begin_rows();
    for (int r = 0; r < kRows; ++r) {
      Line line{std::to_string(r), fixed(0.01 * r, 6), "0.5", "0.5", "-0.5", "0.5"};
      add(line, point(r, 1000));
      line.push_back("0.000113");
      sheet_.lines.push_back(line);
    }
  }

  void vicon() {
    sheet_.lines = {{"Objects"},
                    {"100"},
                    {"", "", "tool", "", "", "", "", "", ""},
                    {"Frame", "Sub Frame", "RX", "RY", "RZ", "RW", "TX", "TY", "TZ"},
                    {"", "", "", "", "", "", "mm", "mm", "mm"}};
    begin_rows();
    sheet_.header = 3;
    for (int r = 0; r < kRows; ++r) {
      Line line{std::to_string(r + 1), "0", "0.5", "0.5", "-0.5", "0.5"};
      add(line, point(r, 1));
      sheet_.lines.push_back(line);
    }
  }

  void qualisys() {
    sheet_.separator = '\t';
    sheet_.lines = {{"NO_OF_FRAMES", std::to_string(kRows)},
                    {"FREQUENCY", "100"},
                    {"DATA_INCLUDED", "6D"},
                    {"BODY_NAMES", "tool"},
                    {"Frame", "Time", "tool X", "Y", "Z", "Roll", "Pitch", "Yaw", "Residual"}};
    for (int k = 0; k < 9; ++k) sheet_.lines.back().push_back("Rot[" + std::to_string(k) + "]");
    begin_rows();
    for (int r = 0; r < kRows; ++r) {
      Line line{std::to_string(r + 1), fixed(0.01 * r, 5)};
      add(line, point(r, 1));
      add(line, {"90.000", "0.000", "-90.000", "0.113"});
      add(line, {"0", "0", "-1", "1", "0", "0", "0", "-1", "0"});  // column by column
      sheet_.lines.push_back(line);
    }
  }

  void ros_poses() {
    const bool is_topic = preset_.name == "rostopic-poses";
    Line header{is_topic ? "%time" : "__time"};
    for (const char* part : {"position", "orientation"})
      for (const char axis : std::string(part == std::string("position") ? "xyz" : "xyzw"))
        header.push_back(is_topic ? "field.pose." + std::string(part) + "." + axis
                                  : "/tool/pose/" + std::string(part) + "/" + axis);
    sheet_.lines = {header};
    begin_rows();
    for (int r = 0; r < kRows; ++r) {
      Line line{is_topic ? "173964158" + std::to_string(r) + "661579370" : fixed(1.6e9 + r, 3)};
      add(line, point(r, 1000));
      add(line, {"0.5", "0.5", "-0.5", "0.5"});
      sheet_.lines.push_back(line);
    }
  }

  void joints() {
    const bool is_topic = preset_.name == "rostopic-joints", is_ur = preset_.name == "ur-rtde";
    const bool is_trace = preset_.name == "kuka-trace";
    Line header{is_ur ? "timestamp" : is_topic ? "%time" : is_trace ? "Zeit[sec]" : "__time"};
    if (is_ur) sheet_.separator = ' ';
    if (is_trace) sheet_.separator = ';';
    if (is_topic)
      for (int j = 0; j < 6; ++j) header.push_back("field.name" + std::to_string(j));
    for (int j = 0; j < 6; ++j)
      header.push_back(is_ur      ? "actual_q_" + std::to_string(j)
                       : is_topic ? "field.position" + std::to_string(j)
                       : is_trace ? "AxisPos_Act" + std::to_string(j + 1) + "[\xC2\xB0]"
                                  : "/joint_states/arm_" + std::to_string(j + 1) + "/position");
    sheet_.lines = {header};
    begin_rows();
    for (int r = 0; r < kRows; ++r) {
      Line line{is_topic ? "173964158" + std::to_string(r) + "661579370" : fixed(r, 3)};
      if (is_topic)
        for (int j = 1; j <= 6; ++j) line.push_back("arm_" + std::to_string(j));
      for (size_t j = 0; j < 6; ++j)
        line.push_back(fixed(truth_[static_cast<size_t>(r)][3 + j] * kDegree, 12));
      sheet_.lines.push_back(line);
    }
  }

  const Preset& preset_;
  std::mt19937_64 random_;
  Sheet sheet_;
  std::vector<std::vector<double>> truth_;
};

}  // namespace armtrue::import_damage_test
