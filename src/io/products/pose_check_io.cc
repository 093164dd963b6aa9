#include "armtrue/io/products/pose_check_io.h"

#include <Eigen/Geometry>

#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

YAML::Node numbers_of_pose(const PendantPose& pose) {
  YAML::Node node;
  constexpr const char* kKeys[] = {"x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"};
  for (size_t i = 0; i < pose.size(); ++i) node[kKeys[i]] = number_in_form("{:.6f}", pose[i] + 0.0);
  return node;
}

YAML::Node shown_frame_node(const ShownFrame& frame) {
  const Eigen::Vector3d place = frame.pose.translation / kMillimetre;
  const Eigen::Vector3d abc = abc_from_rotation(frame.pose.rotation) / kDegree;
  YAML::Node node = numbers_of_pose({place[0], place[1], place[2], abc[0], abc[1], abc[2]});
  const Eigen::Quaterniond q(frame.pose.rotation);
  for (const double part : {q.w(), q.x(), q.y(), q.z()})
    node["quaternion_wxyz"].push_back(number_in_form("{:.9f}", part + 0.0));
  node["quaternion_wxyz"].SetStyle(YAML::EmitterStyle::Flow);
  node["name"] = frame.name;
  node["what"] = frame.what;
  return flow(node);
}

YAML::Node agreement_node(const Agreement& agreement) {
  YAML::Node node;
  node["frame"] = agreement.frame;
  node["changes"] = texts_node(agreement.changes);
  node["distance_mm"] = rounded(agreement.distance / kMillimetre);
  node["angle_deg"] = rounded(agreement.angle / kDegree);
  return node;
}

}  // namespace

Document write_pose_check(const Robot& robot, const PoseCheck& check,
                          const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-pose-check/1";
  root["provenance"] = provenance_node(provenance);
  root["robot"] = robot.name;
  const std::vector<JointName> joints = joint_names(robot.chain);
  for (size_t j = 0; j < joints.size(); ++j)
    root["joints"][joints[j].encoder()] =
        number_text(check.q[static_cast<Eigen::Index>(j)], joints[j].si());
  for (const ShownFrame& frame : check.frames) root["frames"].push_back(shown_frame_node(frame));
  if (!check.pose) return print_document(root);
  root["pose"] = flow(numbers_of_pose(*check.pose));
  root["agrees"] = boolean(check.agrees());
  std::vector<YAML::Node> agreements;
  for (const Agreement& agreement : check.agreements)
    agreements.push_back(agreement_node(agreement));
  root["agreements"] = list_node(agreements);
  return print_document(root);
}

}  // namespace armtrue
