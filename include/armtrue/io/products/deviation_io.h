#pragma once

#include <string>

#include "armtrue/kinematics/joint_names.h"
#include "armtrue/path/mirror/mirror.h"

namespace armtrue {

/// The deviation on its grid: `t_s,s_mm,dx_mm,dy_mm,dz_mm` (across the path), `along_mm`,
/// `trend_x_mm,trend_y_mm,trend_z_mm`, and `break`, 1 where the trend may jump.
std::string write_deviation(const PathDeviation& deviation);

/// Measured poses for close-loop: means of `block` neighbouring samples on the grid of the
/// deviation while the tool moves. `q`: joint angles at the samples of the programmed path. Columns
/// `pose,t_s,q1_deg..q6_deg,x_mm,y_mm,z_mm,sigma_mm` (noise of the mean) and, where there are
/// forces, `fx_n,fy_n,fz_n`.
std::string write_pass_as_poses(const Path& programmed, const JointMatrix& q,
                                const PathDeviation& deviation, int block,
                                const std::vector<JointName>& joints = six_axis_names());

}  // namespace armtrue
