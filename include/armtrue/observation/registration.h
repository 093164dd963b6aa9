#pragma once

#include <Eigen/Core>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/pose.h"

namespace armtrue {

/// The points that the robot without effects predicts, in the R_A of `robot.chain.base` [m], one
/// column per row.
Eigen::Matrix3Xd own_points(Robot robot, const Campaign& campaign);

/// The rigid motion that takes points to others with least squares, 3 x n each (Umeyama 1991).
Pose rigid_fit(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

/// Spheres through points p, linear in their centre c: with p and c from the middle of the points,
///     2 p.c + (l^2 - |c|^2) = |p|^2.
/// One sphere through all has l^2 - |c|^2 as the fourth unknown. If each point states its l, its
/// l^2 goes to the right, and -|c|^2 is the fourth.
struct SphereEquations {
  Eigen::Vector3d middle;
  Eigen::MatrixXd columns;  ///< a row [2 p, 1] for each point
  Eigen::VectorXd squares;  ///< |p|^2
};

SphereEquations sphere_equations(const Eigen::Matrix3Xd& points);

/// The base pose that best maps the robot's own points, without effects, onto the measured ones. It
/// is fitted to all, then twice to the half with the smaller errors, but to four points at least.
/// Points (and coordinates, if there are four points): Umeyama's closed form. Distances: the place
/// of each anchor in R_0 by trilateration, |p - a|^2 = l^2, linear in a and |a|^2, then the places
/// are mapped onto those in the file; half of the distances, too, are five at least. An anchor with
/// fewer does not count. With two anchors the rotation of the base about the connecting line is
/// kept, with one all rotations, with none the base. Throws as match_targets() and match_anchors().
Pose registered_base(const Robot& robot, const Campaign& campaign);

/// The robot that calibration starts from: as in the first session of the campaign, with a base for
/// each session. `kept`: indices of the identified parameters. If the base is among them and the
/// median error is 80 mm or more, registered_base() replaces the base, if its error is smaller. If
/// the tool is among them, too, the error was 80 mm or 0.3 rad or more, and stays above 20 mm or
/// 0.3 rad with the registered base, those of place_base_and_tool() replace base and tool, if their
/// error is smaller. with_contacts_fitted() places contacts among them. Without contacts, 100,000
/// rows at equal steps stand for more.
Robot starting_robot(const Robot& robot, const Campaign& campaign, const std::vector<int>& kept);

}  // namespace armtrue
