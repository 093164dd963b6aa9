#include "import/table_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "armtrue/campaign/turns.h"
#include "armtrue/text/input_error.h"
#include "import/orientation_columns.h"

namespace armtrue {

std::vector<std::string> TableReader::quantities() const {
  std::vector<std::string> names;
  for (const auto& [quantity, column] : mapping_.columns) names.push_back(quantity);
  return names;
}

const std::string& TableReader::cell(int r, const std::string& quantity) const {
  return row(r).cells[mapping_.find(quantity)->column];
}

void TableReader::fail(int r, const std::string& quantity, const std::string& what) const {
  table_.fail(row(r), mapping_.find(quantity)->column, what);
}

double TableReader::number(int r, const std::string& quantity) const {
  const std::string& text = cell(r, quantity);
  if (text.empty()) fail(r, quantity, "is empty; complete or remove the row");
  if (const auto count = plain_count(text); quantity == "t" && count)
    return mapping_.find(quantity)->factor * *count;
  const auto read = plain_number(text, mapping_.decimal_sign);
  if (!read)
    fail(r, quantity,
         fmt::format("is no number with a decimal {}; correct it or remove the row",
                     mapping_.decimal_sign == ',' ? "comma" : "point"));
  if (read->ambiguous && !mapping_.decimal_stated)
    fail(r, quantity,
         fmt::format("can be read with a thousands separator or with a decimal sign; correct it, "
                     "or say --decimal {} if thousands are separated",
                     mapping_.decimal_sign == ',' ? "comma" : "point"));
  return mapping_.find(quantity)->factor * read->value;
}

int TableReader::whole_number(int r, const std::string& quantity) const {
  const double value = number(r, quantity);
  if (value != std::floor(value) || std::abs(value) > 2e9)
    fail(r, quantity, "is no whole number; correct it");
  return static_cast<int>(value);
}

const std::string& TableReader::name(int r, const std::string& quantity) const {
  const std::string& text = cell(r, quantity);
  if (text.empty()) fail(r, quantity, "is empty; every row needs a name here");
  if (text.find_first_of(",\"\t") != std::string::npos || text.front() == '#')
    fail(r, quantity,
         "holds a comma, a quote or a tab, or begins with #, which the names of measured poses "
         "cannot; rename it");
  return text;
}

JointVector TableReader::joints(int r) const {
  if (!moved_.empty()) return moved_[moved_row_[r]];
  JointVector q(mapping_.joints.size());
  for (Eigen::Index j = 0; j < q.size(); ++j) q[j] = number(r, mapping_.joints[j].column);
  return q;
}

std::string TableReader::move_joints_into_travel(const KinematicChain& chain) {
  JointRows q;
  std::vector<int> lines, poses, row_of(rows(), -1);
  std::map<std::string, int> numbers;  // of the poses
  for (int r = 0; r < rows(); ++r) {
    if (has("x") && is_unmeasured(r)) continue;
    row_of[r] = static_cast<int>(q.size());
    q.push_back(joints(r));
    lines.push_back(row(r).line);
    if (has("pose"))
      poses.push_back(numbers.try_emplace(name(r, "pose"), numbers.size()).first->second);
  }
  const std::vector<MovedByTurns> moved = move_into_travel(q, poses, chain);
  if (moved.empty()) return "";
  moved_ = std::move(q);
  moved_row_ = std::move(row_of);
  return table_.file + ": " + moved_text(moved, mapping_.joints, lines);
}

Eigen::Vector3d TableReader::position(int r) const {
  return {number(r, "x"), number(r, "y"), number(r, "z")};
}

Eigen::Quaterniond TableReader::orientation(int r) const {
  OrientationNumbers numbers{};
  const std::vector<std::string> quantities = orientation_quantities(mapping_.orientation);
  for (size_t k = 0; k < quantities.size(); ++k) numbers[k] = number(r, quantities[k]);
  const auto rotation = orientation_of(mapping_.orientation, numbers);
  if (!rotation)
    fail(r, quantities.front(),
         std::string(
             mapping_.orientation == "matrix"
                 ? "begins a matrix that is no rotation: its rows are not of length 1 and at "
                   "right angles, or it mirrors"
                 : "begins a quaternion whose length is not 1") +
             "; are these its columns? Correct or remove the row");
  return *rotation;
}

bool TableReader::is_unmeasured(int r) const {
  const auto empty = [&](const std::string& quantity) { return cell(r, quantity).empty(); };
  return empty("x") && empty("y") && empty("z") &&
         std::ranges::all_of(orientation_quantities(mapping_.orientation), empty);
}

double TableReader::Clock::since(int r, const PlainTime& zero) const {
  return is_number ? seconds[r] : seconds_between(times[r], zero);
}

PlainTime TableReader::time(int r) const {
  auto read = plain_time(cell(r, "t"), mapping_.date_order);
  if (!read)
    fail(r, "t",
         "is no time such as 12:33:01.5 or 2024-05-03T12:33:01.5, as in the first row; write all "
         "times in one of these ways, or give seconds");
  if (!has("date")) return *read;
  const auto day = plain_date(cell(r, "date"), mapping_.date_order);
  if (!day)
    fail(r, "date",
         "is no date such as 2024-05-03, 3.5.2024 or 3/5/2024; write all dates in one way");
  if (read->has_date) fail(r, "t", "states a date beside the column of dates; --ignore one");
  read->has_date = true;
  read->day = *day;
  return *read;
}

TableReader::Clock TableReader::clock() const {
  Clock clock;
  clock.is_number = !has("date") && !mapping_.find("t")->unit.empty();
  for (int r = 0; r < rows(); ++r) {
    if (clock.is_number) {
      clock.seconds.push_back(number(r, "t"));
      continue;
    }
    clock.times.push_back(time(r));
    const PlainTime& first = clock.times.front();
    const PlainTime& last = clock.times.back();
    if (first.has_date != last.has_date || first.has_zone != last.has_zone)
      fail(r, "t", "is written in another way than in the first row; write all times in one way");
    if (!last.has_date && r > 0 && last.seconds < clock.times[r - 1].seconds)
      fail(r, "t",
           "is before the time of the row above: past midnight, or not in order; give times with "
           "dates");
  }
  return clock;
}

}  // namespace armtrue
