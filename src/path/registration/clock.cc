#include "armtrue/path/registration/clock.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "armtrue/path/registration/aside.h"
#include "armtrue/path/registration/pause.h"
#include "linear_algebra/decompositions.h"
#include "path/registration/clock_estimator.h"
#include "path/registration/feed.h"
#include "path/registration/first_offset.h"
#include "path/registration/formatted.h"
#include "path/registration/frame_fit.h"
#include "path/registration/unit_check.h"

namespace armtrue {
namespace {

constexpr double kMaxRate = 1e-3;  // no clock is worse

void check_motion(const Path& path, const std::string& which) {
  if (extent(path) > 1e-3) return;
  throw std::invalid_argument("the " + which + " path stands still (it spans " +
                              formatted("%.3g", extent(path) / kMillimetre) +
                              " mm): there is nothing to correct; check that it is the right "
                              "record and in mm");
}

// The record where a frame has it.
Path placed(const Path& record, const Pose& program_from_instrument) {
  Path path = record;
  path.position = (program_from_instrument.rotation * record.position).colwise() +
                  program_from_instrument.translation;
  if (record.has_force()) path.force = program_from_instrument.rotation * record.force;
  return path;
}

// Puts the record into a frame, and fits its clock there.
void place_in(const Path& programmed, const Path& measured, const Pose& frame, ClockFit& fit) {
  ClockFit own = fit;
  own.program_from_instrument = Pose{};
  own = refine_clock(programmed, placed(measured, frame), own, false);
  fit.offset = own.offset;
  fit.rate = own.rate;
  fit.middle = own.middle;
  fit.program_from_instrument = frame;
}

// Fits frame and clock, from a first offset. Both together first, because one misleads the other;
// the covariance of the clock is from there.
ClockFit fit_with_frame(const Path& programmed, const Path& measured, double offset) {
  ClockFit fit;
  fit.offset = offset;
  const Eigen::Matrix4d motion = Eigen::umeyama(
      measured.position, position_at(programmed, measured.time.array() - offset), false);
  fit.program_from_instrument = {motion.topLeftCorner<3, 3>(), motion.topRightCorner<3, 1>()};
  fit = refine_clock(programmed, measured, fit, true);
  place_in(programmed, measured,
           fit_frame(programmed, {measured}, {fit}, fit.program_from_instrument), fit);
  return fit;
}

// Distance of each sample from where the program has the tool at that time [m].
Eigen::VectorXd distances(const Path& programmed, const Path& measured, const ClockFit& fit) {
  const Pose& motion = fit.program_from_instrument;
  const Eigen::VectorXd time = (measured.time.array() - fit.offset) / (1 + fit.rate);
  const Eigen::Matrix3Xd off =
      ((motion.rotation * measured.position).colwise() + motion.translation) -
      position_at(programmed, time);
  return off.colwise().norm().transpose();
}

// The record without a pause: what comes after it, as much earlier.
Path without(const Path& record, const Pause& pause) {
  std::vector<Eigen::Index> kept;
  Path path;
  for (Eigen::Index k = 0; k < record.samples(); ++k)
    if (k < pause.sample || record.time[k] >= pause.begin + pause.longer) kept.push_back(k);
  path.time = record.time(kept);
  path.position = record.position(Eigen::all, kept);
  path.time.tail(std::ssize(kept) - pause.sample).array() -= pause.longer;
  return path;
}

// After a pause a record lies far from the program, and near it without the pause.
void check_pause(const Path& programmed, const Path& measured, bool fit_frame) {
  const auto pause = find_pause(programmed, measured);
  if (!pause) return;
  const Path record = without(measured, *pause);
  const double offset = first_offset(programmed, record);
  const double off = fit_frame
                         ? distances(programmed, record, fit_with_frame(programmed, record, offset))
                                   .squaredNorm() /
                               static_cast<double>(record.samples())
                         : mean_square_distance(programmed, record, offset);
  if (off < kMaxPathDistance * kMaxPathDistance)
    throw std::invalid_argument("the tool " + in_words(*pause));
}

// A record of another feed lies far from the program, in whatever frame, and is of this pass.
void check_feed(const Path& programmed, const Path& measured, bool fit_frame) {
  const auto feed = find_other_feed(programmed, measured);
  if (!feed || !joins(programmed, measured, *feed, fit_frame)) return;
  // A radius inside of the curves makes the way shorter, at the same feed.
  const auto aside = fit_frame ? std::nullopt : find_aside(programmed, measured);
  const Eigen::VectorXd length = arc_length(programmed);
  if (aside && aside->explains((1 - feed->ratio) * length[length.size() - 1]))
    throw std::invalid_argument("the measured path " + in_words(*aside));
  throw std::invalid_argument("the measured path " + in_words(*feed));
}

}  // namespace

std::string mistaken_columns(const Path& programmed, const Path& measured) {
  const auto lies_on_program = [&](const Path& record) {
    return mean_square_distance(programmed, record, first_offset(programmed, record)) <
           kMaxPathDistance * kMaxPathDistance;
  };
  constexpr std::array kAxes{'x', 'y', 'z'};
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    Path negated = measured;
    negated.position.row(axis) *= -1;
    if (lies_on_program(negated)) return std::string(1, kAxes[axis]) + " of the other sign";
    const Eigen::Index next = (axis + 1) % 3;
    Path exchanged = measured;
    exchanged.position.row(axis).swap(exchanged.position.row(next));
    if (lies_on_program(exchanged))
      return std::string(1, kAxes[axis]) + " and " + kAxes[next] + " exchanged";
  }
  return "";
}

