#include "io/yaml/convention_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "armtrue/io/link_names.h"
#include "armtrue/kinematics/conventions.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/names.h"
#include "armtrue/text/number_text.h"
#include "io/yaml/link_io.h"

namespace armtrue {
namespace {

// Throws InputError if the file states values of parameters: conversion changes the chain, and so
// what their names mean.
void refuse_parameters(YamlMap& document, const std::string& why) {
  for (const char* key : {"sessions", "effects", "priors", "std", "uncertainty"})
    if (document.has(key) && !(std::string(key) == "effects" && document.maps(key).empty()))
      document.fail(key, why +
                             "; write the file in it: convert-robot FILE --to yaml, without this "
                             "key");
}

KinematicChain read_chain(YamlMap& map) {
  KinematicChain chain;
  chain.base = read_pose(map.map("base"));
  read_links(map, chain);
  if (!chain.couplings.empty())
    map.fail("links",
             "the axes of a positioner each have an encoder and move by themselves; leave "
             "out 'follows' and 'coupled'");
  chain.tool = read_pose(map.map("part"));
  map.finish();
  return chain;
}

// Replaces the chain from the foot of the arm by the chain from the part to the tool.
void begin_with_positioner(YamlMap& document, const KinematicChain& positioner, Robot& robot) {
  PartToFoot way;
  try {
    way = part_to_foot(positioner, robot.chain.base);
  } catch (const std::invalid_argument& error) {
    document.fail("positioner", error.what());
  }
  std::vector<Link>& links = robot.chain.links;
  for (const Link& link : way.links)
    if (std::ranges::find(links, link.name, &Link::name) != links.end())
      document.fail("positioner", "its link '" + link.name +
                                      "' has the name of a link of the arm; name it otherwise");
  const auto before_arm = static_cast<int>(way.links.size());
  robot.ground_link = before_arm - 1;
  for (Body& body : robot.bodies) body.link += before_arm;
  for (Coupling& coupling : robot.chain.couplings) {
    coupling.follower += before_arm;
    coupling.followed += before_arm;
  }
  robot.chain.base = way.base;
  links.insert(links.begin(), way.links.begin(), way.links.end());
  if (std::ssize(links) > kMaxLinks)
    document.fail("positioner", fmt::format("makes {} links of the chain; a chain has from 1 to {}",
                                            links.size(), kMaxLinks));
}

void check_axes_of_positioner(YamlMap& document, const Robot& robot) {
  const std::vector<JointName> names = joint_names(robot.chain);
  for (int j = 0; j <= *robot.ground_link; ++j)
    if (const int joint = joint_of_link(robot.chain, j); joint >= 0 && !names[joint].is_external())
      document.fail("positioner", "the axis '" + robot.chain.links[j].name +
                                      "' of a positioner is an external axis: call it E1 to E6");
}

void check_masses_on_ground(YamlMap& document, const Robot& robot) {
  for (const Body& body : robot.bodies)
    if (body.link <= *robot.ground_link)
      document.fail("masses",
                    "the load of a positioner is the part, and of an arm before ground_link "
                    "its tool, whatever their mass: leave out the masses of its links");
}

}  // namespace

void read_links(YamlMap& map, KinematicChain& chain) {
  std::vector<YamlMap> entries = map.maps("links");
  if (entries.empty() || entries.size() > kMaxLinks)
    map.fail("links", fmt::format("has {}; a chain has from 1 to {}",
                                  counted(entries.size(), "entry"), kMaxLinks));
  std::vector<Link>& links = chain.links;
  for (YamlMap& entry : entries) {
    const Link link = read_link(entry);
    if (std::ranges::find(links, link.name, &Link::name) != links.end())
      entry.fail("name", "'" + link.name + "' stands twice; parameters are named after links");
    if (is_reserved_link_name(link.name))
      entry.fail("name", "'" + link.name + "' means something else; name the link otherwise");
    links.push_back(link);
  }
  for (int j = 0; j < std::ssize(entries); ++j) {
    read_couplings(entries[j], j, chain);
    entries[j].finish();
  }
  try {
    coupling_order(chain);
  } catch (const std::invalid_argument& error) {
    map.fail("links", std::string(error.what()) + " through others; leave one of them out");
  }
}

namespace {

// Alpha and d of the last row act behind its joint and before the flange: they become a fixed link.
void keep_flange(YamlMap& document, const KinematicChain& rows, Robot& robot) {
  const Link& last = rows.links.back();
  if (last.alpha == 0 && last.d == 0) return;
  if (rows.links.size() == kMaxLinks)
    document.fail("links", fmt::format("has {} rows, and alpha_deg and d_mm of the last need one "
                                       "link more than a chain has; write them into 'tool'",
                                       rows.links.size()));
  Link flange;
  flange.name = last.name + "_flange";
  flange.joint = JointKind::fixed;
  flange.alpha = last.alpha;
  flange.d = last.d;
  robot.chain.links.push_back(flange);
  robot.chain.tool = rows.tool;
}

}  // namespace

void use_convention(YamlMap& document, Robot& robot) {
  const std::string convention = document.text("convention", "modified");
  if (convention == "modified") return;
  if (convention != "standard")
    document.fail("convention", "'" + convention + "' is neither modified nor standard");
  refuse_parameters(document, "names parameters of the modified convention");
  for (Body& body : robot.bodies)
    body.centre = modified_from_standard(robot.chain.links[body.link]) * body.centre;
  const KinematicChain rows = robot.chain;
  try {
    robot.chain = from_standard(rows);
  } catch (const std::invalid_argument& error) {
    document.fail("convention", error.what());
  }
  keep_flange(document, rows, robot);
}

void use_positioner(YamlMap& document, Robot& robot) {
  const bool forward = document.has("positioner");
  if (document.has("ground_link")) {
    if (forward)
      document.fail("ground_link", "stands beside 'positioner', which says the same; keep one");
    const std::string name = document.text("ground_link");
    robot.ground_link = find_name(robot.chain.links, name);
    if (!robot.ground_link) document.fail("ground_link", "the robot has no link '" + name + "'");
  } else if (forward) {
    refuse_parameters(document, "names parameters of the chain from the part to the tool");
    YamlMap map = document.map("positioner");
    KinematicChain positioner = read_chain(map);
    if (document.text("convention", "modified") == "standard") {
      try {
        positioner = from_standard(positioner);
      } catch (const std::invalid_argument& error) {
        document.fail("positioner", error.what());
      }
    }
    begin_with_positioner(document, positioner, robot);
  }
  const char* key = robot.ground_link ? (forward ? "positioner" : "ground_link") : "links";
  if (const int joints = joint_count(robot.chain); joints < 1 || joints > kMaxJoints)
    document.fail(key, fmt::format("has {} (revolute or prismatic); an arm has from "
                                   "1 to {}",
                                   counted(joints, "driven joint"), kMaxJoints));
  if (forward) check_axes_of_positioner(document, robot);
  if (robot.ground_link) check_masses_on_ground(document, robot);
}

}  // namespace armtrue
