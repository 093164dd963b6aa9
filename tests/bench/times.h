#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace armtrue_bench {

// Google Benchmark's table, and afterwards what each function took: CPU time of a call, the least
// of its repetitions, because another process can only make it longer.
class Times : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type == Run::RT_Aggregate) continue;
      const double time = 1e9 * run.cpu_accumulated_time / static_cast<double>(run.iterations);
      double& least = nanoseconds_.try_emplace(run.run_name.function_name, time).first->second;
      least = std::min(least, time);
    }
  }
  double nanoseconds(const std::string& function) const { return nanoseconds_.at(function); }
  double ratio(const std::string& function, const std::string& to) const {
    return nanoseconds(function) / nanoseconds(to);
  }

 private:
  std::map<std::string, double> nanoseconds_;
};

}  // namespace armtrue_bench
