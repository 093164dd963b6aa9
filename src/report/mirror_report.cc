#include "armtrue/report/mirror_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "armtrue/kinematics/units.h"
#include "report/gnuplot.h"
#include "report/html.h"

namespace armtrue {
namespace {

constexpr Eigen::Index kMaxPoints = 2000;  // of a curve
constexpr std::array<const char*, 3> kAxisNames{"x", "y", "z"};
constexpr std::array<const char*, 3> kAxisColours{"#d62728", "#2ca02c", "#1f77b4"};

struct Curve {
  Eigen::VectorXd x, y;
  std::string look;  // the style, as gnuplot's plot command has it
};

// Thins a curve: keeps the smallest and the largest value of each stretch, so that no peak is lost.
std::vector<Eigen::Index> thinned(const Eigen::VectorXd& values) {
  const Eigen::Index n = values.size();
  std::vector<Eigen::Index> kept;
  if (n <= kMaxPoints) {
    for (Eigen::Index i = 0; i < n; ++i) kept.push_back(i);
    return kept;
  }
  constexpr Eigen::Index stretches = kMaxPoints / 2;
  for (Eigen::Index k = 0; k < stretches; ++k) {
    const Eigen::Index begin = k * n / stretches, end = (k + 1) * n / stretches;
    Eigen::Index least = 0, largest = 0;
    values.segment(begin, end - begin).minCoeff(&least);
    values.segment(begin, end - begin).maxCoeff(&largest);
    kept.push_back(begin + std::min(least, largest));
    if (least != largest) kept.push_back(begin + std::max(least, largest));
  }
  return kept;
}

std::string draw(const std::string& settings, const std::vector<Curve>& curves,
                 const std::string& lines = "", int height = kPlotHeight) {
  std::ostringstream script;
  script.precision(8);
  script << "set grid\nset key tmargin center horizontal\n" << settings;
  for (size_t k = 0; k < curves.size(); ++k) {
    script << "$c" << k << " << END\n";
    for (const Eigen::Index i : thinned(curves[k].y))
      script << curves[k].x[i] << " " << curves[k].y[i] << "\n";
    script << "END\n";
  }
  for (size_t k = 0; k < curves.size(); ++k)
    script << (k == 0 ? "plot $c" : ", $c") << k << " using 1:2 " << curves[k].look;
  script << lines << "\n";
  return plot_svg(script.str(), kPlotWidth, height);
}

std::string in_colour(int axis) { return std::string(" lc rgb '") + kAxisColours[axis] + "'"; }

// Vertical lines in a plot against time, and their entries in its key.
struct Marks {
  std::ostringstream settings, key;

  void add(double time, const std::string& look) {
    settings << "set arrow from first " << time << ", graph 0 to first " << time
             << ", graph 1 nohead back " << look << "\n";
  }
  void explain(const std::string& look, const std::string& text) {
    key << ", NaN with lines " << look << " title " << quoted(text);
  }
};

Marks marks(const PathDeviation& deviation) {
  constexpr const char* kBreak = "lw 1 dt 2 lc rgb '#888888'";
  constexpr const char* kEntry = "lw 2 lc rgb '#000000'";
  constexpr const char* kExit = "lw 2 dt 4 lc rgb '#000000'";
  Marks result;
  result.settings.precision(8);
  for (const Eigen::Index b : deviation.breaks) result.add(deviation.time[b], kBreak);
  if (!deviation.breaks.empty()) result.explain(kBreak, "break of the trend");
  bool entries = false, exits = false;
  for (const Engagement& interval : deviation.engagement.intervals) {
    if (interval.entry) result.add(interval.entry->time, kEntry);
    if (interval.exit) result.add(interval.exit->time, kExit);
    entries = entries || interval.entry;
    exits = exits || interval.exit;
  }
  if (entries) result.explain(kEntry, "tool enters");
  if (exits) result.explain(kExit, "tool leaves");
  return result;
}

std::string deviation_plot(const PathDeviation& deviation) {
  std::vector<Curve> curves;
  for (int axis = 0; axis < 3; ++axis)
    curves.push_back({deviation.time, deviation.normal.row(axis).transpose() / kMillimetre,
                      "with lines" + in_colour(axis) + " title " + quoted(kAxisNames[axis])});
  const Marks marked = marks(deviation);
  return draw("set xlabel 'time of the program, s'\nset ylabel 'deviation across the path, mm'\n" +
                  marked.settings.str(),
              curves, marked.key.str());
}

std::string trend_plot(const Path& programmed, const MirrorResult& result) {
  const PathDeviation& deviation = result.deviation;
  const auto count = static_cast<Eigen::Index>(result.points.size());
  std::vector<Curve> curves;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name = kAxisNames[axis];
    const Eigen::VectorXd trend = deviation.trend.row(axis).transpose() / kMillimetre;
    Eigen::VectorXd time(count), value(count);
    for (Eigen::Index k = 0; k < count; ++k) {
      time[k] = programmed.time[result.points[static_cast<size_t>(k)]];
      const auto place =
          static_cast<Eigen::Index>(std::lround((time[k] - deviation.time[0]) / deviation.period));
      value[k] = trend[std::clamp<Eigen::Index>(place, 0, trend.size() - 1)];
    }
    curves.push_back(
        {deviation.time, trend, "with lines lw 2" + in_colour(axis) + " title " + quoted(name)});
    curves.push_back({time, value,
                      "with points pt 7 ps 0.5" + in_colour(axis) + " title " +
                          quoted(name + ", correction points")});
  }
  return draw("set xlabel 'time of the program, s'\nset ylabel 'trend, mm'\n", curves);
}

// 1, 2 or 5 times a power of ten, at most, by which `largest` is a tenth of `extent`; at least 1.
double magnification(double largest, double extent) {
  if (!(largest > 0) || !(extent > 0)) return 1;
  const double wanted = 0.1 * extent / largest;
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  const double digit = wanted / power;
  return std::max(1.0, power * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1));
}

