#include "armtrue/path/samples/bad_samples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <numeric>
#include <random>
#include <set>

#include "armtrue/path/mirror/mirror.h"
#include "kinematics/six_axes.h"
#include "plant_pass.h"
#include "support/thinned.h"

namespace armtrue::bad_samples_test {
namespace {

using Eigen::Index;

Path pass_of(plant::Shape shape, const plant::Options& options) {
  const plant::Program program = plant::program(shape);
  return record_of(plant::run(program, program.position, options));
}

std::vector<Index> samples_of(const std::vector<BadSample>& bad) {
  std::vector<Index> samples;
  for (const BadSample& b : bad) samples.push_back(b.sample);
  return samples;
}

// With what the deviations show besides.
std::vector<Index> bad_in(const Path& programmed, const Path& pass) {
  return samples_of(mirror_correct(programmed, {pass}, {}).passes[0].bad);
}

// A record with bad samples at random places, runs of one to three.
struct Spoiled {
  Path path;
  std::vector<Index> bad;
};

// `size` is how far off, in a random direction; 0 writes zeros.
// Those of two runs side by side would be one longer run.
Spoiled spoil(const Path& clean, int runs, double size, std::mt19937_64& random) {
  constexpr Index kBetween = 3;
  Spoiled spoiled{clean, {}};
  std::set<Index> bad;
  std::normal_distribution<double> normal;
  for (int run = 0; run < runs; ++run) {
    const Index length = std::uniform_int_distribution<Index>(1, 3)(random);
    const Index first = std::uniform_int_distribution<Index>(0, clean.samples() - length)(random);
    Eigen::Vector3d direction(normal(random), normal(random), normal(random));
    direction.normalize();
    const auto near = bad.lower_bound(first - kBetween);
    if (near != bad.end() && *near < first + length + kBetween) continue;
    for (Index i = first; i < first + length; ++i) {
      if (size > 0)
        spoiled.path.position.col(i) = clean.position.col(i) + size * direction;
      else
        spoiled.path.position.col(i).setZero();
      if (clean.has_force()) spoiled.path.force.col(i).setConstant(1e4);
      bad.insert(i);
    }
  }
  spoiled.bad.assign(bad.begin(), bad.end());
  return spoiled;
}

// Nothing in a pass without bad samples looks like one: not the tool's engagement, reversals, stops
// and corners, however quiet or loud the instrument is. Of 160 passes none in 50 would be bad, or
// one is seen in 96 %; of the 80 of the ordinary run in 80 %.
TEST(BadSamples, ThereAreNoneInCleanPasses) {
  for (const plant::Shape shape : {plant::Shape::line, plant::Shape::arc, plant::Shape::corner,
                                   plant::Shape::spiral, plant::Shape::pocket})
    for (int seed = 0; seed < 8 / thinned(2); ++seed)
      for (const double noise : {0.0, 0.01e-3, 0.095e-3, 0.5e-3}) {
        plant::Options options = cell(seed);
        options.pass_seed = 1000 + static_cast<std::uint64_t>(seed);
        options.noise = noise;
        options.period = seed % 4 == 3 ? 0.1 : 0.032;
        options.reversal_step = {0.3e-3 + 0.02e-3 * seed, 0.2e-3};
        options.ramp = seed % 2 == 0 ? 0.004 : 0.0005;
        options.depth = 0.008 * (1 + seed % 3);
        const Path pass = pass_of(shape, options);
        EXPECT_THAT(find_bad_samples(path_of(plant::program(shape)), pass), ::testing::IsEmpty())
            << static_cast<int>(shape) << ' ' << seed << ' ' << noise;
        if (seed % 4 == 1) {
          EXPECT_THAT(bad_in(path_of(plant::program(shape)), pass), ::testing::IsEmpty())
              << static_cast<int>(shape) << ' ' << seed << ' ' << noise;
        }
      }
}

// What departs and stays is what a tool, a part or a tripod may do.
TEST(BadSamples, AStepThatStaysIsNone) {
  const Path programmed = path_of(plant::program(plant::Shape::arc));
  std::mt19937_64 random(3);
  for (const double size : {0.5e-3, 1e-3, 3e-3, 10e-3, 30e-3})
    for (int trial = 0; trial < 40; ++trial) {
      Path pass = pass_of(plant::Shape::arc, cell(trial));
      const Index at = std::uniform_int_distribution<Index>(10, pass.samples() - 10)(random);
      pass.position.rightCols(pass.samples() - at).colwise() += Eigen::Vector3d(0, 0.6, 0.8) * size;
      EXPECT_THAT(find_bad_samples(programmed, pass), ::testing::IsEmpty()) << size << ' ' << at;
    }
}

// A sharp corner without a stop, and a stitch out and back within two samples, which is programmed.
TEST(BadSamples, WhatIsProgrammedIsNone) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  for (const double turn : {0.5, 1.57, 2.5, 3.14}) {
    Path path;
    path.time = Eigen::VectorXd::LinSpaced(400, 0, 399 * 0.032);
    path.position = Eigen::Matrix3Xd::Zero(3, 400);
    for (Index i = 1; i < 400; ++i) {
      const double angle = i <= 200 ? 0 : turn;
      path.position.col(i) =
          path.position.col(i - 1) + 4e-3 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    }
    for (const Index stitch : {100, 150, 300}) path.position(2, stitch) -= 5e-3;
    Path pass = path;
    for (auto sample : pass.position.colwise())
      sample += 0.05e-3 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    EXPECT_THAT(find_bad_samples(path, pass), ::testing::IsEmpty()) << turn;
    // Whoever only measures it, without the program, cannot know.
    Path straight = path;
    for (const Index stitch : {100, 150, 300}) straight.position(2, stitch) = 0;
    EXPECT_THAT(samples_of(find_bad_samples(straight, pass)), ::testing::ElementsAre(100, 150, 300))
        << turn;
  }
}

TEST(BadSamples, AreFoundWhateverTheirSize) {
  std::mt19937_64 random(5);
  for (const double size : {3e-3, 10e-3, 30e-3, 200e-3, 400e-3, 0.0}) {
    int placed = 0, found = 0, more = 0;
    for (const plant::Shape shape : kShapes) {
      const Path programmed = path_of(plant::program(shape));
      for (const int k : {0, 2, 5}) {
        const Path clean = pass_of(shape, cell(k));
        const Spoiled spoiled = spoil(clean, 1 + k, size, random);
        const std::vector<Index> bad = bad_in(programmed, spoiled.path);
        placed += static_cast<int>(spoiled.bad.size());
        for (const Index i : bad) {
          const bool right = std::binary_search(spoiled.bad.begin(), spoiled.bad.end(), i);
          found += right;
          more += !right;
        }
      }
    }
    std::printf("%3.0f mm off: %d of %d found, %d more\n", 1e3 * size, found, placed, more);
    EXPECT_GE(found, 0.99 * placed) << size;
    EXPECT_LE(more, 0.01 * placed) << size;
  }
}

// A step of 10 mm is just possible in the direction of the feed, and not against it: what lies
// between two such runs is good.
TEST(BadSamples, BetweenStepsThatAreJustPossibleAllIsGood) {
  const Path programmed = path_of(plant::program(plant::Shape::arc));
  const Path clean = pass_of(plant::Shape::arc, cell(1));
  for (const Index length : {1, 2, 3})
    for (const double first : {-10.4e-3, 10.4e-3})
      for (const double second : {-10.4e-3, 10.4e-3}) {
        Path pass = clean;
        std::vector<Index> bad;
        for (Index k = 0; k < length; ++k) bad.push_back(160 + k);
        for (Index k = 0; k < length; ++k) bad.push_back(260 + k);
        for (const Index i : bad)
          pass.position.col(i) +=
              (i < 200 ? first : second) *
              (clean.position.col(i + 1) - clean.position.col(i - 1)).normalized();
        EXPECT_EQ(bad_in(programmed, pass), bad) << length << ' ' << first << ' ' << second;
      }
}

// The tracker loses the reflector for a while, shows zeros or another reflector, and finds it.
TEST(BadSamples, ALostLockMayLast) {
  const Path programmed = path_of(plant::program(plant::Shape::spiral));
  const Path clean = pass_of(plant::Shape::spiral, cell(2));
  for (const Eigen::Vector3d& other : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1.4, -0.2, 0.9)})
    for (const Index first : {0, 200, clean.samples() - 30}) {
      Path pass = clean;
      pass.position.middleCols(first, 30).colwise() = other;
      const std::vector<BadSample> bad = find_bad_samples(programmed, pass);
      if (first == 200 || other.isZero()) {
        ASSERT_EQ(bad.size(), 30U) << first;
        EXPECT_EQ(bad.front().sample, first);
        EXPECT_NEAR(bad[15].off, (clean.position.col(first + 15) - other).norm(), 15e-3);
      } else {
        EXPECT_THAT(bad, ::testing::IsEmpty());  // nobody knows which of the two is the tool
      }
    }
}

