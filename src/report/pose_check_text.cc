#include "armtrue/report/pose_check_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <cmath>

#include "armtrue/kinematics/conventions.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr size_t kMostAgreements = 5;  // that are shown

// R = Rx(x) Ry(y) Rz(z). At y = +-90 deg R depends on x + z or x - z alone: z is 0.
Eigen::Vector3d xyz_from_rotation(const Eigen::Matrix3d& r) {
  const double cosine = std::hypot(r(0, 0), r(0, 1)), y = std::atan2(r(0, 2), cosine);
  if (cosine < 1e-9) return {std::atan2(r(2, 1), r(1, 1)), y, 0};
  return {std::atan2(-r(1, 2), r(2, 2)), y, std::atan2(-r(0, 1), r(0, 0))};
}

// R = Rz(a) Ry(b) Rz(c) with b from 0 to pi. At b = 0 or pi R depends on a + c or a - c alone: c is
// 0.
Eigen::Vector3d zyz_from_rotation(const Eigen::Matrix3d& r) {
  const double sine = std::hypot(r(0, 2), r(1, 2)), b = std::atan2(sine, r(2, 2));
  if (sine < 1e-9) return {std::atan2(-r(0, 1), r(1, 1)), b, 0};
  return {std::atan2(r(1, 2), r(0, 2)), b, std::atan2(r(2, 1), -r(2, 0))};
}

// A zero has no sign.
std::string numbers_text(const Eigen::Ref<const Eigen::VectorXd>& values, int decimals) {
  std::vector<std::string> texts;
  for (const double value : values) {
    std::string& text = texts.emplace_back(fmt::format("{:.{}f}", value, decimals));
    if (text[0] == '-' && text.find_first_of("123456789") == std::string::npos) text.erase(0, 1);
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace

std::string frame_text(const ShownFrame& frame) {
  const Eigen::Vector3d t = frame.pose.translation / kMillimetre;
  const Eigen::Vector3d abc = abc_from_rotation(frame.pose.rotation) / kDegree;
  const Eigen::Vector3d xyz = xyz_from_rotation(frame.pose.rotation) / kDegree;
  const Eigen::Vector3d zyz = zyz_from_rotation(frame.pose.rotation) / kDegree;
  const Eigen::Vector3d vector = rotation_log(frame.pose.rotation);
  const Eigen::Quaterniond q(frame.pose.rotation);
  return fmt::format(
      "{}: {}: {}\n"
      "  x, y, z [mm]                    {}\n"
      "  A, B, C [deg] (KUKA)            {}\n"
      "  W, P, R [deg] (FANUC; r, p, y)  {}\n"
      "  RX, RY, RZ [deg] (Staubli)      {}\n"
      "  A, B, C [deg] (Doosan)          {}\n"
      "  q1 to q4 (ABB)                  {}\n"
      "  RX, RY, RZ [rad] (UR)           {}\n",
      frame.name, frame.what, frame.words, numbers_text(t, 3), numbers_text(abc, 4),
      numbers_text(abc.reverse(), 4), numbers_text(xyz, 4), numbers_text(zyz, 4),
      numbers_text(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()), 6), numbers_text(vector, 5));
}

std::string agreements_text(const std::vector<Agreement>& agreements, int links, double within,
                            double within_angle) {
  if (agreements.empty())
    return fmt::format(
        "The pose agrees with no frame within {:g} mm and {:g} deg, and no one or two changes of "
        "convention, sign, zero or unit make it agree. Compare the lengths with the data sheet.\n",
        within / kMillimetre, within_angle / kDegree);
  std::string text;
  for (const Agreement& a : agreements) {
    if (a.changes.empty())
      text += "The pose agrees: ";
    else
      text += fmt::format("The pose agrees if {}: ", fmt::join(a.changes, ", and "));
    text += fmt::format("it is {} ({:.3f} mm, {:.4f} deg apart).\n", a.frame,
                        a.distance / kMillimetre, a.angle / kDegree);
    if (&a - agreements.data() + 1 == kMostAgreements) break;
  }
  if (agreements.front().changes.empty() && !agreements.front().is_flange)
    text += fmt::format(
        "This is with `tool` of the robot file, and compensate takes R_{} as the flange. If the "
        "pendant showed its flange, tool 0, the flange stands in `tool`: convert the URDF again, "
        "so "
        "that the last link ends at the flange (convert-robot(1)), or see the flange in "
        "compensate(1).\n",
        links);
  if (!agreements.front().changes.empty())
    text += "One pose cannot distinguish all of these: check another, with all joints bent.\n";
  return text;
}

}  // namespace armtrue
