#include "armtrue/tracing/loop_doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "armtrue/calibration/doubts.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/diagnosis/mistakes.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/tracing/description.h"

namespace armtrue {
namespace {

// Why the result must not be used; empty if it may be.
std::string why_not_used(const Robot& robot, const LoopResult& result) {
  if (!result.trace.fit.converged) return not_converged(result.trace.fit);
  const double after = result.are_blunders ? result.after_sound : result.after;
  const std::string beyond = beyond_any_arm(robot, after, result.noise.position);
  if (!beyond.empty() || !result.worse_than_nominal) return beyond;
  const double nominal = result.stages.front().held_out.position.mean;
  return fmt::format(
      "on the held-out poses the result is worse than the nominal robot with base and tool placed: "
      "{:.4g} mm, against {:.4g}; keep the nominal robot, or measure more poses",
      result.after / kMillimetre, nominal / kMillimetre);
}

std::string common_backlash_in_words(const LoopResult& result) {
  if (!result.common_backlash) return "";
  return fmt::format(
      "the joints look as if they had one backlash, {:.2g} deg, and gears have each their own: the "
      "joint angles were not read at standstill; read the angles when the arm stands",
      std::abs(*result.common_backlash) / kDegree);
}

}  // namespace

LoopDoubts doubts_of_loop(const Robot& robot, const Campaign& training, const LoopResult& result) {
  const CalibrationResult& fit = result.trace.fit;
  const std::string not_used = why_not_used(robot, result);
  // What the others of the links err by was taken up by those that are fitted, and no pose that
  // took no part says how much.
  const bool unknown_elsewhere =
      result.held_out_poses == 0 && !lost_to_poses(robot, training, fit.set).empty();
  LoopDoubts doubts{not_shown_by_touches(robot, training, fit.set),
                    not_used.empty() && !unknown_elsewhere};
  for (const std::string& sentence :
       {result.trace.left_out ? left_out_in_words(robot, *result.trace.left_out) : "",
        lost_in_words(robot, training, fit), not_used, common_backlash_in_words(result),
        rejection_in_words(result), unknown_noise_in_words(result), result.left_out_together,
        contradiction_of_noise(robot, training, fit, result.noise)})
    if (!sentence.empty()) doubts.sentences.push_back(sentence);
  std::ranges::copy(off_and_counted(result.gross_held_out), std::back_inserter(doubts.sentences));
  return doubts;
}

}  // namespace armtrue
