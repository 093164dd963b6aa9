#include "armtrue/path/mirror/form_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "armtrue/path/registration/clock.h"
#include "plant_pass.h"
#include "support/thinned.h"

namespace armtrue::form_error_test {
namespace {

// A cell without cut and friction whose tool runs aside of a line along x.
plant::Options aside(double offset, double direction) {
  plant::Options options = plant::ideal();
  options.static_offset =
      offset * Eigen::Vector3d(0, std::cos(direction), std::sin(direction));
  options.lost = 0.01;
  return options;
}

std::vector<Path> registered_passes(const Path& programmed, const std::vector<Path>& passes) {
  std::vector<Path> in_time;
  for (const Path& pass : passes)
    in_time.push_back(registered(pass, fit_clock(programmed, pass)));
  return in_time;
}

struct Runs {
  int runs = 0, covered = 0;
  double sum = 0;
  double bias() const { return sum / runs; }  // relative
  double coverage() const { return static_cast<double>(covered) / runs; }
  void add(const FormError& form, double truth) {
    ++runs;
    sum += form.rms / truth - 1;
    covered += form.ci95[0] <= truth && truth <= form.ci95[1];
  }
};

// The record of an instrument with this noise and period, of a tool aside by a constant offset.
// Plain samples of a line at 27 mm/s: thousands of runs of the plant would take minutes.
Path plain_record(std::mt19937_64& random, double offset, double noise, double period) {
  std::normal_distribution<double> normal(0, noise);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<double> times;
  for (double t = period * uniform(random); t < 13.2; t += period)
    if (uniform(random) > 0.01) times.push_back(t);
  const double direction = 6.2831853 * uniform(random);
  Path record;
  record.time = Eigen::Map<const Eigen::VectorXd>(times.data(), std::ssize(times));
  record.position.resize(3, record.time.size());
  for (Eigen::Index i = 0; i < record.time.size(); ++i) {
    record.position.col(i) << 0.027 * std::clamp(record.time[i] - 1, 0.0, 11.2),
        offset * std::cos(direction), offset * std::sin(direction);
    for (int axis = 0; axis < 3; ++axis) record.position(axis, i) += normal(random);
  }
  return record;
}

Path plain_line() {
  Path line;
  line.time = Eigen::VectorXd::LinSpaced(826, 0, 13.2);
  line.position = Eigen::Matrix3Xd::Zero(3, 826);
  for (Eigen::Index i = 0; i < 826; ++i)
    line.position(0, i) = 0.027 * std::clamp(line.time[i] - 1, 0.0, 11.2);
  return line;
}

// Offsets of 0.02 to 0.2 mm, noise of 0.02 to 0.1, periods of 4 to 64 ms, one to three passes. Of a
// cell of the grid with 60 runs the mean scatters, so the bounds hold for all runs of one offset
// and noise.
TEST(FormError, IsUnbiasedAndItsIntervalCovers) {
  std::mt19937_64 random(1);
  const Path line = plain_line();
  const int part = thinned(4);
  const double wider = std::sqrt(part);
  Runs all;
  for (const double offset : {0.02e-3, 0.05e-3, 0.2e-3})
    for (const double noise : {0.02e-3, 0.05e-3, 0.1e-3}) {
      Runs runs;
      for (const double period : {0.004, 0.016, 0.032, 0.064})
        for (int passes = 1; passes <= 3; ++passes)
          for (int k = 0; k < (period < 0.01 ? 20 : 80) / part; ++k) {
            std::vector<Path> records;
            for (int p = 0; p < passes; ++p)
              records.push_back(plain_record(random, offset, noise, period));
            const FormError form = form_error(line, records);
            runs.add(form, offset);
            all.add(form, offset);
          }
      std::printf("offset %.2f noise %.2f mm: bias %.2f %%, coverage %.1f %%\n", 1e3 * offset,
                  1e3 * noise, 100 * runs.bias(), 100 * runs.coverage());
      EXPECT_LT(std::abs(runs.bias()), 0.03 * wider) << offset << " " << noise;
      EXPECT_NEAR(runs.coverage(), 0.95, 0.02 * wider) << offset << " " << noise;
    }
  EXPECT_NEAR(all.coverage(), 0.95, 0.01 * wider);
}

// A path through these corners at 27 mm/s, which stands for a second at both ends.
Path through(const std::vector<Eigen::Vector3d>& corners) {
  constexpr double kPeriod = 0.016, kFeed = 0.027;
  std::vector<double> length{0};
  for (size_t k = 1; k < corners.size(); ++k)
    length.push_back(length.back() + (corners[k] - corners[k - 1]).norm());
  const auto samples = static_cast<Eigen::Index>((length.back() / kFeed + 2) / kPeriod) + 1;
  Path path;
  path.time = Eigen::VectorXd::LinSpaced(samples, 0, kPeriod * static_cast<double>(samples - 1));
  path.position.resize(3, samples);
  size_t k = 1;
  for (Eigen::Index i = 0; i < samples; ++i) {
    const double at = std::clamp(kFeed * (path.time[i] - 1), 0.0, length.back());
    while (k + 1 < corners.size() && at > length[k]) ++k;
    const double share = (at - length[k - 1]) / (length[k] - length[k - 1]);
    path.position.col(i) = corners[k - 1] + share * (corners[k] - corners[k - 1]);
  }
  return path;
}

Path record_aside(std::mt19937_64& random, const Path& path, const Eigen::Vector3d& offset,
                  double noise, double period) {
  std::normal_distribution<double> normal(0, noise);
  Path record;
  const double end = path.time[path.samples() - 1];
  const auto samples = static_cast<Eigen::Index>(end / period);
  record.time = Eigen::VectorXd::LinSpaced(samples, 0, period * static_cast<double>(samples - 1));
  record.position = position_at(path, record.time).colwise() + offset;
  for (double& value : record.position.reshaped()) value += normal(random);
  return record;
}

// An offset in x, y and z on a circle, and on sides along x and y of equal length: across the path
// lies half of the square of x and y, and that of z. At each corner the deviation jumps.
TEST(FormError, IntervalCoversOnCurvesAndBetweenCorners) {
  std::vector<Eigen::Vector3d> circle, stairs;
  for (int k = 0; k <= 720; ++k)
    circle.emplace_back(0.06 * std::cos(k * std::numbers::pi / 360),
                        0.06 * std::sin(k * std::numbers::pi / 360), 0);
  for (int k = 0; k <= 18; ++k) stairs.emplace_back(0.02 * ((k + 1) / 2), 0.02 * (k / 2), 0);
  const Eigen::Vector3d offset(0.12e-3, -0.09e-3, 0.05e-3);
  const double truth = std::sqrt(offset.head<2>().squaredNorm() / 2 + offset.z() * offset.z());
  std::mt19937_64 random(7);
  const int part = thinned(4);
  const double wider = std::sqrt(part);
  for (const Path& path : {through(circle), through(stairs)})
    for (const double noise : {0.02e-3, 0.05e-3, 0.1e-3})
      for (const double period : {0.016, 0.032}) {
        Runs runs;
        int shaken = 0;
        for (int k = 0; k < 400 / part; ++k) {
          const FormError form =
              form_error(path, {record_aside(random, path, offset, noise, period)});
          runs.add(form, truth);
          shaken += form.faster > 0;
        }
        EXPECT_LT(std::abs(runs.bias()), 0.01 * wider) << noise << " " << period;
        EXPECT_NEAR(runs.coverage(), 0.95, 0.03 * wider) << noise << " " << period;
        EXPECT_LE(shaken, 4 / wider) << noise << " " << period;
      }
}

// The same through clocks that differ and are fitted.
TEST(FormError, HoldsWithFittedClocksAndLostSamples) {
  const plant::Program program = plant::program(plant::Shape::line);
  const Path programmed = path_of(program);
  Runs runs;
  for (int k = 0; k < 60; ++k) {
    std::vector<Path> passes;
    for (int p = 0; p <= k % 2; ++p) {
      plant::Options options = aside(0.08e-3, 0.7 * k);
      options.noise = 0.095e-3;
      options.clock_offset = 0.3 + 0.01 * k;
      options.clock_rate = (k % 5 - 2) * 70e-6;
      options.period = k % 3 == 0 ? 0.016 : 0.032;
      options.pass_seed = static_cast<std::uint64_t>(10 * k + p);
      passes.push_back(record_of(plant::run(program, program.position, options)));
    }
    runs.add(form_error(programmed, registered_passes(programmed, passes)), 0.08e-3);
  }
  EXPECT_LT(std::abs(runs.bias()), 0.03);
  EXPECT_GE(runs.coverage(), 0.88);  // 60 runs: 3 +- 1.7 are outside
}

// Truth: the distances of the simulated tool from the path, which the estimator never sees.
double true_form(const plant::Program& program, const plant::Record& record) {
  const Eigen::VectorXd distance = plant::distances(program, record.true_position);
  double sum = 0;
  int count = 0;
  for (Eigen::Index i = 1; i < distance.size(); ++i)
    if (program.arc_length[i] > program.arc_length[i - 1]) {
      sum += distance[i] * distance[i];
      ++count;
    }
  return std::sqrt(sum / count);
}

// Cuts, reversals, corners and curves: jumps have power above the highest frequency of the form.
TEST(FormError, OfAMachinedPathIsThatOfTheTool) {
  for (const plant::Shape shape : kShapes) {
    const plant::Program program = plant::program(shape);
    for (int k = 0; k < 3; ++k) {
      const plant::Record record = plant::run(program, program.position, cell(k));
      const double truth = true_form(program, record);
      const Path programmed = path_of(program);
      const FormError form =
          form_error(programmed, registered_passes(programmed, {record_of(record)}));
      EXPECT_NEAR(form.rms, truth, 0.03 * truth) << static_cast<int>(shape) << " " << k;
      EXPECT_LE(form.ci95[0], form.rms);
      EXPECT_GE(form.ci95[1], form.rms);
    }
  }
}

// Neighbouring samples of 4 ms share their noise (first-order, 10 ms): it is no form.
TEST(FormError, AutocorrelatedNoiseIsNotForm) {
  std::mt19937_64 random(2);
  const Path line = plain_line();
  const double share = std::exp(-4.0 / 10);
  std::normal_distribution<double> normal(0, 0.05e-3);
  Runs runs;
  for (int k = 0; k < 200; ++k) {
    Path record = plain_record(random, 0.08e-3, 0, 0.004);
    Eigen::Vector3d noise = Eigen::Vector3d::Zero();
    for (auto position : record.position.colwise()) {
      for (double& axis : noise)
        axis = share * axis + std::sqrt(1 - share * share) * normal(random);
      position += noise;
    }
    runs.add(form_error(line, {record}), 0.08e-3);
  }
  EXPECT_LT(std::abs(runs.bias()), 0.03);
  EXPECT_GE(runs.coverage(), 0.91);
}

// Slower noise, of 20 to 100 ms, has its power where the form is. Passes differ by it and not by
// the form; one pass does not tell, and its interval says so. With 20 ms two passes do not always
// show it: 90 % cover.
TEST(FormError, SlowNoiseIsWhatPassesDifferBy) {
  std::mt19937_64 random(6);
  const Path line = plain_line();
  std::normal_distribution<double> normal(0, 1);
  constexpr double kPeriod = 0.008, kNoise = 0.06e-3, kForm = 0.08e-3;
  for (const double slow : {0.02, 0.05, 0.1})
    for (const int passes : {1, 2, 3}) {
      Runs runs;
      for (int k = 0; k < 100; ++k) {
        std::vector<Path> records;
        for (int pass = 0; pass < passes; ++pass) {
          Path& record = records.emplace_back(plain_record(random, 0, 0, kPeriod));
          const double share = std::exp(-kPeriod / slow);
          Eigen::Vector3d noise = Eigen::Vector3d::Zero();
          for (int i = 0; i < 100 + record.samples(); ++i) {
            for (double& axis : noise)
              axis = share * axis + kNoise * std::sqrt(1 - share * share) * normal(random);
            if (i >= 100) record.position.col(i - 100) += noise;
          }
          for (Eigen::Index i = 0; i < record.samples(); ++i) {
            const double at = std::clamp(record.time[i] - 1, 0.0, 11.2) / 11.2;
            record.position(1, i) +=
                std::numbers::sqrt2 * kForm * std::cos(12 * std::numbers::pi * at);
          }
        }
        runs.add(form_error(line, records), kForm);
      }
      EXPECT_GE(runs.coverage(), slow < 0.03 ? 0.88 : 0.92) << slow << " " << passes;
      const double most_biased = passes > 1 ? 0.1 : 0.5;
      EXPECT_LT(std::abs(runs.bias()), most_biased) << slow << " " << passes;
    }
}

// A tool that vibrates by 0.2 mm at 5 Hz, above the form: 0.141 mm RMS, and no goal of 0.05 mm is
// held. White noise of samples is none of it, whatever the period.
TEST(FormError, AVibrationIsNoNoise) {
  std::mt19937_64 random(4);
  const Path line = plain_line();
  for (const double period : {0.004, 0.01, 0.016}) {
    int stands_out = 0;
    for (int k = 0; k < 40; ++k) {
      Path record = plain_record(random, 0.01e-3, 0.01e-3, period);
      const FormError still = form_error(line, {record});
      stands_out += still.faster > 0;
      EXPECT_EQ(still.holds(0.05e-3), true) << period;
      for (Eigen::Index i = 0; i < record.samples(); ++i)
        record.position(1, i) += 0.2e-3 * std::sin(2 * std::numbers::pi * 5 * record.time[i]);
      const FormError shaken = form_error(line, {record});
      EXPECT_NEAR(shaken.faster, 0.2e-3 / std::numbers::sqrt2, 0.01e-3) << period;
      EXPECT_NE(shaken.holds(0.05e-3), true) << period;
    }
    EXPECT_LE(stands_out, 1) << period;
  }
}

// What stands at one place for 20 to 100 ms, in each pass: a spike, or a step at a corner, which
// fades. Its power lies far above the form, where it counted as noise.
TEST(FormError, IntervalCoversSparseForms) {
  std::mt19937_64 random(11);
  const Path path = through({{0, 0, 0}, {0.15, 0, 0}, {0.15, 0.15, 0}});
  const int part = thinned(4);
  const double wider = std::sqrt(part);
  constexpr double kPeriod = 0.01, kSide = 0.15 / 0.027, kAside = 5e-6;
  for (const bool fades : {false, true})
    for (const double size : {0.05e-3, 0.1e-3, 0.26e-3, 0.8e-3}) {
      Runs runs;
      for (const double lasts : {0.02, 0.05, 0.1})
        for (const double noise : {0.005e-3, 0.02e-3})
          for (int k = 0; k < 80 / part; ++k) {
            std::vector<Path> records;
            double square = 0, count = 0;
            for (int pass = 0; pass <= k % 2; ++pass) {
              Path& record = records.emplace_back(
                  record_aside(random, path, Eigen::Vector3d::Constant(kAside), noise, kPeriod));
              for (Eigen::Index i = 0; i < record.samples(); ++i) {
                const double in_motion = record.time[i] - 1;
                const double since = in_motion - (fades ? kSide : 1.3 * kSide);
                const double there = since <= 0 ? 0
                                     : fades    ? std::exp(-since / lasts)
                                                : static_cast<double>(since < lasts);
                record.position(2, i) += size * there;
                if (in_motion < 0 || in_motion > 2 * kSide) continue;
                square += kAside * kAside + std::pow(kAside + size * there, 2);
                ++count;
              }
            }
            runs.add(form_error(path, records), std::sqrt(square / count));
          }
      std::printf("%s of %.2f mm: bias %.1f %%, coverage %.1f %%\n", fades ? "step" : "spike",
                  1e3 * size, 100 * runs.bias(), 100 * runs.coverage());
      EXPECT_LT(std::abs(runs.bias()), 0.03 * wider) << fades << " " << size;
      EXPECT_NEAR(runs.coverage(), 0.95, 0.02 * wider) << fades << " " << size;
    }
}

TEST(FormError, HoldsAGoalOnlyIfTheIntervalSaysSo) {
  EXPECT_EQ((FormError{0.04e-3, {0.03e-3, 0.05e-3}}.holds(0.05e-3)), true);
  EXPECT_EQ((FormError{0.06e-3, {0.051e-3, 0.07e-3}}.holds(0.05e-3)), false);
  EXPECT_EQ((FormError{0.04e-3, {0.03e-3, 0.051e-3}}.holds(0.05e-3)), std::nullopt);
}

TEST(FormError, ReductionIsThatOfTheFormWithItsInterval) {
  const auto reduction =
      form_reduction({0.4e-3, {0.4e-3, 0.4e-3}}, {0.1e-3, {0.05e-3, 0.2e-3}});
  ASSERT_TRUE(reduction && reduction->ci95);
  EXPECT_DOUBLE_EQ(reduction->share, 0.75);
  EXPECT_NEAR((*reduction->ci95)[0], 0.5, 1e-12);
  EXPECT_NEAR((*reduction->ci95)[1], 0.875, 1e-12);
  EXPECT_FALSE(form_reduction({0, {0, 0.1e-3}}, {0, {0, 0.1e-3}}));
  EXPECT_FALSE(form_reduction({0.1e-3, {0, 0.2e-3}}, {0, {0, 0.1e-3}})->ci95);
}

// The logarithms of both forms err: their distances from the ends add up in squares.
TEST(FormError, ReductionHasTheIntervalsOfBothForms) {
  const auto reduction = form_reduction({0.4e-3, {0.35e-3, 0.5e-3}}, {0.1e-3, {0.05e-3, 0.2e-3}});
  ASSERT_TRUE(reduction && reduction->ci95);
  const double more = std::hypot(std::log(2), std::log(0.4 / 0.35));
  const double less = std::hypot(std::log(2), std::log(0.5 / 0.4));
  EXPECT_NEAR((*reduction->ci95)[0], 1 - 0.25 * std::exp(more), 1e-12);
  EXPECT_NEAR((*reduction->ci95)[1], 1 - 0.25 * std::exp(-less), 1e-12);
}

TEST(FormError, NeedsSamplesInMotion) {
  Path standing = plain_line();
  standing.time = standing.time.head(50).eval();
  standing.position = standing.position.leftCols(50).eval();
  EXPECT_THROW(form_error(plain_line(), {standing}), std::invalid_argument);
}

}  // namespace
}  // namespace armtrue::form_error_test
