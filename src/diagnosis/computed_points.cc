#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <set>
#include <stdexcept>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

namespace {

// How closely a robot file predicts no measured points. A nominal one errs as arms are made. A
// calibrated one errs by the noise of the instrument at least, of which a tenth is left as margin.
double closer_than_measured(const Robot& robot) {
  constexpr double kAsNoArmIsMade = 0.01 * kMillimetre;
  constexpr double kAsNoInstrumentReads = 0.001 * kMillimetre;
  constexpr double kOfNoise = 0.1;
  if (!is_calibrated(robot)) return kAsNoArmIsMade;
  if (robot.noise.position <= 0) return kAsNoInstrumentReads;
  return std::min(kAsNoArmIsMade, kOfNoise * robot.noise.position);
}

// Whether rows of these poses are of so many different ones; it looks no further than it must.
template <typename PoseOfRow>
bool have_poses(size_t rows, const PoseOfRow& pose_of, size_t fewest) {
  std::set<int> poses;
  for (size_t k = 0; k < rows && poses.size() < fewest; ++k) poses.insert(pose_of(k));
  return poses.size() >= fewest;
}

// Some rows of some sessions of four poses or more: of fewer a base of its own fits most errors.
std::vector<int> rows_of_some_sessions(const Campaign& campaign) {
  constexpr int kMostRows = 500, kMostSessions = 50;
  constexpr size_t kFewestPoses = 4;
  std::vector<std::vector<int>> sessions = rows_by_session(campaign);
  std::erase_if(sessions, [&](const std::vector<int>& own) {
    const auto pose_of = [&](size_t k) { return campaign.pose[own[k]]; };
    return !have_poses(own.size(), pose_of, kFewestPoses);
  });
  std::vector<int> numbers(sessions.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  numbers = evenly_chosen(numbers, kMostSessions);
  std::vector<int> rows;
  for (int session : numbers)
    std::ranges::copy(
        evenly_chosen(sessions[session], kMostRows / static_cast<int>(numbers.size())),
        std::back_inserter(rows));
  std::ranges::sort(rows);
  return rows;
}

}  // namespace

bool is_calibrated(const Robot& robot) { return robot.uncertainty || !robot.std.empty(); }

std::optional<std::string> find_computed_points(const Robot& robot, const Campaign& campaign) {
  constexpr size_t kFewestPoses = 10;
  if (campaign.reads_one_number() || campaign.has_touches()) return std::nullopt;
  const auto pose_of = [&](size_t row) { return campaign.pose[row]; };
  if (!have_poses(campaign.pose.size(), pose_of, kFewestPoses)) return std::nullopt;
  const std::vector<int> rows = rows_of_some_sessions(campaign);
  if (rows.empty()) return std::nullopt;
  const Campaign readings = campaign.select(rows);
  Robot alone = robot;
  if (!is_calibrated(robot)) alone.effects.clear();
  try {
    const Robot placed = refit_set_up(alone, readings, {"base", "tool"});
    const double miss = median(evaluate(placed, readings).position);
    if (miss > closer_than_measured(robot)) return std::nullopt;
    return fmt::format(
        "the robot file predicts these points to {:.2g} mm (median), as no {}: are they what the "
        "controller computes from the joint angles? Give those that the instrument reads",
        miss / kMillimetre, is_calibrated(robot) ? "instrument reads" : "arm is made");
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // too few readings
  }
}

}  // namespace armtrue
