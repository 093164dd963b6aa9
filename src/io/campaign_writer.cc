#include <fmt/format.h>

#include <string>

#include "armtrue/campaign/stated_covariance.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "io/campaign_columns.h"
#include "io/csv_cell.h"
#include "io/joint_columns.h"
#include "io/row_text.h"

namespace armtrue {
namespace {

// Calls take(row, column) for each entry of the covariance that has a column.
template <typename Take>
void for_each_covariance(const StatedBlocks& blocks, const Take& take) {
  if (!blocks.any()) return;
  for (int i = blocks.position ? 0 : 3; i < 6; ++i)
    for (int k = i; k < (blocks.rotation ? 6 : 3); ++k) take(i, k);
}

void append_row(const Campaign& campaign, const std::vector<JointName>& joints, int row,
                std::string& text) {
  text += csv_cell(campaign.pose_ids[campaign.pose[row]]);
  const auto add = [&](const std::string& cell) { (text += ",") += cell; };
  if (!campaign.repeat.empty()) add(std::to_string(campaign.repeat[row]));
  if (!campaign.time_s.empty()) add(number_text(campaign.time_s[row]));
  for (size_t j = 0; j < joints.size(); ++j) add(number_text(campaign.q[row][j], joints[j].si()));
  if (campaign.has_pixels()) {
    const PixelName name(campaign.contact_names[campaign.touch[row].contact]);
    if (!name.camera.empty()) add(csv_cell(name.camera));
    if (!name.board.empty()) add(csv_cell(name.board));
    add(csv_cell(name.corner));
    for (int axis = 0; axis < 2; ++axis) add(number_text(campaign.position[row][axis]));
  } else if (campaign.has_touches()) {  // of beams
    const BeamName name(campaign.contact_names[campaign.touch[row].contact]);
    add(csv_cell(name.beam));
    add(csv_cell(name.contact));
    add(number_text(campaign.distance[row], kMillimetre));
  } else if (campaign.has_distances()) {
    add(number_text(campaign.distance[row], kMillimetre));
  } else {
    for (int i = 0; i < 3; ++i) add(number_text(campaign.position[row][i], kMillimetre));
  }
  if (campaign.has_orientation()) {
    const Eigen::Vector3d abc = abc_from_rotation(campaign.orientation[row].toRotationMatrix());
    for (int i = 0; i < 3; ++i) add(number_text(abc[i], kDegree));
  }
  if (const StatedBlocks blocks = stated_blocks(campaign); blocks.any()) {
    const PoseCovariance covariance = stated_covariance(campaign, row);
    for_each_covariance(blocks, [&](int i, int k) {
      add(fmt::format("{:.12g}", covariance(i, k) / covariance_unit(i, k)));
    });
  }
  if (!campaign.target.empty()) add(csv_cell(campaign.target_names[campaign.target[row]]));
  if (!campaign.anchor.empty()) add(csv_cell(campaign.anchor_names[campaign.anchor[row]]));
  if (!campaign.arrival.empty())
    for (size_t j = 0; j < joints.size(); ++j) add(std::to_string(campaign.arrival[row][j]));
  if (!campaign.session.empty()) add(csv_cell(campaign.session_names[campaign.session[row]]));
  if (!campaign.payload_kg.empty()) add(number_text(campaign.payload_kg[row]));
  for (size_t k = 0; k < campaign.temperature_names.size(); ++k)
    add(number_text(campaign.temperature_c[row][k]));
  text += "\n";
}

}  // namespace

std::string write_campaign(const Campaign& campaign, const std::vector<JointName>& joints) {
  std::string text = "pose";
  if (!campaign.repeat.empty()) text += ",repeat";
  if (!campaign.time_s.empty()) text += ",t_s";
  for (const JointName& joint : joints) text += "," + joint.encoder();
  if (campaign.has_pixels()) {
    const PixelName name(campaign.contact_names.at(0));
    text += std::string(name.camera.empty() ? "" : ",camera") +
            (name.board.empty() ? "" : ",board") + ",corner,u_px,v_px";
  } else if (campaign.has_touches()) {
    text += ",beam,contact,l_mm";
  } else {
    text += campaign.has_distances() ? ",l_mm" : ",x_mm,y_mm,z_mm";
  }
  if (campaign.has_orientation()) text += ",a_deg,b_deg,c_deg";
  for_each_covariance(stated_blocks(campaign),
                      [&](int i, int k) { text += "," + covariance_column(i, k); });
  if (!campaign.target.empty()) text += ",target";
  if (!campaign.anchor.empty()) text += ",anchor";
  if (!campaign.arrival.empty())
    for (const std::string& name : numbered_columns("dir", joints)) text += "," + name;
  if (!campaign.session.empty()) text += ",session";
  if (!campaign.payload_kg.empty()) text += ",payload_kg";
  for (const std::string& name : campaign.temperature_names) text += "," + csv_cell("temp_" + name + "_c");
  text += "\n";
  append_rows(
      campaign.rows(),
      [&](int row, std::string& lines) { append_row(campaign, joints, row, lines); }, text);
  return text;
}

}  // namespace armtrue
