#include "armtrue/io/products/evaluation_io.h"

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"
#include "io/products/error_nodes.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {

namespace {

YAML::Node prediction_node(const Evaluation& evaluation, const Campaign& campaign,
                           const std::vector<Prediction>& predictions) {
  double inside = 0, deviation = 0;
  std::vector<double> leverage(campaign.pose_ids.size(), 0.0);
  for (size_t row = 0; row < predictions.size(); ++row) {
    inside += evaluation.position[row] <= predictions[row].bound_95;
    deviation += predictions[row].deviation * predictions[row].deviation;
    double& of_pose = leverage[campaign.pose[row]];
    of_pose = std::max(of_pose, predictions[row].leverage);
  }
  const auto rows = static_cast<double>(predictions.size());
  YAML::Node outside(YAML::NodeType::Sequence);
  for (size_t pose = 0; pose < leverage.size(); ++pose)
    if (leverage[pose] > 1) outside.push_back(campaign.pose_ids[pose]);
  YAML::Node node;
  node["rms_mm"] = rounded(std::sqrt(deviation / rows) / kMillimetre);
  node["inside_95"] = rounded(inside / rows);
  node["outside_measured"] = flow(outside);
  return node;
}

}  // namespace

Document write_summary(const Evaluation& evaluation, const Robot& robot, const Campaign& campaign,
                       const Provenance& provenance, const std::vector<Prediction>& predictions,
                       const std::optional<Robot>& against) {
  YAML::Node root;
  root["format"] = "armtrue-summary/1";
  root["provenance"] = provenance_node(provenance);
  root["robot"] = robot.name;
  root["poses"] = whole_number(campaign.pose_ids.size());
  root["rows"] = whole_number(campaign.readings());
  root["skipped_rows"] = whole_number(campaign.skipped_rows);
  const NoiseFloor noise = noise_floor(robot, campaign, evaluation);
  root["noise_floor"] = noise_node(noise);
  root["floor_mm"] = floor_node(noise, mean_error(noise, campaign));
  const PoseErrors errors = errors_of(evaluation, campaign);
  root["position_mm"] = error_node(errors.position, kMillimetre);
  if (errors.orientation) root["orientation_mrad"] = error_node(*errors.orientation, kMilliradian);
  if (!predictions.empty()) root["prediction"] = prediction_node(evaluation, campaign, predictions);
  root["axes_mm"] = axes_node(errors.axes);
  add_kinds(errors, root);
  if (const auto scale = unseen_scale(robot, campaign))
    root["unseen_scale"] = unseen_scale_node(*scale);
  if (against) {
    root["against"] = errors_node(errors_of(*against, campaign));
    root["against"]["robot"] = against->name;
  }
  return print_document(root);
}

}  // namespace armtrue
