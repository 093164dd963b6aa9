#include <fmt/format.h>

#include <filesystem>

#include "armtrue/io/mirror_io.h"
#include "armtrue/io/output.h"
#include "armtrue/io/program_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/path/joint_path.h"
#include "armtrue/path/mirror/mirror.h"
#include "armtrue/path/samples/bad_samples.h"
#include "armtrue/programs/krl.h"
#include "armtrue/report/mirror_report.h"
#include "armtrue/text/input_error.h"
#include "command_line.h"

using namespace armtrue;

namespace {

// An earlier correction has to be one of this program: the same samples, other positions.
Eigen::Matrix3Xd previous_correction(const PathFile& previous, const PathFile& programmed) {
  if (previous.path.time != programmed.path.time)
    throw InputError(previous.source + ": its times are not those of " + programmed.source +
                     "; --previous takes what mirror-correct wrote for the same program");
  return previous.path.position;
}

std::string program_report(const std::string& name, const CorrectedKrl& corrected) {
  return fmt::format("{}: {} points corrected, {} moves inserted, {} moves left alone\n", name,
                     corrected.corrected, corrected.inserted, corrected.left_alone);
}

// The .dat first: a .src that calls for points which are not there yet would be worse.
void write_program(const CorrectedKrl& corrected, const std::filesystem::path& program,
                   std::filesystem::path out) {
  if (out.empty())
    out = std::filesystem::path(program).replace_filename(program.stem().string() + "-corrected" +
                                                          program.extension().string());
  if (corrected.dat)
    write_output(std::filesystem::path(out).replace_extension(".dat"), *corrected.dat);
  write_output(out, corrected.src);
}

std::vector<PathFile> read_passes(app::Command& command, const std::vector<std::string>& files) {
  std::vector<PathFile> passes;
  for (const std::string& file : files) passes.push_back(command.path(file));
  return passes;
}

// The same record twice passes for two passes that agree, and the program for one that is right.
void warn_of_the_same(const app::Command& command, const std::vector<const PathFile*>& files) {
  for (size_t i = 0; i < files.size(); ++i)
    for (size_t k = 0; k < i; ++k)
      if (files[i]->sha256 == files[k]->sha256)
        command.warn(files[i]->source + " holds the same as " + files[k]->source +
                     " and is taken for a pass of its own; name the program and each record once");
}

std::vector<Path> paths(const std::vector<PathFile>& files) {
  std::vector<Path> all;
  for (const PathFile& file : files) all.push_back(file.path);
  return all;
}

// How many, where and how far off.
std::string describe_bad(const PathFile& pass, const std::vector<BadSample>& bad) {
  constexpr size_t kNamed = 5;
  std::string text = fmt::format(
      "{}:{}: {} of {} samples are no readings of the tool, which does not move so:", pass.source,
      pass.line[static_cast<size_t>(bad.front().sample)], bad.size(), pass.path.samples());
  for (size_t i = 0; i < std::min(bad.size(), kNamed); ++i)
    text += fmt::format("{} line {} ({:.4g} mm off)", i > 0 ? "," : "",
                        pass.line[static_cast<size_t>(bad[i].sample)], bad[i].off / kMillimetre);
  return text + (bad.size() > kNamed ? ", ..." : "");
}

void warn_of_bad(const app::Command& command, const PathFile& pass,
                 const std::vector<BadSample>& bad) {
  if (!bad.empty())
    command.warn(describe_bad(pass, bad) + "; left out; check the line of sight of the instrument");
}

[[noreturn]] void refuse(const PathFile& pass, const std::vector<BadSample>& bad) {
  throw InputError(describe_bad(pass, bad) +
                   "; that is more than a tenth: measure the pass again with a clear line of "
                   "sight, or empty the position of the rows without one");
}

MirrorResult correct(const app::Command& command, const Path& programmed,
                     const std::vector<PathFile>& passes, const MirrorOptions& options) {
  try {
    MirrorResult result = mirror_correct(programmed, paths(passes), options);
    for (size_t p = 0; p < passes.size(); ++p)
      warn_of_bad(command, passes[p], result.passes[p].bad);
    return result;
  } catch (const TooManyBadSamples& error) {
    refuse(passes[error.pass], error.bad);
  }
}

// Passes that are only compared with.
std::vector<Path> without_bad(const app::Command& command, const Path& programmed,
                              const std::vector<PathFile>& passes) {
  std::vector<Path> good;
  for (const PathFile& pass : passes) {
    const std::vector<BadSample> bad = find_bad_samples(programmed, pass.path);
    if (too_many(bad, pass.path)) refuse(pass, bad);
    warn_of_bad(command, pass, bad);
    good.push_back(without(pass.path, bad));
  }
  return good;
}

// What the record does not show is not corrected, or only guessed.
void warn_of_gaps(const app::Command& command, const MirrorResult& result) {
  if (result.unrecorded > 0)
    command.warn(fmt::format(
        "{} samples in motion lie before or after the record and are not corrected; record from "
        "before the tool moves until it stands again",
        result.unrecorded));
  for (const Pass& pass : result.passes)
    if (pass.longest_gap > 0.5 / result.cutoff)
      command.warn(fmt::format(
          "the record has a gap of {:.2f} s, longer than the correction can follow: there it is "
          "only interpolated",
          pass.longest_gap));
}

// In the clock of the program.
std::vector<Path> registered(const std::vector<Path>& passes, const std::vector<ClockFit>& clocks) {
  std::vector<Path> in_time;
  for (size_t p = 0; p < passes.size(); ++p) in_time.push_back(registered(passes[p], clocks[p]));
  return in_time;
}

// What the passes show beside the correction.
void describe(MirrorFindings& findings, const PathFile& program, const std::vector<Path>& passes,
              const std::vector<Path>& earlier, const std::optional<Robot>& robot) {
  const Path& programmed = program.path;
  std::vector<ClockFit> clocks, earlier_clocks;
  std::vector<Path> good;
  for (size_t p = 0; p < passes.size(); ++p) {
    clocks.push_back(findings.result.passes[p].clock);
    good.push_back(without(passes[p], findings.result.passes[p].bad));
  }
  for (const Path& pass : earlier)
    earlier_clocks.push_back(fit_clock(programmed, pass, findings.options.clock));
  findings.accuracy = pass_accuracy(programmed, registered(good, clocks));
  if (!earlier.empty())
    findings.before = pass_accuracy(programmed, registered(earlier, earlier_clocks));
  const PathDeviation& deviation = findings.result.deviation;
  findings.force =
      force_law(deviation, programmed, position_at(programmed, deviation.time),
                LowPass(findings.options.order, findings.result.cutoff, 1 / deviation.period));
  if (robot)
    findings.robot = app::on_samples_of(
        program, [&] { return measured_on_predicted(deviation, programmed, *robot); });
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
  constexpr int kBlock = 10;  // samples of the instrument to a pose
  return app::on_samples_of(programmed, [&] {
    return write_pass_as_poses(
        programmed.path, robot ? joint_path(programmed.path, robot->chain) : programmed.path.q,
        deviation, kBlock);
  });
}

// "auto" leaves the choice to the data.
std::optional<double> number_or_auto(const std::string& text) {
  if (text == "auto") return std::nullopt;
  return std::stod(text);
}

CLI::Validator positive_or_auto() {
  return CLI::Validator(
      [check = app::above_zero()](std::string& text) {
        return text == "auto" ? std::string() : check(text);
      },
      "NUMBER or auto");
}

CLI::Validator gain_or_auto() {
  return CLI::Validator(
      [positive = positive_or_auto()](std::string& text) {
        const std::string wrong = positive(text);
        if (!wrong.empty() || text == "auto" || std::stod(text) < 2) return wrong;
        return "'" + text +
               "' must be below 2: the correction would put the tool at least as far off on the "
               "other side, and every further pass farther; 1 takes off the whole deviation";
      },
      "NUMBER or auto");
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("mirror-correct",
                       "A programmed path, corrected by the mirror of what was measured across it.",
                       "mirror-correct --programmed path.csv --measured pass.csv > corrected.csv");
  std::string programmed_path, previous_path, summary_path, deviation_path, program_path,
      program_out, robot_path, poses_path, report_path;
  std::string cutoff = "1.5625", gain = "auto", points = "turning";
  std::vector<std::string> measured_paths, before_paths;
  double max_mm = 0, offset = 0;
  KrlCorrectionOptions krl;
  double spacing_mm = krl.spacing / kMillimetre;
  MirrorOptions mirror;
  command.add_output();
  CLI::App& options = command.options();
  options
      .add_option("--programmed", programmed_path, "The path as it should be: t_s,x_mm,y_mm,z_mm")
      ->required();
  CLI::Option_group* const source = options.add_option_group("Deviation");
  source->add_option(
      "--measured", measured_paths,
      "One or more recorded passes, each with a clock of its own; - is standard input");
  bool from_force = false;
  CLI::Option* const force_option = source->add_flag(
      "--from-force", from_force,
      "No pass was measured: what the forces in the program's file make --robot give way");
  source->require_option(1);
  CLI::Option* const robot_option = options.add_option(
      "--robot", robot_path,
      "Robot file with effects that a force drives: its prediction is compared with the pass");
  force_option->needs(robot_option);
  // What only a measured pass gives.
  const auto of_passes = [&](CLI::Option* option) { option->excludes(force_option); };
  of_passes(
      options.add_flag("--engaged-only", mirror.engaged_only, "Correct only where the tool cuts"));
  of_passes(options.add_option("--before", before_paths,
                               "Recorded passes before the correction, to tell what it gained"));
  of_passes(command.add_output("--poses", poses_path,
                               "Write the pass as measured poses for close-loop here; the joint "
                               "angles are those of the program's file or, with --robot, "
                               "calculated"));
  of_passes(options.add_option(
      "--previous", previous_path,
      "The corrected path that these passes ran; the new correction adds to it"));
  options.add_option("--order", mirror.order, "Order of the Butterworth filter, each way")
      ->check(CLI::Range(1, 12))
      ->capture_default_str();
  options.add_option("--cut-off", cutoff, "-3 dB of both ways together, Hz; or auto")
      ->check(positive_or_auto())
      ->capture_default_str();
  of_passes(options
                .add_option("--points", points,
                            "turning: straight between the turning points of the trend; or spline")
                ->check(CLI::IsMember({"turning", "spline"}))
                ->capture_default_str());
  options
      .add_option("--gain", gain,
                  "Share of the deviation to take off, below 2; auto: what is no noise")
      ->check(gain_or_auto())
      ->capture_default_str();
  options.add_option("--max-mm", max_mm, "Longest correction")->check(app::above_zero());
  CLI::Option* const frame_option =
      options.add_flag("--fit-frame", mirror.clock.fit_frame,
                       "The instrument's frame is not the program's: fit it too");
  of_passes(frame_option);
  CLI::Option* const offset_option =
      options.add_option("--offset-s", offset,
                         "The instrument's clock is this far ahead of the program's; not fitted");
  of_passes(offset_option);
  offset_option->excludes(frame_option);
  CLI::Option* const program_option = options.add_option(
      "--program", program_path, "KUKA program (.src, with its .dat) of the programmed path");
  command
      .add_output("--program-out", program_out,
                  "Write the corrected program here, its .dat beside it [NAME-corrected.src]")
      ->needs(program_option);
  options
      .add_option("--spacing-mm", spacing_mm,
                  "Least distance of the points that are inserted into the program")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str()
      ->needs(program_option);
  of_passes(command.add_output("--summary", summary_path,
                               "Write clocks, noise, deviation and forecast here"));
  of_passes(
      command.add_output("--deviation", deviation_path, "Write the deviation and its trend here"));
  of_passes(command.add_output("--report", report_path,
                               "Write a page with plots (HTML) of the measured passes here"));
  return command.run(argc, argv, [&] {
    command.progress("reading");
    const PathFile programmed = command.path(programmed_path, KeepRows::yes);
    std::optional<Robot> robot;
    if (!robot_path.empty()) robot = command.robot(robot_path).robot;
    mirror.cutoff = number_or_auto(cutoff);
    mirror.gain = number_or_auto(gain);
    mirror.points = points == "spline" ? CorrectionPoints::spline : CorrectionPoints::turning;
    if (max_mm > 0) mirror.max = max_mm * kMillimetre;
    if (*offset_option) mirror.clock.offset = offset;
    MirrorFindings findings;
    findings.options = mirror;
    const std::vector<PathFile> passes = read_passes(command, measured_paths);
    const std::vector<PathFile> earlier = read_passes(command, before_paths);
    std::vector<const PathFile*> all = {&programmed};
    for (const PathFile& pass : passes) all.push_back(&pass);
    for (const PathFile& pass : earlier) all.push_back(&pass);
    warn_of_the_same(command, all);
    for (const PathFile& pass : passes) {
      findings.files.push_back(pass.source);
      findings.lines.push_back(pass.line);
    }
    if (!previous_path.empty())
      findings.options.executed =
          previous_correction(command.path(previous_path, KeepRows::yes), programmed);
    command.progress("correcting");
    if (!from_force) findings.result = correct(command, programmed.path, passes, findings.options);
    const Eigen::Matrix3Xd corrected =
        from_force ? corrected_from_force(programmed, *robot, mirror) : findings.result.position;
    // The products first: nothing that goes wrong with the rest shall keep them back.
    if (!program_path.empty()) {
      krl.spacing = spacing_mm * kMillimetre;
      const KrlProgram program = read_krl(program_path);
      const CorrectedKrl rewritten = correct_krl(program, programmed.path, corrected, krl);
      for (const std::string& warning : rewritten.warnings) command.warn(warning);
      command.tell(program_report(program.src.name, rewritten));
      write_program(rewritten, program_path, program_out);
    }
    write_output(command.output, write_path_like(programmed, corrected));
    if (from_force) return app::kSuccess;

    warn_of_gaps(command, findings.result);
    if (command.verbose || !summary_path.empty() || !report_path.empty()) {
      command.progress("describing");
      describe(findings, programmed, paths(passes), without_bad(command, programmed.path, earlier),
               robot);
      command.tell(mirror_table(findings));
    }
    if (!summary_path.empty())
      write_output(summary_path, write_mirror(findings, command.provenance()));
    if (!deviation_path.empty())
      write_output(deviation_path, write_deviation(findings.result.deviation));
    if (!poses_path.empty())
      write_output(poses_path, pass_as_poses(programmed, robot, findings.result.deviation));
    if (!report_path.empty())
      write_output(report_path,
                   mirror_report(programmed.path, findings.result, findings.options, findings.force,
                                 findings.files, "Mirror correction of " + programmed.source));
    return app::kSuccess;
  });
}
