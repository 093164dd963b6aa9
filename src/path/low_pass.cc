#include "armtrue/path/low_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <stdexcept>

namespace armtrue {
namespace {

constexpr double kMaxCutoff = 0.45;  // of a single run, over the sample rate

// Value at `at` of the straight line fitted to samples 0, 1, 2, ...
double line_at(const Eigen::VectorXd& samples, double at) {
  const auto n = static_cast<double>(samples.size());
  const double mean = samples.mean();
  if (samples.size() < 3) return mean;
  const Eigen::VectorXd place =
      Eigen::VectorXd::LinSpaced(samples.size(), -(n - 1) / 2, (n - 1) / 2);
  return mean + place.dot(samples) / place.squaredNorm() * (at - (n - 1) / 2);
}

}  // namespace

LowPass::LowPass(int order, double cutoff, double sample_rate)
    : sample_rate_(sample_rate), cutoff_(cutoff) {
  if (order < 1 || order > 12)
    throw std::invalid_argument("the order of the filter has to be between 1 and 12");
  // Two runs of |H|^2 = 1 / (1 + (w / w1)^(2 n)) give 1 / sqrt 2 at w1 (sqrt 2 - 1)^(1/(2 n)).
  const double widening = std::pow(std::numbers::sqrt2 - 1, -0.5 / order);
  if (!(cutoff > 0) || !(cutoff * widening < kMaxCutoff * sample_rate)) {
    std::array<char, 160> message{};
    std::snprintf(message.data(), message.size(),
                  "a cut-off of %.4g Hz does not go with %.4g samples per second; it has to be "
                  "below %.4g Hz",
                  cutoff, sample_rate, kMaxCutoff * sample_rate / widening);
    throw std::invalid_argument(message.data());
  }
  const double analog = std::tan(std::numbers::pi * cutoff / sample_rate) * widening;
  // Pairs of poles of the prototype, made digital by the bilinear transform; an odd order has a
  // real pole besides.
  for (int pair = 0; pair < order / 2; ++pair) {
    const double angle = std::numbers::pi * (2 * pair + 1) / (2 * order);
    const double damping = 2 * std::sin(angle);
    const double square = analog * analog;
    const double a0 = 1 + damping * analog + square;
    sections_.push_back({square / a0, 2 * square / a0, square / a0, 2 * (square - 1) / a0,
                         (1 - damping * analog + square) / a0});
  }
  if (order % 2 == 1)
    sections_.push_back(
        {analog / (1 + analog), analog / (1 + analog), 0, (analog - 1) / (1 + analog), 0});
}

// One run, in the steady state of the first sample.
void LowPass::run(Eigen::Matrix3Xd& samples) const {
  // Direct form II, transposed. Three channels go side by side: a single one would wait for its own
  // last result.
  struct State {
    Eigen::Array3d first, second;
  };
  std::vector<State> states;
  for (const Section& s : sections_)
    states.push_back({samples.col(0).array() * (1 - s.b0), samples.col(0).array() * (s.b2 - s.a2)});
  for (auto column : samples.colwise()) {
    Eigen::Array3d value = column.array();
    for (size_t k = 0; k < sections_.size(); ++k) {
      const Section& s = sections_[k];
      const Eigen::Array3d in = value;
      value = s.b0 * in + states[k].first;
      states[k].first = s.b1 * in - s.a1 * value + states[k].second;
      states[k].second = s.b2 * in - s.a2 * value;
    }
    column = value;
  }
}

Eigen::MatrixXd LowPass::operator()(const Eigen::MatrixXd& samples) const {
  const Eigen::Index n = samples.cols();
  const auto settled = static_cast<Eigen::Index>(std::ceil(5 * sample_rate_ / cutoff_));
  const auto fitted = std::min<Eigen::Index>(
      n, std::max<Eigen::Index>(4, static_cast<Eigen::Index>(0.5 * sample_rate_ / cutoff_)));
  Eigen::MatrixXd result(samples.rows(), n);
  for (Eigen::Index channel = 0; channel < samples.rows(); channel += 3) {
    const Eigen::Index count = std::min<Eigen::Index>(3, samples.rows() - channel);
    const auto in = samples.middleRows(channel, count);
    Eigen::VectorXd begin(count), end(count);
    for (Eigen::Index k = 0; k < count; ++k) {
      begin[k] = line_at(in.row(k).head(fitted).transpose(), 0);
      end[k] = line_at(in.row(k).tail(fitted).transpose(), static_cast<double>(fitted - 1));
    }
    Eigen::Matrix3Xd padded = Eigen::Matrix3Xd::Zero(3, n + 2 * settled);
    auto used = padded.topRows(count);
    used.middleCols(settled, n) = in;
    for (Eigen::Index k = 1; k <= settled; ++k) {  // beyond a short record its far end stands still
      used.col(settled - k) = 2 * begin - in.col(std::min(k, n - 1));
      used.col(settled + n - 1 + k) = 2 * end - in.col(std::max<Eigen::Index>(n - 1 - k, 0));
    }
    run(padded);
    padded.rowwise().reverseInPlace();
    run(padded);
    result.middleRows(channel, count) = used.rowwise().reverse().middleCols(settled, n);
  }
  return result;
}

double LowPass::noise_share() const {
  // The response of both passes is |H|^2, its square |H|^4; the mean over frequency by rectangles.
  constexpr int kSteps = 4096;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) {
    const std::complex<double> z = std::polar(1.0, -std::numbers::pi * (k + 0.5) / kSteps);
    double response = 1;
    for (const Section& s : sections_)
      response *= std::norm((s.b0 + s.b1 * z + s.b2 * z * z) / (1.0 + s.a1 * z + s.a2 * z * z));
    sum += response * response;
  }
  return sum / kSteps;
}

}  // namespace armtrue
