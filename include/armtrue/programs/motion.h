#pragma once

namespace armtrue {

/// How the TCP moves to a target from the one before.
enum class MotionKind {
  joint,  ///< all joints move together; the path of the TCP is no straight line
  line,
  via,  ///< the auxiliary point of an arc, whose end is the next target
  arc
};

/// How the tool turns along an arc, from its orientation at the start to that at the end.
enum class ArcTurning {
  in_frame,   ///< at constant rate, about one axis
  with_path,  ///< the same relative to the tangent of the arc, which turns itself
  /// The auxiliary point may count: known only if it lies where `in_frame` has it.
  perhaps_through_via
};

/// How the arm comes to a target from the one before.
struct ProgramMotion {
  MotionKind kind = MotionKind::joint;
  ArcTurning turning = ArcTurning::in_frame;
};

}  // namespace armtrue
