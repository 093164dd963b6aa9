#pragma once

#include <string>
#include <vector>

#include "armtrue/effects/context.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// A turn of 1 mrad counts as 0.1 mm [m]: as far as the tip of a tool of this length moves.
inline constexpr double kLengthOfTurn = 0.1;

/// Distances between two models of one arm at the measured frame, over some visits [m].
struct ModelDistance {
  double mean = 0, max = 0;
};

/// The visits over which constants stand for an arm.
struct ConstantsVisits {
  std::vector<Context> contexts;
  std::vector<std::string> temperature_names;  ///< of their temperatures
};

/// Visits that fill the travel evenly, each joint arriving from either side; all else as in
/// `conditions`.
ConstantsVisits visits_of_travel(const Robot& robot, const Context& conditions);

/// The same at these encoder values, in their order.
ConstantsVisits visits_at(const Robot& robot, const std::vector<JointVector>& q,
                          const Context& conditions);

/// The arm whose constants stand for its effects: without those of the station, of the tool that
/// carried the reflectors, and of measured motor torques, which are not known at other poses.
Robot arm_of_constants(const Robot& robot);
/// Sentences that name the effects which it lacks.
std::vector<std::string> not_in_constants(const Robot& robot);

/// Payload, time and temperature of visits, as far as effects of the robot follow them, each behind
/// a comma.
std::string conditions_in_words(const Robot& robot, const Context& conditions);

/// A file or a controller without effects holds constants alone. The best constants are not those
/// that were identified beside effects.
struct ConstantsFit {
  KinematicChain chain;
  ModelDistance before;  ///< with the constants from which the fit began
  ModelDistance after;   ///< with those of `chain`
};

/// The constants of the links with which a chain comes nearest to `arm`, effects and all: least
/// squares of the pose of the measured frame over the visits, a turn counted by kLengthOfTurn.
/// `from` has the links of `arm`; base and tool stay those of `arm`, because they are places of the
/// measurement. `free`: parameters (see parameters.h) that may change. What these visits do not
/// show stays as it is in `from`. Throws std::invalid_argument as RobotModel does, and for a chain
/// of other links.
ConstantsFit fit_constants(const Robot& arm, const KinematicChain& from,
                           const std::vector<int>& free, const ConstantsVisits& visits);

/// All parameters of the links.
std::vector<int> link_parameters(const KinematicChain& chain);
/// The zero offsets of the driven joints.
std::vector<int> zero_offsets(const KinematicChain& chain);

}  // namespace armtrue
