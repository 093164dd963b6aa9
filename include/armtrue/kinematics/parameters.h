#pragma once

#include <array>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Every parameter of the geometric model has one index, in the order of the Jacobian's columns.
/// With n links:
///     0..5       base   x y z rx ry rz
///     6..5+5n    links  alpha d theta r beta, link by link
///     6+5n..     tool   x y z rx ry rz
///     then       the coefficients of the couplings
///     then       arm.scale (relative change of all lengths of the arm at once)
///     then       instrument.scale (relative error of the instrument's lengths)
///     then       instrument.range .azimuth .elevation (errors along and across its line of sight)
///     then       targets, x y z each
///     then       anchors, x y z zero each
///     then       contacts, x y z rx ry rz radius, then the numbers of a camera, fx fy cx cy k1 k2
///                p1 p2 k3 k4, each; each kind uses some (parameters_of_contact)
/// The parameters of base and tool change the pose in the axes of its parent frame:
/// t <- t + (x, y, z) and R <- exp([r]x) R with r = (rx, ry, rz), about the pose's own origin.
/// Those of a contact change its place in its own axes: t <- t + R (x, y, z), R <- R exp([r]x).
inline constexpr int kFirstBaseParameter = 0;
inline constexpr int kParametersPerPose = 6;  ///< of base and tool
inline constexpr int kFirstLinkParameter = kFirstBaseParameter + kParametersPerPose;
inline constexpr int kParametersPerLink = 5;
inline constexpr int kMaxGeometricParameters =
    2 * kParametersPerPose + kParametersPerLink * kMaxLinks + kMaxCouplings;

/// Index of the first parameter of each kind for a chain of so many links and couplings.
struct ParameterLayout {
  int tool, couplings, geometric, arm_scale;
  int instrument_scale, instrument_range, instrument_elevation, targets;

  explicit constexpr ParameterLayout(int links, int coupling_count = 0)
      : tool(kFirstLinkParameter + kParametersPerLink * links),
        couplings(tool + kParametersPerPose),
        geometric(couplings + coupling_count),  // number of the columns of the Jacobian
        arm_scale(geometric),
        instrument_scale(arm_scale + 1),
        instrument_range(instrument_scale + 1),
        instrument_elevation(instrument_range + 2),
        targets(instrument_elevation + 1) {}

  /// Whether the constant of a parameter may differ from 0. Only effects change the others: what
  /// belongs to the instrument, and arm.scale, whose constant is that of every length.
  constexpr bool has_constant(int index) const { return index < geometric || index >= targets; }
  /// Whether a parameter belongs to the instrument.
  constexpr bool is_of_instrument(int index) const {
    return index >= instrument_scale && index < targets;
  }
  constexpr bool is_of_links(int index) const {
    return index >= kFirstLinkParameter && index < tool;
  }
  constexpr bool is_of_tool(int index) const { return index >= tool && index < couplings; }
  constexpr bool is_of_couplings(int index) const {
    return index >= couplings && index < geometric;
  }
};

inline ParameterLayout layout_of(const KinematicChain& chain) {
  return ParameterLayout(link_count(chain), static_cast<int>(chain.couplings.size()));
}

/// The link that a parameter of the links belongs to.
constexpr int link_of_parameter(int index) {
  return (index - kFirstLinkParameter) / kParametersPerLink;
}

/// Names of the parameters of base and tool in files.
inline constexpr std::array<const char*, 6> kTwistNames{"x", "y", "z", "rx", "ry", "rz"};

/// The parameters of a link, in the order of the layout.
enum class LinkParameter { alpha, d, theta, r, beta };

constexpr int link_parameter(int link, LinkParameter which) {
  return kFirstLinkParameter + kParametersPerLink * link + static_cast<int>(which);
}
/// Number of a parameter within its link: 0 is alpha, 4 is beta.
constexpr int place_in_link(int index) {
  return (index - kFirstLinkParameter) % kParametersPerLink;
}
/// The kind of a parameter of the links.
constexpr LinkParameter kind_of_parameter(int index) {
  return static_cast<LinkParameter>(place_in_link(index));
}

