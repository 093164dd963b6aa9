#include "path/registration/clock_estimator.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "linear_algebra/decompositions.h"
#include "path/registration/first_offset.h"
#include "path/registration/frame_fit.h"
#include "path/registration/ornstein_uhlenbeck.h"

namespace armtrue {
namespace {

// Prior standard deviations of the unknowns; kRateSigma is another.
constexpr double kOffsetSigma = 1;         // [s], about the first offset
constexpr double kDragSigma = 0.15e-3;     // [m]: friction holds the tool back by about this
constexpr double kComplianceSigma = 1e-3;  // [m/N]: no machine gives way more
constexpr double kFrameSigma = 1;          // [m], [rad]: keeps what a path does not determine

// A long record reduced to runs of samples, evenly spread from the first sample to the last: they
// determine the clock as well as all samples do.
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

// The share of a jump's variance that falls before each sample. A tool may jump (free play, a
// cutting force that turns) where its motion changes; the share of a change is spread evenly over
// its samples.
Eigen::VectorXd jump_shares(const Path& programmed, const Eigen::VectorXd& times) {
  constexpr double kReach = 0.1;      // [s] before and after
  constexpr double kMinChange = 0.5;  // of the velocity, over the greatest speed
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
    if (!(change[i] >= kMinChange * speed)) {
      ++i;
      continue;
    }
    Eigen::Index end = i + 1;
    while (end < times.size() && change[end] >= kMinChange * speed) ++end;
    share.segment(i, end - i).setConstant(1 / static_cast<double>(end - i));
    i = end;
  }
  return share;
}

class ClockEstimator {
 public:
  ClockEstimator(const Path& programmed, const Path& measured, bool fit_frame)
      : programmed_(programmed), measured_(thinned(measured)), shared_(fit_frame ? 10 : 4) {
    centre_ = measured_.position.rowwise().mean();
    middle_ = 0.5 * (measured_.time[0] + measured_.time[measured_.samples() - 1]);
    // Axes in the order of the motion of the tool along them: on a straight line only the first
    // shows the time.
    const Eigen::Matrix3Xd motion = programmed.position.rightCols(programmed.samples() - 1) -
                                    programmed.position.leftCols(programmed.samples() - 1);
    axes_ = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(motion * motion.transpose())
                .eigenvectors()
                .transpose();
    // Start values: 1 mm, plus the travel in one sample, which is the possible error of the first
    // offset.
    const double speed = motion.colwise().norm().maxCoeff() / median_period(programmed);
    processes_.fill({1e-3 + speed * median_period(measured_), 2, 0.1e-3});
  }

  void refine(ClockFit& fit) {
    constexpr int kRounds = 10;  // five in which the processes are fitted, then until it converges
    for (int round = 0; round < kRounds; ++round) {
      linearize(fit);
      if (round == 2 || round == 4)
        for (size_t axis = 0; axis < 3; ++axis) {
          FittedProcess fitted = fit_ornstein_uhlenbeck(samples_[axis]);
          processes_[axis] = fitted.process;
          samples_[axis].explained = std::move(fitted.explained);
        }
      if (round > 4 && std::abs(step(fit)) < 1e-6) break;
      if (round <= 4) step(fit);
    }
    if (shared_ > 4) fit.frame_covariance = frame_covariance(fit);
  }

 private:
  int unknowns() const { return shared_ + (measured_.has_force() ? 9 : 0); }

  // Fills samples_: for each axis the deviation, its derivatives by offset, rate, drag and frame,
  // and the force, because the deviation by force is no error of the clock either.
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
      AxisSamples& samples = samples_[axis];
      samples.time = measured_.time;
      samples.jump_share = share;
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

  // The normal equations of one axis for one size of its jumps.
  struct Evidence {
    double cost = 0;
    Eigen::MatrixXd products;  // white' * white; row and column 0 belong to the deviation
  };

  struct Solution {
    double cost = 0;
    Eigen::VectorXd change;  // of the unknowns that all axes share
    Eigen::MatrixXd covariance;
  };