TEST(BadSamples, TooManyAreFoundAndSaidToBe) {
  const Path programmed = path_of(plant::program(plant::Shape::arc));
  std::mt19937_64 random(6);
  for (const double size : {0.0, 10e-3, 200e-3})
    for (const int runs : {60, 100}) {
      const Spoiled spoiled = spoil(pass_of(plant::Shape::arc, cell(1)), runs, size, random);
      EXPECT_TRUE(too_many(find_bad_samples(programmed, spoiled.path), spoiled.path))
          << size << ' ' << runs;
    }
  EXPECT_FALSE(too_many({}, programmed));
}

TEST(BadSamples, AllColumnsGo) {
  Path path = pass_of(plant::Shape::line, cell(0));
  path.orientation = path.force;
  path.q.setConstant(kJoints, path.samples(), 1);
  const Path rest = without(path, {{3, 1}, {7, 1}});
  EXPECT_EQ(rest.samples(), path.samples() - 2);
  EXPECT_EQ(rest.time[3], path.time[4]);
  EXPECT_EQ(rest.force.col(6), path.force.col(8));
  EXPECT_EQ(rest.orientation.col(6), path.orientation.col(8));
  EXPECT_EQ(rest.q.cols(), rest.samples());
}

// The correction is that of the clean pass: nearer to it than that of another pass over the same
// part is. A departure of 1 mm may stay, where the program itself turns or stops as suddenly.
TEST(BadSamples, TheCorrectionIsThatOfTheCleanPass) {
  const int trials = 4 / thinned(2);
  std::mt19937_64 random(7);
  for (const plant::Shape shape : kShapes) {
    const Path programmed = path_of(plant::program(shape));
    const auto correction = [&](const Path& pass) {
      return Eigen::Matrix3Xd(mirror_correct(programmed, {pass}, {}).correction);
    };
    std::vector<Path> clean;
    std::vector<Eigen::Matrix3Xd> of_clean;
    double usual = 0, usual_worst = 0;
    for (int k = 0; k < trials; ++k) {
      clean.push_back(pass_of(shape, cell(k)));
      of_clean.push_back(correction(clean.back()));
      plant::Options other = cell(k);
      other.pass_seed += 500;  // the same part once more: the noise of a correction
      const Eigen::VectorXd noise =
          (correction(pass_of(shape, other)) - of_clean.back()).colwise().norm();
      usual += noise.mean() / trials;
      usual_worst = std::max(usual_worst, noise.maxCoeff());
    }
    for (const double size : {1e-3, 3e-3, 10e-3, 200e-3, 400e-3, 0.0}) {
      double mean = 0, worst = 0;
      for (int k = 0; k < trials; ++k) {
        const Spoiled spoiled = spoil(clean[k], 3, size, random);
        const Eigen::VectorXd off = (correction(spoiled.path) - of_clean[k]).colwise().norm();
        mean += off.mean() / trials;
        worst = std::max(worst, off.maxCoeff());
      }
      std::printf("%3.0f mm, shape %d: mean %.4f worst %.3f mm; another pass %.4f, %.3f\n",
                  1e3 * size, static_cast<int>(shape), 1e3 * mean, 1e3 * worst, 1e3 * usual,
                  1e3 * usual_worst);
      EXPECT_LT(mean, usual) << size << ' ' << static_cast<int>(shape);
      if (size != 1e-3)
        EXPECT_LT(worst, usual_worst + 0.1e-3) << size << ' ' << static_cast<int>(shape);
    }
  }
}

