#include <fmt/format.h>

#include <algorithm>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/doubts.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/certification/certificate.h"
#include "armtrue/certification/doubts.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/certificate_io.h"
#include "armtrue/io/source.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/report/certificate_page.h"
#include "armtrue/text/input_error.h"
#include "columns.h"
#include "command_line.h"
#include "option_text.h"
#include "pass_warnings.h"

using namespace armtrue;

namespace {

struct Arguments {
  std::string robot, about, refit, cube, page, against, path;
  std::vector<std::string> passes;
  bool fit_frame = false;
  std::optional<double> tolerance_mm;
};

app::Check five_names() {
  return {"", [](const std::string& text) {
            std::vector<std::string> names = app::split_list(text);
            std::ranges::sort(names);
            if (names.size() != 5)
              return "'" + text + "' must be five names of poses, such as P1,P2,P3,P4,P5";
            return std::ranges::adjacent_find(names) == names.end()
                       ? ""
                       : "'" + text + "' names a pose twice; the cube has five";
          }};
}

// What the links are fitted to must not judge them.
app::Check set_up_only() {
  return {"", [](const std::string& text) {
            for (const std::string& name : app::split_list(text))
              if (const Owner owner = Parameter(name).owner;
                  owner != Owner::base && owner != Owner::tool)
                return "'" + name +
                       "' is no part of the set-up: fitted to the readings that judge the arm, it "
                       "takes up their errors; give base,tool, or one of them";
            return std::string();
          }};
}

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("Measured poses, each visited several times");
  command.add_output(app::ProductKind::document);
  command.add_new_sessions();
  command.file("--robot", arguments.robot, "The robot whose predictions are the commanded poses")
      .required();
  command
      .file("--about", arguments.about,
            "Robot, operator, date, instrument and its errors (armtrue-about/1)")
      .required();
  command
      .option("--tolerance-mm", arguments.tolerance_mm,
              "Largest AP allowed; exit with 3 unless AP and its uncertainty stay below it")
      .check(app::above_zero());
  command
      .option("--cube", arguments.cube,
              "Names of the five poses of the standard's cube [P1,P2,P3,P4,P5, if all are there]")
      .check(five_names());
  command
      .option("--refit", arguments.refit,
              "Fit these first, such as base,tool for a robot in another set-up")
      .check(set_up_only());
  app::Option path =
      command.file("--path", arguments.path,
                   "Commanded path: path accuracy of its recorded passes is certified too");
  app::Option pass = command
                         .file("--pass", arguments.passes,
                               "A pass of the path as the instrument recorded it, with its own "
                               "clock; may be given several times")
                         .one_each()
                         .needs(path);
  path.needs(pass);
  command
      .flag("--fit-frame", arguments.fit_frame,
            "The instrument's frame is not that of the path: fit it to each pass")
      .needs(path);
  command.add_output("--page", arguments.page, "Write a page to print and to sign (HTML) here");
  command.file("--against", arguments.against,
               "Compare with this older certificate of the same robot");
  command.add_columns(app::kMeasuredPoseColumns);
}

// Whether the robot file names these readings as an input of its calibration. Standard input and
// pipes cannot be read twice.
bool knows_readings(const std::string& robot, const Provenance& provenance) {
  if (robot == "-" || is_device_or_pipe(robot)) return false;
  return Source(robot).read_all().find(provenance.inputs.back().second) != std::string::npos;
}

// Right after the readings have been read.
void warn_of_criteria(app::Command& command, const Arguments& arguments) {
  constexpr double kFarthest = 20;  // mm: no arm, nominal or not, is as far off
  if (arguments.tolerance_mm && *arguments.tolerance_mm > kFarthest)
    command.warn(
        fmt::format("--tolerance-mm {:g}: no arm is {:g} mm off, so that every one passes: is it in "
                    "um? Give mm",
                    *arguments.tolerance_mm, kFarthest));
  if (!arguments.against.empty() && knows_readings(arguments.against, command.provenance()))
    command.warn(arguments.against +
                 ": is the certificate of these same readings, which show no change; give that of "
                 "earlier ones");
}

// Runs `work`, and adds the name of the file to its errors.
template <typename Work>
auto about_file(const std::string& file, const Work& work) {
  try {
    return work();
  } catch (const std::invalid_argument& error) {
    throw InputError(file + ": " + error.what());
  }
}

