#pragma once

#include "armtrue/effects/effect.h"
#include "armtrue/kinematics/chain.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// The forms of a driver, for messages.
inline constexpr const char* kDriverForms =
    "joint-angle <j>[,<k>], gravity-torque <j>, motor-torque <j>, arrival <j>, time, temperature "
    "<where>, payload, force, moment, position (of instrument.scale), or one of them * arrival "
    "<j>, time, temperature <where>, payload or force";

Shape read_shape(YamlMap& map);

/// Reads basis, count and ranges of a series.
void read_series(YamlMap series, bool two_drivers, Shape& shape);

/// Reads parameter, driver and shape; the caller reads the other keys.
Effect read_effect_form(YamlMap& map, const KinematicChain& chain);

/// Reads an entry of `effects` of a robot, ranking or loop document. Throws InputError.
Effect read_effect(YamlMap map, const KinematicChain& chain);

}  // namespace armtrue
