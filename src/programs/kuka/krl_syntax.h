#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "armtrue/programs/program_text.h"
#include "armtrue/programs/robot_program.h"
#include "programs/kuka/krl_flow.h"
#include "programs/kuka/krl_frame.h"
#include "programs/kuka/krl_steps.h"
#include "programs/statement.h"

// What a KRL program says about its moves, and where in the text it says so.

namespace armtrue {

enum class KrlTargetKind {
  frame,       ///< a position, written out or by a name with one known value
  axes,        ///< joint angles
  undeclared,  ///< a name that no text gives a value
  home,        ///< of these, one of the home positions of $config.dat
  reassigned,  ///< a name that is given several values, or one in a way that is not understood
  here,        ///< where the arm stands: $POS_ACT, $AXIS_ACT
  expression,  ///< anything else
};

/// The point that a move goes to.
struct KrlTarget {
  KrlTargetKind kind = KrlTargetKind::expression;
  size_t begin = 0, end = 0;  ///< in the .src
  int frame = -1;       ///< in KrlSyntax::frames: the target itself or the declaration of its name
  int axes = -1;        ///< in KrlSyntax::axes, of joint angles
  bool shared = false;  ///< the name is declared, and not only moves of this program use it
  bool is_global = false;  ///< the name is declared so
  /// Displaced by constant frames, XP1:{Z 50,..}, or relative. Then `frame` is what comes out, or
  /// of a relative move by how much it moves, in the .src and without written numbers.
  bool is_expression = false;
  int starts_from = -1;        ///< in KrlSyntax::frames: the named point of a product; -1: none
  std::string before, behind;  ///< what stands beside the point where it is written out
  int only_external = -1;      ///< in KrlSyntax::frames: the target states E1 to E6 alone
};

/// LIN_REL and its like: the frame that they count in.
enum class KrlRelative { none, base, tool };

enum class KrlMotion { point_to_point, line, circle, spline_point };

struct KrlMove {
  int line = 0;
  // Places in the .src:
  size_t line_begin = 0;
  size_t begin = 0, end = 0;  ///< of the statement, without its comment
  size_t keyword_end = 0;
  KrlMotion motion = KrlMotion::line;
  bool spline = false;  ///< SPTP, SLIN, SCIRC
  KrlRelative relative = KrlRelative::none;
  bool circle_angle = false;              ///< CIRC with an angle: it does not end at its target
  std::optional<Statement> spline_block;  ///< it stands in: the line SPLINE or PTP_SPLINE
  bool in_loop = false;
  bool in_inline_form = false;
  bool after_trigger = false;  ///< a TRIGGER refers to this move
  KrlTarget target;
  KrlTarget auxiliary;  ///< the point on the way of a circular move
  size_t set_ups = 0;   ///< statements in KrlSyntax::set_ups before this move
};

/// A statement of the .src that may set $BASE, $TOOL or $IPO_MODE, begins a DEF, begins or ends a
/// loop, or calls a subprogram.
struct KrlSetUp {
  int line = 0;
  size_t begin = 0, end = 0;  ///< in the .src, without its comment
  std::string word;  ///< that it begins with: $BASE, BAS, FDAT_ACT, DEF, LOOP, the name it calls
};

/// A frame of the controller, BASE_DATA[3] or TOOL_DATA[1], that the .src sets.
struct KrlSetFrame {
  std::vector<int> values;  ///< in KrlSyntax::frames: what it gives it, NAME={..}, all six numbers
  int before = -1;          ///< in KrlSyntax::frames: as others declare it; -1: not known
  std::vector<size_t> lost_at;  ///< in the .src: calls of others that may set it
};

class KrlVariables;

struct KrlSyntax {
  std::vector<KrlFrame> frames;
  std::vector<KrlFrame> axes;  ///< joint angles
  std::vector<KrlMove> moves;
  std::vector<KrlNode> nodes;  ///< in the order of the text; a move once
  std::vector<KrlSetUp> set_ups;
  KrlSteps steps;  ///< of the .src
  std::unordered_map<std::string, KrlFdat> fdats;  ///< that nothing may change
  std::vector<KrlSetUp> zones;  ///< statements of the .src that set $APO or LDAT_ACT
  std::unordered_map<std::string, double> ldats;     ///< APO_DIST by name [mm], likewise
  std::unordered_map<std::string, int> frame_names;  ///< with one value, that nothing may change
  std::unordered_map<std::string, KrlSetFrame> set_frames;  ///< if nothing else changes them
  std::unordered_set<std::string> changed;        ///< variables that may have several values
  std::shared_ptr<const KrlVariables> variables;  ///< never null; the values of these, if known
  int robot_root = -1;                  ///< in `frames`: $ROBROOT of $machine.dat; -1: not given
  bool circles_turn_with_path = false;  ///< somewhere $CIRC_TYPE (or CIRC_TYPE of LDAT) is #PATH
  bool keeps_orientation = false;       ///< somewhere $ORI_TYPE (or ORI_TYP of LDAT) is #CONSTANT
  int absolute_accuracy_line = 0;       ///< the first line that uses $ABS_ACCUR; 0: none does
  int absolute_accuracy_text = 0;       ///< in which it stands
  std::string arm_name;                 ///< $TRAFONAME or $MODEL_NAME; empty if no text states one
  int arm_name_text = 0, arm_name_line = 0;
};

/// `texts`: the .src and, if there is one, its .dat, which are `own`; behind them data lists of
/// others. `shared`: see ProgramNeighbours; null: not known.
KrlSyntax parse_krl(const std::vector<ProgramText>& texts, size_t own,
                    const ProgramNeighbours::SharedVariables* shared = nullptr);
/// The same of a program.
KrlSyntax parse_krl(const RobotProgram& program);

}  // namespace armtrue
