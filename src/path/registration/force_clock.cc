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

const double kCertain = 2 * std::log(1000.0);  // of odds of a thousand

// How far the tool deviates across the path while it moves, in the samples of the instrument.
class MovingDeviation {
 public:
  MovingDeviation(const Path& executed, const Path& pass, const ClockFit& clock,
                  const Span& moves) {
    constexpr double kAir = 1;  // [s] of standstill before and after the motion
    const Path part = at_columns(pass, within(pass, {moves.begin - kAir, moves.end + kAir}));
    time_ = part.time;
    deviation_ = deviation_across(executed, part, clock);
    period_ = median_period(part);
  }

  Eigen::Index samples() const { return time_.size(); }
  double period() const { return period_; }  // s

  // Only samples that the force record covers count: a force that is assumed beyond its ends would
  // be a step.
  OffsetFit fit(const Span& covered, Eigen::Index stride) const {
    std::vector<Eigen::Index> some;
    for (Eigen::Index i = 0; i < samples(); i += stride)
      if (time_[i] >= covered.begin && time_[i] <= covered.end) some.push_back(i);
    return OffsetFit(time_(some), deviation_(Eigen::all, some));
  }

 private:
  Eigen::VectorXd time_;
  Eigen::Matrix3Xd deviation_;
  double period_ = 0;
};

// All offsets, with the force averaged over a step.
struct CoarseSearch {
  double first = 0, step = 0;  // s
  Eigen::Index stride = 1;     // of the samples
  Eigen::VectorXd gain;        // n ln(S without force / S) of samples as if all were independent
  Eigen::Index best = 0;

  double offset(Eigen::Index k) const { return first + step * static_cast<double>(k); }
};

CoarseSearch search_all(const MovingDeviation& deviation, const Path& force, const Span& known,
                        const Span& offsets) {
  constexpr double kMostSteps = 4000, kMostSamples = 2000;
  CoarseSearch search;
  search.first = offsets.begin;
  search.step = std::max(deviation.period() / 2, offsets.length() / kMostSteps);
  search.stride =
      static_cast<Eigen::Index>(std::ceil(static_cast<double>(deviation.samples()) / kMostSamples));
  const Path slow = smoothed(force, std::max(deviation.period(), search.step));
  search.gain.resize(static_cast<Eigen::Index>(std::floor(offsets.length() / search.step)) + 1);
  for (Eigen::Index k = 0; k < search.gain.size(); ++k) {
    const double at = search.offset(k);
    const OffsetFit fit = deviation.fit({known.begin - at, known.end - at}, search.stride);
    search.gain[k] = fit.numbers() * std::log(fit.unforced() / fit.left(slow, at));
  }
  search.gain.maxCoeff(&search.best);
  return search;
}

// Offsets about the best of a coarse search.
struct FineSearch {
  double about = 0, step = 0;  // s
  int side = 0;                // steps on either side
  Eigen::MatrixXd of_blocks;   // sum of squares of each block, at each offset [m^2]
  Eigen::VectorXd rest;        // of all blocks
  Eigen::Index best = 0;
  double unforced = 0;  // sum of squares without force [m^2]
  double independent_share = 1;
  double independent = 0;  // number of independent residuals

  double offset(Eigen::Index k) const { return about + step * static_cast<double>(k - side); }
  // Twice the fall of the log likelihood is n ln S's rise, with the independent n.
  double fall(double more) const { return independent * std::log(more / rest[best]); }
  // Whether 95 % of the likely offsets lie inside.
  bool holds_likely() const {
    constexpr double kOf95 = 3.84;
    return fall(rest[0]) >= kOf95 && fall(rest[rest.size() - 1]) >= kOf95;
  }
};

