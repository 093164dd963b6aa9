#include "armtrue/observation/contacts.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/approach.h"
#include "armtrue/kinematics/contact.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/observation/observation.h"
#include "armtrue/observation/placement.h"
#include "armtrue/observation/registration.h"
#include "armtrue/statistics/summary.h"
#include "linear_algebra/decompositions.h"
#include "observation/beams.h"
#include "observation/cameras.h"

namespace armtrue {
namespace {

enum class By { tool, beam };

// What touches one contact: points in R_A, what the gauge showed, and of an artefact which of its
// points was touched. A touch of a point, three rows, counts once. A beam ends on the surface
// itself: it has no radius.
struct Touches {
  By by = By::tool;
  Eigen::Vector3d towards{0, 0, 0};  // of beams: the sum of the directions back along them
  std::vector<Eigen::Vector3d> points;
  std::vector<double> gauge;
  std::vector<int> of_artefact;

  Eigen::Matrix3Xd matrix() const {
    return Eigen::Map<const Eigen::Matrix3Xd>(points.front().data(), 3, std::ssize(points));
  }
};

// With By::beam every beam of the campaign must have a place.
std::map<int, Touches> touches_by_contact(const Robot& robot, const Campaign& campaign, By by) {
  const std::vector<ContactPoint> matched = match_contacts(campaign, robot.chain);
  const Eigen::Matrix3Xd points = own_points(robot, campaign);
  Robot arm = robot;
  arm.effects.clear();
  const RobotModel model(arm);
  std::map<int, Touches> all;
  for (int row = 0; row < campaign.rows(); ++row) {
    if (campaign.kind(row) != ReadingKind::touch || campaign.touch[row].axis > 0) continue;
    const ContactPoint& which = matched[campaign.touch[row].contact];
    if ((which.beam >= 0) != (by == By::beam)) continue;
    Touches& touches = all[which.contact];
    touches.by = by;
    touches.of_artefact.push_back(which.point);
    const double shown = campaign.distance[row];
    touches.gauge.push_back(by == By::beam ? 0.0 : shown);
    if (by == By::tool) {
      touches.points.emplace_back(points.col(row));
      continue;
    }
    const Contact& beam = robot.chain.contacts[which.beam];
    const Pose measured = model.pose(campaign.context(row));
    touches.points.emplace_back(measured * end_of_beam(beam, shown));
    touches.towards -= measured.rotation * beam.place.rotation.col(2);
  }
  return all;
}

void place_points(const Touches& touches, Contact& contact) {
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

// Difference of a touch at `seen`, in the axes of the contact, from the reading of the gauge: three
// numbers or one, with their derivatives by the point.
Eigen::VectorXd off_contact(const Contact& contact, int point, double gauge, By by,
                            const Eigen::Vector3d& seen, Eigen::MatrixX3d* gradients = nullptr) {
  const int count = reads_point(contact, point) ? 3 : 1;
  Eigen::VectorXd off(count);
  if (gradients) gradients->resize(count, 3);
  for (int axis = 0; axis < count; ++axis) {
    const TouchReading reading = touch_reading(contact, point, axis, seen);
    off[axis] = reading.value - gauge + (by == By::beam ? contact.radius : 0.0);
    if (gradients) gradients->row(axis) = reading.gradient;
  }
  return off;
}

// Normal equations of the touches of an artefact at one place: unknowns are its motion in its own
// axes and, `with_radius`, the radius of what touches.
struct ArtefactFit {
  Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, 1> right = Eigen::Matrix<double, 7, 1>::Zero();
  double cost = 0;

  ArtefactFit(const Touches& touches, const Contact& contact, bool with_radius) {
    const Pose from_a = inverse(contact.place);
    Eigen::MatrixX3d gradients;
    for (size_t k = 0; k < touches.points.size(); ++k) {
      const Eigen::Vector3d seen = from_a * touches.points[k];
      const int point = touches.of_artefact[k];
      const Eigen::VectorXd off =
          off_contact(contact, point, touches.gauge[k], touches.by, seen, &gradients);
      const bool has_radius = with_radius && !reads_point(contact, point);
      for (Eigen::Index i = 0; i < off.size(); ++i) {
        const Eigen::Vector3d gradient = gradients.row(i);
        Eigen::Matrix<double, 7, 1> column;
        column << -gradient, gradient.cross(seen), has_radius ? -1.0 : 0.0;
        normal += column * column.transpose();
        right -= column * off[i];
        cost += off[i] * off[i];
      }
    }
  }
};

// Levenberg's method from the contact's place.
double refine_artefact(const Touches& touches, Contact& contact, bool with_radius) {
  constexpr int kMaxSteps = 60;
  constexpr double kFirstDamping = 1e-3, kMostDamping = 1e3, kStands = 1e-12;
  ArtefactFit here(touches, contact, with_radius);
  double damping = kFirstDamping * here.normal.trace();
  const double most = kMostDamping * here.normal.trace();
  for (int k = 0; k < kMaxSteps && damping < most; ++k) {
    const Eigen::MatrixXd damped = here.normal + damping * Eigen::Matrix<double, 7, 7>::Identity();
    const Eigen::VectorXd step = damped.ldlt().solve(Eigen::VectorXd(here.right));
    Contact moved = contact;
    moved.place = contact.place * Pose{rotation_exp(step.segment<3>(3)), step.head<3>()};
    moved.radius += step[6];
    const ArtefactFit there(touches, moved, with_radius);
    if (!(there.cost < here.cost)) {
      damping *= 10;
      continue;
    }
    const bool is_settled = step.norm() < kStands;
    contact = std::move(moved);
    here = there;
    if (is_settled) break;
    damping *= 0.1;
  }
  return here.cost;
}

// Faces and balls have no closed form together: the best of the starts with rotations all around,
// the mean of what was touched at the mean of the touches.
void place_artefact(const Touches& touches, Contact& contact) {
  const auto is_point = [&](int point) { return reads_point(contact, point); };
  if (std::ranges::all_of(touches.of_artefact, is_point)) return place_points(touches, contact);
  const Eigen::Vector3d middle =
      mean_of(touches.of_artefact, [&](int point) { return contact.points[point].position; });
  const Eigen::Vector3d in_a = touches.matrix().rowwise().mean();
  std::optional<Contact> best;
  double least = 0;
  for (const Eigen::Matrix3d& turn : turns_of_a_cube()) {
    Contact start = contact;
    start.place.rotation = contact.place.rotation * turn;
    start.place.translation = in_a - start.place.rotation * middle;
    const double cost = refine_artefact(touches, start, false);
    if (best && cost >= least) continue;
    best = start;
    least = cost;
  }
  contact = *best;
  // The radius last: if a shift of the place does the same, the radius stays as it was.
  if (touches.by == By::tool && !contact.radius_is_known) refine_artefact(touches, contact, true);
}

// The normal points to the side on which a gauge shows more, or from which beams come; without
// both, or if it shows the same everywhere, in the direction of the contact's z axis.
void place_plane(const Touches& touches, Contact& contact) {
  const Eigen::Matrix3Xd points = touches.matrix();
  const Eigen::Vector3d middle = points.rowwise().mean();
  const Eigen::Map<const Eigen::VectorXd> gauge(touches.gauge.data(), std::ssize(touches.gauge));
  if (points.cols() >= 3) {
    const Eigen::Matrix3Xd centred = points.colwise() - middle;
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(centred * centred.transpose(), Eigen::ComputeThinU);
    Eigen::Vector3d normal = svd.matrixU().col(2);
    const double with_gauge = gauge.maxCoeff() > gauge.minCoeff()  // else rounding is its sign
                                  ? (normal.transpose() * centred).dot(gauge.transpose())
                                  : 0.0;
    const Eigen::Vector3d z = contact.place.rotation.col(2);
    const Eigen::Vector3d side = touches.by == By::beam ? touches.towards : z;
    if (with_gauge != 0 ? with_gauge < 0 : normal.dot(side) < 0) normal = -normal;
    contact.place.rotation = shortest_rotation(z, normal) * contact.place.rotation;
  }
  contact.place.translation = middle - contact.place.rotation.col(2) * gauge.mean();
}

void place_sphere(const Touches& touches, Contact& contact) {
  const SphereEquations sphere = sphere_equations(touches.matrix());
  const Eigen::Vector4d solution =
      Eigen::VectorXd(sphere.columns.completeOrthogonalDecomposition().solve(sphere.squares));
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
    case ContactKind::beam:  // by with_beams_placed()
    case ContactKind::board:
    case ContactKind::camera:  // by with_cameras_placed()
      break;
  }
  contact.is_placed = true;
}

// Median error of the touches of the contact.
double miss_of(const Touches& touches, const Contact& contact) {
  std::vector<double> misses;
  for (size_t k = 0; k < touches.points.size(); ++k)
    misses.push_back(off_contact(contact, touches.of_artefact[k], touches.gauge[k], touches.by,
                                 inverse(contact.place) * touches.points[k])
                         .norm());
  return median(std::move(misses));
}

// The joints with which the tool touches the contact of a row.
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
    const ContactPoint& which = contacts_[campaign_.touch[row].contact];
    const By by = which.beam >= 0 ? By::beam : By::tool;
    const Contact& contact = chain_.contacts[which.contact];
    Eigen::Vector3d point = campaign_.own_point(row);  // in the measured frame
    if (by == By::beam)
      point = end_of_beam(chain_.contacts[which.beam], campaign_.distance[row]);
    else if (!targets_.empty())
      point = chain_.targets[targets_[campaign_.target[row]]].position;
    const auto miss = [&](const Eigen::Vector3d& place, Eigen::MatrixX3d& gradients) {
      const Eigen::VectorXd off =
          off_contact(contact, which.point, by == By::beam ? 0.0 : campaign_.distance[row], by,
                      inverse(contact.place) * place, &gradients);
      gradients *= contact.place.rotation.transpose();
      return off;
    };
    const auto pose_at = [&](const JointVector& q, PoseJacobian& jacobian) {
      return evaluator_.pose(q, jacobian);
    };
    return touching_joints(chain_, pose_at, point, miss, campaign_.q[row]);
  }

