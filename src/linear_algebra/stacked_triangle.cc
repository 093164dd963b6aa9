#include "linear_algebra/stacked_triangle.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace armtrue {
namespace {

// Reflections that are applied to the other columns together: each number of a column is then read
// and written once for all of them.
constexpr int kTogether = 4;
constexpr int kLanes = 4;

using Lanes = Eigen::Array<double, kLanes, 1>;
using Coefficients = std::array<double, kTogether>;
using Vectors = std::array<const double*, kTogether>;

Lanes lanes(const double* from) { return Eigen::Map<const Lanes>(from); }

// The products of `kCount` columns with the vectors, all of size m.
template <int kCount>
std::array<Coefficients, kCount> products(const Vectors& v, std::array<const double*, kCount> c,
                                          Eigen::Index m) {
  std::array<std::array<Lanes, kTogether>, kCount> sums;
  for (auto& of_column : sums)
    for (Lanes& sum : of_column) sum.setZero();
  Eigen::Index row = 0;
  for (; row + kLanes <= m; row += kLanes)
    for (int i = 0; i < kTogether; ++i) {
      const Lanes of_vector = lanes(v[i] + row);
      for (int k = 0; k < kCount; ++k) sums[k][i] += of_vector * lanes(c[k] + row);
    }
  std::array<Coefficients, kCount> result;
  for (int k = 0; k < kCount; ++k)
    for (int i = 0; i < kTogether; ++i) {
      double sum = sums[k][i].sum();
      for (Eigen::Index rest = row; rest < m; ++rest) sum += v[i][rest] * c[k][rest];
      result[k][i] = sum;
    }
  return result;
}

void subtract(const Vectors& v, const Coefficients& w, double* column, Eigen::Index m) {
  Eigen::Index row = 0;
  for (; row + kLanes <= m; row += kLanes) {
    Lanes sum = lanes(v[0] + row) * w[0];
    for (int i = 1; i < kTogether; ++i) sum += lanes(v[i] + row) * w[i];
    Eigen::Map<Lanes>(column + row) -= sum;
  }
  for (; row < m; ++row)
    for (int i = 0; i < kTogether; ++i) column[row] -= v[i][row] * w[i];
}

// Turns a column of the rows into the vector v of a reflection I - tau [1; v] [1; v]^T that takes
// it to zero; returns tau.
double reflect(double& corner, Eigen::Ref<Eigen::VectorXd> column) {
  const double squares = column.squaredNorm();
  if (squares == 0) return 0;
  const double norm = std::sqrt(corner * corner + squares);
  const double end = corner >= 0 ? -norm : norm;
  column *= 1 / (corner - end);
  const double tau = (end - corner) / end;
  corner = end;
  return tau;
}

}  // namespace

// Reflections H_1 .. H_k one after the other are I - V T V^T, with T upper triangular (Schreiber
// and Van Loan 1989).
void fold_rows(Eigen::MatrixXd& triangle, Eigen::Ref<Eigen::MatrixXd> rows) {
  const Eigen::Index n = triangle.cols(), m = rows.rows();
  const Eigen::VectorXd zeros = Eigen::VectorXd::Zero(n % kTogether == 0 ? 0 : m);
  for (Eigen::Index first = 0; first < n; first += kTogether) {
    const auto count = static_cast<int>(std::min<Eigen::Index>(kTogether, n - first));
    Eigen::Matrix<double, kTogether, kTogether> t;
    t.setZero();
    Vectors v;
    v.fill(zeros.data());
    for (int j = 0; j < count; ++j) {
      auto own = rows.col(first + j);
      const double tau = reflect(triangle(first + j, first + j), own);
      v[j] = own.data();
      for (Eigen::Index k = first + j + 1; k < first + count; ++k) {
        const double w = tau * (triangle(first + j, k) + own.dot(rows.col(k)));
        triangle(first + j, k) -= w;
        rows.col(k) -= w * own;
      }
      for (int i = 0; i < j; ++i) {
        double sum = 0;
        for (int k = i; k < j; ++k) sum += t(i, k) * rows.col(first + k).dot(own);
        t(i, j) = -tau * sum;
      }
      t(j, j) = tau;
    }
    const auto apply = [&](Eigen::Index k, Coefficients products_of_k) {
      for (int i = 0; i < count; ++i) products_of_k[i] += triangle(first + i, k);
      Coefficients w{};
      for (int j = 0; j < count; ++j)
        for (int i = 0; i <= j; ++i) w[j] += t(i, j) * products_of_k[i];
      for (int i = 0; i < count; ++i) triangle(first + i, k) -= w[i];
      subtract(v, w, rows.col(k).data(), m);
    };
    Eigen::Index k = first + count;
    for (; k + 2 <= n; k += 2) {
      const auto of_two = products<2>(v, {rows.col(k).data(), rows.col(k + 1).data()}, m);
      apply(k, of_two[0]);
      apply(k + 1, of_two[1]);
    }
    if (k < n) apply(k, products<1>(v, {rows.col(k).data()}, m)[0]);
  }
}

}  // namespace armtrue
