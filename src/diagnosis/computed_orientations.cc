#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/observation.h"
#include "armtrue/observation/placement.h"
#include "armtrue/statistics/summary.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

// One reading of each pose of the largest session, of some 200 poses.
Campaign some_orientations(const Campaign& campaign) {
  constexpr long kMostPoses = 200;
  const std::vector<std::vector<int>> sessions = rows_by_session(campaign);
  std::vector<bool> is_seen(campaign.pose_ids.size(), false);
  std::vector<int> rows;
  const auto size = [](const std::vector<int>& own) { return own.size(); };
  for (int row : *std::ranges::max_element(sessions, {}, size))
    if (!is_seen[campaign.pose[row]]) {
      is_seen[campaign.pose[row]] = true;
      rows.push_back(row);
    }
  return campaign.select(evenly_chosen(rows, kMostPoses));
}

// The turns of base and tool and, if `with_links`, all angles of the links.
std::vector<int> angles(const KinematicChain& chain, bool with_links) {
  std::vector<int> parameters;
  for (const int first : {kFirstBaseParameter, layout_of(chain).tool})
    for (int axis = 3; axis < kParametersPerPose; ++axis) parameters.push_back(first + axis);
  for (int link = 0; with_links && link < link_count(chain); ++link)
    for (const LinkParameter which :
         {LinkParameter::alpha, LinkParameter::theta, LinkParameter::beta})
      parameters.push_back(link_parameter(link, which));
  return parameters;
}

// The robot with base and tool turned so that its orientations are near those that were read. With B
// and T these turns, R_k = B F_k T, so that the turns from one pose to another have the same axes but
// for B. The points take no part: orientations of a controller may be in a frame of its own.
Robot turned_to_orientations(Robot robot, const Campaign& readings) {
  robot.chain.base.rotation.setIdentity();
  robot.chain.tool.rotation.setIdentity();
  const RobotModel model(robot);
  std::vector<Eigen::Matrix3d> of_arm;
  for (int row = 0; row < readings.rows(); ++row)
    of_arm.push_back(model.pose(readings.context(row)).rotation);
  const auto vector = [](const Eigen::Matrix3d& rotation) -> Eigen::Vector3d {
    const Eigen::AngleAxisd turn(rotation);
    return turn.angle() * turn.axis();
  };
  const Eigen::Index motions = std::ssize(of_arm) - 1;
  Eigen::Matrix3Xd by_arm(3, motions), by_readings(3, motions);
  for (Eigen::Index k = 0; k < motions; ++k) {
    by_arm.col(k) = vector(of_arm[k + 1] * of_arm[k].transpose());
    by_readings.col(k) = vector(
        (readings.orientation[k + 1] * readings.orientation[k].conjugate()).toRotationMatrix());
  }
  const Eigen::Matrix4d turn = Eigen::umeyama(by_arm, by_readings, false);
  robot.chain.base.rotation = turn.topLeftCorner<3, 3>();
  std::vector<Eigen::Matrix3d> turns;
  for (size_t k = 0; k < of_arm.size(); ++k)
    turns.emplace_back((robot.chain.base.rotation * of_arm[k]).transpose() *
                       readings.orientation[k].toRotationMatrix());
  robot.chain.tool.rotation = common_turn(turns).first;
  return robot;
}

// Median angle between the orientations and those of the robot with these angles fitted to the
// orientations alone [rad].
double turn_left(Robot robot, const Campaign& readings, const std::vector<int>& parameters) {
  constexpr int kSteps = 4;           // of Newton and Gauss, from angles right to some mrad
  constexpr double kIndependent = 1e-4;  // smaller shares of a column: a step would be far too long
  std::vector<double> left;
  for (int step = 0; step <= kSteps; ++step) {
    const ObservationModel model(readings, robot, parameters, {1, 1}, 0);
    const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
    Eigen::MatrixXd block(model.row_size(), model.unknowns() + 1);
    Eigen::MatrixXd columns(3 * model.rows(), model.unknowns());
    Eigen::VectorXd residual(3 * model.rows());
    left.clear();
    for (int row = 0; row < model.rows(); ++row) {
      at.block(row, block);
      columns.middleRows(3 * row, 3) = block.bottomLeftCorner(3, model.unknowns());
      residual.segment<3>(3 * row) = block.bottomRightCorner<3, 1>();
      left.push_back(residual.segment<3>(3 * row).norm());
    }
    if (step == kSteps) break;
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr(columns.rows(), columns.cols());
    qr.setThreshold(kIndependent);
    qr.compute(columns);
    robot = model.robot_at(qr.solve(residual));
  }
  return median(left);
}