std::optional<PathFigures> path_figures_of(app::Command& command, const Arguments& arguments) {
  if (arguments.path.empty()) return std::nullopt;
  const PathFile commanded = command.read_path(arguments.path);
  app::refuse_corrected(commanded,
                        "the path as it should be as --path: AT is the distance of the tool from "
                        "that, not from what the controller was told");
  std::vector<PathFile> passes;
  for (const std::string& file : arguments.passes) passes.push_back(command.read_path(file));
  std::vector<const PathFile*> all{&commanded};
  for (const PathFile& pass : passes) all.push_back(&pass);
  for (const PathFile& pass : passes) app::refuse_corrected(pass, "what the instrument recorded");
  app::warn_of_the_same(command, all);
  app::warn_of_computed(command, commanded, passes);
  app::warn_of_copied(command, commanded, passes);
  std::vector<Path> paths;
  for (const PathFile& pass : passes) paths.push_back(pass.path);
  ClockOptions clock;
  clock.fit_frame = arguments.fit_frame;
  const PathFigures figures =
      about_file(commanded.source, [&] { return path_figures(commanded.path, paths, clock); });
  for (const PathFile& pass : passes)
    app::warn_of_bad_kept(command, pass, find_bad_samples(commanded.path, pass.path));
  if (!figures.is_whole())
    command.warn(
        fmt::format("{}: all passes meet {} of its {} planes; AT and RT do not hold for the rest. "
                    "Record passes of the whole path at the programmed speed",
                    commanded.source, figures.planes, figures.of_path));
  return figures;
}

int conclude(app::Command& command, const Certificate& certificate) {
  const std::string figures =
      fmt::format("AP {:.4g} mm, its uncertainty {:.4g} mm (k = {:.4g}), RP {:.4g} mm",
                  certificate.all.ap.value / kMillimetre, certificate.budget.expanded / kMillimetre,
                  certificate.budget.k, certificate.all.rp.value / kMillimetre);
  for (const std::string& note : certificate.notes) command.tell(note + "\n");
  if (certificate.path)
    command.report(fmt::format(
        "AT {:.4g} mm, its uncertainty {:.4g} mm{}\n", certificate.path->at / kMillimetre,
        certificate.path_budget->expanded / kMillimetre,
        certificate.path->rt ? fmt::format(", RT {:.4g} mm", *certificate.path->rt / kMillimetre)
                             : ""));
  if (!certificate.decision || *certificate.decision == Decision::pass) {
    command.report(figures + "\n");
    return app::kSuccess;
  }
  command.warn(fmt::format("{}: tolerance {:g} mm, {}", decision_name(*certificate.decision),
                           *certificate.tolerance / kMillimetre, figures));
  return app::kNotReached;
}

int run(app::Command& command, const Arguments& arguments) {
  const RobotFile file = command.read_robot(arguments.robot);
  Robot robot = file.robot;
  const About about = command.read_about(arguments.about);
  std::optional<CertifiedValues> before;
  if (!arguments.against.empty()) before = command.read_certificate(arguments.against);
  const Campaign campaign = command.read_campaign(command.input, robot);
  if (campaign.has_pixels())
    throw InputError(campaign.source +
                     ": a certificate is of points that an instrument read, not of images; give "
                     "those, or use evaluate-poses");
  app::refuse_mistakes(command, robot, campaign);
  warn_of_criteria(command, arguments);
  CertificateOptions options;
  options.points_look_computed = command.warn_if_computed(robot, campaign);
  options.cube = app::split_list(arguments.cube);
  options.refitted = arguments.refit;
  options.robot_knows_readings = knows_readings(arguments.robot, command.provenance());
  if (arguments.tolerance_mm) options.tolerance = *arguments.tolerance_mm * kMillimetre;
  options.seen = seen_poses(file.training, campaign);
  if (options.robot_knows_readings)
    command.warn(arguments.robot + ": was made from " + campaign.source +
                 ": not all poses are held out; measure poses that the calibration did not use");
  else
    command.warn_of_training(file, campaign, "AP is too small");
  if (arguments.refit.empty()) {
    app::require_sessions(robot, campaign);
  } else {
    command.progress("refitting " + arguments.refit);
    app::warn_of_all(command, {hidden_by_refit(app::split_list(arguments.refit), robot, campaign)});
    robot = refit_set_up(robot, campaign, app::split_list(arguments.refit));
  }
  options.path = path_figures_of(command, arguments);
  const Certificate certificate = about_file(campaign.source, [&] {
    return certify(robot, campaign, evaluate(robot, campaign), about, options);
  });
  std::optional<Comparison> comparison;
  if (before)
    comparison =
        about_file(arguments.against, [&] { return compare(*before, values_of(certificate)); });
  for (const std::string& doubt : certificate.doubts)
    command.warn(campaign.source + ": " + doubt);
  for (const std::string& doubt : doubts_of(about)) command.warn(arguments.about + ": " + doubt);
  const Provenance provenance = command.provenance();
  std::vector<Product> products;
  if (!arguments.page.empty())
    products.push_back(
        {arguments.page,
         certificate_page(certificate, comparison,
                          {provenance.command, provenance.version, provenance.inputs, {}})});
  products.push_back({command.output, write_certificate(certificate, comparison, provenance)});
  write_outputs(products);
  return conclude(command, certificate);
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command(
      "certify",
      "Accuracy and repeatability of poses and paths after ISO 9283, with a page to sign.",
      "certify --robot closed.yaml --about about.yaml --tolerance-mm 0.5 visits.csv -o cert.yaml "
      "--page cert.html");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
