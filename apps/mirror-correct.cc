#include <fmt/format.h>

#include <filesystem>

#include "armtrue/io/input_error.h"
#include "armtrue/io/krl.h"
#include "armtrue/io/mirror_io.h"
#include "armtrue/io/output.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/path/mirror.h"
#include "armtrue/report/mirror_report.h"
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

// When the tool was in the material, from the force or, without one, from the deviation.
EngagementRecord engagement(const PathDeviation& deviation) {
  return find_engagement(deviation.time,
                         deviation.force.cols() > 0 ? deviation.force : deviation.normal);
}

// What the force has to do with the deviation; nothing without a force.
std::optional<ForceLaw> force_law(const PathDeviation& deviation, const Path& programmed) {
  if (deviation.force.cols() == 0) return std::nullopt;
  Path on_grid;
  on_grid.time = deviation.time;
  on_grid.position = position_at(programmed, deviation.time);
  ForceRecord record;
  record.deviation = deviation.normal + tangents(on_grid) * deviation.along.asDiagonal();
  record.force = deviation.force;
  record.force_noise = engagement(deviation).noise;
  record.direction = motion_directions(on_grid.position);
  return armtrue::force_law(record);
}

// "auto" leaves the choice to the data.
std::optional<double> number_or_auto(const std::string& text) {
  if (text == "auto") return std::nullopt;
  return std::stod(text);
}

CLI::Validator positive_or_auto() {
  return CLI::Validator(
      [](const std::string& text) {
        if (text == "auto") return std::string();
        return CLI::PositiveNumber(text);
      },
      "NUMBER or auto");
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("mirror-correct",
                       "A programmed path, corrected by the mirror of what was measured across it.",
                       "mirror-correct --programmed path.csv --measured pass.csv > corrected.csv");
  std::string programmed_path, previous_path, summary_path, deviation_path, program_path,
      program_out, report_path;
  std::string cutoff = "1.5625", gain = "auto", points = "turning";
  std::vector<std::string> measured_paths;
  double max_mm = 0, offset = 0;
  MirrorOptions mirror;
  command.add_output();
  CLI::App& options = command.options();
  options
      .add_option("--programmed", programmed_path, "The path as it should be: t_s,x_mm,y_mm,z_mm")
      ->required();
  options
      .add_option("--measured", measured_paths,
                  "One or more recorded passes, each with a clock of its own; - is standard input")
      ->required();
  options.add_option("--previous", previous_path,
                     "The corrected path that these passes ran; the new correction adds to it");
  options.add_option("--order", mirror.order, "Order of the Butterworth filter, each way")
      ->check(CLI::Range(1, 12))
      ->capture_default_str();
  options.add_option("--cut-off", cutoff, "-3 dB of both ways together, Hz; or auto")
      ->check(positive_or_auto())
      ->capture_default_str();
  options
      .add_option("--points", points,
                  "turning: straight between the turning points of the trend; or spline")
      ->check(CLI::IsMember({"turning", "spline"}))
      ->capture_default_str();
  options.add_option("--gain", gain, "Share of the deviation to take off; auto: what is no noise")
      ->check(positive_or_auto())
      ->capture_default_str();
  options.add_option("--max-mm", max_mm, "Longest correction")->check(CLI::PositiveNumber);
  options.add_flag("--fit-frame", mirror.clock.fit_frame,
                   "The instrument's frame is not the program's: fit it too");
  CLI::Option* const offset_option =
      options.add_option("--offset-s", offset,
                         "The instrument's clock is this far ahead of the program's; not fitted");
  CLI::Option* const program_option = options.add_option(
      "--program", program_path, "KUKA program (.src, with its .dat) of the programmed path");
  options
      .add_option("--program-out", program_out,
                  "Write the corrected program here, its .dat beside it [NAME-corrected.src]")
      ->needs(program_option);
  options.add_option("--summary", summary_path, "Write clocks, noise, deviation and forecast here");
  options.add_option("--deviation", deviation_path, "Write the deviation and its trend here");
  options.add_option("--report", report_path, "Write a page with plots (HTML) here");
  return command.run(argc, argv, [&] {
    command.progress("reading");
    const PathFile programmed = command.path(programmed_path, KeepRows::yes);
    std::vector<Path> passes;
    std::vector<std::string> names;
    for (const std::string& path : measured_paths) {
      PathFile pass = command.path(path);
      names.push_back(pass.source);
      passes.push_back(std::move(pass.path));
    }
    if (!previous_path.empty())
      mirror.executed = previous_correction(command.path(previous_path, KeepRows::yes), programmed);
    mirror.cutoff = number_or_auto(cutoff);
    mirror.gain = number_or_auto(gain);
    mirror.points = points == "spline" ? CorrectionPoints::spline : CorrectionPoints::turning;
    if (max_mm > 0) mirror.max = max_mm * kMillimetre;
    if (*offset_option) mirror.clock.offset = offset;
    command.progress("correcting");
    const MirrorResult result = mirror_correct(programmed.path, passes, mirror);
    command.tell(mirror_table(result, names));
    if (!summary_path.empty())
      write_output(summary_path, write_mirror(result, mirror, names, command.provenance()));
    if (!deviation_path.empty()) write_output(deviation_path, write_deviation(result.deviation));
    if (!program_path.empty()) {
      const KrlProgram program = read_krl(program_path);
      const CorrectedKrl corrected = correct_krl(program, programmed.path, result.position);
      for (const std::string& warning : corrected.warnings) command.warn(warning);
      command.tell(program_report(program.src.name, corrected));
      write_program(corrected, program_path, program_out);
    }
    write_output(command.output, write_path_like(programmed, result.position));
    if (!report_path.empty())
      write_output(report_path,
                   mirror_report(programmed.path, result, mirror, engagement(result.deviation),
                                 force_law(result.deviation, programmed.path), names,
                                 "Mirror correction of " + programmed.source));
    return app::kSuccess;
  });
}
