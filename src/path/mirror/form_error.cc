#include "armtrue/path/mirror/form_error.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "armtrue/path/mirror/mirror_options.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/intervals.h"
#include "armtrue/statistics/summary.h"
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
constexpr double kShortest = 0.5 / kHighest;  // [s]: what lasts longer is in the form
constexpr double kNoChance = 1e-3;            // that noise stands out anywhere in a pass
constexpr double kMayBelong = 0.1;            // chance of as much in a sample beside

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
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();  // sum of z z', of the form
};

// Noise of the coefficients of some bands of the form.
struct Noise {
  size_t first = 0, end = 0;                       // bands
  Eigen::Matrix2d mean = Eigen::Matrix2d::Zero();  // of z z'
  double count = 0;                                // of coefficients that show it
  double variance() const { return mean.trace(); }
  // Numbers of a coefficient that vary: two, if the noise is the same along both axes.
  double axes() const {
    const double squares = mean.squaredNorm();
    return squares > 0 ? variance() * variance() / squares : 1;
  }
};

class FormSpectrum {
 public:
  void begin_pass() { passes_.emplace_back(); }

  // What stands out at `count` samples, which add() has without it: the difference of the squares.
  void add_outstanding(double power, double count) {
    outstanding_ += power;
    outstanding_count_ += count;
  }

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
    const Noise above{0, bands_.size(), noise_ / noise_count_, noise_count_};
    const std::vector<Noise> slow = slow_noise(above);
    const std::vector<Noise> noises = slow.empty() ? std::vector{above} : slow;
    const double of_sample = above_.count > 0 ? above_.power / above_.count : above.variance();
    const double apart = (outstanding_ - outstanding_count_ * of_sample) / samples_;
    double least_biased = apart, power = 0, square = apart, crossing = 0;
    for (const Noise& noise : noises) {
      for (size_t b = noise.first; b < noise.end; ++b) {
        const Band& band = bands_[b];
        const double own = (band.power - band.count * noise.variance()) / samples_;
        if (b == 0 || std::sqrt(of_noise(noise, b, b + 1)) < kHardlyUncertain * least_biased ||
            stands_out(band, noise))
          least_biased += own;
        power += band.power;
        square += own;
        crossing += (noise.mean * band.squares).trace();
      }
    }
    const Eigen::Matrix2d form = sum_of_form();
    // Variance of a sample along the form.
    const double along = form.trace() > 0 ? crossing / form.trace() : 0;
    const auto squared_ci95 = not_negative_ci95(square, [&](double truth) {
      double variance = 4 * truth * along / samples_;
      for (const Noise& noise : noises) variance += of_noise(noise, noise.first, noise.end);
      const double times = slow.empty() ? pooled(above, power, truth - apart, along) : 1;
      return times * std::sqrt(variance);
    });
    FormError error;
    error.faster = faster(above.axes());
    for (size_t k = 0; k < 2; ++k) error.ci95[k] = std::sqrt(squared_ci95[k]);
    if (slow.empty() && !are_comparable() && may_be_slow(above)) error.ci95[0] = 0;
    // The root of a square of variance 4 form^2 along / n is too small by along / (2 n form).
    error.rms = std::clamp(std::sqrt(std::max(0.0, least_biased + along / samples_)), error.ci95[0],
                           error.ci95[1]);
    return error;
  }

 private:
  // Variance that noise alone gives the square of the form in some bands.
  double of_noise(const Noise& noise, size_t first, size_t end) const {
    double count = 0;
    for (size_t b = first; b < end; ++b) count += bands_[b].count;
    return 2 * count * noise.mean.squaredNorm() * (1 + count / noise.count) / (samples_ * samples_);
  }

  static bool stands_out(const Band& band, const Noise& noise) {
    if (noise.variance() == 0) return band.power > 0;
    return fisher_f_above(band.power / (band.count * noise.variance()), noise.axes() * band.count,
                          noise.axes() * noise.count) < kStandsOut;
  }

  Eigen::Matrix2d sum_of_form() const {
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    for (const Band& band : bands_) sum += band.squares;
    return sum;
  }

  // If this is the truth of the bands, they show the noise as well, by their weight (score).
  // Over the noise that is seen above them.
  double pooled(const Noise& above, double power, double truth, double along) const {
    const double squares = above.mean.squaredNorm();
    if (squares == 0) return 1;
    double count = 0;
    for (const Band& band : bands_) count += band.count;
    truth = std::max(0.0, truth);
    const double weight = count * count / (4 * truth * along * samples_ + 2 * count * squares);
    const double weight_above = above.count / (2 * squares);
    const double shown = std::max(0.0, (power - truth * samples_) / count);
    return (weight * shown / above.variance() + weight_above) / (weight + weight_above);
  }

  // Whether all passes have the same stretches.
  bool are_comparable() const {
    return passes_.size() > 1 && std::ranges::all_of(passes_, [&](const auto& pass) {
             return pass.size() == passes_.front().size();
           });
  }

  // The noise of each band, as passes differ there; bands that few coefficients show together.
  // Nothing if that is no more than the noise above the form, or if there is nothing to compare.
  std::vector<Noise> slow_noise(const Noise& above) const {
    constexpr double kFewest = 8, kMoreByChance = 0.03;
    if (!are_comparable() || above.variance() == 0) return {};
    std::vector<Noise> of_bands(bands_.size());
    for (size_t s = 0; s < passes_.front().size(); ++s) add_differences(s, of_bands);
    std::vector<Noise> slow;
    Noise all;
    for (size_t b = 0; b < of_bands.size(); ++b) {
      if (slow.empty() || slow.back().count >= kFewest) slow.push_back({b, b, all.mean * 0, 0});
      for (Noise* noise : {&slow.back(), &all}) {
        noise->mean += of_bands[b].mean;
        noise->count += of_bands[b].count;
        noise->end = b + 1;
      }
    }
    for (Noise& noise : slow) noise.mean /= std::max(1.0, noise.count);
    all.mean /= std::max(1.0, all.count);
    return fisher_f_above(all.variance() / above.variance(), all.axes() * all.count,
                          above.axes() * above.count) < kMoreByChance
               ? slow
               : std::vector<Noise>();
  }

  // Adds the differences of all passes from their mean in one stretch, without those of the first
  // coefficient: a pass may run aside of the others by an offset, which is no noise.
  void add_differences(size_t stretch, std::vector<Noise>& of_bands) const {
    Eigen::Index count = passes_.front()[stretch].cols();
    for (const auto& pass : passes_) count = std::min(count, pass[stretch].cols());
    Eigen::Matrix2Xd mean = Eigen::Matrix2Xd::Zero(2, count);
    const auto passes = static_cast<double>(passes_.size());
    for (const auto& pass : passes_) mean += pass[stretch].leftCols(count) / passes;
    size_t band = 1;
    for (Eigen::Index first = 1, end = 2; first < count; first = end, end *= 2, ++band) {
      const Eigen::Index last = std::min(end, count);
      for (const auto& pass : passes_) {
        const Eigen::Matrix2Xd apart =
            pass[stretch].middleCols(first, last - first) - mean.middleCols(first, last - first);
        of_bands[band].mean += apart * apart.transpose();
      }
      of_bands[band].count += (passes - 1) * static_cast<double>(last - first);
    }
  }

  // Whether the noise near the form is more than that from sample to sample: then it rises towards
  // slow changes, and may be all of the form.
  bool may_be_slow(const Noise& above) const {
    if (differences_ == 0) return false;
    return fisher_f_above(above.variance() / (differences_ / difference_count_),
                          above.axes() * above.count,
                          above.axes() * kEfficiencyOfDifferences * difference_count_) < kStandsOut;
  }

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
    above_.power += across.squaredNorm() - z.leftCols(of_form).squaredNorm();
    above_.count += n - of_form;
    for (Eigen::Index i = 1; i + 1 < n; ++i)
      differences_ += (across.col(i - 1) - 2 * across.col(i) + across.col(i + 1)).squaredNorm() / 6;
    difference_count_ += n - 2;
    samples_ += n;
    passes_.back().push_back(z.leftCols(of_form));
    size_t band = 0;
    for (int first = 0, end = 1; first < of_form; first = end, end *= 2, ++band) {
      const int count = std::min(end, of_form) - first;
      if (band == bands_.size()) bands_.emplace_back();
      bands_[band].power += z.middleCols(first, count).squaredNorm();
      bands_[band].squares += z.middleCols(first, count) * z.middleCols(first, count).transpose();
      bands_[band].count += count;
    }
  }

  Eigen::Matrix2d noise_ = Eigen::Matrix2d::Zero();  // of z z'
  double noise_count_ = 0, samples_ = 0;
  double outstanding_ = 0, outstanding_count_ = 0;
  Band above_;                                     // all that the form does not have
  double differences_ = 0, difference_count_ = 0;  // squares of second differences, as of a sample
  std::vector<Band> bands_;
  std::vector<std::vector<Eigen::Matrix2Xd>> passes_;  // coefficients of the form, by stretch
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

