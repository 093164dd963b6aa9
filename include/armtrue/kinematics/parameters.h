#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Every parameter of the geometric model has one index, in the order of the Jacobian's columns:
///     0..5    base   x y z rx ry rz
///     6..40   links  alpha d theta r beta, link by link
///     41..46  tool   x y z rx ry rz
///     47      instrument.scale (relative error of the instrument's lengths)
///     48..50  instrument.range .azimuth .elevation (errors along and across its line of sight)
///     51..    targets, x y z each
///     then    anchors, x y z zero each
/// The parameters of base and tool change the pose in the axes of its parent frame:
/// t <- t + (x, y, z) and R <- exp([r]x) R with r = (rx, ry, rz), about the pose's own origin.
inline constexpr int kBaseParameters = 0;
inline constexpr int kLinkParameters = 6;
inline constexpr int kToolParameters = 41;
inline constexpr int kGeometricParameters = 47;
inline constexpr int kInstrumentScale = 47;
inline constexpr int kInstrumentRange = 48;
inline constexpr int kInstrumentElevation = 50;
inline constexpr int kTargetParameters = 51;

/// Whether a parameter belongs to the instrument. It is 0 but for effects.
constexpr bool is_instrument_parameter(int index) {
  return index >= kInstrumentScale && index < kTargetParameters;
}

/// Names of the parameters of base and tool in files.
inline constexpr std::array<const char*, 6> kTwistNames{"x", "y", "z", "rx", "ry", "rz"};

enum class LinkParameter { alpha, d, theta, r, beta };

constexpr int link_parameter(int link, LinkParameter which) {
  return kLinkParameters + 5 * link + static_cast<int>(which);
}

/// Returns whether a parameter is the zero offset (theta) of a driven joint. The link is
/// (index - kLinkParameters) / 5.
constexpr bool is_zero_offset(int index) {
  return index >= kLinkParameters && index < kLinkParameters + 5 * kJoints &&
         (index - kLinkParameters) % 5 == static_cast<int>(LinkParameter::theta);
}

/// Index of the first anchor's x.
inline int first_anchor_parameter(const KinematicChain& chain) {
  return kTargetParameters + 3 * static_cast<int>(chain.targets.size());
}

/// Number of parameters of a chain, its targets and anchors included.
inline int parameter_count(const KinematicChain& chain) {
  return first_anchor_parameter(chain) + 4 * static_cast<int>(chain.anchors.size());
}

/// SI unit of a parameter.
enum class ParameterUnit { metre, radian, one };
ParameterUnit parameter_unit(int index);

/// Unit in which values of a parameter are displayed: mm, mrad, or ppm if it has no unit.
struct DisplayUnit {
  double si;  ///< one display unit in SI units
  std::string name;
};
DisplayUnit display_unit(ParameterUnit unit);

/// `A1.alpha`, `base.x`, `tool.rz`, `instrument.scale`, `target 2.x`, `anchor 1.zero`.
std::string parameter_name(const KinematicChain& chain, int index);

/// The inverse of parameter_name; nothing if the chain has no such parameter.
std::optional<int> find_parameter(const KinematicChain& chain, std::string_view name);

/// Adds `delta` (m or rad) to one parameter. Those of the instrument are no property of the chain:
/// the chain does not change.
void move_parameter(KinematicChain& chain, int index, double delta);

}  // namespace armtrue
