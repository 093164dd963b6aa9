#include "armtrue/report/mirror_page.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "armtrue/kinematics/units.h"
#include "report/mirror_pictures.h"
#include "report/page.h"

namespace armtrue {
namespace {

void add_mirror_verdict(Page& page, const MirrorFindings& findings) {
  const MirrorResult& result = findings.result;
  const double rms = findings.accuracy.errors.whole.rms;
  const FormError& form = findings.form;
  const std::optional<bool> held = form.holds(findings.goal);
  page.verdict(
      held.value_or(false) ? Tone::good : Tone::attention,
      !held   ? "form goal undecided"
      : *held ? "form goal held"
              : "form goal not held",
      "Mean deviation across the path " + keyed_mm(result.before.mean, "deviation_mm/mean") +
          " mm; " + keyed_mm(result.expected_after, "expected_after_mean_mm") +
          " mm expected after the correction, if " +
          keyed(result.expected_if(), "expected_after_if") + ". RMS of these passes " +
          keyed_mm(rms, "accuracy/whole_mm/rms") + " mm, without the noise of the instrument " +
          keyed_mm(form.rms, "accuracy/form_rms_mm") + " mm (95 %: " +
          keyed_mm(form.ci95[0], "accuracy/form_rms_ci95_mm/0") + " to " +
          keyed_mm(form.ci95[1], "accuracy/form_rms_ci95_mm/1") + " mm); goal " +
          keyed_mm(findings.goal, "accuracy/goal_rms_mm") + " mm.");
  page.tiles(
      {{"Before",
        (result.uncorrected ? keyed_mm(*result.uncorrected, "uncorrected_mean_mm")
                            : keyed_mm(result.before.mean, "deviation_mm/mean")) +
            " mm",
        result.uncorrected ? "mean deviation without any correction" : "mean deviation measured"},
       {"After", keyed_mm(result.expected_after, "expected_after_mean_mm") + " mm",
        "mean deviation expected of the next pass"},
       {"Floor",
        (findings.files.size() > 1 ? keyed_mm(result.deviation.spread, "noise/pass_to_pass_mm")
                                   : keyed_mm(result.deviation.noise, "noise/sample_mm")) +
            " mm",
        findings.files.size() > 1 ? "spread from pass to pass, per axis"
                                  : "noise of one sample, per axis"}});
}

std::string accuracy_table(const MirrorFindings& findings) {
  std::vector<TableRow> rows;
  const auto add = [&](const PassAccuracy& accuracy, const std::string& key,
                       const std::string& passes) {
    const auto row = [&](const std::string& name, const ErrorSummary& errors,
                         const std::string& of) {
      rows.push_back(error_cells(name + ", " + passes, errors, kMillimetre, key + of));
    };
    for (size_t axis = 0; axis < accuracy.errors.axis.size(); ++axis)
      row(std::string(1, "xyz"[axis]), accuracy.errors.axis[axis],
          std::string(1, "xyz"[axis]) + "_mm");
    row("length", accuracy.errors.whole, "whole_mm");
  };
  if (findings.before) add(*findings.before, "before/", "earlier passes");
  add(findings.accuracy, "accuracy/", "these passes");
  std::string html = table({"deviation, mm", "mean", "RMS", "95 %", "max"}, rows);
  const PathAccuracy& path = findings.accuracy.path;
  html += paragraph("Path accuracy AT (ISO 9283) " + keyed_mm(path.at, "accuracy/at_mm") + " mm" +
                    (path.rt ? ", repeatability RT " + keyed_mm(*path.rt, "accuracy/rt_mm") + " mm"
                             : std::string()) +
                    ".");
  if (!findings.before) return html;
  const Reduction gained = reduction(findings.before->errors, findings.accuracy.errors);
  std::string text = "Error reduced by:";
  const auto add_share = [&](const std::string& name, const std::optional<double>& share) {
    if (share) text += " " + name + " " + keyed_share(*share, "reduction/" + name) + ";";
  };
  for (size_t axis = 0; axis < 3; ++axis) add_share(std::string(1, "xyz"[axis]), gained.axis[axis]);
  add_share("whole", gained.whole);
  if (const auto of_form = form_reduction(*findings.form_before, findings.form))
    add_share("form", of_form->share);
  text.back() = '.';
  return html + paragraph(text);
}

std::string passes_table(const MirrorFindings& findings) {
  std::vector<TableRow> rows;
  for (size_t p = 0; p < findings.files.size(); ++p) {
    const Pass& pass = findings.result.passes[p];
    const std::string key = fmt::format("passes/{}/", p);
    rows.push_back({"<span class=\"file\" data-key=\"" + key + "file\">" +
                        escaped(findings.files[p]) + "</span>",
                    keyed(std::to_string(pass.samples), key + "samples"),
                    keyed(std::to_string(pass.lost), key + "lost_samples"),
                    keyed(std::to_string(pass.bad.size()), key + "bad_samples"),
                    keyed(fmt::format("{:.6f}", pass.clock.offset), key + "offset_s"),
                    keyed(pass.clock.offset_deviation(), key + "offset_std_s"),
                    keyed(pass.clock.rate * 1e6, key + "rate_ppm"),
                    keyed(std::sqrt(pass.clock.covariance(1, 1)) * 1e6, key + "rate_std_ppm")});
  }
  return table({"pass", "samples", "lost", "bad", "clock ahead, s", "its std, s", "rate, ppm",
                "its std, ppm"},
               rows);
}

std::string filter_table(const MirrorResult& result) {
  return table(
      {"correction", ""},
      {{"cut-off, Hz", keyed(result.cutoff, "filter/cut_off_hz")},
       {"gain", keyed(result.gain, "correction/gain")},
       {"correction points", keyed(std::to_string(result.points.size()), "correction/points")},
       {"longest correction, mm",
        keyed_mm(result.correction.colwise().norm().maxCoeff(), "correction/largest_mm")},
       {"samples clipped", keyed(std::to_string(result.clipped), "correction/clipped_samples")},
       {"samples outside the record",
        keyed(std::to_string(result.unrecorded), "correction/unrecorded_samples")}});
}

std::string force_text(const ForceLaw& law) {
  if (!law.magnitude.k) return paragraph("No force stands out of its noise.");
  const Estimate& k = *law.magnitude.k;
  const std::string key = "force/magnitude/";
  std::string text = "Deviation over force: " + keyed_mm(k.value, key + "k_mm_n/value") +
                     " mm/N (95 %: " + keyed_mm(k.ci95[0], key + "k_mm_n/ci95/0") + " to " +
                     keyed_mm(k.ci95[1], key + "k_mm_n/ci95/1") + "), R<sup>2</sup> " +
                     keyed(law.magnitude.r2, key + "r2") +
                     ". What the tool deviates by without force is taken off.";
  if (!law.reversals.empty())
    text += " The steps at reversals are a part of the samples, but not of the line.";
  return paragraph(text);
}

void add_mirror_next(Page& page, const MirrorFindings& findings) {
  page.section("What to do next");
  std::vector<std::string> items{
      "run the corrected path and record it: <code>--previous</code> with the corrected path adds "
      "what is left"};
  if (findings.files.size() == 1)
    items.push_back("record two or three passes: one does not show how passes differ");
  if (findings.result.unrecorded > 0)
    items.push_back(
        "record from before the tool moves until it stands again: " +
        keyed(std::to_string(findings.result.unrecorded), "correction/unrecorded_samples") +
        " samples in motion lie outside the record");
  page.list(items);
}

}  // namespace

Report mirror_page(const Path& programmed, const MirrorFindings& findings,
                   const std::string& program, const PageHead& head) {
  const MirrorResult& result = findings.result;
  Page page(head, std::filesystem::path(program).filename().string(), "Mirror correction");
  add_mirror_verdict(page, findings);
  page.section("Deviation");
  page.pictures({deviation_picture(result.deviation), path_picture(programmed, result),
                 correction_picture(programmed, result, findings.options),
                 trend_picture(programmed, result)});
  if (const auto& force = findings.force) {
    page.section("Deviation against force");
    page.add(force_text(*force));
    page.pictures({force_picture(result.deviation, *force), force_over_time(result.deviation)});
  }
  add_mirror_next(page, findings);
  page.folded_section("Details");
  page.add(folded("Accuracy of the passes, each axis", accuracy_table(findings)));
  page.add(folded("Passes and their clocks", passes_table(findings)));
  page.add(folded("Filter and correction", filter_table(result)));
  return page.finish();
}

}  // namespace armtrue
