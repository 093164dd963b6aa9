#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/io/provenance.h"
#include "armtrue/path/accuracy.h"
#include "armtrue/path/mirror/mirror.h"

namespace armtrue {

/// What a mirror document may hold beside the correction itself.
struct MirrorFindings {
  MirrorResult result;
  MirrorOptions options;
  std::vector<std::string> files;       ///< the measured passes
  std::vector<std::vector<int>> lines;  ///< of the files, for each sample
  PassAccuracy accuracy;                ///< of these passes, noise of the instrument included
  std::optional<PassAccuracy> before;   ///< of earlier passes, to compare with
  std::optional<ForceLaw> force;
  std::optional<ForceLine> robot;  ///< measured deviation on that predicted from the force
};

/// armtrue-mirror/1: clocks of the passes with their uncertainty, noise, deviation before, the
/// correction and what the next pass is expected to show; accuracy by ISO 9283; what forces and
/// reversals have to do with it.
std::string write_mirror(const MirrorFindings& findings, const Provenance& provenance);

/// The same for a terminal, in a few lines.
std::string mirror_table(const MirrorFindings& findings);

/// The deviation on its grid: `t_s,s_mm,dx_mm,dy_mm,dz_mm` (across the path), `along_mm`,
/// `trend_x_mm,trend_y_mm,trend_z_mm`, and `break`, 1 where the trend may jump.
std::string write_deviation(const PathDeviation& deviation);

/// Measured poses for close-loop: means of `block` neighbouring samples of the deviation's grid
/// while the tool moves, with the joint angles `q` of the programmed path at its samples. Columns
/// `pose,t_s,q1_deg..q6_deg,x_mm,y_mm,z_mm,sigma_mm` (noise of the mean) and, where there are
/// forces, `fx_n,fy_n,fz_n`.
std::string write_pass_as_poses(const Path& programmed,
                                const Eigen::Matrix<double, kJoints, Eigen::Dynamic>& q,
                                const PathDeviation& deviation, int block);

}  // namespace armtrue
