#pragma once

#include <deque>
#include <limits>
#include <optional>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/programs/robot_program.h"
#include "armtrue/programs/way.h"
#include "compensation/arms.h"

namespace armtrue {

/// The known part of the path to a row of a program.
struct WayToRow {
  bool is_known = false;  ///< where it begins
  /// The part of the path, from 0 to 1, that counts: beyond it the arm rounds the corners.
  double from = 0, to = 1;
};

/// The prediction for the path to a row.
struct WayError {
  /// The largest error on it [m]. Infinite if the controller's model cannot follow the path; NaN
  /// for joint moves, auxiliary points, unknown paths, and paths with an end that is not corrected.
  double largest = std::numeric_limits<double>::quiet_NaN();
  /// The part of the path, from 0 to 1, on which most of the error appears or disappears suddenly,
  /// as where a joint with backlash reverses; `from` = `to` if there is none.
  double step_from = 0, step_to = 0;
};

/// Predicts the distance of the TCP of the identified arm from the intended path between the points
/// of straight and circular moves. The controller moves it on a line or an arc in its own model,
/// from command to command, at constant speed; the error is the distance from the point of the
/// intended path at the same time.
class ErrorBetween {
 public:
  /// `program` must outlive it.
  ErrorBetween(const Robot& identified, const Robot& controller, const Program& program,
               const CompensationOptions& options)
      : program_(program), arms_(arms_of(identified, controller, program, options)) {}

  /// The way to a row as the program means it, R_0 from TCP of the row's tool. Nothing of joint
  /// moves, of auxiliary points, of moves without their points before, and of arcs whose points lie
  /// on a line.
  std::optional<Way> intended_way(const std::vector<CorrectedTarget>& targets, size_t row) const;

  /// One for each row.
  std::vector<WayError> errors(const std::vector<CorrectedTarget>& targets,
                               const std::vector<WayToRow>& ways) const;

 private:
  const Arms& arms(size_t row) const { return arms_[set_up_of(program_, row)]; }
  WayError error_on(const std::vector<CorrectedTarget>& targets, size_t row, const WayToRow& way,
                    CommandedMotion& motion) const;
  Pose commanded(const std::vector<CorrectedTarget>& targets, size_t row, const Arms& own) const;
  Pose intended(const std::vector<CorrectedTarget>& targets, size_t row, const Arms& own) const;

  const Program& program_;
  std::deque<Arms> arms_;
};

}  // namespace armtrue
