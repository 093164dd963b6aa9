#include "armtrue/path/registration/clock.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "linear_algebra/decompositions.h"
#include "path/registration/ornstein_uhlenbeck.h"

namespace armtrue {
namespace {

// Quartz keeps time to 1e-4; the pass rarely lasts long enough to say so by itself.
constexpr double kRateDeviation = 2e-4;
constexpr double kWorstRate = 1e-3;      // beyond it is no clock
constexpr double kOffsetDeviation = 1;   // [s], about the first offset: so far off it never is
constexpr double kMaxDeviation = 10e-3;  // [m]: beyond it the frames differ, not the path
constexpr double kWorstOffset = 0.1;     // [s], one standard deviation
constexpr double kDrag = 0.15e-3;        // [m]: friction holds the tool back by about this
constexpr double kSoftest = 1e-3;        // [m/N]: no machine gives way more
constexpr double kWeakFramePrior = 1;    // [m], [rad]: what a path cannot show stays put

std::string text(const char* format, double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

double extent(const Path& path) {
  return (path.position.rowwise().maxCoeff() - path.position.rowwise().minCoeff()).norm();
}

// Speed over chords of `window`, on a grid of `period` from the first sample on.
Eigen::VectorXd speed(const Path& path, double period, double window) {
  const auto count = static_cast<Eigen::Index>(
                         std::ceil((path.time[path.samples() - 1] - path.time[0]) / period)) +
                     1;
  const auto times = [&](double shift) -> Eigen::VectorXd {
    return Eigen::VectorXd::LinSpaced(
        count, path.time[0] + shift,
        path.time[0] + shift + period * static_cast<double>(count - 1));
  };
  return (position_at(path, times(window / 2)) - position_at(path, times(-window / 2)))
             .colwise()
             .norm()
             .transpose() /
         window;
}

// correlation[k] = sum_i a[i + k - (b.size() - 1)] b[i]
Eigen::VectorXd correlate(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::Index length = a.size() + b.size() - 1;
  Eigen::Index padded = 1;
  while (padded < length) padded *= 2;
  Eigen::FFT<double> fft;
  const auto transform = [&](const Eigen::VectorXd& values) {
    Eigen::VectorXd time = Eigen::VectorXd::Zero(padded);
    time.head(values.size()) = values;
    Eigen::VectorXcd frequency;
    fft.fwd(frequency, time);
    return frequency;
  };
  const Eigen::VectorXcd product = transform(a).cwiseProduct(transform(b.reverse()));
  Eigen::VectorXd correlation;
  fft.inv(correlation, product);
  return correlation.head(length);
}

// Mean square distance of some thousands of samples, were the clocks so.
double misfit(const Path& programmed, const Path& measured, double offset, double rate = 0) {
  const Eigen::Index step = std::max<Eigen::Index>(1, measured.samples() / 5000);
  const Eigen::VectorXd time = measured.time(Eigen::seq(0, Eigen::last, step));
  const Eigen::Matrix3Xd position = measured.position(Eigen::all, Eigen::seq(0, Eigen::last, step));
  return (position - position_at(programmed, (time.array() - offset) / (1 + rate)))
      .colwise()
      .squaredNorm()
      .mean();
}

// Where the two speeds go together best. A record of a part of the pass at constant speed fits in
// many places; of these the one is taken where the positions agree.
double coarse_offset(const Path& programmed, const Path& measured) {
  const double period = median_period(measured);
  const double duration = programmed.time[programmed.samples() - 1] - programmed.time[0];
  const double window = std::max(3 * period, std::min(0.25, 0.05 * duration));
  const Eigen::VectorXd correlation =
      correlate(speed(measured, period, window), speed(programmed, period, window));
  const auto last = static_cast<Eigen::Index>(std::ceil(duration / period));
  const auto offset_of = [&](double k) {
    return measured.time[0] - programmed.time[0] + (k - static_cast<double>(last)) * period;
  };
  // Rasters fit again one line further, stretches at constant speed anywhere: the best peaks and
  // places evenly spread between them.
  // Drag, force and noise cost the right one less than 3 % of the best.
  const double good = 0.97 * correlation.maxCoeff();
  std::vector<Eigen::Index> peaks, places;
  for (Eigen::Index k = 0; k < correlation.size(); ++k) {
    if (correlation[k] < good) continue;
    places.push_back(k);
    const Eigen::Index from = std::max<Eigen::Index>(k - 3, 0);
    const Eigen::Index to = std::min(k + 3, correlation.size() - 1);
    if (correlation[k] == correlation.segment(from, to - from + 1).maxCoeff()) peaks.push_back(k);
  }
  constexpr size_t kTried = 100;  // of either; each costs a comparison of the positions
  const auto higher = [&](Eigen::Index a, Eigen::Index b) {
    return correlation[a] > correlation[b];
  };
  std::sort(peaks.begin(), peaks.end(), higher);
  peaks.resize(std::min(peaks.size(), kTried));
  const double highest = offset_of(static_cast<double>(peaks.front()));
  for (size_t k = 0; k < places.size(); k += std::max<size_t>(1, places.size() / kTried))
    peaks.push_back(places[k]);
  double best = highest;
  double least = kMaxDeviation * kMaxDeviation;  // further off it is not positions that agree
  for (const Eigen::Index k : peaks) {
    const double offset = offset_of(static_cast<double>(k));
    const double here = misfit(programmed, measured, offset);
    if (here >= least) continue;
    least = here;
    best = offset;
  }
  return best;
}

// Velocity of the polygon; nothing moves outside the program.
Eigen::Matrix3Xd velocity_at(const Path& path, const Eigen::VectorXd& times) {
  const Eigen::Index n = path.samples();
  Eigen::Matrix3Xd velocity = Eigen::Matrix3Xd::Zero(3, times.size());
  Eigen::Index k = 0;
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    if (times[i] < path.time[0] || times[i] > path.time[n - 1]) continue;
    while (k + 2 < n && path.time[k + 1] < times[i]) ++k;
    velocity.col(i) =
        (path.position.col(k + 1) - path.position.col(k)) / (path.time[k + 1] - path.time[k]);
  }
  return velocity;
}

// Clocks drift apart over a long record, in the end by more than the paths may lie apart. From the
// middle, where the first offset holds, offset and rate follow it outwards: least squares over a
// stretch that doubles.
void follow_drift(const Path& programmed, const Path& measured, ClockFit& fit) {
  constexpr double kBridged = 0.1;  // [s] of drift
  constexpr int kRounds = 5;        // Gauss-Newton from close by
  constexpr Eigen::Index kSamples = 5000;
  const double* const begin = measured.time.data();
  const double* const end = begin + measured.samples();
  const double middle = 0.5 * (*begin + *(end - 1)), whole = *(end - 1) - middle;
  for (double half = kBridged / kRateDeviation;; half *= 2) {
    const auto first = std::lower_bound(begin, end, middle - half) - begin;
    const auto last = std::upper_bound(begin, end, middle + half) - begin - 1;
    const auto some = Eigen::seq(first, last, std::max<Eigen::Index>(1, (last - first) / kSamples));
    const Eigen::VectorXd time = measured.time(some);
    const Eigen::Matrix3Xd position = measured.position(Eigen::all, some);
    for (int round = 0; round < kRounds; ++round) {
      const Eigen::VectorXd own = (time.array() - fit.offset) / (1 + fit.rate);
      const Eigen::Matrix3Xd velocity = velocity_at(programmed, own);
      const Eigen::Matrix3Xd off = position - position_at(programmed, own);
      const double at = fit.program_time(middle);
      Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
      Eigen::Vector2d right = Eigen::Vector2d::Zero();
      for (Eigen::Index i = 0; i < own.size(); ++i) {
        const Eigen::Vector2d by(1, own[i] - at);
        normal += velocity.col(i).squaredNorm() * by * by.transpose();
        right -= velocity.col(i).dot(off.col(i)) * by;
      }
      const Eigen::Vector2d change = normal.ldlt().solve(right);
      if (!change.allFinite()) return;
      fit.offset += change[0] - at * change[1];
      fit.rate += change[1];
    }
    if (half >= whole) return;
  }
}

// Samples of a long record that tell the clock as well as all of them: some runs, evenly spread,
// the first and the last among them.
Path thinned(const Path& path) {
  constexpr Eigen::Index kRuns = 20, kRun = 2000;
  if (path.samples() <= kRuns * kRun) return path;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index run = 0; run < kRuns; ++run) {
    const Eigen::Index begin = run * (path.samples() - kRun) / (kRuns - 1);
    for (Eigen::Index k = 0; k < kRun; ++k) kept.push_back(begin + k);
  }
  Path some;
  some.time = path.time(kept);
  some.position = path.position(Eigen::all, kept);
  if (path.has_force()) some.force = path.force(Eigen::all, kept);
  return some;
}

// How the variance of a jump spreads over the samples: a tool may jump (free play, a cutting force
// that turns) where the motion changes, just where the clock shows.
Eigen::VectorXd jump_shares(const Path& programmed, const Eigen::VectorXd& times) {
  constexpr double kReach = 0.1;   // [s]
  constexpr double kChange = 0.5;  // of the speed
  const auto velocity = [&](double shift) -> Eigen::Matrix3Xd {
    return (position_at(programmed, times.array() + shift + kReach / 2) -
            position_at(programmed, times.array() + shift - kReach / 2)) /
           kReach;
  };
  const Eigen::Matrix3Xd before = velocity(-kReach / 2), after = velocity(kReach / 2);
  const Eigen::VectorXd change = (after - before).colwise().norm();
  const double speed = before.colwise().norm().maxCoeff();
  Eigen::VectorXd share = Eigen::VectorXd::Zero(times.size());
  for (Eigen::Index i = 1; i < times.size();) {
    if (!(change[i] >= kChange * speed)) {
      ++i;
      continue;
    }
    Eigen::Index end = i + 1;
    while (end < times.size() && change[end] >= kChange * speed) ++end;
    share.segment(i, end - i).setConstant(1 / static_cast<double>(end - i));
    i = end;
  }
  return share;
}

// One record against its program.
class ClockEstimator {
 public:
  ClockEstimator(const Path& programmed, const Path& measured, bool fit_frame)
      : programmed_(programmed), measured_(thinned(measured)), shared_(fit_frame ? 10 : 4) {
    centre_ = measured_.position.rowwise().mean();
    middle_ = 0.5 * (measured_.time[0] + measured_.time[measured_.samples() - 1]);
    // On a straight line what lies along it tells time, what lies across does not.
    const Eigen::Matrix3Xd motion = programmed.position.rightCols(programmed.samples() - 1) -
                                    programmed.position.leftCols(programmed.samples() - 1);
    axes_ = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(motion * motion.transpose())
                .eigenvectors()
                .transpose();
    // Before anything is known: a millimetre, and what the first offset may be wrong by.
    const double speed = motion.colwise().norm().maxCoeff() / median_period(programmed);
    laws_.fill({1e-3 + speed * median_period(measured_), 2, 0.1e-3});
  }

