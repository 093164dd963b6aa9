#include "search/replicates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kRowsOfTask = 64;

// Readings with the same prediction, in the order of the first of each.
Replicates alike_readings(const SessionModels& models) {
  std::vector<std::vector<int>> rows;
  for (int g = 0; g < models.groups(); ++g) {
    const GroupedRows& own = models.model(g).rows_by_prediction();
    for (int k = 0; k < own.groups(); ++k) {
      std::vector<int>& readings = rows.emplace_back();
      for (int row : own.rows(k)) readings.push_back(models.rows_of(g)[row]);
    }
  }
  std::ranges::sort(rows, {}, [](const std::vector<int>& readings) { return readings.front(); });
  Replicates replicates{{0}, {}, {}, {}};
  for (const std::vector<int>& own : rows) {
    replicates.reading.insert(replicates.reading.end(), own.begin(), own.end());
    replicates.first.push_back(replicates.readings());
  }
  return replicates;
}

}  // namespace

Replicates Replicates::none(int rows, int row_size) {
  Replicates alone{std::vector<int>(static_cast<size_t>(rows) + 1), std::vector<int>(rows),
                   std::vector<double>(static_cast<size_t>(rows), 1.0),
                   Eigen::MatrixXd::Zero(row_size, rows)};
  std::iota(alone.first.begin(), alone.first.end(), 0);
  std::iota(alone.reading.begin(), alone.reading.end(), 0);
  return alone;
}

RowsOfReplicates rows_of_replicates(const SessionModels& models,
                                    const std::vector<double>& weights) {
  RowsOfReplicates all{{}, {}, {}, alike_readings(models)};
  Replicates& replicates = all.replicates;
  const int rows = replicates.rows(), size = models.row_size(), p = models.unknowns();
  all.blocks.resize(rows * size, p + 1);
  all.length.resize(rows);
  all.nearest.resize(rows);
  replicates.share.resize(replicates.reading.size());
  replicates.rest.resize(size, replicates.readings());
  const SessionModels::At at = models.at(Eigen::VectorXd::Zero(p));
  for_ordered_blocks<int>(
      rows, kRowsOfTask,
      [&](int begin, int end) {
        for (int row = begin; row < end; ++row) {
          const int from = replicates.first[row], to = replicates.first[row + 1];
          auto own = all.blocks.middleRows(row * size, size);
          double least = std::numeric_limits<double>::infinity(), squares = 0;
          for (int k = from; k < to; ++k) {
            const int reading = replicates.reading[k];
            replicates.rest.col(k) = at.residual(reading);
            squares += weights[reading];
            const double norm = replicates.rest.col(k).squaredNorm();
            if (!(norm < least) && k > from) continue;
            least = norm;
            all.nearest[row] = reading;
          }
          at.block(all.nearest[row], own);
          const double length = all.length[row] = std::sqrt(squares);
          own *= length;
          own.col(p).setZero();
          for (int k = from; k < to; ++k) {
            const double root = std::sqrt(weights[replicates.reading[k]]);
            replicates.share[k] = squares > 0 ? root / length : 0;
            replicates.rest.col(k) *= root;
            own.col(p) += replicates.share[k] * replicates.rest.col(k);
          }
          for (int k = from; k < to; ++k)
            replicates.rest.col(k) -= replicates.share[k] * own.col(p);
        }
        return 0;
      },
      [](int) {});
  return all;
}

}  // namespace armtrue