// Programmed, measured and corrected path in the plane of the two axes of largest extent.
std::string path_plot(const Path& programmed, const MirrorResult& result) {
  const PathDeviation& deviation = result.deviation;
  const Eigen::Vector3d extent =
      programmed.position.rowwise().maxCoeff() - programmed.position.rowwise().minCoeff();
  const Eigen::Vector3d shown = extent + deviation.trend.cwiseAbs().rowwise().maxCoeff();
  std::array<int, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return shown[a] > shown[b]; });
  const double largest = std::max(deviation.trend.colwise().norm().maxCoeff(),
                                  result.correction.colwise().norm().maxCoeff());
  const double factor = magnification(largest, extent.maxCoeff());
  const auto curve = [&](const Eigen::Matrix3Xd& positions, const std::string& look) {
    return Curve{positions.row(axes[0]).transpose() / kMillimetre,
                 positions.row(axes[1]).transpose() / kMillimetre, look};
  };
  std::ostringstream settings;
  settings << "set xlabel '" << kAxisNames[axes[0]] << ", mm'\nset ylabel '" << kAxisNames[axes[1]]
           << ", mm'\nset title 'measured and corrected: distance from the programmed path times "
           << factor << "'\n";
  // Equal scales keep the shape of a contour; a nearly straight path would become too flat.
  if (extent[axes[1]] > 0.1 * extent[axes[0]]) settings << "set size ratio -1\n";
  const Eigen::Matrix3Xd on_grid = position_at(programmed, deviation.time);
  return draw(
      settings.str(),
      {curve(on_grid + factor * deviation.normal, "with lines lc rgb '#ff9896' title 'measured'"),
       curve(programmed.position + factor * result.correction,
             "with lines lw 2 lc rgb '#2ca02c' title 'corrected'"),
       curve(programmed.position, "with lines lw 2 lc rgb '#000000' title 'programmed'")},
      "", kPlotHeight + 120);
}

// The correction beyond the one that these passes ran, on the grid of the deviation.
Eigen::Matrix3Xd new_correction(const Path& programmed, const MirrorResult& result,
                                const MirrorOptions& options) {
  Path correction = programmed;
  correction.position = result.correction;
  if (options.executed) correction.position -= *options.executed - programmed.position;
  return position_at(correction, result.deviation.time);
}

std::string before_after_plot(const Path& programmed, const MirrorResult& result,
                              const MirrorOptions& options) {
  const PathDeviation& deviation = result.deviation;
  const Eigen::VectorXd arc = deviation.arc_length / kMillimetre;
  const auto length = [](const Eigen::Matrix3Xd& vectors) -> Eigen::VectorXd {
    return vectors.colwise().norm().transpose() / kMillimetre;
  };
  std::ostringstream expected;
  expected << ", " << result.expected_after / kMillimetre
           << " with lines lw 2 dt 2 lc rgb '#000000' title 'expected mean'";
  return draw(
      "set xlabel 'arc length, mm'\nset ylabel 'distance from the path, mm'\n"
      "set yrange [0:*]\n",
      {{arc, length(deviation.normal), "with lines lc rgb '#ff9896' title 'measured'"},
       {arc, length(deviation.normal + new_correction(programmed, result, options)),
        "with lines lc rgb '#98df8a' title 'less the correction'"},
       {arc, length(deviation.trend), "with lines lw 2 lc rgb '#d62728' title 'trend'"}},
      expected.str());
}

