#include "armtrue/io/products/residuals_io.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "io/csv_cell.h"
#include "io/row_text.h"

namespace armtrue {
namespace {

// The axis of the coordinate that a row reads, of R_A or of an artefact; -1 of other rows.
int axis_of(const Campaign& campaign, int row) {
  const ReadingKind kind = campaign.kind(row);
  if (kind == ReadingKind::touch || kind == ReadingKind::pixel) return campaign.touch[row].axis;
  return kind == ReadingKind::coordinate ? campaign.coordinate[row]->axis : -1;
}

// For each row the length of the error of its reading, the same for the rows of one point.
std::vector<double> errors_of_readings(const Residuals& part) {
  std::vector<double> errors;
  errors.reserve(part.of_row.size());
  for (const auto& residual : part.of_row) errors.push_back(residual.head<3>().norm());
  std::vector<int> first = part.campaign.first_rows_of_readings();
  if (first.empty()) return errors;
  first.push_back(part.campaign.rows());
  for (size_t k = 0; k + 1 < first.size(); ++k) {
    const auto begin = errors.begin() + first[k], end = errors.begin() + first[k + 1];
    const double squares = std::inner_product(begin, end, begin, 0.0);
    if (end - begin > 1) std::fill(begin, end, std::sqrt(squares));
  }
  return errors;
}

// Which columns the table has beside those that every one has.
struct OptionalColumns {
  bool of_distances, predicted, of_pixels;
};

void append_row(const Residuals& part, int row, double error, const OptionalColumns& columns,
                std::string& text) {
  const auto& [campaign, residuals, split, predictions] = part;
  const auto& residual = residuals[row];
  text += csv_cell(campaign.pose_ids[campaign.pose[row]]) + "," +
          (campaign.repeat.empty() ? "" : std::to_string(campaign.repeat[row])) + "," + split[row];
  const auto add = [&](double value, double unit) { text += "," + number_text(value / unit); };
  const bool has_point = !campaign.reads_one_number();
  const int axis = axis_of(campaign, row);
  for (int i = 0; i < 3; ++i)
    if (i == axis)
      add(residual[0], kMillimetre);
    else if (has_point)
      add(residual[i], kMillimetre);
    else
      text += ",";
  if (campaign.has_orientation())
    for (int i = 3; i < 6; ++i) add(residual[i], kMilliradian);
  else
    text += ",,,";
  add(error, kMillimetre);
  if (campaign.has_orientation())
    add(residual.tail<3>().norm(), kMilliradian);
  else
    text += ",";
  if (campaign.reads_one_number() && axis < 0)
    add(residual[0], kMillimetre);
  else if (columns.of_distances)
    text += ",";
  for (int i = 0; columns.of_pixels && i < 2; ++i) {
    if (campaign.kind(row) == ReadingKind::pixel && i == axis)
      add(residual[0], campaign.metre_per_pixel);
    else
      text += ",";
  }
  if (!predictions.empty()) {
    const Prediction& prediction = predictions[row];
    add(prediction.deviation, kMillimetre);
    add(prediction.bound_95, kMillimetre);
    text += residual.head<3>().norm() <= prediction.bound_95 ? ",1" : ",0";
    add(prediction.leverage, 1);
  } else if (columns.predicted) {
    text += ",,,,";
  }
  text += "\n";
}

}  // namespace

std::string write_residuals(const std::vector<Residuals>& campaigns) {
  const bool of_distances = std::ranges::any_of(campaigns, [](const Residuals& part) {
    return part.campaign.reads_one_number() && !part.campaign.has_pixels_only();
  });
  std::string text =
      "pose,repeat,split,dx_mm,dy_mm,dz_mm,rx_mrad,ry_mrad,rz_mrad,position_error_mm,"
      "orientation_error_mrad";
  if (of_distances) text += ",dl_mm";
  const bool of_pixels = std::ranges::any_of(
      campaigns, [](const Residuals& part) { return part.campaign.has_pixels(); });
  if (of_pixels) text += ",du_px,dv_px";
  const bool predicted = std::ranges::any_of(
      campaigns, [](const Residuals& part) { return !part.predictions.empty(); });
  text += predicted ? ",std_mm,bound_95_mm,inside_95,leverage\n" : "\n";
  for (const Residuals& part : campaigns) {
    const std::vector<double> errors = errors_of_readings(part);
    append_rows(
        part.campaign.rows(),
        [&](int row, std::string& lines) {
          append_row(part, row, errors[row], {of_distances, predicted, of_pixels}, lines);
        },
        text);
  }
  return text;
}

std::string write_residuals(const Robot& robot, const Campaign& all, const Split& split,
                            const Campaign& test) {
  std::vector<std::string> part(all.rows(), "training");
  for (int row : split.held_out) part[row] = "held-out";
  std::vector<Residuals> parts{{all, evaluate(robot, all).residuals, part}};
  if (test.rows() > 0)
    parts.push_back(
        {test, evaluate(robot, test).residuals, std::vector<std::string>(test.rows(), "held-out")});
  return write_residuals(parts);
}

}  // namespace armtrue
