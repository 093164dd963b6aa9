#include "armtrue/diagnosis/suspicions.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "armtrue/calibration/gross_poses.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/campaign/without_rows.h"
#include "diagnosis/coupling_check.h"
#include "diagnosis/depth_check.h"
#include "diagnosis/early_angles.h"
#include "diagnosis/far_set_up_change.h"
#include "diagnosis/gravity_check.h"
#include "diagnosis/gravity_direction.h"
#include "diagnosis/impossible_change.h"
#include "diagnosis/plain_fit.h"
#include "diagnosis/rounding_check.h"
#include "diagnosis/scale_check.h"
#include "diagnosis/set_up_change.h"
#include "diagnosis/station_check.h"

namespace armtrue {
namespace {

constexpr double kResolution = 1e-7;  // m: what is left below it is rounding of the file
constexpr size_t kMostSessions = 16;  // of the rows of a plain fit each has some

// What explains the residual best of what is found in the order of the readings or of the sessions.
std::optional<Suspicion> best_change(const PlainFit& fit) {
  if (auto constant = find_constant_of_range(fit)) return constant;
  const auto by_place = find_set_up_change(fit), by_session = find_change_of_session(fit);
  if (by_session && (!by_place || by_session->score > by_place->score)) return by_session;
  return by_place;
}

using Refit = std::function<std::optional<PlainFit>(const Campaign& readings)>;

// The same if it explains more than a few blunders do; otherwise these are left out. `refit`: to
// what remains, because what a fit was bent by them, other causes would explain.
std::optional<std::string> find_change(PlainFit fit, const Refit& refit) {
  for (;;) {
    const auto change = best_change(fit);
    const Blunders blunders = find_blunders(reading_equations(fit, {}), fit.poses());
    if (change && change->score > blunders.score) return change->words;
    if (blunders.score < kClearFall) return std::nullopt;
    auto without = refit(without_rows(fit.readings, blunders.rows));
    if (!without) return std::nullopt;
    fit = std::move(*without);
  }
}

std::optional<std::string> find_change_of_any(const PlainFit& fit, const Refit& refit) {
  const bool has_points = !fit.readings.reads_one_number() || fit.readings.has_pixels_only();
  return has_points ? find_change(fit, refit) : find_scale_of_anchor(fit);
}

}  // namespace

Findings find_suspicions(const Robot& robot, const Campaign& campaign) {
  Findings found;
  if (rows_by_session(campaign).size() > kMostSessions) return found;
  if (auto moved = find_far_set_up_change(robot, campaign)) {
    found.warnings.push_back(std::move(*moved));
    found.of_change = true;
    return found;
  }
  auto fit = fit_plainly(robot, campaign);
  if (!fit) return found;
  if (fit->result.spread.position < kResolution) return found;
  const auto coupling = find_coupling(*fit);
  auto change = find_impossible_change(robot, fit->result);
  if (coupling) {
    (change ? found.errors : found.warnings).push_back(*coupling);
    return found;
  }
  if (change)
    // Least squares follow a gross pose that far: only a fit without it says something of the
    // others.
    if (const auto gross = find_gross_poses(robot, campaign); !gross.empty()) {
      fit = fit_plainly(robot, without_gross(campaign, gross));
      if (!fit) return found;
      change = find_impossible_change(robot, fit->result);
    }
  if (change) {
    found.errors.push_back(*change);
    return found;
  }
  auto suspicion = find_change_of_any(
      *fit, [&](const Campaign& readings) { return fit_plainly(robot, readings); });
  found.of_change = suspicion.has_value();
  if (const auto depth = find_depth_scale(*fit)) suspicion = depth->words;
  if (!suspicion)
    if ((suspicion = find_scale_of_links(*fit, robot))) found.wrong_readings = *suspicion;
  if (!suspicion)
    if ((suspicion = find_early_angles(*fit, campaign))) found.early_angles = *suspicion;
  if (!suspicion) suspicion = find_reversed_gravity(*fit);
  if (!suspicion)
    if (const auto gravity = find_direction_of_gravity(*fit)) suspicion = gravity->words;
  if (!suspicion) suspicion = find_rounded_angles(*fit);
  if (!suspicion) suspicion = find_rounded_readings(*fit);
  if (suspicion) found.warnings.push_back(*suspicion);
  if (!suspicion)
    if (const auto unlikely = find_unlikely_change(robot, *fit)) {
      found.warnings.push_back(*unlikely);
      found.other_arm = *unlikely;
    }
  return found;
}

std::optional<std::string> explanation_of_rest(const CalibrationResult& fit,
                                               const Campaign& campaign) {
  if (rows_by_session(campaign).size() > kMostSessions) return std::nullopt;
  if (auto moved = find_far_set_up_change(fit.robot, campaign)) return moved;
  if (fit.spread.position < kResolution) return std::nullopt;
  return find_change_of_any(beside_fit(fit, campaign), [&](const Campaign& readings) {
    return std::optional(PlainFit{readings, fit});  // blunders hardly bend a fit by Student's law
  });
}

}  // namespace armtrue