// --- An instrument that hangs repeats its last reading while time goes on.

Path frozen(Path pass, Index first, Index repeats) {
  pass.position.middleCols(first + 1, repeats).colwise() =
      Eigen::Vector3d(pass.position.col(first));
  return pass;
}

Path rounded(Path pass, double resolution) {
  pass.position = (pass.position / resolution).array().round() * resolution;
  return pass;
}

// A side of 60 mm out and one back at 60 deg, with a stop between and at both ends; a rapid
// approach of 200 mm comes first.
Path program_with_rapid(double feed, double rapid, double period, double side = 0.06) {
  constexpr double kAcceleration = 0.5;  // [m/s^2]
  struct Move {
    Eigen::Vector3d to;
    double speed;
  };
  const Eigen::Vector3d corner(0.2 + side, 0, 0);
  const std::array moves{Move{{0.2, 0, 0}, rapid}, Move{corner, feed},
                         Move{corner + side * Eigen::Vector3d(-0.5, 0.87, 0), feed}};
  std::vector<Eigen::Vector3d> places(static_cast<size_t>(1 / period), Eigen::Vector3d::Zero());
  for (const Move& move : moves) {
    const Eigen::Vector3d from = places.back();
    const double length = (move.to - from).norm();
    const double ramp = move.speed / kAcceleration;
    const double total = length / move.speed + ramp;
    const auto place = [&](double t) {
      if (t <= ramp) return 0.5 * kAcceleration * t * t;
      return move.speed * (t - 0.5 * ramp);
    };
    for (double t = period; t < total; t += period)
      places.push_back(from + (move.to - from) / length *
                                  (t < total / 2 ? place(t) : length - place(total - t)));
    places.insert(places.end(), static_cast<size_t>(0.6 / period), move.to);
  }
  Path path;
  const auto count = static_cast<Index>(places.size());
  path.time = Eigen::VectorXd::LinSpaced(count, 0, period * static_cast<double>(count - 1));
  path.position.resize(3, count);
  for (Index i = 0; i < count; ++i) path.position.col(i) = places[static_cast<size_t>(i)];
  return path;
}

