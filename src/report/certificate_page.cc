#include "armtrue/report/certificate_page.h"

#include <algorithm>
#include <iterator>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "report/page.h"

namespace armtrue {
namespace {

// With the decimals of its uncertainty [m]; with four digits if that is not known (0).
std::string mm_as_known(double value, double expanded) {
  return as_known(value / kMillimetre, expanded / kMillimetre);
}

std::string mm_as_known(const std::optional<double>& value, double expanded) {
  return value ? mm_as_known(*value, expanded) : "";
}

// A figure that is not zero does not read 0.
std::string figure_mm(double value, double expanded) {
  return expanded > 0 ? fixed_text(value / kMillimetre,
                                   decimals_of_figure(value / kMillimetre, expanded / kMillimetre))
                      : mm_as_known(value, expanded);
}

std::string conditions_line(const Certificate& certificate) {
  const About& about = certificate.about;
  return paragraph((certificate.has_poses()
                        ? "Commanded poses: predicted by " + escaped(certificate.robot) + ". "
                        : std::string()) +
                   (about.calibrated_until.empty()
                        ? std::string()
                        : "Instrument calibrated until " + escaped(about.calibrated_until) + "."));
}

Tone tone_of_decision(const Certificate& certificate) {
  if (!certificate.decision || *certificate.decision == Decision::pass) return Tone::good;
  return *certificate.decision == Decision::fail ? Tone::bad : Tone::attention;
}

// Whether the law of a decision holds for the figures with so many decimals.
bool law_holds(const Certificate& certificate, int decimals) {
  const auto shown = [&](double value) {
    return read_number(fixed_text(value / kMillimetre, decimals)).value();
  };
  constexpr double kRounding = 1e-9;  // mm: of a sum of decimals
  const double ap = shown(certificate.all.ap.value), expanded = shown(certificate.budget.expanded),
               tolerance = *certificate.tolerance / kMillimetre + kRounding;
  if (*certificate.decision == Decision::pass) return ap + expanded <= tolerance;
  const bool fails = ap - expanded > tolerance;
  return *certificate.decision == Decision::fail ? fails : !fails && ap + expanded > tolerance;
}

void add_decision(Page& page, const Certificate& certificate) {
  if (!certificate.decision) {
    page.add(paragraph("No tolerance was stated: no decision."));
    return;
  }
  const char* law = "AP &minus; U &le; tolerance &lt; AP + U";
  if (*certificate.decision == Decision::pass) law = "AP + U &le; tolerance";
  if (*certificate.decision == Decision::fail) law = "AP &minus; U &gt; tolerance";
  const int decimals = decimals_shown(certificate);
  page.verdict(tone_of_decision(certificate), decision_name(*certificate.decision),
               "Tolerance of AP " + number_text(*certificate.tolerance, kMillimetre) + " mm, AP " +
                   fixed_text(certificate.all.ap.value / kMillimetre, decimals) + " mm, U " +
                   fixed_text(certificate.budget.expanded / kMillimetre, decimals) + " mm; " + law +
                   " (ISO 14253-1).");
}

std::string figures_table(const std::string& what, const SetFigures& set, double expanded) {
  std::string html = "<h2>" + what + ": " + std::to_string(set.poses) + ", each visited " +
                     std::to_string(set.fewest_visits) + " times or more</h2>\n";
  std::vector<TableRow> rows;
  const auto add_length = [&](const char* name, const std::optional<Largest>& largest,
                              const std::optional<double>& own, double decimals_of) {
    if (largest)
      rows.push_back({name, figure_mm(largest->value, decimals_of), mm_as_known(own, decimals_of),
                      escaped(largest->pose)});
  };
  const auto add_angle = [&](const char* name, const std::optional<Largest>& largest) {
    if (largest)
      rows.push_back({name, rounded(largest->value / kMilliradian), "", escaped(largest->pose)});
  };
  const std::optional<double> of_rp = set.rp_expanded();
  add_length("pose accuracy AP, mm", set.ap, expanded, expanded);
  add_length("pose repeatability RP, mm", set.rp, of_rp, of_rp.value_or(0));
  add_angle("AP of an angle, mrad", set.ap_turn);
  add_angle("RP of an angle, &plusmn; mrad", set.rp_turn);
  add_length("multi-directional variation vAP, mm", set.vap, {}, 0);
  add_angle("vAP of an angle, mrad", set.vap_turn);
  add_length("drift of AP, mm", set.drift_ap, {}, 0);
  add_length("drift of RP, mm", set.drift_rp, {}, 0);
  add_angle("drift of AP of an angle, mrad", set.drift_ap_turn);
  add_angle("drift of RP of an angle, mrad", set.drift_rp_turn);
  return html + table({"largest", "value", "U", "pose"}, rows);
}

std::string path_table(const PathFigures& path, const Budget& budget) {
  std::vector<TableRow> rows{{"path accuracy AT, mm", figure_mm(path.at, budget.expanded),
                              mm_as_known(budget.expanded, budget.expanded)}};
  const std::optional<double> of_rt = path.rt_expanded();
  if (path.rt)
    rows.push_back({"path repeatability RT, mm", figure_mm(*path.rt, of_rt.value_or(0)),
                    mm_as_known(of_rt, of_rt.value_or(0))});
  return "<h2>Path, recorded " + std::to_string(path.passes) + " times</h2>\n" +
         table({"largest of " + std::to_string(path.planes) + " planes", "value", "U"}, rows);
}

std::string budget_table(const std::string& figure, const Budget& budget) {
  std::vector<TableRow> rows;
  for (const BudgetRow& row : budget.rows)
    rows.push_back({row.source, row.distribution, rounded(row.standard / kMillimetre), "1"});
  rows.push_back({"combined", "", rounded(budget.combined / kMillimetre), ""});
  rows.push_back({"expanded U, k = " + rounded(budget.k), "",
                  mm_as_known(budget.expanded, budget.expanded), ""});
  return "<h2>Uncertainty of " + figure + " (GUM)</h2>\n" +
         table({"source", "distribution", "standard uncertainty, mm", "sensitivity"}, rows);
}

std::string poses_table(const std::vector<PoseFigures>& poses, double expanded) {
  std::vector<TableRow> rows;
  const auto ap = [&](const std::optional<double>& value) { return mm_as_known(value, expanded); };
  const auto mm = [](const std::optional<double>& value) { return mm_as_known(value, 0); };
  for (const PoseFigures& figures : poses)
    rows.push_back({escaped(figures.pose), std::to_string(figures.visits),
                    figure_mm(figures.ap, expanded), ap(figures.ap_axes.x()),
                    ap(figures.ap_axes.y()), ap(figures.ap_axes.z()), mm(figures.rp),
                    mm(figures.vap), mm(figures.drift_ap), mm(figures.drift_rp)});
  return "<h2>Poses, mm</h2>\n" +
         table({"pose", "visits", "AP", "AP<sub>x</sub>", "AP<sub>y</sub>", "AP<sub>z</sub>", "RP",
                "vAP", "drift of AP", "drift of RP"},
               rows);
}

std::string comparison_table(const Comparison& comparison) {
  std::vector<TableRow> rows;
  const auto add = [&](const std::vector<CertifiedChange>& differences, const std::string& prefix) {
    for (const CertifiedChange& difference : differences) {
      const auto mm = [&](const std::optional<double>& value) {
        return mm_as_known(value, difference.expanded.value_or(0));
      };
      rows.push_back({prefix + escaped(difference.name), mm(difference.before), mm(difference.now),
                      mm(difference.difference), mm(difference.expanded),
                      difference.significant ? "yes" : "no"});
    }
  };
  add(comparison.figures, "");
  add(comparison.poses, "ap of ");
  const std::string doubt = doubt_of_poses(comparison);
  return "<h2>Compared with the certificate of " + escaped(comparison.date_before) + ", mm</h2>\n" +
         table({"", "before", "now", "difference", "U", "significant"}, rows) +
         (doubt.empty() ? "" : paragraph("Doubt: " + escaped(doubt) + "."));
}

void add_notes(Page& page, const std::vector<std::string>& notes) {
  if (notes.empty()) return;
  page.section("Notes");
  std::vector<std::string> items;
  std::ranges::transform(notes, std::back_inserter(items), escaped);
  page.list(items);
}

}  // namespace

int decimals_shown(const Certificate& certificate) {
  constexpr int kMore = 3;
  const int decimals = decimals_of_figure(certificate.all.ap.value / kMillimetre,
                                          certificate.budget.expanded / kMillimetre);
  for (int more = 0; certificate.decision && more <= kMore; ++more)
    if (law_holds(certificate, decimals + more)) return decimals + more;
  return decimals;  // without a decision, or undecided for another reason, which the notes say
}

std::string certificate_page(const Certificate& certificate,
                             const std::optional<Comparison>& comparison, const PageHead& head) {
  const double expanded = certificate.budget.expanded;
  PageHead stated = head;
  stated.about = certificate.about;
  const bool has_poses = certificate.has_poses();
  Page page(stated, certificate.about.type,
            has_poses ? "Certificate of pose accuracy" : "Certificate of path accuracy");
  add_decision(page, certificate);
  page.add(conditions_line(certificate));
  if (certificate.cube) page.add(figures_table("Poses of the cube", *certificate.cube, expanded));
  if (has_poses) page.add(figures_table("All poses", certificate.all, expanded));
  if (certificate.path) page.add(path_table(*certificate.path, *certificate.path_budget));
  page.add(paragraph("After ISO 9283:1998; axes of the instrument's frame."));
  if (has_poses) page.add(budget_table("AP", certificate.budget));
  if (certificate.path_budget) page.add(budget_table("AT", *certificate.path_budget));
  if (comparison) page.add(comparison_table(*comparison));
  add_notes(page, certificate.notes);
  if (has_poses) page.add(poses_table(certificate.poses, expanded));
  page.section("Files");
  page.add(page.inputs());
  page.add(
      "<table class=\"sign\"><tr><th scope=\"col\">Place, date</th><th "
      "scope=\"col\">Signature</th></tr></table>\n");
  return page.finish(false).html;
}

}  // namespace armtrue
