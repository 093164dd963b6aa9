#include "armtrue/kinematics/parameters.h"

#include <algorithm>
#include <ostream>
#include <span>
#include <stdexcept>

#include "armtrue/kinematics/names.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr const char* kArmNames[] = {"scale"};
constexpr const char* kInstrumentNames[] = {"scale", "range", "azimuth", "elevation"};
constexpr std::string_view kPointName = "point";  // all components of the instrument
constexpr const char* kAnchorNames[] = {"x", "y", "z", "zero"};
constexpr const char* kContactNames[] = {"x",  "y",  "z",  "rx", "ry", "rz", "radius", "fx", "fy",
                                         "cx", "cy", "k1", "k2", "p1", "p2", "k3",     "k4"};
static_assert(std::size(kContactNames) == kParametersOfContact);
constexpr const char* kLinkParameterNames[] = {"alpha", "d", "theta", "r", "beta"};

using Names = std::span<const char* const>;

// The names of the components of each owner.
Names component_names(Owner owner) {
  switch (owner) {
    case Owner::link:
      return kLinkParameterNames;
    case Owner::base:
    case Owner::tool:
      return kTwistNames;
    case Owner::arm:
      return kArmNames;
    case Owner::instrument:
      return kInstrumentNames;
    case Owner::target:
      return Names(kTwistNames).first(3);
    case Owner::anchor:
      return kAnchorNames;
    case Owner::beam:
    case Owner::board:
    case Owner::camera:
    case Owner::contact:
      return kContactNames;
    case Owner::coupling:
    case Owner::several:
      break;
  }
  return {};
}

// Between the names of the links of a coupling.
constexpr std::string_view kFollows = ".follows.";

// The word before the name of an owner, of which there are several.
struct OwnerWord {
  Owner owner;
  std::string_view word;
};
constexpr OwnerWord kNamed[] = {{Owner::target, "target"},   {Owner::anchor, "anchor"},
                                {Owner::contact, "contact"}, {Owner::beam, "beam"},
                                {Owner::board, "board"},     {Owner::camera, "camera"}};
constexpr OwnerWord kSingle[] = {{Owner::arm, "arm"},
                                 {Owner::base, "base"},
                                 {Owner::tool, "tool"},
                                 {Owner::instrument, "instrument"}};

std::optional<int> component_of(Owner owner, std::string_view name) {
  return find_name(component_names(owner), name);
}

// The text before the last dot, and that behind it; both empty without a dot.
std::pair<std::string_view, std::string_view> at_last_dot(std::string_view text) {
  const size_t dot = text.rfind('.');
  if (dot == std::string_view::npos) return {};
  return {text.substr(0, dot), text.substr(dot + 1)};
}

// What stands behind the word of an owner and a blank; nothing if it is another text.
std::optional<std::string_view> behind(std::string_view word, std::string_view text) {
  if (!text.starts_with(word) || text.size() <= word.size() + 1 || text[word.size()] != ' ')
    return std::nullopt;
  return text.substr(word.size() + 1);
}

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
  } else if (which < kFirstIntrinsic) {
    contact.radius += delta;
  } else {
    contact.intrinsics[which - kFirstIntrinsic] += delta;
  }
}

Owner owner_of(ContactKind kind) {
  switch (kind) {
    case ContactKind::beam:
      return Owner::beam;
    case ContactKind::board:
      return Owner::board;
    case ContactKind::camera:
      return Owner::camera;
    default:
      return Owner::contact;
  }
}

std::vector<int> of_camera(Lens lens) {
  std::vector<int> parameters{0, 1, 2, 3, 4, 5};
  for (int k : {kFx, kFy, kCx, kCy, kK1, kK2}) parameters.push_back(kFirstIntrinsic + k);
  for (int k : lens == Lens::pinhole ? std::vector<int>{kP1, kP2, kK3} : std::vector<int>{kK3, kK4})
    parameters.push_back(kFirstIntrinsic + k);
  return parameters;
}

