#include "urdf/urdf_ends.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "armtrue/text/input_error.h"

namespace armtrue {
namespace {

constexpr size_t kMostLinksNamed = 12;  // in a message

// Number of joints of a branch, from `joint` on, that move and do not follow another (mimic).
int independent_joints(const urdf::Joint& joint, const urdf::ModelInterface& model) {
  int count = !is_fixed(joint) && !joint.mimic ? 1 : 0;
  for (const auto& next : model.getLink(joint.child_link_name)->child_joints)
    count += independent_joints(*next, model);
  return count;
}

// Whether a joint behind the link is not fixed.
bool carries_joints(const urdf::Link& link, const urdf::ModelInterface& model) {
  return std::ranges::any_of(link.child_joints,
                             [&](const auto& joint) { return moves(*joint, model); });
}

// Links behind `link` that end a branch.
void find_ends(const urdf::Link& link, std::vector<std::string>& ends) {
  if (link.child_links.empty()) ends.push_back(link.name);
  for (const auto& child : link.child_links) find_ends(*child, ends);
}

std::string some_of(const std::vector<std::string>& names) {
  if (names.size() <= kMostLinksNamed) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{}, ... ({} in all)",
                     fmt::join(names.begin(), names.begin() + kMostLinksNamed, ", "), names.size());
}

// The branches along which the arm may go on behind a link: those that move, else all. Beside a
// branch with two independent joints or more, branches whose joints only follow others are drives
// and springs: they do not count.
std::vector<urdf::JointSharedPtr> ways_behind(const urdf::Link& link,
                                              const urdf::ModelInterface& model) {
  std::vector<urdf::JointSharedPtr> ways, own;
  std::ranges::copy_if(link.child_joints, std::back_inserter(ways),
                       [&](const auto& joint) { return moves(*joint, model); });
  std::ranges::copy_if(ways, std::back_inserter(own),
                       [&](const auto& joint) { return independent_joints(*joint, model) > 0; });
  if (own.size() == 1 && independent_joints(*own.front(), model) > 1) return own;
  return ways.empty() ? link.child_joints : ways;
}

// Descriptions after ROS-Industrial have a flange for grippers, whose x points out, and the flange
// as the controller shows it, tool0.
const std::string& likely_end(const std::vector<std::string>& ends) {
  const auto tool0 =
      std::ranges::find_if(ends, [](const std::string& name) { return name.ends_with("tool0"); });
  return tool0 != ends.end() ? *tool0 : ends.front();
}

// Fingers move and follow each other, and no arm goes on behind them.
bool is_gripper(const std::vector<urdf::JointSharedPtr>& ways, const urdf::ModelInterface& model) {
  return std::ranges::all_of(ways, [&](const auto& joint) {
    return moves(*joint, model) && independent_joints(*joint, model) <= 1;
  });
}

}  // namespace

bool moves(const urdf::Joint& joint, const urdf::ModelInterface& model) {
  return !is_fixed(joint) || carries_joints(*model.getLink(joint.child_link_name), model);
}

std::string only_end(const urdf::ModelInterface& model, const std::string& base,
                     const std::string& file) {
  urdf::LinkConstSharedPtr link = model.getLink(base);
  // The frame of a controller often is a branch beside the arm: go back to where the arm begins.
  while (link->parent_joint && is_fixed(*link->parent_joint) && !carries_joints(*link, model))
    link = model.getLink(link->parent_joint->parent_link_name);
  while (!link->child_joints.empty()) {
    const std::vector<urdf::JointSharedPtr> ways = ways_behind(*link, model);
    if (ways.size() > 1) {
      std::vector<std::string> ends;
      for (const auto& way : ways) find_ends(*model.getLink(way->child_link_name), ends);
      throw InputError(fmt::format(
          "{}: the link '{}' branches; name the link where the arm ends: --tip {} (ends are {})",
          file, link->name, is_gripper(ways, model) ? link->name : likely_end(ends),
          some_of(ends)));
    }
    link = model.getLink(ways.front()->child_link_name);
  }
  return link->name;
}

void require_link(const urdf::ModelInterface& model, const std::string& name, const char* option,
                  const std::string& file) {
  if (model.getLink(name)) return;
  std::vector<std::string> names;
  for (const auto& link : model.links_) names.push_back(link.first);
  throw InputError(fmt::format("{}: has no link '{}' for {}; its links are {}", file, name, option,
                               some_of(names)));
}

}  // namespace armtrue
