#include "armtrue/report/certificate_page.h"

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "report/page.h"

namespace armtrue {
namespace {

std::string mm_text(double value) { return rounded(value / kMillimetre); }

std::string mm_text(const std::optional<double>& value) { return value ? mm_text(*value) : ""; }

std::string poses_line(const Certificate& certificate) {
  const About& about = certificate.about;
  return paragraph("Commanded poses: predicted by " + escaped(certificate.robot) +
                   (about.calibrated_until.empty() ? std::string(".")
                                                   : ". Instrument calibrated until " +
                                                         escaped(about.calibrated_until) + "."));
}

Tone tone_of_decision(const Certificate& certificate) {
  if (!certificate.decision || *certificate.decision == Decision::pass) return Tone::good;
  return *certificate.decision == Decision::fail ? Tone::bad : Tone::attention;
}

void add_decision(Page& page, const Certificate& certificate) {
  if (!certificate.decision) {
    page.add(paragraph("No tolerance was stated: no decision."));
    return;
  }
  const char* law = "AP &minus; U &le; tolerance &lt; AP + U";
  if (*certificate.decision == Decision::pass) law = "AP + U &le; tolerance";
  if (*certificate.decision == Decision::fail) law = "AP &minus; U &gt; tolerance";
  page.verdict(tone_of_decision(certificate), decision_name(*certificate.decision),
               "Tolerance of AP " + mm_text(*certificate.tolerance) + " mm, AP " +
                   mm_text(certificate.all.ap.value) + " mm, U " +
                   mm_text(certificate.budget.expanded) + " mm; " + law + " (ISO 14253-1).");
}

std::string figures_table(const std::string& what, const SetFigures& set, double expanded) {
  std::string html = "<h2>" + what + ": " + std::to_string(set.poses) + ", each visited " +
                     std::to_string(set.fewest_visits) + " times or more</h2>\n";
  std::vector<TableRow> rows;
  const auto row = [&](const char* name, const Largest& largest, double unit,
                       const std::string& uncertainty) {
    rows.push_back({name, rounded(largest.value / unit), uncertainty, escaped(largest.pose)});
  };
  const auto add = [&](const char* name, const std::optional<Largest>& largest, double unit) {
    if (largest) row(name, *largest, unit, "");
  };
  row("pose accuracy AP, mm", set.ap, kMillimetre, mm_text(expanded));
  row("pose repeatability RP, mm", set.rp, kMillimetre, mm_text(set.rp_expanded()));
  add("AP of an angle, mrad", set.ap_turn, kMilliradian);
  add("RP of an angle, &plusmn; mrad", set.rp_turn, kMilliradian);
  add("multi-directional variation vAP, mm", set.vap, kMillimetre);
  add("vAP of an angle, mrad", set.vap_turn, kMilliradian);
  add("drift of AP, mm", set.drift_ap, kMillimetre);
  add("drift of RP, mm", set.drift_rp, kMillimetre);
  add("drift of AP of an angle, mrad", set.drift_ap_turn, kMilliradian);
  add("drift of RP of an angle, mrad", set.drift_rp_turn, kMilliradian);
  return html + table({"largest", "value", "U", "pose"}, rows);
}

std::string path_table(const PathFigures& path, const Budget& budget) {
  std::vector<TableRow> rows{{"path accuracy AT, mm", mm_text(path.at), mm_text(budget.expanded)}};
  if (path.rt)
    rows.push_back({"path repeatability RT, mm", mm_text(*path.rt), mm_text(path.rt_expanded())});
  return "<h2>Path, recorded " + std::to_string(path.passes) + " times</h2>\n" +
         table({"largest of " + std::to_string(path.planes) + " planes", "value", "U"}, rows);
}

std::string budget_table(const std::string& figure, const Budget& budget) {
  std::vector<TableRow> rows;
  for (const BudgetRow& row : budget.rows)
    rows.push_back({row.source, row.distribution, mm_text(row.standard), "1"});
  rows.push_back({"combined", "", mm_text(budget.combined), ""});
  rows.push_back({"expanded U, k = " + rounded(budget.k), "", mm_text(budget.expanded), ""});
  return "<h2>Uncertainty of " + figure + " (GUM)</h2>\n" +
         table({"source", "distribution", "standard uncertainty, mm", "sensitivity"}, rows);
}

std::string poses_table(const std::vector<PoseFigures>& poses) {
  std::vector<TableRow> rows;
  for (const PoseFigures& figures : poses)
    rows.push_back({escaped(figures.pose), std::to_string(figures.visits), mm_text(figures.ap),
                    mm_text(figures.ap_axes.x()), mm_text(figures.ap_axes.y()),
                    mm_text(figures.ap_axes.z()), mm_text(figures.rp), mm_text(figures.vap),
                    mm_text(figures.drift_ap), mm_text(figures.drift_rp)});
  return "<h2>Poses, mm</h2>\n" +
         table({"pose", "visits", "AP", "AP<sub>x</sub>", "AP<sub>y</sub>", "AP<sub>z</sub>", "RP",
                "vAP", "drift of AP", "drift of RP"},
               rows);
}

std::string comparison_table(const Comparison& comparison) {
  std::vector<TableRow> rows;
  const auto add = [&](const std::vector<CertifiedChange>& differences, const std::string& prefix) {
    for (const CertifiedChange& difference : differences)
      rows.push_back({prefix + escaped(difference.name), mm_text(difference.before),
                      mm_text(difference.now), mm_text(difference.difference),
                      mm_text(difference.expanded), difference.significant ? "yes" : "no"});
  };
  add(comparison.figures, "");
  add(comparison.poses, "ap of ");
  const std::string doubt = doubt_of_poses(comparison);
  return "<h2>Compared with the certificate of " + escaped(comparison.date_before) + ", mm</h2>\n" +
         table({"", "before", "now", "difference", "U", "significant"}, rows) +
         (doubt.empty() ? "" : paragraph("Doubt: " + escaped(doubt) + "."));
}

std::string notes_list(const std::vector<std::string>& notes) {
  if (notes.empty()) return "";
  std::string html = "<h2>Notes</h2>\n<ul>\n";
  for (const std::string& note : notes) html += "<li>" + escaped(note) + "</li>\n";
  return html + "</ul>\n";
}

}  // namespace

std::string certificate_page(const Certificate& certificate,
                             const std::optional<Comparison>& comparison, const PageHead& head) {
  const double expanded = certificate.budget.expanded;
  PageHead stated = head;
  stated.about = certificate.about;
  Page page(stated, certificate.about.type, "Certificate of pose accuracy");
  add_decision(page, certificate);
  page.add(poses_line(certificate));
  if (certificate.cube) page.add(figures_table("Poses of the cube", *certificate.cube, expanded));
  page.add(figures_table("All poses", certificate.all, expanded));
  if (certificate.path) page.add(path_table(*certificate.path, *certificate.path_budget));
  page.add(paragraph("After ISO 9283:1998; axes of the instrument's frame."));
  page.add(budget_table("AP", certificate.budget));
  if (certificate.path_budget) page.add(budget_table("AT", *certificate.path_budget));
  if (comparison) page.add(comparison_table(*comparison));
  page.add(notes_list(certificate.notes) + poses_table(certificate.poses));
  page.section("Files");
  page.add(page.inputs());
  page.add("<table class=\"sign\"><tr><td>Place, date</td><td>Signature</td></tr></table>\n");
  return page.finish(false).html;
}

}  // namespace armtrue
