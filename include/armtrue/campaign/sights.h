#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/profile_sights.h"
#include "armtrue/campaign/touch_sights.h"
#include "armtrue/effects/robot.h"
#include "armtrue/statistics/random.h"

namespace armtrue {

/// Something that is read in some configurations, and how the arm comes to read it.
struct Sight {
  std::string contact{}, target{};  ///< of PlannedPose
  std::function<std::optional<JointVector>(const JointVector& start, Random&)> go_to;
  std::function<bool(const JointVector& q, const Pose& a_from_measured)> is_read;
  std::string hardly_read;  ///< what is wrong if hardly any configuration reads it
  bool is_needed = true;    ///< false: it is left out then, if others of its kind are read
};

/// What an instrument beside the arm reads: any configuration.
std::vector<Sight> sights_of_instrument();

/// Each of views_of(): a board is seen whole, a third to nine tenths as large as the image,
/// anywhere in it, tilted by up to 35 deg and turned in any direction. The chain outlives the
/// sights, here and below. They throw std::invalid_argument as views_of(), beam_sights_of() and
/// scanned_contacts().
std::vector<Sight> sights_of_boards(const KinematicChain& chain);

/// Each of beam_sights_of().
std::vector<Sight> sights_of_beams(const KinematicChain& chain);

/// Each of scanned_contacts(), of which three points and more are read.
std::vector<Sight> sights_of_scanner(const KinematicChain& chain, const Scanner& scanner);

/// Each of the touches, in which the chain touches exactly.
std::vector<Sight> sights_of_touches(const KinematicChain& chain,
                                     const std::vector<TouchSight>& touches);

/// Random configurations within the travel limits: each kind in turn and, of each kind, each of its
/// sights. Throws std::invalid_argument if hardly any configuration reads one that is needed, or
/// any of a kind.
std::vector<PlannedPose> random_sighted_poses(const KinematicChain& chain,
                                              std::vector<std::vector<Sight>> kinds, int count,
                                              std::uint64_t seed);

}  // namespace armtrue
