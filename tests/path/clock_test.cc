#include "armtrue/path/registration/clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>

#include "armtrue/kinematics/units.h"
#include "path/registration/unit_check.h"
#include "plant_pass.h"

namespace armtrue::clock_test {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// Of the middle of the record, where the fit states it; a constant lag belongs to the offset.
double offset_error(const ClockFit& fit, const plant::Record& record,
                    const plant::Options& options) {
  const double middle =
      (0.5 * (record.time[0] + record.time[record.time.size() - 1]) - options.clock_offset) /
      (1 + options.clock_rate);
  return fit.offset + fit.rate * middle - options.clock_offset - options.lag -
         options.clock_rate * middle;
}

TEST(Clock, AnIdealRecordGivesItsClockBack) {
  for (const plant::Shape shape : kShapes) {
    const plant::Program program = plant::program(shape);
    plant::Options options = plant::ideal();
    options.clock_offset = 12.3456;
    options.clock_rate = 80e-6;
    options.period = 0.032;
    const plant::Record record = plant::run(program, program.position, options);
    const ClockFit fit = fit_clock(path_of(program), record_of(record));
    EXPECT_NEAR(fit.offset, options.clock_offset, 2e-4);
    EXPECT_NEAR(fit.rate, options.clock_rate, 2e-5);
  }
}

// Cutting forces, reversals, a servo that lags, noise: the offset lies within its uncertainty.
TEST(Clock, TheOffsetIsWithinItsStatedUncertainty) {
  int runs = 0, within = 0;
  double largest = 0;
  for (const plant::Shape shape : kShapes) {
    const plant::Program program = plant::program(shape);
    for (int k = 0; k < 12; ++k) {
      plant::Options options = cell(k);
      options.repeatability = 0.03e-3;
      const plant::Record record = plant::run(program, program.position, options);
      const ClockFit fit = fit_clock(path_of(program), record_of(record));
      ++runs;
      within += std::abs(offset_error(fit, record, options)) < 1.96 * fit.offset_deviation();
      largest = std::max(largest, 1.96 * fit.offset_deviation());
    }
  }
  EXPECT_GE(within, 43) << "of " << runs;  // 45.6 expected; 5 misses have a chance of 8 %
  EXPECT_LT(largest, 15e-3);
}

// What a clock that is a bit off makes of the deviations, to first order.
TEST(Clock, ItsErrorsMoveTheRecordAlongThePath) {
  constexpr double kHour = 36000;  // of the day: nothing may depend on it
  Path programmed = path_of(plant::program(plant::Shape::arc));
  programmed.time.array() += kHour;
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(51, kHour + 2, kHour + 17);
  Eigen::Matrix2d covariance;
  covariance << 4e-6, -1e-7, -1e-7, 2.25e-8;
  const auto errors = clock_errors(programmed, times, covariance);
  const Eigen::Matrix2d root = covariance.llt().matrixL();
  for (const Eigen::Index i : {0, 20, 50}) {
    Eigen::Matrix3d expected = Eigen::Matrix3d::Zero(), stated = expected;
    for (int k = 0; k < 2; ++k) {
      const double late = root(0, k) + root(1, k) * (times[i] - times[25]);
      const auto at = [&](double time) -> Eigen::Vector3d {
        return position_at(programmed, Eigen::VectorXd::Constant(1, time));
      };
      const Eigen::Vector3d moved = at(times[i]) - at(times[i] - late);
      expected += moved * moved.transpose();
      stated +=
          errors[static_cast<size_t>(k)].col(i) * errors[static_cast<size_t>(k)].col(i).transpose();
    }
    EXPECT_LT((stated - expected).norm(), 0.02 * expected.norm()) << i;
  }
  for (const Eigen::Matrix3Xd& error : clock_errors(programmed, times, Eigen::Matrix2d::Zero()))
    EXPECT_TRUE(error.isZero(0));
}

// Two hours at 100 ppm: the clocks drift apart by more than any deviation.
TEST(Clock, ALongRecordIsFollowedThroughItsDrift) {
  Path programmed;
  constexpr Eigen::Index n = 60000;
  constexpr double kPeriod = 0.12, kLap = 23, kRate = 100e-6, kOffset = 4.5;
  programmed.time = Eigen::VectorXd::LinSpaced(n, 0, kPeriod * (n - 1));
  programmed.position = Eigen::Matrix3Xd::Zero(3, n);
  Path measured = programmed;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = programmed.time[i], phase = std::fmod(t, kLap) / kLap;
    programmed.position(0, i) = 0.6 * std::abs(phase - 0.5);  // to and fro
    programmed.position(1, i) = 1e-4 * t;
    measured.time[i] = (1 + kRate) * t + kOffset;
  }
  measured.position = programmed.position;
  const ClockFit fit = fit_clock(programmed, measured);
  EXPECT_NEAR(fit.rate, kRate, 1e-6);
  EXPECT_NEAR(fit.offset + fit.rate * programmed.time[n / 2],
              kOffset + kRate * programmed.time[n / 2], 5e-3);
}