  void refine(ClockFit& fit) {
    constexpr int kRounds = 10;  // five while the laws of the deviations settle, then to the end
    for (int round = 0; round < kRounds; ++round) {
      linearize(fit);
      if (round == 2 || round == 4)
        for (size_t axis = 0; axis < 3; ++axis) laws_[axis] = fit_law(samples_[axis]);
      if (round > 4 && std::abs(step(fit)) < 1e-6) break;
      if (round <= 4) step(fit);
    }
  }

 private:
  int unknowns() const { return shared_ + (measured_.has_force() ? 9 : 0); }

  // Deviations and their derivatives by offset, rate and frame, by axis; and the force, since what
  // it explains is no time either.
  void linearize(const ClockFit& fit) {
    const Eigen::Index n = measured_.samples();
    const Pose& frame = fit.program_from_instrument;
    const Eigen::VectorXd time = (measured_.time.array() - fit.offset) / (1 + fit.rate);
    const Eigen::Matrix3Xd wanted = position_at(programmed_, time);
    const Eigen::Matrix3Xd deviation =
        axes_ * ((frame.rotation * measured_.position - wanted).colwise() + frame.translation);
    const Eigen::Matrix3Xd by_offset = axes_ * velocity_at(programmed_, time) / (1 + fit.rate);
    const Eigen::VectorXd share = jump_shares(programmed_, time);
    Path motion;
    motion.time = time;
    motion.position = wanted;
    const Eigen::Matrix3Xd along = axes_ * tangents(motion);
    Eigen::VectorXd before_start = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n && by_offset.col(i).isZero(0); ++i) before_start[i] = 1;
    const Eigen::Matrix3Xd lever = frame.rotation * (measured_.position.colwise() - centre_);
    for (int axis = 0; axis < 3; ++axis) {
      AxisSamples& samples = samples_[static_cast<size_t>(axis)];
      samples.time = measured_.time;
      samples.share = share;
      Eigen::MatrixXd& columns = samples.columns;
      columns.resize(n, 1 + shared_ + (measured_.has_force() ? 3 : 0));
      columns.col(0) = deviation.row(axis).transpose();
      columns.col(1) = by_offset.row(axis).transpose();
      // The rate about the middle of the record: there it is independent of the offset.
      columns.col(2) = columns.col(1).array() * (measured_.time.array() - middle_);
      columns.col(3) = along.row(axis).transpose();
      columns.col(4) = columns.col(3).cwiseProduct(before_start);
      for (int k = 0; shared_ > 4 && k < 3; ++k) {
        columns.col(5 + k).setConstant(axes_(axis, k));
        // axis . (e_k x lever) = lever . (axis x e_k)
        const Eigen::Vector3d turned =
            Eigen::Vector3d(axes_.row(axis).transpose()).cross(Eigen::Vector3d::Unit(k));
        columns.col(8 + k) = lever.transpose() * turned;
      }
      if (measured_.has_force()) columns.rightCols<3>() = measured_.force.transpose();
    }
  }

