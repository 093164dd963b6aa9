#include "path/mirror/mean_deviation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "path/mirror/corners.h"
#include "path/registration/unit_check.h"

namespace armtrue {
namespace {

// Fills the parts of the whole deviation along the program and across it. `tangent`: of the
// program.
void part_whole(const Path& programmed, const Eigen::Matrix3Xd& tangent, PathDeviation& deviation) {
  const Eigen::Index count = deviation.time.size();
  deviation.arc_length.resize(count);
  deviation.normal.resize(3, count);
  deviation.along.resize(count);
  const Eigen::VectorXd length = arc_length(programmed);
  Eigen::Index sample = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    sample = nearest_sample(programmed, deviation.time[i], sample);
    const Eigen::Vector3d along = tangent.col(sample);
    deviation.arc_length[i] = length[sample];
    deviation.along[i] = along.dot(deviation.whole.col(i));
    deviation.normal.col(i) = deviation.whole.col(i) - deviation.along[i] * along;
    sample = std::max<Eigen::Index>(sample - 1, 0);
  }
}

// Means of the deviations of passes on one grid of program times.
class DeviationGrid {
 public:
  DeviationGrid(const Path& programmed, const std::vector<Path>& measured,
                const std::vector<Pass>& passes)
      : programmed_(programmed), tangent_(side_tangents(programmed, find_corners(programmed))) {
    double begin = programmed.time[programmed.samples() - 1], end = programmed.time[0];
    for (size_t p = 0; p < measured.size(); ++p) {
      const ClockFit& clock = passes[p].clock;
      period_ = std::max(period_, median_period(measured[p]) / (1 + clock.rate));
      begin = std::min(begin, clock.program_time(measured[p].time[0]));
      end = std::max(end, clock.program_time(measured[p].time[measured[p].samples() - 1]));
      with_force_ = with_force_ && measured[p].has_force();
    }
    begin_ = std::max(begin, programmed.time[0]);
    end = std::min(end, programmed.time[programmed.samples() - 1]);
    count_ = static_cast<Eigen::Index>((end - begin_) / period_) + 1;
    weight_ = Eigen::VectorXd::Zero(count_);
    deviation_ = Eigen::Matrix3Xd::Zero(3, count_);
    force_ = Eigen::Matrix3Xd::Zero(3, with_force_ ? count_ : 0);
  }

  // Adds each reading to the nearest place of the grid: a deviation changes little in half a
  // period, and interpolation would reduce the noise of some samples only.
  void add(const Path& measured, const Eigen::Matrix3Xd& deviation, const ClockFit& clock) {
    for (Eigen::Index i = 0; i < measured.samples(); ++i) {
      const Eigen::Index place =
          std::lround((clock.program_time(measured.time[i]) - begin_) / period_);
      if (place < 0 || place >= count_) continue;
      weight_[place] += 1;
      deviation_.col(place) += deviation.col(i);
      if (with_force_)
        force_.col(place) += clock.program_from_instrument.rotation * measured.force.col(i);
    }
  }

  // The means; places without a reading are filled by interpolation.
  PathDeviation mean() {
    for (Eigen::Index i = 0; i < count_; ++i) {
      if (weight_[i] == 0) continue;
      deviation_.col(i) /= weight_[i];
      if (with_force_) force_.col(i) /= weight_[i];
    }
    fill_gaps();
    PathDeviation result;
    result.period = period_;
    result.time = Eigen::VectorXd::LinSpaced(count_, begin_,
                                             begin_ + period_ * static_cast<double>(count_ - 1));
    result.force = std::move(force_);
    result.whole = std::move(deviation_);
    part_whole(programmed_, tangent_, result);
    return result;
  }

 private:
  void fill_gaps() {
    Eigen::Index known = -1;
    for (Eigen::Index i = 0; i < count_; ++i) {
      if (weight_[i] == 0) continue;
      for (Eigen::Index k = known + 1; k < i; ++k) {
        const double share =
            known < 0 ? 1 : static_cast<double>(k - known) / static_cast<double>(i - known);
        const Eigen::Index from = std::max<Eigen::Index>(known, 0);
        const auto fill = [&](Eigen::Matrix3Xd& values) {
          values.col(k) =
              share * values.col(i) + (1 - share) * (known < 0 ? Eigen::Vector3d::Zero().eval()
                                                               : Eigen::Vector3d(values.col(from)));
        };
        fill(deviation_);
        if (with_force_) fill(force_);
      }
      known = i;
    }
    for (Eigen::Index k = known + 1; k < count_; ++k) {
      deviation_.col(k) = deviation_.col(known);
      if (with_force_) force_.col(k) = force_.col(known);
    }
  }