namespace {

[[noreturn]] void fail_frame(const Path& programmed, const Path& measured, double offset) {
  check_pause(programmed, measured, false);
  check_feed(programmed, measured, false);
  const double apart = std::sqrt(mean_square_distance(programmed, measured, offset));
  if (const std::string mistake = mistaken_columns(programmed, measured); !mistake.empty())
    throw std::invalid_argument(
        "the measured path lies " + formatted("%.4g", apart / kMillimetre) +
        " mm from the programmed one, and on it with " + mistake +
        ": check the columns of the record and their signs, and correct them");
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
                apart / kMillimetre, shift[0], shift[1], shift[2], abc[0], abc[1], abc[2],
                off.mean() / kMillimetre,
                std::sqrt(off.array().square().mean()) < kMaxPathDistance
                    ? "check the columns of the record and their signs first; then apply that to "
                      "the record or "
                      "use --fit-frame"
                    : "no frame joins them; take the record of this pass");
  throw std::invalid_argument(message.data());
}

// Refuses a fitted frame in which the paths lie too far apart.
void check_joined(const Path& programmed, const Path& measured, const ClockFit& fit) {
  const Eigen::VectorXd off = distances(programmed, measured, fit);
  const double rms = std::sqrt(off.array().square().mean());
  if (!(rms > kMaxPathDistance)) return;
  check_pause(programmed, measured, true);
  check_feed(programmed, measured, true);
  throw std::invalid_argument("the measured path lies " + formatted("%.4g", rms / kMillimetre) +
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
        "the paths do not overlap in time: with an offset of " + formatted("%.6g", fit.offset) +
        " s the record covers " + formatted("%.3g", std::max(0.0, end - begin)) + " s of the " +
        formatted("%.6g", duration) + " s of the program; take the record of this pass");
}

using Matrix6d = Eigen::Matrix<double, 6, 6>;

}  // namespace

ClockFit fit_clock(const Path& programmed, const Path& measured, const ClockOptions& options) {
  check_motion(programmed, "programmed");
  check_units(programmed, measured);
  check_motion(measured, "measured");
  ClockFit fit;
  fit.offset = options.offset ? *options.offset : first_offset(programmed, measured);
  check_overlap(programmed, measured, fit);
  const auto apart = [&](const ClockFit& clock) {
    return mean_square_distance(programmed, measured, clock.offset, clock.rate) >
           kMaxPathDistance * kMaxPathDistance;
  };
  if (apart(fit) && !options.fit_frame) {
    const ClockFit drifting = options.offset ? fit : follow_drift(programmed, measured, fit);
    if (apart(drifting) || std::abs(drifting.rate) > kMaxRate)
      fail_frame(programmed, measured, fit.offset);
    fit = drifting;
  }
  if (options.offset) return fit;
  if (options.fit_frame)
    fit = fit_with_frame(programmed, measured, fit.offset);
  else
    fit = refine_clock(programmed, measured, fit, false);
  check_overlap(programmed, measured, fit);
  if (options.fit_frame) check_joined(programmed, measured, fit);
  if (!(fit.offset_deviation() < kMaxOffsetSigma))
    throw std::invalid_argument(
        "the record does not show how the clocks lie to each other" +
        (std::isfinite(fit.offset_deviation())
             ? " (offset " + formatted("%.4g", fit.offset) + " +- " +
                   formatted("%.2g", fit.offset_deviation()) + " s)"
             : "") +
        ": record from before the tool moves until it stands again, or, where the offset of the clocks is known, mirror-correct --offset-s");
  return fit;
}

