#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/observation/session_models.h"

namespace armtrue {

/// The readings that each row of a linear problem stands for. The model predicts the same for all
/// readings of a row (ObservationModel::rows_by_prediction), so their equations, whitened and times
/// the roots a_i of their weights, are a_i J x = r_i. With a^2 = sum a_i^2 and the shares s_i = a_i
/// / a, a rotation of these equations gives the equation of the row,
///     a J x = r,  r = sum s_i r_i,
/// and others without derivatives, whose sum of squares is that of the rests r_i - s_i r. So row
/// and rests are sufficient statistics: all sums over the readings of a pose stay the same.
struct Replicates {
  std::vector<int>
      first;  ///< row k has the readings reading[first[k]] to reading[first[k + 1] - 1]
  std::vector<int> reading;   ///< row of the campaign
  std::vector<double> share;  ///< s_i, in the order of `reading`
  Eigen::MatrixXd rest;       ///< row_size x readings, in the order of `reading`

  /// Each row one reading.
  static Replicates none(int rows, int row_size);
  int rows() const { return static_cast<int>(first.size()) - 1; }
  int readings() const { return static_cast<int>(reading.size()); }
  /// Whether a row stands for several readings.
  bool any() const { return readings() > rows(); }
};

/// The equations of a fit, whitened and weighted, those of replicates as one row.
struct RowsOfReplicates {
  Eigen::MatrixXd blocks;      ///< (rows * row_size) x (unknowns + 1), the readings last
  std::vector<double> length;  ///< a, of each row
  std::vector<int> nearest;    ///< the reading of each row that is nearest to the model
  Replicates replicates;
};

/// At x = 0. Replicates are of one pose. Rows are in the order of their first readings.
RowsOfReplicates rows_of_replicates(const SessionModels& models,
                                    const std::vector<double>& weights);

}  // namespace armtrue
