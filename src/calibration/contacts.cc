#include "armtrue/calibration/contacts.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "armtrue/calibration/observation.h"
#include "armtrue/calibration/registration.h"
#include "armtrue/kinematics/contact.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/joint_iterations.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/statistics/summary.h"
#include "calibration/cameras.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

// What touches one contact: points in R_A, what the gauge showed, and of an artefact which of its
// points was touched. Each touch once, though that of a point is three rows.
struct Touches {
  std::vector<Eigen::Vector3d> points;
  std::vector<double> gauge;
  std::vector<int> of_artefact;

  Eigen::Matrix3Xd matrix() const {
    return Eigen::Map<const Eigen::Matrix3Xd>(points.front().data(), 3, std::ssize(points));
  }
};

std::map<int, Touches> touches_by_contact(const Robot& robot, const Campaign& campaign) {
  const std::vector<ContactPoint> matched = match_contacts(campaign, robot.chain);
  const Eigen::Matrix3Xd points = own_points(robot, campaign);
  std::map<int, Touches> all;
  for (int row = 0; row < campaign.rows(); ++row) {
    if (campaign.kind(row) != ReadingKind::touch || campaign.touch[row].axis > 0) continue;
    const ContactPoint& which = matched[campaign.touch[row].contact];
    Touches& touches = all[which.contact];
    touches.points.emplace_back(points.col(row));
    touches.gauge.push_back(campaign.distance[row]);
    touches.of_artefact.push_back(which.point);
  }
  return all;
}

void place_artefact(const Touches& touches, Contact& contact) {
  std::map<int, std::pair<Eigen::Vector3d, int>> sums;
  for (size_t k = 0; k < touches.points.size(); ++k) {
    auto& [sum, count] =
        sums.try_emplace(touches.of_artefact[k], Eigen::Vector3d::Zero(), 0).first->second;
    sum += touches.points[k];
    ++count;
  }
  Eigen::Matrix3Xd in_artefact(3, sums.size()), in_a(3, sums.size());
  Eigen::Index k = 0;
  for (const auto& [point, mean] : sums) {
    in_artefact.col(k) = contact.points[point].position;
    in_a.col(k++) = mean.first / mean.second;
  }
  if (k > 1)
    contact.place = rigid_fit(in_artefact, in_a);
  else
    contact.place.translation = in_a.col(0) - contact.place.rotation * in_artefact.col(0);
}

// The normal points to the side on which a gauge shows more; without a gauge, in the direction of
// the contact's z axis.
void place_plane(const Touches& touches, Contact& contact) {
  const Eigen::Matrix3Xd points = touches.matrix();
  const Eigen::Vector3d middle = points.rowwise().mean();
  const Eigen::Map<const Eigen::VectorXd> gauge(touches.gauge.data(), std::ssize(touches.gauge));
  if (points.cols() >= 3) {
    const Eigen::Matrix3Xd centred = points.colwise() - middle;
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(centred * centred.transpose(), Eigen::ComputeThinU);
    Eigen::Vector3d normal = svd.matrixU().col(2);
    const double with_gauge = (normal.transpose() * centred).dot(gauge.transpose());
    const Eigen::Vector3d z = contact.place.rotation.col(2);
    if (with_gauge != 0 ? with_gauge < 0 : normal.dot(z) < 0) normal = -normal;
    contact.place.rotation = shortest_rotation(z, normal) * contact.place.rotation;
  }
  contact.place.translation = middle - contact.place.rotation.col(2) * gauge.mean();
}

void place_sphere(const Touches& touches, Contact& contact) {
  const SphereEquations sphere = sphere_equations(touches.matrix());
  const Eigen::Vector4d solution =
      sphere.columns.completeOrthogonalDecomposition().solve(sphere.squares);
  const Eigen::Vector3d centre = solution.head<3>();
  const Eigen::Map<const Eigen::VectorXd> gauge(touches.gauge.data(), std::ssize(touches.gauge));
  contact.place.translation = sphere.middle + centre;
  contact.radius = std::sqrt(std::max(0.0, solution[3] + centre.squaredNorm())) - gauge.mean();
}

void place_contact(const Touches& touches, Contact& contact) {
  switch (contact.kind) {
    case ContactKind::point:
      contact.place.translation = touches.matrix().rowwise().mean();
      break;
    case ContactKind::artefact:
      place_artefact(touches, contact);
      break;
    case ContactKind::plane:
      place_plane(touches, contact);
      break;
    case ContactKind::sphere:
      place_sphere(touches, contact);
      break;
    case ContactKind::board:
    case ContactKind::camera:
      break;  // by with_cameras_placed()
  }
  contact.is_placed = true;
}

