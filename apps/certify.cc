#include <fmt/format.h>

#include "armtrue/calibration/doubts.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/certification/certificate.h"
#include "armtrue/certification/doubts.h"
#include "armtrue/certification/stray_visits.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/certificate_io.h"
#include "armtrue/io/source.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/report/certificate_page.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "certificate_inputs.h"
#include "option_text.h"

using namespace armtrue;

namespace {

// Whether the robot file names these readings as an input of its calibration. Standard input and
// pipes cannot be read twice.
bool knows_readings(const std::string& robot, const Provenance& provenance) {
  if (robot == "-" || is_device_or_pipe(robot)) return false;
  return Source(robot).read_all().find(provenance.inputs.back().second) != std::string::npos;
}

// Right after the readings have been read.
void warn_of_criteria(app::Command& command, const app::CertificateArguments& arguments) {
  constexpr double kFarthest = 20;  // mm: no arm, nominal or not, is as far off
  if (arguments.tolerance_mm && *arguments.tolerance_mm > kFarthest)
    command.warn(fmt::format(
        "--tolerance-mm {:g}: no arm is {:g} mm off, so that every one passes: is it in "
        "um? Give mm",
        *arguments.tolerance_mm, kFarthest));
  if (!arguments.against.empty() && knows_readings(arguments.against, command.provenance()))
    command.warn(arguments.against +
                 ": is the certificate of these same readings, which show no change; give that of "
                 "earlier ones");
}

int conclude(app::Command& command, const Certificate& certificate) {
  const auto mm = [](double value, double expanded) -> std::string {
    return fixed_text(value / kMillimetre,
                      decimals_of_figure(value / kMillimetre, expanded / kMillimetre));
  };
  for (const std::string& note : certificate.notes) command.tell(note + "\n");
  if (certificate.path) {
    const PathFigures& path = *certificate.path;
    const double of_at = certificate.path_budget->expanded;
    command.report(fmt::format(
        "AT {} mm, its uncertainty {} mm{}\n", mm(path.at, of_at), mm(of_at, of_at),
        path.rt ? ", RT " + mm(*path.rt, path.rt_expanded().value_or(of_at)) + " mm" : ""));
  }
  if (!certificate.has_poses()) return app::kSuccess;
  const double expanded = certificate.budget.expanded;
  const int decimals = decimals_shown(certificate);
  const std::string figures =
      fmt::format("{}AP {} mm, its uncertainty {} mm (k = {}), RP {} mm",
                  certificate.decision
                      ? fmt::format("{}: tolerance {} mm, ", decision_name(*certificate.decision),
                                    number_text(*certificate.tolerance, kMillimetre))
                      : "",
                  fixed_text(certificate.all.ap.value / kMillimetre, decimals),
                  fixed_text(expanded / kMillimetre, decimals), rounded(certificate.budget.k),
                  mm(certificate.all.rp.value, certificate.all.rp_expanded().value_or(expanded)));
  if (!certificate.decision || *certificate.decision == Decision::pass) {
    command.report(figures + "\n");
    return app::kSuccess;
  }
  command.warn(figures);
  return app::kNotReached;
}

Certificate certificate_of_poses(app::Command& command, const app::CertificateArguments& arguments,
                                 const RobotFile& file, const About& about) {
  Robot robot = file.robot;
  const Campaign campaign = command.read_campaign(command.input, robot, app::Command::Copies::keep);
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
    const std::vector<std::string> refit = app::parameters_of("--refit", arguments.refit, robot);
    options.hidden = hidden_by_refit(refit, robot, campaign);
    app::warn_of_all(command, {options.hidden.words});
    robot = refit_to_sound(robot, campaign, refit);
  }
  if (!arguments.path.empty()) options.path = app::certified_path(command, arguments);
  const Evaluation evaluation = evaluate(robot, campaign);
  app::warn_of_all(command, {contradiction_of_uncertainty(robot, campaign, evaluation)});
  Certificate certificate = app::about_file(
      campaign.source, [&] { return certify(robot, campaign, evaluation, about, options); });
  for (const std::string& doubt : certificate.doubts) command.warn(campaign.source + ": " + doubt);
  return certificate;
}

Certificate certificate_of_path(app::Command& command, const app::CertificateArguments& arguments,
                                const About& about) {
  if (command.input != "-")
    throw app::UsageError("'" + command.input +
                          "': poses need --robot, whose predictions are the commanded poses");
  return certify_path(about, app::certified_path(command, arguments));
}

int run(app::Command& command, const app::CertificateArguments& arguments) {
  if (arguments.robot.empty() && arguments.path.empty())
    throw app::UsageError("give --robot and visited poses, or --path and --pass, or all of them");
  std::optional<RobotFile> file;
  if (!arguments.robot.empty()) file = command.read_robot(arguments.robot);
  const About about = command.read_about(arguments.about);
  std::optional<CertifiedValues> before;
  if (!arguments.against.empty()) before = command.read_certificate(arguments.against);
  const Certificate certificate = file ? certificate_of_poses(command, arguments, *file, about)
                                       : certificate_of_path(command, arguments, about);
  if (before && before->date > about.date)
    command.warn(fmt::format(
        "{}: is of {}, younger than these readings of {} ({}): before and now look exchanged; give "
        "the older certificate to --against, or correct the date",
        arguments.against, before->date, about.date, arguments.about));
  std::optional<Comparison> comparison;
  if (before)
    comparison = app::about_file(arguments.against,
                                 [&] { return compare(*before, values_of(certificate)); });
  for (const std::string& doubt : doubts_of(about)) command.warn(arguments.about + ": " + doubt);
  const auto warn_of_type = [&](const std::string& source, const std::string& type) {
    const std::string doubt = file ? doubt_of_type(type, certificate.robot) : "";
    if (!doubt.empty()) command.warn(source + ": " + doubt);
  };
  warn_of_type(arguments.about, about.type);
  if (before) warn_of_type(arguments.against, before->type);
  if (const std::string doubt = comparison ? doubt_of_poses(*comparison) : ""; !doubt.empty())
    command.warn(arguments.against + ": " + doubt);
  std::vector<Product> products;
  const Document product = write_certificate(certificate, comparison, command.provenance());
  if (!arguments.page.empty())
    products.push_back({arguments.page, certificate_page(certificate, comparison, {product})});
  products.push_back({command.output, product});
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
  app::CertificateArguments arguments;
  app::add_certificate_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
