#include "armtrue/kinematics/parameters.h"

#include <stdexcept>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr const char* kInstrumentNames[] = {"scale", "range", "azimuth", "elevation"};
constexpr const char* kAnchorNames[] = {"x", "y", "z", "zero"};
constexpr const char* kLinkParameterNames[] = {"alpha", "d", "theta", "r", "beta"};

void move_pose(Pose& pose, int component, double delta) {
  if (component < 3) {
    pose.translation[component] += delta;
    return;
  }
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  w[component - 3] = delta;
  pose.rotation = rotation_exp(w) * pose.rotation;
}

}  // namespace

ParameterUnit parameter_unit(int index) {
  if (index == kInstrumentScale) return ParameterUnit::one;
  if (index >= kTargetParameters || index == kInstrumentRange) return ParameterUnit::metre;
  if (is_instrument_parameter(index)) return ParameterUnit::radian;
  if (index < kLinkParameters) return index < 3 ? ParameterUnit::metre : ParameterUnit::radian;
  if (index >= kToolParameters)
    return index - kToolParameters < 3 ? ParameterUnit::metre : ParameterUnit::radian;
  const auto which = static_cast<LinkParameter>((index - kLinkParameters) % 5);
  return which == LinkParameter::d || which == LinkParameter::r ? ParameterUnit::metre
                                                                : ParameterUnit::radian;
}

DisplayUnit display_unit(ParameterUnit unit) {
  switch (unit) {
    case ParameterUnit::metre:
      return {kMillimetre, "mm"};
    case ParameterUnit::radian:
      return {kMilliradian, "mrad"};
    case ParameterUnit::one:
      break;
  }
  return {kPartPerMillion, "ppm"};
}

std::string parameter_name(const KinematicChain& chain, int index) {
  if (index < 0 || index >= parameter_count(chain)) throw std::out_of_range("no such parameter");
  if (index < kLinkParameters) return std::string("base.") + kTwistNames[index];
  if (index < kToolParameters) {
    const int k = index - kLinkParameters;
    return chain.links[k / 5].name + "." + kLinkParameterNames[k % 5];
  }
  if (index < kInstrumentScale) return std::string("tool.") + kTwistNames[index - kToolParameters];
  if (is_instrument_parameter(index))
    return std::string("instrument.") + kInstrumentNames[index - kInstrumentScale];
  if (const int k = index - first_anchor_parameter(chain); k >= 0)
    return "anchor " + chain.anchors[k / 4].name + "." + kAnchorNames[k % 4];
  const int k = index - kTargetParameters;
  return "target " + chain.targets[k / 3].name + "." + kTwistNames[k % 3];
}

std::optional<int> find_parameter(const KinematicChain& chain, std::string_view name) {
  for (int index = 0; index < parameter_count(chain); ++index)
    if (parameter_name(chain, index) == name) return index;
  return std::nullopt;
}

void move_parameter(KinematicChain& chain, int index, double delta) {
  if (index < 0 || index >= parameter_count(chain)) throw std::out_of_range("no such parameter");
  if (index < kLinkParameters) return move_pose(chain.base, index, delta);
  if (index < kToolParameters) {
    const int k = index - kLinkParameters;
    Link& link = chain.links[k / 5];
    double* const members[] = {&link.alpha, &link.d, &link.theta, &link.r, &link.beta};
    *members[k % 5] += delta;
    return;
  }
  if (index < kInstrumentScale) return move_pose(chain.tool, index - kToolParameters, delta);
  if (is_instrument_parameter(index)) return;
  if (const int k = index - first_anchor_parameter(chain); k >= 0) {
    Anchor& anchor = chain.anchors[k / 4];
    (k % 4 < 3 ? anchor.position[k % 4] : anchor.zero) += delta;
    return;
  }
  const int k = index - kTargetParameters;
  chain.targets[k / 3].position[k % 3] += delta;
}

}  // namespace armtrue
