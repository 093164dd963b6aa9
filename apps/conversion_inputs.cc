#include "conversion_inputs.h"

#include "armtrue/io/robot_io.h"
#include "armtrue/text/input_error.h"
#include "armtrue/urdf/ur_calibration_io.h"
#include "armtrue/urdf/ur_conf_io.h"

namespace armtrue::app {
namespace {

bool is_xml(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");  // behind a BOM, too
  return first != std::string::npos && text[first] == '<';
}

}  // namespace

void add_conversion_options(Command& command, ConversionArguments& arguments) {
  command.add_input(
      "A robot: YAML, URDF, or calibration of Universal Robots (kinematics file or "
      "calibration.conf)");
  command.add_output(ProductKind::document);
  command
      .option(
          "--to", arguments.to,
          "What to write: yaml or json (the robot file), urdf, controller (with --into: "
          "calibration.conf or the kinematics file of Universal Robots), or fields (a table of the "
          "numbers to enter into a controller)")
      .required()
      .check(one_of({"yaml", "json", "urdf", "controller", "fields"}));
  command.option("--base", arguments.ends.base,
                 "Link of the URDF whose frame is R_A; its root if absent");
  command.option(
      "--tip", arguments.ends.tip,
      "Link of the URDF whose frame is that of the last link, the flange of programs; the "
      "only end if absent");
  Option into = command.file(
      "--into", arguments.into,
      "URDF, or calibration of Universal Robots (kinematics file of the driver or "
      "calibration.conf), of the same arm: write it with the robot's geometry; only the "
      "origins of its joints change. With --to fields: what the controller holds now, "
      "$machine.dat of KUKA or SYSMAST.VA of FANUC");
  command.flag("--keep-base", arguments.kept.base, "With --into: the base stays as in the URDF")
      .needs(into);
  command.flag("--keep-tool", arguments.kept.tool, "With --into: the tool stays as in the URDF")
      .needs(into);
  command.file(
      "--nominal", arguments.nominal,
      "The nominal robot: of --to fields the model of the controller, of a calibration.conf "
      "the type by its DH parameters, such as ur5e.yaml");
  command
      .joints(
          "--counts-per-deg", arguments.counts_per_degree,
          "With SYSMAST.VA: how far the count of each encoder rises per deg of its axis, below 0 "
          "if it falls; separated by commas")
      .needs(into);
  command.file("--poses", arguments.poses,
               "Joint targets at which constants stand for the effects; the travel if absent");
  command.option("--payload-kg", arguments.payload_kg, "Payload there; 0 if absent")
      .check(payload_of_arm());
  command.option("--t-s", arguments.time_s, "Time since the start of the campaign; 0 if absent");
  command.option("--temp-c", arguments.temperature_c, "Temperature of all sensors; 20 if absent")
      .check(temperature_of_arm());
}

Robot nominal_robot(Command& command, const ConversionArguments& arguments,
                    const std::string& why) {
  if (arguments.nominal.empty()) throw InputError(why);
  return command.read_robot(arguments.nominal).robot;
}

Robot read_any_robot(Command& command, const std::string& text, const std::string& file,
                     const ConversionArguments& arguments) {
  if (is_xml(text)) {
    const Robot robot = parse_urdf(text, file, arguments.ends);
    warn_of_all(command, doubts_of_urdf(robot, text, file, arguments.ends));
    return robot;
  }
  if (is_ur_calibration(text)) return parse_ur_calibration(text, file);
  if (!is_ur_conf(text)) return parse_robot(text, file);
  const Robot nominal = nominal_robot(command, arguments,
                                      file +
                                          ": is added to the DH parameters of the type; give its "
                                          "robot file as --nominal, such as ur5e.yaml");
  return parse_ur_conf(text, file, nominal, arguments.nominal);
}

void check_usage(const Command& command, const ConversionArguments& arguments,
                 const std::string& text) {
  if (arguments.to == "urdf" && is_json_file(command.output))
    throw UsageError("-o: '" + command.output +
                     "' ends in .json, and a URDF is XML: end it in .urdf, or give --to json");
  if (arguments.to == "controller" && arguments.into.empty())
    throw UsageError(
        "--to controller: name the file of the controller as --into; its other lines stay");
  const bool writes_into = arguments.to != "yaml" && arguments.to != "json";
  if (!arguments.into.empty() && (is_xml(text) || !writes_into))
    throw InputError(
        "--into writes a robot file into another file: it needs --to urdf, controller or fields, "
        "and "
        "YAML as input");
}

}  // namespace armtrue::app
