#include "search/values_at_rows.h"

#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kValuesOfTask = 8;

}  // namespace

ValuesAtRows::ValuesAtRows(const ScanValues& scan, const Replicates& replicates)
    : scan_(scan), replicates_(replicates) {
  for (int row = 0; row < replicates.rows() && !differ_; ++row)
    for (int k = replicates.first[row] + 1; k < replicates.first[row + 1]; ++k)
      differ_ |= scan.context_of_reading[replicates.reading[k]] !=
                 scan.context_of_reading[replicates.reading[k - 1]];
  if (differ_) set_means();
}

bool ValuesAtRows::has_contexts_of(const ValuesAtRows& other) const {
  if (values().rows() != other.values().rows()) return false;
  for (int row = 0; row < replicates_.rows(); ++row)
    if (context_of_row(row) != other.context_of_row(row)) return false;
  return true;
}

void ValuesAtRows::set_means() {
  const Eigen::Index size = replicates_.rest.rows(), count = scan_.values.cols();
  means_.resize(replicates_.rows(), count);
  pulls_.resize(replicates_.rows() * size, count);
  for_ordered_blocks<int>(
      static_cast<int>(count), kValuesOfTask,
      [&](int begin, int end) {
        for (int value = begin; value < end; ++value) {
          const auto of_context = scan_.values.col(value);
          for (int row = 0; row < replicates_.rows(); ++row) {
            double mean = 0;
            Eigen::Matrix<double, 6, 1> pull = Eigen::Matrix<double, 6, 1>::Zero();
            for (int k = replicates_.first[row]; k < replicates_.first[row + 1]; ++k) {
              const double of_reading =
                  of_context[scan_.context_of_reading[replicates_.reading[k]]];
              const double weighted = replicates_.share[k] * of_reading;
              mean += replicates_.share[k] * weighted;
              pull.head(size) += weighted * replicates_.rest.col(k);
            }
            means_(row, value) = static_cast<float>(mean);
            pulls_.col(value).segment(row * size, size) = pull.head(size).cast<float>();
          }
        }
        return 0;
      },
      [](int) {});
}

void ValuesAtRows::find_spreads(const std::set<std::pair<int, int>>& pairs) {
  for (const auto& pair : pairs) spreads_[pair].resize(replicates_.rows());
  const std::vector<std::pair<int, int>> all(pairs.begin(), pairs.end());
  for_ordered_blocks<int>(
      static_cast<int>(all.size()), kValuesOfTask,
      [&](int begin, int end) {
        for (int pair = begin; pair < end; ++pair) {
          const auto [u, v] = all[pair];
          Eigen::VectorXd& spread = spreads_.at({u, v});
          for (int row = 0; row < replicates_.rows(); ++row) {
            double sum = 0;
            for (int k = replicates_.first[row]; k < replicates_.first[row + 1]; ++k)
              sum += replicates_.share[k] * replicates_.share[k] * beside_mean(row, k, u) *
                     beside_mean(row, k, v);
            spread[row] = sum;
          }
        }
        return 0;
      },
      [](int) {});
}

}  // namespace armtrue
