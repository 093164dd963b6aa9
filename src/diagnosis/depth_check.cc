#include "diagnosis/depth_check.h"

#include <fmt/format.h>

#include <cmath>
#include <set>
#include <vector>

#include "armtrue/calibration/observation.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

struct Direction3 {
  std::string name;
  bool is_of_tool;  // in the measured frame, else in R_A
  Eigen::Vector3d axis;
};

// By how much each reading moves by e = 1, whitened; orientations do not.
Eigen::VectorXd stretch(const Direction3& direction, const PlainFit& fit, int row_size) {
  const Campaign& readings = fit.readings;
  const ObservationModel model(readings, fit.result.robot, {}, fit.result.sigma, 0);
  Eigen::VectorXd column(readings.rows() * row_size);
  for (int row = 0; row < readings.rows(); ++row) {
    const Eigen::Vector3d& point = readings.position[row];
    const Eigen::Vector3d axis = direction.is_of_tool
                                     ? readings.orientation[row] * direction.axis
                                     : direction.axis;
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
  if (readings.has_distances() || readings.has_touches()) return std::nullopt;
  std::vector<Direction3> directions{{"x of R_A", false, Eigen::Vector3d::UnitX()},
                                     {"y of R_A", false, Eigen::Vector3d::UnitY()},
                                     {"z of R_A", false, Eigen::Vector3d::UnitZ()}};
  if (readings.has_orientation())
    directions.push_back({"z of the measured frame", true, Eigen::Vector3d::UnitZ()});
  const FitEquations equations = fit_equations(fit, {});
  const auto poses =
      static_cast<double>(std::set<int>(readings.pose.begin(), readings.pose.end()).size());
  std::optional<Suspicion> best;
  for (const Direction3& direction : directions) {
    const Eigen::MatrixXd column = stretch(direction, fit, equations.row_size);
    const JointFit found = fit_beside(column, equations);
    const double scale = found.value[0];
    const double score =
        fall_of_bic(found, equations, poses, static_cast<double>(directions.size()));
    if (std::abs(scale) < kLeastScale || found.share < kShareThatMatters || score < kClearFall ||
        score <= (best ? best->score : 0) || !is_of_most(column * found.value, equations))
      continue;
    best = Suspicion{score,
                     fmt::format("along {} the readings are {:.2g} % too {}, across it they are "
                                 "not: is it the depth of a camera, with a wrong focal length? "
                                 "Calibrate the camera anew; base and tool are wrong by as much",
                                 direction.name, 100 * std::abs(scale),
                                 scale > 0 ? "long" : "short")};
  }
  return best;
}

}  // namespace armtrue
