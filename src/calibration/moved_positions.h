#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "armtrue/calibration/prediction.h"
#include "armtrue/observation/session_models.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {

/// Derivatives of the positions of all rows by the columns of a root. The own parameters of a
/// further session that has no root of its own count as those of the first.
class MovedPositions {
 public:
  /// `geometric`: as for ObservationModel. `root`: unknowns of the first session x columns.
  /// Keeps references to `campaign` and the roots, which must outlive it.
  MovedPositions(const Robot& robot, const Campaign& campaign, const std::vector<int>& geometric,
                 const Eigen::MatrixXd& root, const RootsOfSessions& of_sessions = kNoSessions);

  /// Calls add(result, rows, moved, residuals) for groups of rows, on the machine's threads, and
  /// joins the results of blocks in their order. `moved`: derivatives of the positions of these
  /// rows times the root, 3 x columns for each row, or 1 x columns for lengths.
  template <typename Result, typename Add, typename Join>
  void add_up(const Add& add, const Join& join) const {
    for_each_group([&](int g, const ObservationModel::At& at, const OwnRoot& root) {
      for_ordered_blocks<Result>(
          models_.model(g).rows(), kRowsPerBlock,
          [&](int begin, int end) {
            Result result{};
            for_rows(g, at, root, begin, end, [&](auto&&... rows) { add(result, rows...); });
            return result;
          },
          join);
    });
  }

  /// Calls take(row, moved, residual) for each row, one after the other.
  template <typename Take>
  void for_each_row(const Take& take) const {
    for_each_group([&](int g, const ObservationModel::At& at, const OwnRoot& root) {
      for_rows(g, at, root, 0, models_.model(g).rows(),
               [&](std::span<const int> rows, const auto& moved, const auto& residuals) {
                 for (int k = 0; k < std::ssize(rows); ++k) {
                   const auto first = k * axes_;
                   take(rows[k], moved.middleRows(first, axes_), residuals.segment(first, axes_));
                 }
               });
    });
  }

 private:
  inline static const RootsOfSessions kNoSessions;

  // The unknowns of a group that the root knows, and its rows of them.
  struct OwnRoot {
    std::vector<Eigen::Index> unknowns;
    Eigen::MatrixXd rows;
  };
  OwnRoot root_of(int group) const;

  template <typename Take>
  void for_each_group(const Take& take) const {
    for (int g = 0; g < models_.groups(); ++g) {
      const ObservationModel& model = models_.model(g);
      take(g, model.at(Eigen::VectorXd::Zero(model.unknowns())), root_of(g));
    }
  }

  // As many rows at once as a product of matrices takes together.
  template <typename Take>
  void for_rows(int group, const ObservationModel::At& at, const OwnRoot& root, int begin, int end,
                const Take& take) const {
    constexpr int kRowsOfProduct = 64;
    const ObservationModel& model = models_.model(group);
    const int size = model.row_size();
    Eigen::MatrixXd blocks(kRowsOfProduct * size, model.unknowns() + 1);
    Eigen::MatrixXd positions(kRowsOfProduct * axes_, std::ssize(root.unknowns)), moved;
    Eigen::VectorXd residuals(kRowsOfProduct * axes_);
    for (int first = begin; first < end; first += kRowsOfProduct) {
      const int rows = std::min(kRowsOfProduct, end - first);
      at.blocks(first, rows, blocks);
      for (int k = 0; k < rows; ++k) {
        const double sigma = model.row_sigma(first + k).position;
        positions.middleRows(k * axes_, axes_) =
            sigma * blocks.middleRows(k * size, axes_)(Eigen::all, root.unknowns);
        residuals.segment(k * axes_, axes_) =
            sigma * blocks.col(model.unknowns()).segment(k * size, axes_);
      }
      moved.noalias() = positions.topRows(rows * axes_) * root.rows;
      take(std::span(models_.rows_of(group)).subspan(first, rows), std::as_const(moved),
           residuals.head(rows * axes_));
    }
  }

  std::optional<Campaign> by_axis_;  // without covariances: the positions themselves are asked for
  SessionModels models_;
  const Eigen::MatrixXd& root_;
  const RootsOfSessions& of_sessions_;
  int axes_;
};

}  // namespace armtrue
