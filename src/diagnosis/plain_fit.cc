#include "diagnosis/plain_fit.h"

#include <numeric>
#include <stdexcept>

#include "armtrue/calibration/observation.h"
#include "campaign/selection.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {

std::optional<PlainFit> fit_plainly(const Robot& given, const Campaign& campaign) {
  constexpr int kMostRows = 500;
  constexpr double kResolution = 1e-7;  // m: what is left below it is rounding of the file
  std::vector<int> rows(campaign.pose.size());
  std::iota(rows.begin(), rows.end(), 0);
  Campaign readings = campaign.select(evenly_chosen(rows, kMostRows));
  Robot robot = given;
  robot.effects.clear();
  robot.identify = {"auto"};
  try {
    CalibrationResult result = calibrate(robot, readings, {.robust = false});
    if (result.spread.position < kResolution) return std::nullopt;
    return PlainFit{std::move(readings), std::move(result)};
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // too few readings
  }
}

FitEquations fit_equations(const PlainFit& fit, const std::vector<int>& further_parameters) {
  std::vector<int> parameters = fit.result.set.kept;
  const auto kept = static_cast<Eigen::Index>(parameters.size());
  parameters.insert(parameters.end(), further_parameters.begin(), further_parameters.end());
  const ObservationModel model(fit.readings, fit.result.robot, parameters, fit.result.sigma, 0);
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
  const int size = model.row_size();
  Eigen::MatrixXd blocks(model.rows() * size, model.unknowns() + 1);
  Eigen::MatrixXd block(size, model.unknowns() + 1);
  for (int row = 0; row < model.rows(); ++row) {
    at.block(row, block);
    blocks.middleRows(row * size, size) = block;
  }
  Eigen::MatrixXd fitted = blocks.leftCols(kept);
  for (Eigen::Index k = 0; k < kept; ++k) fitted.col(k).normalize();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(fitted);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(blocks.rows(), qr.rank());
  basis = qr.householderQ() * basis;
  Eigen::VectorXd residual = blocks.rightCols<1>();
  residual -= basis * (basis.transpose() * residual);
  return {size, basis, blocks.middleCols(kept, std::ssize(further_parameters)), residual};
}

}  // namespace armtrue