// Faces do not show a shift along all of them, nor a turn about the normal of all.
std::vector<int> of_artefact(const Contact& artefact) {
  const std::vector<ArtefactPoint>& parts = artefact.points;
  std::vector<int> parameters;
  for (int axis = 0; axis < 3; ++axis)
    if (std::ranges::any_of(parts, [axis](const ArtefactPoint& part) {
          return part.kind != ContactKind::plane || part.normal[axis] != 0;
        }))
      parameters.push_back(axis);
  for (int axis = 0; axis < 3; ++axis)
    if (std::ranges::any_of(parts, [axis](const ArtefactPoint& part) {
          return part.kind != ContactKind::plane ||
                 part.normal.cwiseAbs() != Eigen::Vector3d::Unit(axis);
        }))
      parameters.push_back(3 + axis);
  const bool has_surfaces = std::ranges::any_of(
      parts, [](const ArtefactPoint& part) { return part.kind != ContactKind::point; });
  if (has_surfaces && !artefact.radius_is_known) parameters.push_back(6);
  return parameters;
}

}  // namespace

std::vector<int> parameters_of_contact(const Contact& contact) {
  switch (contact.kind) {
    case ContactKind::point:
      return {0, 1, 2};
    case ContactKind::artefact:
      return of_artefact(contact);
    case ContactKind::beam:
      return {0, 1, 2, 3, 4};
    case ContactKind::board:
      return {0, 1, 2, 3, 4, 5};
    case ContactKind::camera:
      return of_camera(contact.lens);
    case ContactKind::plane:
      return {2, 3, 4};
    case ContactKind::sphere:
      return {0, 1, 2, 6};
  }
  return {};
}

int zero_offset(const KinematicChain& chain, int joint) {
  return zero_of_link(chain, link_of_joint(chain, joint));
}

std::string coupling_name(const KinematicChain& chain, const Coupling& coupling) {
  return chain.links[coupling.follower].name + std::string(kFollows) +
         chain.links[coupling.followed].name;
}

bool is_zero_offset(const KinematicChain& chain, int index) {
  if (!layout_of(chain).is_of_links(index)) return false;
  const int joint = joint_of_link(chain, link_of_parameter(index));
  return joint >= 0 && index == zero_offset(chain, joint);
}

double coefficient_unit(const KinematicChain& chain, const Coupling& coupling) {
  const auto unit = [&](int link) { return is_prismatic(chain.links[link]) ? kMillimetre : 1.0; };
  return unit(coupling.follower) / unit(coupling.followed);
}

ParameterUnit parameter_unit(const KinematicChain& chain, int index) {
  const ParameterLayout layout = layout_of(chain);
  if (index == layout.arm_scale || index == layout.instrument_scale ||
      layout.is_of_couplings(index))
    return ParameterUnit::one;
  if (const int k = index - first_contact_parameter(chain); k >= 0) {
    const int which = k % kParametersOfContact;
    if (which >= kFirstIntrinsic)
      return which - kFirstIntrinsic < kK1 ? ParameterUnit::pixel : ParameterUnit::one;
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
    case ParameterUnit::pixel:
      return {1, "px"};
    case ParameterUnit::one:
      break;
  }
  return {kPartPerMillion, "ppm"};
}

namespace {

Parameter parse(std::string_view text) {
  const auto [before, last] = at_last_dot(text);
  if (const size_t at = text.find(kFollows);
      at != std::string_view::npos && at > 0 && at + kFollows.size() < text.size())
    return {Owner::coupling, std::string(text), 0};
  if (const auto which = component_of(Owner::link, last))
    return {Owner::link, std::string(before), *which};
  for (const auto& [single, word] : kSingle) {
    const bool is_instrument = single == Owner::instrument;
    const bool is_whole =
        is_instrument ? before == word && last == kPointName : single != Owner::arm && text == word;
    if (is_whole) return {single, "", Parameter::kWhole};
    if (before != word) continue;
    if (const auto which = component_of(single, last)) return {single, "", *which};
  }
  for (const auto& [named, word] : kNamed)
    if (const auto name = behind(word, text)) {
      const auto [own_name, of_it] = at_last_dot(*name);
      const auto which = component_of(named, of_it);
      if (which && !own_name.empty()) return {named, std::string(own_name), *which};
      return {named, std::string(*name), Parameter::kWhole};
    }
  return {Owner::several, std::string(text), Parameter::kWhole};
}

}  // namespace

Parameter::Parameter(std::string_view text) : Parameter(parse(text)) {}

Parameter parameter_of_catalogue(std::string_view text) {
  Parameter each;
  each.of_each = true;
  if (const auto which = component_of(Owner::link, text)) {
    each.owner = Owner::link;
    each.component = *which;
    return each;
  }
  const auto [before, last] = at_last_dot(text);
  for (const auto& [named, word] : kNamed) {
    each.owner = named;
    if (text == word && named == Owner::target) return each;
    if (before != word) continue;
    if (const auto which = component_of(named, last)) {
      each.component = *which;
      return each;
    }
  }
  return text;
}

