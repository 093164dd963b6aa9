#include "compensation/all_postures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "armtrue/kinematics/units.h"
#include "compensation/joint_correction.h"

namespace armtrue {
namespace {

using Eigen::Vector3d;

// What the errors of axes move an arm away from the closed form, generously: some mrad, some mm.
constexpr double kOwnPosition = 10 * kMillimetre, kOwnTurn = 10 * kMilliradian;
// A posture that they move by more lies near a singular one.
constexpr double kOwnAngle = 5 * kDegree;

// From one direction to another, about an axis.
double angle_about(const Vector3d& axis, const Vector3d& from, const Vector3d& to) {
  return std::atan2(axis.dot(from.cross(to)), from.dot(to) - axis.dot(from) * axis.dot(to));
}

Vector3d across(const Vector3d& axis, const Vector3d& vector) {
  return vector - axis.dot(vector) * axis;
}

Vector3d turned(const Vector3d& axis, double angle, const Vector3d& vector) {
  return Eigen::AngleAxisd(angle, axis) * vector;
}

class PosturesInClosedForm {
 public:
  PosturesInClosedForm(const ProgramArm& arm, const Context& context, const Pose& wanted)
      : arm_(arm), joints_(arm.program_joints()), context_(context), wanted_(wanted) {}

  std::optional<std::vector<JointVector>> find() {
    if (!joints_.is_six() || !arm_.robot().chain.couplings.empty() || !is_built_so())
      return std::nullopt;
    place_shoulder();
    if (!is_clear_) return std::nullopt;
    return found_;
  }

 private:
  Vector3d axis(const LinkFrames& frames, int j) const { return frame(frames, j).rotation.col(2); }
  const Pose& frame(const LinkFrames& frames, int j) const {
    return frames[joints_.first_link + j];
  }
  void turn(JointVector& q, int j, double angle) const {
    q[joints_.arm[j]] += joint_link(arm_.robot().chain, joints_.arm[j]).sign * angle;
  }

  // Whether the axes lie as the closed form takes them: that it has no posture says of no other arm
  // that it has none. From one posture to another an offset of the wrist moves its centre by twice
  // as much.
  bool is_built_so() const {
    const LinkFrames frames = arm_.chain().link_frames(context_.q);
    const Vector3d centre = frame(frames, 4).translation;
    const auto is_across = [&](int a, int b) {
      return std::abs(axis(frames, a).dot(axis(frames, b))) < kOwnTurn;
    };
    const auto meets_centre = [&](int j) {
      return across(axis(frames, j), centre - frame(frames, j).translation).norm() <
             kOwnPosition / 2;
    };
    return is_across(0, 1) && axis(frames, 1).cross(axis(frames, 2)).norm() < kOwnTurn &&
           is_across(3, 4) && is_across(4, 5) && meets_centre(3) && meets_centre(5);
  }

  // The two angles at which a cos(x) - b sin(x) is `value`, which the scale turns into a length.
  // Nothing if the arm is too short, or too long, by more than its own errors.
  static std::optional<double> arc_cosine(double value, double beyond) {
    if (beyond > kOwnPosition) return std::nullopt;
    return std::acos(std::clamp(value, -1.0, 1.0));
  }

  // Axis 1 brings the plane of axes 2 and 3 through the centre of the wrist.
  void place_shoulder() {
    const JointVector start = context_.q;
    const LinkFrames frames = arm_.chain().link_frames(start);
    const Pose tcp = arm_.pose(context_);
    const Vector3d centre = frame(frames, 4).translation;
    const Vector3d wanted_centre = wanted_ * (inverse(tcp) * centre);
    wanted_axis_ = wanted_.rotation * (tcp.rotation.transpose() * axis(frames, 5));
    const Vector3d z1 = axis(frames, 0), z2 = axis(frames, 1), foot = frame(frames, 0).translation;
    const Vector3d flat = across(z1, wanted_centre - foot);
    const double beside = z2.dot(centre - wanted_centre + flat);
    const double a = z2.dot(flat), b = z2.dot(z1.cross(flat)), size = std::hypot(a, b);
    const auto half = arc_cosine(beside / size, std::abs(beside) - size);
    if (!half) return;
    for (const double side : {1.0, -1.0}) {
      const double angle = side * *half - std::atan2(b, a);
      JointVector q = start;
      turn(q, 0, angle);
      place_elbow(q, frames, foot + turned(z1, -angle, wanted_centre - foot));
    }
  }

  // Axes 2 and 3 bring the centre of the wrist to `wanted`, as seen with axis 1 as in `frames`.
  void place_elbow(const JointVector& start, const LinkFrames& frames, const Vector3d& wanted) {
    const Vector3d z2 = axis(frames, 1), elbow = frame(frames, 2).translation;
    const Vector3d upper = across(z2, elbow - frame(frames, 1).translation);
    const Vector3d fore = across(z2, frame(frames, 4).translation - elbow);
    const Vector3d reach = across(z2, wanted - frame(frames, 1).translation);
    const double u = upper.norm(), f = fore.norm(), r = reach.norm();
    const auto bend = arc_cosine((r * r - u * u - f * f) / (2 * u * f),
                                 std::max(r - (u + f), std::abs(u - f) - r));
    if (!bend) return;
    for (const double side : {1.0, -1.0}) {
      const double angle = side * *bend - angle_about(z2, upper, fore);
      JointVector q = start;
      turn(q, 2, angle * (axis(frames, 2).dot(z2) > 0 ? 1 : -1));
      turn(q, 1, angle_about(z2, upper + turned(z2, angle, fore), reach));
      place_wrist(q);
    }
  }

  // Axes 4 and 5 turn axis 6 to where it is wanted, and axis 6 does the rest.
  void place_wrist(const JointVector& start) {
    for (const double side : {1.0, -1.0}) {
      JointVector q = start;
      LinkFrames frames = arm_.chain().link_frames(q);
      const Vector3d z5 = side * axis(frames, 3).cross(wanted_axis_);
      turn(q, 3, angle_about(axis(frames, 3), axis(frames, 4), z5));
      frames = arm_.chain().link_frames(q);
      turn(q, 4, angle_about(axis(frames, 4), axis(frames, 5), wanted_axis_));
      frames = arm_.chain().link_frames(q);
      context_.q = q;
      const Pose tcp = arm_.pose(context_);
      turn(q, 5,
           axis(frames, 5).dot(rotation_log(wanted_.rotation * tcp.rotation.transpose())));
      add(q);
    }
  }

  void add(const JointVector& q) {
    context_.q = q;
    const PoseDifference apart = difference(wanted_, arm_.pose(context_));
    if (apart.position > kOwnPosition || apart.orientation > kOwnTurn) {
      is_clear_ = false;
      return;
    }
    const JointCorrection refined = joints_of_pose(arm_, context_, wanted_, q);
    if (refined.is_reached && (refined.q - q).cwiseAbs().maxCoeff() < kOwnAngle)
      found_.push_back(refined.q);
    else
      is_clear_ = false;
  }

  const ProgramArm& arm_;
  const ProgramJoints& joints_;
  Context context_;
  const Pose& wanted_;
  Vector3d wanted_axis_;  // axis 6 at the pose
  std::vector<JointVector> found_;
  bool is_clear_ = true;
};

}  // namespace

std::optional<std::vector<JointVector>> all_postures(const ProgramArm& arm, Context context,
                                                     const Pose& wanted) {
  return PosturesInClosedForm(arm, context, wanted).find();
}

}  // namespace armtrue
