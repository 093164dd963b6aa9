#include "armtrue/report/mirror_table.h"

#include <fmt/format.h>

#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"

namespace armtrue {

std::string mirror_table(const MirrorFindings& findings) {
  const auto& [result, options, files, lines, forces, accuracy, form, before, form_before,
               deviation_before, from_executed, force, robot, goal, reversals] = findings;
  std::string table;
  for (size_t p = 0; p < files.size(); ++p) {
    const Pass& pass = result.passes[p];
    table += fmt::format(
        "{}: clock {:.4f} +- {:.4f} s ahead of the program (95 %), rate {:.0f} +- {:.0f} ppm, {} "
        "samples, {} lost, {} bad\n",
        files[p], pass.clock.offset, 1.96 * pass.clock.offset_deviation(), pass.clock.rate * 1e6,
        1.96e6 * std::sqrt(pass.clock.covariance(1, 1)), pass.samples, pass.lost, pass.bad.size());
  }
  for (size_t p = 0; p < forces.size(); ++p)
    table += fmt::format("{}: clock {:.4f} +- {:.4f} s ahead of {} (95 %)\n", forces[p].file,
                         forces[p].clock.offset, 1.96 * forces[p].clock.deviation, files[p]);
  const auto row = [&](const std::string& what, double value) {
    table += fmt::format("{:<44}{:>9.3f}\n", what, value / kMillimetre);
  };
  if (result.uncorrected) row("mean deviation without correction, mm", *result.uncorrected);
  row("mean deviation across the path, mm", result.before.mean);
  row("expected after the correction, mm", result.expected_after);
  table += fmt::format("  if {}\n", result.expected_if());
  row("noise of a sample, mm", result.deviation.noise);
  if (files.size() > 1) row("spread from pass to pass, mm", result.deviation.spread);
  row("path accuracy AT (ISO 9283), mm", accuracy.path.at);
  if (accuracy.path.rt) row("path repeatability RT, mm", *accuracy.path.rt);
  row("RMS of these passes, mm", accuracy.errors.whole.rms);
  table += fmt::format("{:<44}{:>9.3f}  (of noise alone about {:.3f})\n",
                       "largest deviation of a sample, mm", accuracy.errors.whole.max / kMillimetre,
                       largest_of_noise(findings) / kMillimetre);
  const std::optional<bool> held = form.holds(goal);
  table += fmt::format("{:<44}{:>9.3f}  [{:.3f}, {:.3f}] (RMS goal {:.3f}: {})\n",
                       "RMS without noise, 95 %, mm", form.rms / kMillimetre,
                       form.ci95[0] / kMillimetre, form.ci95[1] / kMillimetre, goal / kMillimetre,
                       !held   ? "undecided"
                       : *held ? "held"
                               : "not held");
  if (form.faster > 0)
    table += fmt::format("{:<44}{:>9.3f}  (a vibration, or slow noise)\n",
                         "faster than the form, RMS without noise, mm", form.faster / kMillimetre);
  if (before) {
    const Reduction gained = reduction(before->errors, accuracy.errors);
    const auto per_cent = [](const std::optional<double>& share) {
      return share ? fmt::format("{:.0f}", 100 * *share) : std::string("-");
    };
    table += fmt::format("error reduced by, per cent: x {}, y {}, z {}, whole {}\n",
                         per_cent(gained.axis[0]), per_cent(gained.axis[1]),
                         per_cent(gained.axis[2]), per_cent(gained.whole));
    if (const auto of_form = form_reduction(*form_before, form))
      table += fmt::format("form reduced by, per cent: {:.0f}{}\n", 100 * of_form->share,
                           of_form->ci95 ? fmt::format(" [{:.0f}, {:.0f}]", 100 * (*of_form->ci95)[0],
                                                       100 * (*of_form->ci95)[1])
                                         : "");
  }
  if (force && force->magnitude.k)
    table += fmt::format("deviation over force: {:.4f} mm/N [{:.4f}, {:.4f}], R2 {:.2f}\n",
                         force->magnitude.k->value / kMillimetre,
                         force->magnitude.k->ci95[0] / kMillimetre,
                         force->magnitude.k->ci95[1] / kMillimetre, force->magnitude.r2);
  table += fmt::format("cut-off {:.3g} Hz, gain {:.3f}, {}, {}, {} clipped\n", result.cutoff,
                       result.gain, counted(result.points.size(), "correction point"),
                       counted(result.deviation.breaks.size(), "break"),
                       counted(result.clipped, "sample"));
  return table;
}

}  // namespace armtrue
