#include "armtrue/io/output.h"
#include "armtrue/io/source.h"
#include "armtrue/io/urdf_io.h"
#include "command_line.h"

using namespace armtrue;

int main(int argc, char** argv) {
  app::Command command("convert-robot", "Convert a robot between its YAML file and URDF.",
                       "convert-robot robot.yaml --to urdf > robot.urdf");
  std::string to;
  command.add_input("A robot, YAML or URDF");
  command.add_output();
  command.options()
      .add_option("--to", to, "yaml or urdf")
      ->required()
      ->check(CLI::IsMember({"yaml", "urdf"}));
  return command.run(argc, argv, [&] {
    Source source(command.input);
    const std::string text = source.read_all();
    const size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    const bool is_xml = first != std::string::npos && text[first] == '<';
    const Robot robot = is_xml ? parse_urdf(text, source.name()) : parse_robot(text, source.name());
    if (to == "urdf") {
      std::string lost;
      for (const std::string& key : lost_in_urdf(robot)) lost += (lost.empty() ? "" : ", ") + key;
      if (!lost.empty()) command.warn("URDF cannot hold: " + lost);
      write_output(command.output, write_urdf(robot));
    } else {
      write_output(command.output, write_robot(robot));
    }
    return app::kSuccess;
  });
}
