#pragma once

// Derivatives of a chain with respect to its parameters, automatically: armtrue's parameters handed
// to the chain that is written once more in autodiff_chain.h.

#include <ceres/jet.h>

#include <Eigen/Core>
#include <array>

#include "armtrue/kinematics/parameters.h"
#include "kinematics/frame_derivative.h"
#include "kinematics/six_axes.h"
#include "support/autodiff_chain.h"

namespace armtrue {

/// The first N parameters of a chain, each its own variable; targets, scale and anchors as changes.
template <int N>
using JetParameters = std::array<ceres::Jet<double, N>, N>;

template <int N>
JetParameters<N> jet_parameters(const KinematicChain& chain) {
  JetParameters<N> p;
  for (int k = 0; k < N; ++k) p[k] = ceres::Jet<double, N>(0.0, k);
  for (int j = 0; j < kLinks; ++j) {
    const Link& link = chain.links[j];
    const double values[] = {link.alpha, link.d, link.theta, link.r, link.beta};
    for (int i = 0; i < 5; ++i) p[link_parameter(j, LinkParameter::alpha) + i].a = values[i];
  }
  return p;
}

/// R_A from the measured frame.
template <int N>
armtrue_oracle::Transform<ceres::Jet<double, N>> jet_frame(const KinematicChain& chain,
                                                           const JetParameters<N>& parameters,
                                                           const JointVector& q) {
  double sign[kJoints];
  for (int j = 0; j < kJoints; ++j) sign[j] = chain.links[j].sign;
  return armtrue_oracle::chain<ceres::Jet<double, N>>(
      parameters.data(), q.data(), sign, homogeneous(chain.base), homogeneous(chain.tool));
}

}  // namespace armtrue
