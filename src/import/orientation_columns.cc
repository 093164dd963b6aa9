#include "import/orientation_columns.h"

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/pose.h"

namespace armtrue {
namespace {

constexpr double kUnitNorm = 1e-3;

const std::vector<std::vector<std::string>>& orientation_groups() {
  static const std::vector<std::vector<std::string>> kGroups{
      {"a", "b", "c"},
      {"roll", "pitch", "yaw"},
      {"rx", "ry", "rz"},
      {"qw", "qx", "qy", "qz"},
      {"quat0", "quat1", "quat2", "quat3"},
      {"quat1", "quat2", "quat3", "quat4"},
      {"r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"}};
  return kGroups;
}

std::string their_names(const PlainTable& table, const ColumnMapping& mapping,
                        const std::vector<std::string>& group) {
  std::string names;
  for (const std::string& quantity : group)
    if (const MappedColumn* const column = mapping.find(quantity))
      names += (names.empty() ? "'" : ", '") + table.columns[column->column].name + "'";
  return names;
}

// Whether the angles have armtrue's own names a_deg, b_deg, c_deg (or _rad), whose convention is
// known.
bool is_our_name(const PlainTable& table, const ColumnMapping& mapping) {
  return std::ranges::all_of(std::array{"a", "b", "c"}, [&](const std::string& name) {
    const std::string& header = table.columns[mapping.find(name)->column].name;
    return header == name + "_deg" || header == name + "_rad";
  });
}

// The only group of orientation columns in the table; throws InputError if it is not complete or
// not the only one.
std::vector<std::string> only_group(const PlainTable& table, const ColumnMapping& mapping) {
  std::vector<std::vector<std::string>> found;
  for (const auto& group : orientation_groups()) {
    const bool from_zero = mapping.has("quat0");
    if (group.front() == (from_zero ? "quat1" : "quat0")) continue;
    const auto count = std::ranges::count_if(
        group, [&](const std::string& quantity) { return mapping.has(quantity); });
    if (count == 0) continue;
    if (count < std::ssize(group))
      table.fail_header("an orientation needs all of " + our_column(group.front()) + " to " +
                        our_column(group.back()) + ", and only " +
                        their_names(table, mapping, group) +
                        " stands here; name the others with --column, or leave these out with "
                        "--ignore");
    found.push_back(group);
  }
  if (found.size() > 1)
    table.fail_header("two orientations stand here, " + their_names(table, mapping, found[0]) +
                      " and " + their_names(table, mapping, found[1]) +
                      "; leave one out with --ignore");
  if (mapping.has("quat0") && mapping.has("quat4"))
    table.fail_header("five numbers of a quaternion stand here; leave one out with --ignore");
  return found.empty() ? std::vector<std::string>() : found.front();
}

std::string convention_of_angles(const PlainTable& table, const ColumnMapping& mapping,
                                 const ImportOptions& options,
                                 const std::vector<std::string>& group) {
  const std::string names = their_names(table, mapping, group);
  const std::string& stated = options.angles;
  const std::string first = group.front();
  if (first == "a" && (stated == "abc" || (stated.empty() && is_our_name(table, mapping))))
    return "abc";
  if (first == "roll" && stated == "rpy") return "rpy";
  if (first == "rx" && stated == "rpy") return "rpy-rx";
  if (first == "rx" && stated == "rotvec") return "rotvec";
  if (!stated.empty())
    table.fail_header("--angles " + stated + " does not fit the columns " + names +
                      "; say which column is which angle, such as --column roll=NAME");
  const std::string remedy =
      first == "a"      ? "--angles abc, if R = Rz(A) Ry(B) Rx(C) as KUKA counts"
      : first == "roll" ? "--angles rpy, if R = Rz(yaw) Ry(pitch) Rx(roll)"
                        : "--angles rpy, if R = Rz(rz) Ry(ry) Rx(rx), or --angles rotvec, if they "
                          "are a rotation vector";
  table.fail_header("the convention of the angles " + names + " is not known; give " + remedy +
                    "; or leave them out with --ignore");
}

// The nearest rotation of a matrix whose numbers are rounded.
std::optional<Eigen::Quaterniond> rotation_of(const OrientationNumbers& n) {
  const Eigen::Matrix3d given =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(n.data());
  const Eigen::Matrix3d apart = given * given.transpose() - Eigen::Matrix3d::Identity();
  if (!(apart.cwiseAbs().maxCoeff() <= 2 * kUnitNorm) || given.determinant() < 0)
    return std::nullopt;
  // Newton's steps to the polar factor: R <- (R + R^-T) / 2, whose error of 1e-3 becomes 1e-6,
  // 1e-12.
  Eigen::Matrix3d rotation = given;
  for (int step = 0; step < 3; ++step) {
    Eigen::Matrix3d inverse_transposed;
    for (int k = 0; k < 3; ++k)
      inverse_transposed.row(k) =
          rotation.row((k + 1) % 3).cross(rotation.row((k + 2) % 3)) / rotation.determinant();
    rotation = (rotation + inverse_transposed) / 2;
  }
  return Eigen::Quaterniond(rotation);
}

}  // namespace

std::string find_orientation(const PlainTable& table, const ColumnMapping& mapping,
                             const ImportOptions& options) {
  const std::vector<std::string> group = only_group(table, mapping);
  if (group.empty()) return "";
  if (group.front() == "qw") return "quaternion";
  if (group.front() == "r11") return "matrix";
  if (!group.front().starts_with("quat"))
    return convention_of_angles(table, mapping, options, group);
  if (options.quaternion.empty())
    table.fail_header("the columns " + their_names(table, mapping, group) +
                      " do not tell whether w is first or last; give --quaternion wxyz or "
                      "--quaternion xyzw");
  return group.front() + "-" + options.quaternion;
}

std::vector<std::string> orientation_quantities(const std::string& orientation) {
  const auto& groups = orientation_groups();
  if (orientation == "abc") return groups[0];
  if (orientation == "rpy") return groups[1];
  if (orientation == "rpy-rx" || orientation == "rotvec") return groups[2];
  if (orientation == "quaternion") return groups[3];
  if (orientation.starts_with("quat0")) return groups[4];
  if (orientation.starts_with("quat1")) return groups[5];
  if (orientation == "matrix") return groups[6];
  return {};
}

std::optional<Eigen::Quaterniond> orientation_of(const std::string& orientation,
                                                 const OrientationNumbers& n) {
  if (orientation == "matrix") return rotation_of(n);
  if (orientation == "abc") return Eigen::Quaterniond(rotation_from_abc(n[0], n[1], n[2]));
  if (orientation.starts_with("rpy"))
    return Eigen::Quaterniond(rotation_from_abc(n[2], n[1], n[0]));
  if (orientation == "rotvec")
    return Eigen::Quaterniond(rotation_exp(Eigen::Vector3d(n[0], n[1], n[2])));
  const bool w_last = orientation.ends_with("-xyzw");
  const Eigen::Quaterniond q = w_last ? Eigen::Quaterniond(n[3], n[0], n[1], n[2])
                                      : Eigen::Quaterniond(n[0], n[1], n[2], n[3]);
  if (!(std::abs(q.norm() - 1) <= kUnitNorm)) return std::nullopt;
  return q.normalized();
}

}  // namespace armtrue
