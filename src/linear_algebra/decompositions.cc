#include "linear_algebra/decompositions.h"

namespace Eigen {

ARMTRUE_DECOMPOSITIONS(template)

}  // namespace Eigen

namespace armtrue {

Eigen::MatrixXd product(const Reflections& q, const Eigen::MatrixXd& columns) {
  return q * columns;
}

Eigen::VectorXd product(const Reflections& q, const Eigen::VectorXd& column) { return q * column; }

Eigen::MatrixXd first_columns(const Reflections& q, Eigen::Index count) {
  return q * Eigen::MatrixXd::Identity(q.rows(), count);
}

Eigen::MatrixXd identity(Eigen::Index size) { return Eigen::MatrixXd::Identity(size, size); }

}  // namespace armtrue
