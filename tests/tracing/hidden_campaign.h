#pragma once

// A campaign of the oracle as the estimating side gets it, read from CSV, and whether an effect
// that was found is the one that was hidden.

#include <stdlib.h>

#include <array>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/planning/pose_cloud.h"
#include "armtrue/search/trace.h"
#include "support/oracle.h"

namespace armtrue {

class HiddenCampaign {
 public:
  HiddenCampaign(const std::string& nominal, const std::string& family, double size_mm,
                 const armtrue_oracle::CampaignPlan& plan) {
    std::string folder = std::filesystem::temp_directory_path() / "armtrue-hidden-XXXXXX";
    if (!mkdtemp(folder.data())) throw std::runtime_error("cannot create " + folder);
    written = armtrue_oracle::write_campaign(armtrue_oracle::read_arm(nominal), family, size_mm,
                                             plan, folder);
    training = read_campaign(folder + "/train.csv").campaign;
    held_out = read_campaign(folder + "/test.csv").campaign;
    std::filesystem::remove_all(folder);
  }

  armtrue_oracle::Written written;
  Campaign training, held_out;
};

/// These poses, each visited once, by the true arm of a seed with the effect as it is.
inline Campaign visits(const std::string& nominal, const armtrue_oracle::HiddenEffect& effect,
                       const std::vector<std::array<double, 6>>& commanded, unsigned seed) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = seed;
  std::string folder = std::filesystem::temp_directory_path() / "armtrue-visits-XXXXXX";
  if (!mkdtemp(folder.data())) throw std::runtime_error("cannot create " + folder);
  armtrue_oracle::write_visits(armtrue_oracle::read_arm(nominal), effect, commanded, plan,
                               folder + "/m.csv");
  Campaign campaign = read_campaign(folder + "/m.csv").campaign;
  std::filesystem::remove_all(folder);
  return campaign;
}

/// The same of poses of the whole travel.
inline Campaign visits(const std::string& nominal, const armtrue_oracle::HiddenEffect& effect,
                       int poses, unsigned seed) {
  std::vector<std::array<double, 6>> commanded;
  for (const JointVector& q : random_configurations(read_robot(nominal).robot, poses, {}, seed))
    commanded.push_back({q[0], q[1], q[2], q[3], q[4], q[5]});
  return visits(nominal, effect, commanded, seed);
}

inline bool names(const armtrue_oracle::Hidden& truth, const Effect& effect) {
  const bool parameter = effect.parameter == truth.parameter ||
                         to_string(effect.parameter).starts_with(truth.parameter + ".");  // of a group
  return parameter && to_string(effect.driver) == truth.driver;
}

/// The effect itself, or one that the campaign cannot tell from it.
inline bool names(const armtrue_oracle::Hidden& truth, const TracedEffect& traced) {
  if (names(truth, traced.effect)) return true;
  for (const Rival& rival : traced.indistinguishable)
    if (names(truth, rival.effect)) return true;
  return false;
}

}  // namespace armtrue
