#include <fmt/format.h>
#include <fmt/ranges.h>

#include "armtrue/io/output.h"
#include "armtrue/io/source.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/urdf/ur_calibration_io.h"
#include "armtrue/urdf/urdf_io.h"
#include "command_line.h"

using namespace armtrue;

namespace {

// A base or tool that moves farther was hardly identified as part of the arm.
constexpr double kNoticeable = 0.01 * kMillimetre;  // more than angles that are written as 3.1416
constexpr double kNoticeableTurn = 0.01 * kMilliradian;
constexpr double kLargeShift = 10 * kMillimetre, kLargeTurn = 1 * kDegree;

struct Arguments {
  std::string to, into;
  UrdfEnds ends;
  UrdfKept kept;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("A robot: YAML, URDF, or calibration of Universal Robots");
  command.add_output(app::ProductKind::document);
  command
      .option("--to", arguments.to,
              "yaml, which is JSON in a file that ends in .json, json, or urdf")
      .required()
      .check(app::one_of({"yaml", "json", "urdf"}));
  command.option("--base", arguments.ends.base,
                 "Link of the URDF whose frame is R_A; its root if absent");
  command.option("--tip", arguments.ends.tip,
                 "Link of the URDF whose frame is that of the last link, the flange of programs; the "
                 "only end if absent");
  app::Option into =
      command.file("--into", arguments.into,
                   "URDF, or calibration of Universal Robots, of the same arm: write it with the "
                   "robot's geometry; only the origins of its joints change");
  command.flag("--keep-base", arguments.kept.base, "With --into: the base stays as in the URDF")
      .needs(into);
  command.flag("--keep-tool", arguments.kept.tool, "With --into: the tool stays as in the URDF")
      .needs(into);
}

bool is_xml(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");  // behind a BOM, too
  return first != std::string::npos && text[first] == '<';
}

void explain_base(app::Command& command, const std::string& text, const std::string& file,
                  const UrdfEnds& ends) {
  for (const std::string& link : frames_beside_base(text, file, ends))
    command.warn(file + ": R_A is the frame of '" +
                 (ends.base.empty() ? "the root link" : ends.base) + "'; '" + link +
                 "' stands beside it, moved or turned; if the controller's poses are in '" + link +
                 "', give --base " + link);
}

// Programs speak of the flange in R_0, which of a URDF are --tip and --base.
void explain_flange(app::Command& command, const Robot& robot, const std::string& text,
                    const std::string& file, const UrdfEnds& ends) {
  const Eigen::Vector3d foot = foot_beside_base(text, file, ends) / kMillimetre;
  if (foot.norm() > kNoticeable / kMillimetre)
    command.warn(fmt::format(
        "{}: R_0, the foot of programs, stands at {:.4g}, {:.4g}, {:.4g} mm of the frame of --base, "
        "because link 1 alone does not lead from there to axis 1: for poses in the frame of --base "
        "give compensate --base {:.10g},{:.10g},{:.10g},0,0,0",
        file, foot.x(), foot.y(), foot.z(), -foot.x(), -foot.y(), -foot.z()));
  const std::string tool0 = tool0_beside_tip(text, file, ends);
  if (!tool0.empty())
    command.warn(fmt::format(
        "{}: R_{}, the flange of programs, is the frame of '{}'; '{}' stands elsewhere; if it is the "
        "flange of the controller, give --tip {}",
        file, link_count(robot.chain), ends.tip.empty() ? "the end of the arm" : ends.tip, tool0,
        tool0));
}

void warn_of_travel(app::Command& command, const std::string& text, const std::string& file,
                    const UrdfEnds& ends) {
  const std::vector<std::string> links = links_without_travel(text, file, ends);
  if (links.empty()) return;
  command.warn(
      fmt::format("{}: states no travel of {} (limits of 0): add min_deg and max_deg, or poses are "
                  "planned over "
                  "whole turns",
                  file, fmt::join(links, ", ")));
}

void warn_of_shift(app::Command& command, const char* what, const char* where,
                   const FrameShift& shift) {
  if (shift.distance < kLargeShift && shift.angle < kLargeTurn) return;
  command.warn(
      fmt::format("the {} moves by {:.4g} mm and {:.3g} deg; if that is where the {} "
                  "stood, and not the robot's own, give --keep-{}",
                  what, shift.distance / kMillimetre, shift.angle / kDegree, where, what));
}

std::string into_urdf(app::Command& command, const Robot& robot, const Arguments& arguments) {
  Source source(arguments.into);
  const std::string document = source.read_all();
  const PatchedUrdf patched =
      is_ur_calibration(document)
          ? write_into_ur_calibration(robot, document, source.name(), arguments.kept)
          : write_into_urdf(robot, document, source.name(), arguments.ends, arguments.kept);
  warn_of_shift(command, "base", "instrument", patched.base);
  warn_of_shift(command, "tool", "reflector", patched.tool);
  const FrameShift& left = patched.tool_left_out;
  if (left.distance > kNoticeable || left.angle > kNoticeableTurn)
    command.warn(fmt::format(
        "{}: '{}' turns with the last joint, so no origin can hold the tool: {:.4g} mm and {:.3g} deg "
        "of it are not written; if they belong to the robot, add a link that is fixed behind '{}' and "
        "name it by --tip, else give --keep-tool",
        source.name(), left.of_link, left.distance / kMillimetre, left.angle / kDegree,
        left.of_link));
  return patched.text;
}

int run(app::Command& command, const Arguments& arguments) {
  if (arguments.to == "urdf" && is_json_file(command.output))
    throw app::UsageError("-o: '" + command.output +
                          "' ends in .json, and a URDF is XML: end it in .urdf, or give --to json");
  Source source(command.input);
  const std::string text = source.read_all();
  const bool is_urdf = is_xml(text);
  if (!arguments.into.empty() && (is_urdf || arguments.to != "urdf"))
    throw InputError(
        "--into writes a robot file into a URDF: it needs --to urdf, and YAML as input");
  const Robot robot = is_urdf                   ? parse_urdf(text, source.name(), arguments.ends)
                      : is_ur_calibration(text) ? parse_ur_calibration(text, source.name())
                                                : parse_robot(text, source.name());
  if (is_urdf) {
    explain_base(command, text, source.name(), arguments.ends);
    explain_flange(command, robot, text, source.name(), arguments.ends);
    warn_of_travel(command, text, source.name(), arguments.ends);
  }
  if (arguments.to == "json") {
    write_output(command.output, write_robot(robot).json());
    return app::kSuccess;
  }
  if (arguments.to == "yaml") {
    write_output(command.output, write_robot(robot));
    return app::kSuccess;
  }
  if (robot.ground_link)
    throw InputError(source.name() +
                     ": a URDF is written of an arm alone, and this robot has a positioner that "
                     "carries the part; keep it as YAML, which all commands read");
  std::string lost;
  for (const std::string& key : lost_in_urdf(robot)) lost += (lost.empty() ? "" : ", ") + key;
  if (!lost.empty()) command.warn("URDF cannot hold: " + lost);
  write_output(command.output,
               arguments.into.empty() ? write_urdf(robot) : into_urdf(command, robot, arguments));
  return app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("convert-robot", "Convert a robot between its YAML file and URDF.",
                       "convert-robot robot.yaml --to urdf > robot.urdf");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