std::string to_string(const Parameter& parameter) {
  std::string text = parameter.of;
  for (const auto& [owner, word] : kNamed)
    if (owner == parameter.owner) text = std::string(word) + (text.empty() ? "" : " " + text);
  for (const auto& [owner, word] : kSingle)
    if (owner == parameter.owner) text = word;
  if (parameter.component != Parameter::kWhole && parameter.owner != Owner::coupling) {
    const std::string name = component_names(parameter.owner)[parameter.component];
    return text.empty() ? name : text + "." + name;
  }
  return parameter.owner == Owner::instrument ? text + "." + std::string(kPointName) : text;
}

std::ostream& operator<<(std::ostream& stream, const Parameter& parameter) {
  return stream << to_string(parameter);
}

Parameter parameter_of(const KinematicChain& chain, int index) {
  if (index < 0 || index >= parameter_count(chain)) throw std::out_of_range("no such parameter");
  if (index < kFirstLinkParameter) return {Owner::base, "", index};
  const ParameterLayout layout = layout_of(chain);
  if (index < layout.tool)
    return {Owner::link, chain.links[link_of_parameter(index)].name, place_in_link(index)};
  if (index < layout.couplings) return {Owner::tool, "", index - layout.tool};
  if (layout.is_of_couplings(index))
    return {Owner::coupling, coupling_name(chain, chain.couplings[index - layout.couplings]), 0};
  if (index == layout.arm_scale) return {Owner::arm, "", 0};
  if (layout.is_of_instrument(index))
    return {Owner::instrument, "", index - layout.instrument_scale};
  if (const int k = index - first_contact_parameter(chain); k >= 0) {
    const Contact& contact = chain.contacts[k / kParametersOfContact];
    return {owner_of(contact.kind), contact.name, k % kParametersOfContact};
  }
  if (const int k = index - first_anchor_parameter(chain); k >= 0)
    return {Owner::anchor, chain.anchors[k / 4].name, k % 4};
  const int k = index - layout.targets;
  return {Owner::target, chain.targets[k / 3].name, k % 3};
}

std::string parameter_name(const KinematicChain& chain, int index) {
  return to_string(parameter_of(chain, index));
}

std::optional<int> find_parameter(const KinematicChain& chain, const Parameter& parameter) {
  if (parameter.component == Parameter::kWhole) return std::nullopt;
  const auto place = [&](const auto& all, int first, int size) -> std::optional<int> {
    const auto found = find_name(all, parameter.of);
    if (!found) return std::nullopt;
    return first + size * *found + parameter.component;
  };
  const ParameterLayout layout = layout_of(chain);
  switch (parameter.owner) {
    case Owner::base:
      return kFirstBaseParameter + parameter.component;
    case Owner::link:
      return place(chain.links, kFirstLinkParameter, kParametersPerLink);
    case Owner::tool:
      return layout.tool + parameter.component;
    case Owner::coupling: {
      for (int k = 0; k < std::ssize(chain.couplings); ++k)
        if (coupling_name(chain, chain.couplings[k]) == parameter.of) return layout.couplings + k;
      return std::nullopt;
    }
    case Owner::arm:
      return layout.arm_scale;
    case Owner::instrument:
      return layout.instrument_scale + parameter.component;
    case Owner::target:
      return place(chain.targets, layout.targets, 3);
    case Owner::anchor:
      return place(chain.anchors, first_anchor_parameter(chain), 4);
    case Owner::beam:
    case Owner::board:
    case Owner::camera:
    case Owner::contact: {
      const auto found =
          place(chain.contacts, first_contact_parameter(chain), kParametersOfContact);
      if (!found || parameter_of(chain, *found).owner != parameter.owner) return std::nullopt;
      return found;
    }
    case Owner::several:
      break;
  }
  return std::nullopt;
}

std::optional<Parameter> ambiguous_parameter(const KinematicChain& chain) {
  std::vector<Parameter> all;
  for (int index = 0; index < parameter_count(chain); ++index)
    all.push_back(parameter_of(chain, index));
  for (const Target& target : chain.targets)
    all.emplace_back(Owner::target, target.name, Parameter::kWhole);
  for (const Parameter& parameter : all)
    if (Parameter(to_string(parameter)) != parameter) return parameter;
  return std::nullopt;
}

