#include "armtrue/effects/shape.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace armtrue {
namespace {

constexpr int kSplineDegree = 3;
constexpr int kMaxSeriesValues = 64;

// The count + 1 cubic B-splines on uniform clamped knots over [0, 1] by Cox and de Boor's
// recursion. The last one is left out: with the parameter's constant the others span the same
// curves.
void spline_values(int count, double u, double* out) {
  const int splines = count + 1;
  const int intervals = splines - kSplineDegree;
  const auto knot = [&](double i) { return std::clamp((i - kSplineDegree) / intervals, 0.0, 1.0); };
  const int interval = std::min(static_cast<int>(u * intervals), intervals - 1);
  double basis[kSplineDegree + 1] = {1.0};
  for (int degree = 1; degree <= kSplineDegree; ++degree) {
    double saved = 0.0;
    for (int k = 0; k < degree; ++k) {
      const double right = knot(interval + kSplineDegree + 1 + k);
      const double left = knot(interval + kSplineDegree + 1 + k - degree);
      const double share = basis[k] / (right - left);
      basis[k] = saved + (right - u) * share;
      saved = (u - left) * share;
    }
    basis[degree] = saved;
  }
  std::fill(out, out + count, 0.0);
  for (int k = 0; k <= kSplineDegree; ++k)
    if (interval + k < count) out[interval + k] = basis[k];
}

void series_values(const Shape& shape, int driver, double x, double* out) {
  if (shape.basis == SeriesBasis::fourier) {
    for (int k = 1; k <= shape.count; ++k) {
      out[2 * k - 2] = std::sin(k * x);
      out[2 * k - 1] = std::cos(k * x);
    }
    return;
  }
  if (shape.basis == SeriesBasis::saturating || shape.basis == SeriesBasis::bump) {
    const double z =
        (2 * x - shape.low[driver] - shape.high[driver]) / (shape.high[driver] - shape.low[driver]);
    out[0] = shape.basis == SeriesBasis::bump ? std::exp(-0.5 * z * z) : std::tanh(z);
    return;
  }
  const double u =
      std::clamp((x - shape.low[driver]) / (shape.high[driver] - shape.low[driver]), 0.0, 1.0);
  if (shape.basis == SeriesBasis::spline) return spline_values(shape.count, u, out);
  for (int k = 1; k <= shape.count; ++k) out[k - 1] = std::cos(k * std::numbers::pi * u);
}

int series_count(const Shape& shape) {
  if (shape.basis == SeriesBasis::saturating || shape.basis == SeriesBasis::bump) return 1;
  const int n = shape.count;
  if (shape.basis == SeriesBasis::polynomial)
    return n == 1 ? 3 : (n + 1) * (n + 2) * (n + 3) / 6 - 4;
  return shape.basis == SeriesBasis::fourier ? 2 * n : n;
}

struct ShapeWord {
  ShapeKind kind;
  std::string_view text;
};

constexpr ShapeWord kShapeWords[] = {
    {ShapeKind::linear, "linear"},
    {ShapeKind::harmonic, "harmonic"},
    {ShapeKind::sign, "sign"},
    {ShapeKind::step, "step"},
    {ShapeKind::kink, "kink"},
    {ShapeKind::exponential, "exponential"},
    {ShapeKind::pre_sliding, "pre-sliding"},
    {ShapeKind::series, "series"},
};

}  // namespace

Shape harmonic_shape(double cycles_per_turn) {
  return {.kind = ShapeKind::harmonic, .harmonic = cycles_per_turn};
}

Shape sign_shape() { return {.kind = ShapeKind::sign}; }

Shape step_shape(double at) { return {.kind = ShapeKind::step, .at = at}; }

Shape kink_shape(double at) { return {.kind = ShapeKind::kink, .at = at}; }

Shape exponential_shape(double tau) { return {.kind = ShapeKind::exponential, .tau = tau}; }

Shape pre_sliding_shape(double tau) { return {.kind = ShapeKind::pre_sliding, .tau = tau}; }

Shape series_shape(SeriesBasis basis, int count, double low, double high) {
  return series_shape(basis, count, std::array{low, 0.0, 0.0}, std::array{high, 0.0, 0.0});
}

