#include <fmt/format.h>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/doubts.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/compensation/compensation.h"
#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/diagnosis/mistakes.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/evaluation_io.h"
#include "armtrue/io/products/residuals_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/report/calibration_page.h"
#include "armtrue/text/number_text.h"
#include "columns.h"
#include "command_line.h"
#include "option_text.h"
#include "report_arguments.h"

using namespace armtrue;

namespace {

struct Arguments {
  std::string robot, against, refit, residuals;
  app::ReportArguments page;
  double max_error_mm = 0;  // 0: no limit
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("Measured poses");
  command.add_output(app::ProductKind::document);
  command.add_new_sessions();
  command.file("--robot", arguments.robot, "The robot to evaluate").required();
  command.option("--refit", arguments.refit,
                 "Fit these first, such as base,tool for a robot in another set-up");
  command.file("--against", arguments.against,
               "Compare with this robot on the same readings, such as the nominal one; --refit is "
               "applied to it too");
  command.add_output("--residuals", arguments.residuals, "Write the residual of every reading here",
                     app::ProductKind::table);
  command
      .option("--max-error-mm", arguments.max_error_mm,
              "Exit with 3 if position_mm: mean, the mean error of the readings, is larger")
      .check(app::above_zero());
  app::add_report(command, arguments.page, "with errors, maps and the robot of --against");
  command.add_columns(app::kMeasuredPoseColumns);
}

// The robot as it is judged.
Robot set_up(app::Command& command, const Arguments& arguments, const Robot& robot,
             const Campaign& campaign) {
  app::refuse_mistakes(command, robot, campaign);
  if (arguments.refit.empty()) {
    app::require_sessions(robot, campaign);
    return robot;
  }
  command.progress("refitting " + arguments.refit);
  return refit_set_up(robot, campaign, app::parameters_of("--refit", arguments.refit, robot));
}

// Reports what is wrong with the errors of `given`, fitted as `robot`; false if a criterion fails
// and the result must not be used. A nominal robot as its file has it fails none: its base may be
// that of another cell. Who states a limit wants bounds that hold, too.
bool meets_criteria(app::Command& command, const Arguments& arguments, const Robot& given,
                    const Robot& robot, const Campaign& campaign, const Evaluation& evaluation,
                    const std::string& broken) {
  const bool is_refitted = !arguments.refit.empty();
  const std::string beyond = beyond_arm(given, robot, campaign, evaluation);
  if (!beyond.empty())
    command.warn(beyond + (is_refitted ? ""
                                       : "; or base and tool are those of another set-up: then "
                                         "give --refit base,tool"));
  const bool meets = beyond.empty() || !(is_refitted || states_calibration(given));
  if (!broken.empty()) command.warn(broken);
  if (arguments.max_error_mm == 0) return meets;
  const double mean = summarize(evaluation.reading_errors()).mean / kMillimetre;
  if (mean <= arguments.max_error_mm) return meets && broken.empty();
  command.warn(
      fmt::format("the mean error, {:.4g} mm, is above {:g} mm", mean, arguments.max_error_mm));
  return false;
}

int run(app::Command& command, const Arguments& arguments) {
  const RobotFile file = command.read_robot(arguments.robot);
  const Robot& given = file.robot;
  std::optional<Robot> against;
  if (!arguments.against.empty()) {
    against = command.read_robot(arguments.against).robot;
    app::require_same_joints(given, arguments.robot, *against, arguments.against);
  }
  if (arguments.max_error_mm > kImplausibleMiss / kMillimetre)
    command.warn(fmt::format("--max-error-mm {:g}: every arm meets it; is it in um?",
                             arguments.max_error_mm));
  if (against && is_calibrated(*against) && !is_calibrated(given))
    command.warn(arguments.against + " is calibrated and " + arguments.robot +
                 " is not: the gain of the second over the first is meant; exchange --robot and "
                 "--against if it is not");
  const Campaign campaign = command.read_campaign(command.input, given, app::Command::Copies::keep);
  command.warn_of_training(file, campaign,
                           "their errors are what the fit left, not those of other poses");
  const std::optional<About> about = app::read_about(command, arguments.page);
  const Robot robot = set_up(command, arguments, given, campaign);
  if (against) against = set_up(command, arguments, *against, campaign);
  app::warn_of_all(command,
                   {hidden_by_refit(app::split_list(arguments.refit), given, campaign).words});
  const Evaluation evaluation = evaluate(robot, campaign);
  std::vector<Prediction> predictions;
  if (robot.uncertainty) {
    predictions = predict(robot, campaign);
    app::warn_of_all(command, off_and_counted(find_gross_held_out(robot, campaign)));
    app::warn_of_all(command, {contradiction_of_uncertainty(robot, campaign, evaluation)});
  }
  const std::string broken = broken_bounds(robot, campaign, evaluation, predictions);
  const bool is_met =
      meets_criteria(command, arguments, given, robot, campaign, evaluation, broken);
  if (!arguments.residuals.empty()) {
    const std::vector<std::string> split(campaign.rows(), "all");
    write_output(arguments.residuals,
                 write_residuals({{campaign, evaluation.residuals, split, predictions}}));
  }
  const Document product =
      write_summary(evaluation, robot, campaign, command.provenance(), predictions, against);
  write_output(command.output, product);
  if (arguments.page.is_wanted())
    app::write_report(command, arguments.page,
                      evaluation_page(robot, given, campaign, evaluation, against,
                                      app::page_head(command, product, about),
                                      broken.empty() ? Bounds::held_or_unknown : Bounds::broken));
  const std::vector<double> of_readings = evaluation.reading_errors();
  const ErrorSummary errors = summarize(of_readings);
  const double floor = noise_floor(robot, campaign, evaluation).mean_error();
  command.report(fmt::format(
      "{}: mean error {:.4g} mm, {:.4g} mm at most{}\n", counted(of_readings.size(), "reading"),
      errors.mean / kMillimetre, errors.max / kMillimetre,
      floor > 0 ? fmt::format("; noise alone makes {:.4g} mm on average", floor / kMillimetre)
                : ""));
  return is_met ? app::kSuccess : app::kNotReached;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("evaluate-poses", "Errors of a robot model on measured poses.",
                       "evaluate-poses --robot calibrated.yaml --refit base,tool other-cell.csv");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
