#include "armtrue/path/mirror/record_doubts.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "armtrue/kinematics/pose.h"
#include "armtrue/path/mirror/path_deviation.h"
#include "armtrue/statistics/summary.h"
#include "linear_algebra/decompositions.h"
#include "path/registration/feed.h"
#include "path/registration/unit_check.h"
#include "statistics/rounding.h"

namespace armtrue {
namespace {

using Eigen::Index;

constexpr double kKnock = 1.5e-3;  // [m]
constexpr double kTimesUsual = 6;  // the median change from sample to sample
constexpr double kShareThatStays = 0.7;
constexpr Index kSamplesBeside = 10;
constexpr double kLargeDeviation = 2e-3;  // [m]: more than a machine that repeats shows in a part
constexpr double kMostOfIt = 1.0 / 3;
constexpr double kStraight = 1e-6;  // of the squared extents
constexpr double kSameVelocity = 0.2;
constexpr double kFollowed = 0.5;
constexpr Index kFewestOfShape = 20;

// Of a row of positions.
Eigen::JacobiSVD<Eigen::MatrixXd> directions(const Eigen::Matrix3Xd& positions) {
  const Eigen::MatrixXd off = positions.colwise() - positions.rowwise().mean();
  return Eigen::JacobiSVD<Eigen::MatrixXd>(off * off.transpose(),
                                           Eigen::ComputeFullU | Eigen::ComputeFullV);
}

// A straight path does not determine the rotation about it: the smallest one is taken.
Eigen::Matrix3d rotation_onto(const Eigen::Matrix3Xd& measured,
                              const Eigen::Matrix3Xd& programmed) {
  const auto own = directions(programmed);
  if (own.singularValues()[1] > kStraight * own.singularValues()[0])
    return Eigen::umeyama(measured, programmed, false).topLeftCorner<3, 3>();
  const Eigen::Vector3d to = own.matrixU().col(0), from = directions(measured).matrixU().col(0);
  return shortest_rotation(from, from.dot(to) < 0 ? -to : to);
}

// The most by which an arm that follows the program, late or rounding its corners, can change its
// deviation up to each sample since the one before [m]. A change of the programmed velocity fades
// from the difference of velocities as in a critically damped servo of the time constant T; with
// the period h of the samples
//     |change| <= h max |v(t - s) - v(t)| (1 + s / T) exp(-s / T), s >= -2 T - h,
// where the factor is 1 for s < 0: the clock of a record takes the lag of the servo, 2 T, for its
// offset, so that the arm seems to begin a corner before the program.
Eigen::VectorXd change_of_following(const Eigen::Matrix3Xd& velocity, const Eigen::VectorXd& time) {
  constexpr double kServo = 0.08;  // [s]: 2 Hz, the slowest of arms
  constexpr double kFaded = 7;     // time constants; less than 1 % is left
  Eigen::VectorXd most = Eigen::VectorXd::Zero(time.size());
  Index first = 0;
  for (Index k = 1; k < time.size(); ++k) {
    const double period = time[k] - time[k - 1];
    while (time[k] - time[first] > kFaded * kServo + period) ++first;
    for (Index i = first; i < time.size() && time[i] - time[k] <= 2 * kServo + period; ++i) {
      const double since = std::max(0.0, time[k] - time[i] - period) / kServo;
      const double left = (1 + since) * std::exp(-since);
      most[k] = std::max(most[k], period * left * (velocity.col(i) - velocity.col(k)).norm());
    }
  }
  return most;
}

std::optional<RecordStep> find_step(const Eigen::Matrix3Xd& deviation,
                                    const Eigen::Matrix3Xd& velocity, const Eigen::VectorXd& time,
                                    const std::vector<Index>& sample) {
  const Index count = deviation.cols();
  if (count < 2 * kSamplesBeside + 2) return std::nullopt;
  std::vector<double> changes;
  for (Index k = 1; k < count; ++k)
    changes.push_back((deviation.col(k) - deviation.col(k - 1)).norm());
  const double usual = std::max(kKnock, kTimesUsual * median(changes));
  const Eigen::VectorXd following = change_of_following(velocity, time);
  std::optional<RecordStep> found;
  for (Index k = kSamplesBeside; k + kSamplesBeside <= count; ++k) {
    const double jump = changes[k - 1];
    if (jump <= usual + following[k] || (found && jump <= found->moved)) continue;
    const double stays = (deviation.middleCols(k, kSamplesBeside).rowwise().mean() -
                          deviation.middleCols(k - kSamplesBeside, kSamplesBeside).rowwise().mean())
                             .norm();
    if (stays >= kShareThatStays * jump) found = RecordStep{sample[k], jump};
  }
  return found;
}

// Whether the program keeps its velocity around a sample. At a corner an arm departs from the
// program.
std::vector<bool> straight_on(const Path& programmed, const Eigen::VectorXd& time) {
  const Eigen::Matrix3Xd velocity = velocity_at(programmed, time);
  std::vector<bool> result(time.size());
  for (Index k = kSamplesBeside; k + kSamplesBeside <= time.size(); ++k) {
    const auto about = velocity.middleCols(k - kSamplesBeside, 2 * kSamplesBeside);
    const double change =
        (about.colwise() - Eigen::Vector3d(velocity.col(k))).colwise().norm().maxCoeff();
    result[k] = change <= kSameVelocity * velocity.col(k).norm();
  }
  return result;
}

// The motion of the whole record that brings it nearest to the program.
RigidDeviation nearest_motion(const Eigen::Matrix3Xd& measured,
                              const Eigen::Matrix3Xd& programmed) {
  const auto rms = [](const Eigen::Matrix3Xd& off) {
    return std::sqrt(off.colwise().squaredNorm().mean());
  };
  const Eigen::Matrix3d rotation = rotation_onto(measured, programmed);
  Eigen::Matrix3Xd joined = rotation * measured;
  const Eigen::Vector3d shift = (programmed - joined).rowwise().mean();
  joined.colwise() += shift;
  return {rms(measured - programmed), rms(joined - programmed),
          (joined - measured).rowwise().mean().norm(), rotation_log(rotation).norm()};
}

std::optional<RigidDeviation> find_rigid(const Eigen::Matrix3Xd& measured,
                                         const Eigen::Matrix3Xd& programmed) {
  const RigidDeviation motion = nearest_motion(measured, programmed);
  if (motion.before < kLargeDeviation || motion.after > kMostOfIt * motion.before)
    return std::nullopt;
  return motion;
}

// Positions minus the nearest straight motion with constant velocity.
Eigen::Matrix3Xd without_even_motion(const Eigen::Matrix3Xd& positions,
                                     const Eigen::VectorXd& time) {
  const Eigen::RowVectorXd centred = (time.array() - time.mean()).transpose();
  const Eigen::Matrix3Xd off = positions.colwise() - positions.rowwise().mean();
  const Eigen::Vector3d velocity = off * centred.transpose() / centred.squaredNorm();
  return off - velocity * centred;
}

std::optional<UnfollowedShape> find_unfollowed(const Eigen::Matrix3Xd& measured,
                                               const Eigen::Matrix3Xd& programmed,
                                               const Eigen::VectorXd& time,
                                               const std::vector<Index>& sample) {
  const Index count = time.size();
  std::optional<UnfollowedShape> found;
  for (const Index parts : {2, 4}) {
    const Index length = count / parts;
    if (length < kFewestOfShape) break;
    for (Index first = 0; first + length <= count; first += length / 2) {
      const Eigen::VectorXd own_time = time.segment(first, length);
      const auto shape = without_even_motion(programmed.middleCols(first, length), own_time);
      const double extent = std::sqrt(shape.colwise().squaredNorm().mean());
      if (extent < kLargeDeviation) continue;
      const auto record = without_even_motion(measured.middleCols(first, length), own_time);
      const double followed = shape.cwiseProduct(record).sum() / shape.squaredNorm();
      if (followed >= (found ? found->followed : kFollowed)) continue;
      found = UnfollowedShape{sample[first], sample[first + length - 1], extent, followed};
    }
  }
  return found;
}

// Deviations along the path, of the samples in motion and of those that stand before and after.
struct AlongPath {
  Eigen::MatrixXd columns;  // of a shift and a turn about the middle of the samples
  Eigen::VectorXd along;    // [m]
};

AlongPath along_path(const Eigen::Matrix3Xd& position, const Eigen::Matrix3Xd& deviation,
                     const Eigen::Matrix3Xd& tangent, const std::vector<Index>& samples) {
  AlongPath result{Eigen::MatrixXd(std::ssize(samples), 6), Eigen::VectorXd(std::ssize(samples))};
  const Eigen::Vector3d middle = position.rowwise().mean();
  for (size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d along = tangent.col(samples[i]),
                          lever = position.col(samples[i]) - middle;
    const Index row = i;
    result.columns.row(row) << along.transpose(), lever.cross(along).transpose();
    result.along[row] = along.dot(deviation.col(samples[i]));
  }
  return result;
}

// The shortest solution of least squares.
Eigen::VectorXd solved(const Eigen::MatrixXd& columns, const Eigen::VectorXd& along) {
  return Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(columns).solve(along);
}

double rms_along(const Eigen::VectorXd& values) { return std::sqrt(values.cwiseAbs2().mean()); }

std::optional<TurnedRecord> find_turn(const Eigen::Matrix3Xd& position,
                                      const Eigen::Matrix3Xd& deviation,
                                      const Eigen::Matrix3Xd& velocity) {
  constexpr double kLeastTurn = 5e-3;  // [rad]
  constexpr double kStands = 1e-6;     // [m/s]
  constexpr double kMostLeft = 1.0 / 3;
  std::vector<Index> moving, before, after;
  for (Index k = 0; k < velocity.cols(); ++k)
    if (velocity.col(k).norm() > kStands) moving.push_back(k);
  if (std::ssize(moving) < kFewestOfShape) return std::nullopt;
  for (Index k = 0; k < moving.front(); ++k) before.push_back(k);
  for (Index k = moving.back() + 1; k < velocity.cols(); ++k) after.push_back(k);
  if (std::ssize(before) < kSamplesBeside || std::ssize(after) < kSamplesBeside)
    return std::nullopt;
  Eigen::Matrix3Xd tangent = velocity.colwise().normalized();
  for (const Index k : before) tangent.col(k) = tangent.col(moving.front());
  for (const Index k : after) tangent.col(k) = tangent.col(moving.back());
  const AlongPath in_motion = along_path(position, deviation, tangent, moving);
  const Eigen::MatrixXd shift = in_motion.columns.leftCols<3>();
  const auto left_by = [&](const Eigen::MatrixXd& columns) {
    return rms_along(in_motion.along - columns * solved(columns, in_motion.along));
  };
  const Eigen::VectorXd motion = solved(in_motion.columns, in_motion.along);
  const double turned = motion.tail<3>().norm();
  if (turned < kLeastTurn || left_by(in_motion.columns) > kMostLeft * left_by(shift))
    return std::nullopt;
  // A lag of the servos and a force on the tool end where it stands.
  for (const std::vector<Index>* end : {&before, &after}) {
    const AlongPath standing = along_path(position, deviation, tangent, *end);
    const double seen = standing.along.mean(), expected = (standing.columns * motion).mean();
    if (std::abs(seen - expected) > kMostLeft * std::abs(expected)) return std::nullopt;
  }
  return TurnedRecord{turned, median({in_motion.along.begin(), in_motion.along.end()})};
}

// How the path stretches in the directions in which it extends, less for one direction than for
// another: what an arm does as easily as a stretch alike in all of them. Columns for the part along
// the path, whose directions are `tangent`; `off`: positions from their mean.
Eigen::MatrixXd unlike_stretches(const Eigen::Matrix3Xd& off, const Eigen::Matrix3Xd& tangent) {
  constexpr double kExtends = 0.01;  // of the squared extents
  const auto extents = directions(off);
  const Index count =
      (extents.singularValues().array() > kExtends * extents.singularValues()[0]).count();
  const Eigen::MatrixXd axes = extents.matrixU().leftCols(count).transpose();
  const Eigen::MatrixXd place = axes * off, way = axes * tangent;
  Eigen::MatrixXd columns(off.cols(), count * (count + 1) / 2 - 1);
  Index column = 0;
  for (Index i = 0; i < count; ++i)
    for (Index k = i + 1; k < count; ++k) {
      columns.col(column++) =
          (way.row(i).cwiseProduct(place.row(k)) + way.row(k).cwiseProduct(place.row(i)));
      if (k == i + 1)
        columns.col(column++) =
            (way.row(i).cwiseProduct(place.row(i)) - way.row(k).cwiseProduct(place.row(k)));
    }
  return columns;
}

// A scale is alike in all directions. It is told if it leaves little but noise, and explains far
// more beside stretches that differ between directions than these do beside it.
std::optional<double> find_scale(const Eigen::Matrix3Xd& position,
                                 const Eigen::Matrix3Xd& deviation,
                                 const Eigen::Matrix3Xd& velocity, const Eigen::VectorXd& time,
                                 double noise) {
  constexpr double kLeastScale = 5e-3, kMostLeft = 0.25, kTimesUnlike = 2;
  std::vector<Index> moving;
  for (Index k = 0; k < velocity.cols(); ++k)
    if (!velocity.col(k).isZero(0)) moving.push_back(k);
  if (std::ssize(moving) < kFewestOfShape) return std::nullopt;
  const AlongPath path = along_path(position, deviation, velocity.colwise().normalized(), moving);
  const Eigen::Matrix3Xd place = position(Eigen::all, moving), moves = velocity(Eigen::all, moving);
  const Eigen::Matrix3Xd off = place.colwise() - Eigen::Vector3d(position.rowwise().mean());
  const Eigen::Matrix3Xd way = moves.colwise().normalized();
  const Eigen::VectorXd speed = moves.colwise().norm().transpose();
  const Eigen::VectorXd since = time(moving).array() - time.mean();
  Eigen::MatrixXd known(path.along.size(), 8);
  known << path.columns, speed, speed.cwiseProduct(since);
  Eigen::VectorXd solution;
  const auto left_beside = [&](const Eigen::MatrixXd& more) {
    Eigen::MatrixXd columns(known.rows(), known.cols() + more.cols());
    columns << known, more;
    solution = solved(columns, path.along);
    return (path.along - columns * solution).squaredNorm();
  };
  const Eigen::MatrixXd unlike = unlike_stretches(off, way);
  const Eigen::VectorXd alike = way.cwiseProduct(off).colwise().sum().transpose();
  Eigen::MatrixXd both(unlike.rows(), unlike.cols() + 1);
  both << unlike, alike;
  const double noises = static_cast<double>(path.along.size()) * noise * noise;
  const double before = left_beside(Eigen::MatrixXd(known.rows(), 0)) - noises;
  const double by_both = left_beside(both), by_unlike = left_beside(unlike);
  const double by_scale = left_beside(alike);
  if (std::abs(solution[8]) < kLeastScale || by_scale - noises > kMostLeft * before ||
      by_unlike - by_both < kTimesUnlike * (by_scale - by_both))
    return std::nullopt;
  return solution[8];
}

std::optional<OpenRecord> find_open(const Path& programmed, const Eigen::Matrix3Xd& deviation,
                                    const Eigen::Matrix3Xd& velocity,
                                    const std::vector<bool>& straight_on,
                                    const std::vector<Index>& sample) {
  constexpr double kSamePlace = 1e-5;  // [m]
  constexpr double kStands = 1e-6;     // [m/s]
  constexpr double kUsual = 0.95;      // a knock makes the others
  const Index count = deviation.cols();
  const Eigen::Vector3d across_ends =
      programmed.position.rightCols<1>() - programmed.position.leftCols<1>();
  if (across_ends.norm() > kSamePlace) return std::nullopt;
  Index begin = 0, end = count;
  while (begin < count && velocity.col(begin).norm() <= kStands) ++begin;
  while (end > begin && velocity.col(end - 1).norm() <= kStands) --end;
  if (begin < kSamplesBeside || count - end < kSamplesBeside || end - begin < 6 * kSamplesBeside)
    return std::nullopt;
  const auto mean_from = [&](Index k) -> Eigen::Vector3d {
    return deviation.middleCols(k, kSamplesBeside).rowwise().mean();
  };
  double starts = 0, stops = 0, bends = 0;
  std::vector<double> smooth;
  for (Index k = kSamplesBeside; k + kSamplesBeside <= count; ++k) {
    const double change = (mean_from(k) - mean_from(k - kSamplesBeside)).norm();
    if (k <= begin + 2 * kSamplesBeside)
      starts = std::max(starts, change);
    else if (k >= end - 2 * kSamplesBeside)
      stops = std::max(stops, change);
    else if (straight_on[k])
      smooth.push_back(change);
    else
      bends = std::max(bends, change);
  }
  if (!smooth.empty()) bends = std::max(bends, quantile(std::move(smooth), kUsual));
  const OpenRecord found{
      sample[begin], sample[end - 1],
      (mean_from(count - kSamplesBeside) - mean_from(begin - kSamplesBeside)).norm(),
      starts + bends + stops};
  if (found.apart <= found.changes) return std::nullopt;
  return found;
}

std::optional<TimeLag> find_lag(const Eigen::Matrix3Xd& deviation,
                                const Eigen::Matrix3Xd& velocity) {
  constexpr size_t kQuarters = 4;
  constexpr double kMoves = 0.5;  // of the median speed; slower samples show the noise
  std::vector<double> speeds;
  for (const auto& v : velocity.colwise())
    if (v.norm() > 0) speeds.push_back(v.norm());
  if (speeds.empty()) return std::nullopt;
  TimeLag lag{0, 0, 0, median(speeds), 0};
  std::vector<double> later, across;
  for (Index k = 0; k < velocity.cols(); ++k) {
    if (velocity.col(k).norm() <= kMoves * lag.speed) continue;
    later.push_back(-velocity.col(k).dot(deviation.col(k)) / velocity.col(k).squaredNorm());
    across.push_back((deviation.col(k) + later.back() * velocity.col(k)).norm());
  }
  const size_t length = later.size() / kQuarters;
  if (std::cmp_less(length, kFewestOfShape)) return std::nullopt;
  std::vector<double> quarters;
  for (size_t i = 0; i < kQuarters; ++i) {
    const auto begin = later.begin() + i * length;
    quarters.push_back(median({begin, begin + length}));
  }
  lag.median = median(later);
  const auto upper = across.begin() + std::ssize(across) * 3 / 4;
  std::ranges::nth_element(across, upper);
  lag.across = *upper;
  lag.earliest = std::ranges::min(quarters);
  lag.latest = std::ranges::max(quarters);
  return lag;
}

}  // namespace

bool looks_computed(const Path& programmed, const Path& record) {
  constexpr double kNoInstrument = 1e-7;  // [m]
  if (!record.has_times_of(programmed)) return false;
  const std::optional<double> noise = noise_of_samples(record);
  return noise && *noise < kNoInstrument;
}

namespace {

// Whether the values stand in the program's in this order, some left out, or are all the same.
bool is_copy(const Eigen::RowVectorXd& programmed, const Eigen::RowVectorXd& values) {
  constexpr double kLastDigit = 1e-9;  // [m]
  if (values.maxCoeff() - values.minCoeff() < kLastDigit) return true;
  Index next = 0;
  for (const double value : values) {
    while (next < programmed.size() && std::abs(programmed[next] - value) >= kLastDigit) ++next;
    if (next == programmed.size()) return false;
  }
  return true;
}

// The largest power of ten of which all are multiples [m].
double step_of(const Eigen::RowVectorXd& values) {
  constexpr double kFinest = 1e-9;
  for (double step = 1e-2; step > kFinest; step /= 10)
    if (last_digits({values.begin(), values.end()}, step)) return step;
  return kFinest;
}

}  // namespace

std::vector<Index> find_copied_coordinates(const Path& programmed, const Path& record) {
  Path measured = record;
  std::vector<Index> copied;
  double step = 0;
  for (Index axis = 0; axis < 3; ++axis) {
    const Eigen::RowVectorXd values = record.position.row(axis);
    if (is_copy(programmed.position.row(axis), values)) {
      copied.push_back(axis);
      measured.position.row(axis).setZero();
    } else {
      step = std::max(step, step_of(values));
    }
  }
  const std::optional<double> noise = noise_of_samples(measured);
  // A quarter more: that of the coordinates that are left.
  if (copied.size() == 3 || !noise || *noise <= step) return {};
  return copied;
}

std::optional<std::pair<Index, Index>> find_copy(const Path& record, const Path& other) {
  constexpr Index kWindow = 20, kPlaces = 4;
  constexpr double kStepsOfNoise = 10;
  const std::optional<double> noise = noise_of_samples(record);
  double step = 0;
  for (Index axis = 0; axis < 3; ++axis)
    for (const Path* path : {&record, &other})
      step = std::max(step, step_of(path->position.row(axis)));
  if (!noise || *noise < kStepsOfNoise * step) return std::nullopt;
  // Whether both have moved alike from one sample of each to another.
  const auto alike = [&](Index i, Index k, Index steps) {
    return i + steps >= 0 && k + steps >= 0 && i + steps < record.samples() &&
           k + steps < other.samples() &&
           ((record.position.col(i + steps) - record.position.col(i)) -
            (other.position.col(k + steps) - other.position.col(k)))
                   .cwiseAbs()
                   .maxCoeff() <= 2 * step;
  };
  for (Index place = 1; place < kPlaces; ++place) {
    const Index i = record.samples() * place / kPlaces;
    for (Index k = 0; k + kWindow < other.samples(); ++k) {
      Index after = 0;
      while (alike(i, k, after + 1)) ++after;
      if (after < kWindow) continue;
      Index before = 0;
      while (alike(i, k, -before - 1)) ++before;
      if (2 * (before + after) >= std::min(record.samples(), other.samples()))
        return std::pair(i - before, k - before);
    }
  }
  return std::nullopt;
}

double interpolated_share(const Path& record) {
  constexpr double kFewestKnots = 0.05, kStepsOfNoise = 10;
  double step = 0;
  for (Index axis = 0; axis < 3; ++axis) step = std::max(step, step_of(record.position.row(axis)));
  Index between = 0, knots = 0;
  double square = 0, with_next = 0;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (Index i = 1; i + 1 < record.samples(); ++i) {
    const Eigen::Vector3d bend =
        record.position.col(i - 1) - 2 * record.position.col(i) + record.position.col(i + 1);
    if (bend.cwiseAbs().maxCoeff() <= 2 * step) {
      ++between;
      continue;
    }
    knots += bend.norm() > kStepsOfNoise * step;
    square += bend.squaredNorm();
    with_next += bend.dot(last);
    last = bend;
  }
  const auto samples = static_cast<double>(record.samples());
  // Bends of a curve have one sign, those of noise alternate.
  if (2 * between <= record.samples() || static_cast<double>(knots) < kFewestKnots * samples ||
      with_next >= -0.25 * square)
    return 0;
  return static_cast<double>(between) / samples;
}

std::optional<FrozenCoordinate> find_frozen_coordinate(const Path& record) {
  constexpr double kNoChance = 1e-6, kLeastShare = 0.1, kStepsOfNoise = 10;
  const Index samples = record.samples();
  std::optional<FrozenCoordinate> found;
  const std::optional<double> noise = noise_of_samples(record);
  for (Index axis = 0; axis < 3; ++axis) {
    const Eigen::RowVectorXd values = record.position.row(axis);
    if (!noise || *noise < kStepsOfNoise * step_of(values)) continue;
    const auto others_change = [&](Index k) {
      for (Index other = 0; other < 3; ++other)
        if (other != axis && record.position(other, k) == record.position(other, k - 1))
          return false;
      return true;
    };
    Index equal = 0, first = 0, longest = 0, begin = 0;
    for (Index k = 1; k < samples; ++k) {
      const bool is_equal = values[k] == values[k - 1];
      equal += is_equal;
      if (!is_equal || !others_change(k)) begin = k;
      if (k - begin <= longest) continue;
      longest = k - begin;
      first = begin;
    }
    if (longest == 0 || longest == samples - 1) continue;
    const double share = std::max(kLeastShare, static_cast<double>(equal - longest) /
                                                   static_cast<double>(samples - 1 - longest));
    if (std::log(static_cast<double>(samples)) + static_cast<double>(longest) * std::log(share) >=
        std::log(kNoChance))
      continue;
    if (!found || longest > found->last - found->first)
      found = FrozenCoordinate{axis, first, first + longest};
  }
  return found;
}

namespace {

std::optional<std::string> feed_of(const Path& programmed, const Path& joined,
                                   const Path& measured) {
  const auto is_near = [&](Eigen::Index sample, Eigen::Index of_program) {
    return (joined.position.col(sample) - programmed.position.col(of_program)).norm() <
           kLargeDeviation;
  };
  if (!is_near(0, 0) || !is_near(joined.samples() - 1, programmed.samples() - 1))
    return std::nullopt;
  const auto feed = find_other_feed(programmed, measured);
  if (!feed) return std::nullopt;
  return in_words(*feed);
}

}  // namespace

RecordDoubts record_doubts(const Path& programmed, const Path& measured, const ClockFit& clock,
                           const std::vector<BadSample>& bad) {
  const Path joined = registered(measured, clock);
  std::vector<bool> taken(measured.samples(), true);
  for (const BadSample& one : bad) taken[one.sample] = false;
  std::vector<Index> good;
  for (Index k = 0; k < measured.samples(); ++k)
    if (taken[k] && joined.time[k] >= programmed.time[0] &&
        joined.time[k] <= programmed.time[programmed.samples() - 1])
      good.push_back(k);
  if (good.size() < 3) return {};
  const Eigen::Matrix3Xd position = joined.position(Eigen::all, good);
  const Eigen::Matrix3Xd wanted = position_at(programmed, joined.time(good));
  const Eigen::VectorXd time = joined.time(good);
  const Eigen::Matrix3Xd deviation = position - wanted, velocity = velocity_at(programmed, time);
  const std::vector<bool> straight = straight_on(programmed, time);
  auto aside = find_aside(programmed, without(joined, bad));
  if (aside && std::abs(aside->left) < kLargeDeviation) aside.reset();
  const auto step = aside ? std::nullopt : find_step(deviation, velocity, time, good);
  const auto rigid = aside || step ? std::nullopt : find_rigid(position, wanted);
  const auto turned =
      aside || step || rigid ? std::nullopt : find_turn(wanted, deviation, velocity);
  const auto open = aside || step || turned
                        ? std::nullopt
                        : find_open(programmed, deviation, velocity, straight, good);
  const auto pause = find_pause(programmed, without(measured, bad));
  const auto scaled = aside || step
                          ? std::nullopt
                          : find_scale(wanted, deviation, velocity, time,
                                       noise_of_samples(without(measured, bad)).value_or(0));
  RecordDoubts doubts{aside,
                      step,
                      rigid,
                      turned,
                      scaled,
                      open,
                      pause ? std::nullopt : find_unfollowed(position, wanted, time, good),
                      find_lag(deviation, velocity),
                      pause ? std::nullopt : feed_of(programmed, joined, without(measured, bad)),
                      pause,
                      {}};
  if (aside || step || rigid || turned || scaled || pause || doubts.unfollowed) return doubts;
  if (const RigidDeviation motion = nearest_motion(position, wanted);
      motion.after > kLargeDeviation)
    doubts.other_shape = motion;
  return doubts;
}

}  // namespace armtrue