  // The Gauss-Newton step from one size of jumps along each axis.
  Solution solve(const ClockFit& fit, const std::array<const Evidence*, 3>& axes) const {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns(), unknowns());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns());
    Solution solution;
    for (int axis = 0; axis < 3; ++axis) {
      const auto& [cost, products] = *axes[axis];
      solution.cost += cost;
      const auto place = [&](Eigen::Index c) {  // of regressor c among the unknowns
        return c < shared_ ? c : c + 3 * axis;
      };
      for (Eigen::Index a = 0; a + 1 < products.cols(); ++a) {
        right[place(a)] -= products(1 + a, 0);
        for (Eigen::Index b = 0; b + 1 < products.cols(); ++b)
          normal(place(a), place(b)) += products(1 + a, 1 + b);
      }
    }
    normal(0, 0) += 1 / (kOffsetSigma * kOffsetSigma);
    const double rate_weight = 1 / (kRateSigma * kRateSigma);
    normal(1, 1) += rate_weight;
    right[1] -= rate_weight * fit.rate;
    for (int k : {2, 3}) normal(k, k) += 1 / (kDragSigma * kDragSigma);
    for (int k = 4; k < shared_; ++k) normal(k, k) += 1 / (kFrameSigma * kFrameSigma);
    for (int k = shared_; k < unknowns(); ++k)
      normal(k, k) += 1 / (kComplianceSigma * kComplianceSigma);
    const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
    const Eigen::VectorXd change = solver.solve(right);
    solution.cost += 0.5 * (solver.vectorD().array().log().sum() - right.dot(change));
    solution.change = change.head(shared_);
    solution.covariance =
        Eigen::MatrixXd(solver.solve(identity(unknowns()))).topLeftCorner(shared_, shared_);
    return solution;
  }

  // One step: the mean over the sizes of jumps along the three axes, weighted by the likelihood
  // exp(-cost) of each combination. Returns the change of the offset [s].
  double step(ClockFit& fit) {
    constexpr std::array kJumps{0.0, 0.05e-3, 0.1e-3, 0.2e-3, 0.4e-3};  // [m]
    std::array<std::array<Evidence, kJumps.size()>, 3> evidence;
    for (size_t axis = 0; axis < 3; ++axis)
      for (size_t k = 0; k < kJumps.size(); ++k) {
        OrnsteinUhlenbeck process = processes_[axis];
        process.jump = kJumps[k];
        const Whitened white = whiten(process, samples_[axis]);
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

  void apply(const Eigen::VectorXd& change, const Eigen::MatrixXd& covariance, ClockFit& fit) {
    // The next deviations are without the change of clock and frame, but not without drag.
    for (AxisSamples& samples : samples_)
      for (int k = 0; samples.explained.size() > 0 && k < shared_; ++k)
        if (k != 2 && k != 3) samples.explained[k] += change[k];
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
    fit.frame_pivot = frame * centre_;
  }

  // That of least squares of the deviations, H^-1 J' S J H^-1: S is the covariance
  // of the deviations by the fitted processes, so it is the uncertainty that knows that neighbours
  // deviate alike.
  Eigen::Matrix<double, 6, 6> frame_covariance(const ClockFit& fit) const {
    const FrameEquations equations = frame_equations(programmed_, measured_, fit);
    Eigen::Matrix<double, 6, 6> sum = Eigen::Matrix<double, 6, 6>::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const OrnsteinUhlenbeck& process = processes_[axis];
      const double power = process.deviation * process.deviation;
      const double noise = process.noise * process.noise;
      using Vector6d = Eigen::Matrix<double, 6, 1>;
      Vector6d before = Vector6d::Zero();  // all earlier ones, each by its correlation with this
      for (Eigen::Index i = 0; i < measured_.samples(); ++i) {
        const Vector6d here = equations.by_frame.middleRows<3>(3 * i).transpose() *
                              equations.weight.middleRows<3>(3 * i) * axes_.row(axis).transpose();
        sum += (power + noise) * here * here.transpose() +
               power * (here * before.transpose() + before * here.transpose());
        if (i + 1 < measured_.samples())
          before =
              std::exp(-(measured_.time[i + 1] - measured_.time[i]) / process.correlation_time) *
              (before + here);
      }
    }
    const Eigen::Matrix<double, 6, 6> inverse = equations.information().inverse();
    return inverse * sum * inverse;
  }

  const Path& programmed_;
  Path measured_;
  int shared_;  // number of unknowns that all axes share: offset, rate, two of drag, six of frame
  Eigen::Vector3d centre_;
  double middle_ = 0;
  Eigen::Matrix3d axes_;  // rows: principal directions of the motion, least first
  std::array<AxisSamples, 3> samples_;
  std::array<OrnsteinUhlenbeck, 3> processes_;
};

}  // namespace

ClockFit refine_clock(const Path& programmed, const Path& measured, ClockFit fit, bool fit_frame) {
  ClockEstimator(programmed, measured, fit_frame).refine(fit);
  return fit;
}

}  // namespace armtrue
