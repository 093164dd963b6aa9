#include "armtrue/path/mirror/mirror.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "armtrue/path/mirror/findings.h"
#include "plant_pass.h"

namespace armtrue::mirror_test {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

struct Passes {
  double before = 0, after = 0, second = 0, expected = 0;  // mean distance from the path [m]
};

// Correct, cut again, correct once more; mean of some cells.
Passes run_passes(plant::Shape shape, const MirrorOptions& options) {
  constexpr int kCells = 6;
  const plant::Program program = plant::program(shape);
  const Path programmed = path_of(program);
  Passes sum;
  for (int k = 0; k < kCells; ++k) {
    const auto cut = [&](const Eigen::Matrix3Xd& commanded, int pass) {
      plant::Options cell_options = cell(k);
      cell_options.pass_seed = static_cast<std::uint64_t>(100 * k + pass);
      return plant::run(program, commanded, cell_options);
    };
    const plant::Record first = cut(program.position, 1);
    const MirrorResult corrected = mirror_correct(programmed, {record_of(first)}, options);
    const plant::Record second = cut(corrected.position, 2);
    MirrorOptions again = options;
    again.executed = corrected.position;
    const MirrorResult twice = mirror_correct(programmed, {record_of(second)}, again);
    const plant::Record third = cut(twice.position, 3);
    sum.before += plant::mean_distance(program, first.true_position) / kCells;
    sum.after += plant::mean_distance(program, second.true_position) / kCells;
    sum.second += plant::mean_distance(program, third.true_position) / kCells;
    sum.expected += corrected.expected_after / kCells;
  }
  std::printf("shape %d: taken off %.1f %%, second pass %.1f %%; forecast over first pass %.2f\n",
              static_cast<int>(shape), 100 * (1 - sum.after / sum.before),
              100 * (1 - sum.second / sum.before), sum.expected / sum.after);
  return sum;
}

TEST(Mirror, TakesTheDeviationOffInOnePass) {
  for (const plant::Shape shape : kShapes) {
    const Passes passes = run_passes(shape, {});
    // The seeds are fixed: 4.7 to 6.3 % are left by the first pass, 4.3 to 6.2 % by the second.
    EXPECT_LT(passes.after, 0.066 * passes.before) << static_cast<int>(shape);
    EXPECT_LT(passes.second, 0.065 * passes.before) << static_cast<int>(shape);
    EXPECT_NEAR(passes.expected, passes.after, 0.2 * passes.after) << static_cast<int>(shape);
  }
}

TEST(Mirror, TakesMoreOffWithTheCutoffOfTheData) {
  MirrorOptions options;
  options.cutoff.reset();
  for (const plant::Shape shape : kShapes) {
    const Passes passes = run_passes(shape, options);
    EXPECT_LT(passes.after, 0.062 * passes.before) << static_cast<int>(shape);
    EXPECT_LT(passes.second, 0.062 * passes.before) << static_cast<int>(shape);
  }
}

// The forecast has to hold where passes differ by more than the noise, too.
TEST(Mirror, SeveralPassesShowTheSpreadAndForecastIt) {
  const plant::Program program = plant::program(plant::Shape::arc);
  double expected = 0, after = 0, spread = 0;
  constexpr int kCells = 6;
  for (int k = 0; k < kCells; ++k) {
    plant::Options options = cell(k);
    options.repeatability = 0.06e-3;
    std::vector<Path> passes;
    for (int pass = 0; pass < 4; ++pass) {
      options.pass_seed = static_cast<std::uint64_t>(100 * k + pass);
      options.clock_offset += 0.2;
      passes.push_back(record_of(plant::run(program, program.position, options)));
    }
    const MirrorResult result = mirror_correct(path_of(program), passes, {});
    options.pass_seed = static_cast<std::uint64_t>(100 * k + 50);
    after +=
        plant::mean_distance(program, plant::run(program, result.position, options).true_position) /
        kCells;
    expected += result.expected_after / kCells;
    spread += result.deviation.spread / kCells;
  }
  EXPECT_NEAR(spread, 0.06e-3, 0.015e-3);
  EXPECT_NEAR(expected, after, 0.2 * after);
}

// A deviation of three axes that forgets itself in `memory` [s], standard deviation `sigma` [m].
Eigen::Matrix3Xd wandering(const Eigen::VectorXd& time, double sigma, double memory,
                           std::mt19937& random) {
  std::normal_distribution<double> unit;
  Eigen::Matrix3Xd values(3, time.size());
  for (Eigen::Index i = 0; i < time.size(); ++i) {
    const double kept = i == 0 ? 0 : std::exp((time[i - 1] - time[i]) / memory);
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      values(axis, i) = (i == 0 ? 0 : kept * values(axis, i - 1)) +
                        sigma * std::sqrt(1 - kept * kept) * unit(random);
  }
  return values;
}

// A closed path in space of 20 s, between standstills.
Path contour() {
  constexpr Eigen::Index kSamples = 720, kStand = 50;
  Path path;
  path.time.setLinSpaced(kSamples, 0, 0.032 * (kSamples - 1));
  path.position.resize(3, kSamples);
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    const double u =
        std::clamp(static_cast<double>(i - kStand) / (kSamples - 2 * kStand), 0.0, 1.0);
    const double a = 2 * std::numbers::pi * u - 0.5 * std::sin(2 * std::numbers::pi * u);
    path.position.col(i) =
        Eigen::Vector3d(0.12 * std::cos(a), 0.09 * std::sin(a), 0.03 * std::sin(2 * a));
  }
  return path;
}

