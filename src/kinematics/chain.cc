#include "armtrue/kinematics/chain.h"

#include <algorithm>
#include <stdexcept>

namespace armtrue {
namespace {

bool is_driven(const Link& link) { return link.joint != JointKind::fixed; }

constexpr int kAxesOfArm = 6;

}  // namespace

int joint_count(const KinematicChain& chain) {
  return static_cast<int>(std::ranges::count_if(chain.links, is_driven));
}

int link_of_joint(const KinematicChain& chain, int joint) {
  int left = joint;
  for (int j = 0; left >= 0 && j < link_count(chain); ++j)
    if (is_driven(chain.links[static_cast<size_t>(j)]) && left-- == 0) return j;
  throw std::out_of_range("the chain has no joint " + std::to_string(joint + 1));
}

int joint_of_link(const KinematicChain& chain, int link) {
  if (!is_driven(chain.links[static_cast<size_t>(link)])) return -1;
  return static_cast<int>(
      std::count_if(chain.links.begin(), chain.links.begin() + link, is_driven));
}

int joint_beyond_travel(const KinematicChain& chain, const JointVector& q) {
  for (int j = 0; j < joint_count(chain); ++j)
    if (const Link& link = joint_link(chain, j); q[j] < link.min || q[j] > link.max) return j;
  return -1;
}

bool is_six_axis_arm(const KinematicChain& chain) {
  if (link_count(chain) != kAxesOfArm + 1) return false;
  return std::all_of(chain.links.begin(), chain.links.end() - 1,
                     [](const Link& link) { return link.joint == JointKind::revolute; }) &&
         !is_driven(chain.links.back());
}

std::vector<Link> six_axis_links() {
  std::vector<Link> links(kAxesOfArm + 1);
  links.back().joint = JointKind::fixed;
  return links;
}

}  // namespace armtrue