// The program as an instrument shows it: beside it by a slow deviation, later by its clock.
Path seen(const Path& programmed, double noise, double period = 0) {
  Path pass = programmed;
  if (period > 0) {
    const double end = programmed.time[programmed.samples() - 1];
    const auto count = static_cast<Index>(end / period);
    pass.time = Eigen::VectorXd::LinSpaced(count, 0, period * static_cast<double>(count - 1));
    pass.position = position_at(programmed, pass.time);
  }
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal(0, 1);
  for (Index i = 0; i < pass.samples(); ++i)
    pass.position.col(i) +=
        noise * Eigen::Vector3d(normal(random), normal(random), normal(random)) +
        0.3e-3 * std::sin(pass.position(0, i) / 0.02) * Eigen::Vector3d(0, 0.6, 0.8);
  pass.time.array() += 0.4;
  return pass;
}

// All that are off by more than a millimetre, and none but those that repeat.
TEST(BadSamples, FrozenReadingsAreFound) {
  std::mt19937_64 random(8);
  int far = 0, found = 0, more = 0;
  for (const plant::Shape shape : kShapes)
    for (const Index repeats : {2, 4, 10, 25})
      for (int k = 0; k < 3; ++k) {
        const Path clean = pass_of(shape, cell(k));
        const Index first = std::uniform_int_distribution<Index>(20, clean.samples() - 60)(random);
        const std::vector<Index> bad =
            bad_in(path_of(plant::program(shape)), frozen(clean, first, repeats));
        for (const Index i : bad) more += i <= first || i > first + repeats;
        for (Index i = first + 1; i <= first + repeats; ++i) {
          const bool is_far = (clean.position.col(i) - clean.position.col(first)).norm() > 1e-3;
          far += is_far;
          found += is_far && std::binary_search(bad.begin(), bad.end(), i);
        }
      }
  std::printf("frozen: %d of %d found, %d more\n", found, far, more);
  EXPECT_GE(found, 0.97 * far);
  EXPECT_LE(more, 0.005 * far);
}

// With one or two hangs, exactly the rows of them; the second is not taken for the way back of the
// first.
TEST(BadSamples, LongAndRepeatedHangsLeaveTheRestAlone) {
  const Path programmed = path_of(plant::program(plant::Shape::spiral));
  for (const double noise : {0.0, 0.095e-3}) {
    plant::Options options = cell(2);
    options.noise = noise;
    options.lost = 0;
    const Path clean = pass_of(plant::Shape::spiral, options);
    const Path once = frozen(clean, 150, 30), twice = frozen(once, 300, 30);
    std::vector<Index> rows(30);
    std::iota(rows.begin(), rows.end(), 151);
    EXPECT_EQ(bad_in(programmed, once), rows) << noise;
    for (Index i = 301; i <= 330; ++i) rows.push_back(i);
    EXPECT_EQ(bad_in(programmed, twice), rows) << noise;
  }
}

