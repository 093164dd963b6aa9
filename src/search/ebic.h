#pragma once

namespace armtrue {

/// Fall of the extended BIC (Chen, Chen 2008, gamma 1) when a candidate with k independent columns
/// lowers the sum of squares of the residual from `before` by `gain`:
///     score  = fall - charge - 2 log_choices
///     fall   = -m ln(1 - gain / before),  m = `freedom`: independent equations of the residual
///     charge = k ln m.
/// Positive: the model with the candidate is better. -infinity if k is 0.
///
/// Coefficients that share one prior deviation (`is_shrunken`: six of base or tool, or a family)
/// pay at most k (1 + ln(fall / k)), or the fall itself if fall <= k: the local empirical Bayes
/// charge of Liang et al., JASA 103, 2008. One cause moves a few of them much and the rest little,
/// so k full charges are too many. A curve on one parameter pays the full charge, because its
/// coefficients follow blunders otherwise.
double ebic_fall(bool is_shrunken, double log_choices, int k, double gain, double before,
                 double freedom);

}  // namespace armtrue
