#include <fmt/format.h>

#include "armtrue/io/output.h"
#include "armtrue/io/products/deviation_io.h"
#include "armtrue/io/products/mirror_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/path/joint_path.h"
#include "armtrue/path/mirror/findings.h"
#include "armtrue/path/mirror/mirror.h"
#include "armtrue/path/samples/bad_samples.h"
#include "armtrue/report/mirror_page.h"
#include "armtrue/report/mirror_table.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "columns.h"
#include "command_line.h"
#include "pass_warnings.h"
#include "path_program.h"
#include "report_arguments.h"

using namespace armtrue;

namespace {

struct Arguments {
  std::string programmed, robot, previous;
  std::vector<std::string> measured, before;
  bool from_force = false, engaged_only = false, fit_frame = false;
  int order = MirrorOptions{}.order;
  double goal_mm = kFormGoal / kMillimetre;
  std::string cutoff_hz = "1.5625", gain = "auto", points = "turning";
  std::optional<double> max_mm, offset_s;
  app::PathProgramArguments program;
  std::string poses, summary, deviation;
  app::ReportArguments page;
};

app::Check gain_or_auto() {
  return {"NUMBER or auto", [](const std::string& text) {
            const std::string wrong = app::above_zero_or_auto().why_wrong(text);
            if (!wrong.empty() || text == "auto" || *read_number(text) < 2) return wrong;
            return "'" + text +
                   "' must be below 2: the correction would put the tool at least as far off on "
                   "the other side, and every further pass farther; 1 takes off the whole "
                   "deviation";
          }};
}

void add_correction_options(app::Command& command, Arguments& arguments, app::Option from_force) {
  command.option("--order", arguments.order, "Order of the Butterworth filter, each way")
      .check(app::in_range(1, 12))
      .default_shown();
  command.option("--cut-off", arguments.cutoff_hz, "-3 dB of both ways together, Hz; or auto")
      .check(app::above_zero_or_auto())
      .default_shown();
  command
      .option("--points", arguments.points,
              "turning: straight between the turning points of the trend; or spline")
      .check(app::one_of({"turning", "spline"}))
      .default_shown()
      .excludes(from_force);
  command
      .option("--gain", arguments.gain,
              "Share of the deviation to correct, below 2; auto: the share that is not noise")
      .check(gain_or_auto())
      .default_shown();
  command.option("--max-mm", arguments.max_mm, "Longest correction").check(app::above_zero());
  const app::Option fit_frame = command
                                    .flag("--fit-frame", arguments.fit_frame,
                                          "The instrument's frame is not the program's: fit it too")
                                    .excludes(from_force);
  command
      .option("--offset-s", arguments.offset_s,
              "The instrument's clock is this far ahead of the program's; not fitted")
      .excludes(from_force)
      .excludes(fit_frame);
}

void add_options(app::Command& command, Arguments& arguments) {
  command.add_output();
  command.file("--programmed", arguments.programmed, "The path as it should be: t_s,x_mm,y_mm,z_mm")
      .required();
  app::OptionGroup source = command.group("Deviation");
  source.file("--measured", arguments.measured,
              "One or more recorded passes, each with its own clock; - is standard input");
  const app::Option from_force = source.flag("--from-force", arguments.from_force,
                                             "Without a measured pass: correct the deviation of "
                                             "--robot under the forces in the file of the program");
  source.require_one();
  from_force.needs(command.file(
      "--robot", arguments.robot,
      "Robot file with effects that a force drives: its prediction is compared with the pass"));
  // For an option that means nothing without a measured pass.
  const auto of_passes = [&](app::Option option) { option.excludes(from_force); };
  of_passes(
      command.flag("--engaged-only", arguments.engaged_only, "Correct only where the tool cuts"));
  of_passes(command.file("--before", arguments.before,
                         "Recorded passes before the correction, to show what it gained"));
  of_passes(command.add_output("--poses", arguments.poses,
                               "Write the pass as measured poses for close-loop here; the joint "
                               "angles are those of the program's file or, with --robot, "
                               "calculated"));
  of_passes(
      command.file("--previous", arguments.previous,
                   "The corrected path that these passes ran; the new correction is added to it"));
  add_correction_options(command, arguments, from_force);
  app::add_path_program(command, arguments.program);
  of_passes(command.add_output("--summary", arguments.summary,
                               "Write clocks, noise, deviation and forecast here",
                               app::ProductKind::document));
  of_passes(command
                .option("--goal-mm", arguments.goal_mm,
                        "Largest RMS form error that is wanted, without the noise of the "
                        "instrument")
                .check(app::above_zero())
                .default_shown());
  of_passes(command.add_output("--deviation", arguments.deviation,
                               "Write the deviation and its trend here"));
  for (const app::Option& option :
       app::add_report(command, arguments.page, "of the measured passes with pictures"))
    of_passes(option);
  command.add_columns(app::kPathColumns);
}

MirrorOptions mirror_options(const Arguments& arguments) {
  MirrorOptions options;
  options.order = arguments.order;
  options.cutoff = app::number_or_auto(arguments.cutoff_hz);
  options.gain = app::number_or_auto(arguments.gain);
  options.points =
      arguments.points == "spline" ? CorrectionPoints::spline : CorrectionPoints::turning;
  options.engaged_only = arguments.engaged_only;
  if (arguments.max_mm) options.max = *arguments.max_mm * kMillimetre;
  options.clock.fit_frame = arguments.fit_frame;
  options.clock.offset = arguments.offset_s;
  return options;
}

// The correction that the passes ran. It must have the samples of the program.
Eigen::Matrix3Xd previous_correction(const PathFile& previous, const PathFile& programmed) {
  if (!previous.path.has_times_of(programmed.path))
    throw InputError(previous.source + ": its times are not those of " + programmed.source +
                     "; --previous takes what mirror-correct wrote for the same program");
  return previous.path.position;
}

std::vector<PathFile> read_passes(app::Command& command, const std::vector<std::string>& files,
                                  const std::optional<Robot>& robot) {
  std::vector<PathFile> passes;
  for (const std::string& file : files)
    passes.push_back(command.read_path(file, KeepRows::no, robot));
  return passes;
}

std::vector<Path> paths(const std::vector<PathFile>& files) {
  std::vector<Path> all;
  for (const PathFile& file : files) all.push_back(file.path);
  return all;
}

MirrorResult correct(app::Command& command, const PathFile& programmed,
                     const std::vector<PathFile>& passes, const MirrorOptions& options) {
  try {
    MirrorResult result = mirror_correct(programmed.path, paths(passes), options);
    for (size_t p = 0; p < passes.size(); ++p)
      app::warn_of_bad(command, passes[p], result.passes[p].bad);
    app::warn_of_doubts(command, programmed, passes, result, options);
    return result;
  } catch (const TooManyBadSamples& error) {
    app::refuse(passes[error.pass], error.bad);
  } catch (const UnusablePass& error) {
    throw InputError(passes[error.pass].source + ": " + error.what());
  }
}

// Paths of the earlier passes, which are only compared with, without their bad samples.
std::vector<Path> without_bad(app::Command& command, const Path& programmed,
                              const std::vector<PathFile>& passes) {
  std::vector<Path> good;
  for (const PathFile& pass : passes) {
    const std::vector<BadSample> bad = find_bad_samples(programmed, pass.path);
    if (too_many(bad, pass.path)) app::refuse(pass, bad);
    app::warn_of_bad(command, pass, bad);
    good.push_back(without(pass.path, bad));
  }
  return good;
}

Eigen::Matrix3Xd corrected_from_force(const PathFile& programmed, const Robot& robot,
                                      const MirrorOptions& options) {
  if (!programmed.path.has_force())
    throw InputError(programmed.source +
                     ": --from-force needs the forces of the cut: add fx_n, fy_n and fz_n");
  return app::on_samples_of(programmed, [&] {
    return correct_from_force(
        programmed.path,
        deviation_from_force(RobotModel(robot), joint_path(programmed.path, robot.chain),
                             programmed.path.force),
        options);
  });
}

std::string pass_as_poses(const PathFile& programmed, const std::optional<Robot>& robot,
                          const PathDeviation& deviation) {
  if (!programmed.path.has_joints() && !robot)
    throw InputError(programmed.source +
                     ": --poses needs the joint angles of the program: add q1_deg to q6_deg, or "
                     "give --robot");
  constexpr int kBlock = 10;  // samples of the deviation per pose
  return app::on_samples_of(programmed, [&] {
    return write_pass_as_poses(
        programmed.path, robot ? joint_path(programmed.path, robot->chain) : programmed.path.q,
        deviation, kBlock, robot ? joint_names(robot->chain) : six_axis_names());
  });
}

// The files of one run.
struct Inputs {
  PathFile programmed;
  std::optional<Robot> robot;
  std::vector<PathFile> passes, earlier;
  std::optional<PathFile> previous;
  std::optional<RobotProgram> program;
  std::optional<About> about;
};

Inputs read_inputs(app::Command& command, const Arguments& arguments) {
  command.progress("reading");
  Inputs inputs;
  if (!arguments.program.path.empty())
    inputs.program = app::read_path_program(command, arguments.program);
  // The robot tells which joint columns a path has; among the inputs it stands after the program.
  std::optional<RobotFile> robot;
  if (!arguments.robot.empty()) inputs.robot = robot.emplace(read_robot(arguments.robot)).robot;
  inputs.programmed = command.read_path(arguments.programmed, KeepRows::yes, inputs.robot);
  constexpr const char* kAsPrevious = ", and this path as --previous if the passes ran it";
  app::refuse_corrected(inputs.programmed, "the path as it should be as --programmed", kAsPrevious);
  if (robot) command.add_robot_to_inputs(*robot);
  inputs.about = app::read_about(command, arguments.page);
  inputs.passes = read_passes(command, arguments.measured, inputs.robot);
  inputs.earlier = read_passes(command, arguments.before, inputs.robot);
  for (const std::vector<PathFile>* passes : {&inputs.passes, &inputs.earlier})
    for (const PathFile& pass : *passes)
      app::refuse_corrected(pass, "what the instrument recorded", kAsPrevious);
  std::vector<const PathFile*> all = {&inputs.programmed};
  for (const PathFile& pass : inputs.passes) all.push_back(&pass);
  for (const PathFile& pass : inputs.earlier) all.push_back(&pass);
  app::warn_of_the_same(command, all);
  app::warn_of_computed(command, inputs.programmed, inputs.passes);
  app::warn_of_computed(command, inputs.programmed, inputs.earlier);
  app::warn_of_copied(command, inputs.programmed, inputs.passes);
  if (arguments.previous.empty() && !arguments.before.empty())
    command.warn(
        "--before names passes before a correction, and --previous does not name the correction "
        "that the measured passes ran: the new one replaces it, and what it took off comes back");
  if (arguments.previous.empty()) return inputs;
  inputs.previous = command.read_path(arguments.previous, KeepRows::yes, inputs.robot);
  if (inputs.previous->sha256 == inputs.programmed.sha256)
    command.warn(inputs.previous->source +
                 ": is the program itself and corrects nothing; name the corrected path that the "
                 "passes ran, or leave --previous out");
  return inputs;
}

// What only a measured pass gives.
void write_findings(app::Command& command, const Arguments& arguments, const Inputs& inputs,
                    MirrorFindings& findings) {
  app::warn_of_gaps(command, inputs.programmed, findings.result);
  app::warn_of_clipping(command, findings.result, findings.options);
  if (command.verbose || !arguments.summary.empty() || arguments.page.is_wanted()) {
    command.progress("describing");
    const std::vector<Path> earlier = without_bad(command, inputs.programmed.path, inputs.earlier);
    app::on_samples_of(inputs.programmed, [&] {
      describe_passes(findings, inputs.programmed.path, paths(inputs.passes), earlier,
                      inputs.robot);
    });
    command.tell(mirror_table(findings));
  }
  if (!arguments.summary.empty())
    write_output(arguments.summary, write_mirror(findings, command.provenance()));
  if (!arguments.deviation.empty())
    write_output(arguments.deviation, write_deviation(findings.result.deviation));
  if (!arguments.poses.empty())
    write_output(arguments.poses,
                 pass_as_poses(inputs.programmed, inputs.robot, findings.result.deviation));
  if (arguments.page.is_wanted())
    app::write_report(command, arguments.page,
                      mirror_page(inputs.programmed.path, findings, inputs.programmed.source,
                                  app::page_head(command, inputs.about)));
}

int run(app::Command& command, const Arguments& arguments) {
  MirrorFindings findings;
  findings.options = mirror_options(arguments);
  findings.goal = arguments.goal_mm * kMillimetre;
  const Inputs inputs = read_inputs(command, arguments);
  for (const PathFile& pass : inputs.passes) {
    findings.files.push_back(pass.source);
    findings.lines.push_back(pass.line);
  }
  if (inputs.previous)
    findings.options.executed = previous_correction(*inputs.previous, inputs.programmed);

  command.progress("correcting");
  if (!arguments.from_force)
    findings.result = correct(command, inputs.programmed, inputs.passes, findings.options);
  else
    findings.result.position =
        corrected_from_force(inputs.programmed, *inputs.robot, findings.options);
  const Eigen::Matrix3Xd& corrected = findings.result.position;
  // The correction is written before the further products, so that an error in one of them cannot
  // keep it back.
  if (inputs.program)
    app::write_path_program(command, arguments.program, *inputs.program, inputs.programmed.path,
                            corrected, findings.options.executed);
  write_output(command.output, write_path_like(inputs.programmed, corrected));
  if (!arguments.from_force) write_findings(command, arguments, inputs, findings);
  return app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("mirror-correct",
                       "A programmed path, corrected by the mirror of what was measured across it.",
                       "mirror-correct --programmed path.csv --measured pass.csv > corrected.csv");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