  // What one axis says, if jumps along it have one size.
  struct Evidence {
    double cost = 0;
    Eigen::MatrixXd products;  // of the whitened columns
  };

  struct Solution {
    double cost = 0;
    Eigen::VectorXd change;  // of the shared unknowns
    Eigen::MatrixXd covariance;
  };

  // The Gauss-Newton step from one piece of evidence for each axis.
  Solution solve(const ClockFit& fit, const std::array<const Evidence*, 3>& axes) const {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns(), unknowns());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns());
    Solution solution;
    for (int axis = 0; axis < 3; ++axis) {
      const auto& [cost, products] = *axes[static_cast<size_t>(axis)];
      solution.cost += cost;
      const auto place = [&](Eigen::Index c) {  // of a regressor among the unknowns
        return c < shared_ ? c : c + 3 * axis;
      };
      for (Eigen::Index a = 0; a + 1 < products.cols(); ++a) {
        right[place(a)] -= products(1 + a, 0);
        for (Eigen::Index b = 0; b + 1 < products.cols(); ++b)
          normal(place(a), place(b)) += products(1 + a, 1 + b);
      }
    }
    normal(0, 0) += 1 / (kOffsetDeviation * kOffsetDeviation);
    const double rate_weight = 1 / (kRateDeviation * kRateDeviation);
    normal(1, 1) += rate_weight;
    right[1] -= rate_weight * fit.rate;
    for (int k : {2, 3}) normal(k, k) += 1 / (kDrag * kDrag);
    for (int k = 4; k < shared_; ++k) normal(k, k) += 1 / (kWeakFramePrior * kWeakFramePrior);
    for (int k = shared_; k < unknowns(); ++k) normal(k, k) += 1 / (kSoftest * kSoftest);
    const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
    const Eigen::VectorXd change = solver.solve(right);
    solution.cost += 0.5 * (solver.vectorD().array().log().sum() - right.dot(change));
    solution.change = change.head(shared_);
    solution.covariance = solver.solve(Eigen::MatrixXd::Identity(unknowns(), unknowns()))
                              .topLeftCorner(shared_, shared_);
    return solution;
  }

  // One step, averaged over the size of jumps along each axis by how likely they make the record.
  // Returns what the offset moved by.
  double step(ClockFit& fit) const {
    constexpr std::array kJumps{0.0, 0.05e-3, 0.1e-3, 0.2e-3, 0.4e-3};  // [m], free play at a tool
    std::array<std::array<Evidence, kJumps.size()>, 3> evidence;
    for (size_t axis = 0; axis < 3; ++axis)
      for (size_t k = 0; k < kJumps.size(); ++k) {
        DeviationLaw law = laws_[axis];
        law.jump = kJumps[k];
        const Whitened white = whiten(law, samples_[axis]);
        evidence[axis][k] = {white.log_determinant + 0.5 * white.columns.col(0).squaredNorm(),
                             white.columns.transpose() * white.columns};
      }
    std::vector<Solution> solutions;
    double least = std::numeric_limits<double>::infinity();
    for (const Evidence& x : evidence[0])
      for (const Evidence& y : evidence[1])
        for (const Evidence& z : evidence[2]) {
          solutions.push_back(solve(fit, {&x, &y, &z}));
          least = std::min(least, solutions.back().cost);
        }
    double total = 0;
    Eigen::VectorXd change = Eigen::VectorXd::Zero(shared_);
    Eigen::MatrixXd square = Eigen::MatrixXd::Zero(shared_, shared_);
    for (const Solution& solution : solutions) {
      const double weight = std::exp(least - solution.cost);
      total += weight;
      change += weight * solution.change;
      square += weight * (solution.covariance + solution.change * solution.change.transpose());
    }
    change /= total;
    apply(change, square / total - change * change.transpose(), fit);
    return change[0];
  }

  void apply(const Eigen::VectorXd& change, const Eigen::MatrixXd& covariance,
             ClockFit& fit) const {
    fit.covariance = covariance.topLeftCorner<2, 2>();
    fit.offset += change[0] + (fit.offset - middle_) * change[1];
    fit.rate += change[1];
    fit.middle = fit.program_time(middle_);
    if (shared_ == 4) return;
    Pose& frame = fit.program_from_instrument;
    const Eigen::Matrix3d turn = rotation_exp(change.segment<3>(7));
    const Eigen::Vector3d pivot = frame.rotation * centre_;
    frame.translation += change.segment<3>(4) + pivot - turn * pivot;
    frame.rotation = turn * frame.rotation;
  }

  const Path& programmed_;
  Path measured_;
  int shared_;  // unknowns that all axes have in common: offset, rate, drag, perhaps the frame
  Eigen::Vector3d centre_;
  double middle_ = 0;
  Eigen::Matrix3d axes_;  // rows: directions of most and least motion
  std::array<AxisSamples, 3> samples_;
  std::array<DeviationLaw, 3> laws_;
};

