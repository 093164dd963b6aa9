#include "certificate_inputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "columns.h"
#include "option_text.h"
#include "pass_warnings.h"

namespace armtrue::app {
namespace {

Check five_names() {
  return {"", [](const std::string& text) {
            std::vector<std::string> names = split_list(text);
            std::ranges::sort(names);
            if (names.size() != 5)
              return "'" + text + "' must be five names of poses, such as P1,P2,P3,P4,P5";
            return std::ranges::adjacent_find(names) == names.end()
                       ? ""
                       : "'" + text + "' names a pose twice; the cube has five";
          }};
}

// What the links are fitted to must not judge them.
Check set_up_only() {
  return {"", [](const std::string& text) {
            for (const std::string& name : split_list(text))
              if (const Owner owner = Parameter(name).owner;
                  owner != Owner::base && owner != Owner::tool)
                return "'" + name +
                       "' is no part of the set-up: fitted to the readings that judge the arm, it "
                       "takes up their errors; give base,tool, or one of them";
            return std::string();
          }};
}

}  // namespace

void add_certificate_options(Command& command, CertificateArguments& arguments) {
  command.add_input("Measured poses, each visited several times");
  command.add_output(ProductKind::document);
  command.add_new_sessions();
  Option robot = command.file("--robot", arguments.robot,
                              "The robot whose predictions are the commanded poses; without it "
                              "--path alone is certified");
  command
      .file("--about", arguments.about,
            "Robot, operator, date, instrument and its errors (armtrue-about/1)")
      .required();
  command
      .option("--tolerance-mm", arguments.tolerance_mm,
              "Largest AP allowed; exit with 3 unless AP and its uncertainty stay below it")
      .check(above_zero())
      .needs(robot);
  command
      .option("--cube", arguments.cube,
              "Names of the five poses of the standard's cube [P1,P2,P3,P4,P5, if all are there]")
      .check(five_names())
      .needs(robot);
  command
      .option("--refit", arguments.refit,
              "Fit these first, such as base,tool for a robot in another set-up")
      .check(set_up_only())
      .needs(robot);
  Option path =
      command.file("--path", arguments.path,
                   "Commanded path: path accuracy of its recorded passes is certified too");
  Option pass = command
                    .file("--pass", arguments.passes,
                          "A pass of the path as the instrument recorded it, with its own "
                          "clock; may be given several times")
                    .one_each()
                    .needs(path);
  path.needs(pass);
  command
      .flag("--fit-frame", arguments.fit_frame,
            "The instrument's frame is not that of the path: fit it, one for all passes")
      .needs(path);
  command.add_output("--page", arguments.page, "Write a page to print and to sign (HTML) here");
  command.file("--against", arguments.against,
               "Compare with this older certificate of the same robot");
  command.add_columns(kMeasuredPoseColumns);
}

PathFigures certified_path(Command& command, const CertificateArguments& arguments) {
  const PathFile commanded = command.read_path(arguments.path);
  refuse_corrected(commanded,
                   "the path as it should be as --path: AT is the distance of the tool from "
                   "that, not from what the controller was told");
  std::vector<PathFile> passes;
  for (const std::string& file : arguments.passes) passes.push_back(command.read_path(file));
  std::vector<const PathFile*> all{&commanded};
  for (const PathFile& pass : passes) all.push_back(&pass);
  for (const PathFile& pass : passes) refuse_corrected(pass, "what the instrument recorded");
  refuse_the_same(command, all);
  refuse_copies(passes);
  warn_of_interpolated(command, passes);
  warn_of_computed(command, commanded, passes);
  warn_of_copied(command, commanded, passes);
  std::vector<Path> paths;
  for (const PathFile& pass : passes) paths.push_back(pass.path);
  ClockOptions clock;
  clock.fit_frame = arguments.fit_frame;
  const PathFigures figures = about_file(commanded.source, [&] {
    try {
      return path_figures(commanded.path, paths, clock);
    } catch (const UnusablePass& error) {
      throw InputError(passes[error.pass].source + ": " + error.what());
    }
  });
  warn_of_certified(command, commanded, passes, figures.clocks, clock);
  for (const PathFile& pass : passes)
    warn_of_bad_kept(command, pass, find_bad_samples(commanded.path, pass.path));
  if (!figures.is_whole())
    command.warn(
        fmt::format("{}: all passes meet {} of its {} planes; AT and RT do not hold for the rest. "
                    "Record passes of the whole path at the programmed speed",
                    commanded.source, figures.planes, figures.of_path));
  return figures;
}

}  // namespace armtrue::app
