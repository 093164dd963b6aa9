#include "report/evaluation_parts.h"

#include "armtrue/kinematics/units.h"

namespace armtrue {

std::string errors_table(const std::vector<TabledModel>& models, const Campaign& campaign) {
  std::vector<TableRow> lengths, axes;
  for (const TabledModel& model : models) {
    const auto row = [&](const std::string& name, const std::vector<double>& errors, double unit,
                         const std::string& of) {
      lengths.push_back(
          error_cells(model.name + ", " + name, summarize(errors), unit, model.key + of));
    };
    row("mm", model.evaluation->reading_errors(), kMillimetre, "position_mm");
    if (!model.evaluation->orientation.empty())
      row("mrad", model.evaluation->orientation, kMilliradian, "orientation_mrad");
    for (const AxisErrors& axis : axis_errors(*model.evaluation, campaign)) {
      const std::string key = model.key + "axes_mm/" + axis.axis;
      axes.push_back({model.name + ", " + axis.axis, keyed_mm(axis.mean, key + "/mean"),
                      keyed_mm(axis.min, key + "/min"), keyed_mm(axis.max, key + "/max")});
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

std::string unseen_scale_text(const std::optional<UnseenScale>& scale, const std::string& key) {
  if (!scale) return "";
  return paragraph(
      "Poses do not show an error of the instrument's scale: lengths of the arm take it up. Each "
      "100 ppm of it would cost " +
      keyed_mm(scale->mean_cost(), key + "mean_mm_per_100_ppm") +
      " mm on average at these poses, " +
      keyed_mm(scale->max_cost(), key + "max_mm_per_100_ppm") + " mm at most.");
}

Page::Tile floor_tile(const NoiseFloor& noise, const std::string& key) {
  if (noise.source == NoiseFloor::Source::none)
    return {"Floor", "?", "no repeats, and no noise of the instrument is stated"};
  return {"Floor",
          keyed(noise.mean_error() / kMillimetre, key) + " mm",
          noise.source == NoiseFloor::Source::replicates ? "what repeats of a pose differ by"
                                                         : "noise of the instrument, as stated"};
}

}  // namespace armtrue
