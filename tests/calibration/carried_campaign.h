#pragma once

// Campaigns of the oracle, which shares no code with armtrue, in several sessions: before each the
// instrument is carried elsewhere by metres.

#include <stdlib.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "armtrue/io/campaign_io.h"
#include "support/oracle.h"

namespace armtrue {

/// What a joint's zero is off by in a session [rad].
using ZeroOffsets = std::function<double(int joint, int session)>;

inline std::string name_of_day(int session) { return "day " + std::to_string(session + 1); }

/// The kr360-spindle's true arm of the plan's seed, in so many visits of each session.
inline Campaign carried_campaign(
    const std::vector<int>& visits_of_session, const armtrue_oracle::CampaignPlan& plan,
    const ZeroOffsets& offset = [](int, int) { return 0.0; }, bool carried = true) {
  const armtrue_oracle::OracleArm nominal =
      armtrue_oracle::read_arm(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml");
  armtrue_oracle::Dice dice(1000 + plan.seed);
  std::vector<std::array<double, 6>> visits;
  std::vector<int> sessions;
  for (size_t s = 0; s < visits_of_session.size(); ++s)
    for (int i = 0; i < visits_of_session[s]; ++i) {
      std::array<double, 6>& q = visits.emplace_back();
      for (size_t j = 0; j < q.size(); ++j)
        q[j] = 0.95 * dice.uniform(std::max(nominal.links[j].min, -3.0),
                                   std::min(nominal.links[j].max, 3.0));
      sessions.push_back(static_cast<int>(s));
    }
  const auto moves = [&](const armtrue_oracle::Moment& moment, armtrue_oracle::OracleArm& arm) {
    const auto visit = std::find(visits.begin(), visits.end(), moment.q) - visits.begin();
    const int session = sessions[static_cast<size_t>(visit)];
    for (int j = 0; j < 6; ++j) arm.links[static_cast<size_t>(j)].theta += offset(j, session);
    if (!carried) return;
    const KDL::Frame station(KDL::Rotation::RPY(0.1 * session, -0.2 * session, 1.1 * session),
                             KDL::Vector(3.0 * session, -2.0 * session, 0.5 * session));
    arm.base = station * arm.base;
  };
  std::string folder = std::filesystem::temp_directory_path() / "armtrue-carried-XXXXXX";
  if (!mkdtemp(folder.data())) throw std::runtime_error("cannot create " + folder);
  armtrue_oracle::write_visits(nominal, moves, visits, plan, folder + "/m.csv");
  Campaign campaign = read_campaign(folder + "/m.csv").campaign;
  std::filesystem::remove_all(folder);
  for (int pose : campaign.pose) campaign.session.push_back(sessions[static_cast<size_t>(pose)]);
  for (size_t s = 0; s < visits_of_session.size(); ++s)
    campaign.session_names.push_back(name_of_day(static_cast<int>(s)));
  return campaign;
}

/// The sessions from `first` to `last`, named from day 1 on.
inline Campaign sessions_of(const Campaign& campaign, int first, int last) {
  std::vector<int> rows;
  for (int row = 0; row < campaign.rows(); ++row)
    if (first <= campaign.session[row] && campaign.session[row] <= last) rows.push_back(row);
  Campaign part = campaign.select(rows);
  for (int& session : part.session) session -= first;
  part.session_names.resize(static_cast<size_t>(last - first + 1));
  return part;
}

}  // namespace armtrue
