#include <dlfcn.h>
#include <fmt/format.h>

#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/diagnosis/log_check.h"
#include "armtrue/import/import_images.h"
#include "armtrue/import/import_io.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/output.h"
#include "armtrue/io/path_io.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "command_line.h"
#include "import_inputs.h"
#include "path_program.h"
#include "standard_streams.h"

using namespace armtrue;

namespace {

// The library brings a hundred others, so it is loaded here and not with the command.
FindCorners load_corner_finder() {
  void* const library = dlopen(kCornerLibrary, RTLD_NOW);
  void* const function = library ? dlsym(library, kCornerFunction) : nullptr;
  if (!function)
    throw InputError(fmt::format(
        "--images: {}, which finds corners in images, is not there or does not load: OpenCV was "
        "not installed when these commands were built, or is no more; install "
        "libopencv-contrib-dev and build again: apps/set-up commands",
        kCornerLibrary));
  const auto find = reinterpret_cast<decltype(&armtrue_find_corners)>(function);
  return [find](const BoardPattern& pattern, const std::string& file, bool explain) {
    ImageCorners found;
    std::string error;
    find(pattern, file, explain, found, error);
    if (!error.empty()) throw InputError(error);
    return found;
  };
}

ImportedReadings read_images(app::Command& command, const app::ImportArguments& arguments) {
  ImageFolder folder{arguments.images, {}, arguments.camera};
  try {
    folder.pattern = board_pattern(arguments.board);
  } catch (const std::invalid_argument& error) {
    throw app::UsageError(std::string("--board: ") + error.what());
  }
  const FindCorners find = load_corner_finder();
  return import_images(folder, arguments.joints, arguments.import,
                       [&](const BoardPattern& pattern, const std::string& file, bool explain) {
                         command.progress("looking for corners in " + file);
                         return find(pattern, file, explain);
                       });
}

// What calibrate would say of units and columns; the table is written all the same.
std::vector<std::string> doubts_of(const ImportedReadings& readings,
                                   const std::optional<Robot>& robot) {
  const Campaign& campaign = readings.campaign;
  if (!robot || campaign.position.empty()) return check_units(campaign, readings.joints);
  std::vector<std::string> doubts = check_travel(*robot, campaign).errors;
  if (doubts.empty()) doubts = diagnose(*robot, campaign);
  return doubts;
}

int run_pass(app::Command& command, const app::ImportArguments& arguments) {
  const ImportedPass pass = import_pass(command.input, arguments.import);
  write_output(command.output, write_path(pass.path, pass.joints));
  if (!command.quiet) app::print_error(pass.mapping);
  app::warn_of_all(command, pass.warnings);
  return app::kSuccess;
}

int run_program(app::Command& command, const app::ImportArguments& arguments) {
  const ProgramSpeed speed{arguments.feed_mm_s * kMillimetre, arguments.acceleration_m_s2,
                           arguments.period_ms * 1e-3};
  const TimedProgram program =
      timed_path(app::read_original_program(command, arguments.program, arguments.with,
                                            "give the original program"),
                 speed);
  app::warn_of_all(command, program.warnings);
  const Path& path = program.path;
  command.tell(fmt::format("{}: {:.1f} mm in {:.2f} s\n", arguments.program,
                           arc_length(path)[path.samples() - 1] / kMillimetre,
                           path.time[path.samples() - 1] - 2 * speed.standstill));
  write_output(command.output, write_path(path, six_axis_names()));
  return app::kSuccess;
}

int run(app::Command& command, app::ImportArguments arguments) {
  const bool has_images = !arguments.images.empty();
  app::complete(command, arguments);
  command.progress("reading");
  if (!arguments.program.empty()) return run_program(command, arguments);
  if (arguments.is_pass) return run_pass(command, arguments);
  const ImportedReadings readings =
      has_images ? read_images(command, arguments)
      : arguments.points.empty()
          ? import_readings(command.input, arguments.import)
          : import_readings(arguments.points, arguments.joints, arguments.import);
  write_output(command.output, write_campaign(readings.campaign, readings.joints));
  if (!command.quiet) app::print_error(readings.mapping);
  app::warn_of_all(command, readings.warnings);
  for (const std::string& doubt : doubts_of(readings, arguments.import.robot))
    command.warn((command.output == "-" ? "" : command.output + ": ") + doubt);
  return app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("import-readings",
                       "Exported tables to measured poses, and to passes for mirror-correct.",
                       "import-readings --points tracker.csv --joints controller.csv "
                       "--angle-unit deg -o measured.csv");
  app::ImportArguments arguments;
  app::add_import_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
