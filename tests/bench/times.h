#pragma once

#include <benchmark/benchmark.h>

#include <map>
#include <string>
#include <vector>

namespace armtrue_bench {

// Google Benchmark's table, and afterwards what each function took.
class Times : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs)
      nanoseconds_[run.run_name.function_name] =
          1e9 * run.cpu_accumulated_time / static_cast<double>(run.iterations);
  }
  double nanoseconds(const std::string& function) const { return nanoseconds_.at(function); }
  double ratio(const std::string& function, const std::string& to) const {
    return nanoseconds(function) / nanoseconds(to);
  }

 private:
  std::map<std::string, double> nanoseconds_;
};

}  // namespace armtrue_bench
