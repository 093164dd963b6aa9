#include "compensation/branch.h"

#include <Eigen/Geometry>
#include <cmath>

namespace armtrue {
namespace {

constexpr double kBoth = 1e-9;  // [m], [m^2], 1: a program written at zero is of either branch

int sign_of(double value) {
  if (std::abs(value) < kBoth) return 0;
  return value > 0 ? 1 : -1;
}

}  // namespace

Branch branch_of(const ChainEvaluator& arm, const JointVector& q, int first) {
  const LinkFrames frames = arm.link_frames(q);
  const auto at = [first](size_t j) { return static_cast<size_t>(first) + j; };
  const auto axis = [&](size_t j) -> Eigen::Vector3d { return frames[at(j)].rotation.col(2); };
  const auto origin = [&](size_t j) -> const Eigen::Vector3d& { return frames[at(j)].translation; };
  const Eigen::Vector3d wrist = origin(4);
  Branch branch;
  branch.shoulder = sign_of(axis(0).cross(axis(1)).dot(wrist - origin(0)));
  branch.elbow = sign_of(axis(1).dot((origin(2) - origin(1)).cross(wrist - origin(2))));
  branch.wrist = sign_of(axis(3).cross(axis(5)).dot(axis(4)));
  return branch;
}

Branch branch_of_few(const KinematicChain& chain, const ChainEvaluator& arm, const JointVector& q,
                     const std::array<int, 3>& links) {
  const LinkFrames frames = arm.link_frames(q);
  const Eigen::Vector3d place = frames[static_cast<size_t>(links[2]) + 1].translation;
  Eigen::Matrix3d motion;
  for (size_t j = 0; j < links.size(); ++j) {
    const Pose& frame = frames[links[j]];
    const Eigen::Vector3d axis = frame.rotation.col(2);
    motion.col(j) = axis;
    if (!is_prismatic(chain.links[links[j]])) motion.col(j) = axis.cross(place - frame.translation);
  }
  Branch branch;
  branch.elbow = sign_of(motion.determinant());
  return branch;
}

bool is_same(const Branch& a, const Branch& b) {
  return a.shoulder * b.shoulder >= 0 && a.elbow * b.elbow >= 0 && a.wrist * b.wrist >= 0;
}

bool stays(const Branch& before, const Branch& now) {
  const auto same = [](int a, int b) { return a == 0 || a == b; };
  return same(before.shoulder, now.shoulder) && same(before.elbow, now.elbow) &&
         same(before.wrist, now.wrist);
}

double wrist_sine(const ChainEvaluator& arm, const JointVector& q, int first) {
  const LinkFrames frames = arm.link_frames(q);
  const auto axis = [&](size_t j) -> Eigen::Vector3d { return frames[first + j].rotation.col(2); };
  return axis(3).cross(axis(5)).norm();
}

}  // namespace armtrue
