#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// The identified arm and the model that its controller runs, with the names of their files.
struct ModelPair {
  const Robot& robot;
  const Robot& controller;
  std::string robot_name, controller_name;
};

// Judgements about the two, as sentences that name what to do; empty if nothing is wrong.

/// An error: they seem exchanged, or have different flanges.
std::string why_not_a_pair(const ModelPair& pair);

/// Where the flange of the program is.
enum class FlangeStated { no, last_link, tool };

/// An error: poses are those of a flange that may be the tool of the controller's model
/// (may_hold_flange_in_tool()), and `stated` does not say it; or `stated` says it of a tool that
/// was identified.
std::string why_flange_is_unclear(const Robot& controller, const std::string& name,
                                  FlangeStated stated, bool tool_is_measured);

/// An error: they are different arms. `nearest`: least distance between their flanges [m].
std::string why_other_arm(const ModelPair& pair, double nearest);

/// Reasons to doubt a prediction, without a full stop. `predicted`: "the commands", "the errors".
std::vector<std::string> doubts_of_models(const ModelPair& pair, const Campaign& visits,
                                          const std::string& predicted);

/// Effects of the robot that belong to the station and move no program.
std::vector<std::string> station_effects(const Robot& robot, bool tool_is_measured);

}  // namespace armtrue
