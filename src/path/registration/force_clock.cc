#include "armtrue/path/registration/force_clock.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "path/registration/formatted.h"

namespace armtrue {
namespace {

// [s], by the clock of the record that they are of.
struct Span {
  double begin = 0, end = 0;
  double length() const { return end - begin; }
};

Span span_of(const Path& path) { return {path.time[0], path.time[path.samples() - 1]}; }

// When the tool moves, by the clock of the pass.
Span motion_of(const Path& executed, const Path& pass, const ClockFit& clock) {
  Eigen::Index first = 0, last = executed.samples() - 1;
  const auto stands = [&](Eigen::Index i) {
    return (executed.position.col(i + 1) - executed.position.col(i)).norm() <= kStandstill;
  };
  while (first < last && stands(first)) ++first;
  while (last > first && stands(last - 1)) --last;
  const auto instrument_time = [&](Eigen::Index i) {
    return clock.offset + (1 + clock.rate) * executed.time[i];
  };
  const Span recorded = span_of(pass);
  return {std::max(instrument_time(first), recorded.begin),
          std::min(instrument_time(last), recorded.end)};
}

// The integral of a record is a polygon's, so its mean over a window about a time is a difference.
// Constant before the first sample and after the last.
class RunningMean {
 public:
  RunningMean(const Path& force, double window)
      : time_(force.time.size() + 2), integral_(3, force.time.size() + 2), window_(window) {
    const double far = force.time[force.samples() - 1] - force.time[0] + 2 * window;
    const Eigen::Index n = force.samples();
    time_ << force.time[0] - far, force.time, force.time[n - 1] + far;
    integral_.col(0).setZero();
    integral_.col(1) = far * force.force.col(0);
    for (Eigen::Index i = 1; i < n; ++i)
      integral_.col(i + 1) = integral_.col(i) + (force.time[i] - force.time[i - 1]) / 2 *
                                                    (force.force.col(i) + force.force.col(i - 1));
    integral_.col(n + 1) = integral_.col(n) + far * force.force.col(n - 1);
  }

  Eigen::Matrix3Xd at(const Eigen::VectorXd& times) const {
    return (interpolate(time_, integral_, times.array() + window_ / 2) -
            interpolate(time_, integral_, times.array() - window_ / 2)) /
           window_;
  }

 private:
  Eigen::VectorXd time_;
  Eigen::Matrix3Xd integral_;
  double window_;
};

// The force without its teeth, which the instrument does not show and samples of it would take for
// slow changes: the mean over a window, twice, on an even grid.
Path smoothed(const Path& force, double window) {
  constexpr double kPerWindow = 8;
  const Span known = span_of(force);
  const auto count = static_cast<Eigen::Index>(std::ceil(known.length() / window * kPerWindow)) + 1;
  Path result;
  result.time = Eigen::VectorXd::LinSpaced(count, known.begin, known.end);
  result.force = RunningMean(force, window).at(result.time);
  result.force = RunningMean(result, window).at(result.time);
  return result;
}

// What the deviation of the tool says of an offset.
class OffsetFit {
 public:
  // Deviations across the path, one column for each of the times of the instrument.
  OffsetFit(Eigen::VectorXd times, const Eigen::Matrix3Xd& deviation)
      : times_(std::move(times)), beside_(2, times_.size()) {
    beside_.row(0).setConstant(1 / std::sqrt(static_cast<double>(times_.size())));
    const Eigen::RowVectorXd centred = times_.transpose().array() - times_.mean();
    beside_.row(1) = centred / centred.norm();
    deviation_ = without_beside(deviation);
  }

  // Sum of the squares that the force at this offset leaves [m^2].
  double left(const Path& force, double offset) const {
    return residuals(force, offset).squaredNorm();
  }

  double numbers() const { return static_cast<double>(deviation_.size()); }
  double unforced() const { return deviation_.squaredNorm(); }

  Eigen::Matrix3Xd residuals(const Path& force, double offset) const {
    const Eigen::Matrix3Xd f =
        without_beside(interpolate(force.time, force.force, times_.array() + offset));
    Eigen::Matrix3d power = f * f.transpose();
    if (!(power.trace() > 0)) return deviation_;
    // Along directions without a force the compliance is zero.
    power.diagonal().array() += 1e-9 * power.trace();
    return deviation_ - deviation_ * f.transpose() * power.ldlt().solve(f);
  }

 private:
  Eigen::Matrix3Xd without_beside(const Eigen::Matrix3Xd& values) const {
    return values - values * beside_.transpose() * beside_;
  }

