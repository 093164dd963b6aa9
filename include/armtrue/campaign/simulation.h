#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "armtrue/campaign/campaign.h"
#include "armtrue/campaign/profile_sights.h"
#include "armtrue/campaign/sights.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Axis-aligned box in R_A [m].
struct Box {
  Eigen::Vector3d low, high;
};

enum class VisitOrder {
  random,  ///< every round in a new random order
  sorted,  ///< every round sorted by the first joint: short motions, but a slow drift then looks
           ///< like geometry
  as_given,
};

/// What is read, one kind or several. None is named: distances if the robot has anchors, otherwise
/// points.
struct ReadingKinds {
  bool points = false;      ///< of each target
  bool orientation = true;  ///< beside points, if they are all that is read, without targets
  bool distances = false;   ///< of each target from each anchor
  bool touches = false;     ///< the arm goes on to a contact and touches it
  bool beams = false;       ///< each beam reads the nearest surface in its range
  std::optional<Scanner> profiles{};  ///< this scanner reads profile_at()
  bool images = false;                ///< each corner that a camera has in its image

  int count() const { return points + distances + touches + beams + profiles.has_value() + images; }
  /// Whether more than an instrument reads, which does so anywhere.
  bool needs_sights() const { return touches || beams || profiles || images; }
};

/// The kinds that are meant where none is named, and whether an orientation is read.
ReadingKinds with_usual_kind(ReadingKinds kinds, const KinematicChain& chain);

/// The sights of each kind that is named: of touches those of `touches`.
std::vector<std::vector<Sight>> sights_of(const ReadingKinds& kinds, const KinematicChain& chain,
                                          const std::vector<TouchSight>& touches);

struct SimulationOptions : ReadingKinds {
  int poses = 60;
  int repeats = 1;
  double noise_position = 0;     ///< per axis, or of a length [m]
  double noise_orientation = 0;  ///< per axis [rad]
  double noise_pixel = 0;        ///< of a corner, per axis [px]
  double blunders = 0;           ///< share of readings with an error of 2 to 20 mm, or px
  std::optional<Box> box;        ///< of the measured point; absent: the whole travel of the joints
  VisitOrder order = VisitOrder::random;
  double seconds_per_visit = 20;
  std::uint64_t seed = 1;
};

/// Simulates a measurement of `truth`: configurations within the travel limits of `robot` (and
/// within the box, by the model of `robot`), visited `repeats` times and read with noise. If more
/// than an instrument reads, they are random_sighted_poses() of `robot`, in which each kind that is
/// named reads in turn, and all that can read there do. Of touches the joint angles are those in
/// which `truth` touches, off by the noise. The campaign is as a file has it: before bind_touches()
/// and, of several kinds, before points_to_coordinates(), with a stated standard deviation of each
/// row, that of the options or else of the robot. Throws std::invalid_argument if the box cannot be
/// reached, and as random_sighted_poses().
Campaign simulate(const Robot& robot, const Robot& truth, const SimulationOptions& options);

/// The same at given configurations; ignores `poses` and `box` of the options. Where `truth` does
/// not reach what is to be touched, nothing is touched.
Campaign simulate(const std::vector<PlannedPose>& commanded, const Robot& truth,
                  SimulationOptions options);
Campaign simulate(const std::vector<JointVector>& commanded, const Robot& truth,
                  const SimulationOptions& options);

/// Random configurations, as simulate() commands them.
std::vector<JointVector> random_configurations(const Robot& robot, int count,
                                               const std::optional<Box>& box, std::uint64_t seed);

}  // namespace armtrue
