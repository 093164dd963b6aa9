#include "armtrue/io/path_io.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "io/compensation_columns.h"
#include "io/csv_cell.h"
#include "io/csv_table.h"
#include "io/joint_columns.h"
#include "io/mistaken_columns.h"

namespace armtrue {
namespace {

// Between the cells of PathFile::rows; no cell holds it, and one may hold a comma.
constexpr char kBetweenCells = '\x1f';

using Quantity = CsvTable::Quantity;
constexpr double kNanometre = 1e-9;
constexpr int kPathDecimals = 8;  // of a corrected mm: a nanometre, and two check digits
constexpr int kRounded = 3;       // decimals of a mm that show it if the others are lost

std::optional<Quantity> find_plain(const CsvTable& table, const std::string& name) {
  if (const auto column = table.find(name)) return Quantity{*column, 1.0};
  return std::nullopt;
}

// The columns of one vector quantity: all of them, or none.
template <size_t N>
std::optional<std::array<Quantity, N>> group(const CsvTable& table,
                                             const std::array<std::optional<Quantity>, N>& found,
                                             const std::array<std::string, N>& names) {
  if (!has_all(table, found, names)) return std::nullopt;
  std::array<Quantity, N> columns;
  for (size_t i = 0; i < N; ++i) columns[i] = *found[i];
  return columns;
}

struct PathColumns {
  std::vector<int> used() const {
    std::vector<int> all{time.column};
    const auto add = [&](const auto& columns) {
      for (const Quantity& column : columns) all.push_back(column.column);
    };
    add(position);
    if (orientation) add(*orientation);
    if (force) add(*force);
    if (q) add(*q);
    return all;
  }

  Quantity time;
  std::array<Quantity, 3> position;
  std::optional<std::array<Quantity, 3>> orientation, force;
  std::optional<std::vector<Quantity>> q;
};

std::vector<std::string> columns_of_a_path(const std::vector<JointName>& joints) {
  std::vector<std::string> known{"t_s",   "x_mm",  "y_mm", "z_mm", "a_deg",
                                 "b_deg", "c_deg", "fx_n", "fy_n", "fz_n"};
  const std::vector<std::string> encoders = encoder_names(joints);
  known.insert(known.end(), encoders.begin(), encoders.end());
  return known;
}

std::array<std::optional<Quantity>, 3> find_position(const CsvTable& table) {
  return {table.find_length("x"), table.find_length("y"), table.find_length("z")};
}

// The columns of the joints: all of them, or none.
std::optional<std::vector<Quantity>> find_joints(const CsvTable& table,
                                                 const std::vector<JointName>& joints) {
  const auto found = find_encoders(table, joints);
  if (!has_all(table, found, encoder_names(joints))) return std::nullopt;
  std::vector<Quantity> columns;
  for (const auto& column : found) columns.push_back(*column);
  return columns;
}

std::optional<std::array<Quantity, 3>> find_force(const CsvTable& table) {
  return group<3>(table,
                  {find_plain(table, "fx_n"), find_plain(table, "fy_n"), find_plain(table, "fz_n")},
                  {"fx_n", "fy_n", "fz_n"});
}

PathColumns find_columns(const CsvTable& table, const std::vector<JointName>& joints) {
  PathColumns columns;
  const auto time = find_plain(table, "t_s");
  const auto position = group<3>(table, find_position(table), {"x_mm", "y_mm", "z_mm"});
  std::vector<std::string> missing;
  if (!time) missing.push_back("t_s");
  if (!position) missing.insert(missing.end(), {"x_mm", "y_mm", "z_mm"});
  if (!missing.empty()) table.fail_missing(missing);
  columns.time = *time;
  columns.position = *position;
  columns.orientation =
      group<3>(table, {table.find_angle("a"), table.find_angle("b"), table.find_angle("c")},
               {"a_deg", "b_deg", "c_deg"});
  columns.force = find_force(table);
  columns.q = find_joints(table, joints);
  return columns;
}

// Collects the numbers of all samples; their count is only known at the end of the file.
class SampleBuffer {
 public:
  void add(const CsvTable& table, std::span<const Quantity> columns) {
    for (const Quantity& column : columns) values_.push_back(table.number(column));
  }
  template <typename Matrix>
  Matrix matrix(Eigen::Index rows) const {
    return Eigen::Map<const Matrix>(values_.data(), rows, std::ssize(values_) / rows);
  }