void check_motion(const Path& path, const std::string& which) {
  if (extent(path) > 1e-3) return;
  throw std::invalid_argument("the " + which + " path stands still (it spans " +
                              text("%.3g", extent(path) / kMillimetre) +
                              " mm): there is nothing to correct; check that it is the right "
                              "record and in mm");
}

// Frame and clock together, from a first offset.
ClockFit fit_with_frame(const Path& programmed, const Path& measured, double offset) {
  ClockFit fit;
  fit.offset = offset;
  const Eigen::Matrix4d motion = Eigen::umeyama(
      measured.position, position_at(programmed, measured.time.array() - offset), false);
  fit.program_from_instrument = {motion.topLeftCorner<3, 3>(), motion.topRightCorner<3, 1>()};
  ClockEstimator(programmed, measured, true).refine(fit);
  return fit;
}

// Of each sample from where the program has the tool at its time.
Eigen::VectorXd distances(const Path& programmed, const Path& measured, const ClockFit& fit) {
  const Pose& motion = fit.program_from_instrument;
  const Eigen::VectorXd time = (measured.time.array() - fit.offset) / (1 + fit.rate);
  const Eigen::Matrix3Xd off =
      ((motion.rotation * measured.position).colwise() + motion.translation) -
      position_at(programmed, time);
  return off.colwise().norm().transpose();
}

