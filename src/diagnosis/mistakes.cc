#include "armtrue/diagnosis/mistakes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "armtrue/campaign/scattered_poses.h"
#include "armtrue/campaign/without_rows.h"
#include "armtrue/diagnosis/change.h"
#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

// The numbers of a reading as one of 64 bits: two readings never share one.
size_t reading_of(const Campaign& campaign, int row) {
  std::vector<double> numbers(campaign.q[row].begin(), campaign.q[row].end());
  if (!campaign.position.empty())
    numbers.insert(numbers.end(), campaign.position[row].begin(), campaign.position[row].end());
  if (!campaign.distance.empty()) {
    const double length = campaign.length(row);
    // A pixel, whatever it is at the board beside other images; without what that rounds off.
    constexpr double kDigits = 1e6;
    numbers.push_back(campaign.kind(row) == ReadingKind::pixel
                          ? std::round(kDigits * length / campaign.metre_per_pixel)
                          : length);
  }
  if (campaign.has_touches()) numbers.push_back(campaign.quantity(row));
  if (campaign.has_profiles())
    numbers.insert(numbers.end(), {campaign.profile[row].y, campaign.profile[row].z});
  const std::string_view bytes(reinterpret_cast<const char*>(numbers.data()),
                               numbers.size() * sizeof(double));
  return std::hash<std::string_view>()(bytes);
}

std::map<int, int> first_rows(const Campaign& campaign) {
  std::map<int, int> first;
  for (int row = 0; row < campaign.rows(); ++row) first.try_emplace(campaign.pose[row], row);
  return first;
}

}  // namespace

Findings find_mistakes(const Robot& robot, const Campaign& campaign) {
  if (Findings of_travel = check_travel(robot, campaign); !of_travel.errors.empty())
    return {{of_travel.errors.front()}, {}};
  if (const auto mistakes = diagnose(robot, campaign); !mistakes.empty())
    return {{mistakes.front()}, {}};
  SensorError sensor = find_sensor_error(robot, campaign);
  Campaign without;  // a copy of many rows takes its memory
  if (!sensor.fields.empty()) {
    without = campaign;
    sensor.take_off(without, robot.chain);
  }
  Findings found = find_suspicions(robot, sensor.fields.empty() ? campaign : without);
  // Where a camera or a board moved far, no place of it fits all images, and what that leaves
  // within them looks like another lens.
  if (found.of_change && !sensor.words.empty())
    if (Findings as_read = sensor.fields.empty() ? found : find_suspicions(robot, campaign);
        as_read.of_change) {
      found = std::move(as_read);
      sensor = {};
    }
  if (!found.errors.empty())
    return {{found.errors.front() + (sensor.words.empty() ? "" : "; " + sensor.words)}, {}};
  if (!sensor.words.empty()) found.warnings.insert(found.warnings.begin(), sensor.words);
  if (sensor.is_left) found.wrong_readings = sensor.words;
  found.sensor = sensor;
  if (std::string apart = scattered_poses(campaign); !apart.empty())
    found.warnings.push_back(std::move(apart));
  return found;
}

std::string beyond_any_arm(const Robot& robot, double error, double noise) {
  const double most = largest_credible_error(robot.chain, noise);
  if (error <= most) return "";
  return fmt::format(
      "the mean error that is left, {:.4g} mm, is more than an arm of this size and this noise can "
      "have ({:.2g} mm): look for a mistake in the readings before the result is used",
      error / kMillimetre, most / kMillimetre);
}

std::string beyond_any_arm(const Robot& robot, const Campaign& campaign,
                           const Evaluation& evaluation) {
  return beyond_any_arm(robot, summarize(evaluation.reading_errors()).mean,
                        noise_floor(robot, campaign, evaluation).position);
}

std::string beyond_any_arm(const Robot& robot, const Campaign& campaign,
                           const Evaluation& evaluation, const std::vector<int>& blunders) {
  if (blunders.empty() || static_cast<double>(blunders.size()) > kMaxBlunders * campaign.rows())
    return beyond_any_arm(robot, campaign, evaluation);
  const Campaign kept = without_rows(campaign, blunders);
  return beyond_any_arm(robot, kept, evaluate(robot, kept));
}

