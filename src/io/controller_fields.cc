#include "armtrue/io/controller_fields.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/kinematics/conventions.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/edit_distance.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "armtrue/text/text_parts.h"
#include "io/csv_cell.h"

namespace armtrue {
namespace {

using Eigen::Vector3d;

constexpr const char* kMames = "$MAMES[";
constexpr const char* kCounts = "$DMR_GRP[1].$MASTER_COUN";
constexpr int kAxesOfArm = 6;       // of KUKA: external axis E1 has the number 7
constexpr int kDecimals = 6;        // of deg and mm: 0.1 um at the end of an arm of some metres
constexpr double kNoChange = 5e-7;  // smaller changes round to 0

struct NumberedLine {
  std::string text;  // in capitals, without a comment
  int number = 0;
};

std::vector<NumberedLine> lines_of(const std::string& text) {
  std::vector<NumberedLine> lines;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t newline = std::min(text.find('\n', begin), text.size());
    const std::string_view line(text.data() + begin, newline - begin);
    lines.push_back({upper_case(trimmed(line.substr(0, line.find(';')), " \t\r")),
                     static_cast<int>(lines.size()) + 1});
    begin = newline + 1;
  }
  return lines;
}

// An element of an array, from `[i] = n` at a place of a line.
struct Element {
  int index;
  double value;
};

std::optional<Element> element_of(const NumberedLine& line, size_t bracket,
                                  const std::string& file) {
  const size_t close = line.text.find(']', bracket), equals = line.text.find('=', bracket);
  if (close == std::string::npos || equals == std::string::npos || equals < close)
    return std::nullopt;
  const auto index =
      read_number(trimmed(std::string_view(line.text).substr(bracket + 1, close - bracket - 1)));
  const auto value = read_number(trimmed(std::string_view(line.text).substr(equals + 1)));
  if (!index || *index < 1 || *index > 99 || *index != std::floor(*index) || !value ||
      !(std::abs(*value) <= kMaxNumber))
    throw InputError(fmt::format("{}, line {}: '{}' needs the number of an axis and a number", file,
                                 line.number, line.text));
  return Element{static_cast<int>(*index), *value};
}

void take(const Element& element, const NumberedLine& line, Mastering& mastering) {
  if (!mastering.values.emplace(element.index, element.value).second)
    throw InputError(fmt::format("{}, line {}: axis {} has a value before; keep one",
                                 mastering.file, line.number, element.index));
}

std::optional<Mastering> read_kuka(const std::vector<NumberedLine>& lines,
                                   const std::string& file) {
  Mastering mastering{Mastering::Maker::kuka, file, {}};
  for (const NumberedLine& line : lines)
    if (line.text.starts_with(kMames))
      if (const auto element = element_of(line, std::string_view(kMames).size() - 1, file))
        take(*element, line, mastering);
  if (mastering.values.empty()) return std::nullopt;
  return mastering;
}

std::optional<Mastering> read_fanuc(const std::vector<NumberedLine>& lines,
                                    const std::string& file) {
  Mastering mastering{Mastering::Maker::fanuc, file, {}};
  bool inside = false;
  for (const NumberedLine& line : lines) {
    if (line.text.find(kCounts) != std::string::npos) {
      inside = true;
    } else if (inside && line.text.starts_with('[') && !line.text.starts_with("[*")) {
      if (const auto element = element_of(line, 0, file)) take(*element, line, mastering);
    } else {
      inside = false;
    }
  }
  if (mastering.values.empty()) return std::nullopt;
  return mastering;
}

double old_value(const Mastering& mastering, int axis, const char* field) {
  const auto found = mastering.values.find(axis);
  if (found != mastering.values.end()) return found->second;
  throw InputError(fmt::format("{}: has no {}{}], which the robot's axis {} needs", mastering.file,
                               field, axis, axis));
}

// Of "3" and of "E3".
int number_of(const std::string& axis) {
  return read_whole_number(axis.substr(axis.front() == 'E' ? 1 : 0)).value_or(0);
}

// The field of an axis, its value now and the new one; `change` in the unit of the axis.
std::string kuka_cells(const Mastering& mastering, const std::string& axis, double change) {
  const int number = number_of(axis) + (axis.front() == 'E' ? kAxesOfArm : 0);
  const double old = old_value(mastering, number, kMames);
  return fmt::format("$MAMES[{}],", number) + number_text(old) + "," +
         decimal_text(old + change, kDecimals);
}

std::string fanuc_cells(const Mastering& mastering, const std::string& axis, double change,
                        const std::vector<double>& counts_per_degree, size_t joint) {
  if (axis.front() == 'E')
    throw InputError(mastering.file + ": holds external axes in another group, which is not read");
  const double old = old_value(mastering, number_of(axis), "$DMR_GRP[1].$MASTER_COUN[");
  return fmt::format("{}[{}],", kCounts, axis) + number_text(old) + "," +
         decimal_text(std::round(old - counts_per_degree[joint] * change), 0);
}

Pose along_z(double length) { return {Eigen::Matrix3d::Identity(), Vector3d(0, 0, length)}; }

Pose about(const Vector3d& axis, double angle) {
  return {Eigen::AngleAxisd(angle, axis).toRotationMatrix(), Vector3d::Zero()};
}

// KUKA turns an axis of a positioner about z, seen from the ground. The chain comes from the part:
// a joint that rises with its encoder there turns the other way here.
Pose turned_over(const Link& link) {
  return link.sign > 0 ? about(Vector3d::UnitX(), std::numbers::pi) : Pose{};
}

// From the axis to the frame before it, seen from the part.
Pose behind_axis(const Link& link) {
  return inverse(about(Vector3d::UnitY(), link.beta) * about(Vector3d::UnitX(), link.alpha) *
                 Pose{Eigen::Matrix3d::Identity(), Vector3d(link.d, 0, 0)});
}

Pose before_axis(const Link& link) {
  return along_z(-link.r) * about(Vector3d::UnitZ(), -link.theta) * turned_over(link);
}

std::string krl_frame(const Pose& pose) {
  const Vector3d abc = abc_from_rotation(pose.rotation) / kDegree;
  const Vector3d t = pose.translation / kMillimetre;
  const auto number = [](double value) { return decimal_text(value, kDecimals); };
  return "{X " + number(t.x()) + ",Y " + number(t.y()) + ",Z " + number(t.z()) + ",A " +
         number(abc[0]) + ",B " + number(abc[1]) + ",C " + number(abc[2]) + "}";
}

std::string positioner_rows(const Robot& robot) {
  const KinematicChain& chain = robot.chain;
  const size_t ground = *robot.ground_link;
  const auto row = [](const std::string& axis, const std::string& field, const Pose& pose) {
    return axis + "," + field + ",,,," + csv_cell(krl_frame(pose)) + "\n";
  };
  const Link& foot = chain.links[ground];
  const Pose from_foot =
      inverse(inverse(behind_axis(foot)) * about(Vector3d::UnitZ(), foot.theta) * along_z(foot.r));
  const Link& first = chain.links[ground - 1];
  std::string rows = row(first.name, "MACHINE_DEF[].ROOT", from_foot * before_axis(first)) +
                     row(first.name, "$ET1_TA1KR", {});
  size_t number = 1;
  for (size_t j = ground - 1; j > 0; --j, ++number)
    rows += row(chain.links[j - 1].name, fmt::format("$ET1_TA{}A{}", number + 1, number),
                inverse(turned_over(chain.links[j])) * behind_axis(chain.links[j]) *
                    before_axis(chain.links[j - 1]));
  const Link& last = chain.links.front();
  return rows + row(last.name, "$ET1_TFLA3", inverse(turned_over(last)) * behind_axis(last)) +
         row("part", "BASE_DATA[]", inverse(chain.base));
}

}  // namespace

