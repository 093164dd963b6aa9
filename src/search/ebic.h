#pragma once

namespace armtrue {

/// Fall of the extended BIC (Chen, Chen 2008, gamma 1) when a candidate with k independent columns
/// lowers the sum of squares of the residual from `before` by `gain`:
///     score  = fall - charge - 2 log_choices
///     fall   = -m ln(1 - gain / before),  m = `freedom`: independent equations of the residual
///     charge = k ln m.
/// Positive: the model with the candidate is better. -infinity if k is 0.
///
/// Coefficients that share one prior deviation (`is_shrunken`: six of base or tool, those of a
/// distortion, or a family) pay at most k (1 + ln(fall / k)), or the fall itself if fall <= k: the
/// local empirical Bayes charge of Liang et al., JASA 103, 2008. It assumes that the fall by chance
/// is k. If k is not small against m, that fall is -m ln(1 - k / m), so the fall is first divided
/// by the ratio of the two (Bartlett's correction). With k above 3 m / 4 there is no evidence:
/// -infinity. The reason for the smaller charge: one cause moves a few of the coefficients much and
/// the rest little. A curve on one parameter pays the full charge, because otherwise its
/// coefficients would follow blunders.
class EbicFall {
 public:
  EbicFall(bool is_shrunken, double log_choices, int k, double freedom);

  double operator()(double gain, double before) const;

 private:
  bool is_shrunken_, is_possible_;
  double log_choices_, count_, freedom_;
  double full_charge_;  // k ln m
  double by_chance_;    // -m ln(1 - k / m)
};

inline double ebic_fall(bool is_shrunken, double log_choices, int k, double gain, double before,
                        double freedom) {
  return EbicFall(is_shrunken, log_choices, k, freedom)(gain, before);
}

}  // namespace armtrue