[[noreturn]] void fail_frame(const Path& programmed, const Path& measured, double offset) {
  const ClockFit fit = fit_with_frame(programmed, measured, offset);
  const Pose& motion = fit.program_from_instrument;
  const Eigen::VectorXd off = distances(programmed, measured, fit);
  const Eigen::Vector3d shift = motion.translation / kMillimetre;
  const Eigen::Vector3d abc = abc_from_rotation(motion.rotation) / kDegree;
  std::array<char, 480> message{};
  std::snprintf(message.data(), message.size(),
                "the measured path lies %.4g mm from the programmed one, in another frame or of "
                "another pass; moved by x %.3f, y %.3f, z %.3f mm, a %.4f, b %.4f, c %.4f deg it "
                "would lie %.3f mm away: %s",
                std::sqrt(misfit(programmed, measured, offset)) / kMillimetre, shift[0], shift[1],
                shift[2], abc[0], abc[1], abc[2], off.mean() / kMillimetre,
                std::sqrt(off.array().square().mean()) < kMaxDeviation
                    ? "apply that to the record or use --fit-frame"
                    : "no frame joins them; take the record of this pass");
  throw std::invalid_argument(message.data());
}

// A fitted frame has to join the paths, too.
void check_joined(const Path& programmed, const Path& measured, const ClockFit& fit) {
  const Eigen::VectorXd off = distances(programmed, measured, fit);
  const double rms = std::sqrt(off.array().square().mean());
  if (!(rms > kMaxDeviation)) return;
  throw std::invalid_argument("the measured path lies " + text("%.4g", rms / kMillimetre) +
                              " mm from the programmed one in whatever frame: it is not of this "
                              "program or not of one pass; take the record of this pass");
}