 private:
  std::vector<double> values_;
};

// Adds the time of the row.
void add_time(const CsvTable& table, const Quantity& column, std::vector<double>& times) {
  const double t = table.seconds(column.column);
  if (!times.empty() && t <= times.back())
    table.fail(column.column,
               table.quoted(column.column) + " is not later than the sample before (" +
                   number_text(times.back()) + "); sort the rows by time and remove doubled ones");
  times.push_back(t);
}

// Throws InputError for a path of fewer than two samples.
void set_times(const std::vector<double>& times, PathFile& file) {
  if (times.size() < 2)
    throw InputError(file.source + ": has " + counted(times.size(), "sample") +
                     "; a path needs at least two");
  file.path.time = Eigen::Map<const Eigen::VectorXd>(times.data(), times.size());
}

bool is_lost(const CsvTable& table, const std::array<Quantity, 3>& position) {
  const auto is_empty = [&](const Quantity& column) { return table.is_empty(column.column); };
  const auto empty = std::ranges::find_if(position, is_empty);
  if (empty == position.end()) return false;
  if (std::ranges::all_of(position, is_empty)) return true;
  table.fail(empty->column,
             "is empty while the others of the position are not; complete the row, or empty all "
             "three for a lost sample");
}

std::optional<Corrector> corrector_of(const PathFile& file) {
  if (std::ranges::find(file.columns, kCommandColumns.front()) != file.columns.end())
    return Corrector::compensate;
  CheckDigits commands(CheckSize::digits, Corrector::compensate),
      mirrored(CheckSize::digits, Corrector::mirror), rounded(CheckSize::half, Corrector::mirror);
  for (const double coordinate : file.path.position.reshaped()) {
    const double mm = coordinate / kMillimetre;
    commands.add(mm, command_decimals(kMillimetre) + kCheckDecimals);
    mirrored.add(mm, kPathDecimals);
    rounded.add_rounded(mm, kRounded);
  }
  if (commands.are_found()) return Corrector::compensate;
  if (mirrored.are_found() || rounded.are_found()) return Corrector::mirror;
  return std::nullopt;
}

}  // namespace

PathFile read_path(const std::string& file, KeepRows keep, const std::vector<JointName>& joints) {
  Source source(file);
  CsvTable table(source, "t_s,x_mm,y_mm,z_mm");
  const PathColumns columns = find_columns(table, joints);
  PathFile result;
  result.source = source.name();
  result.columns = table.columns();
  result.position = columns.position;
  const std::vector<int> used = columns.used();
  for (int c = 0; c < std::ssize(result.columns); ++c)
    if (std::find(used.begin(), used.end(), c) == used.end())
      result.unknown_columns.push_back(result.columns[c]);
  if (keep == KeepRows::no) {  // else they stay in the product
    refuse_mistaken_columns(table, result.unknown_columns, columns_of_a_path(joints),
                            {.orientation = !columns.orientation});
    result.unknown_columns =
        with_likely_columns(table, result.unknown_columns, columns_of_a_path(joints));
  }
  SampleBuffer position, orientation, force, q;
  std::vector<double> time;
  while (table.next_row()) {
    if (is_lost(table, columns.position)) {
      if (keep == KeepRows::yes)
        table.fail(columns.position[0].column, "is empty; a programmed path has no lost samples");
      ++result.lost;
      continue;
    }
    add_time(table, columns.time, time);
    result.line.push_back(table.line_number());
    position.add(table, columns.position);
    if (columns.orientation) orientation.add(table, *columns.orientation);
    if (columns.force) force.add(table, *columns.force);
    if (columns.q) q.add(table, *columns.q);
    if (keep == KeepRows::yes) {
      for (int c = 0; c < std::ssize(result.columns); ++c) {
        const int column = c;
        const std::string_view text = table.text(column);
        if (c) result.rows += kBetweenCells;
        result.rows += read_number(text) ? text : table.original(column);
      }
      result.rows += '\n';
    }
  }
  set_times(time, result);
  result.path.position = position.matrix<Eigen::Matrix3Xd>(3);
  result.path.orientation = orientation.matrix<Eigen::Matrix3Xd>(3);
  result.path.force = force.matrix<Eigen::Matrix3Xd>(3);
  result.path.q = q.matrix<JointMatrix>(joints.size());
  result.sha256 = source.sha256();
  result.corrected_by = corrector_of(result);
  return result;
}

PathFile read_force_record(const std::string& file) {
  Source source(file);
  CsvTable table(source, "t_s,fx_n,fy_n,fz_n");
  const auto time_column = find_plain(table, "t_s");
  const auto columns = find_force(table);
  std::vector<std::string> missing;
  if (!time_column) missing.push_back("t_s");
  if (!columns) missing.insert(missing.end(), {"fx_n", "fy_n", "fz_n"});
  if (!missing.empty()) table.fail_missing(missing);
  PathFile result;
  result.source = source.name();
  SampleBuffer force;
  std::vector<double> times;
  while (table.next_row()) {
    add_time(table, *time_column, times);
    result.line.push_back(table.line_number());
    force.add(table, *columns);
  }
  set_times(times, result);
  result.path.force = force.matrix<Eigen::Matrix3Xd>(3);
  result.sha256 = source.sha256();
  return result;
}

std::string write_path(const Path& path, const std::vector<JointName>& joints) {
  std::string text = "t_s";
  if (path.has_position()) text += ",x_mm,y_mm,z_mm";
  if (path.has_orientation()) text += ",a_deg,b_deg,c_deg";
  if (path.has_joints())
    for (const JointName& joint : joints) text += "," + joint.encoder();
  if (path.has_force()) text += ",fx_n,fy_n,fz_n";
  text += '\n';
  const auto add = [&](const auto& values, double unit, int decimals) {
    for (Eigen::Index k = 0; k < values.size(); ++k)
      text += ',' + decimal_text(values[k] / unit, decimals);
  };
  for (Eigen::Index i = 0; i < path.samples(); ++i) {
    text += decimal_text(path.time[i], 7);
    if (path.has_position()) add(path.position.col(i), kMillimetre, 6);
    if (path.has_orientation()) add(path.orientation.col(i), kDegree, 9);
    for (size_t j = 0; path.has_joints() && j < joints.size(); ++j)
      text += ',' + decimal_text(path.q(j, i) / joints[j].si(), 9);
    if (path.has_force()) add(path.force.col(i), 1, 6);
    text += '\n';
  }
  return text;
}

std::string write_path_like(const PathFile& file, const Eigen::Matrix3Xd& position) {
  std::string text;
  text.reserve(file.rows.size() * 5 / 4);
  for (size_t c = 0; c < file.columns.size(); ++c) text += (c ? "," : "") + csv_cell(file.columns[c]);
  text += '\n';
  size_t begin = 0;
  for (Eigen::Index i = 0; i < position.cols(); ++i) {
    for (int c = 0; c < std::ssize(file.columns); ++c) {
      const size_t end = file.rows.find_first_of(std::string{kBetweenCells, '\n'}, begin);
      const auto moved = [&](int axis) {
        return file.position[axis].column == c &&
               std::abs(position(axis, i) - file.path.position(axis, i)) >= kNanometre / 2;
      };
      const int axis = moved(0) ? 0 : moved(1) ? 1 : moved(2) ? 2 : -1;
      if (axis < 0) {
        text += csv_cell(std::string_view(file.rows).substr(begin, end - begin));
      } else {
        const double unit = file.position[axis].unit;
        const int decimals = unit == kMillimetre ? kPathDecimals : kPathDecimals + 3;
        const double value = checked_if_rounded(position(axis, i) / unit,
                                                unit == kMillimetre ? kRounded : kRounded + 3,
                                                CheckSize::half, Corrector::mirror);
        text += decimal_text(checked(value, decimals, CheckSize::digits, Corrector::mirror),
                             decimals);
      }
      text += c + 1 < std::ssize(file.columns) ? ',' : '\n';
      begin = end + 1;
    }
  }
  return text;
}

}  // namespace armtrue
