#include "armtrue/calibration/hold_out.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {
namespace {

constexpr double kLeastFreedom = 1.0 / 3;
constexpr double kLeastHeldOut = 0.03;  // a smaller share of the poses says nothing

// What a part of the poses lacks that all have, in words; empty if it lacks nothing.
class Lack {
 public:
  Lack(const Robot& robot, const Campaign& all)
      : robot_(robot),
        kept_(choose_identifiable(robot, all).kept),
        unknowns_(static_cast<double>(kept_.size() + (rows_by_session(all).size() - 1) *
                                                         own_parameters(robot).size())),
        freedom_(distinct_equations(all) - unknowns_) {}

  std::string of(const Campaign& part) const {
    const double least = std::min(kLeastFreedom * freedom_, unknowns_);
    if (freedom_ > 0 && distinct_equations(part) - unknowns_ < least)
      return fmt::format("the others would give {:g} equations for {:g} unknowns",
                         distinct_equations(part), unknowns_);
    std::vector<int> kept;
    try {
      kept = choose_identifiable(robot_, part).kept;
    } catch (const std::invalid_argument&) {
      return "the others would not show where the instrument of each session stood";
    }
    if (kept.size() >= kept_.size()) return "";
    std::vector<int> lost;
    std::ranges::set_difference(kept_, kept, std::back_inserter(lost));
    std::string names;
    for (int parameter : lost)
      names += (names.empty() ? "" : ", ") + parameter_name(robot_.chain, parameter);
    return "the others would not show " + names;
  }

 private:
  const Robot& robot_;
  std::vector<int> kept_;
  double unknowns_, freedom_;
};

}  // namespace

double distinct_equations(const Campaign& campaign) {
  std::set<std::pair<int, int>> distinct;  // session, pose and quantity
  for (int row = 0; row < campaign.rows(); ++row)
    distinct.emplace(campaign.session.empty() ? 0 : campaign.session[row],
                     campaign.pose_by_quantity(row));
  return static_cast<double>(distinct.size()) * campaign.reading_size().all();
}

HeldOut hold_out(const Robot& robot, const Campaign& campaign, const HoldOut& asked) {
  const auto split_at = [&](double share) {
    return asked.by_region ? split_by_region(robot, campaign, share, asked.seed)
                           : split_by_pose(campaign, share, asked.seed);
  };
  if (asked.share == 0) return {split_at(0), ""};
  const Lack lack(robot, campaign);
  std::string first;
  for (double share = asked.share; share > kLeastHeldOut; share /= 2) {
    Split split = split_at(share);
    const Campaign training = campaign.select(split.training);
    const std::string lacks = lack.of(training);
    if (lacks.empty()) {
      if (first.empty()) return {std::move(split), ""};
      return {std::move(split),
              fmt::format("{} of {} poses are held out, not {:g} %: {}; measure more poses",
                          campaign.poses() - training.poses(), campaign.poses(), 100 * asked.share,
                          first)};
    }
    if (first.empty()) first = lacks;
  }
  return {split_at(0), fmt::format("no pose is held out, so no error of other poses is known: {}; "
                                   "measure more poses",
                                   first)};
}

}  // namespace armtrue
