#include "armtrue/io/mirror_io.h"

#include <fmt/format.h>

#include <cmath>

#include "armtrue/kinematics/pose.h"
#include "armtrue/kinematics/units.h"
#include "yaml_text.h"

namespace armtrue {
namespace {

std::string millimetres(double value) { return rounded(value / kMillimetre); }

YAML::Node pass_node(const Pass& pass, const std::string& file) {
  const ClockFit& clock = pass.clock;
  YAML::Node node;
  node["file"] = file;
  node["samples"] = std::to_string(pass.samples);
  node["lost_samples"] = std::to_string(pass.lost);
  node["longest_gap_s"] = rounded(pass.longest_gap);
  node["offset_s"] = fmt::format("{:.6f}", clock.offset);
  node["offset_std_s"] = rounded(clock.offset_deviation);
  const auto [low, high] = clock.offset_ci95();
  node["offset_ci95_s"] = flow_list({std::round(low * 1e6) / 1e6, std::round(high * 1e6) / 1e6});
  node["rate_ppm"] = rounded(clock.rate * 1e6);
  node["rate_std_ppm"] = rounded(std::sqrt(clock.covariance(1, 1)) * 1e6);
  const Pose& frame = clock.program_from_instrument;
  if (!frame.rotation.isIdentity(0) || !frame.translation.isZero(0)) {
    const Eigen::Vector3d abc = abc_from_rotation(frame.rotation);
    node["program_from_instrument"] =
        flow_map({{"x_mm", number_text(frame.translation[0], kMillimetre)},
                  {"y_mm", number_text(frame.translation[1], kMillimetre)},
                  {"z_mm", number_text(frame.translation[2], kMillimetre)},
                  {"a_deg", number_text(abc[0], kDegree)},
                  {"b_deg", number_text(abc[1], kDegree)},
                  {"c_deg", number_text(abc[2], kDegree)}});
  }
  return node;
}

}  // namespace

std::string write_mirror(const MirrorResult& result, const MirrorOptions& options,
                         const std::vector<std::string>& files, const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-mirror/1";
  root["provenance"] = provenance_node(provenance);
  for (size_t p = 0; p < files.size(); ++p)
    root["passes"].push_back(pass_node(result.passes[p], files[p]));
  const bool spline = options.points == CorrectionPoints::spline;
  std::vector<std::pair<std::string, std::string>> filter{
      {"kind", spline ? "smoothing-spline" : "butterworth"}};
  if (!spline) filter.emplace_back("order", std::to_string(options.order));
  filter.emplace_back("cut_off_hz", rounded(result.cutoff));
  filter.emplace_back("chosen", options.cutoff ? "given" : "auto");
  root["filter"] = flow_map(filter);
  const PathDeviation& deviation = result.deviation;
  root["noise"] =
      flow_map({{"sample_mm", millimetres(deviation.noise)},
                {"pass_to_pass_mm", files.size() > 1 ? millimetres(deviation.spread) : "null"}});
  root["deviation_mm"] = error_node(result.before, kMillimetre);
  if (result.uncorrected) root["uncorrected_mean_mm"] = millimetres(*result.uncorrected);
  root["expected_after_mean_mm"] = millimetres(result.expected_after);
  YAML::Node breaks(YAML::NodeType::Sequence);
  for (const Eigen::Index b : deviation.breaks)
    breaks.push_back(fmt::format("{:.3f}", deviation.time[b]));
  root["breaks_s"] = flow(breaks);
  root["correction"] =
      flow_map({{"gain", rounded(result.gain)},
                {"points", std::to_string(result.points.size())},
                {"largest_mm", millimetres(result.correction.colwise().norm().maxCoeff())},
                {"clipped_samples", std::to_string(result.clipped)}});
  return print_document(root);
}

std::string mirror_table(const MirrorResult& result, const std::vector<std::string>& files) {
  std::string table;
  for (size_t p = 0; p < files.size(); ++p) {
    const Pass& pass = result.passes[p];
    table += fmt::format(
        "{}: clock {:.4f} +- {:.4f} s ahead of the program (95 %), rate {:.0f} +- {:.0f} ppm, {} "
        "samples, {} lost\n",
        files[p], pass.clock.offset, 1.96 * pass.clock.offset_deviation, pass.clock.rate * 1e6,
        1.96e6 * std::sqrt(pass.clock.covariance(1, 1)), pass.samples, pass.lost);
  }
  const auto row = [&](const std::string& what, double value) {
    table += fmt::format("{:<44}{:>9.3f}\n", what, value / kMillimetre);
  };
  if (result.uncorrected) row("mean deviation without correction, mm", *result.uncorrected);
  row("mean deviation across the path, mm", result.before.mean);
  row("expected after the correction, mm", result.expected_after);
  row("noise of a sample, mm", result.deviation.noise);
  if (files.size() > 1) row("spread from pass to pass, mm", result.deviation.spread);
  table += fmt::format(
      "cut-off {:.3g} Hz, gain {:.3f}, {} correction points, {} breaks, {} samples clipped\n",
      result.cutoff, result.gain, result.points.size(), result.deviation.breaks.size(),
      result.clipped);
  return table;
}

std::string write_deviation(const PathDeviation& deviation) {
  std::string text = "t_s,s_mm,dx_mm,dy_mm,dz_mm,along_mm,trend_x_mm,trend_y_mm,trend_z_mm,break\n";
  size_t next = 0;
  for (Eigen::Index i = 0; i < deviation.time.size(); ++i) {
    const bool breaks = next < deviation.breaks.size() && deviation.breaks[next] == i;
    next += breaks;
    const Eigen::Vector3d normal = deviation.normal.col(i) / kMillimetre;
    const Eigen::Vector3d trend = deviation.trend.col(i) / kMillimetre;
    text += fmt::format("{:.6f},{:.4f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{}\n",
                        deviation.time[i], deviation.arc_length[i] / kMillimetre, normal[0],
                        normal[1], normal[2], deviation.along[i] / kMillimetre, trend[0], trend[1],
                        trend[2], breaks ? 1 : 0);
  }
  return text;
}

}  // namespace armtrue
