#include "armtrue/kinematics/parameters.h"

#include <stdexcept>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr const char* kInstrumentNames[] = {"scale", "range", "azimuth", "elevation"};
constexpr const char* kAnchorNames[] = {"x", "y", "z", "zero"};
constexpr const char* kContactNames[] = {"x", "y", "z", "rx", "ry", "rz", "radius"};
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

void move_contact(Contact& contact, int which, double delta) {
  if (which < 3) {
    contact.place.translation += contact.place.rotation.col(which) * delta;
  } else if (which < 6) {
    contact.place.rotation =
        contact.place.rotation * rotation_exp(delta * Eigen::Vector3d::Unit(which - 3));
  } else {
    contact.radius += delta;
  }
}

}  // namespace

std::vector<int> of_contact(ContactKind kind) {
  switch (kind) {
    case ContactKind::point:
      return {0, 1, 2};
    case ContactKind::artefact:
      return {0, 1, 2, 3, 4, 5};
    case ContactKind::plane:
      return {2, 3, 4};
    case ContactKind::sphere:
      return {0, 1, 2, 6};
  }
  return {};
}

int zero_offset(const KinematicChain& chain, int joint) {
  const int link = link_of_joint(chain, joint);
  const bool slides = is_prismatic(chain.links[static_cast<size_t>(link)]);
  return link_parameter(link, slides ? LinkParameter::r : LinkParameter::theta);
}

bool is_zero_offset(const KinematicChain& chain, int index) {
  if (!layout_of(chain).is_of_links(index)) return false;
  const int joint = joint_of_link(chain, link_of_parameter(index));
  return joint >= 0 && index == zero_offset(chain, joint);
}

ParameterUnit parameter_unit(const KinematicChain& chain, int index) {
  const ParameterLayout layout = layout_of(chain);
  if (index == layout.instrument_scale) return ParameterUnit::one;
  if (const int k = index - first_contact_parameter(chain); k >= 0) {
    const int which = k % kParametersOfContact;
    return which >= 3 && which < 6 ? ParameterUnit::radian : ParameterUnit::metre;
  }
  if (index >= layout.targets || index == layout.instrument_range) return ParameterUnit::metre;
  if (layout.is_of_instrument(index)) return ParameterUnit::radian;
  if (index < kFirstLinkParameter) return index < 3 ? ParameterUnit::metre : ParameterUnit::radian;
  if (index >= layout.tool)
    return index - layout.tool < 3 ? ParameterUnit::metre : ParameterUnit::radian;
  const LinkParameter which = kind_of_parameter(index);
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
  if (index < kFirstLinkParameter) return std::string("base.") + kTwistNames[index];
  const ParameterLayout layout = layout_of(chain);
  if (index < layout.tool)
    return chain.links[static_cast<size_t>(link_of_parameter(index))].name + "." +
           kLinkParameterNames[static_cast<int>(kind_of_parameter(index))];
  if (index < layout.instrument_scale)
    return std::string("tool.") + kTwistNames[static_cast<size_t>(index - layout.tool)];
  if (layout.is_of_instrument(index))
    return std::string("instrument.") + kInstrumentNames[index - layout.instrument_scale];
  if (const int k = index - first_contact_parameter(chain); k >= 0)
    return "contact " + chain.contacts[static_cast<size_t>(k / kParametersOfContact)].name + "." +
           kContactNames[k % kParametersOfContact];
  if (const int k = index - first_anchor_parameter(chain); k >= 0)
    return "anchor " + chain.anchors[k / 4].name + "." + kAnchorNames[k % 4];
  const int k = index - layout.targets;
  return "target " + chain.targets[k / 3].name + "." + kTwistNames[k % 3];
}

std::optional<int> find_parameter(const KinematicChain& chain, std::string_view name) {
  for (int index = 0; index < parameter_count(chain); ++index)
    if (parameter_name(chain, index) == name) return index;
  return std::nullopt;
}

void move_parameter(KinematicChain& chain, int index, double delta) {
  if (index < 0 || index >= parameter_count(chain)) throw std::out_of_range("no such parameter");
  if (index < kFirstLinkParameter) return move_pose(chain.base, index, delta);
  const ParameterLayout layout = layout_of(chain);
  if (index < layout.tool) {
    Link& link = chain.links[static_cast<size_t>(link_of_parameter(index))];
    double* const members[] = {&link.alpha, &link.d, &link.theta, &link.r, &link.beta};
    *members[static_cast<int>(kind_of_parameter(index))] += delta;
    return;
  }
  if (index < layout.instrument_scale) return move_pose(chain.tool, index - layout.tool, delta);
  if (layout.is_of_instrument(index)) return;
  if (const int k = index - first_contact_parameter(chain); k >= 0)
    return move_contact(chain.contacts[static_cast<size_t>(k / kParametersOfContact)],
                        k % kParametersOfContact, delta);
  if (const int k = index - first_anchor_parameter(chain); k >= 0) {
    Anchor& anchor = chain.anchors[k / 4];
    (k % 4 < 3 ? anchor.position[k % 4] : anchor.zero) += delta;
    return;
  }
  const int k = index - layout.targets;
  chain.targets[k / 3].position[k % 3] += delta;
}

}  // namespace armtrue
