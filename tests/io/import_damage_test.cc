// Exported tables in random writings, each damaged in one way that changes no digit. Each is read
// with the right numbers, or refused by an error that names the file and a line.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "armtrue/io/import/import_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "io/import/presets.h"
#include "io/temporary_file.h"

namespace armtrue::import_damage_test {
namespace {

constexpr int kColumns = 10, kRows = 5;
constexpr int kKinds = 14;  // of damage

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

std::string fixed(double value, int decimals) {
  char digits[40];
  std::snprintf(digits, sizeof digits, "%.*f", decimals, value);
  return digits;
}

// Random numbers in mm and deg.
std::vector<double> random_row(std::mt19937_64& random) {
  std::vector<double> row;
  for (int c = 1; c < kColumns; ++c)
    row.push_back(static_cast<double>(static_cast<long>(random() % (c <= 3 ? 5000000 : 3600000)) -
                                      1700000) /
                  (c <= 3 ? 1000 : 10000));
  return row;
}

class DamagedExport {
 public:
  explicit DamagedExport(unsigned seed) : random_(seed) {
    sheet_.separator = std::string(",;\t")[below(3)];
    // In quotes between commas.
    comma_ = sheet_.separator == ',' ? below(4) == 0 : below(2) == 0;
    thousands_ = below(3) == 0;
    for (int r = 0; r < kRows; ++r) truth_["P" + std::to_string(r)] = random_row(random_);
    write();
  }

  // The right numbers, in mm and deg, by pose.
  const std::map<std::string, std::vector<double>>& truth() const { return truth_; }
  std::string text() const { return sheet_.text(); }
  void damage() { sheet_.damage(random_); }

 private:
  unsigned long below(unsigned long limit) { return random_() % limit; }

  std::string number(double value, int decimals) {
    std::string text = fixed(value, decimals);
    const size_t point = text.find('.');
    if (comma_) text[point] = ',';
    const size_t first = text[0] == '-' ? 1 : 0;
    if (thousands_ && point - first > 3) text.insert(point - 3, comma_ ? "." : ",");
    return sheet_.separator == ',' && text.find(',') != std::string::npos ? '"' + text + '"' : text;
  }

  void write() {
    const bool lower = below(2) == 0;
    const std::string joint = std::vector<std::string>{"A", "J", "Joint_", "q"}[below(4)];
    std::vector<std::string> header{lower ? "point" : "Point"};
    for (const char axis : std::string(lower ? "xyz" : "XYZ"))
      header.push_back(std::string(1, axis) + (below(2) ? " [mm]" : " (mm)"));
    for (int j = 1; j <= 6; ++j) header.push_back(joint + std::to_string(j) + " [deg]");
    sheet_.lines = {header};
    for (const auto& [id, numbers] : truth_) {
      std::vector<std::string> line{id};
      for (int c = 1; c < kColumns; ++c)
        line.push_back(number(numbers[static_cast<size_t>(c) - 1], c <= 3 ? 3 : 4));
      sheet_.lines.push_back(line);
    }
  }

  std::mt19937_64 random_;
  Sheet sheet_;
  bool comma_ = false, thousands_ = false;
  std::map<std::string, std::vector<double>> truth_;
};

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
  static void add(Line& line, const Line& more) { line.insert(line.end(), more.begin(), more.end()); }

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
    sheet_.lines = {{"Objects"}, {"100"}, {"", "", "tool", "", "", "", "", "", ""},
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
    const bool is_kuka = preset_.name == "kuka-trace";
    Line header{is_ur ? "timestamp" : is_kuka ? "Zeit(s)" : is_topic ? "%time" : "__time"};
    if (is_ur) sheet_.separator = ' ';
    if (is_topic)
      for (int j = 0; j < 6; ++j) header.push_back("field.name" + std::to_string(j));
    for (int j = 0; j < 6; ++j)
      header.push_back(is_ur      ? "actual_q_" + std::to_string(j)
                       : is_kuka  ? "AxisPos_Act" + std::to_string(j + 1) + "(deg)"
                       : is_topic ? "field.position" + std::to_string(j)
                                  : "/joint_states/arm_" + std::to_string(j + 1) + "/position");
    sheet_.lines = {header};
    begin_rows();
    for (int r = 0; r < kRows; ++r) {
      Line line{is_topic ? "173964158" + std::to_string(r) + "661579370" : fixed(r, 3)};
      if (is_topic)
        for (int j = 1; j <= 6; ++j) line.push_back("arm_" + std::to_string(j));
      for (size_t j = 0; j < 6; ++j)
        line.push_back(fixed(truth_[static_cast<size_t>(r)][3 + j] * (is_kuka ? 1 : kDegree), 12));
      sheet_.lines.push_back(line);
    }
  }

