#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/model_pair.h"
#include "armtrue/compensation/prediction_conditions.h"
#include "armtrue/effects/robot.h"
#include "command_line.h"

namespace armtrue::app {

inline constexpr const char* kPoseForm = "x,y,z,a,b,c in mm and deg";

/// x, y, z [mm], a, b, c [deg]; no numbers are no displacement.
Pose pose_from_numbers(const std::vector<double>& n);

/// What compensate and map-errors ask for: an identified arm, the model of its controller, the
/// program's frames, and what effects follow where no column says it.
struct ProgramArguments {
  std::string robot, controller, session;
  std::vector<double> base, tool, start;
  std::string flange;
  bool tool_is_measured = false;
  std::optional<double> payload_kg, time_s, temperature_c;
};

/// --robot and --controller.
void add_models(Command& command, ProgramArguments& arguments);
/// The robot of --robot in its session, and the model of --controller. `nominal` there becomes the
/// file that --robot was made from, by the path that it states or beside it. Throws InputError if
/// that is not known, not found, or has changed since.
struct Models {
  Robot robot, controller;
};
Models read_models(Command& command, ProgramArguments& arguments);
/// --tool, --tool-is-measured, --flange and --base.
void add_frames(Command& command, ProgramArguments& arguments);
/// Warns of a --tool or --base that looks as if it were in m, and of a --start in rad.
void warn_of_units(Command& command, const Robot& controller, const ProgramArguments& arguments);
/// --session, --payload-kg, --t-s and --temp-c.
void add_conditions(Command& command, ProgramArguments& arguments);

/// Base, flange, tool and start.
CompensationOptions program_options(const ProgramArguments& arguments, const Robot& controller);

/// Fills the columns that the command line states. Throws InputError if the file has one of them.
void fill_conditions(Campaign& visits, const ProgramArguments& arguments,
                     const std::vector<const Robot*>& robots);

/// Whether the rows are those of a table, which may have columns for the conditions.
enum class HasColumns { no, yes };

/// Throws InputError if an effect of the robot that moves the program follows time or a
/// temperature, and neither a column nor the command line states it.
void require_conditions(const Campaign& visits, const Robot& robot,
                        const ProgramArguments& arguments, HasColumns has_columns);

/// The robot of --session.
Robot robot_of_session(const Robot& robot, const ProgramArguments& arguments);

/// The two models with the names of their files.
ModelPair pair_of(const Robot& robot, const Robot& controller, const ProgramArguments& arguments);

/// Throws InputError if --robot and --controller seem exchanged.
void refuse_other_files(const Robot& robot, const Robot& controller,
                        const ProgramArguments& arguments);

/// Throws InputError if poses are those of a flange and --controller may have it in its tool, but
/// --flange does not say so, or if --flange says so of a tool that was identified.
void require_flange(const Robot& controller, const ProgramArguments& arguments);

/// The same if they are different arms; `nearest`: least distance between their flanges [m].
void refuse_other_arm(double nearest, const ModelPair& pair);

/// Tools or frames that a robot program names itself.
struct StatedFrames {
  std::vector<std::string> names;
  bool everywhere = false;  ///< every target has one
  bool in_base = false;     ///< they stand in the base of the other poses
};

/// In which tool and frame the targets are taken to be, as a sentence.
std::string assumed_frames(const Robot& controller, const ProgramArguments& arguments,
                           const StatedFrames& tools = {}, const StatedFrames& frames = {});

/// Warns of what puts a prediction in doubt, and states it among its conditions.
void warn_of_doubts(Command& command, const std::vector<std::string>& doubts,
                    PredictionConditions& conditions);

/// Warns of effects that are not applied.
void warn_of_station(Command& command, const std::vector<std::string>& not_applied);

}  // namespace armtrue::app
