#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "armtrue/diagnosis/pose_check.h"
#include "armtrue/io/output.h"
#include "armtrue/kinematics/units.h"
#include "command_line.h"
#include "option_text.h"

using namespace armtrue;

namespace armtrue::app {
extern const char* const kRobotTemplate;
extern const char* const kAboutTemplate;
}  // namespace armtrue::app

namespace {

constexpr size_t kMostAgreements = 5;  // that are shown

struct Arguments {
  std::string new_file;
  std::vector<double> at, pose;
  double within_mm = 1, within_deg = 0.1;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("A robot file");
  command.add_output();
  app::OptionGroup what = command.group("What to show");
  const app::Option at = what.joints(
      "--at", arguments.at,
      "Joint values q1,...,q6, one for each joint of the robot, as the pendant shows them: "
      "angles in deg, lengths in mm");
  what.option("--new", arguments.new_file,
              "robot or about: a file to fill in, of a robot, or of who measured what (--about of "
              "certify and of pages); no robot file is read")
      .check(app::one_of({"robot", "about"}));
  what.require_one();
  const app::Option pose = command.numbers(
      "--pose", arguments.pose, 6, "x,y,z,a,b,c in mm and deg",
      "The pose that the pendant shows there, best of the flange (tool 0) in the robot's own base: "
      "it is compared with R_7 in R_0, then with R_7 tool in R_0 and in R_A; x,y,z,a,b,c in mm and "
      "deg, KUKA's A, B, C");
  pose.needs(at);
  command.option("--within-mm", arguments.within_mm, "What counts as the same place")
      .check(app::above_zero())
      .default_shown()
      .needs(pose);
  command.option("--within-deg", arguments.within_deg, "What counts as the same orientation")
      .check(app::above_zero())
      .default_shown()
      .needs(pose);
}

// R = Rx(x) Ry(y) Rz(z); where only x + z or x - z counts, z is 0.
Eigen::Vector3d xyz_from_rotation(const Eigen::Matrix3d& r) {
  const double cosine = std::hypot(r(0, 0), r(0, 1)), y = std::atan2(r(0, 2), cosine);
  if (cosine < 1e-9) return {std::atan2(r(2, 1), r(1, 1)), y, 0};
  return {std::atan2(-r(1, 2), r(2, 2)), y, std::atan2(-r(0, 1), r(0, 0))};
}

// R = Rz(a) Ry(b) Rz(c) with b from 0 to pi; where only a + c or a - c counts, c is 0.
Eigen::Vector3d zyz_from_rotation(const Eigen::Matrix3d& r) {
  const double sine = std::hypot(r(0, 2), r(1, 2)), b = std::atan2(sine, r(2, 2));
  if (sine < 1e-9) return {std::atan2(-r(0, 1), r(1, 1)), b, 0};
  return {std::atan2(r(1, 2), r(0, 2)), b, std::atan2(r(2, 1), -r(2, 0))};
}

std::string frame_text(const ShownFrame& frame) {
  const Eigen::Vector3d t = frame.pose.translation / kMillimetre;
  const Eigen::Vector3d abc = abc_from_rotation(frame.pose.rotation) / kDegree;
  const Eigen::Vector3d xyz = xyz_from_rotation(frame.pose.rotation) / kDegree;
  const Eigen::Vector3d zyz = zyz_from_rotation(frame.pose.rotation) / kDegree;
  const Eigen::Vector3d vector = rotation_log(frame.pose.rotation);
  const Eigen::Quaterniond q(frame.pose.rotation);
  return fmt::format(
      "{}: {}: {}\n  x, y, z [mm]                    {:.3f}, {:.3f}, {:.3f}\n"
      "  A, B, C [deg] (KUKA)            {:.4f}, {:.4f}, {:.4f}\n"
      "  W, P, R [deg] (FANUC; r, p, y)  {:.4f}, {:.4f}, {:.4f}\n"
      "  RX, RY, RZ [deg] (Staubli)      {:.4f}, {:.4f}, {:.4f}\n"
      "  A, B, C [deg] (Doosan)          {:.4f}, {:.4f}, {:.4f}\n"
      "  q1 to q4 (ABB)                  {:.6f}, {:.6f}, {:.6f}, {:.6f}\n"
      "  RX, RY, RZ [rad] (UR)           {:.5f}, {:.5f}, {:.5f}\n",
      frame.name, frame.what, frame.words, t.x(), t.y(), t.z(), abc[0], abc[1], abc[2], abc[2], abc[1], abc[0],
      xyz[0], xyz[1], xyz[2], zyz[0], zyz[1], zyz[2], q.w(), q.x(), q.y(), q.z(), vector.x(),
      vector.y(), vector.z());
}

// `links`: number of the last frame.
std::string agreements_text(const std::vector<Agreement>& agreements, int links,
                            const Arguments& arguments) {
  if (agreements.empty())
    return fmt::format(
        "The pose agrees with no frame within {:g} mm and {:g} deg, and no one or two changes of "
        "convention, sign, zero or unit make it agree. Compare the lengths with the data sheet.\n",
        arguments.within_mm, arguments.within_deg);
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
        "pendant showed its flange, tool 0, the flange stands in `tool`: convert the URDF again, so "
        "that the last link ends at the flange (convert-robot(1)), or see the flange in "
        "compensate(1).\n",
        links);
  if (!agreements.front().changes.empty())
    text += "One pose cannot distinguish all of these: check another, with all joints bent.\n";
  return text;
}

