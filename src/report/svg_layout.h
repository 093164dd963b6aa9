#pragma once

#include <string>

#include "report/svg.h"

namespace armtrue {

// Units of every picture's viewBox. A picture 340 px wide shows them at four fifths.
inline constexpr double kPictureWidth = 420;
inline constexpr double kLeft = 56, kRight = 14;  // beside the panels
inline constexpr double kRowHeight = 18;          // of a line of text
inline constexpr double kPanelGap = 14;
inline constexpr double kLetter = 7.9;  // widest mean width of a letter of 13 units
inline double width_of(const std::string& text) {
  return kLetter * static_cast<double>(text.size());
}

/// A coordinate with at most one decimal.
std::string coordinate_text(double value);

/// The CSS class of a look.
const char* class_of(Look look);

/// The mark of a look about a point.
std::string mark_path(const std::string& look, double x, double y);

}  // namespace armtrue
