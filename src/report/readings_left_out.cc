#include "report/readings_left_out.h"

#include <fmt/format.h>

#include <algorithm>

#include "armtrue/kinematics/units.h"

namespace armtrue {

void add_readings_left_out(Page& page, const std::vector<GrossPose>& gross,
                           const std::vector<int>& lines, const std::string& key) {
  constexpr size_t kMostLines = 40;
  if (gross.empty() && lines.empty()) return;
  page.section("Readings left out");
  if (!gross.empty()) {
    std::vector<TableRow> rows;
    for (size_t k = 0; k < gross.size(); ++k) {
      const std::string of = fmt::format("{}gross_poses/{}/", key, k);
      rows.push_back({keyed(gross[k].id, of + "pose"),
                      keyed(gross[k].off / kMillimetre, of + "off_mm"),
                      keyed(gross[k].likely, of + "likely")});
    }
    page.add(table({"pose", "off by, mm", "what would explain it"}, rows));
  }
  if (lines.empty()) return;
  std::string text =
      fmt::format("{} {} of the file:", lines.size(), lines.size() == 1 ? "line" : "lines");
  for (size_t k = 0; k < std::min(kMostLines, lines.size()); ++k)
    text += (k > 0 ? ", " : " ") +
            keyed(std::to_string(lines[k]), fmt::format("{}excluded_rows/{}", key, k));
  page.add(paragraph(text + (lines.size() > kMostLines ? ", ..." : ".")));
}

}  // namespace armtrue