// How much the readings of the points scatter about a calibrated arm [m]; nothing if they are too
// few.
std::optional<double> spread_of_points(const Robot& robot, const Campaign& campaign) {
  try {
    return calibrate(robot, campaign, {.robust = false, .statistics = FitStatistics::weights})
        .sigma.position;
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

}  // namespace

void leave_out_orientations(Campaign& campaign) {
  campaign.orientation.clear();
  campaign.sigma_orientation.clear();
  if (campaign.sigma_position.empty()) campaign.whitening.clear();
}

std::optional<std::string> find_computed_orientations(const Robot& given,
                                                      const Campaign& campaign) {
  constexpr int kFewestPoses = 20;
  constexpr double kAsNoInstrumentTurns = 1e-5;  // rad: of a measured point and of joints at rest
  constexpr double kOfPoints = 0.1;  // an arm that is made wrong errs in angles as in lengths
  constexpr double kMuchWorse = 2;
  // What a controller has written down is rounded; below it is a simulation without noise.
  constexpr double kRounding = 1e-10;  // rad
  constexpr double kLeastNoise = 1e-6;  // m, of points that an instrument has read
  if (!campaign.has_orientation()) return std::nullopt;
  Robot robot = given;
  robot.effects.clear();
  const Campaign readings = some_orientations(campaign);
  if (readings.rows() < kFewestPoses) return std::nullopt;
  robot = robot_at_row(robot, readings, 0);
  const auto placement = place_base_and_tool(robot, readings, kImplausibleMiss);
  if (!placement || median(placement->miss) > kImplausibleMiss) return std::nullopt;
  const Robot turned = turned_to_orientations(robot, readings);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : readings.position) middle += point / readings.rows();
  double radius = 0;
  for (const Eigen::Vector3d& point : readings.position)
    radius += (point - middle).norm() / readings.rows();

  // The controller computes them with the model of the robot file, or with one of its own.
  const double by_file = turn_left(turned, readings, angles(turned.chain, false));
  const bool is_of_file = by_file * radius < kOfPoints * median(placement->miss);
  const double left =
      is_of_file ? by_file : turn_left(turned, readings, angles(turned.chain, true));
  if (!is_of_file && left > kAsNoInstrumentTurns) return std::nullopt;

  // What the instrument reads agrees with itself: orientations that contradict its points by much
  // are not its own, and none are that have no noise beside points that have some. The latter may
  // move no point, where the model of the controller is that of the arm.
  Robot calibrated = given;
  calibrated.effects.clear();
  calibrated.identify = {"auto"};
  calibrated.identify_per_session.clear();
  Campaign alone = readings;
  leave_out_orientations(alone);
  const auto together = spread_of_points(calibrated, readings),
             apart = spread_of_points(calibrated, alone);
  if (!apart) return std::nullopt;
  const bool moves_points = together && *together >= kMuchWorse * *apart;
  const bool is_without_noise =
      left <= kAsNoInstrumentTurns && left > kRounding && *apart > kLeastNoise;
  if (!moves_points && !is_without_noise) return std::nullopt;
  const std::string and_points =
      moves_points ? fmt::format("and beside them the points scatter by {:.2g} mm about a "
                                 "calibrated arm, without them by {:.2g} mm",
                                 *together / kMillimetre, *apart / kMillimetre)
                   : fmt::format("and the points scatter by {:.2g} mm about a calibrated arm",
                                 *apart / kMillimetre);
  return fmt::format(
      "{} to {:.2g} mrad (median), as no instrument reads, {}: they look computed by the "
      "controller from the joint angles, and are left out; give those of the instrument, or remove "
      "the columns",
      is_of_file ? "the robot file, turned as a whole, gives the orientations"
                 : "a model of the arm gives the orientations",
      left / kMilliradian, and_points);
}

}  // namespace armtrue