TEST(Clock, AFrameIsFittedOnRequest) {
  const plant::Program program = plant::program(plant::Shape::spiral);
  const plant::Options options = cell(3);
  const plant::Record record = plant::run(program, program.position, options);
  const Pose instrument_from_program{rotation_from_abc(0.3, -0.1, 0.05), {0.5, -0.2, 1}};
  Path measured = record_of(record);
  measured.position = (instrument_from_program.rotation * measured.position).colwise() +
                      instrument_from_program.translation;
  measured.force.resize(3, 0);
  EXPECT_THAT([&] { fit_clock(path_of(program), measured); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("--fit-frame")));
  ClockOptions with_frame;
  with_frame.fit_frame = true;
  const ClockFit fit = fit_clock(path_of(program), measured, with_frame);
  EXPECT_LT(std::abs(offset_error(fit, record, options)), 3 * fit.offset_deviation());
  const Eigen::Vector3d centre = program.position.rowwise().mean();
  EXPECT_LT((fit.program_from_instrument * (instrument_from_program * centre) - centre).norm(),
            1e-3);
}

// An arm that deviates would turn the frame, and x, y, z are those of the origin, 1.6 m away.
TEST(Clock, AForeignFrameIsNamed) {
  const plant::Program program = plant::program(plant::Shape::corner);
  const plant::Record record = plant::run(program, program.position, plant::ideal());
  Path measured = record_of(record);
  measured.position.colwise() += Eigen::Vector3d(0, 0.1, 0);
  EXPECT_THAT([&] { fit_clock(path_of(program), measured); },
              ThrowsMessage<std::invalid_argument>(ContainsRegex(", y -(99|100)[.]")));
}

TEST(Clock, RefusesWhatHasNoInformation) {
  const plant::Program program = plant::program(plant::Shape::line);
  const Path programmed = path_of(program);
  const plant::Record record = plant::run(program, program.position, plant::Options());
  Path measured = record_of(record);

  Path standing = measured;
  standing.position = programmed.position.col(0).replicate(1, measured.samples());
  EXPECT_THAT([&] { fit_clock(programmed, standing); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("the measured path stands still")));
  Path parked = programmed;
  parked.position.colwise() = Eigen::Vector3d(1, 0, 0);
  EXPECT_THAT([&] { fit_clock(parked, measured); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("the programmed path stands still")));

  Path metres = measured;
  metres.position *= 1e-3;
  EXPECT_THAT([&] { fit_clock(programmed, metres); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("in m where the column says mm")));

  ClockOptions apart;
  apart.offset = 1000;
  EXPECT_THAT([&] { fit_clock(programmed, measured, apart); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("do not overlap in time")));
}

// A stretch at constant speed, read in a frame of its own: any offset goes with some frame.
TEST(Clock, RefusesARecordThatFitsAnywhere) {
  const plant::Program program = plant::program(plant::Shape::line);
  const plant::Record record = plant::run(program, program.position, plant::Options());
  const Path all = record_of(record);
  Path middle;
  const Eigen::Index begin = all.samples() / 3, count = all.samples() / 3;
  middle.time = all.time.segment(begin, count);
  middle.position = all.position.middleCols(begin, count);
  ClockOptions with_frame;
  with_frame.fit_frame = true;
  EXPECT_THAT([&] { fit_clock(path_of(program), middle, with_frame); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("does not show how the clocks lie")));
}

// A part of the pass, or one that waits for long, is no other unit.
// A tool that lies off along a straight path at rest and in motion shows the clock by both.
TEST(Clock, AConstantDeviationAlongThePathIsNoBlunder) {
  Path programmed;
  programmed.time = Eigen::VectorXd::LinSpaced(601, -2, 10);
  programmed.position = Eigen::Matrix3Xd::Zero(3, 601);
  for (Eigen::Index i = 0; i < 601; ++i)
    programmed.position(0, i) =
        0.15 - 0.15 * std::cos(M_PI * std::clamp(programmed.time[i] / 6.5, 0., 1.));
  for (const double along : {0.1e-3, 0.3e-3, -0.5e-3, 1e-3}) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal(0, 0.03e-3);
    Path measured = programmed;
    for (double& part : measured.position.reshaped()) part += normal(random);
    measured.position.colwise() += Eigen::Vector3d(along, 0.2e-3, 0);
    const ClockFit fit = fit_clock(programmed, measured);
    EXPECT_LT(fit.offset_deviation(), 1e-3) << along;
    EXPECT_LT(std::abs(fit.offset), 3 * fit.offset_deviation()) << along;
  }
}

TEST(Clock, NamesTimesInAnotherUnit) {
  const plant::Program program = plant::program(plant::Shape::arc);
  const Path programmed = path_of(program);
  const Path whole = record_of(plant::run(program, program.position, cell(1)));
  Path part = whole;
  part.time = whole.time.segment(100, 150).eval();
  part.position = whole.position.middleCols(100, 150).eval();
  part.force.resize(3, 0);
  for (const Path& record : {whole, part}) {
    EXPECT_NO_THROW(check_units(programmed, record));
    for (const auto& [factor, named] : {std::pair{1e3,
                                                  "measured path: its clock seems to count "
                                                  "milliseconds"},
                                        {1e6, "microseconds"},
                                        {1e-3, "programmed path: its times seem to be milli"}}) {
      Path other = record;
      other.time *= factor;
      EXPECT_THAT([&] { fit_clock(programmed, other); },
                  ThrowsMessage<std::invalid_argument>(HasSubstr(named)));
    }
  }
  Path waiting = whole;  // an hour
  waiting.time[waiting.samples() - 1] += 3600;
  EXPECT_NO_THROW(check_units(programmed, waiting));
}

}  // namespace
}  // namespace armtrue::clock_test