// Mean and mean square of the distance across the path, where it moves.
std::array<double, 2> across(const Path& path, const Eigen::Matrix3Xd& off) {
  double sum = 0, squares = 0, count = 0;
  for (Eigen::Index i = 1; i + 1 < path.samples(); ++i) {
    const Eigen::Vector3d along = path.position.col(i + 1) - path.position.col(i - 1);
    if (along.norm() < 1e-6) continue;
    const double distance = off.col(i).cross(along.normalized()).norm();
    sum += distance;
    squares += distance * distance;
    count += 1;
  }
  return {sum / count, squares / count};
}

// Whatever share of the mean deviation is corrected, the next pass differs as these do.
TEST(Mirror, TheNextOfSeveralPassesHasTheWholeSpread) {
  constexpr int kCells = 5;
  const Path programmed = contour();
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, 0.02e-3);
  for (const auto& [systematic, spread, count] : {std::tuple(0.0, 0.05e-3, 2),
                                                  {0.02e-3, 0.05e-3, 5},
                                                  {0.2e-3, 0.02e-3, 3},
                                                  {0.1e-3, 0.1e-3, 6}}) {
    double expected = 0, after = 0;
    for (int k = 0; k < kCells; ++k) {
      Eigen::Matrix3Xd arm(3, programmed.samples());
      for (Eigen::Index i = 0; i < programmed.samples(); ++i)
        for (int axis = 0; axis < 3; ++axis)
          arm(axis, i) = systematic * std::sin(0.9 * programmed.time[i] + 2.0 * axis + k);
      std::vector<Path> passes;
      for (int p = 0; p < count; ++p) {
        Path pass = programmed;
        pass.position += arm + wandering(programmed.time, spread, 1.5, random);
        for (double& value : pass.position.reshaped()) value += noise(random);
        passes.push_back(std::move(pass));
      }
      const MirrorResult result = mirror_correct(programmed, passes, {});
      expected += result.expected_after / kCells;
      after += across(programmed, result.correction + arm +
                                      wandering(programmed.time, spread, 1.5, random))[0] /
               kCells;
    }
    std::printf("%d passes, systematic %.2f, spread %.2f mm: forecast over next pass %.3f\n", count,
                1e3 * systematic, 1e3 * spread, expected / after);
    EXPECT_NEAR(expected / after, 1, 0.1);
  }
}

// A pass as an instrument records it that stands turned by 0.3 rad, and its noise.
Path in_another_frame(Path pass, double noise, std::mt19937& random) {
  std::normal_distribution<double> error(0, noise);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 1, 1).normalized()).toRotationMatrix();
  pass.position = (turn * pass.position).eval();
  pass.position.colwise() += Eigen::Vector3d(1, -0.5, 0.2);
  for (double& value : pass.position.reshaped()) value += error(random);
  return pass;
}

