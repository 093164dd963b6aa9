#include "armtrue/path/mirror/form_error.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "armtrue/path/mirror/mirror_options.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/intervals.h"
#include "path/mirror/corners.h"
#include "path/mirror/mean_deviation.h"

namespace armtrue {
namespace {

// Of the form [Hz]: twice the cut-off of the seed paper, beyond which its correction follows
// nothing. Of a step, 99 % of the power lies below.
constexpr double kHighest = 2 * kPaperCutoff;
constexpr int kNoiseBand = 2;              // up to this multiple of it: noise near the form
constexpr double kLongestStretch = 20;     // [s]: 125 coefficients of the form
constexpr double kStandsOut = 1e-3;       // chance of as much power in a band by noise
// Of white noise: of n samples the mean square of second differences is as uncertain as that of
// this share of n. With covariances 6, -4 and 1: 36 / (36 + 2 (16 + 1)).
constexpr double kEfficiencyOfDifferences = 0.514;
constexpr double kHardlyUncertain = 0.1;  // of the square of the bands below

// The first `count` coefficients of the orthonormal cosine transform of each row.
Eigen::Matrix2Xd cosine_transform(const Eigen::Ref<const Eigen::Matrix2Xd>& samples,
                                  Eigen::Index count) {
  const auto n = static_cast<double>(samples.cols());
  Eigen::MatrixX2d sum = Eigen::MatrixX2d::Zero(count, 2);
  for (int i = 0; i < samples.cols(); ++i) {
    const double angle = std::numbers::pi * (i + 0.5) / n;
    const double twice = 2 * std::cos(angle);
    double before = twice / 2, cosine = 1;  // of -1 and 0 times the angle
    for (Eigen::Index k = 0; k < count; ++k) {
      sum.row(k) += cosine * samples.col(i).transpose();
      const double next = twice * cosine - before;
      before = cosine;
      cosine = next;
    }
  }
  sum *= std::sqrt(2 / n);
  sum.row(0) /= std::numbers::sqrt2;
  return sum.transpose();
}

// Coefficients of a band of frequencies, from all stretches.
struct Band {
  double power = 0;  // sum of |z|^2
  double count = 0;
};

class FormSpectrum {
 public:
  // A deviation across the path in one piece.
  void add(const Eigen::Ref<const Eigen::Matrix2Xd>& across, double period) {
    const double duration = period * static_cast<double>(across.cols());
    const auto stretches =
        std::max<Eigen::Index>(1, static_cast<Eigen::Index>(std::ceil(duration / kLongestStretch)));
    for (Eigen::Index s = 0; s < stretches; ++s) {
      const Eigen::Index first = s * across.cols() / stretches;
      const Eigen::Index end = (s + 1) * across.cols() / stretches;
      add_stretch(across.middleCols(first, end - first), period);
    }
  }

