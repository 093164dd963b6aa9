// The filter of the mirror correction against the same response by FFT, and the matching of points
// to a path against the nearest of all segments, in one run.

#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>
#include <unsupported/Eigen/FFT>

#include "armtrue/path/low_pass.h"
#include "bench/times.h"
#include "programs/matching.h"

namespace {

using namespace armtrue;
using Eigen::Index;

constexpr int kOrder = 4;
constexpr double kCutoff = 1 / 0.64, kRate = 1 / 0.032;  // [Hz]: the seed paper's

// An hour of deviations.
const Eigen::Matrix3Xd& deviations() {
  static const Eigen::Matrix3Xd samples = [] {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal(0, 0.1e-3);
    Eigen::Matrix3Xd values(3, 112500);
    for (double& value : values.reshaped()) value = normal(random);
    return values;
  }();
  return samples;
}

// As by armtrue::LowPass, but for the ends, where the record goes on as its own beginning.
Eigen::Matrix3Xd filtered_by_fft(const Eigen::Matrix3Xd& samples) {
  const Index n = samples.cols();
  Index length = 1;
  while (length < n) length *= 2;
  const double edge = std::tan(std::numbers::pi * kCutoff / kRate) *
                      std::pow(std::numbers::sqrt2 - 1, -0.5 / kOrder);
  Eigen::VectorXd response(length);
  for (Index k = 0; k < length; ++k)
    response[k] = 1 / (1 + std::pow(std::tan(std::numbers::pi * static_cast<double>(k) /
                                             static_cast<double>(length)) /
                                        edge,
                                    2 * kOrder));
  Eigen::FFT<double> fft;
  Eigen::VectorXd time = Eigen::VectorXd::Zero(length);
  Eigen::VectorXcd frequency;
  Eigen::Matrix3Xd result(3, n);
  for (Index axis = 0; axis < 3; ++axis) {
    time.head(n) = samples.row(axis).transpose();
    time.tail(length - n).setZero();
    fft.fwd(frequency, time);
    frequency.array() *= response.array();
    fft.inv(time, frequency);
    result.row(axis) = time.head(n).transpose();
  }
  return result;
}

// A spiral, and points a tenth of a millimetre off it.
struct Matched {
  Eigen::Matrix3Xd polygon, points;
};

const Matched& matched() {
  static const Matched matched = [] {
    constexpr Index kCount = 5000;
    std::mt19937_64 random(2);
    std::normal_distribution<double> normal(0, 0.1e-3);
    Matched result{Eigen::Matrix3Xd(3, kCount), {}};
    for (Index i = 0; i < kCount; ++i) {
      const double turned = 0.02 * static_cast<double>(i), radius = 0.02 + 0.002 * turned;
      result.polygon.col(i) << radius * std::cos(turned), radius * std::sin(turned), 0.8;
    }
    result.points = result.polygon;
    for (double& value : result.points.reshaped()) value += normal(random);
    return result;
  }();
  return matched;
}

Eigen::VectorXd nearest_of_all(const Eigen::Matrix3Xd& polygon, const Eigen::Matrix3Xd& points) {
  Eigen::VectorXd places(points.cols());
  for (Index i = 0; i < points.cols(); ++i) {
    double least = std::numeric_limits<double>::infinity();
    for (Index k = 0; k + 1 < polygon.cols(); ++k) {
      const Eigen::Vector3d chord = polygon.col(k + 1) - polygon.col(k);
      const Eigen::Vector3d off = points.col(i) - polygon.col(k);
      const double share = std::clamp(chord.dot(off) / chord.squaredNorm(), 0.0, 1.0);
      const double square = (off - share * chord).squaredNorm();
      if (square >= least) continue;
      least = square;
      places[i] = static_cast<double>(k) + share;
    }
  }
  return places;
}

constexpr double kTolerance = 1e-3;  // [m]

void low_pass(benchmark::State& state) {
  const LowPass filter(kOrder, kCutoff, kRate);
  for (auto _ : state) benchmark::DoNotOptimize(filter(deviations()));
}

void fft(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(filtered_by_fft(deviations()));
}

void matching(benchmark::State& state) {
  for (auto _ : state)
    benchmark::DoNotOptimize(places_in_order(matched().polygon, matched().points, kTolerance));
}

void all_segments(benchmark::State& state) {
  for (auto _ : state)
    benchmark::DoNotOptimize(nearest_of_all(matched().polygon, matched().points));
}

BENCHMARK(low_pass)->MinTime(0.5);
BENCHMARK(fft)->MinTime(0.5);
BENCHMARK(matching)->MinTime(0.5);
BENCHMARK(all_segments)->MinTime(0.5);

// Both ways have to give the same, or their times say nothing.
double difference_of_filters() {
  constexpr Index kEnds = 200;
  const Index inner = deviations().cols() - 2 * kEnds;
  return (LowPass(kOrder, kCutoff, kRate)(deviations()) - filtered_by_fft(deviations()))
      .middleCols(kEnds, inner)
      .cwiseAbs()
      .maxCoeff();
}

Index placed_elsewhere() {
  const auto& [polygon, points] = matched();
  const Eigen::VectorXd apart =
      places_in_order(polygon, points, kTolerance) - nearest_of_all(polygon, points);
  return points.cols() - (apart.array().abs() < 1e-6).count();  // no place at all is one of these
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  armtrue_bench::Times times;
  benchmark::RunSpecifiedBenchmarks(&times);
  std::printf(
      "\nfilter: %.1f ms for 3 x %ld samples; FFT takes %.1f times as long, at most %.1g m "
      "apart\n",
      1e-6 * times.nanoseconds("low_pass"), static_cast<long>(deviations().cols()),
      times.ratio("fft", "low_pass"), difference_of_filters());
  std::printf(
      "matching: %.1f ms for %ld points; all segments take %.0f times as long, %ld points "
      "placed elsewhere\n",
      1e-6 * times.nanoseconds("matching"), static_cast<long>(matched().points.cols()),
      times.ratio("all_segments", "matching"), static_cast<long>(placed_elsewhere()));
}
