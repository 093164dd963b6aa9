#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// A visit that is not of the pose whose name it has: a reading of another pose, a target that was
/// bumped, a digit that is wrong.
struct StrayVisit {
  int row;
  bool with_all;  ///< all visits of the pose stand there; `off` is then from the commanded pose
  double off;     ///< distance from the other visits of the pose [m]
  std::optional<int> fits;  ///< the row of another pose where it stands
  double beside = 0;        ///< distance from that [m]
};

/// Visits more than 2 mm from the others of their pose (no arm returns worse), and visits of poses
/// that are more than 20 mm from the commanded place (no arm, nominal or not, errs as far), if the
/// rest stands much closer: of n distances d_1 >= d_2 >= ... the first k are strays if
///     n / 2 (d_{k+1} / d_k)^(2 k) < 1e-4,
/// the chance of such a gap, at whatever k, in a law whose tail falls as that of Student's t of
/// two degrees of freedom. Fewer than half are strays. `evaluation` is that of the campaign,
/// which has points. In the order of the rows.
std::vector<StrayVisit> find_stray_visits(const Campaign& campaign, const Evaluation& evaluation);

/// A sentence with lines, poses, distances and remedy; empty if there are none.
std::string strays_in_words(const Campaign& campaign, const std::vector<StrayVisit>& strays);

/// A sentence on the visit that is farthest from its commanded place if that is more than 100 mm,
/// for readings of which no stray stands out.
std::string no_arm_in_words(const Campaign& campaign, const Evaluation& evaluation);

/// The campaign without those rows.
Campaign without_strays(const Campaign& campaign, const std::vector<StrayVisit>& strays);

/// refit_set_up() to the visits that are of their pose: least squares follow one of another pose by
/// metres.
Robot refit_to_sound(const Robot& robot, const Campaign& campaign,
                     const std::vector<std::string>& what);

}  // namespace armtrue
