#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "armtrue/path/mirror/frame_error.h"
#include "armtrue/path/path.h"

namespace armtrue {

/// RMS deviation of the tool across its path while it moves, without the noise of the instrument
/// [m].
struct FormError {
  double rms = 0;
  std::array<double, 2> ci95{0, 0};
  /// RMS of changes faster than the form that the noise from sample to sample does not explain: a
  /// vibration of the tool, or slower noise of the instrument; 0 if not significant.
  double faster = 0;

  /// Whether the tool deviates by at most `goal` [m]; empty if the interval of the form contains
  /// the goal, or `faster` may decide.
  std::optional<bool> holds(double goal) const {
    if (std::hypot(ci95[1], faster) <= goal) return true;
    if (ci95[0] > goal) return false;
    return std::nullopt;
  }
};

/// The form error of some passes together, from their samples. `passes` are in the clock and the
/// frame of `programmed`; each has the noise of its own record.
///
/// Cosine transforms of stretches of a pass separate form and noise by frequency. A stretch ends at
/// a corner of the program, where the deviation jumps, and its two components are along axes that
/// turn with the path: noise that is the same along x, y and z is the same along both, on curves,
/// too. With z the n coefficients of a stretch, K of them up to 3.125 Hz (or half of the highest
/// frequency that the samples show, if that is lower) and S the mean of z z' from there to twice
/// the frequency,
///     form^2 = (sum over the K of |z|^2 - K tr S) / n,
/// all stretches together. So noise counts with its power near the frequencies of the form,
/// whatever its spectrum above. Noise that changes more slowly, such as correlated one, differs
/// from pass to pass, and the form does not: if several passes differ by more than S in the bands
/// of the form (p < 0.03), S of each band is that of their differences, and that of frequency 0 the
/// same as next to it: there a pass may be aside. Of one pass slow noise cannot be distinguished
/// from the form: if S is more than the noise from sample to sample (p < 0.001), the interval
/// begins at zero. The interval is that of this square, not_negative_ci95(), with the variance
///     (4 n form^2 tr(S R) / tr R + 2 K tr(S S) (1 + K / number of S)) / n^2,
/// R the sum of z z' over the K. There S is scaled to the variance that both bands show together if
/// the form is as large as the interval supposes (score interval). For `rms` a band of frequencies
/// (0, then each twice as wide as the one before) counts only if its power stands out of the noise
/// (p < 0.001), or if the standard deviation of its noise is below a tenth of the square of the
/// bands below: noise of bands without form would bias the root of a small square.
///
/// What stands out at a place for at most 0.16 s, such as a spike or the end of a step at a corner,
/// has its power far above these frequencies, too, and would count as noise. It is taken off first,
/// and its square, less the noise of its samples, is added to form^2: samples that differ from the
/// median of 0.64 s about them, alone or as the mean of 2, 4, .. neighbours, by more than noise
/// does anywhere in a pass (p < 0.001), and those beside that differ by more than nine of ten do.
///
/// The noise from sample to sample is that of second differences, sum of |x_{i-1} - 2 x_i +
/// x_{i+1}|^2 / 6. `faster` is the excess of the coefficients above the form over it (p < 0.001).
///
/// Throws std::invalid_argument if fewer than two samples are in motion.
FormError form_error(const Path& programmed, const std::vector<Path>& passes);

/// The form with the uncertainty of a fitted frame. The half widths of both add in quadrature on
/// either side of the square of the form; above, the part that the frame hides is added, too.
FormError with_frame(const FormError& form, const FrameError& frame);

/// 1 - after / before of two form errors of independent records.
struct FormReduction {
  double share = 0;
  /// On the log scale the half widths add in quadrature (Zou and Donner 2008, MOVER). Empty if the
  /// form before may be zero.
  std::optional<std::array<double, 2>> ci95;
};

/// Empty if the form before is zero.
std::optional<FormReduction> form_reduction(const FormError& before, const FormError& after);

}  // namespace armtrue