// A fitted frame takes up a part of the deviation; the forecast and the interval of the form know.
TEST(Mirror, TheUncertaintyOfAFittedFrameIsForecast) {
  constexpr int kCells = 8;
  const Path programmed = contour();
  std::mt19937 random(5);
  MirrorOptions options;
  options.clock.fit_frame = true;
  double expected = 0, after = 0;
  int held = 0;
  for (int k = 0; k < kCells; ++k) {
    const Eigen::Matrix3Xd arm = wandering(programmed.time, 0.2e-3, 3, random);
    Path pass = programmed;
    pass.position += arm;
    pass = in_another_frame(std::move(pass), 0.02e-3, random);
    MirrorFindings findings;
    findings.options = options;
    findings.result = mirror_correct(programmed, {pass}, options);
    describe_passes(findings, programmed, {pass}, {}, std::nullopt);
    expected += std::pow(findings.result.expected_after, 2) / kCells;
    after += std::pow(across(programmed, findings.result.correction + arm)[0], 2) / kCells;
    const double form = std::sqrt(across(programmed, arm)[1]);
    held += findings.form.ci95[0] <= form && form <= findings.form.ci95[1];
  }
  std::printf("with a fitted frame: forecast over next pass %.3f, form in %d of %d intervals\n",
              std::sqrt(expected / after), held, kCells);
  EXPECT_NEAR(std::sqrt(expected / after), 1, 0.3);
  EXPECT_GE(held, 6);
}

// A deviation that changes with the place as smoothly as a turn does.
Eigen::Matrix3Xd smooth(const Path& path, double rms, std::mt19937& random) {
  std::normal_distribution<double> unit;
  std::uniform_real_distribution<double> length(0.15, 0.4), phase(0, 2 * std::numbers::pi);
  const auto any = [&] { return Eigen::Vector3d(unit(random), unit(random), unit(random)); };
  Eigen::Matrix3Xd values = Eigen::Matrix3Xd::Zero(3, path.samples());
  for (int wave = 0; wave < 4; ++wave) {
    const Eigen::Vector3d number = 2 * std::numbers::pi / length(random) * any().normalized();
    const double begin = phase(random);
    const Eigen::Vector3d size = any();
    for (Eigen::Index i = 0; i < path.samples(); ++i)
      values.col(i) += std::sin(number.dot(path.position.col(i)) + begin) * size;
  }
  return rms / std::sqrt(values.colwise().squaredNorm().mean()) * values;
}

// What a fitted frame takes up stays; a frame that is turned by the deviation would add to it.
TEST(Mirror, AFittedFrameMakesNoPathWorse) {
  constexpr int kCells = 12;
  const Path programmed = contour();
  std::mt19937 random(3);
  MirrorOptions options;
  options.clock.fit_frame = true;
  double worst = 0, before = 0, after = 0;
  for (int k = 0; k < kCells; ++k) {
    const Eigen::Matrix3Xd arm = smooth(programmed, 0.3e-3, random);
    Path pass = programmed;
    pass.position += arm;
    pass = in_another_frame(std::move(pass), 0.01e-3, random);
    const MirrorResult result = mirror_correct(programmed, {pass}, options);
    const double was = across(programmed, arm)[1];
    const double left = across(programmed, result.correction + arm)[1];
    before += was / kCells;
    after += left / kCells;
    worst = std::max(worst, std::sqrt(left / was));
  }
  std::printf("with a fitted frame: %.3f of %.3f mm (rms) left, at worst %.2f of it\n",
              1e3 * std::sqrt(after), 1e3 * std::sqrt(before), worst);
  EXPECT_LT(worst, 1.05);
}