Shape series_shape(SeriesBasis basis, int count, const std::array<double, 3>& low,
                   const std::array<double, 3>& high) {
  return {.kind = ShapeKind::series, .basis = basis, .count = count, .low = low, .high = high};
}

std::string to_string(const Shape& shape) {
  std::string text;
  for (const ShapeWord& word : kShapeWords)
    if (word.kind == shape.kind) text = word.text;
  if (shape.kind != ShapeKind::harmonic) return text;
  char number[32];  // shortest that reads back
  const auto end = std::to_chars(number, number + sizeof number, shape.harmonic).ptr;
  return text + " " + std::string(number, end);
}

std::optional<Shape> parse_shape(std::string_view text) {
  const size_t space = text.find(' ');
  for (const ShapeWord& word : kShapeWords) {
    if (word.text != text.substr(0, space)) continue;
    Shape shape;
    shape.kind = word.kind;
    if (word.kind != ShapeKind::harmonic)
      return space == std::string_view::npos ? std::optional(shape) : std::nullopt;
    if (space == std::string_view::npos) return std::nullopt;
    const std::string_view number = text.substr(space + 1);
    const auto [end, error] =
        std::from_chars(number.data(), number.data() + number.size(), shape.harmonic);
    const bool whole = error == std::errc{} && end == number.data() + number.size();
    const bool valid = whole && std::isfinite(shape.harmonic) && shape.harmonic > 0;
    return valid ? std::optional(shape) : std::nullopt;
  }
  return std::nullopt;
}

int value_count(const Shape& shape, bool two_drivers) {
  switch (shape.kind) {
    case ShapeKind::harmonic:
      return 2;
    case ShapeKind::series: {
      const int count = series_count(shape);
      return two_drivers ? count * count : count;
    }
    default:
      return 1;
  }
}

std::vector<std::string> value_names(const Shape& shape, int count) {
  if (shape.kind == ShapeKind::harmonic) return {"sin", "cos"};
  if (count == 1) return {"c"};
  std::vector<std::string> names;
  for (int k = 1; k <= count; ++k) names.push_back("c" + std::to_string(k));
  return names;
}

void evaluate(const Shape& shape, double x, double* out) {
  switch (shape.kind) {
    case ShapeKind::linear:
      out[0] = x - shape.at;
      return;
    case ShapeKind::harmonic:
      out[0] = std::sin(shape.harmonic * x);
      out[1] = std::cos(shape.harmonic * x);
      return;
    case ShapeKind::sign:
      out[0] = (x > 0) - (x < 0);
      return;
    case ShapeKind::step:
      out[0] = x >= shape.at ? 1.0 : 0.0;
      return;
    case ShapeKind::kink:
      out[0] = std::max(0.0, x - shape.at);
      return;
    case ShapeKind::exponential:
      out[0] = 1.0 - std::exp(-(x - shape.at) / shape.tau);
      return;
    case ShapeKind::pre_sliding:
      out[0] = ((x > 0) - (x < 0)) * (1.0 - 2.0 * std::exp(-std::abs(x) / shape.tau));
      return;
    case ShapeKind::series:
      return series_values(shape, 0, x, out);
  }
}

void evaluate_polynomial(const Shape& shape, const Eigen::Vector3d& place, double* out) {
  Eigen::Vector3d u;
  for (int axis = 0; axis < 3; ++axis)
    u[axis] = std::clamp((2 * place[axis] - shape.low[axis] - shape.high[axis]) /
                             (shape.high[axis] - shape.low[axis]),
                         -1.0, 1.0);
  for (int degree = std::min(2, shape.count); degree <= shape.count; ++degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= 0; --b)
        *out++ = std::pow(u[0], a) * std::pow(u[1], b) * std::pow(u[2], degree - a - b);
}

void evaluate_product(const Shape& shape, double x, double x2, double* out) {
  const int count = series_count(shape);
  if (count > kMaxSeriesValues)
    throw std::invalid_argument("a product series has at most 64 values");
  double first[kMaxSeriesValues], second[kMaxSeriesValues];
  series_values(shape, 0, x, first);
  series_values(shape, 1, x2, second);
  for (int a = 0; a < count; ++a)
    for (int b = 0; b < count; ++b) out[a * count + b] = first[a] * second[b];
}

}  // namespace armtrue
