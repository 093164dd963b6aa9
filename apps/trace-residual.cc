#include "armtrue/identification/tracing.h"
#include "armtrue/io/output.h"
#include "armtrue/io/report_io.h"
#include "command_line.h"

using namespace armtrue;

int main(int argc, char** argv) {
  app::Command command(
      "trace-residual",
      "Trace what the model of a robot lacks: which parameter is not constant, and "
      "what it depends on.",
      "trace-residual --robot robot.yaml measured.csv > ranking.yaml");
  std::string robot_path, catalogue_path;
  bool only_catalogue = false;
  command.add_input("Measured poses");
  command.add_output();
  command.add_seed();
  command.options()
      .add_option("--robot", robot_path, "The robot, nominal or calibrated")
      ->required();
  command.options().add_option("--catalogue", catalogue_path, "Effects to look for");
  command.options().add_flag("--only-catalogue", only_catalogue, "Do not search beyond it");
  return command.run(argc, argv, [&] {
    const Robot robot = command.robot(robot_path).robot;
    const Campaign campaign = command.campaign(command.input, robot);
    TraceOptions options;
    options.seed = command.seed;
    options.beyond_catalogue = !only_catalogue;
    options.progress = [&](const std::string& what) { command.progress(what); };
    const TraceResult result = trace(robot, campaign, app::catalogue(catalogue_path), options);
    write_output(command.output, write_ranking(result, command.provenance()));
    return app::kSuccess;
  });
}