Mastering read_mastering(const std::string& text, const std::string& file) {
  const std::vector<NumberedLine> lines = lines_of(text);
  if (const auto kuka = read_kuka(lines, file)) return *kuka;
  if (const auto fanuc = read_fanuc(lines, file)) return *fanuc;
  throw InputError(
      file +
      ": holds no mastering that is known: lines $MAMES[1]=... of KUKA's $machine.dat, "
      "or $DMR_GRP[1].$MASTER_COUN of FANUC's SYSMAST.VA");
}

std::string write_controller_fields(const Robot& fitted, const KinematicChain& nominal,
                                    const std::optional<Mastering>& mastering,
                                    const std::vector<double>& counts_per_degree) {
  const bool is_fanuc = mastering && mastering->maker == Mastering::Maker::fanuc;
  const std::vector<JointName> joints = joint_names(fitted.chain);
  if (is_fanuc && counts_per_degree.size() != joints.size())
    throw InputError(fmt::format(
        "{}: give --counts-per-deg with {} numbers: how far the count of each encoder rises while "
        "its axis turns by 1 deg, below 0 if it falls",
        mastering->file, joints.size()));
  if (mastering && !fitted.chain.couplings.empty())
    throw InputError(mastering->file +
                     ": joints of the robot follow others, and it is not known how its controller "
                     "counts such motors; without this file the table has the changes alone");
  std::string table = "axis,field,unit,change,old,new\n";
  for (int j = 0; j < std::ssize(joints); ++j) {
    const int joint = j, link = link_of_joint(fitted.chain, joint);
    if (is_of_positioner(fitted, zero_offset(fitted.chain, joint))) continue;
    const Link& own = fitted.chain.links[link];
    const double moved = zero_of(own) - zero_of(nominal.links[link]);
    const double turned = is_prismatic(own) ? moved : std::remainder(moved, kTurn);
    double change = own.sign * turned / joints[j].si();
    if (std::abs(change) < kNoChange) change = 0;
    table += csv_cell(own.name) + ",";
    const std::string cells =
        !mastering ? ",,"
        : is_fanuc ? fanuc_cells(*mastering, joints[j].axis, change, counts_per_degree, j)
                   : kuka_cells(*mastering, joints[j].axis, change);
    const size_t comma = cells.find(',');
    table += cells.substr(0, comma) + "," + joints[j].unit() + "," +
             decimal_text(change, kDecimals) + cells.substr(comma) + "\n";
  }
  if (fitted.ground_link && !is_fanuc) table += positioner_rows(fitted);
  return table;
}

}  // namespace armtrue