  FormError form() const {
    if (noise_count_ == 0)
      throw std::invalid_argument("form error: fewer than two samples in motion");
    const Eigen::Matrix2d noise = noise_ / noise_count_;
    const double squares = noise.squaredNorm(), variance = noise.trace();
    // The square of the form in `count` coefficients, and its standard deviation from noise alone.
    const auto square = [&](const Band& band) {
      return (band.power - band.count * variance) / samples_;
    };
    const auto from_noise = [&](double count) {
      return std::sqrt(2 * count * squares * (1 + count / noise_count_)) / samples_;
    };
    Band all;
    double least_biased = 0;
    // Numbers of a coefficient that vary: two, if the noise is the same along both axes.
    const double axes = squares > 0 ? variance * variance / squares : 1;
    const auto stands_out = [&](const Band& band) {
      if (variance == 0) return band.power > 0;
      const double ratio = band.power / (band.count * variance);
      return fisher_f_above(ratio, axes * band.count, axes * noise_count_) < kStandsOut;
    };
    for (size_t b = 0; b < bands_.size(); ++b) {
      if (b == 0 || from_noise(bands_[b].count) < kHardlyUncertain * least_biased ||
          stands_out(bands_[b]))
        least_biased += square(bands_[b]);
      all.power += bands_[b].power;
      all.count += bands_[b].count;
    }
    // Variance of a sample along the form.
    const double along = form_.trace() > 0 ? (noise * form_).trace() / form_.trace() : 0;
    const auto squared_ci95 = not_negative_ci95(square(all), [&](double truth) {
      const double crossed = 4 * truth * along * samples_, own = 2 * all.count * squares;
      if (own == 0) return std::sqrt(crossed) / samples_;
      // If this is the truth, the band of the form shows the noise as well, by its weight (score).
      const double weight = all.count * all.count / (crossed + own);
      const double weight_above = noise_count_ / (2 * squares);
      const double shown = std::max(0.0, (all.power - truth * samples_) / all.count);
      const double pooled = (weight * shown + weight_above * variance) / (weight + weight_above);
      return pooled / variance * std::hypot(std::sqrt(crossed) / samples_, from_noise(all.count));
    });
    FormError error;
    error.faster = faster(axes);
    for (size_t k = 0; k < 2; ++k) error.ci95[k] = std::sqrt(squared_ci95[k]);
    // The root of a square of variance 4 form^2 along / n is too small by along / (2 n form).
    error.rms = std::clamp(std::sqrt(std::max(0.0, least_biased + along / samples_)), error.ci95[0],
                           error.ci95[1]);
    return error;
  }

 private:
  // See FormError. `axes`: numbers of a coefficient that vary.
  double faster(double axes) const {
    if (differences_ == 0 || above_.count == 0) return 0;
    const double of_sample = differences_ / difference_count_;
    const double ratio = above_.power / (above_.count * of_sample);
    if (fisher_f_above(ratio, axes * above_.count,
                       axes * kEfficiencyOfDifferences * difference_count_) >= kStandsOut)
      return 0;
    return std::sqrt((above_.power - above_.count * of_sample) / samples_);
  }

  void add_stretch(const Eigen::Ref<const Eigen::Matrix2Xd>& across, double period) {
    const auto n = static_cast<int>(across.cols());
    if (n < 2) return;
    // Coefficient k has the frequency k / (2 n period).
    const double highest = 2 * kHighest * period * n;
    const int of_form = std::clamp(static_cast<int>(highest) + 1, 1, n / 2);
    const int of_noise = std::min(kNoiseBand * of_form, n) - of_form;
    const Eigen::Matrix2Xd z = cosine_transform(across, of_form + of_noise);
    noise_ += z.rightCols(of_noise) * z.rightCols(of_noise).transpose();
    noise_count_ += of_noise;
    form_ += z.leftCols(of_form) * z.leftCols(of_form).transpose();
    above_.power += across.squaredNorm() - z.leftCols(of_form).squaredNorm();
    above_.count += n - of_form;
    for (Eigen::Index i = 1; i + 1 < n; ++i)
      differences_ += (across.col(i - 1) - 2 * across.col(i) + across.col(i + 1)).squaredNorm() / 6;
    difference_count_ += n - 2;
    samples_ += n;
    size_t band = 0;
    for (int first = 0, end = 1; first < of_form; first = end, end *= 2, ++band) {
      const int count = std::min(end, of_form) - first;
      if (band == bands_.size()) bands_.emplace_back();
      bands_[band].power += z.middleCols(first, count).squaredNorm();
      bands_[band].count += count;
    }
  }