  Eigen::VectorXd times_;
  Eigen::Matrix2Xd beside_;  // constant and drift, orthonormal
  Eigen::Matrix3Xd deviation_;
};

// The share of independent residuals among n: (1 - r) / (1 + r), with their correlation r from
// sample to sample.
double independent_share(const Eigen::Matrix3Xd& residuals) {
  const Eigen::Index n = residuals.cols();
  const double power = residuals.squaredNorm();
  const double next = residuals.leftCols(n - 1).cwiseProduct(residuals.rightCols(n - 1)).sum();
  const double r = power > 0 ? std::clamp(next / power, 0.0, 0.99) : 0;
  return (1 - r) / (1 + r);
}

constexpr Eigen::Index kBlocks = 10;

// Sums of the squares of as many parts of a record, one after another.
Eigen::VectorXd sums_of_blocks(const Eigen::Matrix3Xd& residuals) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(kBlocks);
  for (Eigen::Index i = 0; i < residuals.cols(); ++i)
    sums[i * kBlocks / residuals.cols()] += residuals.col(i).squaredNorm();
  return sums;
}

Path at_columns(const Path& path, const std::vector<Eigen::Index>& kept) {
  Path some;
  some.time = path.time(kept);
  some.position = path.position(Eigen::all, kept);
  if (path.has_orientation()) some.orientation = path.orientation(Eigen::all, kept);
  if (path.has_joints()) some.q = path.q(Eigen::all, kept);
  return some;
}

std::vector<Eigen::Index> within(const Path& path, const Span& span) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < path.samples(); ++i)
    if (path.time[i] >= span.begin && path.time[i] <= span.end) kept.push_back(i);
  return kept;
}

// Measured minus executed, without the part along the path, at the samples of the pass.
Eigen::Matrix3Xd deviation_across(const Path& executed, const Path& pass, const ClockFit& clock) {
  const Path measured = registered(pass, clock);
  Eigen::Matrix3Xd deviation = measured.position - position_at(executed, measured.time);
  const Eigen::Matrix3Xd velocity = velocity_at(executed, measured.time);
  for (Eigen::Index i = 0; i < deviation.cols(); ++i)
    if (const double speed = velocity.col(i).norm(); speed > 0) {
      const Eigen::Vector3d along = velocity.col(i) / speed;
      deviation.col(i) -= along.dot(deviation.col(i)) * along;
    }
  return deviation;
}

std::string remedy(const std::string& record) {
  return record +
         ", or state --force-offset-s, the time by which the clock of the force record is "
         "ahead of the instrument's";
}

}  // namespace

