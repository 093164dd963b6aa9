// Exported tables in random writings, each damaged in one way that changes no digit. Each is read
// with the right numbers, or refused by an error that names the file and a line.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "armtrue/io/import/import_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "io/temporary_file.h"

namespace armtrue::import_damage_test {
namespace {

constexpr int kColumns = 10, kRows = 5;

class DamagedExport {
 public:
  explicit DamagedExport(unsigned seed) : random_(seed) {
    separator_ = std::string(",;\t")[below(3)];
    comma_ = separator_ == ',' ? below(4) == 0 : below(2) == 0;  // in quotes between commas
    thousands_ = below(3) == 0;
    for (int r = 0; r < kRows; ++r) {
      std::vector<double>& row = truth_["P" + std::to_string(r)];
      for (int c = 1; c < kColumns; ++c)
        row.push_back(
            static_cast<double>(static_cast<long>(below(c <= 3 ? 5000000 : 3600000)) - 1700000) /
            (c <= 3 ? 1000 : 10000));
    }
    write();
  }

  // The right numbers, in mm and deg, by pose.
  const std::map<std::string, std::vector<double>>& truth() const { return truth_; }

  std::string text() const {
    std::string text;
    for (const auto& line : lines_) {
      for (size_t k = 0; k < line.size(); ++k)
        (text += k ? std::string(1, separator_) : "") += line[k];
      text += end_;
    }
    return text;
  }

  void damage() {
    const size_t row = first_row_ + below(kRows), column = 1 + below(kColumns - 1);
    std::string& cell = lines_[row][column];
    switch (below(14)) {
      case 0:  // a separator is lost
        lines_[row][column - 1] += cell;
        lines_[row].erase(lines_[row].begin() + static_cast<long>(column));
        break;
      case 1:
        lines_[row].insert(lines_[row].begin() + static_cast<long>(column), "");
        break;
      case 2:
        lines_.erase(lines_.begin() + static_cast<long>(row));
        break;
      case 3:
        lines_[0][column] = lines_[0][1 + below(kColumns - 1)];
        break;
      case 4:
        lines_.erase(lines_.begin());
        break;
      case 5:
        lines_[0][column] = lines_[0][column].substr(0, lines_[0][column].find(' '));
        break;
      case 6:  // another decimal sign
        for (char& c : cell) c = c == '.' ? ',' : c == ',' ? '.' : c;
        break;
      case 7:
        cell = std::vector<std::string>{"n/a", "", "nan", "--", "1e999", "12.5 mm"}[below(6)];
        break;
      case 8:
        lines_.insert(lines_.begin() + static_cast<long>(row), std::vector<std::string>{""});
        break;
      case 9:
        cell += '"';
        break;
      case 10:
        end_ = "\r\n";
        break;
      case 11:
        lines_.insert(lines_.begin() + static_cast<long>(row),
                      std::vector<std::string>{"# a comment", "1", "2"});
        break;
      case 12: {  // columns in another order
        const size_t other = below(kColumns);
        for (auto& line : lines_) std::swap(line[column], line[other]);
        break;
      }
      default:  // the export was cut
        lines_.back().resize(1 + below(kColumns - 1));
    }
  }

 private:
  unsigned long below(unsigned long limit) { return random_() % limit; }

  std::string number(double value, int decimals) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%.*f", decimals, value);
    std::string text = digits;
    const size_t point = text.find('.');
    if (comma_) text[point] = ',';
    const size_t first = text[0] == '-' ? 1 : 0;
    if (thousands_ && point - first > 3) text.insert(point - 3, comma_ ? "." : ",");
    return separator_ == ',' && text.find(',') != std::string::npos ? '"' + text + '"' : text;
  }

  void write() {
    const bool lower = below(2) == 0;
    const std::string joint = std::vector<std::string>{"A", "J", "Joint_", "q"}[below(4)];
    std::vector<std::string> header{lower ? "point" : "Point"};
    for (const char axis : std::string(lower ? "xyz" : "XYZ"))
      header.push_back(std::string(1, axis) + (below(2) ? " [mm]" : " (mm)"));
    for (int j = 1; j <= 6; ++j) header.push_back(joint + std::to_string(j) + " [deg]");
    lines_ = {header};
    for (const auto& [id, numbers] : truth_) {
      std::vector<std::string> line{id};
      for (int c = 1; c < kColumns; ++c)
        line.push_back(number(numbers[static_cast<size_t>(c) - 1], c <= 3 ? 3 : 4));
      lines_.push_back(line);
    }
  }

  std::mt19937_64 random_;
  char separator_ = ',';
  bool comma_ = false, thousands_ = false;
  size_t first_row_ = 1;
  std::string end_ = "\n";
  std::map<std::string, std::vector<double>> truth_;
  std::vector<std::vector<std::string>> lines_;
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
