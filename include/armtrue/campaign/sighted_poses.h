#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"

namespace armtrue {

/// Sensors that read without an instrument.
enum class Sensor {
  camera,  ///< sees boards, see views.h
  beam,    ///< reads how far planes are, see beam_sights.h
};

/// A configuration in which a sensor reads.
struct SightedPose {
  JointVector q;     ///< [rad or m]
  std::string name;  ///< of what a beam reads, text of its BeamName; empty for a board, which is
                     ///< seen whole
};

/// Random configurations within the travel limits in which a sensor reads: each of views_of() or
/// beam_sights_of() in turn. A board is a third to nine tenths as large as the image, anywhere in
/// it, tilted by up to 35 deg and turned in any direction. Throws std::invalid_argument as those
/// functions do, and if hardly any configuration shows one of them so.
std::vector<SightedPose> random_sighted_poses(const KinematicChain& chain, Sensor sensor, int count,
                                              std::uint64_t seed);

}  // namespace armtrue
