#pragma once

#include "armtrue/effects/effect.h"
#include "armtrue/kinematics/chain.h"
#include "io/yaml_map.h"

namespace armtrue {

/// What a driver may be, for messages.
inline constexpr const char* kDriverForms =
    "joint-angle <j>[,<k>], gravity-torque <j>, motor-torque <j>, arrival <j>, time, temperature "
    "<where>, payload, force, moment, position (of instrument.scale), or one of them * arrival "
    "<j>, time, temperature <where>, payload or force";

Shape read_shape(YamlMap& map);

/// The inner values of a series.
void read_series(YamlMap series, bool two_drivers, Shape& shape);

/// Parameter, driver and shape with its inner values; other keys are left for the caller.
Effect read_effect_form(YamlMap& map, const KinematicChain& chain);

/// An entry of `effects`, whether of a robot or of what was found. Throws InputError.
Effect read_effect(YamlMap map, const KinematicChain& chain);

}  // namespace armtrue
