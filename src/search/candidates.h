#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/catalogue.h"
#include "search/scan.h"

namespace armtrue {

/// The effects of the catalogue that this campaign could show, with inner values (t*, tau) on a
/// grid.
std::vector<Candidate> catalogue_candidates(const Catalogue& catalogue, const Robot& robot,
                                            const Campaign& campaign);

/// The families of the catalogue with two members or more, each as one candidate with all its
/// effects among `singles`.
std::vector<Candidate> family_candidates(const std::vector<Candidate>& singles, const Robot& robot,
                                         const Campaign& campaign);

/// The least and the largest torque of gravity on a joint over its travel [N m]; nothing if gravity
/// does not turn it, or if the robot file states no masses.
std::optional<std::pair<double, double>> gravity_torques(const Robot& robot, int joint);

/// tanh(x / T) of a driver in this range: T is `share` of its largest amount.
Shape saturating_at(double share, const std::pair<double, double>& range);

/// Sets the range of a series over places to a cube around those of the campaign.
void set_range_of_places(const Robot& robot, const Campaign& campaign, Shape& shape);

/// Whether a candidate may be chosen: no member of a family whose effects occur together.
inline bool may_be_alone(const Candidate& candidate) {
  return !candidate.only_together || !candidate.effect.members.empty();
}

/// Every parameter with every driver, in bases that assume no cause.
std::vector<Candidate> open_candidates(const Robot& robot, const Campaign& campaign);

/// Whether the base or a length follows a joint angle, or a length has a step in time: no rigid arm
/// does that. The travel of a prismatic joint is no angle: a rail that is not straight shifts the
/// arm.
bool is_of_no_arm(const Effect& effect, const KinematicChain& chain);

/// A step or kink at every place of its driver (time or a joint angle) between two readings, no
/// nearer to the ends than the scan looks; with very many readings, at evenly chosen places.
std::vector<Candidate> steps_anywhere(const Candidate& step, const Campaign& campaign);

/// Steps of a frequency within one step of a periodogram.
inline constexpr int kFinerSteps = 100;

/// A cycle of a periodogram at the frequencies n + k step, k = first, first + stride, ..., with n
/// its own and step a hundredth of that of the periodogram.
std::vector<Candidate> cycles_near(const Candidate& found, int first, int last, int stride);

/// The same effect with finer inner values around its own; empty if its shape has none but the
/// frequency of a cycle.
std::vector<Candidate> refined_candidates(const Candidate& candidate, const Campaign& campaign);

}  // namespace armtrue