// Median of each row in a window of `half` samples on either side.
Eigen::Matrix2Xd running_median(const Eigen::Ref<const Eigen::Matrix2Xd>& samples,
                                Eigen::Index half) {
  Eigen::Matrix2Xd result(2, samples.cols());
  for (Eigen::Index i = 0; i < samples.cols(); ++i) {
    const Eigen::Index first = std::max<Eigen::Index>(0, i - half);
    const Eigen::Index count = std::min(samples.cols(), i + half + 1) - first;
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      const Eigen::RowVectorXd near = samples.row(axis).segment(first, count);
      result(axis, i) = median({near.begin(), near.end()});
    }
  }
  return result;
}

// Mean of normal squares from all but the tenth of them that is largest.
double usual_square(const Eigen::RowVectorXd& values) {
  constexpr double kShare = 0.9, kOfAll = 0.6231;
  Eigen::RowVectorXd squares = values.cwiseAbs2();
  const auto count =
      static_cast<Eigen::Index>(std::ceil(kShare * static_cast<double>(values.size())));
  std::nth_element(squares.begin(), squares.begin() + count - 1, squares.end());
  return squares.head(count).mean() / kOfAll;
}

// Squares of each sample over the usual ones of the pass, or of these two seconds if they are
// larger.
Eigen::VectorXd over_usual(const Eigen::Matrix2Xd& samples, double period) {
  constexpr double kNear = 2;  // [s]
  const Eigen::Index n = samples.cols();
  const Eigen::Index length = std::clamp<Eigen::Index>(std::lround(kNear / period), 1, n);
  Eigen::VectorXd over = Eigen::VectorXd::Zero(n);
  for (const auto& row : samples.rowwise()) {
    const double of_all = usual_square(row);
    for (Eigen::Index first = 0; first < n; first += length) {
      const double near = usual_square(row.segment(std::min(first, n - length), length));
      const Eigen::Index count = std::min(length, n - first);
      if (std::max(of_all, near) > 0)
        over.segment(first, count) +=
            row.segment(first, count).cwiseAbs2().transpose() / std::max(of_all, near);
    }
  }
  return over;
}

