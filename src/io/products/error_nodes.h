#pragma once

#include <array>
#include <optional>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/unseen_scale.h"
#include "armtrue/statistics/summary.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {

/// A 95 % interval.
YAML::Node interval_node(const std::array<double, 2>& bounds, double unit);

/// Lines of a file.
YAML::Node lines_node(const std::vector<int>& lines);
YAML::Node error_node(const ErrorSummary& errors, double unit);
/// The errors of each axis.
YAML::Node axes_node(const std::vector<AxisErrors>& axes);
/// Lengths, each axis, and what add_kinds() adds.
YAML::Node errors_node(const PoseErrors& errors);
/// Adds, of images, the errors in pixels and the length of a pixel at the board; of several kinds
/// of readings, the errors of each kind.
void add_kinds(const PoseErrors& errors, YAML::Node node);
/// The position errors that an unobservable error of scale would cause.
YAML::Node unseen_scale_node(const UnseenScale& scale);

YAML::Node noise_node(const NoiseFloor& noise);

/// The mean error of a perfect model in mm, `floor` in m; null if nothing says how large the noise
/// is.
YAML::Node floor_node(const NoiseFloor& noise, double floor);

}  // namespace armtrue
