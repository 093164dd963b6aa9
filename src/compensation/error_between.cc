#include "compensation/error_between.h"

#include <algorithm>
#include <optional>

#include "armtrue/programs/division.h"
#include "compensation/joint_correction.h"

namespace armtrue {
namespace {

constexpr int kSamples = 7;  // between two points

// A line, or an arc if there is one through its points.
struct Way {
  Pose start, end;
  std::optional<Arc> arc;

  Pose at(double t) const {
    Pose pose = between(start, end, t);
    if (arc) pose.translation = arc->at(t);
    return pose;
  }
};

}  // namespace

Pose between(const Pose& start, const Pose& end, double t) {
  const Eigen::Vector3d turn = rotation_log(start.rotation.transpose() * end.rotation);
  return {start.rotation * rotation_exp(t * turn),
          start.translation + t * (end.translation - start.translation)};
}

Pose ErrorBetween::intended(const std::vector<CorrectedTarget>& targets, size_t row,
                            const Arms& own) const {
  const Arms& of_row = arms(row);
  const Pose foot_from_tcp = of_row.options.base * targets[row].intended;
  return foot_from_tcp * inverse(of_row.options.tool) * own.options.tool;
}

Pose ErrorBetween::intended_start(const std::vector<CorrectedTarget>& targets, size_t row) const {
  return intended(targets, row - 1, arms(row));
}

Pose ErrorBetween::intended_end(const std::vector<CorrectedTarget>& targets, size_t row) const {
  return intended(targets, row, arms(row));
}

Pose ErrorBetween::commanded(const std::vector<CorrectedTarget>& targets, size_t row,
                             const Arms& own) const {
  Context context = program_.visits.context(static_cast<int>(row));
  context.q = targets[row].q;
  return own.controller.pose(context);
}

std::vector<WayError> ErrorBetween::errors(const std::vector<CorrectedTarget>& targets,
                                           const std::vector<WayToRow>& ways) const {
  std::vector<WayError> errors(targets.size());
  CommandedMotion motion(program_.visits);
  for (size_t row = 0; row < targets.size(); ++row) {
    const WayToRow& way = ways[row];
    if (way.motion == MotionKind::via) continue;  // a point of the arc to the next row
    const size_t points = way.motion == MotionKind::arc ? 2 : 1;
    bool counts = way.motion != MotionKind::joint && way.is_known && row >= points;
    for (size_t k = 0; counts && k <= points; ++k) counts = targets[row - k].is_corrected;
    if (counts) errors[row] = error_on(targets, row, way, motion);
    motion.go_to(targets[row].q);
  }
  return errors;
}

WayError ErrorBetween::error_on(const std::vector<CorrectedTarget>& targets, size_t row,
                                const WayToRow& way, CommandedMotion& motion) const {
  const Arms& own = arms(row);
  const bool is_arc = way.motion == MotionKind::arc;
  const size_t first = row - (is_arc ? 2 : 1);
  Way meant{intended(targets, first, own), intended(targets, row, own), std::nullopt};
  Way driven{commanded(targets, first, own), commanded(targets, row, own), std::nullopt};
  if (is_arc) {
    const auto arc = [&](const Way& of, const Pose& via) {
      return arc_through(of.start.translation, via.translation, of.end.translation);
    };
    meant.arc = arc(meant, intended(targets, row - 1, own));
    driven.arc = arc(driven, commanded(targets, row - 1, own));
    if (!meant.arc || !driven.arc) return {};
  }
  WayError error{0};
  double largest_step = 0;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();  // the error one sample before; none at an end
  JointVector q = targets[first].q;
  for (int k = 1; k <= kSamples + 1; ++k) {
    const double t = static_cast<double>(k) / (kSamples + 1);
    Eigen::Vector3d here = Eigen::Vector3d::Zero();
    if (k <= kSamples) {
      Context context = program_.visits.context(static_cast<int>(row));
      const JointCorrection found = joints_of_pose(own.controller, context, driven.at(t), q);
      if (!found.is_reached) return {std::numeric_limits<double>::infinity()};
      q = found.q;
      motion.arrive(context, q);
      motion.go_to(q);
      context.q = q;
      here = own.identified.pose(context).translation - meant.at(t).translation;
    }
    if (t >= way.from && t <= way.to) error.largest = std::max(error.largest, here.norm());
    if (const double step = (here - before).norm(); step > largest_step) {
      largest_step = step;
      error.step_from = t - 1.0 / (kSamples + 1);
      error.step_to = t;
    }
    before = here;
  }
  // On a smooth bend, which is a parabola, neighbours differ by less than half of the largest
  // value.
  if (largest_step < 0.75 * error.largest) error.step_from = error.step_to = 0;
  return error;
}

}  // namespace armtrue