std::string force_plot(const PathDeviation& deviation, const ForceLaw& law) {
  Eigen::Matrix3Xd forced = deviation.whole;
  for (int axis = 0; axis < 3; ++axis)
    forced.row(axis).array() -= law.offset[static_cast<size_t>(axis)].value;
  // Every n-th sample: extremes would not show where most samples lie.
  const Eigen::Index stride = (deviation.time.size() + kMaxPoints - 1) / kMaxPoints;
  const Eigen::Index count = (deviation.time.size() + stride - 1) / stride;
  Eigen::VectorXd force(count), length(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    force[i] = deviation.force.col(i * stride).norm();
    length[i] = forced.col(i * stride).norm() / kMillimetre;
  }
  std::ostringstream line;
  if (law.magnitude.k)
    line << ", " << law.magnitude.k->value / kMillimetre
         << " * x with lines lw 2 lc rgb '#000000' title 'fitted line'";
  return draw(
      "set xlabel 'force, N'\nset ylabel 'deviation, mm'\nset xrange [0:*]\n"
      "set yrange [0:*]\n",
      {{force, length, "with points pt 7 ps 0.3 lc rgb '#1f77b4' title 'samples'"}}, line.str());
}

std::string fixed(double value, int decimals) {
  std::ostringstream text;
  text << std::fixed;
  text.precision(decimals);
  text << value;
  return text.str();
}

std::string numbers_table(const MirrorResult& result, const std::vector<std::string>& passes) {
  std::ostringstream html;
  const auto row = [&](const std::string& what, const std::string& value) {
    html << "<tr><td>" << escaped(what) << "</td><td>" << value << "</td></tr>\n";
  };
  const auto millimetres = [](double value) { return number(value / kMillimetre); };
  html << "<table>\n";
  if (result.uncorrected)
    row("mean deviation without correction, mm", millimetres(*result.uncorrected));
  row("mean deviation across the path, mm", millimetres(result.before.mean));
  row("expected after the correction, mm", millimetres(result.expected_after));
  row("expected if", result.expected_if());
  row("noise of a sample, mm", millimetres(result.deviation.noise));
  if (passes.size() > 1) row("spread from pass to pass, mm", millimetres(result.deviation.spread));
  for (size_t p = 0; p < passes.size(); ++p) {
    const ClockFit& clock = result.passes[p].clock;
    row(passes[p] + ": clock ahead of the program, s (95 %)",
        fixed(clock.offset, 4) + " &plusmn; " + fixed(1.96 * clock.offset_deviation(), 4));
  }
  row("cut-off, Hz", number(result.cutoff));
  row("gain", number(result.gain));
  row("correction points", std::to_string(result.points.size()));
  row("samples clipped", std::to_string(result.clipped));
  html << "</table>\n";
  return html.str();
}

std::string force_line(const ForceLaw& law) {
  if (!law.magnitude.k) return "<p>No force stands out of its noise.</p>\n";
  const Estimate& k = *law.magnitude.k;
  std::string html = "<p>Deviation over force: " + number(k.value / kMillimetre) +
                     " mm/N (95 %: " + number(k.ci95[0] / kMillimetre) + " to " +
                     number(k.ci95[1] / kMillimetre) + "), R<sup>2</sup> " +
                     number(law.magnitude.r2) +
                     ". What the tool deviates by without force is taken off.";
  if (!law.reversals.empty())
    html += " The steps at reversals are a part of the samples, but not of the line.";
  return html + "</p>\n";
}

}  // namespace

std::string mirror_report(const Path& programmed, const MirrorFindings& findings,
                          const std::string& title) {
  const MirrorResult& result = findings.result;
  std::string html = numbers_table(result, findings.files);
  html += "<h2>Deviation</h2>\n" + deviation_plot(result.deviation);
  html += "<h2>Path</h2>\n" + path_plot(programmed, result);
  html +=
      "<h2>Before and after</h2>\n<p>The record less the correction still holds its noise; the "
      "expected mean of the next pass does not.</p>\n" +
      before_after_plot(programmed, result, findings.options);
  html += "<h2>Trend and correction points</h2>\n" + trend_plot(programmed, result);
  if (const auto& force = findings.force)
    html += "<h2>Deviation against force</h2>\n" + force_line(*force) +
            force_plot(result.deviation, *force);
  return html_page(title, html);
}

}  // namespace armtrue
