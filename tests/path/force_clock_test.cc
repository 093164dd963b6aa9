#include "armtrue/path/registration/force_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "plant_pass.h"

namespace armtrue {
namespace {

using testing::HasSubstr;

constexpr double kPlatePeriod = 1e-3;  // [s]

// The force of a pass as a plate records it: a thousand times a second, by another clock, with the
// teeth of the tool in it.
Path plate_of(const plant::Record& record, const plant::Options& options, double ahead,
              std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const double begin = record.true_time[0] + 0.2;
  const double end = record.true_time[record.true_time.size() - 1] - 0.2;
  const auto count = static_cast<Eigen::Index>((end - begin) / kPlatePeriod);
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(
      count, begin, begin + kPlatePeriod * static_cast<double>(count - 1));
  Path plate;
  plate.time = (1 + options.clock_rate) * time.array() + options.clock_offset + ahead;
  plate.force = interpolate(record.true_time, record.true_force, time);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double tooth = 0.4 * std::sin(2 * M_PI * 133 * time[i]);
    plate.force.col(i) *= 1 + tooth;
    for (double& value : plate.force.col(i)) value += options.force_noise * normal(random);
  }
  return plate;
}

Path without_force(const plant::Record& record) {
  Path pass = record_of(record);
  pass.force.resize(3, 0);
  return pass;
}

TEST(ForceClock, IsThatOfThePlateWithItsStandardDeviation) {
  double squares = 0, stated = 0;
  int count = 0, beyond = 0;
  for (const plant::Shape shape : kShapes)
    for (int k = 0; k < 10; ++k) {
      const plant::Options options = cell(k);
      const plant::Program program = plant::program(shape);
      const plant::Record record = run(program, program.position, options);
      const double ahead = -3.1 + 0.7 * k;
      const ForceClock clock =
          fit_force_clock(path_of(program), without_force(record),
                          plate_of(record, options, ahead, 7 + static_cast<std::uint64_t>(k)));
      const double error = clock.offset - ahead;
      EXPECT_LT(std::abs(error), 0.04) << k;
      squares += error * error;
      stated += clock.deviation * clock.deviation;
      beyond += std::abs(error) > 1.96 * clock.deviation;
      ++count;
    }
  // 40 errors tell their RMS to 11 %; a jackknife states too much rather than too little.
  EXPECT_LT(std::sqrt(squares / stated), 1.25);
  EXPECT_GT(std::sqrt(squares / stated), 0.6);
  EXPECT_LE(beyond, 7);
  EXPECT_EQ(count, 40);
}

// The best of the coarse offsets lies 25 ms beside the likeliest, because readings of much noise do
// not tell them apart.
TEST(ForceClock, OfNoisyReadingsIsTheLikeliestOfAll) {
  const plant::Program program = plant::program(plant::Shape::line);
  for (const int k : {7, 10}) {
    plant::Options options = cell(k);
    options.period = 0.016;
    options.noise = 0.3e-3;
    const plant::Record record = run(program, program.position, options);
    const ForceClock clock =
        fit_force_clock(path_of(program), without_force(record),
                        plate_of(record, options, 2, 7 + static_cast<std::uint64_t>(k)));
    EXPECT_NEAR(clock.offset, 2, 0.01) << k;
    EXPECT_GT(clock.deviation, 0.015) << k;
  }
}

TEST(ForceClock, GivesThePassItsForce) {
  const plant::Options options = cell(3);
  const plant::Program program = plant::program(plant::Shape::line);
  const plant::Record record = run(program, program.position, options);
  const Path plate = plate_of(record, options, 11.5, 3);
  const Path executed = path_of(program), pass = without_force(record);
  const Path forced = with_force(executed, pass, fit_clock(executed, pass), plate, {11.5, 0});
  ASSERT_GT(forced.samples(), record.time.size() * 9 / 10);
  const Eigen::VectorXd program_time =
      (forced.time.array() - options.clock_offset) / (1 + options.clock_rate);
  const Eigen::Matrix3Xd truth = interpolate(record.true_time, record.true_force, program_time);
  // The tooth passes 4.3 times in a sample of the instrument, so a third of one is left at most.
  EXPECT_LT(std::sqrt((forced.force - truth).squaredNorm() / static_cast<double>(truth.size())),
            0.03 * std::sqrt(truth.squaredNorm() / static_cast<double>(truth.size())));
}

TEST(ForceClock, IsRefusedWhereNothingTellsIt) {
  const plant::Program program = plant::program(plant::Shape::line);
  const Path executed = path_of(program);
  plant::Options options = cell(1);
  const plant::Record record = run(program, program.position, options);
  const Path pass = without_force(record);
  const auto why = [&](const Path& plate) {
    try {
      fit_force_clock(executed, pass, plate);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  Path plate = plate_of(record, options, 2, 1);
  const Path whole = plate;
  plate.time = whole.time.head(whole.samples() / 2);
  plate.force = whole.force.leftCols(whole.samples() / 2);
  EXPECT_THAT(why(plate), HasSubstr("the force record lasts"));

  // Of another part, which was not cut.
  plate = whole;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (double& value : plate.force.reshaped()) value = normal(random);
  EXPECT_THAT(why(plate), HasSubstr("does not deviate by the force"));

  // A tool that deviates by nothing at all.
  Path exact = pass;
  exact.position =
      position_at(executed, (pass.time.array() - options.clock_offset) / (1 + options.clock_rate));
  try {
    fit_force_clock(executed, exact, whole);
    ADD_FAILURE() << "a clock without a deviation";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("does not deviate by the force"));
  }

  // The same part twice in one record.
  const double length = whole.time[whole.samples() - 1] - whole.time[0] + kPlatePeriod;
  plate.time.resize(2 * whole.samples());
  plate.time << whole.time, whole.time.array() + length;
  plate.force.resize(3, 2 * whole.samples());
  plate.force << whole.force, whole.force;
  EXPECT_THAT(why(plate), HasSubstr("explains the deviation as well"));
}

TEST(ForceClock, IsRefusedIfTheRecordDoesNotCoverTheMotion) {
  const plant::Program program = plant::program(plant::Shape::line);
  const plant::Options options = cell(1);
  const plant::Record record = run(program, program.position, options);
  const Path plate = plate_of(record, options, 0, 1);
  const Path executed = path_of(program), pass = without_force(record);
  EXPECT_THROW(with_force(executed, pass, fit_clock(executed, pass), plate, {5, 0}),
               std::invalid_argument);
}

}  // namespace
}  // namespace armtrue
