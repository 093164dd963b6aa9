#pragma once

#include <string>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/campaign.h"
#include "report/svg.h"

namespace armtrue {

/// One model on the readings of a picture.
struct Judged {
  std::string name;
  Look look;
  Evaluation evaluation;
};

/// How the lengths of the errors are distributed, from 0 on, a row for each model (seed paper,
/// figure 3). `readings`: what is counted, as "held-out readings".
Drawing histogram_picture(const std::vector<Judged>& models, const std::string& readings);

/// Mean and range of each axis, a mark for each model (figure 4).
Drawing axes_picture(const std::vector<Judged>& models, const Campaign& campaign);

/// The length of the error of each reading, in the order of the visits. `left_out_rows`: by row,
/// whether the fit left it out; such readings are marked. Empty: none.
Drawing campaign_picture(const std::vector<Judged>& models, const Campaign& campaign,
                         const std::vector<bool>& left_out_rows);

/// The pose of a reading, such as "pose P7".
std::string reading_name(const Campaign& campaign, const Evaluation& evaluation, size_t reading);

/// The mean error of each pose as a vector at its place, from three sides and in three dimensions;
/// empty without points. Differences: measured minus model. `up`: the vertical in R_A.
std::vector<Drawing> residual_maps(const std::vector<Judged>& models, const Campaign& campaign,
                                   const Eigen::Vector3d& up);

/// A round factor by which vectors of `longest` [m] are drawn over a workspace of `extent` [m].
double round_magnification(double longest, double extent);

/// Vectors at places of a workspace, for field_maps().
struct VectorField {
  std::string name;
  Look look;
  std::vector<Eigen::Vector3d> vectors;  // [m]
};
struct FieldText {
  std::string file, title, frame, note;  ///< `file`: begins the names of the pictures
  std::string what = "errors";           ///< plural, of what the vectors are
  Eigen::Index most = 250;               ///< vectors to draw
  std::vector<std::string> names = {};   ///< of the places, for a pointer; none if empty
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< the vertical in the frame
};
/// The fields, a vector for each place, seen from three sides and in three dimensions. `places`:
/// [m].
std::vector<Drawing> field_maps(const std::vector<Eigen::Vector3d>& places,
                                const std::vector<VectorField>& fields, const FieldText& text);

}  // namespace armtrue