ForceClock fit_force_clock(const Path& executed, const Path& pass, const Path& force,
                           const ClockOptions& options) {
  const ClockFit clock = fit_clock(executed, pass, options);
  const Span moves = motion_of(executed, pass, clock), known = span_of(force);
  // The record covers the motion at all offsets from first to last.
  const Span offsets{known.begin - moves.begin, known.end - moves.end};
  if (offsets.length() < 0)
    throw std::invalid_argument("the force record lasts " + formatted("%.3g s", known.length()) +
                                ", and the tool moves for " + formatted("%.3g s", moves.length()) +
                                ": take the record of this pass, from air to air");
  constexpr double kAir = 1;  // [s] of standstill before and after the motion
  const std::vector<Eigen::Index> kept = within(pass, {moves.begin - kAir, moves.end + kAir});
  const Path part = at_columns(pass, kept);
  const Eigen::Matrix3Xd deviation = deviation_across(executed, part, clock);
  const double period = median_period(part);
  // Only samples that the force record covers count: a force that is assumed beyond its ends would
  // be a step.
  const auto fit_of = [&](const Span& covered, Eigen::Index stride) {
    std::vector<Eigen::Index> some;
    for (Eigen::Index i = 0; i < part.samples(); i += stride)
      if (part.time[i] >= covered.begin && part.time[i] <= covered.end) some.push_back(i);
    return OffsetFit(part.time(some), deviation(Eigen::all, some));
  };

  // A coarse search over all offsets, with the force averaged over a step of it.
  constexpr double kMostSteps = 4000, kMostSamples = 2000;
  const double step = std::max(period / 2, offsets.length() / kMostSteps);
  const auto stride = static_cast<Eigen::Index>(std::ceil(part.samples() / kMostSamples));
  const Path slow = smoothed(force, std::max(period, step));
  const auto steps = static_cast<Eigen::Index>(std::floor(offsets.length() / step)) + 1;
  const auto coarse_offset = [&](Eigen::Index k) {
    return offsets.begin + step * static_cast<double>(k);
  };
  Eigen::VectorXd gain(steps);  // n ln(S without force / S) of samples as if all were independent
  for (Eigen::Index k = 0; k < steps; ++k) {
    const double at = coarse_offset(k);
    const OffsetFit fit = fit_of({known.begin - at, known.end - at}, stride);
    gain[k] = fit.numbers() * std::log(fit.unforced() / fit.left(slow, at));
  }
  Eigen::Index best = 0;
  gain.maxCoeff(&best);

  // Fine, about the best.
  const Path mean = smoothed(force, period);
  const double fine = period / 16;
  const double about = coarse_offset(best);
  const auto side = static_cast<int>(std::ceil(2 * step / fine));
  const OffsetFit fit =
      fit_of({known.begin - about + fine * side, known.end - about - fine * side}, 1);
  Eigen::MatrixXd of_blocks(kBlocks, 2 * side + 1);  // of each block, at each fine offset
  for (int k = -side; k <= side; ++k)
    of_blocks.col(k + side) = sums_of_blocks(fit.residuals(mean, about + fine * k));
  const Eigen::VectorXd rest = of_blocks.colwise().sum().transpose();
  Eigen::Index at = 0;
  const double least = rest.minCoeff(&at);
  const auto offset = [&](Eigen::Index k) { return about + fine * static_cast<double>(k - side); };

  // Twice the fall of the log likelihood is n ln S's rise, with the independent n.
  const double independent = independent_share(fit.residuals(mean, offset(at)));
  const auto fall = [&](double more) {
    return independent * fit.numbers() * std::log(more / least);
  };
  const double kCertain = 2 * std::log(1000.0);  // odds of a thousand
  constexpr double kOfUnknowns = 2 * 9;          // the compliance explains some of any noise
  if (!(fall(fit.unforced()) >= kCertain + kOfUnknowns))  // nor where the tool does not deviate
    throw std::invalid_argument("the tool does not deviate by the force of the record: " +
                                remedy("check that it is of this pass"));
  // Beyond the valley of this offset, another that is a thousandth as likely or more.
  const auto behind = [&](Eigen::Index k) {
    return independent * static_cast<double>(stride) * (gain[best] - gain[k]);
  };
  Eigen::Index first = best, last = best;
  while (first > 0 && behind(first) < 2 * kCertain) --first;
  while (last + 1 < steps && behind(last) < 2 * kCertain) ++last;
  for (Eigen::Index k = 0; k < steps; ++k)
    if ((k < first || k > last) && behind(k) < kCertain)
      throw std::invalid_argument(
          "the force record explains the deviation as well " + formatted("%.3f s", offset(at)) +
          " ahead of the instrument as " + formatted("%.3f s: ", coarse_offset(k)) +
          remedy("take a pass in which the force changes otherwise each time"));

  // By the noise: n ln S rises by 1.
  Eigen::Index low = at, high = at;
  while (low > 0 && fall(rest[low]) < 1) --low;
  while (high + 1 < rest.size() && fall(rest[high]) < 1) ++high;
  const double by_noise = (offset(high) - offset(low)) / 2;
  // Jackknife: the offset without each block. What force and drift do not explain, such as
  // backlash, moves the offset too, and the noise of the samples says nothing of it.
  Eigen::VectorXd others(kBlocks);
  for (Eigen::Index block = 0; block < kBlocks; ++block) {
    Eigen::Index k = 0;
    (rest - of_blocks.row(block).transpose()).minCoeff(&k);
    others[block] = offset(k);
  }
  const double scatter = (others.array() - others.mean()).square().sum() * (kBlocks - 1) / kBlocks;
  const ForceClock found{offset(at), std::max(by_noise, std::sqrt(scatter))};
  if (at == 0 || at + 1 == rest.size() || found.deviation >= kMaxOffsetSigma)
    throw std::invalid_argument(
        "the deviation of the pass does not show the clock of the force record: " +
        remedy("take a pass whose force changes, from air to air"));
  return found;
}

Path with_force(const Path& executed, const Path& pass, const ClockFit& of_pass, const Path& force,
                const ForceClock& clock) {
  const Span known = span_of(force);
  const Span covered{known.begin - clock.offset, known.end - clock.offset};
  const Span moves = motion_of(executed, pass, of_pass);
  const double period = median_period(pass);
  if (covered.begin > moves.begin + period || covered.end < moves.end - period)
    throw std::invalid_argument("the force record covers " + formatted("%.3f s", covered.begin) +
                                formatted(" to %.3f s", covered.end) +
                                " by the clock of the instrument, and the tool moves " +
                                formatted("from %.3f s", moves.begin) +
                                formatted(" to %.3f s", moves.end) +
                                ": take the record of this pass, or check --force-offset-s");
  Path result = at_columns(pass, within(pass, covered));
  const Path mean = smoothed(force, period);
  result.force = of_pass.program_from_instrument.rotation.transpose() *
                 interpolate(mean.time, mean.force, result.time.array() + clock.offset);
  return result;
}

}  // namespace armtrue