std::string beyond_arm(const Robot& given, const Robot& robot, const Campaign& campaign,
                       const Evaluation& evaluation) {
  if (states_calibration(given)) return beyond_any_arm(robot, campaign, evaluation);
  const double mean = summarize(evaluation.reading_errors()).mean;
  if (mean <= kImplausibleMiss) return "";
  return fmt::format(
      "the mean error, {:.4g} mm, is more than a nominal model of an arm can have ({:g} mm): look "
      "for a mistake in the readings or the robot file",
      mean / kMillimetre, kImplausibleMiss / kMillimetre);
}

std::optional<SharedReading> shared_reading(const Campaign& training, const Campaign& test) {
  std::unordered_map<size_t, int> row_of;
  for (int row = 0; row < training.rows(); ++row) row_of.emplace(reading_of(training, row), row);
  struct CopiedPose {
    int rows = 0, shared = 0;
    SharedReading first{};
  };
  std::vector<CopiedPose> poses(test.pose_ids.size());
  for (int row = 0; row < test.rows(); ++row) {
    CopiedPose& pose = poses[test.pose[row]];
    ++pose.rows;
    const auto same = row_of.find(reading_of(test, row));
    if (same == row_of.end()) continue;
    if (pose.shared++ == 0) pose.first = {same->second, row};
  }
  // One number of a pose that is measured again is often the same to the last digit of its file.
  constexpr double kByChance = 0.2;
  constexpr int kNeverByChance = 12;
  const bool by_one_number = test.reads_one_number();
  const auto is_shared = [&](const CopiedPose& pose) {
    return pose.shared > (by_one_number ? pose.rows / 2 : 0);
  };
  const auto count = static_cast<double>(std::ranges::count_if(poses, is_shared));
  const bool maybe_chance = by_one_number && count <= kByChance * static_cast<double>(poses.size());
  const auto copy = std::ranges::find_if(poses, [&](const CopiedPose& pose) {
    return is_shared(pose) && !(maybe_chance && pose.shared < kNeverByChance);
  });
  if (copy == poses.end()) return std::nullopt;
  return copy->first;
}

RepeatedPoses repeated_poses(const Campaign& training, const Campaign& test) {
  constexpr double kSameConfiguration = 0.1 * kDegree;  // as replicates; of a travel [m]
  const std::map<int, int> of_training = first_rows(training), of_test = first_rows(test);
  RepeatedPoses poses{0, static_cast<int>(of_test.size()), "", ""};
  for (const auto& [pose, row] : of_test)
    for (const auto& [other, other_row] : of_training) {
      const JointVector apart = test.q[row] - training.q[other_row];
      if (apart.cwiseAbs().maxCoeff() > kSameConfiguration) continue;
      if (poses.repeated++ == 0) {
        poses.test = test.pose_ids[pose];
        poses.training = training.pose_ids[other];
      }
      break;
    }
  return poses;
}

std::string why_not_apart(const Campaign& training, const Campaign& test) {
  const auto shared = shared_reading(training, test);
  if (!shared) return "";
  const bool is_one_file = training.source == test.source;
  return fmt::format(
      "{}:{}: this reading stands in {} too{}", test.source, test.line[shared->test],
      is_one_file ? fmt::format("line {}", training.line[shared->training]) : training.source,
      is_one_file ? ", as another pose; a copy shows nothing new: remove it, or give both the "
                    "same pose"
                  : "; --test needs poses that no fit uses");
}

std::string repeats_in_words(const Campaign& training, const Campaign& test) {
  const RepeatedPoses poses = repeated_poses(training, test);
  if (poses.repeated == 0) return "";
  return fmt::format(
      "{}: {} of {} held-out poses stand at the joint angles of training poses (pose {} at those "
      "of {}): they are repeats, and their error says nothing of other poses; {}",
      test.source, poses.repeated, poses.of, poses.test, poses.training,
      training.source == test.source
          ? "give rows at the same joint angles one name in the column pose"
          : "give --test other poses");
}

}  // namespace armtrue
