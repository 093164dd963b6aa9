#pragma once

#include <string>
#include <vector>

#include "report/page.h"
#include "report/residual_pictures.h"

namespace armtrue {

/// One model in the tables of a page: its name, and where its errors stand in the product.
struct TabledModel {
  std::string name, key;  ///< `key`: of position_mm and axes_mm, with a slash
};

/// Lengths, orientations and axes of models, in numbers.
std::string errors_table(const Page& page, const std::vector<TabledModel>& models);

/// Distribution, axes, course, worst poses and map of the errors, with headings. `up`: the vertical
/// in R_A.
void add_error_pictures(Page& page, const std::vector<Judged>& models, const Campaign& campaign,
                        const std::vector<bool>& left_out, const std::string& readings,
                        const Eigen::Vector3d& up);

/// Whether a mean error [m] is at most 1.3 times that of a complete model,
/// NoiseFloor::mean_error(); false if the noise is unknown.
bool is_at_floor(double mean, const NoiseFloor& noise);

/// A paragraph on the position error that an unobservable error of the instrument's scale would
/// cause; empty if the product has no such value. `key`: of unseen_scale, with a slash.
std::string unseen_scale_text(const Page& page, const std::string& key);

/// A paragraph on the frames and tools that a program corrected with this robot needs.
std::string frames_text();

/// The tile of the mean error of a complete model, from its key; it says so if the noise is
/// unknown.
Page::Tile floor_tile(const Page& page, const NoiseFloor& noise, const std::string& key);

}  // namespace armtrue
