#include "report/mirror_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ranges>

#include "armtrue/kinematics/units.h"
#include "report/residual_pictures.h"

namespace armtrue {
namespace {

constexpr Eigen::Index kMostPoints = 700;    // of a curve
constexpr Eigen::Index kMostSamples = 1200;  // of a cloud

Points curve(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  Points points;
  for (Eigen::Index i : peaks_kept(y, kMostPoints)) points.emplace_back(x[i], y[i]);
  return points;
}

std::string thinned_samples(Eigen::Index samples) {
  return samples > kMostPoints
             ? fmt::format(" Of {} samples the smallest and the largest of each stretch are drawn.",
                           samples)
             : std::string();
}

// An axis that holds 0 and reaches 0.01 mm to both sides at least, so that rounding errors do not
// look like a deviation.
Axis axis_of(const Eigen::VectorXd& values, const std::string& label, int most) {
  constexpr double kLeastSide = 0.01;  // mm
  return round_axis(std::min(-kLeastSide, values.minCoeff()),
                    std::max(kLeastSide, values.maxCoeff()), label, most);
}

Eigen::VectorXd lengths_mm(const Eigen::Matrix3Xd& vectors) {
  return vectors.colwise().norm().transpose() / kMillimetre;
}

Axis time_axis(const PathDeviation& deviation) {
  return exact_axis(deviation.time[0], deviation.time[deviation.time.size() - 1],
                    "time of the program, s");
}

// The correction beyond the one that these passes ran, on the grid of the deviation.
Eigen::Matrix3Xd new_correction(const Path& programmed, const MirrorResult& result,
                                const MirrorOptions& options) {
  Path correction = programmed;
  correction.position = result.correction;
  if (options.executed) correction.position -= *options.executed - programmed.position;
  return position_at(correction, result.deviation.time);
}

// "Joints turn back: q2 at 5.12 s, q3 at 5.2 s." Those of long programs are too many to name.
std::string reversals_text(const MirrorFindings& findings) {
  constexpr size_t kNamed = 8;
  if (!findings.reversals || findings.reversals->empty()) return "";
  std::string text;
  for (const auto& [time, joint] : *findings.reversals | std::views::take(kNamed))
    text +=
        fmt::format("{}{} at {:.2f} s", text.empty() ? " Joints turn back: " : ", ", joint, time);
  return text + (findings.reversals->size() > kNamed ? ", .." : ".");
}

}  // namespace

Drawing deviation_picture(const MirrorFindings& findings) {
  const PathDeviation& deviation = findings.result.deviation;
  auto picture = std::make_shared<Picture>(
      "deviation", "Deviation across the path",
      "Measured minus programmed, along each axis; steps at reversals and where the tool enters or "
      "leaves." +
          reversals_text(findings) + thinned_samples(deviation.time.size()),
      time_axis(deviation));
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::VectorXd values = deviation.normal.row(axis).transpose() / kMillimetre;
    Panel& panel = picture->panel(axis_of(values, fmt::format("{}, mm", "xyz"[axis]), 4), 80);
    for (const Eigen::Index b : deviation.breaks)
      panel.rule_x(deviation.time[b], Look::nominal, "break of the trend");
    if (findings.reversals)
      for (const MirrorFindings::Reversal& reversal : *findings.reversals)
        panel.rule_x(reversal.time, Look::after, "a joint turns back");
    for (const Engagement& interval : deviation.engagement.intervals) {
      if (interval.entry)
        panel.rule_x(interval.entry->time, Look::mark, "tool enters, tool leaves");
      if (interval.exit) panel.rule_x(interval.exit->time, Look::mark, "tool enters, tool leaves");
    }
    panel.line(curve(deviation.time, values), Look::before, "measured");
  }
  return picture;
}

Drawing path_picture(const Path& programmed, const MirrorResult& result) {
  const PathDeviation& deviation = result.deviation;
  const Eigen::Vector3d extent =
      programmed.position.rowwise().maxCoeff() - programmed.position.rowwise().minCoeff();
  const Eigen::Vector3d shown = extent + deviation.trend.cwiseAbs().rowwise().maxCoeff();
  std::array<int, 3> axes{0, 1, 2};
  std::ranges::stable_sort(axes, [&](int a, int b) { return shown[a] > shown[b]; });
  const double longest = std::max(deviation.trend.colwise().norm().maxCoeff(),
                                  result.correction.colwise().norm().maxCoeff());
  const double factor = round_magnification(longest, extent.maxCoeff());
  Eigen::Vector2d low(1e300, 1e300), high(-1e300, -1e300);
  const auto in_plane = [&](const Eigen::Matrix3Xd& positions) {
    Points points;
    for (Eigen::Index i : evenly(positions.cols(), kMostPoints)) {
      points.emplace_back(positions(axes[0], i) / kMillimetre, positions(axes[1], i) / kMillimetre);
      low = low.cwiseMin(points.back());
      high = high.cwiseMax(points.back());
    }
    return points;
  };
  const Points measured =
      in_plane(position_at(programmed, deviation.time) + factor * deviation.normal);
  const Points corrected = in_plane(programmed.position + factor * result.correction);
  const Points intended = in_plane(programmed.position);
  // Equal scales keep the shape of a contour; a nearly straight path would become too flat.
  const std::string right = fmt::format("{}, mm", "xyz"[axes[0]]);
  const std::string up = fmt::format("{}, mm", "xyz"[axes[1]]);
  const bool is_straight = extent[axes[1]] <= 0.1 * extent[axes[0]];
  const MapAxes map = is_straight ? MapAxes{exact_axis(low.x(), high.x(), right),
                                            round_axis(low.y(), high.y(), up, 5), 200}
                                  : map_axes(low, high, right, up);
  auto picture = std::make_shared<Picture>(
      "path", "Programmed, measured and corrected path",
      fmt::format("Measured and corrected: distance from the programmed path times {:g}.", factor),
      map.x);
  Panel& panel = picture->panel(map.y, map.height);
  panel.line(measured, Look::before, "measured");
  panel.line(corrected, Look::after, "corrected");
  panel.line(intended, Look::mark, "programmed");
  return picture;
}

