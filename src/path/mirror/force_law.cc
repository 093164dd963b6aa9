#include "armtrue/path/mirror/force_law.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "armtrue/path/joint_path.h"
#include "armtrue/path/path.h"
#include "armtrue/path/registration/clock.h"
#include "linear_algebra/decompositions.h"
#include "path/mirror/corners.h"

namespace armtrue {
namespace {

constexpr double kMinForceToNoise = 3;        // ratio of RMS; below it a force is unknown
constexpr double kRelativeRank = 1e-6;        // of a force's RMS: less is rounding
constexpr double kMinOwnStep = 0.05;          // share of a step that the other steps do not explain
constexpr double kLeastExtent = 0.1;          // of the path, over its longest
constexpr double kMinDirectionChange = 1e-3;  // of the 2 of a reversal: a filter rounds to less

double rms(const Eigen::MatrixXd& values) {
  return std::sqrt(values.squaredNorm() /
                   static_cast<double>(std::max<Eigen::Index>(values.size(), 1)));
}

// The regressors of the deviation without force: a constant; the places of the tool, from their
// mean, along the directions in which the path extends; and half the direction of each axis that
// reverses, so that its coefficient is a whole step.
struct Unforced {
  Eigen::MatrixXd columns;  // n x (1 + places + steps)
  std::vector<ReversalStep> steps;
};

// `values` (n x m) minus their projection on the columns.
Eigen::MatrixXd unexplained(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& values) {
  if (columns.cols() == 0) return values;
  const Eigen::MatrixXd normal = columns.transpose() * columns;
  return values - columns * normal.ldlt().solve(columns.transpose() * values);
}

// Positions (3 x n) from their mean, along the principal directions in which they extend.
Eigen::MatrixXd places_from_mean(const Eigen::Matrix3Xd& place) {
  if (place.cols() == 0) return {};
  const Eigen::Matrix3Xd apart = place.colwise() - place.rowwise().mean();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(apart * apart.transpose());
  const Eigen::Vector3d& power = solver.eigenvalues();
  const Eigen::Index extends = (power.array() > kLeastExtent * kLeastExtent * power[2]).count();
  return apart.transpose() * solver.eigenvectors().rightCols(extends);
}

Unforced unforced(const ForceRecord& record) {
  const Eigen::MatrixXd& direction = record.direction;
  const Eigen::MatrixXd places = places_from_mean(record.place);
  Unforced result{Eigen::MatrixXd::Ones(record.deviation.cols(), 1 + places.cols()), {}};
  Eigen::MatrixXd& columns = result.columns;
  if (places.cols() > 0) columns.rightCols(places.cols()) = places;
  for (Eigen::Index axis = 0; axis < direction.rows(); ++axis) {
    const Eigen::VectorXd row = direction.row(axis).transpose();
    if (row.maxCoeff() - row.minCoeff() < kMinDirectionChange) continue;
    const Eigen::VectorXd column = (row.array() - row.mean()) / 2;
    if (unexplained(columns, column).norm() > kMinOwnStep * column.norm()) {
      columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
      columns.rightCols(1) = column;
      result.steps.push_back({{axis}, {}});
      continue;
    }
    if (result.steps.empty()) continue;
    const auto steps = columns.rightCols(std::ssize(result.steps));
    Eigen::Index most_like = 0;
    (steps.transpose() * column)
        .cwiseAbs()
        .cwiseQuotient(steps.colwise().norm().transpose())
        .maxCoeff(&most_like);
    result.steps[most_like].axes.push_back(axis);
  }
  return result;
}

// Fewer samples than twice the unknowns.
bool has_too_few_samples(const ForceRecord& record) {
  const Eigen::Index n = record.deviation.cols();
  return n == 0 || n < 2 * (3 + unforced(record).columns.cols());
}

// One axis of the deviation, and of the errors that all its samples share (n x number of errors).
struct AxisDeviation {
  Eigen::VectorXd value;
  Eigen::MatrixXd shared;
};

AxisDeviation deviation_along(const ForceRecord& record, Eigen::Index axis) {
  AxisDeviation result{record.deviation.row(axis).transpose(),
                       Eigen::MatrixXd(record.deviation.cols(), record.shared_errors.size())};
  for (Eigen::Index k = 0; k < result.shared.cols(); ++k)
    result.shared.col(k) = record.shared_errors[k].row(axis).transpose();
  return result;
}

// Regression of a deviation on force columns with the noise covariance `noise`, and on the columns
// `beside`, which have no noise.
Regression regress(const Eigen::MatrixXd& force, const Eigen::MatrixXd& noise,
                   const Eigen::MatrixXd& beside, const AxisDeviation& deviation) {
  Eigen::MatrixXd columns(force.rows(), force.cols() + beside.cols());
  columns << force, beside;
  Eigen::MatrixXd all_noise = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
  all_noise.topLeftCorner(noise.rows(), noise.cols()) = noise;
  return regress_autocorrelated(columns, deviation.value, all_noise, deviation.shared);
}

ForceLine line(const Eigen::VectorXd& force, double noise, const Eigen::MatrixXd& beside,
               const AxisDeviation& deviation) {
  ForceLine result;
  const double observed = rms(unexplained(beside, force));
  const double floor = std::max(noise, kRelativeRank * rms(force));
  // observed^2 = force^2 + noise^2, and force > kMinForceToNoise * floor is asked for.
  if (!(observed > std::hypot(kMinForceToNoise * floor, noise)) ||
      rms(deviation.value) < kStandstill)
    return result;
  const Regression fit =
      regress(force, Eigen::MatrixXd::Constant(1, 1, noise * noise), beside, deviation);
  result.k = fit.coefficients.front();
  const double total = unexplained(beside, deviation.value).squaredNorm();
  result.r2 = total > 0 ? 1 - fit.residual.squaredNorm() / total : 0;
  return result;
}

// Principal directions of the force without its projection on the columns `beside`, strongest
// first.
std::array<ForceDirection, 3> principal_directions(const ForceRecord& record,
                                                   const Eigen::MatrixXd& beside) {
  const Eigen::MatrixXd own = unexplained(beside, record.force.transpose());
  Eigen::Matrix3d power = own.transpose() * own / static_cast<double>(own.rows());
  power.diagonal() -= record.force_noise.cwiseAbs2();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(power);
  std::array<ForceDirection, 3> directions;
  for (int i = 0; i < 3; ++i) {
    Eigen::Vector3d u = solver.eigenvectors().col(2 - i);
    Eigen::Index largest = 0;
    u.cwiseAbs().maxCoeff(&largest);
    if (u[largest] < 0) u = -u;  // of the two signs always the same
    directions[i].direction = u;
    directions[i].rms = std::sqrt(std::max(solver.eigenvalues()[2 - i], 0.0));
  }
  return directions;
}

// Fills rank, condition, compliance, offset and steps of a law, given its directions. Returns the
// deviation without force, 3 x n.
Eigen::Matrix3Xd fit_compliance(const ForceRecord& record, const Eigen::MatrixXd& beside,
                                ForceLaw& law) {
  Eigen::Matrix3Xd known(3, 0);
  for (const ForceDirection& d : law.directions) {
    const double noise = record.force_noise.cwiseProduct(d.direction).norm();
    if (!(d.rms > std::max(kMinForceToNoise * noise, kRelativeRank * rms(record.force)))) break;
    known.conservativeResize(Eigen::NoChange, known.cols() + 1);
    known.rightCols(1) = d.direction;
  }
  law.rank = static_cast<int>(known.cols());
  if (law.rank > 0) law.condition = law.directions[0].rms / law.directions[law.rank - 1].rms;
  const Eigen::MatrixXd force = record.force.transpose() * known;
  const Eigen::Matrix3d covariance = record.force_noise.cwiseAbs2().asDiagonal();
  const Eigen::MatrixXd noise = known.transpose() * covariance * known;
  Eigen::Matrix3Xd without_force(3, record.deviation.cols());
  for (size_t a = 0; a < 3; ++a) {
    const Eigen::Index axis = a;
    const AxisDeviation deviation = deviation_along(record, axis);
    const Regression fit = regress(force, noise, beside, deviation);
    auto coefficient = fit.coefficients.begin();
    for (int i = 0; i < law.rank; ++i, ++coefficient) {
      ForceDirection& d = law.directions[i];
      if (!d.compliance) d.compliance.emplace();
      (*d.compliance)[a] = *coefficient;
      law.compliance.row(axis) += coefficient->value * d.direction.transpose();
    }
    law.offset[a] = *coefficient;
    coefficient = fit.coefficients.end() - std::ssize(law.reversals);
    for (ReversalStep& reversal : law.reversals) reversal.step[a] = *coefficient++;
    without_force.row(axis) =
        (deviation.value - fit.residual).transpose() - law.compliance.row(axis) * record.force;
  }
  return without_force;
}

}  // namespace

ForceLaw force_law(const ForceRecord& record) {
  const Eigen::Index n = record.deviation.cols();
  const auto fits = [&](const auto& samples) { return samples.size() == 0 || samples.cols() == n; };
  if (record.force.cols() != n || !fits(record.place) || !fits(record.direction))
    throw std::invalid_argument("force law: sizes disagree");
  if (has_too_few_samples(record)) throw std::invalid_argument("force law: too few samples");
  const Unforced beside = unforced(record);
  ForceLaw law;
  for (Eigen::Index a = 0; a < 3; ++a)
    law.axis[a] = line(record.force.row(a).transpose(), record.force_noise[a], beside.columns,
                       deviation_along(record, a));
  law.directions = principal_directions(record, beside.columns);
  law.reversals = beside.steps;
  const Eigen::Matrix3Xd without_force = fit_compliance(record, beside.columns, law);
  if (law.rank > 0)
    law.magnitude = line_through_origin(record.force.colwise().norm(),
                                        (record.deviation - without_force).colwise().norm());
  return law;
}

ForceLine line_through_origin(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
  if (x.rows() != y.rows() || x.cols() != y.cols())
    throw std::invalid_argument("line: sizes disagree");
  if (x.size() < 2) throw std::invalid_argument("line: too few samples");
  return line(x.reshaped(), 0, Eigen::MatrixXd(x.size(), 0),
              {y.reshaped(), Eigen::MatrixXd(x.size(), 0)});
}

Eigen::MatrixXd motion_directions(const Eigen::MatrixXd& coordinates) {
  const Eigen::Index n = coordinates.cols();
  Eigen::MatrixXd direction = Eigen::MatrixXd::Zero(coordinates.rows(), n);
  for (Eigen::Index axis = 0; axis < coordinates.rows(); ++axis) {
    double last = 0;
    for (Eigen::Index i = 1; i < n; ++i) {
      const double change = coordinates(axis, i) - coordinates(axis, i - 1);
      const double sign = std::abs(change) > kStandstill ? std::copysign(1.0, change) : last;
      if (last == 0 && sign != 0) direction.row(axis).head(i).setConstant(sign);
      direction(axis, i) = last = sign;
    }
  }
  return direction;
}

Eigen::Matrix3Xd deviation_from_force(const RobotModel& robot, const JointMatrix& q,
                                      const Eigen::Matrix3Xd& force) {
  if (q.cols() != force.cols()) throw std::invalid_argument("deviation from force: sizes disagree");
  Eigen::Matrix3Xd deviation(3, q.cols());
  for (Eigen::Index i = 0; i < q.cols(); ++i) {
    Context context;
    context.q = q.col(i);
    const Eigen::Vector3d free = robot.pose(context).translation;
    context.force_n = force.col(i);
    deviation.col(i) = robot.pose(context).translation - free;
  }
  return deviation;
}

std::optional<ForceLine> measured_on_predicted(const PathDeviation& deviation,
                                               const Path& programmed, const Robot& robot) {
  if (deviation.force.cols() == 0) return std::nullopt;
  const Eigen::Matrix3Xd force = interpolate(deviation.time, deviation.force, programmed.time);
  const Eigen::Matrix3Xd predicted = without_along(
      programmed, find_corners(programmed),
      deviation_from_force(RobotModel(robot), joint_path(programmed, robot.chain), force));
  return line_through_origin(interpolate(programmed.time, predicted, deviation.time),
                             deviation.normal);
}

std::optional<ForceLaw> force_law(const PathDeviation& deviation, const Path& programmed,
                                  const Eigen::MatrixXd& axes, const LowPass& filter) {
  if (deviation.force.cols() == 0) return std::nullopt;
  const Eigen::Matrix3Xd wanted = position_at(programmed, deviation.time);
  std::vector<Eigen::Index> moves;
  for (Eigen::Index i = 1; i + 1 < wanted.cols(); ++i)
    if ((wanted.col(i + 1) - wanted.col(i - 1)).norm() > kStandstill) moves.push_back(i);
  const auto moving = [&](const Eigen::MatrixXd& samples) -> Eigen::MatrixXd {
    return filter(samples)(Eigen::all, moves);
  };
  ForceRecord record;
  record.deviation = moving(deviation.whole);
  record.force = moving(deviation.force);
  record.force_noise = deviation.engagement.noise * std::sqrt(filter.noise_share());
  record.place = moving(wanted);
  record.direction = moving(motion_directions(axes));
  for (const Eigen::Matrix3Xd& error :
       clock_errors(programmed, deviation.time, deviation.clock_covariance))
    record.shared_errors.push_back(moving(error));
  if (has_too_few_samples(record)) return std::nullopt;
  return force_law(record);
}

}  // namespace armtrue
