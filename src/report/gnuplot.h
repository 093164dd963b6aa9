#pragma once

#include <string>

namespace armtrue {

inline constexpr int kPlotWidth = 720, kPlotHeight = 300;

/// The SVG that gnuplot draws from a script (without `set terminal` and `set output`). Throws
/// std::runtime_error with the remedy if gnuplot is missing or rejects the script.
std::string plot_svg(const std::string& script, int width, int height);

/// The PNG that it draws, the same way.
std::string plot_png(const std::string& script, int width, int height);

/// The text as a quoted string of gnuplot.
std::string quoted(const std::string& text);

}  // namespace armtrue