Drawing correction_picture(const Path& programmed, const MirrorFindings& findings) {
  const MirrorResult& result = findings.result;
  const PathDeviation& deviation = result.deviation;
  const Eigen::VectorXd arc = deviation.arc_length / kMillimetre;
  const Eigen::VectorXd measured = lengths_mm(deviation.normal);
  const auto& earlier = findings.deviation_before;
  const Eigen::VectorXd before = earlier ? lengths_mm(earlier->normal) : measured;
  const Eigen::VectorXd arc_before = earlier ? earlier->arc_length / kMillimetre : arc;
  const std::string shown =
      earlier ? "Passes before the correction and with it; both hold the noise of the instrument, "
                "the expected mean of the next pass does not."
              : "The record less the correction still holds its noise; the expected mean of the "
                "next pass does not.";
  auto picture = std::make_shared<Picture>(
      "before-after", "Distance from the path, before and after",
      shown + thinned_samples(std::max(arc.size(), arc_before.size())),
      exact_axis(std::min(arc.minCoeff(), arc_before.minCoeff()),
                 std::max(arc.maxCoeff(), arc_before.maxCoeff()), "way along the path, mm"));
  const double most = std::max(before.maxCoeff(), measured.maxCoeff());
  Panel& panel = picture->panel(
      round_axis(0, std::max(most, result.expected_after / kMillimetre), "distance, mm"), 190);
  panel.line(curve(arc_before, before), Look::before, earlier ? "before" : "measured");
  if (earlier)
    panel.line(curve(arc, measured), Look::after, "measured");
  else
    panel.line(curve(arc, lengths_mm(deviation.normal +
                                     new_correction(programmed, result, findings.options))
                              .cwiseMin(most)),
               Look::after, "less the correction");
  panel.rule_y(result.expected_after / kMillimetre, Look::mark, "expected mean of the next pass");
  return picture;
}

Drawing trend_picture(const Path& programmed, const MirrorResult& result) {
  const PathDeviation& deviation = result.deviation;
  auto picture = std::make_shared<Picture>(
      "trend", "Trend and correction points",
      "The deviation without its noise; the correction is straight between the points." +
          thinned_samples(deviation.time.size()),
      time_axis(deviation));
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::VectorXd trend = deviation.trend.row(axis).transpose() / kMillimetre;
    Points points;
    for (const Eigen::Index sample : result.points) {
      const double time = std::clamp(programmed.time[sample], deviation.time[0],
                                     deviation.time[deviation.time.size() - 1]);
      const auto place = std::lround((time - deviation.time[0]) / deviation.period);
      points.emplace_back(time, trend[std::clamp<Eigen::Index>(place, 0, trend.size() - 1)]);
    }
    Points drawn;
    std::vector<std::string> texts;
    for (Eigen::Index k : evenly(points.size(), kMostPoints)) {
      drawn.push_back(points[k]);
      texts.push_back(
          fmt::format("{:.4g} s: {:.3g} mm along {}", points[k].x(), points[k].y(), "xyz"[axis]));
    }
    Panel& panel = picture->panel(axis_of(trend, fmt::format("{}, mm", "xyz"[axis]), 4), 80);
    panel.line(curve(deviation.time, trend), Look::after, "trend");
    panel.points(drawn, Look::mark, "correction point", texts);
  }
  return picture;
}

Drawing force_over_time(const PathDeviation& deviation) {
  auto picture = std::make_shared<Picture>(
      "force-time", "Force on the tool",
      "Along each axis, as recorded with the passes." + thinned_samples(deviation.time.size()),
      time_axis(deviation));
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::VectorXd values = deviation.force.row(axis).transpose();
    Panel& panel = picture->panel(axis_of(values, fmt::format("{}, N", "xyz"[axis]), 4), 80);
    panel.line(curve(deviation.time, values), Look::before, "measured");
  }
  return picture;
}

Drawing force_picture(const PathDeviation& deviation, const ForceLaw& law) {
  Eigen::Matrix3Xd forced = deviation.whole;
  for (int axis = 0; axis < 3; ++axis) forced.row(axis).array() -= law.offset[axis].value;
  // Evenly thinned: extremes alone would not show where most samples are.
  Points samples;
  double most_force = 0, most_mm = 0;
  for (Eigen::Index i : evenly(forced.cols(), kMostSamples)) {
    samples.emplace_back(deviation.force.col(i).norm(), forced.col(i).norm() / kMillimetre);
    most_force = std::max(most_force, samples.back().x());
    most_mm = std::max(most_mm, samples.back().y());
  }
  const double slope = law.magnitude.k ? law.magnitude.k->value / kMillimetre : 0;
  most_mm = std::max(most_mm, slope * most_force);
  auto picture = std::make_shared<Picture>(
      "force", "Deviation against force",
      fmt::format("Each sample while the force was measured.{}",
                  forced.cols() > kMostSamples
                      ? fmt::format(" Of {} samples {} are drawn, evenly spread.", forced.cols(),
                                    samples.size())
                      : ""),
      round_axis(0, most_force, "force, N"));
  Panel& panel = picture->panel(round_axis(0, most_mm, "deviation, mm"), 190);
  panel.points(samples, Look::before, "sample");
  if (law.magnitude.k)
    panel.line({{0, 0}, {most_force, slope * most_force}}, Look::mark, "fitted line");
  return picture;
}

}  // namespace armtrue
