#include "armtrue/statistics/distributions.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/hypergeometric.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace armtrue {

namespace math = boost::math;
namespace policies = boost::math::policies;

namespace {

// With many degrees of freedom the gamma function of a density overflows where the probability
// beside it is 0 or 1 to the last digit; the infinity gives that value. A series that is broken off
// has its best value.
using Policy = policies::policy<policies::overflow_error<policies::ignore_error>,
                                policies::evaluation_error<policies::ignore_error>>;
using ChiSquared = math::chi_squared_distribution<double, Policy>;
using NonCentralChiSquared = math::non_central_chi_squared_distribution<double, Policy>;
using FisherF = math::fisher_f_distribution<double, Policy>;
using StudentT = math::students_t_distribution<double, Policy>;
using Binomial = math::binomial_distribution<double, Policy>;
using Hypergeometric = math::hypergeometric_distribution<double, Policy>;

}  // namespace

double chi_squared_above(double value, double dof) {
  if (value <= 0) return 1;  // rounding of a difference; Boost throws, also at infinity
  if (std::isinf(value)) return 0;
  return math::cdf(math::complement(ChiSquared(dof), value));
}

double chi_squared_quantile_above(double probability, double dof) {
  return math::quantile(math::complement(ChiSquared(dof), probability));
}

double non_central_chi_squared_above(double value, double dof, double non_centrality) {
  return math::cdf(math::complement(NonCentralChiSquared(dof, non_centrality), value));
}

double fisher_f_above(double value, double dof, double dof_of_denominator) {
  if (value <= 0) return 1;
  if (std::isinf(value)) return 0;
  return math::cdf(math::complement(FisherF(dof, dof_of_denominator), value));
}

double fisher_f_quantile(double probability, double dof, double dof_of_denominator) {
  return math::quantile(FisherF(dof, dof_of_denominator), probability);
}

double student_t_above(double value, double dof) {
  return math::cdf(math::complement(StudentT(dof), value));
}

double student_t_quantile(double probability, double dof) {
  return math::quantile(StudentT(dof), probability);
}

double normal_below(double value) { return math::cdf(math::normal(), value); }

double binomial_at_least(int count, int trials, double probability) {
  if (count <= 0) return 1;
  return math::cdf(math::complement(Binomial(trials, probability), count - 1));
}

double hypergeometric_at_least(int count, int drawn, int marked, int all) {
  if (count <= std::max(0, drawn + marked - all)) return 1;
  const Hypergeometric law(marked, drawn, all);
  const unsigned fewer = count - 1;
  return math::cdf(math::complement(law, fewer));
}

double student_t_975(double dof) { return student_t_quantile(0.975, std::max(1.0, dof)); }

}  // namespace armtrue
