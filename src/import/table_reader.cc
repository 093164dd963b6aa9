#include "import/table_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "armtrue/campaign/turns.h"
#include "import/orientation_columns.h"

namespace armtrue {

TableReader::TableReader(const PlainTable& table, const ColumnMapping& mapping)
    : table_(table), mapping_(mapping) {
  for (const char* axis : {"x", "y", "z"})
    if (has(axis)) position_.push_back(mapping.find(axis));
  for (const std::string& quantity : orientation_quantities(mapping.orientation))
    orientation_.push_back(mapping.find(quantity));
  for (const JointName& joint : mapping.joints) joints_.push_back(mapping.find(joint.column));
}

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
  const MappedColumn& column = *mapping_.find(quantity);
  if (quantity == "t")
    if (const auto count = plain_count(row(r).cells[column.column])) return column.factor * *count;
  return number(r, column);
}

double TableReader::number(int r, const MappedColumn& column) const {
  const std::string& text = row(r).cells[column.column];
  if (text.empty()) table_.fail(row(r), column.column, "is empty; complete or remove the row");
  const auto read = plain_number(text, mapping_.decimal_sign);
  const char* const sign = mapping_.decimal_sign == ',' ? "comma" : "point";
  if (!read)
    table_.fail(row(r), column.column,
                fmt::format("is no number with a decimal {}; correct it or remove the row", sign));
  if (read->ambiguous && !mapping_.decimal_stated)
    table_.fail(
        row(r), column.column,
        fmt::format("can be read with a thousands separator or with a decimal sign; correct it, "
                    "or say --decimal {} if thousands are separated",
                    sign));
  return column.factor * read->value;
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
  JointVector q(joints_.size());
  for (Eigen::Index j = 0; j < q.size(); ++j) q[j] = number(r, *joints_[j]);
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
  return {number(r, *position_[0]), number(r, *position_[1]), number(r, *position_[2])};
}

Eigen::Quaterniond TableReader::orientation(int r) const {
  OrientationNumbers numbers{};
  for (size_t k = 0; k < orientation_.size(); ++k) numbers[k] = number(r, *orientation_[k]);
  const auto rotation = orientation_of(mapping_.orientation, numbers);
  if (!rotation)
    table_.fail(
        row(r), orientation_.front()->column,
        std::string(
            mapping_.orientation == "matrix"
                ? "begins a matrix that is no rotation: its rows are not of length 1 and at "
                  "right angles, or it mirrors"
                : "begins a quaternion whose length is not 1") +
            "; are these its columns? Correct or remove the row");
  return *rotation;
}

bool TableReader::is_unmeasured(int r) const {
  const auto is_empty = [&](const MappedColumn* column) {
    return row(r).cells[column->column].empty();
  };
  return std::ranges::all_of(position_, is_empty) && std::ranges::all_of(orientation_, is_empty);
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
