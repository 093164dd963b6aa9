#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/campaign/turns.h"
#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/move_division.h"
#include "armtrue/compensation/prediction_conditions.h"
#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"
#include "armtrue/io/quantity_column.h"
#include "armtrue/kinematics/joint_names.h"

namespace armtrue {

/// The targets of a program as they were read, with all columns of the file.
struct ProgramFile {
  std::string source;  ///< for messages
  std::string sha256;
  Program program;
  char separator = ',';
  bool has_decimal_commas = false;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> cells;  ///< of each row, as they stand in the file

  std::vector<JointName> joints;       ///< of the robot
  std::vector<QuantityColumn> q;       ///< of each joint
  std::array<QuantityColumn, 6> pose;  ///< x y z a b c
  QuantityColumn turn;
  std::vector<MovedByTurns> moved_by_turns;  ///< `first` is a row of the program
};

/// Reads `pose` with `q1_deg..q6_deg`, or with `x_mm,y_mm,z_mm,a_deg,b_deg,c_deg` and, as a hint of
/// the branch, `q1_deg..q6_deg`; and, if present, `t` and the columns of the context, as
/// read_campaign() does. `joints`: those of the robot. Throws InputError, also for a file that
/// compensate wrote, because its targets are already corrected.
ProgramFile read_program(const std::string& path,
                         const std::vector<JointName>& joints = six_axis_names());

/// The same for the joints of a chain. Joint targets are moved into its travel
/// (move_into_travel()), also in their cells. Joint angles beside poses stay: they may state the
/// turn of an axis.
ProgramFile read_program(const std::string& path, const KinematicChain& chain);

/// Which commands write_commands() writes.
enum class CommandKind { joints, cartesian };

/// The rows of `file` with commands of a kind. They replace the columns of that kind, or follow all
/// columns if there are none. Then come the predictions and the notes. A target that is not
/// corrected, and every other column, stays as it was read. Angles have nine decimals, lengths in
/// mm seven, and corrections two more, the check digits by which read_program() recognises them.
std::string write_commands(const ProgramFile& file, const std::vector<CorrectedTarget>& targets,
                           CommandKind kind);

/// An armtrue-compensation/1 document. `between`: of a robot program whose moves were to be
/// divided.
Document write_compensation(const std::vector<CorrectedTarget>& targets, const Program& program,
                            const std::optional<BetweenPoints>& between,
                            const PredictionConditions& conditions, const Provenance& provenance);

/// The summary for a terminal: the sentence and the worst three targets.
std::string compensation_table(const std::vector<CorrectedTarget>& targets, const Program& program);

}  // namespace armtrue