/// The zero offset of a joint, to which the encoder value is added: theta of a revolute joint, r of
/// a prismatic one. `joint` is 0-based.
int zero_offset(const KinematicChain& chain, int joint);

/// Returns whether a parameter is the zero offset of a driven joint; its link is
/// link_of_parameter(index).
bool is_zero_offset(const KinematicChain& chain, int index);

/// The constant of a link to which its joint adds [rad or m]: of a driven one its zero offset.
inline double& zero_of(Link& link) { return is_prismatic(link) ? link.r : link.theta; }
inline double zero_of(const Link& link) { return is_prismatic(link) ? link.r : link.theta; }

/// The index of that constant.
inline int zero_of_link(const KinematicChain& chain, int link) {
  const bool slides = is_prismatic(chain.links[link]);
  return link_parameter(link, slides ? LinkParameter::r : LinkParameter::theta);
}

/// Index of the first anchor's x.
inline int first_anchor_parameter(const KinematicChain& chain) {
  return layout_of(chain).targets + 3 * target_count(chain);
}

/// Number of fx among the parameters of a contact; x y z rx ry rz radius come before it.
inline constexpr int kFirstIntrinsic = 7;
inline constexpr int kParametersOfContact = kFirstIntrinsic + kIntrinsics;
/// Index of the first contact's x.
inline int first_contact_parameter(const KinematicChain& chain) {
  return first_anchor_parameter(chain) + 4 * anchor_count(chain);
}

/// Number of parameters of a chain, its targets, anchors and contacts included.
inline int parameter_count(const KinematicChain& chain) {
  return first_contact_parameter(chain) + kParametersOfContact * contact_count(chain);
}

/// The parameters of a contact that change its readings, as numbers from its first: point x y z;
/// plane z rx ry; sphere x y z radius; board x y z rx ry rz; camera the same, with the intrinsic
/// parameters that its lens has; beam x y z rx ry, where the origin, at which it would read 0,
/// holds the zero of the sensor; artefact those of x y z rx ry rz that its parts show and, unless
/// it is known, the radius of the ball that touches its faces and balls.
std::vector<int> parameters_of_contact(const Contact& contact);

/// The name of a coupling as a parameter: `A5.follows.A2`.
std::string coupling_name(const KinematicChain& chain, const Coupling& coupling);

/// The unit of a coefficient in files, in SI: rad/rad, mm/rad, rad/mm or mm/mm.
double coefficient_unit(const KinematicChain& chain, const Coupling& coupling);

/// SI unit of a parameter; of a coefficient `one`, also where it is m/rad or rad/m.
enum class ParameterUnit { metre, radian, one, pixel };
ParameterUnit parameter_unit(const KinematicChain& chain, int index);
/// Unit of the encoder value of a joint (0-based).
inline ParameterUnit joint_unit(const KinematicChain& chain, int joint) {
  return is_prismatic(joint_link(chain, joint)) ? ParameterUnit::metre : ParameterUnit::radian;
}

/// Unit in which values of a parameter are displayed: mm, mrad, px, or ppm if it has no unit.
struct DisplayUnit {
  double si;  ///< one display unit in SI units
  std::string name;
};
DisplayUnit display_unit(ParameterUnit unit);

/// What a parameter belongs to. `several`: of a family whose effects have different owners.
/// `beam`, `board` and `camera`: contacts of these kinds.
enum class Owner {
  link,
  anchor,
  arm,
  base,
  beam,
  board,
  camera,
  contact,
  coupling,
  instrument,
  several,
  target,
  tool
};

