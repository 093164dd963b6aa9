#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "armtrue/campaign/campaign.h"
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
};

struct SimulationOptions {
  int poses = 60;
  int repeats = 1;
  double noise_position = 0;     ///< per axis [m]
  double noise_orientation = 0;  ///< per axis [rad]
  double noise_pixel = 0;        ///< of a corner, per axis [px]
  double blunders = 0;           ///< share of readings with an error of 2 to 20 mm
  bool orientation = true;
  bool images = false;     ///< readings are the pixels of what the cameras see of the boards
  bool beams = false;      ///< readings are those of the beams
  std::optional<Box> box;  ///< of the measured point [m]; absent: the whole travel of the joints
  VisitOrder order = VisitOrder::random;
  double seconds_per_visit = 20;
  std::uint64_t seed = 1;
};

/// Simulates a measurement of `truth`: configurations within the travel limits of `robot` (and
/// within the box, by the model of `robot`), visited `repeats` times and read with noise. With
/// targets in `truth` every visit reads each of them; with anchors, their distances from each. Of
/// images or beams, the configurations are random_sighted_poses() of `robot`. Every visit then
/// reads each corner that a camera of `truth` has in its image, the campaign as before
/// bind_touches(), and blunders are of 2 to 20 px; or it reads the nearest surface of `truth` with
/// each beam that has one in its range. Throws std::invalid_argument if the box cannot be reached.
Campaign simulate(const Robot& robot, const Robot& truth, const SimulationOptions& options);

/// The same at given configurations; ignores `poses` and `box` of the options.
Campaign simulate(const std::vector<JointVector>& commanded, const Robot& truth,
                  const SimulationOptions& options);

/// Random configurations, as simulate() commands them.
std::vector<JointVector> random_configurations(const Robot& robot, int count,
                                               const std::optional<Box>& box, std::uint64_t seed);

}  // namespace armtrue