// What is exact comes back exactly: a step at a corner is not rounded, a reversal not smeared.
TEST(Mirror, StepsAreKept) {
  const plant::Program program = plant::program(plant::Shape::corner);
  plant::Options options = plant::ideal();
  options.period = 0.032;
  options.depth = 0;
  options.reversal_step = {0.3e-3, 0.2e-3};
  options.noise = 0.02e-3;
  const plant::Record record = plant::run(program, program.position, options);
  const MirrorResult result = mirror_correct(path_of(program), {record_of(record)}, {});
  const plant::Record again = plant::run(program, result.position, options);
  // At every sample in motion but the few that a step falls into.
  const Eigen::VectorXd left = plant::distances(program, again.true_position);
  std::vector<double> moving;
  for (Eigen::Index i = 1; i + 1 < left.size(); ++i)
    if (program.position.col(i + 1) != program.position.col(i - 1)) moving.push_back(left[i]);
  std::sort(moving.begin(), moving.end());
  EXPECT_LT(moving[moving.size() * 98 / 100], 0.04e-3);
}

// Two sides of 100 mm that meet at an angle, at constant speed and without a stop.
Path two_sides(double turn) {
  constexpr Eigen::Index kSide = 230;
  Path path;
  path.time = Eigen::VectorXd::LinSpaced(2 * kSide + 1, 0, 0.016 * 2 * kSide);
  path.position.resize(3, 2 * kSide + 1);
  for (Eigen::Index i = 0; i <= 2 * kSide; ++i) {
    const double s = 0.43e-3 * static_cast<double>(i - kSide);
    path.position.col(i) = s < 0 ? Eigen::Vector3d(s, 0, 0)
                                 : Eigen::Vector3d(s * std::cos(turn), s * std::sin(turn), 0);
  }
  return path;
}

// Everywhere the tool is off by as much to its left: the corrected sides are those of the parallel
// lines on the right, and meet in their intersection.
TEST(Mirror, CorrectedSidesMeetInTheirIntersection) {
  constexpr double kOff = 0.8e-3, kStep = 0.43e-3;
  for (const double degrees : {30, 90, -90, 120, 170}) {
    const double turn = degrees * kDegree;
    const Path programmed = two_sides(turn);
    const Eigen::Index corner = programmed.samples() / 2;
    const Eigen::Vector3d before(1, 0, 0), after(std::cos(turn), std::sin(turn), 0);
    const Eigen::Vector3d left = Eigen::Vector3d::UnitZ().cross(before);
    const Eigen::Vector3d left_after = Eigen::Vector3d::UnitZ().cross(after);
    Path measured = programmed;
    for (Eigen::Index i = 0; i < measured.samples(); ++i)
      measured.position.col(i) += kOff * (i <= corner ? left : left_after);
    MirrorOptions options;
    options.clock.offset = 0;
    options.gain = 1;
    const MirrorResult result = mirror_correct(programmed, {measured}, options);
    double largest = 0, off = 0;
    for (Eigen::Index i = 1; i < programmed.samples(); ++i) {
      const Eigen::Vector3d step = result.position.col(i) - result.position.col(i - 1);
      largest = std::max(largest, step.norm());
      const Eigen::Vector3d normal = i <= corner ? left : left_after;
      off = std::max(off, std::abs(normal.dot(result.correction.col(i)) + kOff));
    }
    const bool meets = std::abs(degrees) < 125;
    EXPECT_LT(off, 0.01 * kOff) << degrees;
    if (meets) {
      EXPECT_LT(largest, 1.11 * kStep) << degrees;
      const Eigen::Vector3d wanted = -kOff * (left + std::tan(turn / 2) * -before);
      EXPECT_LT((result.correction.col(corner) - wanted).norm(), 0.02 * kOff) << degrees;
    }
    EXPECT_LT(result.correction.colwise().norm().maxCoeff(), 2.3 * kOff) << degrees;
  }
}

// On the cell, with all that moves the tool there.
TEST(Mirror, ACornerHasNoJump) {
  const plant::Program program = plant::program(plant::Shape::corner);
  double largest = 0;
  for (int k = 0; k < 4; ++k) {
    const Path measured = record_of(plant::run(program, program.position, cell(k)));
    const MirrorResult result = mirror_correct(path_of(program), {measured}, {});
    for (Eigen::Index i = 1; i < program.time.size(); ++i) {
      const bool near = std::abs(program.arc_length[i] - 0.15) < 0.02;
      if (near)
        largest = std::max(largest, (result.position.col(i) - result.position.col(i - 1)).norm());
    }
  }
  EXPECT_LT(largest, 1.2 * 0.027 * 0.016);  // at full speed
}

