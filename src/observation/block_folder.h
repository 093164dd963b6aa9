#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "armtrue/observation/fold.h"

namespace armtrue {

inline constexpr int kRowsAtOnce = 32;  ///< evaluated at once

/// The columns that are not zero, in ascending order.
void find_nonzero(const Eigen::Ref<const Eigen::MatrixXd>& row, std::vector<int>& nonzero);

/// Folds the rows of some predictions.
class BlockFolder {
 public:
  enum class What { all, slopes };  ///< slopes: `products` is a column, what the last one is of all

  /// `kept`: null to take the derivatives at `at`. Slopes alone need them.
  BlockFolder(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
              FoldBy by, const KeptDerivatives* kept, What what = What::all);

  /// The fold of no rows.
  static Fold zero_fold(const ObservationModel& model, const ReadingLaw& law, FoldBy by);

  /// The fold of the predictions from `begin` on, without `end`. To be called once.
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
  // loss. Sets `bent_` and `bending_`: with J the weighted derivatives, bending J^T bent are the
  // slopes whose products add up to `bend`.
  template <typename Row>
  void weigh(int prediction, Row&& of_row);

  // The same of replicates, as one row. They have one J, so with weights w, W = sum w and
  // m = sum w r / W
  //     sum w [J r]^T [J r] = W [J m]^T [J m] + rest,
  // where the rest is the squares of the readings alone, and with c = 2 w^2 / ((nu + d) u)
  //     sum c (J^T r) (J^T r)^T = J^T (sum c r r^T) J.
  template <typename Row>
  void weigh_replicates(int prediction, Row&& of_row);

  // Sets `gathered_` to the columns of a prediction that are not zero and, the last of them, the
  // residual of a single row.
  void gather(int prediction, int place);

  // A row that few of many unknowns move, as where curves have many knots: only the products of
  // columns that are not zero.
  void add_gathered();

  // Columns that are not zero and stand side by side, as the knots of a curve do: from `column` on,
  // in `gathered_` from `place` on.
  struct Run {
    Eigen::Index place, count;
    int column;
  };

  void find_runs();

  // Adds the products of the j-th column of a row with those up to it.
  void add_products(const RowMajor& row, Eigen::Index j, Eigen::Ref<Eigen::VectorXd> out) const;

  // The compiler knows the number of rows, and that nothing of `row` changes: it takes four columns
  // at once.
  template <int kRows>
  void add_products_of(const RowMajor& row, Eigen::Index j, double* __restrict out) const;

  // Takes the rows into the sums.
  void empty();

  void empty_slopes();

  // The columns of the next slopes.
  Eigen::Block<Eigen::MatrixXd> room_for_slopes();

  // What replicates have beside their means stands in the corner of the products, and moves no
  // other number of a triangle.
  void take_rest();

  const ObservationModel::At& at_;
  const ObservationModel& model_;
  const ReadingLaw& law_;
  const KeptDerivatives* kept_;
  const What what_;
  const bool by_row_;     // each row by itself, without its zeros
  Eigen::MatrixXd rows_;  // weighted, but where each is taken by itself
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
