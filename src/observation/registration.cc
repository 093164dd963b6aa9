#include "armtrue/observation/registration.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "armtrue/campaign/selection.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/observation/contacts.h"
#include "armtrue/observation/observation.h"
#include "armtrue/observation/placement.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/statistics/summary.h"
#include "observation/nearer_half.h"

namespace armtrue {
namespace {

// A larger error of the base is no calibration error: the set-up is not that of the robot file.
constexpr double kFarBase = 0.08;  // m
// The same for the tool, with the base registered.
constexpr double kFarTool = 0.02;         // m, position
constexpr double kFarTurn = 0.3;          // rad
constexpr int kMinPoints = 4;             // one more than a pose needs
constexpr int kMinDistances = 5;          // one more than the unknowns
constexpr int kAnchorsThatShowATurn = 3;  // all rotations of the base
constexpr int kRowsOfAStart = 100000;     // at equal steps; a fit of more starts from them, too

}  // namespace

Eigen::Matrix3Xd own_points(Robot robot, const Campaign& campaign) {
  robot.effects.clear();
  const RobotModel model(robot);
  const std::vector<int> targets = match_targets(campaign, robot.chain);
  Eigen::Matrix3Xd points(3, campaign.rows());
  for (int row = 0; row < campaign.rows(); ++row)
    points.col(row) = targets.empty()
                          ? model.pose(campaign.context(row)) * campaign.own_point(row)
                          : model.point(campaign.context(row), targets[campaign.target[row]]);
  return points;
}

Pose rigid_fit(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  const Eigen::Matrix4d transform = Eigen::umeyama(from, to, false);
  return {transform.topLeftCorner<3, 3>(), transform.topRightCorner<3, 1>()};
}

SphereEquations sphere_equations(const Eigen::Matrix3Xd& points) {
  SphereEquations sphere{points.rowwise().mean(), Eigen::MatrixXd(points.cols(), 4), {}};
  const Eigen::Matrix3Xd centred = points.colwise() - sphere.middle;
  sphere.columns << 2 * centred.transpose(), Eigen::VectorXd::Ones(points.cols());
  sphere.squares = centred.colwise().squaredNorm().transpose();
  return sphere;
}

namespace {

Pose register_points(const Eigen::Matrix3Xd& own, const Eigen::Matrix3Xd& measured) {
  return fit_nearer_half(
      own.cols(), kMinPoints,
      [&](const std::vector<int>& chosen) {
        return rigid_fit(own(Eigen::all, chosen), measured(Eigen::all, chosen));
      },
      [&](const Pose& base, int k) {
        return (measured.col(k) - base * Eigen::Vector3d(own.col(k))).norm();
      });
}

// Each point lies on a sphere about the anchor whose radius is the distance.
Eigen::Vector3d trilaterate(const Eigen::Matrix3Xd& points, const Eigen::VectorXd& distances) {
  const SphereEquations sphere = sphere_equations(points);
  const Eigen::VectorXd squares = sphere.squares - distances.cwiseAbs2();
  return fit_nearer_half(
      points.cols(), kMinDistances,
      [&](const std::vector<int>& chosen) -> Eigen::Vector3d {
        return sphere.middle + Eigen::MatrixXd(sphere.columns(chosen, Eigen::all))
                                   .completeOrthogonalDecomposition()
                                   .solve(Eigen::VectorXd(squares(chosen)))
                                   .head<3>();
      },
      [&](const Eigen::Vector3d& anchor, int k) {
        return std::abs((points.col(k) - anchor).norm() - distances[k]);
      });
}

}  // namespace

Pose registered_base(const Robot& robot, const Campaign& campaign) {
  Robot at_origin = robot;
  at_origin.chain.base = Pose{};
  const Eigen::Matrix3Xd own = own_points(at_origin, campaign);
  if (!campaign.reads_one_number()) {
    Eigen::Matrix3Xd measured(3, campaign.rows());
    for (int row = 0; row < campaign.rows(); ++row) measured.col(row) = campaign.position[row];
    return register_points(own, measured);
  }
  if (campaign.has_coordinates()) {
    std::vector<int> rows;
    std::vector<Eigen::Vector3d> measured;
    const auto reads_axis = [&](int row, int axis) {
      return campaign.kind(row) == ReadingKind::coordinate &&
             campaign.coordinate[row]->axis == axis;
    };
    for (int row = 0; row + 2 < campaign.rows(); ++row) {
      if (!reads_axis(row, 0) || !reads_axis(row + 1, 1) || !reads_axis(row + 2, 2)) continue;
      rows.push_back(row);
      measured.emplace_back(campaign.length(row), campaign.length(row + 1),
                            campaign.length(row + 2));
    }
    if (std::ssize(rows) >= kMinPoints)
      return register_points(
          own(Eigen::all, rows),
          Eigen::Map<const Eigen::Matrix3Xd>(measured.front().data(), 3, std::ssize(measured)));
  }
  const std::vector<int> anchors = match_anchors(campaign, robot.chain);
  std::vector<Eigen::Vector3d> found, given;  // in R_0, in R_A
  for (int a = 0; a < std::ssize(anchors); ++a) {
    const Anchor& anchor = robot.chain.anchors[anchors[a]];
    std::vector<int> rows;
    std::vector<double> distances;
    for (int row = 0; row < campaign.rows(); ++row)
      if (campaign.kind(row) == ReadingKind::distance &&
          (campaign.anchor.empty() || campaign.anchor[row] == a)) {
        rows.push_back(row);
        distances.push_back(campaign.distance[row] - anchor.zero);
      }
    if (std::ssize(rows) < kMinDistances) continue;
    found.push_back(
        trilaterate(own(Eigen::all, rows),
                    Eigen::Map<const Eigen::VectorXd>(distances.data(), std::ssize(distances))));
    given.push_back(anchor.position);
  }
  const auto count = std::ssize(found);
  if (count == 0) return robot.chain.base;
  const Eigen::Map<const Eigen::Matrix3Xd> in_0(found.front().data(), 3, count);
  const Eigen::Map<const Eigen::Matrix3Xd> in_a(given.front().data(), 3, count);
  // Fitted to all of them, because half of three anchors does not show a rotation.
  if (count >= kAnchorsThatShowATurn) return rigid_fit(in_0, in_a);
  Eigen::Matrix3d rotation = robot.chain.base.rotation;
  if (count == 2)  // they show all rotations but that about the connecting line
    rotation =
        shortest_rotation(rotation * (in_0.col(1) - in_0.col(0)), in_a.col(1) - in_a.col(0)) *
        rotation;
  return {rotation, (in_a - rotation * in_0).rowwise().mean()};
}

namespace {

// Median errors of position [m] and orientation [rad].
Eigen::Vector2d typical_miss(const Robot& robot, const Campaign& campaign) {
  const SessionModels model(campaign, robot, {}, {1.0, 1.0});
  if (model.rows() == 0) return Eigen::Vector2d::Zero();
  std::vector<double> position, orientation;
  for (const Eigen::Vector2d& norms :
       model.squared_norms(Eigen::VectorXd::Zero(model.unknowns()))) {
    position.push_back(norms[0]);
    orientation.push_back(norms[1]);
  }
  return {std::sqrt(median(std::move(position))), std::sqrt(median(std::move(orientation)))};
}

// Components of the placed tool that are not among the `kept` parameters are chance: they get the
// value of the robot file, and the base is registered again. The tool keeps the rotation of the
// file if no rotation of it is kept.
void keep_unseen_tool(const Robot& robot, const Campaign& campaign, const std::vector<int>& kept,
                      Robot& placed) {
  constexpr int kAxes = 3;
  const int first = layout_of(robot.chain).tool;
  const auto is_shown = [&](int k) { return std::ranges::count(kept, first + k) > 0; };
  bool is_kept = false, shows_turn = false;
  for (int axis = 0; axis < kAxes; ++axis) {
    shows_turn |= is_shown(kAxes + axis);
    if (is_shown(axis)) continue;
    placed.chain.tool.translation[axis] = robot.chain.tool.translation[axis];
    is_kept = true;
  }
  if (!shows_turn) placed.chain.tool.rotation = robot.chain.tool.rotation;
  if (is_kept) placed.chain.base = registered_base(placed, campaign);
}

// `tool`: the tool may be placed too, in its `kept` parameters.
Robot with_base_near(const Robot& robot, const Campaign& campaign, const std::vector<int>& kept,
                     bool tool) {
  const Eigen::Vector2d as_given = typical_miss(robot, campaign);
  const bool turned = tool && as_given[1] > kFarTurn;
  if (as_given[0] < kFarBase && !turned) return robot;
  Robot moved = robot;
  moved.chain.base = registered_base(robot, campaign);
  const Eigen::Vector2d registered = typical_miss(moved, campaign);
  if (tool && (registered[0] > kFarTool || registered[1] > kFarTurn))
    if (const auto placement = place_base_and_tool(robot, campaign, kFarTool)) {
      Robot placed = placed_robot(robot, campaign, *placement);
      keep_unseen_tool(robot, campaign, kept, placed);
      const Eigen::Vector2d after = typical_miss(placed, campaign);
      const bool better_turn = turned && after[1] < kFarTurn && after[0] < kFarBase;
      if (after[0] < std::min(as_given[0], registered[0]) || better_turn) return placed;
    }
  return registered[0] < as_given[0] && as_given[0] >= kFarBase ? moved : robot;
}

// Registers the base on what an instrument read. Places contacts before it (those without a place)
// and again after it (those that the new base puts far off).
Robot starting_robot_beside_contacts(const Robot& robot, const Campaign& campaign,
                                     const std::vector<int>& kept) {
  const auto finds = [&](int parameter) {
    return parameter >= first_contact_parameter(robot.chain);
  };
  const bool finds_contacts = std::ranges::any_of(kept, finds);
  const auto fitted = [&](const Robot& start) {
    return finds_contacts ? with_contacts_fitted(start, campaign, FitContacts::unplaced) : start;
  };
  std::vector<int> rows;
  for (int row = 0; row < campaign.rows(); ++row)
    if (campaign.touch[row].contact < 0) rows.push_back(row);
  if (rows.empty()) return fitted(robot_at_row(robot, campaign, 0));
  Campaign seen = campaign.select(rows);
  seen.touch.clear();
  seen.contact_names.clear();
  return fitted(starting_robot(fitted(robot), seen, kept));
}

}  // namespace

Robot starting_robot(const Robot& robot, const Campaign& given, const std::vector<int>& kept) {
  if (given.has_touches()) return starting_robot_beside_contacts(robot, given, kept);
  Campaign part;
  const bool is_large = given.rows() > kRowsOfAStart;
  if (is_large) part = given.select(thinned_rows(given, kRowsOfAStart));
  const Campaign& campaign = is_large ? part : given;
  // Fewer than three anchors do not show all rotations of the base.
  const bool shows_turn = !campaign.reads_one_number() || campaign.has_coordinates() ||
                          match_anchors(campaign, robot.chain).size() >= kAnchorsThatShowATurn;
  bool finds_first_base = true;
  for (int k = 0; k < (shows_turn ? 6 : 3); ++k)
    finds_first_base &= std::find(kept.begin(), kept.end(), kFirstBaseParameter + k) != kept.end();
  const bool finds_tool =
      finds_first_base && std::ranges::find(kept, layout_of(robot.chain).tool) != kept.end();
  const std::vector<std::vector<int>> sessions = rows_by_session(campaign);
  if (sessions.size() == 1) {
    const Robot there = robot_at_row(robot, campaign, 0);
    return finds_first_base ? with_base_near(there, campaign, kept, finds_tool) : there;
  }
  Robot start = robot;
  start.sessions.clear();
  for (size_t s = 0; s < sessions.size(); ++s) {
    const Campaign readings = campaign.select(sessions[s]);
    Robot there = robot_at_row(robot, readings, 0);
    if (s > 0 || finds_first_base)
      there = with_base_near(there, readings, kept, s == 0 && finds_tool);
    if (s == 0) start.chain = there.chain;
    const std::string& name = readings.session_names[readings.session.front()];
    const auto known = robot.sessions.find(name);
    if (known != robot.sessions.end()) start.sessions[name] = known->second;
    start.sessions[name].base = there.chain.base;
  }
  return start;
}

}  // namespace armtrue
