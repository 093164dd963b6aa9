#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace armtrue {

/// Four numbers side by side: one of each of four poses. The compiler takes them in one instruction
/// where the processor has AVX2, in two elsewhere, with the same results: every operation rounds
/// each number by itself.
class Lanes {
 public:
  static constexpr int kCount = 4;
  using Values = double __attribute__((vector_size(kCount * sizeof(double))));
  using Integers = std::int64_t __attribute__((vector_size(kCount * sizeof(double))));

  Lanes() = default;
  // Every lane is that number: constants of a chain stand beside its moving parts.
  Lanes(double value) : values_{value, value, value, value} {}
  explicit Lanes(const Values& values) : values_(values) {}
  // Copied as a whole. Copies of bytes are two of 16 for GCC, and a load of all four after them
  // waits until both have left the processor's store buffer.
  Lanes(const Lanes& other) : values_(other.values_) {}
  Lanes& operator=(const Lanes& other) {
    values_ = other.values_;
    return *this;
  }

  double& operator[](int lane) { return reinterpret_cast<double*>(&values_)[lane]; }
  double operator[](int lane) const { return values_[lane]; }
  const Values& values() const { return values_; }

  friend Lanes operator+(const Lanes& a, const Lanes& b) { return Lanes(a.values_ + b.values_); }
  friend Lanes operator-(const Lanes& a, const Lanes& b) { return Lanes(a.values_ - b.values_); }
  friend Lanes operator*(const Lanes& a, const Lanes& b) { return Lanes(a.values_ * b.values_); }
  friend Lanes operator-(const Lanes& a) { return Lanes(-a.values_); }
  Lanes& operator+=(const Lanes& other) { return *this = *this + other; }

 private:
  Values values_;
};

/// Cosine and sine.
template <typename Number>
struct Turn {
  Number cosine, sine;
};

inline Turn<double> turn_by(double angle) { return {std::cos(angle), std::sin(angle)}; }

/// Within one unit in the last place of the exact values, as those of the C library, and the same
/// on every processor. Angles beyond 2^19 quarter turns are left to the C library.
///
/// The angle is reduced to [-pi/4, pi/4] by k quarter turns, pi/2 as a sum of three numbers of
/// which the products of the first two with k are exact (Cody and Waite 1980), and the polynomials
/// are the minimax ones of degree 13 and 14 that fdlibm (Sun, 1993) publishes.
inline Turn<Lanes> turn_by(const Lanes& angle) {
  using Values = Lanes::Values;
  constexpr double kRoundsToInteger = 0x1.8p52;  // when added; it stands in the lowest bits
  constexpr double kQuarterTurns = 0x1.45f306dc9c883p-1;
  constexpr double kFirst = 0x1.921fb544p0, kSecond = 0x1.0b4611a6p-34,
                   kThird = 0x1.3198a2e037073p-69;
  constexpr double kMostQuarterTurns = 1 << 19;

  const Values& x = angle.values();
  const Values shifted = x * kQuarterTurns + kRoundsToInteger;
  const Values k = shifted - kRoundsToInteger;
  const Values first = x - k * kFirst;
  const Values second = k * kSecond;
  const Values rough = first - second;
  const Values lost = k * kThird - ((first - rough) - second);
  const Values r = rough - lost;
  const Values rest = (rough - r) - lost;  // the angle is r + rest

  const Values z = r * r;
  const Values of_sine =
      8.33333333332248946124e-03 +
      z * (-1.98412698298579493134e-04 +
           z * (2.75573137070700676789e-06 +
                z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
  const Values cube = z * r;
  const Values sine =
      r - ((z * (0.5 * rest - cube * of_sine) - rest) - cube * -1.66666666666666324348e-01);
  const Values of_cosine = z * (4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 +
                                                                  z * 2.48015872894767294178e-05)) +
                           z * z * z * z *
                               (-2.75573143513906633035e-07 +
                                z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11));
  const Values half = 0.5 * z;
  const Values near_one = 1.0 - half;
  const Values cosine = near_one + (((1.0 - near_one) - half) + (z * of_cosine - r * rest));

  const auto quarter = reinterpret_cast<Lanes::Integers>(shifted);
  const auto swapped = (quarter & 1) != 0;
  const Values c = swapped ? sine : cosine, s = swapped ? cosine : sine;
  Turn<Lanes> turn{Lanes(((quarter + 1) & 2) != 0 ? -c : c), Lanes((quarter & 2) != 0 ? -s : s)};
  const auto is_near = (k <= kMostQuarterTurns) & (k >= -kMostQuarterTurns);
  if ((is_near[0] & is_near[1] & is_near[2] & is_near[3]) == 0)
    for (int lane = 0; lane < Lanes::kCount; ++lane)
      if (!is_near[lane]) {
        turn.cosine[lane] = std::cos(angle[lane]);
        turn.sine[lane] = std::sin(angle[lane]);
      }
  return turn;
}

}  // namespace armtrue
