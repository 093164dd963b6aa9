#include "armtrue/report/loop_report.h"

#include <algorithm>
#include <sstream>

#include "armtrue/kinematics/units.h"
#include "armtrue/tracing/description.h"
#include "report/gnuplot.h"
#include "report/html.h"

namespace armtrue {
namespace {

constexpr int kBins = 30;

const char* error_name(const LoopResult& result) {
  return result.of_distances ? "distance error" : "position error";
}

std::string stages_plot(const LoopResult& result) {
  std::ostringstream script;
  script << "set style data histogram\nset style fill solid 0.7\nset boxwidth 0.8\nset grid ytics\n"
            "set ylabel 'held-out "
         << error_name(result)
         << ", mm'\nset yrange [0:*]\nset key top right\nset xtics noenhanced\n$d << END\n";
  // Without the nominal robot, whose error is so large that the other bars could not be read.
  for (size_t k = 1; k < result.stages.size(); ++k) {
    const ErrorSummary& errors = result.stages[k].held_out.position;
    script << (k == 1 ? std::string("geometry") : "+" + std::to_string(k - 1)) << " "
           << errors.mean / kMillimetre << " " << errors.p95 / kMillimetre << "\n";
  }
  script << "END\nplot $d using 2:xtic(1) title 'mean', '' using 3 title '95 % of the readings', "
         << result.floor / kMillimetre << " title 'noise floor (mean)' with lines lw 2 dt 2\n";
  return plot_svg(script.str(), kPlotWidth, kPlotHeight);
}

std::string histogram_plot(const LoopResult& result) {
  const double largest =
      *std::max_element(result.errors_before.begin(), result.errors_before.end());
  const double width = std::max(1e-9, largest / kBins);
  std::vector<int> before(kBins + 1), after(kBins + 1);
  const auto bin = [&](double error) { return std::min(kBins, static_cast<int>(error / width)); };
  for (double error : result.errors_before) ++before[bin(error)];
  for (double error : result.errors_after) ++after[bin(error)];
  std::ostringstream script;
  script << "set style fill solid 0.5\nset grid ytics\nset xlabel '" << error_name(result)
         << ", mm'\n"
            "set ylabel 'held-out readings'\n$d << END\n";
  for (int k = 0; k <= kBins; ++k)
    script << (k + 0.5) * width / kMillimetre << " " << before[k] << " " << after[k] << "\n";
  script << "END\nset boxwidth " << 0.9 * width / kMillimetre
         << "\nplot $d using 1:2 with boxes title 'geometry alone', "
            "'' using 1:3 with boxes title 'with the effects'\n";
  return plot_svg(script.str(), kPlotWidth, kPlotHeight);
}

std::string curve_plot(const Effect& effect, const std::vector<CurvePoint>& curve,
                       const KinematicChain& chain) {
  const bool is_angle = effect.driver.kind == DriverKind::joint_angle;
  const DisplayUnit unit = display_unit(unit_of_parameter(chain, effect.parameter));
  const bool travels = is_travel(effect.driver, chain);
  const double driver_si = travels ? kMillimetre : is_angle ? kDegree : 1.0;
  const char* driver_unit = travels                                  ? ", mm"
                            : is_angle                               ? ", deg"
                            : effect.driver.kind == DriverKind::time ? ", s"
                                                                     : ", deg C";
  std::ostringstream script;
  script << "set grid\nset key off\nset xlabel " << quoted(to_string(effect.driver) + driver_unit)
         << " noenhanced\nset ylabel " << quoted(effect.parameter + ", " + unit.name)
         << " noenhanced\n$d << END\n";
  for (const CurvePoint& point : curve)
    script << point.driver / driver_si << " " << point.value / unit.si << " "
           << (point.value - point.half_width) / unit.si << " "
           << (point.value + point.half_width) / unit.si << "\n";
  script
      << "END\nplot $d using 1:3:4 with filledcurves fs solid 0.3, '' using 1:2 with lines lw 2\n";
  return plot_svg(script.str(), kPlotWidth, kPlotHeight - 40);
}

std::string stages_table(const LoopResult& result) {
  std::ostringstream html;
  html << "<table><tr><th>stage</th><th>unknowns</th><th>training mean, mm</th>"
          "<th>held-out mean, mm</th><th>held-out 95 %, mm</th><th>held-out max, mm</th></tr>\n";
  const auto if_held_out = [&](double value) {
    return result.held_out_poses > 0 ? number(value / kMillimetre) : "-";
  };
  for (const Stage& stage : stages_and_predictor(result)) {
    const ErrorSummary& held_out = stage.held_out.position;
    html << "<tr><td>" << escaped(stage.name) << "</td><td>" << stage.parameters << "</td><td>"
         << number(stage.training.position.mean / kMillimetre) << "</td><td>"
         << if_held_out(held_out.mean) << "</td><td>" << if_held_out(held_out.p95) << "</td><td>"
         << if_held_out(held_out.max) << "</td></tr>\n";
  }
  html << "</table>\n";
  return html.str();
}

void write_effect(std::ostringstream& html, const LoopResult& result, size_t k,
                  const std::string& description) {
  const TracedEffect& traced = result.trace.effects[k];
  html << "<h3>" << escaped(describe(traced.effect)) << "</h3>\n<p>" << escaped(description)
       << "</p>\n<p>EBIC falls by " << number(traced.evidence.delta_ebic) << ", family-wise p "
       << number(traced.evidence.p_value) << ", " << number(100 * traced.variance_share.value)
       << " % of the variance that the effects explain";
  if (result.trace.effects.size() > 1)
    html << " (95 %: " << number(100 * traced.variance_share.ci95[0]) << " to "
         << number(100 * traced.variance_share.ci95[1]) << ")"
         << (traced.variance_share.may_lead ? ", no other clearly more" : "");
  if (result.nested)
    html << ", found again in " << result.nested->found_again[k] << " of " << result.nested->folds
         << " folds";
  if (k < result.gains.size())
    html << ", held-out gain " << number(result.gains[k].position / kMillimetre)
         << " mm (95 %: " << number(result.gains[k].ci95[0] / kMillimetre) << " to "
         << number(result.gains[k].ci95[1] / kMillimetre) << ")";
  html << ".</p>\n";
  if (!traced.indistinguishable.empty()) {
    html << "<p>This data cannot tell it from:</p><ul>\n";
    for (const Rival& rival : traced.indistinguishable)
      html << "<li>" << escaped(describe(rival.effect)) << ", correlation "
           << number(rival.correlation) << "</li>\n";
    html << "</ul>\n";
  }
  if (!result.curves[k].empty())
    html << curve_plot(traced.effect, result.curves[k], result.trace.fit.robot.chain);
}

}  // namespace

std::string loop_report(const LoopResult& result, const std::string& title) {
  const std::vector<std::string> descriptions = effect_descriptions(result);
  std::ostringstream html;
  html << "<p>Verdict: <b>" << to_string(result.verdict) << "</b>. " << result.training_poses
       << " poses to learn from, " << result.held_out_poses << " held out.";
  if (!result.excluded_rows.empty())
    html << " " << result.excluded_rows.size() << " readings look like blunders.";
  html << "</p>\n" << stages_table(result);
  if (!result.errors_before.empty())
    html << "<h2>Error on the poses that took no part</h2>\n"
         << stages_plot(result) << histogram_plot(result);
  if (result.predictor)
    html << "<p>The last line of the table is of the robot that only predicts: none of the effects "
            "that it adds is a finding, and the verdict does without them.</p>\n";
  if (const auto& nested = result.nested)
    html << "<p>Nested cross-validation, the whole search repeated in " << nested->folds
         << " folds: mean " << error_name(result) << " "
         << number(nested->before.mean / kMillimetre) << " mm with geometry alone, "
         << number(nested->after.mean / kMillimetre) << " mm with what the search added (gain "
         << number(nested->gain.mean / kMillimetre) << " mm, standard error "
         << number(nested->gain.error / kMillimetre) << " mm).</p>\n";
  if (!result.trace.effects.empty()) html << "<h2>Effects</h2>\n";
  for (size_t k = 0; k < result.trace.effects.size(); ++k)
    write_effect(html, result, k, descriptions[k]);
  html << "<h2>What remains</h2>\n<p>";
  if (result.lack_of_fit)
    html << "Lack of fit against the noise: p " << number(*result.lack_of_fit) << ". ";
  if (!result.pattern.empty())
    html << "Best candidate that was not added: " << escaped(result.pattern) << ", p "
         << number(result.trace.remaining_p) << ".";
  html << "</p>\n";
  return html_page(title, html.str());
}

}  // namespace armtrue