  const Preset& preset_;
  std::mt19937_64 random_;
  Sheet sheet_;
  std::vector<std::vector<double>> truth_;
};

// "" if all numbers are right.
std::string wrong_number(const Campaign& campaign,
                         const std::map<std::string, std::vector<double>>& truth) {
  for (int r = 0; r < campaign.rows(); ++r) {
    const auto row = static_cast<size_t>(r);
    const std::string& id = campaign.pose_ids[static_cast<size_t>(campaign.pose[row])];
    if (!truth.contains(id)) return "there is no pose " + id;
    for (int c = 0; c < kColumns - 1; ++c) {
      const double read =
          c < 3 ? campaign.position[row][c] / kMillimetre : campaign.q[row][c - 3] / kDegree;
      const double right = truth.at(id)[static_cast<size_t>(c)];
      if (std::abs(read - right) > 1e-9 * (1 + std::abs(right)))
        return id + ": " + std::to_string(read) + " for " + std::to_string(right);
    }
  }
  return "";
}

// The same of rows in their order, some of which may be missing; the body is turned as written.
std::string wrong_row(const Campaign& campaign, const std::vector<std::vector<double>>& truth) {
  for (int r = 0; r < campaign.rows(); ++r) {
    const auto row = static_cast<size_t>(r);
    const auto is_row = [&](const std::vector<double>& numbers) {
      for (int c = 0; c < kColumns - 1; ++c) {
        const double read =
            c < 3 ? campaign.position[row][c] / kMillimetre : campaign.q[row][c - 3] / kDegree;
        if (std::abs(read - numbers[static_cast<size_t>(c)]) > 1e-6) return false;
      }
      return true;
    };
    if (std::ranges::none_of(truth, is_row)) return "row " + std::to_string(r) + " is none of them";
    if (campaign.has_orientation() &&
        campaign.orientation[row].angularDistance(Eigen::Quaterniond(0.5, 0.5, 0.5, -0.5)) > 1e-9)
      return "row " + std::to_string(r) + " is turned otherwise";
    if (!campaign.time_s.empty() &&
        std::abs(std::remainder(campaign.time_s[row] - campaign.time_s[0], 0.01)) > 1e-6)
      return "row " + std::to_string(r) + " has another time";
  }
  return "";
}

ImportedReadings import_preset(const Preset& preset, const std::string& damaged,
                               const std::string& whole) {
  ImportOptions options;
  options.presets = {std::string(preset.name)};
  options.join = "order";
  return preset.holds_joints ? import_readings(whole, damaged, options)
                             : import_readings(damaged, whole, options);
}

TEST(ImportDamage, AWholeExportOfEachPresetIsRead) {
  for (const Preset& preset : presets()) {
    const PresetExport table(preset, 1);
    const TemporaryFile file(table.text()), other(table.other_table());
    const Campaign campaign = import_preset(preset, file.path, other.path).campaign;
    EXPECT_EQ(campaign.rows(), kRows) << preset.name;
    EXPECT_EQ(wrong_row(campaign, table.truth()), "") << preset.name << "\n" << table.text();
  }
}

TEST(ImportDamage, ADamagedExportOfEachPresetIsReadRightOrRefused) {
  for (const Preset& preset : presets()) {
    int refused = 0, read = 0;
    for (unsigned seed = 0; seed < 120; ++seed) {
      PresetExport table(preset, seed);
      table.damage();
      const TemporaryFile file(table.text()), other(table.other_table());
      try {
        const Campaign campaign = import_preset(preset, file.path, other.path).campaign;
        EXPECT_EQ(wrong_row(campaign, table.truth()), "")
            << preset.name << " " << seed << "\n" << table.text();
        ++read;
      } catch (const InputError& error) {
        ++refused;
        const std::string what = error.what();
        const bool names_a_line = what.starts_with(file.path + ":") &&
                                  std::isdigit(static_cast<unsigned char>(what[file.path.size() + 1]));
        EXPECT_TRUE(names_a_line || what.find("--join order needs as many") != std::string::npos)
            << preset.name << " " << what;
        EXPECT_TRUE(what.find("; ") != std::string::npos || what.find(". ") != std::string::npos)
            << preset.name << " says no remedy: " << what;
      }
    }
    EXPECT_GT(refused, 40) << preset.name;
    EXPECT_GT(read, 10) << preset.name;
  }
}

TEST(ImportDamage, AWholeTableIsReadInAnyWriting) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const DamagedExport table(seed);
    const TemporaryFile file(table.text());
    const Campaign campaign = import_readings(file.path, {}).campaign;
    EXPECT_EQ(campaign.rows(), kRows) << table.text();
    EXPECT_EQ(wrong_number(campaign, table.truth()), "") << table.text();
  }
}

TEST(ImportDamage, ADamagedTableIsReadRightOrRefusedWithItsLine) {
  int refused = 0, read = 0;
  for (unsigned seed = 0; seed < 1000; ++seed) {
    DamagedExport table(seed);
    table.damage();
    const TemporaryFile file(table.text());
    try {
      EXPECT_EQ(wrong_number(import_readings(file.path, {}).campaign, table.truth()), "")
          << seed << "\n"
          << table.text();
      ++read;
    } catch (const InputError& error) {
      ++refused;
      const std::string what = error.what();
      ASSERT_TRUE(what.starts_with(file.path + ":")) << what;
      EXPECT_TRUE(std::isdigit(static_cast<unsigned char>(what[file.path.size() + 1]))) << what;
    }
  }
  EXPECT_GT(refused, 300);
  EXPECT_GT(read, 150);
}

}  // namespace
}  // namespace armtrue::import_damage_test
