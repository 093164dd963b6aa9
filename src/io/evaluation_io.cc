#include "armtrue/io/evaluation_io.h"

#include <algorithm>

#include "armtrue/kinematics/units.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {

std::string write_summary(const Evaluation& evaluation, const Robot& robot,
                          const Campaign& campaign, const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-summary/1";
  root["provenance"] = provenance_node(provenance);
  root["robot"] = robot.name;
  root["poses"] = std::to_string(campaign.pose_ids.size());
  root["rows"] = std::to_string(campaign.rows());
  root["skipped_rows"] = std::to_string(campaign.skipped_rows);
  root["noise_floor"] = noise_node(noise_floor(robot, campaign, evaluation));
  root["position_mm"] = error_node(summarize(evaluation.position), kMillimetre);
  if (!evaluation.orientation.empty())
    root["orientation_mrad"] = error_node(summarize(evaluation.orientation), kMilliradian);
  YAML::Node axes;
  for (int i = 0; i < campaign.reading_size().position; ++i) {
    double sum = 0, low = 1e300, high = -1e300;
    for (const auto& residual : evaluation.residuals) {
      sum += residual[i];
      low = std::min(low, residual[i]);
      high = std::max(high, residual[i]);
    }
    axes[std::string(1, campaign.has_distances() ? 'l' : "xyz"[i])] =
        flow_map({{"mean", rounded(sum / kMillimetre / static_cast<double>(campaign.rows()))},
                  {"min", rounded(low / kMillimetre)},
                  {"max", rounded(high / kMillimetre)}});
  }
  root["axes_mm"] = axes;
  return print_document(root);
}

}  // namespace armtrue
