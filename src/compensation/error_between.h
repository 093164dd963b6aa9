#pragma once

#include <deque>
#include <limits>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/programs/robot_program.h"
#include "compensation/arms.h"

namespace armtrue {

/// Poses half-way and so on between two: positions on the chord, rotation R exp(t log(R' R_end)).
Pose between(const Pose& start, const Pose& end, double t);

/// How the arm comes to a row of a program from the row before.
struct WayToRow {
  MotionKind motion = MotionKind::joint;
  bool is_known = false;  ///< where it begins
  /// The part of the way, from 0 to 1, that counts: the arm rounds the corners beyond.
  double from = 0, to = 1;
};

/// Predicts how far the TCP of the identified arm is from the intended way between the points of
/// straight and circular moves. The controller moves it on a line or an arc in its own model, from
/// command to command, at constant speed; the error counts from the point of the intended way at
/// the same time.
class ErrorBetween {
 public:
  /// `program` must outlive it.
  ErrorBetween(const Robot& identified, const Robot& controller, const Program& program,
               const CompensationOptions& options)
      : program_(program), arms_(arms_of(identified, controller, program, options)) {}

  /// R_0 from TCP of a row's tool, where the row before is meant to be.
  Pose intended_start(const std::vector<CorrectedTarget>& targets, size_t row) const;
  Pose intended_end(const std::vector<CorrectedTarget>& targets, size_t row) const;

  /// The largest error on the way to each row [m]; infinite where the controller's model cannot
  /// follow the way; NaN of joint moves, auxiliary points, unknown ways, and ways with an end that
  /// is not corrected.
  std::vector<double> largest(const std::vector<CorrectedTarget>& targets,
                              const std::vector<WayToRow>& ways) const;

 private:
  const Arms& arms(size_t row) const { return arms_[set_up_of(program_, row)]; }
  double largest_on(const std::vector<CorrectedTarget>& targets, size_t row, const WayToRow& way,
                    CommandedMotion& motion) const;
  Pose commanded(const std::vector<CorrectedTarget>& targets, size_t row, const Arms& own) const;
  Pose intended(const std::vector<CorrectedTarget>& targets, size_t row, const Arms& own) const;

  const Program& program_;
  std::deque<Arms> arms_;
};

}  // namespace armtrue