// Which samples stand out, alone or as the mean of neighbours, with those beside that may belong to
// them.
std::vector<bool> outstanding(const Eigen::Matrix2Xd& apart, double period) {
  const Eigen::Index n = apart.cols();
  std::vector<bool> stands(n);
  if (n == 0) return stands;
  const double most = -2 * std::log(kNoChance / static_cast<double>(n));
  const Eigen::VectorXd alone = over_usual(apart, period);
  for (Eigen::Index length = 1; length < n; length *= 2) {
    if (length > 1 && static_cast<double>(length) * period > kShortest) break;
    Eigen::Matrix2Xd mean = Eigen::Matrix2Xd::Zero(2, n - length + 1);
    for (Eigen::Index k = 0; k < length; ++k) mean += apart.middleCols(k, mean.cols());
    const Eigen::VectorXd over = over_usual(mean, period);
    for (Eigen::Index i = 0; i < over.size(); ++i)
      if (over[i] > most) std::fill_n(stands.begin() + i, length, true);
  }
  const double belongs = -2 * std::log(kMayBelong);
  for (Eigen::Index i = 1; i < n; ++i)
    if (stands[i - 1] && alone[i] > belongs) stands[i] = true;
  for (Eigen::Index i = n - 1; i > 0; --i)
    if (stands[i] && alone[i - 1] > belongs) stands[i - 1] = true;
  return stands;
}

// Adds a pass. A corner begins a piece: there a deviation jumps from side to side, and a jump has
// power above the form. A side with one sample stays with the next one. What stands out at a place
// for a short time has its power far above the form, where it would count as noise.
void add_pass(const Path& programmed, const Eigen::Matrix3Xd& tangent,
              const std::vector<Corner>& corners, const std::vector<AxesAcross>& axes,
              const Path& pass, FormSpectrum& spectrum) {
  const AcrossInMotion across = across_in_motion(programmed, tangent, pass);
  spectrum.begin_pass();
  const double period = median_period(pass);
  const Eigen::Index n = across.deviation.cols();
  Eigen::Matrix2Xd moving(2, n);
  std::vector<Eigen::Index> begins{0};
  size_t corner = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto nearest = across.nearest[static_cast<size_t>(i)];
    bool turned = false;
    for (; corner < corners.size() && corners[corner].last < nearest; ++corner) turned = true;
    if (turned && i - begins.back() > 1) begins.push_back(i);
    moving.col(i) = axes[static_cast<size_t>(nearest)].transpose() * across.deviation.col(i);
  }
  begins.push_back(n);
  Eigen::Matrix2Xd usual(2, n);
  for (size_t k = 1; k < begins.size(); ++k) {
    const Eigen::Index begin = begins[k - 1], length = begins[k] - begin;
    usual.middleCols(begin, length) =
        running_median(moving.middleCols(begin, length), std::lround(2 * kShortest / period));
  }
  const std::vector<bool> stands = outstanding(moving - usual, period);
  for (Eigen::Index i = 0; i < n; ++i)
    if (stands[i]) {
      spectrum.add_outstanding(moving.col(i).squaredNorm() - usual.col(i).squaredNorm(), 1);
      moving.col(i) = usual.col(i);
    }
  for (size_t k = 1; k < begins.size(); ++k)
    spectrum.add(moving.middleCols(begins[k - 1], begins[k] - begins[k - 1]), period);
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
