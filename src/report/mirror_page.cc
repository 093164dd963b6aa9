#include "armtrue/report/mirror_page.h"

#include <fmt/format.h>

#include <filesystem>

#include "report/mirror_pictures.h"
#include "report/page.h"

namespace armtrue {
namespace {

void add_mirror_verdict(Page& page, const MirrorFindings& findings) {
  const std::optional<bool> held = findings.form.holds(findings.goal);
  page.verdict(held.value_or(false) ? Tone::good : Tone::attention,
               !held   ? "RMS form goal undecided"
               : *held ? "RMS form goal held"
                       : "RMS form goal not held",
               "Mean deviation across the path " + page.value("deviation_mm/mean") + " mm; " +
                   page.value("expected_after_mean_mm") + " mm expected after the correction, if " +
                   page.value("expected_after_if") + ". RMS of these passes " +
                   page.value("accuracy/whole_mm/rms") +
                   " mm, without the noise of the instrument " +
                   page.value("accuracy/form_rms_mm") +
                   " mm (95 %: " + page.value("accuracy/form_rms_ci95_mm/0") + " to " +
                   page.value("accuracy/form_rms_ci95_mm/1") + " mm); goal of this RMS " +
                   page.value("accuracy/goal_rms_mm") + " mm. The largest sample deviates by " +
                   page.value("accuracy/whole_mm/max") + " mm; noise alone would give about " +
                   page.value("noise/largest_mm") + " mm.");
  const bool has_spread = findings.files.size() > 1;
  std::vector<Page::Tile> tiles;
  if (findings.before)
    tiles.push_back({"Before", page.value("before/form_rms_mm") + " mm",
                     "RMS form error measured before the correction"});
  tiles.push_back({findings.before ? "After" : "Measured",
                   page.value("accuracy/form_rms_mm") + " mm",
                   findings.before ? "RMS form error measured with the correction"
                                   : "RMS form error of these passes"});
  if (findings.result.uncorrected && !findings.before)
    tiles.push_back({"Uncorrected", page.value("uncorrected_mean_mm") + " mm",
                     "mean deviation, had the earlier correction not run"});
  tiles.push_back({"Expected", page.value("expected_after_mean_mm") + " mm",
                   "mean deviation of the next pass"});
  tiles.push_back({has_spread ? "Spread of the passes" : "Noise of a sample",
                   page.value(has_spread ? "noise/pass_to_pass_mm" : "noise/sample_mm") + " mm",
                   "per axis"});
  page.tiles(tiles);
}

std::string accuracy_table(const Page& page, const MirrorFindings& findings) {
  std::vector<TableRow> rows;
  const auto add = [&](const std::string& key, const std::string& passes) {
    for (const char* axis : {"x", "y", "z"})
      rows.push_back(page.error_row(axis + (", " + passes), key + axis + "_mm"));
    rows.push_back(page.error_row("length, " + passes, key + "whole_mm"));
  };
  if (findings.before) add("before/", "earlier passes");
  add("accuracy/", "these passes");
  std::string html = table({"deviation, mm", "mean", "RMS", "95 %", "max"}, rows);
  html += paragraph("Path accuracy AT (ISO 9283) " + page.value("accuracy/at_mm") + " mm" +
                    (findings.accuracy.path.rt
                         ? ", repeatability RT " + page.value("accuracy/rt_mm") + " mm"
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

std::string passes_table(const Page& page, size_t passes) {
  std::vector<TableRow> rows;
  for (size_t p = 0; p < passes; ++p) {
    const std::string key = fmt::format("passes/{}/", p);
    TableRow row{page.file_name(key + "file")};
    for (const char* of : {"samples", "lost_samples", "bad_samples", "offset_s", "offset_std_s",
                           "rate_ppm", "rate_std_ppm"})
      row.push_back(page.value(key + of));
    rows.push_back(row);
  }
  return table({"pass", "samples", "lost", "bad", "clock ahead, s", "its std, s", "rate, ppm",
                "its std, ppm"},
               rows);
}

std::string force_records_text(const Page& page, const MirrorFindings& findings) {
  std::string html;
  for (size_t p = 0; p < findings.forces.size(); ++p) {
    const std::string key = fmt::format("passes/{}/force_record/", p);
    html += paragraph("Forces of pass " + page.file_name(fmt::format("passes/{}/file", p)) +
                      " from " + page.file_name(key + "file") + ", whose clock is " +
                      page.value(key + "offset_s") + " s ahead of the instrument's (std " +
                      page.value(key + "offset_std_s") + " s).");
  }
  return html;
}

std::string filter_table(const Page& page) {
  return table({"correction", ""},
               {{"cut-off, Hz", page.value("filter/cut_off_hz")},
                {"gain", page.value("correction/gain")},
                {"correction points", page.value("correction/points")},
                {"longest correction, mm", page.value("correction/largest_mm")},
                {"samples clipped", page.value("correction/clipped_samples")},
                {"samples outside the record", page.value("correction/unrecorded_samples")}});
}

std::string force_text(const Page& page, const ForceLaw& law) {
  if (!law.magnitude.k) return paragraph("No force stands out of its noise.");
  const std::string key = "force/magnitude/";
  std::string text = "Deviation over force: " + page.value(key + "k_mm_n/value") +
                     " mm/N (95 %: " + page.value(key + "k_mm_n/ci95/0") + " to " +
                     page.value(key + "k_mm_n/ci95/1") + "), R<sup>2</sup> " +
                     page.value(key + "r2") +
                     ". A deviation that is there without force does not count.";
  if (!law.reversals.empty())
    text += " The steps at reversals are a part of the samples, but not of the line.";
  return paragraph(text);
}

void add_mirror_next(Page& page, const MirrorFindings& findings) {
  page.section("What to do next");
  const bool is_held = findings.form.holds(findings.goal).value_or(false);
  std::vector<std::string> items{
      is_held ? "keep the path that these passes ran: it holds the RMS form goal. Compare the "
                "largest deviation with the tolerance of the part"
              : "run the corrected path and record it: <code>--previous</code> with the corrected "
                "path adds what is left"};
  if (findings.files.size() == 1)
    items.push_back("record two or three passes: one does not show how passes differ");
  if (findings.result.unrecorded > 0)
    items.push_back("record from before the tool moves until it stands again: " +
                    page.value("correction/unrecorded_samples") +
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
  page.pictures({deviation_picture(findings), path_picture(programmed, result),
                 correction_picture(programmed, findings), trend_picture(programmed, result)});
  if (const auto& force = findings.force) {
    page.section("Deviation against force");
    page.add(force_text(page, *force));
    page.pictures({force_picture(findings.of_arm(), *force), force_over_time(result.deviation)});
  }
  add_mirror_next(page, findings);
  page.folded_section("Details");
  page.add(folded("Accuracy of the passes, each axis", accuracy_table(page, findings)));
  page.add(folded("Passes and their clocks",
                  passes_table(page, findings.files.size()) + force_records_text(page, findings)));
  page.add(folded("Filter and correction", filter_table(page)));
  return page.finish();
}

}  // namespace armtrue
