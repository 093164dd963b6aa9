#include "diagnosis/depth_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "armtrue/observation/observation.h"

namespace armtrue {
namespace {

// Along which a scale may be wrong.
struct SightLine {
  std::string name;
  bool is_of_tool;  // in the measured frame, else in R_A
  Eigen::Vector3d axis;

  Eigen::Vector3d at(const Campaign& readings, int row) const {
    return is_of_tool ? readings.orientation[row] * axis : axis;
  }
};

std::vector<SightLine> sight_lines(const Campaign& readings) {
  std::vector<SightLine> lines{{"x of R_A", false, Eigen::Vector3d::UnitX()},
                               {"y of R_A", false, Eigen::Vector3d::UnitY()},
                               {"z of R_A", false, Eigen::Vector3d::UnitZ()}};
  if (readings.has_orientation())
    lines.push_back({"z of the measured frame", true, Eigen::Vector3d::UnitZ()});
  return lines;
}

std::string in_words(const SightLine& line, double scale) {
  return fmt::format(
      "along {} the readings are {:.2g} % too {}, across it they are not: is it the depth of a "
      "camera, with a wrong focal length? Calibrate the camera anew; base and tool are wrong by as "
      "much",
      line.name, 100 * std::abs(scale), scale > 0 ? "long" : "short");
}

Campaign without_scale(const Campaign& campaign, const SightLine& line, double scale) {
  Campaign corrected = campaign;
  for (int row = 0; row < campaign.rows(); ++row) {
    const Eigen::Vector3d axis = line.at(campaign, row);
    corrected.position[row] -= axis * axis.dot(campaign.position[row]) * scale / (1 + scale);
  }
  return corrected;
}

// By how much each reading moves by e = 1, whitened; orientations do not.
Eigen::VectorXd stretch(const SightLine& line, const PlainFit& fit, int row_size) {
  const Campaign& readings = fit.readings;
  const ObservationModel model(readings, fit.result.robot, {}, fit.result.sigma, 0);
  Eigen::VectorXd column(readings.rows() * row_size);
  for (int row = 0; row < readings.rows(); ++row) {
    const Eigen::Vector3d& point = readings.position[row];
    const Eigen::Vector3d axis = line.at(readings, row);
    Eigen::Matrix<double, 6, 1> moved = Eigen::Matrix<double, 6, 1>::Zero();
    moved.head<3>() = axis * axis.dot(point);
    column.segment(row * row_size, row_size) = model.whitened(row, moved);
  }
  return column;
}

}  // namespace

std::optional<Suspicion> find_depth_scale(const PlainFit& fit) {
  constexpr double kLeastScale = 3e-3, kShareThatMatters = 0.25;
  const Campaign& readings = fit.readings;
  if (readings.reads_one_number() || readings.has_touches()) return std::nullopt;
  const std::vector<SightLine> lines = sight_lines(readings);
  const FitEquations equations = fit_equations(fit, {});
  const double poses = fit.poses();
  std::optional<Suspicion> best;
  for (const SightLine& line : lines) {
    const Eigen::MatrixXd column = stretch(line, fit, equations.row_size);
    const JointFit found = fit_beside(column, equations);
    const double scale = found.value[0];
    const double score =
        fall_of_bic(found, equations, poses, static_cast<double>(lines.size()));
    if (std::abs(scale) < kLeastScale || found.share < kShareThatMatters || score < kClearFall ||
        score <= (best ? best->score : 0) || !is_of_most(column * found.value, equations))
      continue;
    best = Suspicion{score, in_words(line, scale)};
  }
  return best;
}

std::optional<std::string> find_gross_depth_scale(
    const Campaign& campaign, const std::function<double(const Campaign&)>& miss) {
  constexpr double kShort = -0.2, kLong = 0.25, kTenth = 0.1;
  constexpr int kSteps = 18;  // of the golden section: to 0.01 % of the scale
  constexpr double kGolden = 0.61803398875;
  if (campaign.reads_one_number() || campaign.has_touches()) return std::nullopt;
  double least = kTenth * miss(campaign);
  std::optional<std::string> found;
  for (const SightLine& line : sight_lines(campaign)) {
    const auto miss_at = [&](double scale) { return miss(without_scale(campaign, line, scale)); };
    double low = kShort, high = kLong;
    double inner = high - kGolden * (high - low), outer = low + kGolden * (high - low);
    double at_inner = miss_at(inner), at_outer = miss_at(outer);
    for (int step = 0; step < kSteps; ++step) {
      if (at_inner < at_outer) {
        high = outer;
        outer = inner;
        at_outer = at_inner;
        inner = high - kGolden * (high - low);
        at_inner = miss_at(inner);
      } else {
        low = inner;
        inner = outer;
        at_inner = at_outer;
        outer = low + kGolden * (high - low);
        at_outer = miss_at(outer);
      }
    }
    if (std::min(at_inner, at_outer) >= least) continue;
    least = std::min(at_inner, at_outer);
    found = in_words(line, (low + high) / 2);
  }
  return found;
}

}  // namespace armtrue
