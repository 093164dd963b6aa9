#include <fmt/format.h>

#include <optional>

#include "armtrue/calibration/doubts.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/diagnosis/change.h"
#include "armtrue/diagnosis/mistakes.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/change_io.h"
#include "armtrue/io/products/ranking_io.h"
#include "armtrue/search/trace.h"
#include "armtrue/text/input_error.h"
#include "columns.h"
#include "command_line.h"

using namespace armtrue;

namespace {

struct Arguments {
  std::string robot, since, identify, catalogue;
  bool only_catalogue = false;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("Measured poses");
  command.add_output(app::ProductKind::document);
  command.add_seed();
  command.add_new_sessions();
  app::OptionGroup model = command.group("Model");
  model.file("--robot", arguments.robot, "The robot, nominal or calibrated");
  const app::Option since = model.file(
      "--since", arguments.since,
      "Robot file of calibrate or close-loop --robot-out: find what has moved since then");
  model.require_one();
  command.identify(arguments.identify).excludes(since);
  command.file("--catalogue", arguments.catalogue, "Effects to look for").excludes(since);
  command.flag("--only-catalogue", arguments.only_catalogue, "Do not search beyond it")
      .excludes(since);
  command.add_columns(app::kMeasuredPoseColumns);
}

// Standard deviation of the residuals of the previous calibration; without one, the noise of the
// instrument.
ReadingSigma residual_spread(const RobotFile& previous, const Campaign& campaign,
                             app::Command& command) {
  const InstrumentNoise& noise = previous.robot.noise;
  std::optional<ReadingSigma> known = previous.residual_spread;
  ReadingSigma stated{noise.position, noise.orientation};
  const double metre_per_pixel = campaign.metre_per_pixel;  // of these images, not of those before
  if (campaign.has_pixels()) {
    known.reset();
    if (previous.pixel_spread) known = {metre_per_pixel * *previous.pixel_spread, 0};
    stated = {metre_per_pixel * noise.pixel, 0};
  }
  if (known) {
    command.tell(previous.name + ": spread of the readings from its calibration\n");
    return *known;
  }
  if (stated.position <= 0)
    throw InputError(previous.name + ": neither calibration: residual_spread nor noise: " +
                     (campaign.has_pixels() ? "pixel_px" : "position_mm") +
                     "; give the robot as calibrate wrote it, or add the noise of the instrument");
  command.warn(previous.name +
               ": no calibration: residual_spread; the instrument's noise stands in for it");
  return stated;
}

std::string name_of(const Move& move) {
  std::string sessions;
  for (const std::string& session : move.sessions)
    sessions += (sessions.empty() ? " in session " : ", ") + session;
  return move.what + sessions;
}

std::string explanation(const ChangeResult& result) {
  if (result.moved.empty()) return "no move explains it";
  std::string names;
  for (const Move& move : result.moved) names += (names.empty() ? "" : " and ") + name_of(move);
  std::string text = names + (result.moved.size() > 1 ? " explain it best" : " explains it best");
  if (result.p_value_left < kChangeSignificance)
    text += fmt::format(", but not all: something else has changed too (p = {:.2g})",
                        result.p_value_left);
  return text;
}

int report_change(app::Command& command, const std::string& path) {
  const RobotFile previous = command.read_robot(path);
  const Campaign campaign = command.read_campaign(command.input, previous.robot);
  if (campaign.has_pixels() && !campaign.has_pixels_only())
    throw InputError(campaign.source +
                     ": has images and other readings; --since compares readings of one kind with "
                     "those of the earlier calibration: give each kind in a file of its own");
  command.warn_of_own_readings(previous);
  app::refuse_mistakes(command, previous.robot, campaign);
  command.warn_if_computed(previous.robot, campaign);
  const ChangeResult result =
      detect_change(previous.robot, residual_spread(previous, campaign, command), campaign);
  for (int row : result.blunders)
    command.warn(fmt::format("{}:{}: this reading of pose {} is a blunder and is left out",
                             campaign.source, campaign.line[row],
                             campaign.pose_ids[campaign.pose[row]]));
  app::warn_of_all(command, {noisier_in_words(result)});
  write_output(command.output,
               write_change(result, previous.robot, campaign, command.provenance()));
  if (result.holds) {
    command.report(
        fmt::format("the calibration holds (p = {:.2g}): a mean error of {:.4g} mm is within what "
                    "its uncertainty and the noise explain\n",
                    result.p_value, result.before / kMillimetre));
    return app::kSuccess;
  }
  command.warn(fmt::format("the calibration does not hold (p = {:.2g}); {}", result.p_value,
                           explanation(result)));
  return app::kNotReached;
}

int rank_candidates(app::Command& command, const Arguments& arguments) {
  Robot robot = command.read_robot(arguments.robot).robot;
  command.forget_remainder(robot, arguments.robot);
  app::use_identify(arguments.identify, robot);
  const Campaign campaign = command.read_campaign(command.input, robot);
  app::refuse_mistakes(command, robot, campaign);
  command.warn_if_computed(robot, campaign);
  TraceOptions options;
  options.seed = command.seed;
  options.beyond_catalogue = !arguments.only_catalogue;
  options.progress = [&](const std::string& what) { command.progress(what); };
  const TraceResult result = trace(robot, campaign, app::catalogue(arguments.catalogue), options);
  const Robot& found = result.fit.robot;
  const std::string beyond = beyond_any_arm(found, campaign, evaluate(found, campaign));
  app::warn_of_all(command, {result.left_out ? left_out_in_words(robot, *result.left_out) : "",
                             lost_in_words(robot, campaign, result.fit), beyond});
  write_output(command.output, write_ranking(result, command.provenance()));
  return beyond.empty() ? app::kSuccess : app::kNotReached;
}

int run(app::Command& command, const Arguments& arguments) {
  return arguments.since.empty() ? rank_candidates(command, arguments)
                                 : report_change(command, arguments.since);
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command(
      "trace-residual",
      "Trace what the model of a robot lacks: which parameter is not constant, and "
      "what it depends on. With --since: whether a calibration still holds, and which parameter "
      "has moved if not (then exit code 3).",
      "trace-residual --robot robot.yaml measured.csv > ranking.yaml\n"
      "  trace-residual --since calibrated.yaml ten-new-poses.csv > change.yaml");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
