#include "report/evaluation_parts.h"

#include "armtrue/compensation/prediction_conditions.h"

namespace armtrue {

std::string errors_table(const Page& page, const std::vector<TabledModel>& models) {
  std::vector<TableRow> lengths, axes;
  for (const auto& [name, key] : models) {
    lengths.push_back(page.error_row(name + ", mm", key + "position_mm"));
    if (page.has(key + "orientation_mrad/mean"))
      lengths.push_back(page.error_row(name + ", mrad", key + "orientation_mrad"));
    for (const std::string axis : {"x", "y", "z", "l"}) {
      const std::string of = key + "axes_mm/" + axis;
      if (page.has(of + "/mean"))
        axes.push_back({name + ", " + axis, page.value(of + "/mean"), page.value(of + "/min"),
                        page.value(of + "/max")});
    }
  }
  return table({"length of the error", "mean", "RMS", "95 %", "max"}, lengths) +
         table({"axis", "mean, mm", "min, mm", "max, mm"}, axes);
}

void add_error_pictures(Page& page, const std::vector<Judged>& models, const Campaign& campaign,
                        const std::vector<bool>& left_out, const std::string& readings,
                        const Eigen::Vector3d& up) {
  page.section("Errors of the " + readings);
  page.pictures({histogram_picture(models, readings), axes_picture(models, campaign),
                 campaign_picture(models, campaign, left_out)});
  const size_t shown = std::min<size_t>(2, models.size());
  const std::vector<Drawing> maps =
      residual_maps({models.end() - shown, models.end()}, campaign, up);
  if (maps.empty()) return;
  page.section("Errors in the workspace");
  page.pictures(maps);
}

bool is_at_floor(double mean, const NoiseFloor& noise) {
  constexpr double kMaxTimesFloor = 1.3;  // few readings scatter
  return noise.source != NoiseFloor::Source::none &&
         mean <= kMaxTimesFloor * noise.mean_error();
}

std::string unseen_scale_text(const Page& page, const std::string& key) {
  if (!page.has(key + "mean_mm_per_100_ppm")) return "";
  return paragraph(
      "Poses do not show an error of the instrument's scale: lengths of the arm take it up. Each "
      "100 ppm of it would cost " +
      page.value(key + "mean_mm_per_100_ppm") + " mm on average at these poses, " +
      page.value(key + "max_mm_per_100_ppm") + " mm at most.");
}

std::string frames_text() {
  return paragraph(std::string("A program that is corrected with this robot needs ") +
                   kFramesNeeded + ".");
}

Page::Tile floor_tile(const Page& page, const NoiseFloor& noise, const std::string& key) {
  if (noise.source == NoiseFloor::Source::none)
    return {"Floor", "?", "no repeats, and no noise of the instrument is stated"};
  return {
      "Floor", page.value(key) + " mm",
      std::string("mean error of a perfect model, by the ") +
          (noise.source == NoiseFloor::Source::replicates ? "repeats of poses"
                                                          : "noise of the instrument as stated")};
}

}  // namespace armtrue
