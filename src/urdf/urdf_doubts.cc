#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/urdf/urdf_io.h"

namespace armtrue {
namespace {

constexpr double kNoticeable = 0.01 * kMillimetre;

void add_base(const std::string& text, const std::string& file, const UrdfEnds& ends,
              std::vector<std::string>& doubts) {
  for (const std::string& link : frames_beside_base(text, file, ends))
    doubts.push_back(file + ": R_A is the frame of " +
                     (ends.base.empty() ? "the root link" : "'" + ends.base + "'") + "; '" + link +
                     "' stands beside it, moved or turned; if the controller's poses are in '" +
                     link + "', give --base " + link);
}

// Programs state the flange in R_0: of a URDF the flange is --tip, and R_0 follows from --base.
void add_flange(const Robot& robot, const std::string& text, const std::string& file,
                const UrdfEnds& ends, std::vector<std::string>& doubts) {
  const Eigen::Vector3d foot = foot_beside_base(text, file, ends) / kMillimetre;
  if (foot.norm() > kNoticeable / kMillimetre)
    doubts.push_back(fmt::format(
        "{}: R_0, the foot of programs, stands at {:.4g}, {:.4g}, {:.4g} mm of the frame of "
        "--base, "
        "because link 1 alone does not lead from there to axis 1: for poses in the frame of --base "
        "give compensate --base {:.10g},{:.10g},{:.10g},0,0,0",
        file, foot.x(), foot.y(), foot.z(), -foot.x(), -foot.y(), -foot.z()));
  const std::string tool0 = tool0_beside_tip(text, file, ends);
  if (!tool0.empty())
    doubts.push_back(
        fmt::format("{}: R_{}, the flange of programs, is the frame of '{}'; '{}' stands "
                    "elsewhere; if it is the "
                    "flange of the controller, give --tip {}",
                    file, link_count(robot.chain),
                    ends.tip.empty() ? "the end of the arm" : ends.tip, tool0, tool0));
}

void add_two_arms(const Robot& robot, const std::string& file, std::vector<std::string>& doubts) {
  if (!robot.ground_link) return;
  const std::vector<Link>& links = robot.chain.links;
  const auto back = std::count_if(links.begin(), links.begin() + *robot.ground_link, is_driven);
  doubts.push_back(
      fmt::format("{}: two arms as one chain: joints 1 to {} lead from --base back to '{}', which "
                  "stands on the ground, and joints {} to {} from there to --tip",
                  file, back, links[*robot.ground_link].name, back + 1, joint_count(robot.chain)));
}

void add_travel(const std::string& text, const std::string& file, const UrdfEnds& ends,
                std::vector<std::string>& doubts) {
  const std::vector<std::string> links = links_without_travel(text, file, ends);
  if (!links.empty())
    doubts.push_back(
        fmt::format("{}: states no travel of {} (limits of 0): add min_deg and max_deg, or poses "
                    "are planned over "
                    "whole turns",
                    file, fmt::join(links, ", ")));
}

}  // namespace

std::vector<std::string> doubts_of_urdf(const Robot& robot, const std::string& text,
                                        const std::string& file, const UrdfEnds& ends) {
  std::vector<std::string> doubts;
  add_base(text, file, ends, doubts);
  add_flange(robot, text, file, ends, doubts);
  add_two_arms(robot, file, doubts);
  add_travel(text, file, ends, doubts);
  return doubts;
}

}  // namespace armtrue