void check_overlap(const Path& programmed, const Path& measured, const ClockFit& fit) {
  const double begin = std::max(programmed.time[0], fit.program_time(measured.time[0]));
  const double end = std::min(programmed.time[programmed.samples() - 1],
                              fit.program_time(measured.time[measured.samples() - 1]));
  const double duration = programmed.time[programmed.samples() - 1] - programmed.time[0];
  if (end - begin < 0.1 * duration)
    throw std::invalid_argument(
        "the paths do not overlap in time: with an offset of " + text("%.6g", fit.offset) +
        " s the record covers " + text("%.3g", std::max(0.0, end - begin)) + " s of the " +
        text("%.6g", duration) + " s of the program; take the record of this pass");
}

void check_time_unit(const Path& programmed, const Path& measured) {
  const auto duration = [](const Path& path) {
    return path.time[path.samples() - 1] - path.time[0];
  };
  const double longer = duration(measured) / duration(programmed);
  const double window = 0.1 * std::min(duration(measured), duration(programmed));
  const double slower = longest_move(programmed, window) / longest_move(measured, window);
  for (const auto& [factor, what] :
       {std::pair{1e3, "measured path: its clock seems to count milliseconds"},
        {1e6, "measured path: its clock seems to count microseconds"},
        {1e-3, "programmed path: its times seem to be milliseconds"},
        {1e-6, "programmed path: its times seem to be microseconds"}}) {
    // Both are nearer to the factor than to 1: a record may be of a part, or wait for long.
    const bool lasts = std::log(longer) / std::log(factor) > 0.5;
    const bool runs = std::abs(std::log(slower / factor)) < std::numbers::ln2;
    if (lasts && runs)
      throw std::invalid_argument(
          "the measured path lasts " + text("%.4g", duration(measured)) +
          " s by its column t_s, the "
          "programmed one " +
          text("%.4g", duration(programmed)) + " s, and the tool moves " + text("%.3g", slower) +
          " times as slowly in it. Correct t_s of the " + what + " where the column says s");
  }
}

}  // namespace

