#include "report/prediction_parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "armtrue/compensation/prediction_conditions.h"

namespace armtrue {

void add_conditions(Page& page) {
  page.section("What this holds for");
  std::vector<std::string> items = page.values("assumed");
  items.emplace_back(kFramesNeeded);
  for (const std::string& effect : page.values("not_applied"))
    items.push_back("Not applied, because it belongs to the station, or may: " + effect);
  page.list(items);
}

Drawing rows_picture(const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                     const RowsText& text) {
  constexpr Eigen::Index kMostRows = 800;
  const std::vector<int> drawn = evenly(before.size(), kMostRows);
  const size_t rows = before.size();
  auto picture = std::make_shared<Picture>(
      text.file, text.title,
      text.note + (drawn.size() < rows ? fmt::format(" Of {} {}s {} are drawn, evenly spread.",
                                                     rows, text.axis, drawn.size())
                                       : std::string()),
      count_axis(static_cast<double>(rows), text.axis));
  double most = 0;
  Points first, second;
  std::vector<std::string> of_first, of_second;
  for (const int k : drawn)
    for (const auto& [values, points, texts, name] :
         {std::tuple(&before, &first, &of_first, &text.before),
          std::tuple(&after, &second, &of_second, &text.after)})
      if (const double value = (*values)[k]; std::isfinite(value)) {
        points->emplace_back(k + 1, value);
        if (!text.names.empty())
          texts->push_back(fmt::format("{}: {:.3g} mm, {}", text.names[k], value, *name));
        most = std::max(most, value);
      }
  Panel& panel = picture->panel(round_axis(0, most, "error, mm"), 190);
  panel.points(first, Look::before, text.before, of_first);
  panel.points(second, Look::after, text.after, of_second);
  return picture;
}

}  // namespace armtrue
