#include "report/readings_left_out.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "armtrue/text/number_text.h"

namespace armtrue {

void add_readings_left_out(Page& page, const std::vector<GrossPose>& gross,
                           const std::vector<int>& lines, const std::string& key) {
  constexpr size_t kMostLines = 40;
  if (gross.empty() && lines.empty()) return;
  page.section("Readings left out");
  if (!gross.empty())
    page.add(table({"pose", "off by, mm", "what would explain it"},
                   page.rows(key + "gross_poses", {"pose", "off_mm", "likely"})));
  if (lines.empty()) return;
  std::vector<std::string> shown = page.values(key + "excluded_rows");
  shown.resize(std::min(kMostLines, shown.size()));
  const std::string text =
      fmt::format("{} of the file: {}", counted(lines.size(), "line"), fmt::join(shown, ", "));
  page.add(paragraph(text + (lines.size() > kMostLines ? ", ..." : ".")));
}

}  // namespace armtrue