// Difference of a touch at `seen`, in the axes of the contact, from the reading of the gauge: three
// numbers or one, with their derivatives by the point.
Eigen::VectorXd off_contact(const Contact& contact, int point, double gauge,
                            const Eigen::Vector3d& seen, Eigen::MatrixX3d* gradients = nullptr) {
  const int count = reads_point(contact.kind) ? 3 : 1;
  Eigen::VectorXd off(count);
  if (gradients) gradients->resize(count, 3);
  for (int axis = 0; axis < count; ++axis) {
    const TouchReading reading = touch_reading(contact, point, axis, seen);
    off[axis] = reading.value - gauge;
    if (gradients) gradients->row(axis) = reading.gradient;
  }
  return off;
}

// Median error of the touches of the contact.
double miss_of(const Touches& touches, const Contact& contact) {
  std::vector<double> misses;
  for (size_t k = 0; k < touches.points.size(); ++k)
    misses.push_back(off_contact(contact, touches.of_artefact[k], touches.gauge[k],
                                 inverse(contact.place) * touches.points[k])
                         .norm());
  return median(std::move(misses));
}

// Newton's method for the joints until the tool touches one contact.
class Approach {
 public:
  Approach(const Robot& robot, const Campaign& campaign)
      : chain_(robot.chain),
        campaign_(campaign),
        targets_(match_targets(campaign, chain_)),
        contacts_(match_contacts(campaign, chain_)),
        evaluator_(chain_) {}

  // Nothing if the contact is out of reach.
  std::optional<JointVector> configuration(int row) const {
    constexpr int kMaxSteps = 100;
    constexpr double kTouches = 1e-12;  // m, far below what a rank could notice
    const auto step_at = [&](const JointVector& q) -> std::optional<JointVector> {
      Eigen::MatrixXd jacobian;
      const Eigen::VectorXd miss = this->miss(row, q, jacobian);
      if (miss.norm() < kTouches) return std::nullopt;
      const double damping = std::max(1e-30, 1e-12 * jacobian.squaredNorm());
      return smallest_step(jacobian, -miss, damping);
    };
    return newton(campaign_.q[row], kMaxSteps, step_at);
  }

 private:
  // How far the point is off the contact, one or three numbers, with the derivatives by the joints.
  Eigen::VectorXd miss(int row, const JointVector& q, Eigen::MatrixXd& jacobian) const {
    PoseJacobian of_pose;
    Pose frame = evaluator_.pose(q, of_pose);
    if (!targets_.empty()) {
      const int target = targets_[campaign_.target[row]];
      const Eigen::Vector3d lever = frame.rotation * chain_.targets[target].position;
      move_to_point(of_pose, lever);
      frame.translation += lever;
    }
    Eigen::Matrix3Xd joints(3, joint_count(chain_));
    for (int j = 0; j < static_cast<int>(joints.cols()); ++j)
      joints.col(j) = joint_column(chain_, of_pose, j).head<3>();
    const ContactPoint& which = contacts_[campaign_.touch[row].contact];
    const Contact& contact = chain_.contacts[which.contact];
    Eigen::MatrixX3d gradients;
    const Eigen::VectorXd off = off_contact(contact, which.point, campaign_.distance[row],
                                            inverse(contact.place) * frame.translation, &gradients);
    jacobian = gradients * contact.place.rotation.transpose() * joints;
    return off;
  }

  const KinematicChain& chain_;
  const Campaign& campaign_;
  std::vector<int> targets_;
  std::vector<ContactPoint> contacts_;
  ChainEvaluator evaluator_;
};

}  // namespace

Robot with_contacts_fitted(Robot robot, const Campaign& campaign, FitContacts which) {
  if (!campaign.has_touches()) return robot;
  if (campaign.has_pixels()) return with_cameras_placed(std::move(robot), campaign, which);
  for (const auto& [index, touches] : touches_by_contact(robot, campaign)) {
    Contact& contact = robot.chain.contacts[index];
    if (which == FitContacts::unknown && contact.is_placed &&
        miss_of(touches, contact) < kFarContact)
      continue;
    place_contact(touches, contact);
  }
  return robot;
}

Campaign moved_onto_contacts(const Robot& robot, const Campaign& campaign) {
  const Approach approach(robot, campaign);
  Campaign moved = campaign;
  std::vector<int> reached;
  for (int row = 0; row < campaign.rows(); ++row) {
    if (campaign.kind(row) == ReadingKind::touch) {
      const bool as_before = row > 0 && campaign.touch[row].axis > 0 && !reached.empty() &&
                             reached.back() == row - 1 && campaign.q[row] == campaign.q[row - 1];
      const std::optional<JointVector> q =
          as_before ? moved.q[row - 1] : approach.configuration(row);
      if (!q) continue;
      moved.q[row] = *q;
    }
    reached.push_back(row);
  }
  return moved.select(reached);
}

}  // namespace armtrue
