#pragma once

namespace armtrue {

/// Tail probabilities and quantiles of the laws that tests use. They wrap Boost.Math, whose headers
/// take seconds to compile. Degrees of freedom are above zero and need not be whole.

double chi_squared_above(double value, double dof);  ///< P(X > value)
double chi_squared_quantile_above(double probability,
                                  double dof);  ///< x with P(X > x) = probability
double non_central_chi_squared_above(double value, double dof, double non_centrality);
double fisher_f_above(double value, double dof, double dof_of_denominator);
double fisher_f_quantile(double probability, double dof,
                         double dof_of_denominator);  ///< x with P(X <= x) = probability
double student_t_above(double value, double dof);
double student_t_quantile(double probability, double dof);  ///< x with P(X <= x) = probability
double normal_below(double value);
/// Median of the norm of one and of three independent N(0, 1) numbers.
inline constexpr double kMedianOfNorm1 = 0.6745, kMedianOfNorm3 = 1.538;
/// P(X >= count) of a binomial X.
double binomial_at_least(int count, int trials, double probability);
/// P(X >= count) of the number X of marked ones among `drawn` of `all`, `marked` of them marked.
double hypergeometric_at_least(int count, int drawn, int marked, int all);

/// Half width of a 95 % interval in standard deviations: the 0.975 quantile of Student's t. Fewer
/// than one degree of freedom count as one.
double student_t_975(double dof);

}  // namespace armtrue
