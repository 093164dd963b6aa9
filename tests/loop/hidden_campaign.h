#pragma once

// A campaign of the oracle as the estimating side gets it, read from CSV, and whether an effect
// that was found is the one that was hidden.

#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "armtrue/identification/tracing.h"
#include "armtrue/io/campaign_io.h"
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

inline bool names(const armtrue_oracle::Hidden& truth, const Effect& effect) {
  const bool parameter = effect.parameter == truth.parameter ||
                         effect.parameter.starts_with(truth.parameter + ".");  // of a group
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
