#pragma once

#include <Eigen/Core>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "search/replicates.h"
#include "search/scan.h"

namespace armtrue {

/// A part of the values of a scan at the rows of a fit. With s_i the shares of the replicates of a
/// row and v_i their values, the column of a parameter with derivatives a J at the row is a J m
/// there, with the mean m = sum s_i^2 v_i. Where the values of a row differ, as times do, the
/// column has a rest s_i a J (v_i - m) at each reading too, which no column of the model can
/// imitate.
class ValuesAtRows {
 public:
  /// Keeps references to all arguments.
  ValuesAtRows(const ScanValues& scan, const Replicates& replicates);

  /// Contexts x values; where values differ within rows, rows x values: their means.
  const Eigen::MatrixXf& values() const { return differ_ ? means_ : scan_.values; }
  int context_of_row(int row) const {
    return differ_ ? row : scan_.context_of_reading[replicates_.reading[replicates_.first[row]]];
  }
  /// Whether both have the same contexts, and each row the same in both.
  bool has_contexts_of(const ValuesAtRows& other) const;
  /// Whether the readings of a row have different values.
  bool differ() const { return differ_; }
  /// v_i - m of the k-th of the replicates, which is of `row`.
  double beside_mean(int row, int k, Eigen::Index value) const {
    return static_cast<double>(
               scan_.values(scan_.context_of_reading[replicates_.reading[k]], value)) -
           static_cast<double>(means_(row, value));
  }

  /// Where values differ: sum_i s_i v_i times the rest of reading i, (rows * row_size) x values.
  const Eigen::MatrixXf& pulls() const { return pulls_; }

  /// Where values differ: sum_i s_i^2 (u_i - mean u) (v_i - mean v) at each row, of a pair of
  /// values (the smaller number first) that find_spreads() was given.
  const Eigen::VectorXd& spread(int u, int v) const { return spreads_.at({u, v}); }
  void find_spreads(const std::set<std::pair<int, int>>& pairs);

 private:
  void set_means();

  const ScanValues& scan_;
  const Replicates& replicates_;
  bool differ_ = false;
  Eigen::MatrixXf means_, pulls_;
  std::map<std::pair<int, int>, Eigen::VectorXd> spreads_;
};

}  // namespace armtrue
