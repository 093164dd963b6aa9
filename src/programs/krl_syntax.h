#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "armtrue/programs/krl.h"

// What a KRL program says about its moves, and where in the text it says so.

namespace armtrue {

/// X, Y, Z [m], A, B, C [rad], E1..E6 [as written]; NaN: not given.
inline constexpr int kKrlComponents = 12;
using KrlValues = Eigen::Matrix<double, kKrlComponents, 1>;

/// An aggregate {X 1.0,Y 2.0,...} in one of the two texts.
struct KrlFrame {
  bool in_dat = false;
  size_t begin = 0, end = 0;  ///< from the brace to behind the other
  size_t entries = 0;         ///< of the first entry, behind `{` or `{E6POS:`
  struct Number {
    unsigned begin = 0, end = 0;  ///< from `begin` of the frame; empty: not given
  };
  std::array<Number, kKrlComponents> numbers;
  KrlValues values;
};

enum class KrlTargetKind { frame, axes, undeclared, reassigned, expression };

/// What a move goes to. `frame` is that of the target itself or of the declaration of its name.
struct KrlTarget {
  KrlTargetKind kind = KrlTargetKind::expression;
  size_t begin = 0, end = 0;  ///< in the .src
  int frame = -1;
  bool declared = false;  ///< by name
  bool shared = false;    ///< the declaration serves others than the moves of this program
};

enum class KrlMotion { point_to_point, line, circle, spline_point };

struct KrlMove {
  int line = 0;
  size_t line_begin = 0;      ///< of the line, in the .src
  size_t begin = 0, end = 0;  ///< of the statement, without comment
  size_t keyword_end = 0;
  KrlMotion motion = KrlMotion::line;
  bool spline = false;    ///< SPTP, SLIN, SCIRC
  bool relative = false;  ///< LIN_REL and its like; has no target here
  bool circle_angle = false;
  bool in_spline_block = false;
  bool in_loop = false;
  bool in_inline_form = false;
  bool after_trigger = false;  ///< a TRIGGER refers to this move
  bool start_unknown = false;  ///< the first one of a DEF or in another $BASE
  int base = 0;                ///< equal where the same assignment to $BASE holds
  KrlTarget target;
  KrlTarget auxiliary;  ///< of a circle
};

struct KrlSyntax {
  std::vector<KrlFrame> frames;
  std::vector<KrlMove> moves;
  int absolute_accuracy_line = 0;  ///< where $ABS_ACCUR is used, 0: nowhere
};

KrlSyntax parse_krl(const KrlProgram& program);

/// The frame as text with other `values` (NaN: as it is), rounded as correct_krl() says; a number
/// that stays the same in that precision stands as it was written. A component that is not there is
/// added unless `before`, the pose that it is taken from, has the value.
std::string krl_frame_text(std::string_view text, const KrlFrame& frame, const KrlValues& values,
                           const KrlValues& before);

}  // namespace armtrue
