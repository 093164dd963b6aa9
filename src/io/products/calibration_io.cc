#include "armtrue/io/products/calibration_io.h"

#include <fmt/format.h>

#include <algorithm>

#include "armtrue/calibration/prediction.h"
#include "armtrue/campaign/training_rows.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "io/products/error_nodes.h"
#include "io/products/gross_poses_text.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

YAML::Node training_rows_node(const TrainingRows& training) {
  std::string marks;
  for (const std::uint32_t mark : training.marks) marks += fmt::format("{:08x}", mark);
  return flow_map({{"count", whole_number(training.rows)}, {"marks", "x" + marks}});
}

// Names the strongest absorbers of a parameter.
std::string absorbers(const KinematicChain& chain, const AbsorbedParameter& absorbed) {
  if (absorbed.absorbed_by.empty()) return "moves nothing that was measured";
  std::string text;
  constexpr size_t kMaxNamed = 4;
  for (size_t i = 0; i < std::min(kMaxNamed, absorbed.absorbed_by.size()); ++i) {
    text += (i ? ", " : "") + parameter_name(chain, absorbed.absorbed_by[i].first);
  }
  if (absorbed.absorbed_by.size() > kMaxNamed)
    text += fmt::format(" and {} more", absorbed.absorbed_by.size() - kMaxNamed);
  return text;
}

YAML::Node zone_node(const WeightedZone& weighted) {
  const Zone& zone = weighted.zone;
  return flow_map({{"x_mm", number_text(zone.centre.x(), kMillimetre)},
                   {"y_mm", number_text(zone.centre.y(), kMillimetre)},
                   {"z_mm", number_text(zone.centre.z(), kMillimetre)},
                   {"radius_mm", number_text(zone.radius, kMillimetre)},
                   {"readings_inside", whole_number(weighted.readings_inside)}});
}

// The spread of the readings of some kinds, of a row with their median stated noise [m].
template <typename IsOf>
double spread_of(const CalibrationResult& result, const Campaign& campaign, const IsOf& is_of) {
  std::vector<double> own;
  for (int row = 0; row < std::ssize(campaign.sigma_position); ++row)
    if (is_of(campaign.kind(row))) own.push_back(campaign.sigma_position[row]);
  if (own.empty()) return result.spread.position;
  return result.spread.position * (median(std::move(own)) / median(campaign.sigma_position));
}

YAML::Node calibration_node(const CalibrationResult& result, const Campaign& campaign,
                            const Evaluation& evaluation) {
  const Robot& robot = result.robot;
  YAML::Node node;
  node["converged"] = boolean(result.converged);
  node["iterations"] = whole_number(result.iterations);
  node["poses"] = whole_number(campaign.pose_ids.size());
  node["rows"] = whole_number(campaign.readings());
  node["unknowns"] = whole_number(result.names.size());
  node["rank"] = whole_number(result.rank);
  node["condition"] = rounded(result.condition);
  YAML::Node observability;
  for (size_t k = 0; k < result.observability.size(); ++k)
    observability["O" + std::to_string(k + 1)] = rounded(result.observability[k]);
  node["observability"] = flow(observability);
  std::vector<FlowEntry> spread{
      {"position_mm",
       rounded(spread_of(result, campaign,
                         [](ReadingKind kind) { return kind != ReadingKind::pixel; }) /
               kMillimetre)}};
  if (campaign.has_orientation())
    spread.emplace_back("orientation_mrad", rounded(result.spread.orientation / kMilliradian));
  if (campaign.has_pixels())
    spread.emplace_back(
        "pixel_px", rounded(spread_of(result, campaign,
                                      [](ReadingKind kind) { return kind == ReadingKind::pixel; }) /
                            campaign.metre_per_pixel));
  node["residual_spread"] = flow_map(spread);
  node["residual_law"] = result.degrees_of_freedom > 0
                             ? fmt::format("student-t {:g}", result.degrees_of_freedom)
                             : std::string("normal");
  node["training"] = errors_node(errors_of(evaluation, campaign));
  if (const auto scale = unseen_scale(robot, campaign))
    node["unseen_scale"] = unseen_scale_node(*scale);
  node["used_readings"] = training_rows_node(training_rows(campaign));
  node["identified"] =
      flow_list(result.set.kept, [&](int k) { return parameter_name(robot.chain, k); });
  YAML::Node shares(YAML::NodeType::Map), nominal(YAML::NodeType::Sequence);
  for (size_t k = 0; k < result.set.kept.size(); ++k) {
    const Eigen::Index unknown = k;
    if (result.prior_weight[unknown] == 0) continue;
    const std::string name = parameter_name(robot.chain, result.set.kept[k]);
    shares[name] = number_in_form("{:.2f}", result.share_of_readings[unknown]);
    if (result.share_of_readings[unknown] < kMostlyReadings) nominal.push_back(name);
  }
  if (shares.size() > 0) node["share_of_readings"] = flow(shares);
  if (nominal.size() > 0) {
    node["near_nominal"] = flow(nominal);
    node["more_poses"] = whole_number(near_nominal(result, campaign).poses);
  }
  for (const int parameter : set_up_not_shown(robot.chain, result.set))
    node["not_shown"][parameter_name(robot.chain, parameter)] = not_shown(robot.chain, parameter);
  for (const AbsorbedParameter& absorbed : result.set.absorbed)
    node["absorbed"][parameter_name(robot.chain, absorbed.parameter)] =
        absorbers(robot.chain, absorbed);
  return node;
}

void add_findings(YAML::Node node, const Campaign& campaign, const CalibrationFindings& findings) {
  if (findings.nominal) node["nominal"] = errors_node(errors_of(*findings.nominal, campaign));
  if (findings.quality) {
    const NoiseFloor& noise = findings.quality->noise;
    node["noise_floor"] = noise_node(noise);
    node["floor_mm"] = floor_node(noise, mean_error(noise, campaign));
    node["excluded_rows"] = lines_node(campaign.lines_of(findings.quality->blunders));
  }
  if (findings.zone) node["zone"] = zone_node(*findings.zone);
  if (!findings.gross.empty()) node["gross_poses"] = gross_poses_node(findings.gross);
}

}  // namespace

Document write_calibration(const CalibrationResult& result, const Campaign& campaign,
                           const Provenance& provenance, const CalibrationFindings& findings) {
  return write_calibration(result, campaign, evaluate(result.robot, campaign), provenance,
                           findings);
}

Document write_calibration(const CalibrationResult& result, const Campaign& campaign,
                           Evaluation evaluation, const Provenance& provenance,
                           const CalibrationFindings& findings) {
  Robot robot = result.robot;
  robot.uncertainty = uncertainty_of(result, campaign, evaluation);
  robot.uncertainty->rest =
      (findings.quality ? *findings.quality : assess(result, campaign, evaluation)).rest;
  YAML::Node root = robot_node(robot, provenance);
  root["calibration"] = calibration_node(result, campaign, evaluation);
  evaluation = {};
  add_findings(root["calibration"], campaign, findings);
  return print_document(root);
}

}  // namespace armtrue