std::vector<ClockFit> fit_clocks(const Path& programmed, const std::vector<Path>& passes,
                                 const ClockOptions& options) {
  std::vector<ClockFit> clocks;
  for (size_t p = 0; p < passes.size(); ++p) try {
      clocks.push_back(fit_clock(programmed, passes[p], options));
    } catch (const std::invalid_argument& error) {
      throw UnusablePass(p, error.what());
    }
  if (options.fit_frame) share_frame(programmed, passes, clocks);
  return clocks;
}

void share_frame(const Path& programmed, const std::vector<Path>& passes,
                 std::vector<ClockFit>& clocks) {
  constexpr double kMaxApart = 2e-3;  // [m]: no arm repeats worse
  if (passes.size() < 2) return;
  const Pose start = clocks[0].program_from_instrument;
  const Eigen::Vector3d pivot = clocks[0].frame_pivot;
  Matrix6d covariance = Matrix6d::Zero();
  for (size_t p = 0; p < passes.size(); ++p) {
    // From one frame: a turn that a path does not show, such as about a line, is then the same.
    clocks[p].program_from_instrument = start;
    clocks[p] = refine_clock(programmed, passes[p], clocks[p], true);
    Matrix6d to_pivot = Matrix6d::Identity();
    to_pivot.topRows<3>() = clocks[p].by_frame(pivot);
    covariance += to_pivot * clocks[p].frame_covariance * to_pivot.transpose() /
                  static_cast<double>(passes.size());
  }
  const Pose common = fit_frame(programmed, passes, clocks, start);
  for (size_t p = 0; p < passes.size(); ++p) {
    const Pose own = fit_frame(programmed, {passes[p]}, {clocks[p]}, common);
    const Eigen::Matrix3Xd off =
        placed(passes[p], common).position - placed(passes[p], own).position;
    const double apart = std::sqrt(off.colwise().squaredNorm().mean());
    if (!(apart <= kMaxApart))
      throw UnusablePass(
          p, "in the frame that all passes have in common, pass " + std::to_string(p + 1) + " of " +
                 std::to_string(passes.size()) + " lies " + formatted("%.3g", apart / kMillimetre) +
                 " mm (rms) from where its own frame has it: was the instrument moved between the "
                 "passes? Give the passes of one set-up of the instrument");
    place_in(programmed, passes[p], common, clocks[p]);
    clocks[p].frame_covariance = covariance;
    clocks[p].frame_pivot = pivot;
  }
}

Eigen::Matrix<double, 3, 6> ClockFit::by_frame(const Eigen::Vector3d& point) const {
  Eigen::Matrix<double, 3, 6> result;
  result << Eigen::Matrix3d::Identity(), -cross_matrix(point - frame_pivot);
  return result;
}

std::array<Eigen::Matrix3Xd, 2> clock_errors(const Path& programmed, const Eigen::VectorXd& times,
                                             const Eigen::Matrix2d& covariance) {
  const Eigen::Matrix2d root =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(covariance)).operatorSqrt();
  const Eigen::Matrix3Xd velocity = velocity_at(programmed, times);
  const Eigen::ArrayXd from_halfway = times.array() - 0.5 * (times[0] + times[times.size() - 1]);
  const auto error = [&](Eigen::Index k) -> Eigen::Matrix3Xd {
    return velocity * (root(0, k) + root(1, k) * from_halfway).matrix().asDiagonal();
  };
  return {error(0), error(1)};
}

Path registered(const Path& measured, const ClockFit& clock) {
  Path path = placed(measured, clock.program_from_instrument);
  path.time = (measured.time.array() - clock.offset) / (1 + clock.rate);
  return path;
}

}  // namespace armtrue
