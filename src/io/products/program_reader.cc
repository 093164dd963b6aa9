#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "armtrue/io/products/compensation_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/check_digits.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "io/compensation_columns.h"
#include "io/context_columns.h"
#include "io/csv_table.h"
#include "io/joint_columns.h"

namespace armtrue {
namespace {

using Quantity = CsvTable::Quantity;

// Reads the rows of one program.
class ProgramReader {
 public:
  ProgramReader(CsvTable& table, ProgramFile& file) : table_(table), file_(file) {
    refuse_product();
    file.columns = table.columns();
    file.separator = table.separator();
    find_targets();
    context_.emplace(table, file.joints);
    file.program.visits.temperature_names = context_->temperature_names();
  }

  void read() {
    while (table_.next_row()) read_row();
    if (file_.program.rows() == 0) throw InputError(file_.source + ": has no row");
    refuse_corrections();
  }

 private:
  void refuse_product() const {
    for (const std::string& column : table_.columns())
      if (std::ranges::find(kCommandColumns, column) != std::end(kCommandColumns))
        throw InputError(file_.source + ": has the column '" + column +
                         "', which compensate writes; its targets are corrected already, and would "
                         "be corrected twice: give the original targets, or rename the column if "
                         "it is another");
  }

  // Refuses measured poses: the poses in them are what an instrument read, and where.
  void refuse_measured_poses(const std::string& joints) const {
    if (!is_cartesian_ || !has_joints_) return;
    for (const char* column : {"repeat", "session", "target", "sigma_mm", "sigma_deg"})
      if (table_.find(column))
        throw InputError(fmt::format(
            "{}: has the column '{}', so it holds measured poses, whose x_mm to c_deg are what the "
            "instrument read, and no targets: give the columns pose and {} alone, each pose once, "
            "or "
            "rename the column if these are targets",
            file_.source, column, joints));
  }

  // Refuses points, such as a tracker reads: neither the arm nor its tool is determined by them.
  void refuse_points(std::span<const std::optional<Quantity>> pose,
                     std::span<const std::optional<Quantity>> q) const {
    const auto is_found = [](const std::optional<Quantity>& column) { return column.has_value(); };
    if (!std::ranges::all_of(pose.first(3), is_found) ||
        !std::ranges::none_of(pose.last(3), is_found))
      return;
    const std::vector<std::string> names = encoder_names(file_.joints);
    throw InputError(
        fmt::format("{}: has points without an orientation, which are no targets; ", file_.source) +
        (std::ranges::all_of(q, is_found)
             ? fmt::format(
                   "if the instrument measured them, leave x_mm, y_mm and z_mm out, and the "
                   "joint values {} to {} are the targets",
                   names.front(), names.back())
             : fmt::format("add a_deg, b_deg and c_deg, or give joint values, {} to {}",
                           names.front(), names.back())));
  }

  // Refuses corrected numbers by their check digits: a product of compensate may have got other
  // column names, or its columns may be in another file.
  void refuse_corrections() const {
    struct Written {
      double unit;  // of what compensate wrote, in SI
      int decimals;
      const char* as;  // if the file has another unit
      CheckDigits digits{CheckSize::digits, Corrector::compensate};
    };
    constexpr double kInch = 25.4 * kMillimetre;
    const int mm = command_decimals(kMillimetre) + kCheckDecimals,
              deg = command_decimals(kDegree) + kCheckDecimals,
              rad = command_decimals(1) + kCheckDecimals;
    // Lengths in m have the same digits. The last ones: a column whose name tells another unit.
    std::vector<Written> lengths{{kMillimetre, mm, ""},
                                 {kMillimetre * kMillimetre, mm, ", taken as m"},
                                 {kMillimetre / kInch * kMillimetre, mm, ", taken as inches"}},
        angles{{kDegree, deg, ""},
               {1, rad, ", taken in rad"},
               {kDegree * kDegree, deg, ", taken as radians"},
               {kDegree, rad, ", taken as radians"},
               {1, deg, ", taken as degrees"}};
    const auto add = [&](double si, bool is_length) {
      for (Written& written : is_length ? lengths : angles)
        written.digits.add(si / written.unit, written.decimals);
    };
    for (const JointVector& q : file_.program.visits.q)
      for (size_t j = 0; has_joints_ && j < file_.q.size(); ++j)
        add(q[j], file_.joints[j].is_length);
    for (const std::array<double, 6>& pose : poses_)
      for (size_t i = 0; i < pose.size(); ++i) add(pose[i], i < 3);
    for (const std::vector<Written>* all : {&lengths, &angles})
      for (const Written& written : *all)
        if (written.digits.are_found())
          throw InputError(fmt::format(
              "{}: the last digits of its targets{} are those that compensate writes: they are "
              "corrected already; corrected twice, they would be wrong: give the original ones",
              file_.source, written.as));
  }