 private:
  const KinematicChain& chain_;
  const Campaign& campaign_;
  std::vector<int> targets_;
  std::vector<ContactPoint> contacts_;
  ChainEvaluator evaluator_;
};

// Places the beams, and then the planes that nothing touches but beams.
Robot with_beams_and_planes(Robot robot, const Campaign& campaign, FitContacts which,
                            std::vector<bool> known) {
  robot = with_beams_placed(std::move(robot), campaign, known);
  for (const auto& [index, touches] : touches_by_contact(robot, campaign, By::beam)) {
    Contact& contact = robot.chain.contacts[index];
    if (known[index] && miss_of(touches, contact) >= kFarContact &&
        which == FitContacts::unplaced)  // the file has a wrong place, of a plane or a beam
      return with_contacts_fitted(std::move(robot), campaign, FitContacts::all);
    if (!known[index]) place_contact(touches, contact);
  }
  return robot;
}

}  // namespace

Robot with_contacts_fitted(Robot robot, const Campaign& campaign, FitContacts which) {
  if (!campaign.has_touches()) return robot;
  if (campaign.has_pixels()) robot = with_cameras_placed(std::move(robot), campaign, which);
  std::vector<bool> known;  // of each contact, whether it has its place
  for (const Contact& contact : robot.chain.contacts)
    known.push_back(which == FitContacts::unplaced && contact.is_placed);
  for (const auto& [index, touches] : touches_by_contact(robot, campaign, By::tool)) {
    Contact& contact = robot.chain.contacts[index];
    if (!known[index] || miss_of(touches, contact) >= kFarContact) place_contact(touches, contact);
    known[index] = true;
  }
  return with_beams_and_planes(std::move(robot), campaign, which, std::move(known));
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
