#include "armtrue/path/mirror/findings.h"

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
  const std::vector<Path> in_time = all_registered(good, clocks);
  findings.accuracy = pass_accuracy(programmed, in_time);
  findings.form = form_error(programmed, in_time);
  if (!earlier.empty()) {
    const std::vector<Path> earlier_in_time = all_registered(earlier, earlier_clocks);
    findings.before = pass_accuracy(programmed, earlier_in_time);
    findings.form_before = form_error(programmed, earlier_in_time);
  }
  const PathDeviation& deviation = findings.result.deviation;
  findings.force =
      force_law(deviation, programmed, position_at(programmed, deviation.time),
                LowPass(findings.options.order, findings.result.cutoff, 1 / deviation.period));
  if (robot) findings.robot = measured_on_predicted(deviation, programmed, *robot);
}

}  // namespace armtrue
