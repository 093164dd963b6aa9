#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "armtrue/text/text_parts.h"
#include "armtrue/urdf/ur_conf_io.h"
#include "urdf/link_frames.h"
#include "urdf/urdf_chain.h"
#include "urdf/urdf_patch.h"

namespace armtrue {
namespace {

using Eigen::Vector3d;

constexpr size_t kAxes = 6;
using OfAxes = std::array<double, kAxes>;

// DH parameters of an arm, or what is added to them [rad, m].
struct DhTable {
  OfAxes theta{}, a{}, d{}, alpha{};
};

struct NamedRow {
  const char* name;
  OfAxes DhTable::*row;
};
constexpr std::array<NamedRow, 4> kRows{
    NamedRow{"delta_theta", &DhTable::theta}, NamedRow{"delta_a", &DhTable::a},
    NamedRow{"delta_d", &DhTable::d}, NamedRow{"delta_alpha", &DhTable::alpha}};

// A calibration moves an axis less; beyond these the robot is another arm.
constexpr double kSameAxis = 50 * kMillimetre, kSameAxisAngle = 5 * kDegree;
// [rad]: axes closer than this count as parallel. Their common normal is not unique: that of the
// type is taken.
constexpr double kParallel = 1e-9;
constexpr double kLastDigits = 1e-14;  // [rad, m]: of the sums that lead to a number

// Where the numbers of a row stand in the document, from behind '[' to ']', and its line.
struct Place {
  size_t begin, end;
  int line;
};

std::string_view without_blanks(std::string_view text) { return trimmed(text, " \t\r"); }

std::optional<Place> find_row(const std::string& text, std::string_view name,
                              const std::string& file) {
  std::optional<Place> found;
  int number = 0;
  for (size_t begin = 0; begin < text.size();) {
    const size_t newline = std::min(text.find('\n', begin), text.size());
    ++number;
    const std::string_view line =
        std::string_view(text).substr(begin, std::min(newline, text.find('#', begin)) - begin);
    const size_t equals = line.find('=');
    if (equals != std::string_view::npos && without_blanks(line.substr(0, equals)) == name) {
      const std::string_view value = without_blanks(line.substr(equals + 1));
      if (!value.starts_with('[') || !value.ends_with(']'))
        throw InputError(
            fmt::format("{}, line {}: '{}' needs six numbers in brackets, as {} = [0, "
                        "0, 0, 0, 0, 0]",
                        file, number, value, name));
      if (found)
        throw InputError(fmt::format("{}, line {}: '{}' stands in line {} too; keep one", file,
                                     number, name, found->line));
      const size_t start = value.data() - text.data();
      found = Place{start + 1, start + value.size() - 1, number};
    }
    begin = newline + 1;
  }
  return found;
}

Place place_of_row(const std::string& text, const char* name, const std::string& file) {
  if (const auto place = find_row(text, name, file)) return *place;
  throw InputError(
      fmt::format("{}: has no line '{} = [...]'; a calibration.conf has delta_theta, "
                  "delta_a, delta_d and delta_alpha",
                  file, name));
}

OfAxes read_row(const std::string& text, const char* name, const std::string& file) {
  const Place place = place_of_row(text, name, file);
  std::string_view rest = std::string_view(text).substr(place.begin, place.end - place.begin);
  OfAxes row{};
  for (size_t k = 0; k < kAxes; ++k) {
    const size_t comma = rest.find(',');
    const std::string_view cell = without_blanks(rest.substr(0, comma));
    const std::optional<double> value = read_number(cell);
    const bool is_last = comma == std::string_view::npos;
    if (!value || !(std::abs(*value) <= kMaxNumber) || is_last != (k + 1 == kAxes))
      throw InputError(fmt::format("{}, line {}: {} needs six numbers, and '{}' is number {}", file,
                                   place.line, name, cell, k + 1));
    row[k] = *value;
    rest.remove_prefix(is_last ? rest.size() : comma + 1);
  }
  return row;
}

// The DH parameters of the type. Its chain is that of modified parameters whose first alpha and d
// are 0.
DhTable dh_of_type(const Robot& nominal, const std::string& about) {
  const KinematicChain& chain = nominal.chain;
  const auto is_plain = [](const Link& link) { return link.beta == 0 && link.sign == 1; };
  if (!is_six_axis_arm(chain) || !std::ranges::all_of(chain.links, is_plain) ||
      chain.links[0].alpha != 0 || chain.links[0].d != 0 || chain.links[kAxes].theta != 0 ||
      chain.links[kAxes].r != 0)
    throw InputError(about +
                     ": is not the type of an arm of Universal Robots by its DH parameters; give "
                     "the shipped robot file of the type, such as ur5e.yaml, as --nominal");
  DhTable dh;
  for (size_t j = 0; j < kAxes; ++j) {
    dh.theta[j] = chain.links[j].theta;
    dh.d[j] = chain.links[j].r;
    dh.a[j] = chain.links[j + 1].d;
    dh.alpha[j] = chain.links[j + 1].alpha;
  }
  return dh;
}

KinematicChain chain_of(const KinematicChain& type, const DhTable& dh) {
  KinematicChain chain = type;
  chain.base = chain.tool = {};
  for (size_t j = 0; j < kAxes; ++j) {
    chain.links[j].theta = dh.theta[j];
    chain.links[j].r = dh.d[j];
    chain.links[j + 1].d = dh.a[j];
    chain.links[j + 1].alpha = dh.alpha[j];
  }
  return chain;
}

Pose rotated_about_z(double angle) {
  return {Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix(), Vector3d::Zero()};
}

// One row of the table: from the frame on an axis to the next axis, which is z of `next` there.
struct DhLink {
  double theta, d, a, alpha;
};

DhLink dh_towards(const Pose& next, const DhLink& type) {
  const Vector3d z = Vector3d::UnitZ(), along = next.rotation.col(2), to = next.translation;
  Vector3d normal = z.cross(along);
  DhLink link = type;
  if (normal.norm() < kParallel) {
    normal = Vector3d(to.x(), to.y(), 0);
    if (normal.norm() == 0) normal = Vector3d(std::cos(type.theta), std::sin(type.theta), 0);
  } else {
    // On this axis the foot of the common normal: d z + a n = to + s along.
    const double share = along.dot(z);
    link.d = (to.dot(z) - share * to.dot(along)) / normal.squaredNorm();
  }
  normal.normalize();
  // Of the two directions of a normal that with the twist of the type, or with its theta.
  const double twist = z.cross(along).dot(normal) * std::sin(type.alpha);
  const double side = normal.dot(Vector3d(std::cos(type.theta), std::sin(type.theta), 0));
  if (std::abs(std::sin(type.alpha)) > std::sin(kSameAxisAngle) ? twist < 0 : side < 0)
    normal = -normal;
  link.theta = std::atan2(normal.y(), normal.x());
  link.a = to.dot(normal);
  link.alpha = std::atan2(z.cross(along).dot(normal), z.dot(along));
  return link;
}

// A DH table, and the frames of an arm that it cannot hold.
struct DhArm {
  DhTable dh;
  Pose foot;  // R_0 from the frame of the table on axis 1
  Pose tip;   // the table's last frame, on axis 6, from the tip
};

DhArm dh_of(const KinematicChain& chain, const DhTable& type) {
  std::vector<Pose> axes;
  Pose frame;
  for (const Link& link : chain.links) {
    frame = frame * link_transform(link);
    if (is_driven(link)) axes.push_back(frame);
  }
  DhArm arm;
  // x of R_0, seen along axis 1, stays where it is: so does the zero of joint 1.
  const Vector3d z = axes[0].rotation.col(2), from = axes[0].translation;
  arm.foot.rotation.col(2) = z;
  arm.foot.rotation.col(1) = z.cross(Vector3d::UnitX()).normalized();
  arm.foot.rotation.col(0) = arm.foot.rotation.col(1).cross(z);
  arm.foot.translation = from - z * from.dot(z);
  Pose here = arm.foot;
  for (size_t j = 0; j + 1 < kAxes; ++j) {
    const DhLink link = dh_towards(inverse(here) * axes[j + 1],
                                   {type.theta[j], type.d[j], type.a[j], type.alpha[j]});
    arm.dh.theta[j] = link.theta;
    arm.dh.d[j] = link.d;
    arm.dh.a[j] = link.a;
    arm.dh.alpha[j] = link.alpha;
    here = here * rotated_about_z(link.theta) *
           Pose{Eigen::AngleAxisd(link.alpha, Vector3d::UnitX()).toRotationMatrix(),
                Vector3d(link.a, 0, link.d)};
  }
  const Pose end = inverse(here) * frame;
  const size_t last = kAxes - 1;
  arm.dh.theta[last] = std::atan2(end.rotation(1, 0), end.rotation(0, 0));
  arm.dh.d[last] = end.translation.z();
  arm.tip = inverse(rotated_about_z(arm.dh.theta[last])) *
            Pose{Eigen::Matrix3d::Identity(), Vector3d(0, 0, -arm.dh.d[last])} * end;
  return arm;
}

FrameShift shift_of(const Pose& pose) {
  return {pose.translation.norm(), Eigen::AngleAxisd(pose.rotation).angle(), {}};
}

// Throws InputError unless the axes of both arms coincide in R_0 within kSameAxis.
void require_arm_of_type(const Robot& robot, const Robot& nominal, const std::string& about) {
  const auto fail = [&](const std::string& why) {
    throw InputError(
        fmt::format("the robot '{}' is no arm of the type of {}: {}; give the robot file "
                    "of its type as --nominal",
                    robot.name, about, why));
  };
  if (!is_six_axis_arm(robot.chain)) fail("it has not six axes");
  Pose own, expected;
  for (size_t j = 0; j < kAxes; ++j) {
    const Link &link = robot.chain.links[j], &other = nominal.chain.links[j];
    if (link.sign != other.sign) fail(link.name + " counts the other way");
    own = own * link_transform(link);
    expected = expected * link_transform(other);
    const Vector3d z = expected.rotation.col(2), between = own.translation - expected.translation;
    const double distance = (between - z * z.dot(between)).norm();
    const double angle =
        std::atan2(z.cross(own.rotation.col(2)).norm(), z.dot(own.rotation.col(2)));
    if (distance > kSameAxis || angle > kSameAxisAngle)
      fail(fmt::format("axis {} lies {:.4g} mm and {:.3g} deg beside", j + 1,
                       distance / kMillimetre, angle / kDegree));
  }
}

double within_half_turn(double angle) { return std::remainder(angle, kTurn); }

}  // namespace

bool is_ur_conf(const std::string& text) {
  const size_t at = text.find("delta_theta");
  if (at == std::string::npos || text.find("delta_alpha") == std::string::npos) return false;
  const size_t line = text.rfind('\n', at);
  const size_t begin = line == std::string::npos ? 0 : line + 1;
  return without_blanks(std::string_view(text).substr(begin, at - begin)).empty();
}

Robot parse_ur_conf(const std::string& text, const std::string& file, const Robot& nominal,
                    const std::string& about) {
  DhTable dh = dh_of_type(nominal, about);
  for (const NamedRow& row : kRows) {
    const OfAxes added = read_row(text, row.name, file);
    for (size_t j = 0; j < kAxes; ++j) (dh.*row.row)[j] += added[j];
  }
  Robot robot = nominal;
  robot.chain = chain_of(nominal.chain, dh);
  robot.chain = with_frames_of_axes(robot).chain;
  for (size_t j = 0; j < robot.chain.links.size(); ++j) {
    robot.chain.links[j].name = nominal.chain.links[j].name;
    robot.chain.links[j].min = nominal.chain.links[j].min;
    robot.chain.links[j].max = nominal.chain.links[j].max;
  }
  robot.name = nominal.name + ", calibrated by its maker";
  require_arm_of_type(robot, nominal, about);
  return robot;
}

PatchedUrdf write_into_ur_conf(const Robot& robot, const std::string& document,
                               const std::string& file, const Robot& nominal,
                               const std::string& about) {
  const DhTable type = dh_of_type(nominal, about);
  require_arm_of_type(robot, nominal, about);
  const DhArm arm = dh_of(robot.chain, type);
  PatchedUrdf result;
  result.base = shift_of(arm.foot);
  result.tool_left_out = shift_of(arm.tip);
  std::vector<Replacement> rows;
  for (const NamedRow& row : kRows) {
    const Place place = place_of_row(document, row.name, file);
    const bool turns = row.row == &DhTable::theta || row.row == &DhTable::alpha;
    std::string text;
    for (size_t j = 0; j < kAxes; ++j) {
      const double added = (arm.dh.*row.row)[j] - (type.*row.row)[j];
      const double written = turns ? within_half_turn(added) : added;
      text += (j == 0 ? " " : ", ") + number_text(std::abs(written) < kLastDigits ? 0 : written);
    }
    rows.push_back({place.begin, place.end, text});
  }
  result.text = replaced(document, std::move(rows));
  Robot wanted = robot, written = nominal;
  wanted.chain.base = inverse(arm.foot);
  wanted.chain.tool = inverse(arm.tip);
  DhTable read = type;
  for (const NamedRow& row : kRows) {
    const OfAxes added = read_row(result.text, row.name, file);
    for (size_t j = 0; j < kAxes; ++j) (read.*row.row)[j] += added[j];
  }
  written.chain = chain_of(nominal.chain, read);
  require_same_arm(wanted, written, file);
  return result;
}

}  // namespace armtrue
