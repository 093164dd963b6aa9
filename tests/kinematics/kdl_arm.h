#pragma once

// The chain as KDL holds it, by KDL's own modified Denavit-Hartenberg frames (Craig), which know no
// beta.

#include <Eigen/Core>
#include <kdl/chain.hpp>

#include "armtrue/kinematics/chain.h"
#include "kinematics/six_axes.h"

namespace armtrue {

inline KDL::Frame kdl_frame(const Pose& pose) {
  const Eigen::Matrix3d& r = pose.rotation;
  return {KDL::Rotation(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1),
                        r(2, 2)),
          KDL::Vector(pose.translation.x(), pose.translation.y(), pose.translation.z())};
}

/// From R_A to the measured frame: one segment for each driven joint and one after the last.
inline KDL::Chain kdl_arm(const KinematicChain& chain) {
  KDL::Chain arm;
  KDL::Frame before = kdl_frame(chain.base);
  for (int j = 0; j < kJoints; ++j) {
    // Craig's frame at angle zero, then the joint about its z.
    const Link& link = chain.links[j];
    before = before * KDL::Frame::DH_Craig1989(link.d, link.alpha, link.r, link.theta);
    arm.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), before));
    arm.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ, link.sign)));
    before = KDL::Frame::Identity();
  }
  const Link& last = chain.links[kJoints];
  arm.addSegment(KDL::Segment(
      KDL::Joint(KDL::Joint::None),
      KDL::Frame::DH_Craig1989(last.d, last.alpha, last.r, last.theta) * kdl_frame(chain.tool)));
  return arm;
}

}  // namespace armtrue
