#include "compensation/error_between.h"

#include <algorithm>

#include "compensation/tcp_way.h"

namespace armtrue {
namespace {

constexpr int kSamples = 7;  // between two points

// How many rows before a row its way begins.
size_t rows_of(MotionKind motion) { return motion == MotionKind::arc ? 2 : 1; }

}  // namespace

Pose ErrorBetween::intended(const std::vector<CorrectedTarget>& targets, size_t row,
                            const Arms& own) const {
  const Arms& of_row = arms(row);
  const Pose foot_from_tcp = of_row.options.base * targets[row].intended;
  return foot_from_tcp * inverse(of_row.options.tool) * own.options.tool;
}

std::optional<Way> ErrorBetween::intended_way(const std::vector<CorrectedTarget>& targets,
                                              size_t row) const {
  const MotionKind kind = motion_to(program_, row).kind;
  if (kind == MotionKind::via || row < rows_of(kind)) return std::nullopt;
  const auto part = tcp_way(program_, row, row - rows_of(kind),
                            [&](size_t of) { return intended(targets, of, arms(row)); });
  return part ? std::optional(part->way) : std::nullopt;
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
    const MotionKind kind = motion_to(program_, row).kind;
    if (kind == MotionKind::via) continue;  // a point of the arc to the next row
    const size_t points = rows_of(kind);
    bool counts = kind != MotionKind::joint && way.is_known && row >= points;
    for (size_t k = 0; counts && k <= points; ++k) counts = targets[row - k].is_corrected;
    if (counts) errors[row] = error_on(targets, row, way, motion);
    motion.go_to(targets[row].q);
  }
  return errors;
}

WayError ErrorBetween::error_on(const std::vector<CorrectedTarget>& targets, size_t row,
                                const WayToRow& way, CommandedMotion& motion) const {
  const Arms& own = arms(row);
  const auto meant = intended_way(targets, row);
  const auto driven = tcp_way(program_, row, row - rows_of(motion_to(program_, row).kind),
                              [&](size_t of) { return commanded(targets, of, own); });
  if (!meant || !driven) return {};
  WayError error{0};
  double largest_step = 0;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();  // the error one sample before; none at an end
  const JointsOfEnds ends{targets[row - rows_of(motion_to(program_, row).kind)].q, targets[row].q};
  JointVector q = ends.from;
  for (int k = 1; k <= kSamples + 1; ++k) {
    const double t = static_cast<double>(k) / (kSamples + 1);
    Eigen::Vector3d here = Eigen::Vector3d::Zero();
    if (k <= kSamples) {
      Context context = program_.visits.context(static_cast<int>(row));
      const auto found = joints_on(own.controller, program_, context, driven->way, t, ends, t, q);
      if (!found) return {std::numeric_limits<double>::infinity()};
      q = *found;
      motion.arrive(context, q);
      motion.go_to(q);
      context.q = q;
      here = own.identified.pose(context).translation - meant->at(t).translation;
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
