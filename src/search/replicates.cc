#include "search/replicates.h"

#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kRowsOfTask = 64;

// Readings with the same prediction, pose by pose, in the order of the first of each.
Replicates alike_readings(const SessionModels& models) {
  const Campaign& campaign = models.campaign();
  struct Place {
    int group, row;
  };
  std::vector<Place> places(static_cast<size_t>(models.rows()));
  for (int g = 0; g < models.groups(); ++g)
    for (int row = 0; row < models.model(g).rows(); ++row)
      places[static_cast<size_t>(models.rows_of(g)[row])] = {g, row};
  std::vector<std::map<std::vector<double>, size_t>> known(campaign.pose_ids.size());
  std::vector<std::vector<int>> rows;
  for (int reading = 0; reading < models.rows(); ++reading) {
    auto& of_pose = known[static_cast<size_t>(campaign.pose[reading])];
    const auto [group, own] = places[static_cast<size_t>(reading)];
    std::vector<double> key = models.model(group).prediction_key(own);
    key.push_back(group);
    const auto [row, is_new] = of_pose.try_emplace(std::move(key), rows.size());
    if (is_new) rows.emplace_back();
    rows[row->second].push_back(reading);
  }
  Replicates replicates{{0}, {}, {}, {}};
  for (const std::vector<int>& own : rows) {
    replicates.reading.insert(replicates.reading.end(), own.begin(), own.end());
    replicates.first.push_back(replicates.readings());
  }
  return replicates;
}

}  // namespace

Replicates Replicates::none(int rows, int row_size) {
  Replicates alone{
      std::vector<int>(static_cast<size_t>(rows) + 1), std::vector<int>(static_cast<size_t>(rows)),
      std::vector<double>(static_cast<size_t>(rows), 1.0), Eigen::MatrixXd::Zero(row_size, rows)};
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
  all.length.resize(static_cast<size_t>(rows));
  all.nearest.resize(static_cast<size_t>(rows));
  replicates.share.resize(replicates.reading.size());
  replicates.rest.resize(size, replicates.readings());
  const SessionModels::At at = models.at(Eigen::VectorXd::Zero(p));
  for_ordered_blocks<int>(
      rows, kRowsOfTask,
      [&](int begin, int end) {
        Eigen::MatrixXd block(size, p + 1);
        for (int row = begin; row < end; ++row) {
          const int from = replicates.first[row], to = replicates.first[row + 1];
          auto own = all.blocks.middleRows(row * size, size);
          double least = std::numeric_limits<double>::infinity(), squares = 0;
          for (int k = from; k < to; ++k) {
            const int reading = replicates.reading[k];
            at.block(reading, block);
            replicates.rest.col(k) = block.col(p);
            squares += weights[reading];
            if (!(block.col(p).squaredNorm() < least) && k > from) continue;
            least = block.col(p).squaredNorm();
            all.nearest[row] = reading;
            own = block;
          }
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
