#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace armtrue {

/// Products of many vectors with cycles sin(n x), cos(n x) at many frequencies n, interpolated from
/// few frequencies (nonuniform Fourier transform). With u = x - m, |u| <= h, m the middle of the
/// range of x, a cycle changes with its frequency no faster than exp(i n h). So nodes at the
/// frequencies j D, D = pi / (1.5 h), give those between:
///     exp(i n u) = sum_j w(n / D - j) e_j(u),    e_j(u) = exp(i j D u) / W(D u),
/// with the window w of Kaiser and Bessel, 16 nodes wide, and its Fourier transform W. The error is
/// below 1e-9. (The Fourier transform of values at uneven places; Keiner, Kunis, Potts, ACM TOMS 36
/// (4), 2009.)
class CycleNodes {
 public:
  static constexpr int kHalfWidth = 8;  ///< of the window, in nodes

  /// Of a driver that has the values x [rad or m], not all the same, for frequencies from `least`
  /// to `most` [1/rad or 1/m].
  CycleNodes(const Eigen::VectorXd& x, double least, double most);

  int count() const { return count_; }

  /// Of vectors (rows x x.size()) with all nodes: rows x 2 count(). First those with the real parts
  /// of e_j, then those with the imaginary ones.
  template <typename Scalar>
  Eigen::MatrixX<Scalar> products(const Eigen::MatrixX<Scalar>& vectors) const {
    constexpr int kAtOnce = 128;  // bounds the memory
    Eigen::MatrixX<Scalar> products(vectors.rows(), 2 * count_);
    for (int first = 0; first < count_; first += kAtOnce) {
      const int some = std::min(kAtOnce, count_ - first);
      const Eigen::MatrixX<Scalar> own = vectors * values(first, some).template cast<Scalar>();
      products.middleCols(first, some) = own.leftCols(some);
      products.middleCols(count_ + first, some) = own.rightCols(some);
    }
    return products;
  }

  /// The nodes about a frequency: exp(i n x) = exp(i n m) sum_k weight_k e_(first + k)(x - m).
  struct Near {
    int first;
    Eigen::Vector<double, 2 * kHalfWidth> weights;
    double sine, cosine;  ///< of n m
  };
  Near near(double n) const;

  /// Products with sin(n x) and cos(n x), rows x 2, from those with the nodes.
  template <typename Scalar>
  static Eigen::MatrixX2<Scalar> at(const Near& near, const Eigen::MatrixX<Scalar>& of_nodes) {
    const auto weights = near.weights.template cast<Scalar>().eval();
    const auto sine = static_cast<Scalar>(near.sine), cosine = static_cast<Scalar>(near.cosine);
    const Eigen::Index imaginary = of_nodes.cols() / 2 + near.first;
    const Eigen::VectorX<Scalar> with_cosine =
        of_nodes.middleCols(near.first, weights.size()) * weights;
    const Eigen::VectorX<Scalar> with_sine =
        of_nodes.middleCols(imaginary, weights.size()) * weights;
    Eigen::MatrixX2<Scalar> products(of_nodes.rows(), 2);
    products << sine * with_cosine + cosine * with_sine, cosine * with_cosine - sine * with_sine;
    return products;
  }

 private:
  Eigen::MatrixXd values(int first, int some) const;

  Eigen::ArrayXd u_, scale_;  // x - m; 1 / W(D u)
  double middle_ = 0, step_ = 0;
  int first_ = 0, count_ = 0;  // the first node is at the frequency first_ * step_
};

}  // namespace armtrue
