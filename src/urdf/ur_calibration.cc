#include <yaml-cpp/yaml.h>

#include <array>
#include <map>

#include "armtrue/text/number_text.h"
#include "armtrue/text/text_parts.h"
#include "armtrue/urdf/ur_calibration_io.h"
#include "io/yaml/yaml_map.h"
#include "urdf/link_frames.h"
#include "urdf/urdf_chain.h"
#include "urdf/urdf_patch.h"

namespace armtrue {
namespace {

constexpr std::array<const char*, 6> kUrLinks{"shoulder", "upper_arm", "forearm",
                                              "wrist_1",  "wrist_2",   "wrist_3"};
constexpr std::array<const char*, 6> kUrNumbers{"x", "y", "z", "roll", "pitch", "yaw"};

UrdfChain read_ur_chain(const std::string& text, const std::string& file) {
  YamlMap document = read_document(text, file, {""});
  YamlMap kinematics = document.map("kinematics");
  UrdfChain chain;
  chain.robot = "Universal Robots, " + kinematics.text("hash", "no hash");
  chain.base = "base";
  for (const char* link : kUrLinks) {
    YamlMap entry = kinematics.map(link);
    std::array<double, 6> n{};
    for (size_t k = 0; k < n.size(); ++k) n[k] = entry.number(kUrNumbers[k]);
    entry.finish();
    ChainJoint joint;
    joint.name = joint.link = link;
    joint.kind = ChainJoint::Kind::revolute;
    // URDF's roll, pitch and yaw are KUKA's C, B and A.
    joint.origin = {rotation_from_abc(n[5], n[4], n[3]), {n[0], n[1], n[2]}};
    chain.joints.push_back(joint);
  }
  kinematics.finish();
  return chain;
}

// Of the numbers of the links.
std::vector<Replacement> changes(const std::string& document,
                                 const std::map<std::string, Pose>& origins) {
  std::vector<Replacement> result;
  const size_t before = document.starts_with("\xEF\xBB\xBF") ? 3 : 0;  // yaml-cpp counts no BOM
  const YAML::Node kinematics = YAML::Load(document)["kinematics"];
  for (const auto& [link, pose] : origins) {
    const Eigen::Vector3d rpy = roll_pitch_yaw(pose.rotation), &t = pose.translation;
    const std::array<double, 6> n{t.x(), t.y(), t.z(), rpy[0], rpy[1], rpy[2]};
    for (size_t k = 0; k < n.size(); ++k) {
      const YAML::Node node = kinematics[link][kUrNumbers[k]];
      const size_t at = before + node.Mark().pos;
      const bool is_quoted = document[at] == '"' || document[at] == '\'';
      const size_t size = node.Scalar().size() + (is_quoted ? 2 : 0);
      result.push_back({at, at + size, number_text(n[k])});
    }
  }
  return result;
}

}  // namespace

bool is_ur_calibration(const std::string& text) {
  return text.starts_with("kinematics:") || text.find("\nkinematics:") != std::string::npos;
}

Robot parse_ur_calibration(const std::string& text, const std::string& file) {
  return robot_of(read_ur_chain(text, file), "", file);
}

PatchedUrdf write_into_ur_calibration(const Robot& robot, const std::string& document,
                                      const std::string& file, const UrdfKept& kept) {
  const UrdfChain chain = read_ur_chain(document, file);
  const ChainPatch patch = patch_of(chain, robot_of(chain, "", file), robot, kept, file);
  PatchedUrdf result{replaced(document, changes(document, patch.origins)), patch.base, patch.tool,
                     patch.tool_left_out};
  require_same_arm(patch.robot, parse_ur_calibration(result.text, file), file);
  return result;
}

}  // namespace armtrue
