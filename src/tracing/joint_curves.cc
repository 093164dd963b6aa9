#include "tracing/joint_curves.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "armtrue/kinematics/parameters.h"
#include "tracing/curve_points.h"

namespace armtrue {
namespace {

constexpr double kHalfWidth = 1.959964;  // of a 95 % interval of the normal law

// One effect that a curve consists of.
struct Piece {
  const Effect* effect;
  Eigen::Index unknown;             // of the fit, of an effect with a name
  const RandomNumbers::Part* part;  // of one without; else null
};

// The effects on the zero offset of a joint that follow its own angle alone.
std::vector<Piece> pieces_of(const CalibrationResult& arm, const RandomEffects& random, int joint) {
  const int zero = zero_offset(arm.robot.chain, joint);
  const size_t names = arm.robot.effects.size() - random.lasting.size();
  std::vector<Piece> pieces;
  auto unknown = std::ssize(arm.set.kept);
  for (size_t k = 0; k < arm.robot.effects.size(); ++k) {
    const Effect& effect = arm.robot.effects[k];
    if (is_of_one_angle(effect) && effect.driver.joint == joint &&
        find_parameter(arm.robot.chain, effect.parameter) == zero)
      pieces.push_back(k < names ? Piece{&effect, unknown, nullptr}
                                 : Piece{&effect, 0, &random.numbers.of_lasting[k - names]});
    unknown += std::ssize(effect.coefficients);
  }
  return pieces;
}

// Derivatives of a curve by the unknowns of the fit, by the random numbers and by those that the
// readings do not determine.
struct Weights {
  Eigen::VectorXd unknowns, numbers, silent;
  double value = 0, named = 0;
};

Weights weights_at(double x, const std::vector<Piece>& pieces, const RandomNumbers& random) {
  Weights at{Eigen::VectorXd::Zero(random.of_unknowns.rows()),
             Eigen::VectorXd::Zero(random.of_unknowns.cols()), Eigen::VectorXd()};
  for (const Piece& piece : pieces) {
    const std::vector<Coefficient>& coefficients = piece.effect->coefficients;
    Eigen::VectorXd shape(std::ssize(coefficients));
    evaluate(piece.effect->shape, x, shape.data());
    double value = 0;
    for (Eigen::Index k = 0; k < shape.size(); ++k) value += shape[k] * coefficients[k].value;
    at.value += value;
    if (piece.part) {
      at.numbers.segment(piece.part->first, piece.part->root.cols()) +=
          piece.part->root.transpose() * shape;
      const Eigen::VectorXd silent = piece.part->silent.transpose() * shape;
      at.silent.conservativeResize(at.silent.size() + silent.size());
      at.silent.tail(silent.size()) = silent;
    } else {
      at.named += value;
      at.unknowns.segment(piece.unknown, shape.size()) += shape;
    }
  }
  return at;
}

void add(Weights& sum, const Weights& more, double times) {
  sum.unknowns += times * more.unknowns;
  sum.numbers += times * more.numbers;
  sum.silent += times * more.silent;
  sum.value += times * more.value;
  sum.named += times * more.named;
}

}  // namespace

std::vector<JointCurve> joint_curves(const CalibrationResult& arm, const RandomEffects& random,
                                     const Campaign& campaign) {
  const RandomNumbers& numbers = random.numbers;
  const Eigen::LLT<Eigen::MatrixXd> precision(numbers.precision);
  const Eigen::Index unknowns = numbers.of_unknowns.rows();
  const auto beside = arm.covariance.topLeftCorner(unknowns, unknowns);
  std::vector<JointCurve> curves;
  for (int joint = 0; joint < joint_count(arm.robot.chain); ++joint) {
    const std::vector<Piece> pieces = pieces_of(arm, random, joint);
    if (pieces.empty()) continue;
    Weights mean = weights_at(campaign.q[0][joint], pieces, numbers);
    add(mean, mean, -1);
    double low = campaign.q[0][joint], high = low;
    for (const JointVector& q : campaign.q) {
      add(mean, weights_at(q[joint], pieces, numbers), 1.0 / campaign.rows());
      low = std::min(low, q[joint]);
      high = std::max(high, q[joint]);
    }
    int points = 0;
    for (const Piece& piece : pieces) points = std::max(points, curve_points(piece.effect->shape));
    JointCurve curve{joint, {}, {}};
    Eigen::MatrixXd of_unknowns(unknowns, points), of_numbers(numbers.of_unknowns.cols(), points);
    Eigen::VectorXd of_silent(points);
    for (int i = 0; i < points; ++i) {
      const double x = low + (high - low) * i / (points - 1);
      Weights at = weights_at(x, pieces, numbers);
      add(at, mean, -1);
      of_unknowns.col(i) = at.unknowns;
      of_numbers.col(i) = at.numbers;
      of_silent[i] = at.silent.squaredNorm();
      curve.points.push_back({x, at.value, 0});
      curve.named.push_back(at.named);
    }
    of_numbers += numbers.of_unknowns.transpose() * of_unknowns;
    precision.matrixL().solveInPlace(of_numbers);
    for (int i = 0; i < points; ++i) {
      const auto own = of_unknowns.col(i);
      const double variance =
          own.dot(beside * own) + of_numbers.col(i).squaredNorm() + of_silent[i];
      curve.points[i].half_width = kHalfWidth * std::sqrt(std::max(0.0, variance));
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace armtrue
