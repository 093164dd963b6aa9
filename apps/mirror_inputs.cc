#include "mirror_inputs.h"

#include <fmt/format.h>

#include "armtrue/text/number_text.h"
#include "columns.h"
#include "pass_warnings.h"

namespace armtrue::app {
namespace {

Check gain_or_auto() {
  return {"NUMBER or auto", [](const std::string& text) {
            const std::string wrong = above_zero_or_auto().why_wrong(text);
            if (!wrong.empty() || text == "auto" || *read_number(text) < 2) return wrong;
            return "'" + text +
                   "' must be below 2: the correction would put the tool at least as far off on "
                   "the other side, and every further pass farther; 1 takes off the whole "
                   "deviation";
          }};
}

void add_correction_options(Command& command, MirrorArguments& arguments, Option from_force) {
  command.option("--order", arguments.order, "Order of the Butterworth filter, each way")
      .check(in_range(1, 12))
      .default_shown();
  command.option("--cut-off", arguments.cutoff_hz, "-3 dB of both ways together, Hz; or auto")
      .check(above_zero_or_auto())
      .default_shown();
  command
      .option("--points", arguments.points,
              "turning: straight between the turning points of the trend; or spline")
      .check(one_of({"turning", "spline"}))
      .default_shown()
      .excludes(from_force);
  command
      .option("--gain", arguments.gain,
              "Share of the deviation to correct, below 2; auto: the share that is not noise")
      .check(gain_or_auto())
      .default_shown();
  command.option("--max-mm", arguments.max_mm, "Longest correction").check(above_zero());
  const Option fit_frame = command
                               .flag("--fit-frame", arguments.fit_frame,
                                     "The instrument's frame is not the program's: fit it too")
                               .excludes(from_force);
  command
      .option("--offset-s", arguments.offset_s,
              "The instrument's clock is this far ahead of the program's; not fitted")
      .excludes(from_force)
      .excludes(fit_frame);
}

std::vector<PathFile> read_passes(Command& command, const std::vector<std::string>& files,
                                  const std::optional<Robot>& robot) {
  std::vector<PathFile> passes;
  for (const std::string& file : files)
    passes.push_back(command.read_path(file, KeepRows::no, robot));
  return passes;
}

}  // namespace

void add_mirror_options(Command& command, MirrorArguments& arguments) {
  command.add_output(ProductKind::table);
  command.file("--programmed", arguments.programmed, "The path as it should be: t_s,x_mm,y_mm,z_mm")
      .required();
  OptionGroup source = command.group("Deviation");
  source.file("--measured", arguments.measured,
              "One or more recorded passes, each with its own clock; - is standard input");
  const Option from_force = source.flag("--from-force", arguments.from_force,
                                        "Without a measured pass: correct the deviation of "
                                        "--robot under the forces in the file of the program");
  source.require_one();
  from_force.needs(command.file(
      "--robot", arguments.robot,
      "Robot file with effects that a force drives: its prediction is compared with the pass"));
  // For an option that means nothing without a measured pass.
  const auto of_passes = [&](Option option) { option.excludes(from_force); };
  const Option forces =
      command.file("--forces", arguments.forces,
                   "Record of a force plate with a clock of its own, for each pass of --measured: "
                   "t_s,fx_n,fy_n,fz_n. The deviation of the pass tells its clock");
  of_passes(forces);
  command
      .option("--force-offset-s", arguments.force_offset_s,
              "The plate's clock is this far ahead of the instrument's; not fitted")
      .needs(forces);
  of_passes(
      command.flag("--engaged-only", arguments.engaged_only, "Correct only where the tool cuts"));
  of_passes(command.file("--before", arguments.before,
                         "Recorded passes before the correction, to show what it gained"));
  of_passes(command.add_output("--poses", arguments.poses,
                               "Write the pass as measured poses for close-loop here; the joint "
                               "angles are those of the program's file or, with --robot, "
                               "calculated",
                               ProductKind::table));
  of_passes(
      command.file("--previous", arguments.previous,
                   "The corrected path that these passes ran; the new correction is added to it"));
  add_correction_options(command, arguments, from_force);
  add_path_program(command, arguments.program);
  of_passes(command.add_output("--summary", arguments.summary,
                               "Write clocks, noise, deviation and forecast here",
                               ProductKind::document));
  of_passes(command
                .option("--goal-mm", arguments.goal_mm,
                        "Largest RMS form error that is wanted, without the noise of the "
                        "instrument")
                .check(above_zero())
                .default_shown());
  of_passes(command.add_output("--deviation", arguments.deviation,
                               "Write the deviation and its trend here", ProductKind::table));
  for (const Option& option :
       add_report(command, arguments.page, "of the measured passes with pictures"))
    of_passes(option);
  command.add_columns(kPathColumns);
}

MirrorOptions mirror_options(const MirrorArguments& arguments) {
  MirrorOptions options;
  options.order = arguments.order;
  options.cutoff = number_or_auto(arguments.cutoff_hz);
  options.gain = number_or_auto(arguments.gain);
  options.points =
      arguments.points == "spline" ? CorrectionPoints::spline : CorrectionPoints::turning;
  options.engaged_only = arguments.engaged_only;
  if (arguments.max_mm) options.max = *arguments.max_mm * kMillimetre;
  options.clock.fit_frame = arguments.fit_frame;
  options.clock.offset = arguments.offset_s;
  return options;
}

MirrorInputs read_mirror_inputs(Command& command, const MirrorArguments& arguments) {
  command.progress("reading");
  MirrorInputs inputs;
  if (!arguments.program.path.empty())
    inputs.program = read_path_program(command, arguments.program);
  // The robot tells which joint columns a path has; among the inputs it stands after the program.
  std::optional<RobotFile> robot;
  if (!arguments.robot.empty()) inputs.robot = robot.emplace(read_robot(arguments.robot)).robot;
  inputs.programmed = command.read_path(arguments.programmed, KeepRows::yes, inputs.robot);
  constexpr const char* kAsPrevious = ", and this path as --previous if the passes ran it";
  refuse_corrected(inputs.programmed, "the path as it should be as --programmed", kAsPrevious);
  if (robot) command.add_robot_to_inputs(*robot);
  inputs.about = read_about(command, arguments.page);
  inputs.passes = read_passes(command, arguments.measured, inputs.robot);
  inputs.earlier = read_passes(command, arguments.before, inputs.robot);
  for (const std::string& file : arguments.forces)
    inputs.forces.push_back(command.read_force_record(file));
  if (!inputs.forces.empty() && inputs.forces.size() != inputs.passes.size())
    throw UsageError(fmt::format(
        "--forces names {} records and --measured {} passes; name one for each, in the same order",
        inputs.forces.size(), inputs.passes.size()));
  for (const std::vector<PathFile>* passes : {&inputs.passes, &inputs.earlier})
    for (const PathFile& pass : *passes)
      refuse_corrected(pass, "what the instrument recorded", kAsPrevious);
  std::vector<const PathFile*> all = {&inputs.programmed};
  for (const PathFile& pass : inputs.passes) all.push_back(&pass);
  for (const PathFile& pass : inputs.earlier) all.push_back(&pass);
  refuse_the_same(command, all);
  refuse_copies(inputs.passes);
  refuse_copies(inputs.earlier);
  warn_of_interpolated(command, inputs.passes);
  warn_of_computed(command, inputs.programmed, inputs.passes);
  warn_of_computed(command, inputs.programmed, inputs.earlier);
  warn_of_copied(command, inputs.programmed, inputs.passes);
  if (arguments.previous.empty() && !arguments.before.empty())
    command.warn(
        "--before names passes before a correction, and --previous does not name the correction "
        "that the measured passes ran: the new one replaces it, and what it took off comes back");
  if (arguments.previous.empty()) return inputs;
  inputs.previous = command.read_path(arguments.previous, KeepRows::yes, inputs.robot);
  if (!inputs.previous->path.has_times_of(inputs.programmed.path))
    throw InputError(inputs.previous->source + ": its times are not those of " +
                     inputs.programmed.source +
                     "; --previous takes what mirror-correct wrote for the same program");
  if (inputs.previous->sha256 == inputs.programmed.sha256)
    command.warn(inputs.previous->source +
                 ": is the program itself and corrects nothing; name the corrected path that the "
                 "passes ran, or leave --previous out");
  return inputs;
}

}  // namespace armtrue::app