  const Path& programmed_;
  Eigen::Matrix3Xd tangent_;
  double period_ = 0, begin_ = 0;
  bool with_force_ = true;
  Eigen::Index count_ = 0;
  Eigen::VectorXd weight_;
  Eigen::Matrix3Xd deviation_, force_;
};

int lost_samples(const Path& measured) {
  const double period = median_period(measured);
  int lost = 0;
  for (Eigen::Index i = 1; i < measured.samples(); ++i)
    lost += static_cast<int>(std::lround((measured.time[i] - measured.time[i - 1]) / period)) - 1;
  return lost;
}

double longest_gap(const Path& measured) {
  const double period = median_period(measured);
  double longest = 0;
  for (Eigen::Index i = 1; i < measured.samples(); ++i) {
    const double gap = measured.time[i] - measured.time[i - 1];
    if (gap > 1.5 * period) longest = std::max(longest, gap);
  }
  return longest;
}

// Registers one record, see register_passes().
Pass register_pass(const Path& programmed, Path& record, size_t which,
                   const ClockOptions& options) {
  Pass pass;
  pass.samples = record.samples();
  pass.lost = lost_samples(record);
  const auto check_number = [&] {
    if (!too_many(pass.bad, record)) return;
    check_units(programmed, record);  // readings in another unit look bad too
    throw TooManyBadSamples(which, pass.bad);
  };
  pass.bad = find_bad_samples(programmed, record);
  check_number();
  pass.clock = fit_clock(programmed, without(record, pass.bad), options);
  Path deviation = registered(record, pass.clock);
  const Eigen::Matrix3Xd wanted = position_at(programmed, deviation.time);
  deviation.position -= wanted;
  const size_t known = pass.bad.size();
  pass.bad = find_bad_deviations(deviation, wanted, pass.bad);
  check_number();
  record = without(record, pass.bad);
  if (pass.bad.size() != known) pass.clock = fit_clock(programmed, record, options);
  pass.longest_gap = longest_gap(record);
  return pass;
}

// Measured minus programmed, each sample at its own time.
Eigen::Matrix3Xd deviations(const Path& programmed, const Path& measured, const ClockFit& clock) {
  Path own = registered(measured, clock);
  own.position -= position_at(programmed, own.time);
  return std::move(own.position);
}

// The mean of the passes [first, last).
PathDeviation mean_of(const Path& programmed, const std::vector<Path>& measured,
                      const std::vector<Pass>& passes, size_t first, size_t last) {
  DeviationGrid grid(programmed, measured, passes);
  for (size_t p = first; p < last; ++p)
    grid.add(measured[p], deviations(programmed, measured[p], passes[p].clock), passes[p].clock);
  return grid.mean();
}

}  // namespace

AcrossInMotion across_in_motion(const Path& programmed, const Eigen::Matrix3Xd& tangent,
                                const Path& pass) {
  const Eigen::Matrix3Xd velocity = velocity_at(programmed, pass.time);
  const Eigen::Matrix3Xd wanted = position_at(programmed, pass.time);
  AcrossInMotion across{Eigen::Matrix3Xd(3, pass.samples()), {}};
  Eigen::Index count = 0, nearest = 0;
  for (Eigen::Index i = 0; i < pass.samples(); ++i) {
    nearest = nearest_sample(programmed, pass.time[i], nearest);
    if (velocity.col(i).isZero(0)) continue;
    const Eigen::Vector3d deviation = pass.position.col(i) - wanted.col(i);
    across.deviation.col(count++) =
        deviation - tangent.col(nearest).dot(deviation) * tangent.col(nearest);
    across.nearest.push_back(nearest);
  }
  across.deviation.conservativeResize(3, count);
  return across;
}

Eigen::Index nearest_sample(const Path& path, double time, Eigen::Index from) {
  const Eigen::Index last = path.samples() - 1;
  while (from < last && path.time[from + 1] <= time) ++from;
  if (from < last && path.time[from + 1] - time < time - path.time[from]) return from + 1;
  return from;
}

std::vector<Pass> register_passes(const Path& programmed, std::vector<Path>& records,
                                  const ClockOptions& options) {
  std::vector<Pass> passes;
  for (size_t p = 0; p < records.size(); ++p)
    try {
      passes.push_back(register_pass(programmed, records[p], p, options));
    } catch (const TooManyBadSamples&) {
      throw;
    } catch (const std::invalid_argument& error) {
      throw UnusablePass(p, error.what());
    }
  if (options.fit_frame) {
    std::vector<ClockFit> clocks;
    for (const Pass& pass : passes) clocks.push_back(pass.clock);
    share_frame(programmed, records, clocks);
    for (size_t p = 0; p < passes.size(); ++p) passes[p].clock = clocks[p];
  }
  return passes;
}

PathDeviation mean_deviation(const Path& programmed, const std::vector<Path>& measured,
                             const std::vector<Pass>& passes) {
  PathDeviation deviation = mean_of(programmed, measured, passes, 0, measured.size());
  const double halfway = 0.5 * (deviation.time[0] + deviation.time[deviation.time.size() - 1]);
  for (const Pass& pass : passes)
    deviation.clock_covariance += pass.clock.covariance_at(halfway) / std::pow(passes.size(), 2);
  return deviation;
}

PathDeviation from_executed(PathDeviation deviation, const Path& programmed,
                            const Eigen::Matrix3Xd& executed) {
  Path run = programmed;
  run.position = executed;
  deviation.whole -= position_at(run, deviation.time) - position_at(programmed, deviation.time);
  part_whole(programmed, side_tangents(programmed, find_corners(programmed)), deviation);
  return deviation;
}

PathDeviation deviation_of_pass(const Path& programmed, const std::vector<Path>& measured,
                                const std::vector<Pass>& passes, size_t which) {
  return mean_of(programmed, measured, passes, which, which + 1);
}

}  // namespace armtrue
