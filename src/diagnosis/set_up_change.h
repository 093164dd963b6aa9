#pragma once

#include <optional>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names the row of a campaign after which something has changed, and no column says so: the frame,
/// because the instrument was moved; the tool; the zero of a joint; the scale of the instrument or
/// the constant of its range; a camera or a board. Nothing if there is none.
///
/// In the order of the rows, of the time and of the numbers of the poses, the readings (see
/// reading_equations()) from each row on get their own value (unknowns D, beside all others of the
/// fit):
///     gain = |P_D r|^2, r the whitened residual.
/// A place counts if gain is at least a quarter of |r|^2, the median residual falls by a fifth, and
/// BIC (with the poses as readings, and a charge for the choice of the place) falls by more than
/// 20, see fall_of_bic(). An error of the arm does not depend on the order of the readings, unless
/// they are sorted by posture; so the result is a suspicion only. Where the same unknowns explain
/// more as they grow evenly from the first reading to the last, it is a drift, and told as one.
std::optional<Suspicion> find_set_up_change(const PlainFit& fit);

}  // namespace armtrue
