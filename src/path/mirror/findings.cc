#include "armtrue/path/mirror/findings.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/kinematics/joint_names.h"
#include "armtrue/path/joint_path.h"
#include "armtrue/path/joint_reversals.h"
#include "armtrue/path/low_pass.h"
#include "armtrue/path/mirror/pass_doubts.h"
#include "path/mirror/corners.h"
#include "path/mirror/frame_error.h"
#include "path/mirror/mean_deviation.h"

namespace armtrue {
namespace {

// The passes in the clock of the program.
std::vector<Path> all_registered(const std::vector<Path>& passes, const std::vector<Pass>& clocks) {
  std::vector<Path> in_time;
  for (size_t p = 0; p < passes.size(); ++p)
    in_time.push_back(registered(passes[p], clocks[p].clock));
  return in_time;
}

PassAccuracy pass_accuracy(const Path& programmed, const std::vector<Path>& passes) {
  const Eigen::Matrix3Xd tangent = side_tangents(programmed, find_corners(programmed));
  std::vector<Eigen::Matrix3Xd> across;
  for (const Path& pass : passes)
    across.push_back(across_in_motion(programmed, tangent, pass).deviation);
  Eigen::Index count = 0;
  for (const Eigen::Matrix3Xd& of_pass : across) count += of_pass.cols();
  Eigen::Matrix3Xd all(3, count);
  count = 0;
  for (const Eigen::Matrix3Xd& of_pass : across) {
    all.middleCols(count, of_pass.cols()) = of_pass;
    count += of_pass.cols();
  }
  return {path_accuracy(programmed, passes), path_errors(all), count};
}

// What the trend has no part in, and the next pass meets again: vibration, and what the steps of
// coarse coordinates hide, s / sqrt(12) per axis across the path and s / 2 at most.
void add_unseen(const std::vector<Path>& passes, MirrorFindings& findings) {
  const auto count = static_cast<double>(passes.size());
  const double noise = findings.result.deviation.noise * std::sqrt(count);
  double step = 0;
  for (const Path& pass : passes) step = std::max(step, step_that_hides(pass, noise).value_or(0));
  FormError& form = findings.form;
  form.ci95 = {std::max(0.0, form.ci95[0] - step / 2), form.ci95[1] + step / 2};
  const double mean_of_rms = std::sqrt(std::numbers::pi) / 2;
  findings.result.expected_after = std::hypot(
      findings.result.expected_after, mean_of_rms * std::hypot(form.faster, step / std::sqrt(6.0)));
}

void add_reversals(const Path& programmed, const KinematicChain& chain, MirrorFindings& findings) {
  const std::vector<JointName> joints = joint_names(chain);
  findings.reversals.emplace();
  for (const JointReversal& reversal :
       joint_reversals(programmed.time, joint_path(programmed, chain)))
    findings.reversals->push_back({reversal.time, joints[reversal.joint].column});
}

}  // namespace

double largest_of_noise(const MirrorFindings& findings) {
  const auto passes = static_cast<double>(findings.files.size());
  const auto samples = static_cast<double>(findings.accuracy.samples);
  // That of the mean of the passes is smaller.
  const double noise = findings.result.deviation.noise * std::sqrt(passes);
  return noise * std::sqrt(-2 * std::log(-std::expm1(-std::log(2) / samples)));
}

void describe_passes(MirrorFindings& findings, const Path& programmed,
                     const std::vector<Path>& passes, const std::vector<Path>& earlier,
                     const std::optional<Robot>& robot) {
  std::vector<Path> good;
  for (size_t p = 0; p < passes.size(); ++p)
    good.push_back(without(passes[p], findings.result.passes[p].bad));
  const std::vector<Path> in_time = all_registered(good, findings.result.passes);
  findings.accuracy = pass_accuracy(programmed, in_time);
  findings.form = with_frame(form_error(programmed, in_time), findings.result.frame);
  if (!earlier.empty()) {
    std::vector<Pass> clocks(earlier.size());
    const std::vector<ClockFit> fits = fit_clocks(programmed, earlier, findings.options.clock);
    for (size_t p = 0; p < earlier.size(); ++p) clocks[p].clock = fits[p];
    const std::vector<Path> earlier_in_time = all_registered(earlier, clocks);
    findings.before = pass_accuracy(programmed, earlier_in_time);
    findings.deviation_before = mean_deviation(programmed, earlier, clocks);
    findings.form_before =
        with_frame(form_error(programmed, earlier_in_time),
                   frame_error(programmed, *findings.deviation_before, fits.front()));
  }
  add_unseen(passes, findings);
  if (findings.options.executed)
    findings.from_executed =
        from_executed(findings.result.deviation, programmed, *findings.options.executed);
  const PathDeviation& deviation = findings.of_arm();
  findings.force =
      force_law(deviation, programmed, position_at(programmed, deviation.time),
                LowPass(findings.options.order, findings.result.cutoff, 1 / deviation.period));
  if (!robot) return;
  findings.robot = measured_on_predicted(deviation, programmed, *robot);
  add_reversals(programmed, robot->chain, findings);
}

}  // namespace armtrue
