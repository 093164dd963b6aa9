#include "armtrue/io/products/change_io.h"

#include "armtrue/calibration/identified_values.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "io/products/error_nodes.h"

namespace armtrue {
namespace {

YAML::Node change_node(const KinematicChain& chain, const ParameterChange& change) {
  const DisplayUnit in_files = unit_in_files(chain, change.parameter);
  const double unit = in_files.si;
  // The keys of a number without a unit have no suffix.
  const std::string suffix = in_files.name == "1" ? "" : "_" + in_files.name;
  YAML::Node node;
  node["parameter"] = parameter_name(chain, change.parameter);
  node["change" + suffix] = rounded(change.value / unit);
  node["std" + suffix] = rounded(change.std / unit);
  node["ci95" + suffix] = interval_node(change.ci95, unit);
  return flow(node);
}

YAML::Node move_node(const KinematicChain& chain, const Move& move) {
  YAML::Node node;
  if (move.changes.size() == 1) {
    node = change_node(chain, move.changes.front());
  } else {
    node["parameter"] = move.what;
    for (const ParameterChange& change : move.changes)
      node["changes"].push_back(change_node(chain, change));
  }
  for (const std::string& session : move.sessions) node["sessions"].push_back(session);
  node["p_value"] = rounded(move.p_value);
  return node;
}

// A move of the robot, as part of an explanation.
YAML::Node explaining_node(const KinematicChain& chain, const Move& move) {
  YAML::Node node = move_node(chain, move);
  node["delta_bic"] = rounded(move.delta_bic);
  node["p_value_left"] = rounded(move.p_value_left);
  return node;
}

}  // namespace

Document write_change(const ChangeResult& result, const Robot& previous, const Campaign& campaign,
                      const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-change/1";
  root["provenance"] = provenance_node(provenance);
  root["robot"] = previous.name;
  root["holds"] = boolean(result.holds);
  root["p_value"] = rounded(result.p_value);
  root["poses"] = whole_number(campaign.pose_ids.size());
  root["rows"] = whole_number(campaign.readings());
  root["excluded_rows"] = lines_node(campaign.lines_of(result.blunders));
  std::vector<FlowEntry> spread{{"position_mm", rounded(result.sigma.position / kMillimetre)}};
  if (campaign.has_orientation())
    spread.emplace_back("orientation_mrad", rounded(result.sigma.orientation / kMilliradian));
  root["spread"] = flow_map(spread);
  root["mean_error_mm"] = flow_map({{"before", rounded(result.before / kMillimetre)},
                                    {"after", rounded(result.after / kMillimetre)}});
  std::vector<YAML::Node> moved, indistinguishable, stations;
  for (const Move& move : result.moved) {
    moved.push_back(explaining_node(previous.chain, move));
    for (const Move& rival : move.indistinguishable) {
      YAML::Node& node = indistinguishable.emplace_back(explaining_node(previous.chain, rival));
      node["instead_of"] = move.what;
    }
  }
  for (const Move& station : result.stations)
    stations.push_back(move_node(previous.chain, station));
  root["moved"] = list_node(moved);
  root["indistinguishable"] = list_node(indistinguishable);
  root["p_value_left"] = rounded(result.p_value_left);
  if (!campaign.session_names.empty()) root["stations"] = list_node(stations);
  return print_document(root);
}

}  // namespace armtrue
