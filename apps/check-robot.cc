#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "armtrue/diagnosis/pose_check.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/pose_check_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/report/pose_check_text.h"
#include "command_line.h"
#include "option_text.h"

using namespace armtrue;

namespace armtrue::app {
extern const char* const kRobotTemplate;
extern const char* const kAboutTemplate;
}  // namespace armtrue::app

namespace {

struct Arguments {
  std::string new_file;
  std::vector<double> at, pose;
  double within_mm = 1, within_deg = 0.1;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("A robot file");
  command.add_output(
      "-o,--output", command.output,
      "File for the text, or for a document of it if it ends in .yaml or .json; standard output if "
      "absent or -",
      app::ProductKind::document);
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

std::string text_of(const Robot& robot, const PoseCheck& check, const Arguments& arguments) {
  std::string text = robot.name + ", modified Denavit-Hartenberg parameters\n\n";
  for (const ShownFrame& frame : check.frames) text += frame_text(frame) + "\n";
  return check.pose ? text + agreements_text(check.agreements, link_count(robot.chain),
                                             arguments.within_mm * kMillimetre,
                                             arguments.within_deg * kDegree)
                    : text;
}

int run(app::Command& command, const Arguments& arguments) {
  if (!arguments.new_file.empty()) {
    if (is_json_file(command.output))
      throw app::UsageError(
          "-o: '" + command.output +
          "': a file to fill in has comments, which JSON has not; end it in .yaml");
    if (command.input != "-")
      throw app::UsageError("'" + command.input +
                            "' is not read with --new; write the new file by -o");
    write_output(command.output,
                 arguments.new_file == "robot" ? app::kRobotTemplate : app::kAboutTemplate);
    return app::kSuccess;
  }
  const Robot robot = command.read_robot(command.input).robot;
  const JointVector q = app::joints_of(command, arguments.at, robot, "--at");
  app::warn_of_all(command, joints_beyond_travel(robot.chain, q));
  if (!robot.effects.empty()) command.warn("the effects of the robot file are not counted");
  PoseCheck check{q, shown_frames(robot, q), {}, {}};
  if (!arguments.pose.empty()) {
    std::ranges::copy(arguments.pose, check.pose.emplace().begin());
    check.agreements = find_agreements(robot, q, *check.pose, arguments.within_mm * kMillimetre,
                                       arguments.within_deg * kDegree);
  }
  warn_of_unseen_signs(command, robot, q, arguments);
  if (is_json_file(command.output) || command.output.ends_with(".yaml"))
    write_output(command.output, write_pose_check(robot, check, command.provenance()));
  else
    write_output(command.output, text_of(robot, check, arguments));
  return !check.pose || check.agrees() ? app::kSuccess : app::kNotReached;
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