void check_units(const Path& programmed, const Path& measured) {
  const double ratio = extent(measured) / extent(programmed);
  for (const auto& [factor, unit] : {std::pair{1e-3, "in m where the column says mm"},
                                     {1e3, "in mm where the column says m"},
                                     {1 / 25.4, "in inches"},
                                     {25.4, "in mm, while the program is in inches"}})
    if (std::abs(ratio / factor - 1) < 0.1)
      throw std::invalid_argument("the measured path is " + text("%.4g", ratio) +
                                  " times as large as the programmed one: it seems to be " + unit +
                                  "; correct the column");
  check_time_unit(programmed, measured);
}

ClockFit fit_clock(const Path& programmed, const Path& measured, const ClockOptions& options) {
  check_motion(programmed, "programmed");
  check_units(programmed, measured);
  check_motion(measured, "measured");
  ClockFit fit;
  fit.offset = options.offset ? *options.offset : coarse_offset(programmed, measured);
  check_overlap(programmed, measured, fit);
  const auto apart = [&](const ClockFit& clock) {
    return misfit(programmed, measured, clock.offset, clock.rate) > kMaxDeviation * kMaxDeviation;
  };
  if (apart(fit) && !options.fit_frame) {
    ClockFit drifting = fit;
    if (!options.offset) follow_drift(programmed, measured, drifting);
    if (apart(drifting) || std::abs(drifting.rate) > kWorstRate)
      fail_frame(programmed, measured, fit.offset);
    fit = drifting;
  }
  if (options.offset) return fit;
  if (options.fit_frame)
    fit = fit_with_frame(programmed, measured, fit.offset);
  else
    ClockEstimator(programmed, measured, false).refine(fit);
  check_overlap(programmed, measured, fit);
  if (options.fit_frame) check_joined(programmed, measured, fit);
  if (!(fit.offset_deviation() < kWorstOffset))
    throw std::invalid_argument(
        "the record does not show how the clocks lie to each other (offset " +
        text("%.4g", fit.offset) + " +- " + text("%.2g", fit.offset_deviation()) +
        " s): record from before the tool moves until it stands again, or give --offset-s");
  return fit;
}

std::array<Eigen::Matrix3Xd, 2> clock_errors(const Path& programmed, const Eigen::VectorXd& times,
                                             const Eigen::Matrix2d& covariance) {
  const Eigen::Matrix2d root =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).operatorSqrt();
  const Eigen::Matrix3Xd velocity = velocity_at(programmed, times);
  const Eigen::ArrayXd from_halfway = times.array() - 0.5 * (times[0] + times[times.size() - 1]);
  const auto error = [&](Eigen::Index k) -> Eigen::Matrix3Xd {
    return velocity * (root(0, k) + root(1, k) * from_halfway).matrix().asDiagonal();
  };
  return {error(0), error(1)};
}

}  // namespace armtrue
