#pragma once

#include <string>
#include <utility>

#include "armtrue/effects/effect.h"
#include "armtrue/kinematics/chain.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// The forms of a driver, for messages.
inline constexpr const char* kDriverForms =
    "joint-angle <j>[,<k>], gravity-torque <j>, motor-torque <j>, tool-weight <j>, arrival <j>, "
    "stroke <j>, time, temperature <where>, payload, force, moment, range, azimuth, elevation, "
    "incidence, session (of a step), gravity-direction (of the tool), position (of the instrument), place (of a "
    "polynomial), or one of them * arrival <j>, time, temperature <where>, payload or force, or "
    "time * gravity-torque <j> or tool-weight <j>";

/// Ending of the keys `at` and `tau` of an effect with this driver, and their unit in SI.
std::pair<std::string, double> inner_unit(const Driver& driver, const KinematicChain& chain);

/// Key of the time or temperature from which an effect counts; null if its shape counts from zero.
const char* key_of_begin(const Effect& effect);

Shape read_shape(YamlMap& map);

/// Reads basis, count and ranges of a series.
void read_series(YamlMap series, bool two_drivers, Shape& shape);

/// Reads parameter, driver and shape; the caller reads the other keys.
Effect read_effect_form(YamlMap& map, const KinematicChain& chain);

/// Reads an entry of `effects` of a robot, ranking or loop document. Throws InputError.
Effect read_effect(YamlMap map, const KinematicChain& chain);

}  // namespace armtrue