  void find_targets() {
    const std::vector<std::optional<Quantity>> q = find_encoders(table_, file_.joints);
    const std::vector<std::string> q_names = encoder_names(file_.joints);
    const std::array<std::optional<Quantity>, 6> pose{
        table_.find_length("x"), table_.find_length("y"), table_.find_length("z"),
        table_.find_angle("a"),  table_.find_angle("b"),  table_.find_angle("c")};
    refuse_points(pose, q);
    is_cartesian_ = has_all(table_, pose, kPoseColumns);
    has_joints_ = has_all(table_, q, q_names);
    std::vector<std::string> missing;
    if (!table_.find("pose")) missing.emplace_back("pose");
    if (!is_cartesian_ && !has_joints_)
      missing.insert(missing.end(), q_names.begin(), q_names.end());
    if (!missing.empty()) table_.fail_missing(missing);
    refuse_measured_poses(fmt::format("{} to {}", q_names.front(), q_names.back()));
    name_ = *table_.find("pose");
    for (size_t i = 0; is_cartesian_ && i < pose.size(); ++i) file_.pose[i] = *pose[i];
    file_.q.resize(file_.joints.size());
    for (size_t j = 0; has_joints_ && j < q.size(); ++j) file_.q[j] = *q[j];
    const auto turn = table_.find("t");
    if (turn && file_.joints.size() != kProgramAxes)
      table_.fail(*turn, "the turn t is that of six axes, and the robot has " +
                             std::to_string(file_.joints.size()) +
                             "; leave it out, or rename the column if it is another");
    if (turn) file_.turn.column = *turn;
  }

  void read_row() {
    std::vector<std::string>& cells = file_.cells.emplace_back();
    for (int c = 0; c < std::ssize(file_.columns); ++c) {
      cells.emplace_back(table_.original(c));
      // A number with a comma: so are those that are added.
      file_.has_decimal_commas |=
          table_.text(c) != table_.original(c) && read_number(table_.text(c)).has_value();
    }
    Campaign& visits = file_.program.visits;
    if (table_.is_empty(name_)) table_.fail(name_, "is empty; every row needs the id of its pose");
    visits.pose.push_back(visits.rows());
    visits.pose_ids.emplace_back(table_.original(name_));
    visits.line.push_back(table_.line_number());
    read_target();
    context_->read(table_, visits);
  }

  void read_target() {
    Program& program = file_.program;
    const auto joints = std::ssize(file_.joints);
    JointVector q = JointVector::Zero(joints);
    int empty = 0;
    if (has_joints_)
      for (const Quantity& column : file_.q) empty += table_.is_empty(column.column);
    const bool hinted = has_joints_ && !(is_cartesian_ && empty == joints);
    for (int j = 0; hinted && j < joints; ++j) q[j] = table_.number(file_.q[j]);
    program.visits.q.push_back(q);
    if (is_cartesian_) {
      std::array<double, 6> value{};
      for (size_t i = 0; i < value.size(); ++i) value[i] = table_.number(file_.pose[i]);
      program.poses.push_back({rotation_from_abc(value[3], value[4], value[5]),
                               Eigen::Vector3d(value[0], value[1], value[2])});
      program.hinted.push_back(hinted);
      program.motions.push_back({MotionKind::line});
      poses_.push_back(value);
    }
    if (file_.turn.column < 0) return;
    const int turn = table_.integer(file_.turn.column);
    if (turn < 0 || turn > 0xffff)
      table_.fail(file_.turn.column,
                  table_.quoted(file_.turn.column) + " is no turn, a whole number from 0 to 65535");
    program.turns.push_back(turn);
  }

  CsvTable& table_;
  ProgramFile& file_;
  std::optional<ContextColumns> context_;
  std::vector<std::array<double, 6>> poses_;  // of Cartesian targets [m, rad]
  bool is_cartesian_ = false, has_joints_ = false;
  int name_ = 0;
};

}  // namespace

ProgramFile read_program(const std::string& path, const KinematicChain& chain) {
  ProgramFile file = read_program(path, joint_names(chain));
  if (file.program.is_cartesian()) return file;
  JointRows& q = file.program.visits.q;
  const JointRows given = q;
  file.moved_by_turns = move_into_travel(q, {}, chain);
  for (const MovedByTurns& moved : file.moved_by_turns) {
    const QuantityColumn& column = file.q[moved.joint];
    for (size_t row = 0; row < q.size(); ++row) {
      if (q[row][moved.joint] == given[row][moved.joint]) continue;
      std::string& cell = file.cells[row][column.column];
      cell = decimal_text(q[row][moved.joint] / column.unit, command_decimals(column.unit));
      if (file.has_decimal_commas) std::ranges::replace(cell, '.', ',');
    }
  }
  return file;
}

ProgramFile read_program(const std::string& path, const std::vector<JointName>& joints) {
  Source source(path);
  ProgramFile file;
  file.joints = joints;
  file.source = file.program.visits.source = source.name();
  CsvTable table(source, example_header("pose,", joints));
  ProgramReader(table, file).read();
  file.sha256 = source.sha256();
  return file;
}

}  // namespace armtrue
