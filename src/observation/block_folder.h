#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "armtrue/observation/fold.h"

namespace armtrue {

inline constexpr int kRowsAtOnce = 32;  ///< rows that the model evaluates in one call

/// The columns that are not zero, in ascending order.
void find_nonzero(const Eigen::Ref<const Eigen::MatrixXd>& row, std::vector<int>& nonzero);

/// Folds the rows of some predictions.
class BlockFolder {
 public:
  /// slopes: only the last column of Fold::products, J^T W r and r^T W r, and the loss.
  enum class What { all, slopes };

  /// `kept`: null to take the derivatives at `at`. What::slopes needs `kept`.
  BlockFolder(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
              FoldBy by, const KeptDerivatives* kept, What what = What::all);

  /// The fold of no rows.
  static Fold zero_fold(const ObservationModel& model, const ReadingLaw& law, FoldBy by);

  /// The fold of the predictions begin <= k < end. To be called once.
  Fold of(int begin, int end);

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

  // Keeps the columns of `rows_` from falling on the same lines of the cache.
  static constexpr int kPadding = 8;

  Eigen::Block<Eigen::MatrixXd> own_rows(int place, int count) {
    return rows_.middleRows(place * model_.row_size(), count * model_.row_size());
  }

  void add(int prediction, int place);

  bool has_several_rows(int prediction) const {
    return model_.rows_by_prediction().rows(prediction).size() > 1;
  }

  // Multiplies the derivatives and the residual of a row by the root of its weight, and adds its
  // loss. Sets `bent_` and `bending_`: with J the weighted derivatives and a = bending J^T bent,
  // the row adds a a^T to Fold::bend.
  template <typename Row>
  void weigh(int prediction, Row&& of_row);

  // The same of replicates, as one row. They have one J, so with weights w, W = sum w and
  // m = sum w r / W
  //     sum w [J r]^T [J r] = W [J m]^T [J m] + rest,
  // where the rest is a number in the corner of r alone, and with c = 2 w^2 / ((nu + d) u)
  //     sum c (J^T r) (J^T r)^T = J^T (sum c r r^T) J.
  template <typename Row>
  void weigh_replicates(int prediction, Row&& of_row);

  // Sets `gathered_` to the columns of a prediction that are not zero, then the residual. Of
  // replicates weigh() sets the residual.
  void gather(int prediction, int place);

  // Adds the products of the columns of `gathered_` alone: few of many unknowns move a row.
  void add_gathered();

  // Neighbouring columns that are not zero, as those of one spline: from `column` on among the
  // unknowns, from `place` on in `gathered_`.
  struct Run {
    Eigen::Index place, count;
    int column;
  };

  void find_runs();

  // Adds the products of the j-th column of a row with those up to it.
  void add_products(const RowMajor& row, Eigen::Index j, Eigen::Ref<Eigen::VectorXd> out) const;

  // The number of rows is known when this is compiled, and `out` does not overlap `row`: the
  // compiler vectorises it.
  template <int kRows>
  void add_products_of(const RowMajor& row, Eigen::Index j, double* __restrict out) const;

  // Adds the rows that wait in `rows_` to `folded_`.
  void empty();

  void empty_slopes();

  // Columns of `slopes_` for the next row.
  Eigen::Block<Eigen::MatrixXd> room_for_slopes();

  // Adds `rest_` to r^T W r, the corner of the products. In a triangle it changes the corner alone.
  void take_rest();

  const ObservationModel::At& at_;
  const ObservationModel& model_;
  const ReadingLaw& law_;
  const KeptDerivatives* kept_;
  const What what_;
  const bool by_row_;     // each row by itself, without its zeros
  Eigen::MatrixXd rows_;  // weighted unless by_row_
  std::array<Eigen::Matrix<double, 6, 1>, kRowsAtOnce> residuals_;
  int filled_ = 0;
  Fold folded_;
  double rest_ = 0;         // see weigh_replicates()
  Eigen::MatrixXd slopes_;  // side by side; their products add up to `bend`
  Eigen::Index filled_slopes_ = 0;
  SmallMatrix bent_;  // see weigh()
  double bending_ = 0;
  std::vector<int> nonzero_;
  std::vector<Run> runs_;
  RowMajor gathered_, slope_;
};

}  // namespace armtrue
