#include "armtrue/effects/gravity.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "armtrue/effects/sampling.h"

namespace armtrue {
namespace {

// Largest sine of the angle between axes that are built parallel, after calibration. Axes of wrists
// that are not parallel meet at tens of degrees.
constexpr double kParallel = 1e-2;
// Poses from which the basis is chosen. A joint gives at most four values: three first moments of
// its link and one by its travel.
constexpr int kFewestBasisPoses = 64, kBasisPosesPerJoint = 8;
// Share of the torque of a first moment at a right angle to gravity. A smaller independent part
// only comes from small angles of the identified geometry, and would change with every fit of them.
constexpr double kMinNew = 1e-2;

}  // namespace

using Eigen::Vector3d;

// Axes and points in R_0.
struct GravityLoad::Motion {
  Vector3d axis, point;
  bool turns;

  Vector3d velocity(const Vector3d& at) const { return turns ? axis.cross(at - point) : axis; }
};

GravityLoad::GravityLoad(const Robot& robot, int parameter)
    : parameter_(parameter),
      links_(link_count(robot.chain)),
      base_rotation_(robot.chain.base.rotation),
      gravity_(robot.gravity),
      ground_(robot.ground_link.value_or(-1)),
      of_positioner_(is_of_positioner(robot, parameter)),
      by_masses_(!robot.bodies.empty() && !of_positioner_),
      payload_point_(robot.chain.tool.translation),
      bodies_(robot.bodies) {
  if (parameter < kFirstLinkParameter)
    link_ = 0;
  else if (layout_of(robot.chain).is_of_links(parameter))
    link_ = link_of_parameter(parameter);
  else
    link_ = links_;
  for (int j = 0; j < links_; ++j) beta_[j] = robot.chain.links[j].beta;
  if (link_ < links_ && parameter == zero_of_link(robot.chain, link_)) {
    const std::vector<double> moved = moved_with(robot.chain, link_);
    for (int j = 0; j < links_; ++j)
      if (const double factor = moved[j]; j != link_ && factor != 0)
        followers_.push_back({j, factor, !is_prismatic(robot.chain.links[j])});
  }
  if (!by_masses_) choose_basis(robot, ChainEvaluator(robot.chain));
}

int GravityLoad::value_count() const { return by_masses_ ? 1 : static_cast<int>(basis_.size()); }

Vector3d GravityLoad::gravity_in_foot(const ArmFrames& frames) const {
  return ground_ < 0 ? gravity_ : Vector3d(frames[ground_].rotation * gravity_);
}

GravityLoad::Motion GravityLoad::motion(const ArmFrames& frames) const {
  if (parameter_ < kFirstLinkParameter) {
    const Vector3d axis = base_rotation_.transpose() * Vector3d::Unit(parameter_ % 3);
    return {axis, Vector3d::Zero(), parameter_ >= 3};
  }
  const Pose previous = link_ == 0 ? Pose{} : frames[link_ - 1];
  switch (kind_of_parameter(parameter_)) {
    case LinkParameter::alpha:
    case LinkParameter::d: {
      const Vector3d x = std::cos(beta_[link_]) * previous.rotation.col(0) -
                         std::sin(beta_[link_]) * previous.rotation.col(2);
      return {x, previous.translation, kind_of_parameter(parameter_) == LinkParameter::alpha};
    }
    case LinkParameter::beta:
      return {previous.rotation.col(1), previous.translation, true};
    case LinkParameter::theta:
      return {frames[link_].rotation.col(2), frames[link_].translation, true};
    case LinkParameter::r:
      break;
  }
  return {frames[link_].rotation.col(2), frames[link_].translation, false};
}

// The velocity of a point of a link, per unit of the parameter.
Vector3d GravityLoad::velocity(const Motion& moved, const ArmFrames& frames, int link,
                               const Vector3d& point) const {
  Vector3d sum = link >= link_ ? moved.velocity(point) : Vector3d(Vector3d::Zero());
  for (const Follower& follower : followers_) {
    if (link < follower.link) continue;
    const Pose& frame = frames[follower.link];
    sum += follower.factor *
           Motion{frame.rotation.col(2), frame.translation, follower.turns}.velocity(point);
  }
  return sum;
}

// The factor of the torque of a first moment: 1, or the travel of its link [m].
double GravityLoad::arm_of(const FirstMoment& moment, const ArmFrames& frames) const {
  if (!moment.by_travel) return 1;
  const Vector3d foot =
      moment.link > 0 ? frames[moment.link - 1].translation : Vector3d(Vector3d::Zero());
  return frames[moment.link].rotation.col(moment.axis).dot(frames[moment.link].translation - foot);
}

double GravityLoad::first_moment_value(const FirstMoment& moment, const Motion& moved,
                                       const ArmFrames& frames) const {
  if (!moved.turns && followers_.empty()) return 0.0;
  Vector3d axis = moved.turns ? moved.axis : Vector3d(Vector3d::Zero());
  for (const Follower& follower : followers_)
    if (follower.turns && moment.link >= follower.link)
      axis += follower.factor * frames[follower.link].rotation.col(2);
  const Vector3d direction = moment.link < 0
                                 ? Vector3d(Vector3d::Unit(moment.axis))
                                 : Vector3d(frames[moment.link].rotation.col(moment.axis));
  // The links that a joint of a positioner carries stand before it in the chain: they turn the
  // other way.
  return (of_positioner_ ? -1 : 1) * arm_of(moment, frames) *
         gravity_in_foot(frames).dot(axis.cross(direction));
}

// The links whose first moments are the basis: that of the parameter and those after it whose axes
// stay parallel to its axis. For alpha, d, r, beta and the base the next link counts too, with the
// links after it that stay parallel to that one. A link without a revolute joint keeps its
// orientation in the link before it, whatever its axis is.
std::vector<int> GravityLoad::carrying_links(const KinematicChain& chain) const {
  const int last = joint_count(chain) > 0 ? link_of_joint(chain, joint_count(chain) - 1) : -1;
  if (link_ > last) return {};
  const bool own_axis = parameter_ == link_parameter(link_, LinkParameter::theta);
  std::vector<int> links{link_};
  if (!own_axis && link_ + 1 <= last) links.push_back(link_ + 1);
  Eigen::Matrix3d since_turn = Eigen::Matrix3d::Identity();  // from the last link that turns
  for (int j = links.back() + 1; j <= last; ++j) {
    const Link& link = chain.links[j];
    since_turn = since_turn * Eigen::AngleAxisd(link.beta, Vector3d::UnitY()) *
                 Eigen::AngleAxisd(link.alpha, Vector3d::UnitX());
    if (link.joint == JointKind::revolute) {
      if (std::abs(since_turn(0, 2)) >= kParallel || std::abs(since_turn(1, 2)) >= kParallel) break;
      since_turn.setIdentity();
    } else {
      since_turn = since_turn * Eigen::AngleAxisd(link.theta, Vector3d::UnitZ());
    }
    links.push_back(j);
  }
  return links;
}

// The frames that a joint of a positioner carries: all before it. -1 is R_0.
std::vector<int> GravityLoad::carried_links() const {
  std::vector<int> links;
  for (int j = link_ - 1; parameter_ >= kFirstLinkParameter && j >= -1; --j) links.push_back(j);
  return links;
}

// The motions that share a basis. All parameters of the base have that of the turns about the three
// axes of R_0: a moment of mass is then left out or kept for all of them, wherever R_A is.
std::vector<GravityLoad::Motion> GravityLoad::motions_of_basis(const ArmFrames& frames) const {
  if (parameter_ >= kFirstLinkParameter) return {motion(frames)};
  std::vector<Motion> turns;
  for (int axis = 0; axis < 3; ++axis)
    turns.push_back({Vector3d::Unit(axis), Vector3d::Zero(), true});
  return turns;
}

void GravityLoad::choose_basis(const Robot& robot, const ChainEvaluator& evaluator) {
  const bool shifts_base = parameter_ < kFirstLinkParameter && parameter_ % kParametersPerPose < 3;
  if (shifts_base) return;  // gravity does not change with the place
  std::vector<FirstMoment> moments;
  for (int link : of_positioner_ ? carried_links() : carrying_links(robot.chain)) {
    for (int axis = 0; axis < 3; ++axis) moments.push_back({link, axis});
    // None by travel for the base, in whichever direction a rail leads.
    if (!of_positioner_ && is_prismatic(robot.chain.links[link]) &&
        parameter_ >= kFirstLinkParameter)
      moments.push_back({link, 2, true});
  }
  if (moments.empty()) return;
  const int count = std::max(kFewestBasisPoses, kBasisPosesPerJoint * joint_count(robot.chain));
  const std::vector<JointVector> poses = sample_joint_space(robot.chain, count);
  std::vector<LinkFrames> frames;
  for (const JointVector& pose : poses) frames.push_back(evaluator.link_frames(pose));
  const Eigen::Index motions = motions_of_basis(frames.front()).size();
  // Keep values that are independent of the constant of each motion and of those kept already.
  Eigen::MatrixXd kept = Eigen::MatrixXd::Zero(motions * count, motions);
  for (Eigen::Index m = 0; m < motions; ++m)
    kept.col(m).segment(m * count, count).setConstant(1 / std::sqrt(count));
  for (const FirstMoment& moment : moments) {
    Eigen::VectorXd column(motions * count), arm(count), own(count);
    for (int i = 0; i < count; ++i) {
      const std::vector<Motion> moved = motions_of_basis(frames[i]);
      for (Eigen::Index m = 0; m < motions; ++m)
        column[m * count + i] = first_moment_value(moment, moved[m], frames[i]);
      own[i] = first_moment_value(moment, motion(frames[i]), frames[i]);
      arm[i] = arm_of(moment, frames[i]);
    }
    const double least = kMinNew * gravity_.norm() * arm.norm();
    if ((own.array() - own.mean()).matrix().norm() > least) has_work_ = true;
    for (int twice = 0; twice < 2; ++twice) column -= kept * (kept.transpose() * column);
    if (column.norm() <= least) continue;
    kept.conservativeResize(Eigen::NoChange, kept.cols() + 1);
    kept.rightCols<1>() = column.normalized();
    basis_.push_back(moment);
  }
}

void GravityLoad::values(const Context& context, const ArmFrames& frames, double* out) const {
  if (!by_masses_) {
    std::fill(out, out + basis_.size(), 0.0);
    if (!has_work_) return;
    const Motion moved = motion(frames);
    for (size_t k = 0; k < basis_.size(); ++k)
      out[k] = first_moment_value(basis_[k], moved, frames);
    return;
  }
  out[0] = 0;
  if (link_ >= links_) return;
  const Motion moved = motion(frames);
  const Vector3d gravity = gravity_in_foot(frames);
  for (const Body& body : bodies_)
    out[0] += body.mass_kg *
              gravity.dot(velocity(moved, frames, body.link, frames[body.link] * body.centre));
  if (context.payload_kg != 0)
    out[0] += context.payload_kg *
              gravity.dot(velocity(moved, frames, links_ - 1, frames.back() * payload_point_));
}

}  // namespace armtrue
