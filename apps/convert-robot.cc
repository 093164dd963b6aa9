#include <string>

#include "armtrue/io/output.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/io/source.h"
#include "armtrue/text/input_error.h"
#include "armtrue/urdf/urdf_io.h"
#include "command_line.h"
#include "conversion_inputs.h"
#include "conversion_outputs.h"

using namespace armtrue;

namespace {

int run(app::Command& command, const app::ConversionArguments& arguments) {
  Source source(command.input);
  const std::string text = source.read_all();
  app::check_usage(command, arguments, text);
  const Robot robot = app::read_any_robot(command, text, source.name(), arguments);
  if (arguments.to == "json") {
    const Document document = write_robot(robot);
    if (is_json_file(command.output))
      write_output(command.output, document);
    else
      write_output(command.output, document.json());
    return app::kSuccess;
  }
  if (arguments.to == "yaml") {
    write_output(command.output, write_robot(robot));
    return app::kSuccess;
  }
  if (arguments.to == "fields") {
    write_output(command.output, app::controller_fields(command, robot, source.name(), arguments));
    return app::kSuccess;
  }
  if (robot.ground_link)
    throw InputError(source.name() +
                     ": a URDF is written of an arm alone, and this robot is two arms or has a "
                     "positioner that carries the part; keep it as YAML, which all commands read");
  std::string lost;
  for (const std::string& key : lost_in_urdf(robot)) lost += (lost.empty() ? "" : ", ") + key;
  if (!lost.empty() && arguments.to == "urdf") command.warn("URDF cannot hold: " + lost);
  const Robot alone = app::with_constants_alone(command, robot, source.name(), arguments);
  write_output(command.output,
               arguments.to == "controller" ? app::into_controller(command, alone, arguments)
               : arguments.into.empty()     ? write_urdf(alone)
                                            : app::into_urdf(command, alone, arguments));
  return app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("convert-robot",
                       "Convert a robot between its YAML file, URDF and files of controllers.",
                       "convert-robot robot.yaml --to urdf > robot.urdf");
  app::ConversionArguments arguments;
  app::add_conversion_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