TEST(Mirror, WithoutDeviationNothingIsCorrected) {
  const plant::Program program = plant::program(plant::Shape::line);
  plant::Options options = plant::ideal();
  options.period = 0.032;
  options.noise = 0.095e-3;
  const MirrorResult result = mirror_correct(
      path_of(program), {record_of(plant::run(program, program.position, options))}, {});
  EXPECT_LT(result.correction.colwise().norm().mean(), 0.03e-3);
}

TEST(Mirror, CorrectsAcrossThePathOnlyAndWithinBounds) {
  const plant::Program program = plant::program(plant::Shape::spiral);
  const Path programmed = path_of(program);
  const Path measured = record_of(plant::run(program, program.position, cell(1)));
  MirrorOptions options;
  options.max = 0.4e-3;
  options.engaged_only = true;
  const MirrorResult result = mirror_correct(programmed, {measured}, options);
  const Eigen::Matrix3Xd tangent = tangents(programmed);
  constexpr double kSpeed = 0.027;  // of the programs [m/s]
  EXPECT_GT(result.clipped, 0);
  EXPECT_GT(result.expected_after, 0.2e-3);  // what may not be corrected stays
  for (Eigen::Index i = 0; i < programmed.samples(); ++i) {
    EXPECT_LT(result.correction.col(i).norm(), 0.4e-3 + 1e-12);
    EXPECT_LT(std::abs(tangent.col(i).dot(result.correction.col(i))), 1e-12);
    // Half a second is more than the entry's ramp and the noise of the force can hide.
    const double length = program.arc_length[i];
    const double early = program.entry - 0.5 * kSpeed, late = program.exit + 0.5 * kSpeed;
    if (length < early || length > late) EXPECT_TRUE(result.correction.col(i).isZero()) << i;
  }
}

// An instrument that starts late and stops early says nothing about the rest.
TEST(Mirror, WhatWasNotRecordedIsNotCorrected) {
  const plant::Program program = plant::program(plant::Shape::arc);
  const Path programmed = path_of(program);
  plant::Options options = cell(1);
  const Path whole = record_of(plant::run(program, program.position, options));
  Path part;
  const Eigen::Index begin = whole.samples() / 4, count = whole.samples() / 2;
  part.time = whole.time.segment(begin, count);
  part.position = whole.position.middleCols(begin, count);
  part.force = whole.force.middleCols(begin, count);
  const auto program_time = [&](Eigen::Index i) {
    return (whole.time[i] - options.clock_offset) / (1 + options.clock_rate);
  };
  const double from = program_time(begin) - 0.1, to = program_time(begin + count - 1) + 0.1;

  MirrorOptions again;
  again.executed = programmed.position.colwise() + Eigen::Vector3d(0, 0, 1e-4);
  for (const MirrorOptions& how : {MirrorOptions{}, again}) {
    const MirrorResult result = mirror_correct(programmed, {part}, how);
    const Eigen::Matrix3Xd& run = how.executed ? *how.executed : programmed.position;
    int outside = 0, inside = 0, corrected = 0;
    for (Eigen::Index i = 1; i + 1 < programmed.samples(); ++i) {
      if (programmed.position.col(i + 1) == programmed.position.col(i - 1)) continue;
      const bool moved = (result.position.col(i) - run.col(i)).norm() > 1e-12;
      if (programmed.time[i] < from || programmed.time[i] > to) {
        ++outside;
        EXPECT_FALSE(moved) << programmed.time[i];
      } else {
        ++inside;
        corrected += moved;
      }
    }
    EXPECT_NEAR(result.unrecorded, outside, 20);  // a fifth of a second
    EXPECT_GT(corrected, 0.95 * inside);
  }
  EXPECT_EQ(mirror_correct(programmed, {whole}, {}).unrecorded, 0);
}

