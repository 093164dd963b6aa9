#include "armtrue/kinematics/chain.h"

#include <algorithm>
#include <stdexcept>

namespace armtrue {
namespace {

constexpr int kAxesOfArm = 6;

int driven_before(const KinematicChain& chain, int link) {
  int joints = 0;
  for (int k = 0; k < link; ++k) joints += is_driven(chain.links[k]);
  return joints;
}

}  // namespace

int joint_count(const KinematicChain& chain) { return driven_before(chain, link_count(chain)); }

int link_of_joint(const KinematicChain& chain, int joint) {
  int left = joint;
  for (int j = 0; left >= 0 && j < link_count(chain); ++j)
    if (is_driven(chain.links[j]) && left-- == 0) return j;
  throw std::out_of_range("the chain has no joint " + std::to_string(joint + 1));
}

int joint_of_link(const KinematicChain& chain, int link) {
  if (!is_driven(chain.links[link])) return -1;
  return driven_before(chain, link);
}

bool is_six_axis_arm(const KinematicChain& chain) {
  if (link_count(chain) != kAxesOfArm + 1) return false;
  return std::all_of(chain.links.begin(), chain.links.end() - 1,
                     [](const Link& link) {
                       return is_driven(link) && link.joint == JointKind::revolute;
                     }) &&
         chain.links.back().joint == JointKind::fixed;
}

std::vector<int> coupling_order(const KinematicChain& chain) {
  const std::vector<Coupling>& all = chain.couplings;
  const auto moves = [&](int link) {
    return link >= 0 && link < link_count(chain) && chain.links[link].joint != JointKind::fixed;
  };
  for (const Coupling& one : all)
    if (!moves(one.follower) || !moves(one.followed))
      throw std::invalid_argument("a coupling is not between two links that move");
  std::vector<int> order;
  std::vector<bool> done(all.size(), false);
  const auto is_complete = [&](int link) {
    for (size_t k = 0; k < all.size(); ++k)
      if (all[k].follower == link && !done[k]) return false;
    return true;
  };
  while (order.size() < all.size()) {
    const size_t before = order.size();
    for (int k = 0; k < std::ssize(all); ++k) {
      if (done[k] || !is_complete(all[k].followed)) continue;
      done[k] = true;
      order.push_back(k);
    }
    if (order.size() > before) continue;
    const size_t left = std::ranges::find(done, false) - done.begin();
    throw std::invalid_argument("the joint of link '" + chain.links[all[left].follower].name +
                                "' follows itself");
  }
  return order;
}

std::vector<double> moved_with(const KinematicChain& chain, int link) {
  std::vector<double> moved(chain.links.size(), 0.0);
  moved[link] = 1;
  for (const int k : coupling_order(chain)) {
    const Coupling& coupling = chain.couplings[k];
    const size_t followed = coupling.followed;
    const size_t follower = coupling.follower;
    moved[follower] += chain.links[follower].sign * coupling.coefficient *
                       chain.links[followed].sign * moved[followed];
  }
  return moved;
}

std::vector<double> joint_values(const KinematicChain& chain, const JointVector& q) {
  std::vector<double> values(chain.links.size(), 0.0);
  for (int j = 0; j < joint_count(chain); ++j) values[link_of_joint(chain, j)] = q[j];
  for (const int k : coupling_order(chain)) {
    const Coupling& coupling = chain.couplings[k];
    const size_t followed = coupling.followed;
    const Link& link = chain.links[followed];
    const double zero = is_prismatic(link) ? link.r : link.theta;
    values[coupling.follower] +=
        coupling.coefficient * (values[followed] + link.sign * (zero - coupling.from));
  }
  return values;
}

std::optional<BeyondTravel> beyond_travel(const KinematicChain& chain, const JointVector& q) {
  const auto is_beyond = [](const Link& link, double value) {
    return value < link.min || value > link.max;
  };
  for (int j = 0; j < joint_count(chain); ++j)
    if (is_beyond(joint_link(chain, j), q[j])) return BeyondTravel{link_of_joint(chain, j), q[j]};
  if (chain.couplings.empty()) return std::nullopt;
  const std::vector<double> values = joint_values(chain, q);
  for (int j = 0; j < link_count(chain); ++j) {
    const Link& link = chain.links[j];
    const double value = values[j];
    if (!link.has_encoder && is_beyond(link, value)) return BeyondTravel{j, value};
  }
  return std::nullopt;
}

std::vector<Link> six_axis_links() {
  std::vector<Link> links(kAxesOfArm + 1);
  links.back().joint = JointKind::fixed;
  return links;
}

}  // namespace armtrue