FineSearch search_within(double reach, double about, const MovingDeviation& deviation,
                         const Path& force, const Span& known) {
  constexpr double kStepsOfPeriod = 16;
  FineSearch search;
  search.step = deviation.period() / kStepsOfPeriod;
  search.about = about;
  search.side = static_cast<int>(std::ceil(reach / search.step));
  reach = search.step * search.side;
  const OffsetFit fit =
      deviation.fit({known.begin - search.about + reach, known.end - search.about - reach}, 1);
  const Path mean = smoothed(force, deviation.period());
  search.of_blocks.resize(kBlocks, 2 * search.side + 1);
  for (Eigen::Index k = 0; k < search.of_blocks.cols(); ++k)
    search.of_blocks.col(k) = sums_of_blocks(fit.residuals(mean, search.offset(k)));
  search.rest = search.of_blocks.colwise().sum().transpose();
  search.rest.minCoeff(&search.best);
  search.unforced = fit.unforced();
  search.independent_share = independent_share(fit.residuals(mean, search.offset(search.best)));
  search.independent = search.independent_share * fit.numbers();
  return search;
}

// The coarse best errs by as much as the readings leave open, which may be many of its steps.
FineSearch search_about(const CoarseSearch& coarse, const MovingDeviation& deviation,
                        const Path& force, const Span& known) {
  for (double reach = 2 * coarse.step;; reach *= 2) {
    FineSearch search = search_within(reach, coarse.offset(coarse.best), deviation, force, known);
    if (search.holds_likely() || reach > 3 * kMaxOffsetSigma) return search;
  }
}

// Throws where an offset beyond the valley of the best is a thousandth as likely or more.
void require_one_valley(const CoarseSearch& coarse, const FineSearch& fine) {
  const auto behind = [&](Eigen::Index k) {
    return fine.independent_share * static_cast<double>(coarse.stride) *
           (coarse.gain[coarse.best] - coarse.gain[k]);
  };
  const Eigen::Index steps = coarse.gain.size();
  Eigen::Index first = coarse.best, last = coarse.best;
  while (first > 0 && behind(first) < 2 * kCertain) --first;
  while (last + 1 < steps && behind(last) < 2 * kCertain) ++last;
  for (Eigen::Index k = 0; k < steps; ++k)
    if ((k < first || k > last) && behind(k) < kCertain)
      throw std::invalid_argument(
          "the force record explains the deviation as well " +
          formatted("%.3f s", fine.offset(fine.best)) + " ahead of the instrument as " +
          formatted("%.3f s: ", coarse.offset(k)) +
          remedy("take a pass in which the force changes otherwise each time"));
}

// Standard deviation of the best offset [s].
double deviation_of_best(const FineSearch& search) {
  // By the noise: n ln S rises by 1.
  Eigen::Index low = search.best, high = search.best;
  while (low > 0 && search.fall(search.rest[low]) < 1) --low;
  while (high + 1 < search.rest.size() && search.fall(search.rest[high]) < 1) ++high;
  const double by_noise = (search.offset(high) - search.offset(low)) / 2;
  // Jackknife: the offset without each block. What force and drift do not explain, such as
  // backlash, moves the offset too, and the noise of the samples says nothing of it.
  Eigen::VectorXd others(kBlocks);
  for (Eigen::Index block = 0; block < kBlocks; ++block) {
    Eigen::Index k = 0;
    (search.rest - search.of_blocks.row(block).transpose()).minCoeff(&k);
    others[block] = search.offset(k);
  }
  const double scatter = (others.array() - others.mean()).square().sum() * (kBlocks - 1) / kBlocks;
  return std::max(by_noise, std::sqrt(scatter));
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
  const MovingDeviation deviation(executed, pass, clock, moves);
  const CoarseSearch coarse = search_all(deviation, force, known, offsets);
  const FineSearch fine = search_about(coarse, deviation, force, known);
  constexpr double kOfUnknowns = 2 * 9;  // the compliance explains some of any noise
  if (!(fine.fall(fine.unforced) >= kCertain + kOfUnknowns))  // nor where the tool does not deviate
    throw std::invalid_argument("the tool does not deviate by the force of the record: " +
                                remedy("check that it is of this pass"));
  require_one_valley(coarse, fine);
  const ForceClock found{fine.offset(fine.best), deviation_of_best(fine)};
  if (fine.best == 0 || fine.best + 1 == fine.rest.size() || found.deviation >= kMaxOffsetSigma)
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
