// From the record of a machining pass to its law of force: the whole way, on the cell that shares
// nothing with armtrue.

#include <gtest/gtest.h>

#include <cstdio>

#include "armtrue/path/engagement.h"
#include "armtrue/path/force_law.h"
#include "armtrue/path/low_pass.h"
#include "armtrue/path/mirror.h"
#include "support/path_plant.h"

namespace armtrue {
namespace {

struct Registered {
  EngagementRecord engagement;
  ForceLaw law;
};

Registered law_of(const plant::Program& program, const plant::Options& options) {
  const plant::Record record = plant::run(program, program.position, options);
  Path programmed, measured;
  programmed.time = program.time;
  programmed.position = program.position;
  measured.time = record.time;
  measured.position = record.position;
  measured.force = record.force;
  const PathDeviation d = mirror_correct(programmed, {measured}, {}).deviation;
  const EngagementRecord engagement = find_engagement(d.time, d.force);
  const LowPass filter(4, 1 / 0.64, 1 / d.period);
  // In motion only.
  constexpr double kNear = 1e-3;
  Eigen::Index first = 0, last = d.time.size() - 1;
  const double length = d.arc_length[last];
  while (d.arc_length[first] < kNear) ++first;
  while (d.arc_length[last] > length - kNear) --last;
  const Eigen::Index n = last - first + 1;
  return {engagement,
          force_law({.deviation = filter(d.normal).middleCols(first, n),
                     .force = filter(d.force).middleCols(first, n),
                     .force_noise = engagement.noise * std::sqrt(filter.noise_share())})};
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

TEST(ForceOfAPass, ALineShowsItsComplianceAndItsEngagement) {
  const plant::Program program = plant::program(plant::Shape::line);
  constexpr int kPasses = 100;
  int lines = 0, compliances = 0, instants = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    plant::Options options;
    options.part_seed = 100 + static_cast<std::uint64_t>(pass);
    options.pass_seed = 500 + static_cast<std::uint64_t>(pass);
    const auto [engagement, law] = law_of(program, options);
    const Eigen::Vector3d u = options.force_per_depth.normalized();
    const Eigen::Vector3d truth = options.compliance * u;
    ASSERT_TRUE(law.axis[1].k);
    lines += holds(*law.axis[1].k, truth[1] / u[1]);
    EXPECT_GT(law.axis[1].r2, 0.9);
    EXPECT_EQ(law.rank, 1);  // the direction of the force never changes
    const double sign = law.directions[0].direction.dot(u) > 0 ? 1 : -1;
    for (const int a : {1, 2})  // along x the tool's deviation is no part of the record
      compliances +=
          holds((*law.directions[0].compliance)[static_cast<size_t>(a)], sign * truth[a]);
    ASSERT_EQ(engagement.intervals.size(), 1U);
    instants += holds(engagement.intervals[0].entry, time_at(program, program.entry));
    instants += holds(engagement.intervals[0].exit, time_at(program, program.exit));
  }
  std::printf("held by their intervals: k %d of %d, compliance %d of %d, entry and exit %d of %d\n",
              lines, kPasses, compliances, 2 * kPasses, instants, 2 * kPasses);
  EXPECT_GE(lines, 90);  // 95 expected, 2.2 standard deviation
  EXPECT_GE(compliances, 180);
  EXPECT_GE(instants, 195);
}

}  // namespace
}  // namespace armtrue
