#include <fmt/format.h>

#include <algorithm>

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
#include "mirror_inputs.h"
#include "pass_warnings.h"

using namespace armtrue;

namespace {

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

// Gives the passes the forces that plates recorded with clocks of their own.
std::vector<MirrorFindings::Force> add_forces(app::MirrorInputs& inputs,
                                              const MirrorOptions& options,
                                              std::optional<double> stated_offset) {
  std::vector<MirrorFindings::Force> forces;
  Path executed = inputs.programmed.path;
  if (options.executed) executed.position = *options.executed;
  for (size_t p = 0; p < inputs.forces.size(); ++p) {
    PathFile& pass = inputs.passes[p];
    const PathFile& force = inputs.forces[p];
    if (pass.path.has_force())
      throw InputError(pass.source + ": has forces, and --forces names " + force.source +
                       " for them; leave one out");
    try {
      const Path good = without(pass.path, find_bad_samples(executed, pass.path));
      const ForceClock clock = stated_offset
                                   ? ForceClock{*stated_offset, 0}
                                   : fit_force_clock(executed, good, force.path, options.clock);
      Path forced = with_force(executed, pass.path, fit_clock(executed, good, options.clock),
                               force.path, clock);
      const auto first = std::ranges::find(pass.path.time, forced.time[0]) - pass.path.time.begin();
      pass.line = {pass.line.begin() + first, pass.line.begin() + first + forced.samples()};
      pass.path = std::move(forced);
      forces.push_back({force.source, clock});
    } catch (const std::invalid_argument& error) {
      throw InputError(force.source + ": beside " + pass.source + ": " + error.what());
    }
  }
  return forces;
}

Eigen::Matrix3Xd corrected_from_force(app::Command& command, const PathFile& programmed,
                                      const Robot& robot, const MirrorOptions& options) {
  if (!programmed.path.has_force())
    throw InputError(programmed.source +
                     ": --from-force needs the forces of the cut: add fx_n, fy_n and fz_n");
  return app::on_samples_of(programmed, [&] {
    const Eigen::Matrix3Xd deviation = deviation_from_force(
        RobotModel(robot), joint_path(programmed.path, robot.chain), programmed.path.force);
    app::warn_of_forces(command, programmed, deviation, options);
    return correct_from_force(programmed.path, deviation, options);
  });
}

// With the joint angles of the path that ran; those in the file of a correction are the program's.
std::string pass_as_poses(const app::MirrorInputs& inputs, const PathDeviation& deviation) {
  const Path& programmed = inputs.programmed.path;
  const std::optional<Robot>& robot = inputs.robot;
  if (inputs.previous && !robot)
    throw InputError(inputs.previous->source +
                     ": --poses needs the joint angles at which this path ran: give --robot");
  if (!programmed.has_joints() && !robot)
    throw InputError(inputs.programmed.source +
                     ": --poses needs the joint angles of the program: add q1_deg to q6_deg, or "
                     "give --robot");
  constexpr int kBlock = 10;  // samples of the deviation per pose
  const PathFile& run = inputs.previous ? *inputs.previous : inputs.programmed;
  return app::on_samples_of(run, [&] {
    return write_pass_as_poses(programmed,
                               robot ? joint_path(run.path, robot->chain) : programmed.q, deviation,
                               kBlock, robot ? joint_names(robot->chain) : six_axis_names());
  });
}

// What only a measured pass gives.
void write_findings(app::Command& command, const app::MirrorArguments& arguments,
                    const app::MirrorInputs& inputs, MirrorFindings& findings) {
  app::warn_of_gaps(command, inputs.programmed, findings.result);
  app::warn_of_clipping(command, findings.result, findings.options);
  if (command.reports() || !arguments.summary.empty() || arguments.page.is_wanted()) {
    command.progress("describing");
    const std::vector<Path> earlier = without_bad(command, inputs.programmed.path, inputs.earlier);
    try {
      app::on_samples_of(inputs.programmed, [&] {
        describe_passes(findings, inputs.programmed.path, paths(inputs.passes), earlier,
                        inputs.robot);
      });
    } catch (const UnusablePass& error) {
      throw InputError(inputs.earlier[error.pass].source + ": " + error.what());
    }
    if (findings.robot)
      app::warn_of_prediction(command, inputs.passes.front(), *findings.robot);
    else if (findings.force)
      app::warn_of_force_law(command, inputs.passes.front(), *findings.force);
    command.report(mirror_table(findings));
  }
  std::optional<Document> product;
  if (!arguments.summary.empty() || arguments.page.is_wanted())
    product = write_mirror(findings, command.provenance());
  if (!arguments.summary.empty()) write_output(arguments.summary, *product);
  if (!arguments.deviation.empty())
    write_output(arguments.deviation, write_deviation(findings.result.deviation));
  if (!arguments.poses.empty())
    write_output(arguments.poses, pass_as_poses(inputs, findings.result.deviation));
  if (arguments.page.is_wanted())
    app::write_report(command, arguments.page,
                      mirror_page(inputs.programmed.path, findings, inputs.programmed.source,
                                  app::page_head(command, *product, inputs.about)));
}

// No form error that is wanted is as large, and no arm errs so far [m].
constexpr double kLargestGoal = 5e-3;

int run(app::Command& command, const app::MirrorArguments& arguments) {
  MirrorFindings findings;
  findings.options = app::mirror_options(arguments);
  findings.goal = arguments.goal_mm * kMillimetre;
  if (findings.goal > kLargestGoal)
    command.warn(
        fmt::format("--goal-mm {:g}: every arm meets it; is it in um?", arguments.goal_mm));
  app::MirrorInputs inputs = app::read_mirror_inputs(command, arguments);
  if (inputs.previous) findings.options.executed = inputs.previous->path.position;
  findings.forces = add_forces(inputs, findings.options, arguments.force_offset_s);
  for (const PathFile& pass : inputs.passes) {
    findings.files.push_back(pass.source);
    findings.lines.push_back(pass.line);
  }

  command.progress("correcting");
  if (!arguments.from_force)
    findings.result = correct(command, inputs.programmed, inputs.passes, findings.options);
  else
    findings.result.position =
        corrected_from_force(command, inputs.programmed, *inputs.robot, findings.options);
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
  app::MirrorArguments arguments;
  app::add_mirror_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