/// A parameter as a value: whose it is, and which of the parameters of its owner, or all of them.
/// Its text stands in files alone: `A1.alpha`, `base.x`, `tool.rz`, `arm.scale`,
/// `instrument.scale`, `target 2.x`, `anchor 1.zero`, `contact table.z`, `beam laser.rx`, `camera
/// left.fx`, `A5.follows.A2` for the coefficient of a coupling; `base`, `tool`, `target 2` for all
/// of them and `instrument.point` for the three coordinates of every reading. The owner has a name
/// and no number, because a catalogue names parameters of links that not every chain has.
struct Parameter {
  static constexpr int kWhole = -1;

  Owner owner = Owner::several;
  /// Name of the link, target, anchor, contact, coupling (`A5.follows.A2`) or family; else empty.
  std::string of;
  int component = kWhole;  ///< in the order of the layout, from 0 for each owner
  /// In a catalogue: that of every link, target, anchor or contact. `of` is then empty.
  bool of_each = false;

  Parameter() = default;
  Parameter(Owner owner_of_it, std::string name, int which)
      : owner(owner_of_it), of(std::move(name)), component(which) {}
  /// Reads the text of a file; the texts of links end in the name of one of their parameters, and
  /// any other text names a family.
  Parameter(std::string_view text);
  Parameter(const std::string& text) : Parameter(std::string_view(text)) {}
  Parameter(const char* text) : Parameter(std::string_view(text)) {}

  friend bool operator==(const Parameter&, const Parameter&) = default;
};

/// The text of files.
std::string to_string(const Parameter& parameter);
std::ostream& operator<<(std::ostream& stream, const Parameter& parameter);

/// As a catalogue writes it: `alpha`, `d`, `theta`, `r` and `beta` of each link, `target` and
/// `anchor.zero` (`.x` ...) of each of these, or one parameter or group.
Parameter parameter_of_catalogue(std::string_view text);

/// Whether it is this parameter of a link.
inline bool is_link_parameter(const Parameter& parameter, LinkParameter which) {
  return parameter.owner == Owner::link && parameter.component == static_cast<int>(which);
}

/// Whether it is `arm.scale`: all lengths of the arm in proportion, see lengths_of_arm().
inline bool is_arm_scale(const Parameter& parameter) { return parameter.owner == Owner::arm; }

/// The components of the instrument, from 0.
enum class InstrumentParameter { scale, range, azimuth, elevation };
inline bool is_instrument_parameter(const Parameter& parameter, InstrumentParameter which) {
  return parameter.owner == Owner::instrument && parameter.component == static_cast<int>(which);
}

/// The parameter with an index, and its text.
Parameter parameter_of(const KinematicChain& chain, int index);
std::string parameter_name(const KinematicChain& chain, int index);

/// The index of a single parameter, the inverse of parameter_of; nothing if the chain has no such
/// parameter.
std::optional<int> find_parameter(const KinematicChain& chain, const Parameter& parameter);

/// A parameter or group whose text means another one too, such as target `1.x` beside the x of
/// target `1`; nothing if every text means one.
std::optional<Parameter> ambiguous_parameter(const KinematicChain& chain);

/// The value of a parameter [m, rad or px]. Nothing for a parameter that has no value of its own: a
/// rotation of base, tool or contact, a coordinate of a contact that is turned or has no place, and
/// what has no constant.
std::optional<double> parameter_value(const KinematicChain& chain, int index);

/// The delta by which move_parameter() moves a parameter of `before` to that of `after`, a chain of
/// the same kind [m, rad or px]; the three rotations of a pose move together. Nothing where a
/// contact has no place, and of what has no constant.
std::optional<double> parameter_change(const KinematicChain& before, const KinematicChain& after,
                                       int index);

/// Adds `delta` [m, rad or px] to one parameter. One that has no constant leaves the chain as it
/// is. Throws std::out_of_range for an index that the chain has not.
void move_parameter(KinematicChain& chain, int index, double delta);

}  // namespace armtrue