// What the program does elsewhere, at ten times the feed, hides no hang in the cut.
TEST(BadSamples, AHangInTheFeedOfAProgramWithRapidsIsFound) {
  const Path programmed = program_with_rapid(0.02, 0.2, 0.016);
  const Path clean = seen(programmed, 0.02e-3);
  const Index first = 250;  // in the first side
  for (const Index repeats : {8, 30}) {
    const MirrorResult result = mirror_correct(programmed, {frozen(clean, first, repeats)}, {});
    const std::vector<Index> bad = samples_of(result.passes[0].bad);
    EXPECT_GE(static_cast<Index>(bad.size()), repeats - 2);
    for (const Index i : bad) EXPECT_TRUE(i > first && i <= first + repeats) << i;
    EXPECT_NEAR(result.passes[0].clock.offset, 0.4, 5e-3);
  }
}

// Repeats are readings where the tool stands, however exactly, and of an instrument that rounds. It
// shows up to 500 readings of one place at the lower feed.
TEST(BadSamples, RepeatsThatTheToolExplainsAreNone) {
  for (const double feed : {2e-3, 20e-3})
    for (const double resolution : {0.001e-3, 0.01e-3, 0.1e-3, 1e-3})
      for (const double noise : {0.0, 0.05e-3, 0.3e-3}) {
        const Path programmed = program_with_rapid(feed, 0.1, 0.016, feed < 5e-3 ? 0.015 : 0.06);
        const Path pass = rounded(seen(programmed, noise, 0.001), resolution);
        EXPECT_THAT(find_bad_samples(programmed, pass), ::testing::IsEmpty())
            << feed << ' ' << resolution << ' ' << noise;
        EXPECT_THAT(bad_in(programmed, pass), ::testing::IsEmpty())
            << feed << ' ' << resolution << ' ' << noise;
      }
}

// Nor at the stops of a slow instrument: the tool may be up to speed at its next sample.
TEST(BadSamples, StopsOfASlowInstrumentAreNone) {
  const Path programmed = program_with_rapid(0.05, 0.2, 0.016);
  for (const double period : {0.016, 0.05, 0.1, 0.15}) {
    const Path pass = seen(programmed, 0, period);
    EXPECT_THAT(bad_in(programmed, pass), ::testing::IsEmpty()) << period;
    EXPECT_THAT(bad_in(programmed, rounded(pass, 0.01e-3)), ::testing::IsEmpty()) << period;
    MirrorOptions late;  // a clock that is off by less than a sample
    late.clock.offset = 0.4 + 0.3 * period;
    EXPECT_THAT(mirror_correct(programmed, {pass}, late).passes[0].bad, ::testing::IsEmpty())
        << period;
  }
}

// A hang that begins while the tool stands: what was read at standstill is none of it.
TEST(BadSamples, AHangThatOutlastsAStopSparesTheStop) {
  const Path programmed = program_with_rapid(0.05, 0.05, 0.016);
  const Path clean = seen(programmed, 0);
  const Path pass = frozen(clean, 40, 40);  // motion begins at sample 63
  const std::vector<Index> bad = bad_in(programmed, pass);
  ASSERT_FALSE(bad.empty());
  for (const Index i : bad)
    EXPECT_GT((clean.position.col(i) - clean.position.col(40)).norm(), 0.2e-3);
  EXPECT_EQ(bad.back(), 80);
}

// A recorder that asks ten times as often as the instrument measures, and one hang of 0.6 s in it.
TEST(BadSamples, AReadingThatIsHeldUntilTheNextIsNone) {
  const Path programmed = path_of(plant::program(plant::Shape::arc));
  Path pass = pass_of(plant::Shape::arc, cell(1));
  Path held;
  held.time = Eigen::VectorXd::LinSpaced(10 * pass.samples(), 0,
                                         pass.time[pass.samples() - 1] - pass.time[0]);
  held.time.array() += pass.time[0];
  held.position.resize(3, held.time.size());
  Index shown = 0;
  for (Index i = 0; i < held.time.size(); ++i) {
    while (shown + 1 < pass.samples() && pass.time[shown + 1] <= held.time[i]) ++shown;
    held.position.col(i) = pass.position.col(shown);
  }
  EXPECT_THAT(find_bad_samples(programmed, held), ::testing::IsEmpty());
  const std::vector<Index> bad = samples_of(find_bad_samples(programmed, frozen(held, 2000, 190)));
  EXPECT_GE(bad.size(), 160U);
  for (const Index i : bad) EXPECT_TRUE(i > 1990 && i <= 2200) << i;
}

}  // namespace
}  // namespace armtrue::bad_samples_test
