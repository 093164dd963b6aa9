// Exported tables in random writings, each damaged in one way that changes no digit. Each is read
// with the right numbers, or refused by an error that names the file and a line.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "armtrue/import/import_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "import/damaged_exports.h"
#include "support/temporary_file.h"

namespace armtrue::import_damage_test {
namespace {

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
  if (preset.name == "kuka-trace") options.angle_unit = "rad";
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
    for (unsigned seed = 0; seed < 140; ++seed) {
      PresetExport table(preset, seed);
      table.damage();
      const TemporaryFile file(table.text()), other(table.other_table());
      try {
        const Campaign campaign = import_preset(preset, file.path, other.path).campaign;
        EXPECT_EQ(wrong_row(campaign, table.truth()), "") << preset.name << " " << seed << "\n"
                                                          << table.text();
        ++read;
      } catch (const InputError& error) {
        ++refused;
        const std::string what = error.what();
        const char behind = what[std::min(what.size() - 1, file.path.size() + 1)];
        const bool names_a_line = what.starts_with(file.path + ":") &&
                                  std::isdigit(static_cast<unsigned char>(behind)) != 0;
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
