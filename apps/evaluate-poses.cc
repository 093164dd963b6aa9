#include <fmt/format.h>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/io/output.h"
#include "armtrue/io/report_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "command_line.h"

using namespace armtrue;

int main(int argc, char** argv) {
  app::Command command("evaluate-poses", "Errors of a robot model on measured poses.",
                       "evaluate-poses --robot calibrated.yaml --refit base,tool other-cell.csv");
  std::string robot_path, refit, residuals_path;
  double max_error_mm = 0;
  command.add_input("Measured poses");
  command.add_output();
  command.add_new_sessions();
  command.options().add_option("--robot", robot_path, "The robot to judge")->required();
  command.options().add_option(
      "--refit", refit, "Fit these first, as base,tool for a robot carried to another set-up");
  command.add_output("--residuals", residuals_path, "Write the residual of every reading here");
  command.options()
      .add_option("--max-error-mm", max_error_mm,
                  "Exit with 3 if position_mm: mean, the mean error of the readings, is larger")
      ->check(app::above_zero());
  return command.run(argc, argv, [&] {
    Robot robot = command.robot(robot_path).robot;
    const Campaign campaign = command.campaign(command.input, robot);
    for (int session : campaign.session)
      if (const std::string& name = campaign.session_names[session];
          refit.empty() && !robot.sessions.empty() && !robot.sessions.contains(name))
        throw InputError(campaign.source +
                         ": the robot file does not say where the instrument of "
                         "session '" +
                         name + "' stood; add --refit base");
    if (!refit.empty()) {
      command.progress("refitting " + refit);
      robot = refit_set_up(robot, campaign, app::split_list(refit));
    }
    const Evaluation evaluation = evaluate(robot, campaign);
    if (!residuals_path.empty()) {
      const std::vector<std::string> split(campaign.rows(), "all");
      write_output(residuals_path, write_residuals({{campaign, evaluation.residuals, split}}));
    }
    write_output(command.output, write_summary(evaluation, robot, campaign, command.provenance()));
    const double mean = summarize(evaluation.position).mean / kMillimetre;
    if (max_error_mm > 0 && mean > max_error_mm) {
      command.warn(fmt::format("the mean error, {:.4g} mm, is above {:g} mm", mean, max_error_mm));
      return app::kNotReached;
    }
    return app::kSuccess;
  });
}
