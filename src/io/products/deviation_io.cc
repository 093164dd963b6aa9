#include "armtrue/io/products/deviation_io.h"

#include <fmt/format.h>

#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"

namespace armtrue {

std::string write_deviation(const PathDeviation& deviation) {
  std::string text = "t_s,s_mm,dx_mm,dy_mm,dz_mm,along_mm,trend_x_mm,trend_y_mm,trend_z_mm,break\n";
  size_t next = 0;
  for (Eigen::Index i = 0; i < deviation.time.size(); ++i) {
    const bool breaks = next < deviation.breaks.size() && deviation.breaks[next] == i;
    next += breaks;
    const Eigen::Vector3d normal = deviation.normal.col(i) / kMillimetre;
    const Eigen::Vector3d trend = deviation.trend.col(i) / kMillimetre;
    text += fmt::format("{:.6f},{:.4f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{}\n",
                        deviation.time[i], deviation.arc_length[i] / kMillimetre, normal[0],
                        normal[1], normal[2], deviation.along[i] / kMillimetre, trend[0], trend[1],
                        trend[2], breaks ? 1 : 0);
  }
  return text;
}

std::string write_pass_as_poses(const Path& programmed, const JointMatrix& q,
                                const PathDeviation& deviation, int block,
                                const std::vector<JointName>& joints) {
  const bool with_force = deviation.force.cols() > 0;
  std::string text = "pose,t_s";
  for (const JointName& joint : joints) text += "," + joint.encoder();
  text += ",x_mm,y_mm,z_mm,sigma_mm";
  text += with_force ? ",fx_n,fy_n,fz_n\n" : "\n";
  const std::string sigma = ',' + decimal_text(deviation.noise / std::sqrt(block) / kMillimetre, 6);
  const Eigen::Matrix3Xd wanted = position_at(programmed, deviation.time);
  const Eigen::Matrix3Xd measured = wanted + deviation.whole;
  const Eigen::MatrixXd angles = interpolate(programmed.time, q, deviation.time);
  size_t next_break = 0;
  int pose = 0;
  for (Eigen::Index begin = 0; begin + block <= deviation.time.size();) {
    while (next_break < deviation.breaks.size() && deviation.breaks[next_break] <= begin)
      ++next_break;
    const bool jumps =
        next_break < deviation.breaks.size() && deviation.breaks[next_break] < begin + block;
    if (jumps) {
      begin = deviation.breaks[next_break];
      continue;
    }
    if (wanted.col(begin) != wanted.col(begin + block - 1)) {
      text += fmt::format("{},{}", ++pose,
                          decimal_text(deviation.time.segment(begin, block).mean(), 7));
      const auto add = [&](const auto& values, double unit, int decimals) {
        const Eigen::VectorXd mean = values.middleCols(begin, block).rowwise().mean();
        for (const double value : mean) text += ',' + decimal_text(value / unit, decimals);
      };
      for (Eigen::Index j = 0; j < angles.rows(); ++j) add(angles.row(j), joints[j].si(), 9);
      add(measured, kMillimetre, 6);
      text += sigma;
      if (with_force) add(deviation.force, 1, 6);
      text += '\n';
    }
    begin += block;
  }
  return text;
}

}  // namespace armtrue