std::optional<double> parameter_value(const KinematicChain& chain, int index) {
  const Parameter parameter = parameter_of(chain, index);
  const size_t component = parameter.component;
  const auto named = [&](const auto& all) -> const auto& {
    return *std::ranges::find_if(all, [&](const auto& one) { return one.name == parameter.of; });
  };
  const auto of_pose = [&](const Pose& pose) {
    return component < 3 ? std::optional(pose.translation[parameter.component]) : std::nullopt;
  };
  switch (parameter.owner) {
    case Owner::base:
      return of_pose(chain.base);
    case Owner::tool:
      return of_pose(chain.tool);
    case Owner::link: {
      const Link& link = named(chain.links);
      return std::array{link.alpha, link.d, link.theta, link.r, link.beta}[component];
    }
    case Owner::target:
      return named(chain.targets).position[parameter.component];
    case Owner::anchor: {
      const Anchor& anchor = named(chain.anchors);
      return component < 3 ? anchor.position[parameter.component] : anchor.zero;
    }
    case Owner::beam:
    case Owner::board:
    case Owner::camera:
    case Owner::contact: {
      const Contact& contact = named(chain.contacts);
      if (parameter.component >= kFirstIntrinsic)
        return contact.intrinsics[parameter.component - kFirstIntrinsic];
      if (!contact.is_placed) return std::nullopt;
      if (component == kParametersPerPose) return contact.radius;
      return contact.place.rotation.isIdentity(0) ? of_pose(contact.place) : std::nullopt;
    }
    case Owner::coupling: {
      const auto is_it = [&](const Coupling& one) {
        return coupling_name(chain, one) == parameter.of;
      };
      return std::ranges::find_if(chain.couplings, is_it)->coefficient;
    }
    case Owner::arm:
    case Owner::instrument:
    case Owner::several:
      break;
  }
  return std::nullopt;
}

std::optional<double> parameter_change(const KinematicChain& before, const KinematicChain& after,
                                       int index) {
  const Parameter parameter = parameter_of(before, index);
  const int k = parameter.component;
  const bool is_of_contact = index >= first_contact_parameter(before);
  if (is_of_contact && k < kParametersPerPose) {
    const auto named = [&](const KinematicChain& chain) -> const Contact& {
      return *std::ranges::find(chain.contacts, parameter.of, &Contact::name);
    };
    const Contact &from = named(before), &to = named(after);
    if (!from.is_placed || !to.is_placed) return std::nullopt;
    const Eigen::Matrix3d own = from.place.rotation.transpose();
    return k < 3 ? (own * (to.place.translation - from.place.translation))[k]
                 : rotation_log(own * to.place.rotation)[k - 3];
  }
  if ((parameter.owner == Owner::base || parameter.owner == Owner::tool) && k >= 3) {
    const bool of_base = parameter.owner == Owner::base;
    const Pose &from = of_base ? before.base : before.tool, &to = of_base ? after.base : after.tool;
    return rotation_log(to.rotation * from.rotation.transpose())[k - 3];
  }
  const auto from = parameter_value(before, index), to = parameter_value(after, index);
  return from && to ? std::optional(*to - *from) : std::nullopt;
}

void move_parameter(KinematicChain& chain, int index, double delta) {
  if (index < 0 || index >= parameter_count(chain)) throw std::out_of_range("no such parameter");
  if (index < kFirstLinkParameter) return move_pose(chain.base, index, delta);
  const ParameterLayout layout = layout_of(chain);
  if (index < layout.tool) {
    Link& link = chain.links[link_of_parameter(index)];
    double* const members[] = {&link.alpha, &link.d, &link.theta, &link.r, &link.beta};
    *members[place_in_link(index)] += delta;
    return;
  }
  if (index < layout.couplings) return move_pose(chain.tool, index - layout.tool, delta);
  if (layout.is_of_couplings(index)) {
    chain.couplings[index - layout.couplings].coefficient += delta;
    return;
  }
  if (!layout.has_constant(index)) return;
  if (const int k = index - first_contact_parameter(chain); k >= 0)
    return move_contact(chain.contacts[k / kParametersOfContact], k % kParametersOfContact, delta);
  if (const int k = index - first_anchor_parameter(chain); k >= 0) {
    Anchor& anchor = chain.anchors[k / 4];
    (k % 4 < 3 ? anchor.position[k % 4] : anchor.zero) += delta;
    return;
  }
  const int k = index - layout.targets;
  chain.targets[k / 3].position[k % 3] += delta;
}

}  // namespace armtrue
