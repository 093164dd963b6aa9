#pragma once

#include <Eigen/Core>

namespace armtrue {

/// Products with cycles sin(n x), cos(n x) at many frequencies n, from those at few. With u = x -
/// m, |u| <= h, m the middle of the range of x, a cycle changes with its frequency no faster than
/// exp(i n h) does. So frequencies j D, D = pi / (1.5 h), as nodes tell those between:
///     exp(i n u) = sum_j w(n / D - j) e_j(u),    e_j(u) = exp(i j D u) / W(D u),
/// with the window w of Kaiser and Bessel, 16 nodes wide, and its Fourier transform W. The error
/// is below 1e-9. (This is a nonequispaced Fourier transform with few frequencies and no FFT;
/// Keiner, Kunis, Potts, ACM TOMS 36 (4), 2009.)
class CycleNodes {
 public:
  static constexpr int kHalfWidth = 8;  ///< s: of the window, in nodes

  /// Of a driver with values x in each context, for frequencies from `least` to `most` [1 / unit of
  /// x].
  CycleNodes(const Eigen::VectorXd& x, double least, double most);

  int count() const { return count_; }

  /// e_j(x - m) of `some` nodes from the `first` on at every x: their real parts, then the
  /// imaginary ones, x.size() x 2 some.
  Eigen::MatrixXd values(int first, int some) const;

  /// The nodes about a frequency: exp(i n x) = exp(i n m) sum_j weight_j e_(first + j)(x - m).
  struct Near {
    int first;
    Eigen::Vector<double, 2 * kHalfWidth> weights;
    double sine, cosine;  ///< of n m
  };
  Near near(double n) const;

  /// Products with sin(n x) and cos(n x), rows x 2, from those with all nodes, rows x 2 count().
  template <typename Scalar>
  static Eigen::MatrixX2<Scalar> at(const Near& near, const Eigen::MatrixX<Scalar>& of_nodes) {
    const auto weights = near.weights.template cast<Scalar>().eval();
    const auto sine = static_cast<Scalar>(near.sine), cosine = static_cast<Scalar>(near.cosine);
    const Eigen::Index imaginary = of_nodes.cols() / 2 + near.first;
    const Eigen::VectorX<Scalar> u_cosine =
        of_nodes.middleCols(near.first, weights.size()) * weights;
    const Eigen::VectorX<Scalar> u_sine = of_nodes.middleCols(imaginary, weights.size()) * weights;
    Eigen::MatrixX2<Scalar> products(of_nodes.rows(), 2);
    products << sine * u_cosine + cosine * u_sine, cosine * u_cosine - sine * u_sine;
    return products;
  }

 private:
  Eigen::ArrayXd u_, scale_;  // x - m; 1 / W(D u)
  double middle_ = 0, step_ = 0;
  int first_ = 0, count_ = 0;  // the first node is at the frequency first_ * step_
};

}  // namespace armtrue
