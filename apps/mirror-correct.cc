#include "armtrue/io/input_error.h"
#include "armtrue/io/mirror_io.h"
#include "armtrue/io/output.h"
#include "armtrue/io/path_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/path/mirror.h"
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
  std::string programmed_path, previous_path, summary_path, deviation_path;
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
  options.add_option("--summary", summary_path, "Write clocks, noise, deviation and forecast here");
  options.add_option("--deviation", deviation_path, "Write the deviation and its trend here");
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
    write_output(command.output, write_path_like(programmed, result.position));
    return app::kSuccess;
  });
}
