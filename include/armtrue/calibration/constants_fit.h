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

/// The visits over which constants replace the effects of an arm.
struct ConstantsVisits {
  std::vector<Context> contexts;
  std::vector<std::string> temperature_names;  ///< of their temperatures
};

/// Visits that fill the travel evenly; each joint arrives from both sides. All else is as in
/// `conditions`.
ConstantsVisits visits_of_travel(const Robot& robot, const Context& conditions);

/// The same at these encoder values, in their order.
ConstantsVisits visits_at(const Robot& robot, const std::vector<JointVector>& q,
                          const Context& conditions);

/// The arm that constants are to replace: without the effects of the station, of the tool that
/// carried the reflectors, and of motor torques, which other poses do not have.
Robot arm_of_constants(const Robot& robot);
/// Sentences that name the effects that arm_of_constants() leaves out.
std::vector<std::string> not_in_constants(const Robot& robot);

/// Payload, time and temperature of visits, as far as effects of the robot follow them, each after
/// a comma.
std::string conditions_in_words(const Robot& robot, const Context& conditions);

/// A file or a controller without effects holds constants alone. The best constants are not those
/// that were identified beside effects.
struct ConstantsFit {
  KinematicChain chain;
  ModelDistance before;  ///< with the constants from which the fit began
  ModelDistance after;   ///< with those of `chain`
};

/// The constants of the links with which a chain comes nearest to `arm` with its effects: least
/// squares of the pose of the measured frame over the visits, a rotation times kLengthOfTurn.
/// `from` has the links of `arm`; base and tool stay those of `arm`, because they are places of the
/// measurement. `free`: parameters (see parameters.h) that may change. Parameters that these visits
/// do not show stay as in `from`. Throws std::invalid_argument as RobotModel does, and for a chain
/// of other links.
ConstantsFit fit_constants(const Robot& arm, const KinematicChain& from,
                           const std::vector<int>& free, const ConstantsVisits& visits);

/// All parameters of the links.
std::vector<int> link_parameters(const KinematicChain& chain);
/// The zero offsets of the driven joints.
std::vector<int> zero_offsets(const KinematicChain& chain);

}  // namespace armtrue