  Eigen::Matrix2d noise_ = Eigen::Matrix2d::Zero(), form_ = Eigen::Matrix2d::Zero();  // of z z'
  double noise_count_ = 0, samples_ = 0;
  Band above_;                                     // all that the form does not have
  double differences_ = 0, difference_count_ = 0;  // squares of second differences, as of a sample
  std::vector<Band> bands_;
};

using AxesAcross = Eigen::Matrix<double, 3, 2>;

// Two unit vectors across the path at each sample, which turn with it and not about it: noise that
// is the same along x, y and z is the same along both, wherever the path leads.
std::vector<AxesAcross> axes_across(const Eigen::Matrix3Xd& tangent) {
  constexpr double kReversal = 1e-9;  // 1 + cosine: which way it turns is rounding
  const Eigen::Vector3d first = tangent.col(0).unitOrthogonal();
  AxesAcross axes;
  axes << first, tangent.col(0).cross(first);
  std::vector<AxesAcross> all{axes};
  for (Eigen::Index i = 1; i < tangent.cols(); ++i) {
    const Eigen::Vector3d turn = tangent.col(i - 1).cross(tangent.col(i));
    const double cosine = tangent.col(i - 1).dot(tangent.col(i));
    for (auto axis : axes.colwise())
      if (1 + cosine > kReversal)
        axis = (cosine * axis + turn.cross(axis) + turn.dot(axis) / (1 + cosine) * turn).eval();
    all.push_back(axes);
  }
  return all;
}

// Adds a pass. A corner begins a piece: there a deviation jumps from side to side, and a jump has
// power above the form. A side with one sample stays with the next one.
void add_pass(const Path& programmed, const Eigen::Matrix3Xd& tangent,
              const std::vector<Corner>& corners, const std::vector<AxesAcross>& axes,
              const Path& pass, FormSpectrum& spectrum) {
  const AcrossInMotion across = across_in_motion(programmed, tangent, pass);
  const double period = median_period(pass);
  Eigen::Matrix2Xd moving(2, across.deviation.cols());
  Eigen::Index begin = 0;
  size_t corner = 0;
  for (Eigen::Index i = 0; i < moving.cols(); ++i) {
    const auto nearest = across.nearest[static_cast<size_t>(i)];
    bool turned = false;
    for (; corner < corners.size() && corners[corner].last < nearest; ++corner) turned = true;
    if (turned && i - begin > 1) {
      spectrum.add(moving.middleCols(begin, i - begin), period);
      begin = i;
    }
    moving.col(i) = axes[static_cast<size_t>(nearest)].transpose() * across.deviation.col(i);
  }
  spectrum.add(moving.rightCols(moving.cols() - begin), period);
}

}  // namespace

FormError form_error(const Path& programmed, const std::vector<Path>& passes) {
  const std::vector<Corner> corners = find_corners(programmed);
  const Eigen::Matrix3Xd tangent = side_tangents(programmed, corners);
  const std::vector<AxesAcross> axes = axes_across(tangent);
  FormSpectrum spectrum;
  for (const Path& pass : passes) add_pass(programmed, tangent, corners, axes, pass, spectrum);
  return spectrum.form();
}

FormError with_frame(const FormError& form, const FrameError& frame) {
  if (frame.mean_square == 0) return form;
  const double square = form.rms * form.rms, of_frame = 1.96 * frame.form_deviation;
  const double below = std::hypot(square - form.ci95[0] * form.ci95[0], of_frame);
  const double above = std::hypot(form.ci95[1] * form.ci95[1] - square, of_frame);
  return {form.rms,
          {std::sqrt(std::max(0.0, square - below)), std::sqrt(square + frame.mean_square + above)},
          form.faster};
}

std::optional<FormReduction> form_reduction(const FormError& before, const FormError& after) {
  if (before.rms == 0) return std::nullopt;
  const double ratio = after.rms / before.rms;
  FormReduction reduction{1 - ratio, {}};
  if (before.ci95[0] == 0) return reduction;
  // A form of zero has no logarithm: its upper end stands for it.
  const double size = after.rms > 0 ? after.rms : after.ci95[1];
  const auto log_apart = [](double a, double b) { return b > 0 ? std::log(a / b) : INFINITY; };
  const double less = std::hypot(log_apart(size, after.ci95[0]), log_apart(before.ci95[1], before.rms));
  const double more = std::hypot(log_apart(after.ci95[1], size), log_apart(before.rms, before.ci95[0]));
  const double of_size = size / before.rms;
  reduction.ci95 = {1 - of_size * std::exp(more), 1 - of_size * std::exp(-less)};
  return reduction;
}

}  // namespace armtrue