void warn_of_travel(app::Command& command, const Robot& robot, const JointVector& q) {
  int joint = 0;
  for (const JointName& name : joint_names(robot.chain)) {
    const Link& link = joint_link(robot.chain, joint);
    const double value = q[joint++];
    if (value < link.min || value > link.max)
      command.warn(fmt::format("{0} stands at {1:g} {4}, beyond its travel of {2:g} to {3:g} {4}",
                               link.name, value / name.si(), link.min / name.si(),
                               link.max / name.si(), name.unit()));
  }
}

// A joint at 0 agrees whichever way it counts.
void warn_of_unseen_signs(app::Command& command, const Robot& robot, const JointVector& q,
                          const Arguments& arguments) {
  if (arguments.pose.empty()) return;
  PendantPose pose;
  std::ranges::copy(arguments.pose, pose.begin());
  const std::vector<std::string> unseen = find_unseen_signs(
      robot, q, pose, arguments.within_mm * kMillimetre, arguments.within_deg * kDegree);
  if (unseen.empty()) return;
  command.warn(fmt::format(
      "this posture does not show the sign of {}: compare another, with all joints bent",
      fmt::join(unseen, ", ")));
}

int run(app::Command& command, const Arguments& arguments) {
  if (!arguments.new_file.empty()) {
    if (command.input != "-")
      throw app::UsageError("'" + command.input +
                            "' is not read with --new; write the new file by -o");
    write_output(command.output,
                 arguments.new_file == "robot" ? app::kRobotTemplate : app::kAboutTemplate);
    return app::kSuccess;
  }
  const Robot robot = command.read_robot(command.input).robot;
  const JointVector q = app::joints_of(arguments.at, robot, "--at");
  warn_of_travel(command, robot, q);
  if (!robot.effects.empty()) command.warn("the effects of the robot file are not counted");
  std::string text = robot.name + ", modified Denavit-Hartenberg parameters\n\n";
  for (const ShownFrame& frame : shown_frames(robot, q)) text += frame_text(frame) + "\n";
  std::vector<Agreement> agreements;
  if (!arguments.pose.empty()) {
    PendantPose pose;
    std::ranges::copy(arguments.pose, pose.begin());
    agreements = find_agreements(robot, q, pose, arguments.within_mm * kMillimetre,
                                 arguments.within_deg * kDegree);
    text += agreements_text(agreements, link_count(robot.chain), arguments);
  }
  warn_of_unseen_signs(command, robot, q, arguments);
  write_output(command.output, text);
  const bool agrees = !agreements.empty() && agreements.front().changes.empty();
  return arguments.pose.empty() || agrees ? app::kSuccess : app::kNotReached;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("check-robot", "Show where a robot stands, in the words of a pendant.",
                       "check-robot robot.yaml --at 0,-90,90,0,0,0 --pose 1315,0,1765,0,90,0\n"
                       "  check-robot --new robot -o robot.yaml");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
