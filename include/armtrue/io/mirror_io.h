#pragma once

#include <string>
#include <vector>

#include "armtrue/io/provenance.h"
#include "armtrue/path/mirror.h"

namespace armtrue {

/// armtrue-mirror/1: clocks of the passes with their uncertainty, noise, deviation before, the
/// correction and what the next pass is expected to show. `files` names the measured passes.
std::string write_mirror(const MirrorResult& result, const MirrorOptions& options,
                         const std::vector<std::string>& files, const Provenance& provenance);

/// The same for a terminal, in a few lines.
std::string mirror_table(const MirrorResult& result, const std::vector<std::string>& files);

/// The deviation on its grid: `t_s,s_mm,dx_mm,dy_mm,dz_mm` (across the path), `along_mm`,
/// `trend_x_mm,trend_y_mm,trend_z_mm`, and `break`, 1 where the trend may jump.
std::string write_deviation(const PathDeviation& deviation);

}  // namespace armtrue
