#include "armtrue/report/certificate_page.h"

#include "armtrue/kinematics/units.h"
#include "report/html.h"

namespace armtrue {
namespace {

constexpr const char* kPrintStyle =
    "<style>@page{size:A4;margin:18mm}@media print{body{max-width:none;margin:0;font-size:10pt}}"
    "tr,.sign{break-inside:avoid}.hash{font-family:monospace;font-size:80%}"
    ".sign td{width:50%;height:4em;vertical-align:bottom;text-align:left}</style>\n";

// A row of cells that are HTML already.
std::string table_row(const std::vector<std::string>& cells, const char* tag = "td") {
  std::string html = "<tr>";
  for (const std::string& cell : cells)
    html += std::string("<") + tag + ">" + cell + "</" + tag + ">";
  return html + "</tr>\n";
}

std::string table_head(const std::vector<std::string>& cells) {
  return "<table>\n<thead>" + table_row(cells, "th") + "</thead>\n";
}

std::string in_mm(double value) { return number(value / kMillimetre); }

std::string in_mm(const std::optional<double>& value) { return value ? in_mm(*value) : ""; }

std::string about_table(const Certificate& certificate) {
  const About& about = certificate.about;
  std::string html = "<table>\n";
  html += table_row({"Robot", escaped(about.type) + ", serial number " + escaped(about.serial)});
  html += table_row({"Commanded poses", "predicted by " + escaped(certificate.robot)});
  html += table_row({"Instrument", escaped(about.instrument) + ", serial number " +
                                       escaped(about.instrument_serial) + ", calibrated until " +
                                       about.calibrated_until});
  html += table_row({"Place", escaped(about.place)});
  html += table_row({"Date of measurement", about.date});
  html += table_row({"Operator", escaped(about.operator_name)});
  return html + "</table>\n";
}

std::string decision_line(const Certificate& certificate) {
  if (!certificate.decision) return "<p>No tolerance was stated: no decision.</p>\n";
  const char* law = "AP &minus; U &le; tolerance &lt; AP + U";
  if (*certificate.decision == Decision::pass) law = "AP + U &le; tolerance";
  if (*certificate.decision == Decision::fail) law = "AP &minus; U &gt; tolerance";
  return "<p><b>" + decision_name(*certificate.decision) + "</b>: tolerance of AP " +
         in_mm(*certificate.tolerance) + " mm, AP " + in_mm(certificate.all.ap.value) + " mm, U " +
         in_mm(certificate.budget.expanded) + " mm; " + law + " (ISO 14253-1).</p>\n";
}

std::string figures_table(const std::string& what, const SetFigures& set, double expanded) {
  std::string html = "<h2>" + what + ": " + std::to_string(set.poses) + ", each visited " +
                     std::to_string(set.fewest_visits) + " times or more</h2>\n" +
                     table_head({"largest", "value", "U", "pose"});
  const auto row = [&](const char* name, const Largest& largest, double unit,
                       const std::string& uncertainty) {
    html += table_row({name, number(largest.value / unit), uncertainty, escaped(largest.pose)});
  };
  const auto add = [&](const char* name, const std::optional<Largest>& largest, double unit) {
    if (largest) row(name, *largest, unit, "");
  };
  row("pose accuracy AP, mm", set.ap, kMillimetre, in_mm(expanded));
  row("pose repeatability RP, mm", set.rp, kMillimetre, in_mm(set.rp_expanded()));
  add("AP of an angle, mrad", set.ap_turn, kMilliradian);
  add("RP of an angle, &plusmn; mrad", set.rp_turn, kMilliradian);
  add("multi-directional variation vAP, mm", set.vap, kMillimetre);
  add("drift of AP, mm", set.drift_ap, kMillimetre);
  add("drift of RP, mm", set.drift_rp, kMillimetre);
  return html + "</table>\n";
}

std::string budget_table(const Budget& budget) {
  std::string html =
      "<h2>Uncertainty of AP (GUM)</h2>\n" +
      table_head({"source", "distribution", "standard uncertainty, mm", "sensitivity"});
  for (const BudgetRow& row : budget.rows)
    html += table_row({row.source, row.distribution, in_mm(row.standard), "1"});
  html += table_row({"combined", "", in_mm(budget.combined), ""});
  html += table_row({"expanded U, k = " + number(budget.k), "", in_mm(budget.expanded), ""});
  return html + "</table>\n";
}

std::string poses_table(const std::vector<PoseFigures>& poses) {
  std::string html = "<h2>Poses, mm</h2>\n" +
                     table_head({"pose", "visits", "AP", "AP<sub>x</sub>", "AP<sub>y</sub>",
                                 "AP<sub>z</sub>", "RP", "vAP", "drift of AP", "drift of RP"});
  for (const PoseFigures& figures : poses)
    html += table_row({escaped(figures.pose), std::to_string(figures.visits), in_mm(figures.ap),
                       in_mm(figures.ap_axes.x()), in_mm(figures.ap_axes.y()),
                       in_mm(figures.ap_axes.z()), in_mm(figures.rp), in_mm(figures.vap),
                       in_mm(figures.drift_ap), in_mm(figures.drift_rp)});
  return html + "</table>\n";
}

std::string comparison_table(const Comparison& comparison) {
  std::string html = "<h2>Compared with the certificate of " + escaped(comparison.date_before) +
                     ", mm</h2>\n" +
                     table_head({"", "before", "now", "difference", "U", "significant"});
  const auto rows = [&](const std::vector<Difference>& differences, const std::string& prefix) {
    for (const Difference& difference : differences)
      html += table_row({prefix + escaped(difference.name), in_mm(difference.before),
                         in_mm(difference.now), in_mm(difference.difference),
                         in_mm(difference.expanded), difference.significant ? "yes" : "no"});
  };
  rows(comparison.figures, "");
  rows(comparison.poses, "ap of ");
  return html + "</table>\n";
}

std::string notes_list(const std::vector<std::string>& notes) {
  if (notes.empty()) return "";
  std::string html = "<h2>Notes</h2>\n<ul>\n";
  for (const std::string& note : notes) html += "<li>" + escaped(note) + "</li>\n";
  return html + "</ul>\n";
}

}  // namespace

std::string certificate_page(const Certificate& certificate,
                             const std::optional<Comparison>& comparison,
                             const std::vector<std::pair<std::string, std::string>>& inputs) {
  const double expanded = certificate.budget.expanded;
  std::string html = kPrintStyle + about_table(certificate) + decision_line(certificate);
  if (certificate.cube) html += figures_table("Poses of the cube", *certificate.cube, expanded);
  html += figures_table("All poses", certificate.all, expanded);
  html += "<p>After ISO 9283:1998; axes of the instrument's frame.</p>\n";
  html += budget_table(certificate.budget);
  if (comparison) html += comparison_table(*comparison);
  html += notes_list(certificate.notes);
  html += poses_table(certificate.poses);
  html += "<h2>Files</h2>\n" + table_head({"file", "SHA-256"});
  for (const auto& [file, sha256] : inputs)
    html += table_row({escaped(file), "<span class=\"hash\">" + sha256 + "</span>"});
  html += "</table>\n<table class=\"sign\" style=\"width:100%\">\n" +
          table_row({"Place, date", "Signature"}) + "</table>\n";
  return html_page("Certificate of pose accuracy", html);
}

}  // namespace armtrue
