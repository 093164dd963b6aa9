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

// Whether a row reads a point, before points_to_coordinates().
bool reads_point(const Campaign& campaign, int row) {
  const ReadingKind kind = campaign.kind(row);
  return kind == ReadingKind::point ||
         (kind == ReadingKind::distance && campaign.distance[row] == 0);
}

// Which kinds of readings the rows have: they decide on the columns.
struct Kinds {
  bool points = false, distances = false, touches = false, beams = false, pixels = false;
  bool camera = false, board = false;  // are named
  bool sigma = false;                  // each row states one

  explicit Kinds(const Campaign& campaign)
      : sigma(!campaign.sigma_position.empty() && !stated_blocks(campaign).position) {
    for (int row = 0; row < campaign.rows(); ++row) add(campaign, row);
  }

  bool has_lengths() const { return points || distances || touches; }

 private:
  void add(const Campaign& campaign, int row) {
    if (reads_point(campaign, row)) {
      points = true;
    } else if (campaign.kind(row) == ReadingKind::distance) {
      distances = true;
    } else if (const std::string& name = campaign.contact_names[campaign.touch[row].contact];
               campaign.kind(row) == ReadingKind::pixel) {
      pixels = true;
      camera |= !PixelName(name).camera.empty();
      board |= !PixelName(name).board.empty();
    } else {
      touches = true;
      beams |= BeamName::is_one(name);
    }
  }
};

void append_row(const Campaign& campaign, const Kinds& kinds, const std::vector<JointName>& joints,
                int row, std::string& text) {
  text += csv_cell(campaign.pose_ids[campaign.pose[row]]);
  const auto add = [&](const std::string& cell) { (text += ",") += cell; };
  if (!campaign.repeat.empty()) add(std::to_string(campaign.repeat[row]));
  if (!campaign.time_s.empty()) add(number_text(campaign.time_s[row]));
  for (size_t j = 0; j < joints.size(); ++j) add(number_text(campaign.q[row][j], joints[j].si()));
  const ReadingKind kind = campaign.kind(row);
  const bool is_point = reads_point(campaign, row), is_pixel = kind == ReadingKind::pixel;
  const bool is_touch = kind == ReadingKind::touch;
  const std::string name =
      is_pixel || is_touch ? campaign.contact_names[campaign.touch[row].contact] : "";
  const bool is_beam = is_touch && BeamName::is_one(name);
  // A cell of a column that only some kinds of readings have.
  const auto add_if = [&](bool reads, const auto& cell) { add(reads ? cell() : std::string()); };
  if (kinds.camera) add_if(is_pixel, [&] { return csv_cell(PixelName(name).camera); });
  if (kinds.board) add_if(is_pixel, [&] { return csv_cell(PixelName(name).board); });
  if (kinds.pixels) {
    add_if(is_pixel, [&] { return csv_cell(PixelName(name).corner); });
    for (int axis = 0; axis < 2; ++axis)
      add_if(is_pixel, [&] { return number_text(campaign.position[row][axis]); });
    if (kinds.sigma) add_if(is_pixel, [&] { return number_text(campaign.sigma_position[row]); });
  }
  if (kinds.beams) add_if(is_beam, [&] { return csv_cell(BeamName(name).beam); });
  if (kinds.touches)
    add_if(is_touch, [&] { return csv_cell(is_beam ? BeamName(name).contact : name); });
  if (campaign.has_profiles())
    for (const double value : {campaign.profile[row].y, campaign.profile[row].z})
      add(number_text(value, kMillimetre));
  if (kinds.beams || kinds.distances)
    add_if(is_beam || (kind == ReadingKind::distance && !is_point),
           [&] { return number_text(campaign.distance[row], kMillimetre); });
  if (kinds.points)
    for (int i = 0; i < 3; ++i)
      add_if(is_point, [&] { return number_text(campaign.position[row][i], kMillimetre); });
  if (kinds.sigma && kinds.has_lengths())
    add_if(!is_pixel, [&] { return number_text(campaign.sigma_position[row], kMillimetre); });
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
  if (!campaign.target.empty())
    add_if(!is_pixel && !is_beam,
           [&] { return csv_cell(campaign.target_names[campaign.target[row]]); });
  if (!campaign.anchor.empty())
    add_if(kind == ReadingKind::distance && !is_point,
           [&] { return csv_cell(campaign.anchor_names[campaign.anchor[row]]); });
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
  const Kinds kinds(campaign);
  if (kinds.camera) text += ",camera";
  if (kinds.board) text += ",board";
  if (kinds.pixels) text += std::string(",corner,u_px,v_px") + (kinds.sigma ? ",sigma_px" : "");
  if (kinds.beams) text += ",beam";
  if (kinds.touches) text += ",contact";
  if (campaign.has_profiles()) text += ",profile_y_mm,profile_z_mm";
  if (kinds.beams || kinds.distances) text += ",l_mm";
  if (kinds.points) text += ",x_mm,y_mm,z_mm";
  if (kinds.sigma && kinds.has_lengths()) text += ",sigma_mm";
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
      [&](int row, std::string& lines) { append_row(campaign, kinds, joints, row, lines); }, text);
  return text;
}

}  // namespace armtrue
