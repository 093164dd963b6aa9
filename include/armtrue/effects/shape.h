#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace armtrue {

/// How a parameter follows its driver x.
enum class ShapeKind {
  linear,       ///< x - at
  harmonic,     ///< sin n x, cos n x
  sign,         ///< sign of x
  step,         ///< 0 before `at`, 1 from it on
  kink,         ///< 0 before `at`, x - at from it on
  exponential,  ///< 1 - exp(-(x - at) / tau)
  pre_sliding,  ///< sign(x) (1 - 2 exp(-|x| / tau)), x the travel since the last reversal: friction
                ///< changes its sign at 0.7 tau
  series,       ///< a basis, see SeriesBasis
};

/// Bases of a series. Cosine, spline and polynomial stand on u = (x - low) / (high - low),
/// clamped to [0, 1].
enum class SeriesBasis {
  cosine,   ///< cos k pi u, k = 1 .. count
  spline,   ///< `count` cubic B-splines on uniform clamped knots, the last one left out (their sum
            ///< is 1)
  fourier,  ///< sin k x, cos k x, k = 1 .. count; x an angle
  saturating,  ///< tanh(2 u - 1), u not clamped: saturates beyond the range; one value
  bump,        ///< exp(-(2 u - 1)^2 / 2), u not clamped: one standard deviation to either side of
               ///< the middle of the range; one value
  polynomial,  ///< of a place: products of powers of 2 u - 1 of its three axes, degree 2 to `count`
};

/// A shape with its inner values.
struct Shape {
  ShapeKind kind = ShapeKind::linear;
  double harmonic = 1;  ///< n, cycles per turn; gear trains make it any number above zero
  double at = 0;        ///< of a step or kink [s, rad, or a number between two sessions]; if
                        ///< counts_from(): the origin of x [s, deg C]
  double tau = 0;       ///< exponential [s], pre_sliding [rad]

  SeriesBasis basis = SeriesBasis::cosine;
  int count = 0;                        ///< order of the series, for each driver
  std::array<double, 3> low{}, high{};  ///< range of the driver, of each of several [SI]

  bool operator==(const Shape&) const = default;
};

Shape harmonic_shape(double cycles_per_turn);
Shape sign_shape();
Shape step_shape(double at);
Shape kink_shape(double at);
Shape exponential_shape(double tau);
Shape pre_sliding_shape(double tau);
/// Over one driver, or over two angles for products of `fourier`, which has no range.
Shape series_shape(SeriesBasis basis, int count, double low = 0, double high = 0);
/// Over a place, or over two drivers: the range of each.
Shape series_shape(SeriesBasis basis, int count, const std::array<double, 3>& low,
                   const std::array<double, 3>& high);

/// Whether a shape of this kind has the inner value `at`, or `tau`.
constexpr bool has_at(ShapeKind kind) { return kind == ShapeKind::step || kind == ShapeKind::kink; }
/// Whether a shape of this kind may take x - `at` of a time or a temperature in place of x.
constexpr bool counts_from(ShapeKind kind) {
  return kind == ShapeKind::linear || kind == ShapeKind::exponential;
}
constexpr bool has_tau(ShapeKind kind) {
  return kind == ShapeKind::exponential || kind == ShapeKind::pre_sliding;
}

/// As in the files: `linear`, `harmonic 2`, `harmonic 50.5`, `sign`, `step`, `kink`,
/// `exponential`, `pre-sliding`, `series`. The other inner values (at, tau, basis, count, range)
/// stand in keys of their own.
std::string to_string(const Shape& shape);
std::optional<Shape> parse_shape(std::string_view text);

/// Number of values that a shape makes of one driver value; of two, for a series of products.
int value_count(const Shape& shape, bool two_drivers = false);

/// Their names, which are those of the coefficients in files. `count` is above value_count() for a
/// load whose basis has several values.
std::vector<std::string> value_names(const Shape& shape, int count);

/// Writes value_count() values to `out`; not of a polynomial.
void evaluate(const Shape& shape, double x, double* out);
/// Of a series of two drivers: all products of the values at x with those at x2, x slowest. Throws
/// std::invalid_argument for more than 64 values of one driver.
void evaluate_product(const Shape& shape, double x, double x2, double* out);
/// Of a polynomial at a place [m]. Terms of degree 0 and 1 are left out: most of them are a rigid
/// motion or the scale. `count` 1: the terms of degree 1 alone, a strain.
void evaluate_polynomial(const Shape& shape, const Eigen::Vector3d& place, double* out);

inline bool is_polynomial(const Shape& shape) {
  return shape.kind == ShapeKind::series && shape.basis == SeriesBasis::polynomial;
}

}  // namespace armtrue
