#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/certification/pose_accuracy.h"

namespace armtrue {

/// Sources of uncertainty that the readings do not show. All in SI.
struct StatedUncertainty {
  std::optional<double> noise;  ///< of the instrument, one standard deviation per axis
  /// Instead of the noise: maximum permissible error of the instrument, constant + per_metre x
  /// range, the half width of a rectangular distribution.
  double mpe_constant = 0, mpe_per_metre = 0;
  double mounting = 0;                ///< of the reflector or the probe, one standard deviation
  double temperature_half_width = 0;  ///< of the temperature of the arm [K]
  double expansion = 0;               ///< [1/K]
  double length = 0;                  ///< of the arm that expands
};

/// A line of the budget.
struct BudgetRow {
  std::string source;
  std::string distribution;  ///< normal or rectangular
  double standard = 0;       ///< standard uncertainty per axis; its sensitivity is 1 [m]
};

/// Uncertainty of AP or AT after JCGM 100:2008 (GUM).
struct Budget {
  std::vector<BudgetRow> rows;
  double combined = 0;  ///< u_c = root of the sum of squares [m]
  double freedom = 0;   ///< effective, Welch and Satterthwaite (G.4); infinite: all rows are stated
  double k = 2;         ///< coverage factor: Student's t for 95.45 %, 2 for many degrees of freedom
  double expanded = 0;  ///< U = k u_c [m]
};

/// `scatter`: of the visits about their means; `visits`: fewest visits of a pose. `range`: distance
/// from the instrument [m]. `model`: standard uncertainty of the commanded position per axis [m],
/// if the robot file states it.
///
/// The scatter s contains the noise of the instrument. So with a stated noise e the rows are
///     e / sqrt(n)  and  sqrt(max(0, s^2 - e^2)) / sqrt(n),
/// which combine to s / sqrt(n), or to e / sqrt(n) if s is smaller. `too_high`: half width of the
/// bias of the largest of many figures [m], see PathFigures::at_of_scatter. `of_frame`: standard
/// uncertainty by a fitted frame [m], see PathFigures::at_of_frame.
Budget budget_of(const StatedUncertainty& stated, const Scatter& scatter, int visits, double range,
                 const std::optional<double>& model, double too_high = 0, double of_frame = 0);

/// Whether a value meets a tolerance; see decide().
enum class Decision { pass, fail, undecided };

/// ISO 14253-1: pass if ap + U <= tolerance, fail if ap - U > tolerance, else undecided.
Decision decide(double ap, double expanded, double tolerance);

/// "pass", "fail" or "undecided".
std::string decision_name(Decision decision);

}  // namespace armtrue
