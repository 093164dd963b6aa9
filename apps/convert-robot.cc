#include "armtrue/io/output.h"
#include "armtrue/io/source.h"
#include "armtrue/io/urdf_io.h"
#include "command_line.h"

using namespace armtrue;

namespace {

struct Arguments {
  std::string to;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("A robot, YAML or URDF");
  command.add_output();
  command.option("--to", arguments.to, "yaml or urdf")
      .required()
      .check(app::one_of({"yaml", "urdf"}));
}

bool is_xml(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");  // behind a BOM, too
  return first != std::string::npos && text[first] == '<';
}

int run(app::Command& command, const Arguments& arguments) {
  Source source(command.input);
  const std::string text = source.read_all();
  const Robot robot =
      is_xml(text) ? parse_urdf(text, source.name()) : parse_robot(text, source.name());
  if (arguments.to == "yaml") {
    write_output(command.output, write_robot(robot));
    return app::kSuccess;
  }
  std::string lost;
  for (const std::string& key : lost_in_urdf(robot)) lost += (lost.empty() ? "" : ", ") + key;
  if (!lost.empty()) command.warn("URDF cannot hold: " + lost);
  write_output(command.output, write_urdf(robot));
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