// A ring run through once in 32 ms steps, its deviation a slow wave.
Path ring(Eigen::Index samples) {
  Path path;
  path.time = Eigen::VectorXd::LinSpaced(samples, 0, 0.032 * static_cast<double>(samples - 1));
  path.position.resize(3, samples);
  for (Eigen::Index i = 0; i < samples; ++i) {
    const double angle = 6 * static_cast<double>(i) / static_cast<double>(samples);
    path.position.col(i) << std::cos(angle), std::sin(angle), 0;
  }
  return path;
}

Path waving(Path path, double period, double noise) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0, 1);
  for (Eigen::Index i = 0; i < path.samples(); ++i) {
    path.position(2, i) += 0.5e-3 * std::sin(2 * std::numbers::pi * path.time[i] / period);
    for (int axis = 0; axis < 3; ++axis) path.position(axis, i) += noise * normal(random);
  }
  return path;
}

// Without noise nothing is a jump but what the deviation does not do all the time; each false one
// would cost time and leave a piece too short to smooth.
TEST(Mirror, ASmoothDeviationHasNoBreaks) {
  const Path exact = ring(20000), noisy = ring(3000);
  EXPECT_LE(mirror_correct(exact, {waving(exact, 60, 0)}, {}).deviation.breaks.size(), 2U);
  EXPECT_LE(mirror_correct(exact, {exact}, {}).deviation.breaks.size(), 2U);
  for (const double period : {3.0, 8.0, 30.0})
    EXPECT_LE(mirror_correct(noisy, {waving(noisy, period, 0.02e-3)}, {}).deviation.breaks.size(),
              2U)
        << period;
}

TEST(Mirror, OnlyWhereTheToolCutsNeedsToKnowWhere) {
  const plant::Program program = plant::program(plant::Shape::line);
  plant::Options options = cell(1);
  options.depth = 0;
  const Path air = record_of(plant::run(program, program.position, options));
  MirrorOptions only;
  only.engaged_only = true;
  EXPECT_THAT([&] { mirror_correct(path_of(program), {air}, only); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("record from air to air")));
}

// Without a force the deviation shows the cut, but not where a reversal may have made its step.
TEST(Mirror, AReversalIsNoEntry) {
  const plant::Program program = plant::program(plant::Shape::corner);
  plant::Options options = plant::ideal();
  options.period = 0.032;
  options.noise = 0.02e-3;
  options.reversal_step = {0.4e-3, 0.4e-3};
  const auto found = [&] {
    Path measured = record_of(plant::run(program, program.position, options));
    measured.force.resize(3, 0);
    return mirror_correct(path_of(program), {measured}, {}).deviation.engagement.intervals.size();
  };
  EXPECT_EQ(found(), 0U);
  options.reversal_step = {0, 0};
  options.depth = 0.008;
  EXPECT_EQ(found(), 1U);
}

TEST(Mirror, RefusesACutoffThatTheRecordIsTooSlowFor) {
  const plant::Program program = plant::program(plant::Shape::line);
  const Path measured = record_of(plant::run(program, program.position, cell(1)));
  MirrorOptions options;
  options.cutoff = 20;
  EXPECT_THAT([&] { mirror_correct(path_of(program), {measured}, options); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("samples per second")));
}

TEST(Mirror, RefusesACutoffThatTheRecordIsTooShortFor) {
  const plant::Program program = plant::program(plant::Shape::line);
  const Path measured = record_of(plant::run(program, program.position, cell(1)));
  for (const CorrectionPoints points : {CorrectionPoints::turning, CorrectionPoints::spline})
    for (const double cutoff : {1e-9, 1e-5, 0.05}) {
      MirrorOptions options;
      options.points = points;
      options.cutoff = cutoff;
      EXPECT_THAT([&] { mirror_correct(path_of(program), {measured}, options); },
                  ThrowsMessage<std::invalid_argument>(HasSubstr("it has to be above 0.07")));
      EXPECT_THAT([&] { correct_from_force(path_of(program), program.position, options); },
                  ThrowsMessage<std::invalid_argument>(HasSubstr("it has to be above 0.07")));
    }
}

}  // namespace
}  // namespace armtrue::mirror_test
