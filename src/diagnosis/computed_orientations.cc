#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <stdexcept>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/doubts.h"
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

// An instrument does not read closer [rad]: of a measured point and of joints at rest.
constexpr double kAsNoInstrumentTurns = 1e-5;
constexpr int kFewestComputed = 20;

std::vector<int> rows_of_largest_session(const Campaign& campaign) {
  const std::vector<std::vector<int>> sessions = rows_by_session(campaign);
  return *std::ranges::max_element(sessions, {}, &std::vector<int>::size);
}

// One reading of each pose of the largest session, of some 200 poses.
Campaign some_orientations(const Campaign& campaign) {
  constexpr long kMostPoses = 200;
  std::vector<bool> is_seen(campaign.pose_ids.size(), false);
  std::vector<int> rows;
  for (int row : rows_of_largest_session(campaign))
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

// The turns of base and tool with which the orientations of the arm, F_k, are near those that were
// read. With B and T these turns, R_k = B F_k T, so that the turns from one pose to another have
// the same axes but for B. The points take no part: orientations of a controller may be in a frame
// of its own.
struct Turns {
  Eigen::Matrix3d base, tool;
  double left(const Eigen::Matrix3d& of_arm, const Eigen::Matrix3d& read) const {
    return Eigen::AngleAxisd(Eigen::Matrix3d(read.transpose() * base * of_arm * tool)).angle();
  }
};

Turns turns_between(const std::vector<Eigen::Matrix3d>& of_arm,
                    const std::vector<Eigen::Matrix3d>& read) {
  const auto motion = [](const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
    const Eigen::AngleAxisd turn{Eigen::Matrix3d(to * from.transpose())};
    return Eigen::Vector3d(turn.angle() * turn.axis());
  };
  const Eigen::Index motions = std::ssize(of_arm) - 1;
  Eigen::Matrix3Xd by_arm(3, motions), by_readings(3, motions);
  for (Eigen::Index k = 0; k < motions; ++k) {
    by_arm.col(k) = motion(of_arm[k], of_arm[k + 1]);
    by_readings.col(k) = motion(read[k], read[k + 1]);
  }
  Turns found;
  found.base = Eigen::umeyama(by_arm, by_readings, false).topLeftCorner<3, 3>();
  std::vector<Eigen::Matrix3d> turns;
  for (size_t k = 0; k < of_arm.size(); ++k)
    turns.emplace_back((found.base * of_arm[k]).transpose() * read[k]);
  found.tool = common_turn(turns).first;
  return found;
}

std::vector<Eigen::Matrix3d> orientations_of_arm(Robot robot, const Campaign& readings) {
  robot.chain.base.rotation.setIdentity();
  robot.chain.tool.rotation.setIdentity();
  const RobotModel model(robot);
  std::vector<Eigen::Matrix3d> of_arm;
  for (int row = 0; row < readings.rows(); ++row)
    of_arm.push_back(model.pose(readings.context(row)).rotation);
  return of_arm;
}

std::vector<Eigen::Matrix3d> orientations_read(const Campaign& readings) {
  std::vector<Eigen::Matrix3d> read;
  for (const Eigen::Quaterniond& orientation : readings.orientation)
    read.push_back(orientation.toRotationMatrix());
  return read;
}

Robot turned_to_orientations(Robot robot, const Campaign& readings) {
  const Turns turns =
      turns_between(orientations_of_arm(robot, readings), orientations_read(readings));
  robot.chain.base.rotation = turns.base;
  robot.chain.tool.rotation = turns.tool;
  return robot;
}

// The rows whose orientations the robot file gives, turned as a whole, where the others are of an
// instrument: most of those within kNear that the turns between any three rows give.
std::vector<int> rows_of_file(const std::vector<Eigen::Matrix3d>& of_arm,
                              const std::vector<Eigen::Matrix3d>& read) {
  constexpr double kNear = 3 * kAsNoInstrumentTurns, kNearThree = 10 * kAsNoInstrumentTurns;
  constexpr int kDraws = 300, kRefits = 3;
  const auto rows = std::ssize(read);
  const auto turns_of = [&](const std::vector<int>& some) {
    std::vector<Eigen::Matrix3d> arm, readings;
    for (const int row : some) {
      arm.push_back(of_arm[row]);
      readings.push_back(read[row]);
    }
    return turns_between(arm, readings);
  };
  const auto near = [&](const Turns& turns, double most) {
    std::vector<int> found;
    for (int row = 0; row < rows; ++row)
      if (turns.left(of_arm[row], read[row]) <= most) found.push_back(row);
    return found;
  };
  std::mt19937_64 random(1);
  std::vector<int> best;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::set<int> three;
    while (three.size() < 3) three.insert(static_cast<int>(random() % static_cast<size_t>(rows)));
    std::vector<int> found = near(turns_of({three.begin(), three.end()}), kNearThree);
    if (found.size() > best.size()) best = std::move(found);
  }
  for (int refit = 0; refit < kRefits && std::ssize(best) >= kFewestComputed; ++refit)
    best = near(turns_of(best), kNear);
  return best;
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

// What find_computed_orientations() says where a part of the rows is computed. `robot`: placed
// nowhere, without effects.
std::optional<std::string> find_partly_computed(const Robot& robot, const Campaign& campaign) {
  constexpr long kMostRows = 400;
  constexpr double kClearly = 5;  // times as far as those that are computed lie the others
  constexpr double kAlike = 2;    // the points, of which none is computed
  const Campaign readings =
      campaign.select(evenly_chosen(rows_of_largest_session(campaign), kMostRows));
  const std::vector<Eigen::Matrix3d> of_arm = orientations_of_arm(robot, readings),
                                     read = orientations_read(readings);
  const std::vector<int> computed = rows_of_file(of_arm, read);
  std::set<int> poses;
  std::vector<Eigen::Matrix3d> own_arm, own_read;
  for (const int row : computed) {
    poses.insert(readings.pose[row]);
    own_arm.push_back(of_arm[row]);
    own_read.push_back(read[row]);
  }
  if (std::ssize(poses) < kFewestComputed ||
      readings.rows() - std::ssize(computed) < kFewestComputed / 2)
    return std::nullopt;
  const auto placement = place_base_and_tool(robot, readings, kImplausibleMiss);
  if (!placement) return std::nullopt;
  const Turns turns = turns_between(own_arm, own_read);
  std::vector<double> left, others, miss, miss_of_others;
  std::vector<int> lines;
  for (int row = 0; row < readings.rows(); ++row) {
    const bool is_computed = std::ranges::binary_search(computed, row);
    (is_computed ? left : others).push_back(turns.left(of_arm[row], read[row]));
    (is_computed ? miss : miss_of_others).push_back(placement->miss[row]);
    if (is_computed) lines.push_back(readings.line[row]);
  }
  if (median(left) > kAsNoInstrumentTurns || median(others) < kClearly * median(left) ||
      median(miss_of_others) > kAlike * median(miss))
    return std::nullopt;
  return fmt::format(
      "the robot file, turned as a whole, gives the orientations of {} to {:.2g} mrad (median), as "
      "no instrument reads, and of the others to {:.2g} mrad: those look computed by the "
      "controller from the joint angles, and all orientations are left out; give those of the "
      "instrument in all rows, or remove the columns",
      lines_in_words(lines), median(left) / kMilliradian, median(others) / kMilliradian);
}

}  // namespace

void leave_out_orientations(Campaign& campaign) {
  campaign.orientation.clear();
  campaign.sigma_orientation.clear();
  if (campaign.sigma_position.empty()) campaign.whitening.clear();
}

std::optional<std::string> find_computed_orientations(const Robot& given,
                                                      const Campaign& campaign) {
  constexpr double kOfPoints = 0.1;  // an arm that is made wrong errs in angles as in lengths
  constexpr double kMuchWorse = 2;
  // What a controller has written down is rounded; below it is a simulation without noise.
  constexpr double kRounding = 1e-10;  // rad
  constexpr double kLeastNoise = 1e-6;  // m, of points that an instrument has read
  if (!campaign.has_orientation()) return std::nullopt;
  Robot robot = given;
  robot.effects.clear();
  const Campaign readings = some_orientations(campaign);
  if (readings.rows() < kFewestComputed) return std::nullopt;
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
  if (!is_of_file && left > kAsNoInstrumentTurns) return find_partly_computed(robot, campaign);

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
