// From the record of a machining pass to its law of force: the whole way, on the cell that shares
// nothing with armtrue.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "armtrue/path/low_pass.h"
#include "armtrue/path/mirror/engagement.h"
#include "armtrue/path/mirror/force_law.h"
#include "armtrue/path/mirror/mirror.h"
#include "path/plant_pass.h"

namespace armtrue::path_force_test {
namespace {

struct Registered {
  EngagementRecord engagement;
  ForceLaw law;
};

Eigen::Matrix2d axes_of(const plant::Options& options) {
  const double c = std::cos(options.axes_angle), s = std::sin(options.axes_angle);
  return (Eigen::Matrix2d() << c, s, -s, c).finished();
}

Registered law_of(const plant::Program& program, const plant::Options& options,
                  const ClockOptions& clock) {
  const Path programmed = path_of(program);
  const Path measured = record_of(plant::run(program, program.position, options));
  const PathDeviation d = mirror_correct(programmed, {measured}, {.clock = clock}).deviation;
  const Eigen::MatrixXd axes = axes_of(options) * position_at(programmed, d.time).topRows(2);
  const auto law = force_law(d, programmed, axes, LowPass(4, kPaperCutoff, 1 / d.period));
  return {d.engagement, *law};
}

bool holds(const Estimate& estimate, double truth) {
  return estimate.ci95[0] <= truth && truth <= estimate.ci95[1];
}

bool holds(const std::optional<Instant>& instant, double truth) {
  return instant && std::abs(instant->time - truth) <= instant->uncertainty;
}

// When the program has gone so far, going by sample.
double time_at(const plant::Program& program, double arc_length) {
  Eigen::Index i = 1;
  while (program.arc_length[i] < arc_length) ++i;
  const double share = (arc_length - program.arc_length[i - 1]) /
                       (program.arc_length[i] - program.arc_length[i - 1]);
  return program.time[i - 1] + share * (program.time[i] - program.time[i - 1]);
}

// How many of the intervals hold the truth.
struct Count {
  int held = 0, all = 0;
  void operator()(bool holds) {
    held += holds;
    ++all;
  }
  Count& operator+=(const Count& other) {
    held += other.held;
    all += other.all;
    return *this;
  }
  double share() const { return static_cast<double>(held) / all; }
};

constexpr int kPasses = 60;

// A line leaves the clock, and so the part along it, half unknown; what is across it must be right.
TEST(ForceOfAPass, ALineShowsItsComplianceAndItsEngagement) {
  const plant::Program program = plant::program(plant::Shape::line);
  Count lines, compliances, instants;
  for (int pass = 0; pass < kPasses; ++pass) {
    const plant::Options options = cell(pass);
    const auto [engagement, law] = law_of(program, options, {});
    const Eigen::Vector3d u = options.force_per_depth.normalized();
    ASSERT_TRUE(law.axis[1].k);
    lines(holds(*law.axis[1].k, options.compliance.row(1).dot(u) / u[1]));
    EXPECT_GT(law.axis[1].r2, 0.9);
    EXPECT_EQ(law.rank, 1);  // the direction of the force never changes
    const Eigen::Vector3d truth = options.compliance * law.directions[0].direction;
    for (const int a : {1, 2})
      compliances(holds((*law.directions[0].compliance)[static_cast<size_t>(a)], truth[a]));
    ASSERT_EQ(engagement.intervals.size(), 1U);
    instants(holds(engagement.intervals[0].entry, time_at(program, program.entry)));
    instants(holds(engagement.intervals[0].exit, time_at(program, program.exit)));
  }
  std::printf("held: k %d of %d, compliance %d of %d, entry and exit %d of %d\n", lines.held,
              lines.all, compliances.held, compliances.all, instants.held, instants.all);
  EXPECT_GE(lines.share(), 0.90);  // 95 expected; 60 passes
  EXPECT_GE(compliances.share(), 0.90);
  EXPECT_EQ(instants.held, instants.all);
}

struct Coverage {
  Count compliances, steps;
};

Coverage coverage(plant::Shape shape, int passes, bool clock_known) {
  Coverage held;
  const plant::Program program = plant::program(shape);
  for (int pass = 0; pass < passes; ++pass) {
    plant::Options options = cell(pass);
    ClockOptions clock;
    if (clock_known) {
      options.lag = options.clock_rate = 0;
      clock.offset = options.clock_offset;
    }
    const ForceLaw law = law_of(program, options, clock).law;
    for (const ForceDirection& d : law.directions) {
      if (!d.compliance) continue;
      const Eigen::Vector3d truth = options.compliance * d.direction;
      for (int a = 0; a < 3; ++a)
        held.compliances(holds((*d.compliance)[static_cast<size_t>(a)], truth[a]));
    }
    for (const ReversalStep& reversal : law.reversals) {
      if (reversal.axes.size() > 1) continue;  // both turned at once
      const Eigen::Index axis = reversal.axes.front();
      const Eigen::Vector2d truth = -options.reversal_step[static_cast<size_t>(axis)] *
                                    axes_of(options).row(axis).transpose();
      for (int a = 0; a < 2; ++a)
        held.steps(holds(reversal.step[static_cast<size_t>(a)], truth[a]));
    }
  }
  return held;
}

// With the clock known the whole deviation is: compliance and reversals on every shape.
TEST(ForceOfAPass, ForceAndReversalsAreToldApartOnEveryShape) {
  Count compliances, steps;
  for (const plant::Shape shape : kShapes) {
    const Coverage held = coverage(shape, kPasses, true);
    compliances += held.compliances;
    steps += held.steps;
  }
  std::printf("held: compliance %d of %d, steps %d of %d\n", compliances.held, compliances.all,
              steps.held, steps.all);
  EXPECT_GE(compliances.share(), 0.93);
  EXPECT_LE(compliances.share(), 0.97);
  EXPECT_GE(steps.share(), 0.91);  // some stretches between reversals hold few independent samples
}

// A fitted clock errs along the path, on a curve in every direction, at a corner as a step would:
// the intervals have to know.
TEST(ForceOfAPass, TheErrorOfAFittedClockIsInTheIntervals) {
  constexpr int kFew = 14;
  Count compliances, steps;
  for (const plant::Shape shape : {plant::Shape::arc, plant::Shape::corner, plant::Shape::spiral}) {
    const Coverage held = coverage(shape, kFew, false);
    compliances += held.compliances;
    steps += held.steps;
    EXPECT_GE(held.compliances.share(), 0.91);
    EXPECT_GE(held.steps.share(), 0.89);
  }
  std::printf("held: compliance %d of %d, steps %d of %d\n", compliances.held, compliances.all,
              steps.held, steps.all);
  EXPECT_GE(compliances.share(), 0.93);
  EXPECT_LE(compliances.share(), 0.98);
  EXPECT_GE(steps.share(), 0.92);
}

}  // namespace
}  // namespace armtrue::path_force_test
