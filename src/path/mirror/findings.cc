#include "armtrue/path/mirror/findings.h"

#include <algorithm>
#include <cmath>

#include "armtrue/path/low_pass.h"

namespace armtrue {
namespace {

// The passes in the clock of the program.
std::vector<Path> all_registered(const std::vector<Path>& passes,
                                 const std::vector<ClockFit>& clocks) {
  std::vector<Path> in_time;
  for (size_t p = 0; p < passes.size(); ++p) in_time.push_back(registered(passes[p], clocks[p]));
  return in_time;
}

}  // namespace

double MirrorFindings::form_rms(const PassAccuracy& of) const {
  const double passes = static_cast<double>(result.passes.size());
  const double rms = of.errors.whole.rms, noise = result.deviation.noise;
  return std::sqrt(std::max(0.0, rms * rms - 2 * passes * noise * noise));
}

void describe_passes(MirrorFindings& findings, const Path& programmed,
                     const std::vector<Path>& passes, const std::vector<Path>& earlier,
                     const std::optional<Robot>& robot) {
  std::vector<ClockFit> clocks, earlier_clocks;
  std::vector<Path> good;
  for (size_t p = 0; p < passes.size(); ++p) {
    clocks.push_back(findings.result.passes[p].clock);
    good.push_back(without(passes[p], findings.result.passes[p].bad));
  }
  for (const Path& pass : earlier)
    earlier_clocks.push_back(fit_clock(programmed, pass, findings.options.clock));
  findings.accuracy = pass_accuracy(programmed, all_registered(good, clocks));
  if (!earlier.empty())
    findings.before = pass_accuracy(programmed, all_registered(earlier, earlier_clocks));
  const PathDeviation& deviation = findings.result.deviation;
  findings.force =
      force_law(deviation, programmed, position_at(programmed, deviation.time),
                LowPass(findings.options.order, findings.result.cutoff, 1 / deviation.period));
  if (robot) findings.robot = measured_on_predicted(deviation, programmed, *robot);
}

}  // namespace armtrue
