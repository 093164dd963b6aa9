#pragma once

#include <Eigen/Core>
#include <vector>

namespace armtrue {

/// Butterworth low-pass of order n, run forwards and backwards, so that it has no delay. Both runs
/// together attenuate by 3 dB at the cut-off f_c: a single run is designed for f_c (sqrt 2 -
/// 1)^(-1/(2 n)).
class LowPass {
 public:
  /// `order` of one pass, 1 to 12; `cutoff` and `sample_rate` [Hz]. Throws std::invalid_argument
  /// unless the cut-off of a single pass lies below 0.45 of the sample rate.
  LowPass(int order, double cutoff, double sample_rate);

  /// Filters channels (rows) of samples (columns) taken at `sample_rate`. Beyond each end the
  /// samples are continued by point reflection about the end of the straight line fitted to the
  /// first, or last, samples. So a slope continues, and the end does not depend on the noise of one
  /// sample.
  Eigen::MatrixXd operator()(const Eigen::MatrixXd& samples) const;

  /// Share of white noise power that passes: the mean over frequency of |H|^4, H of one run.
  double noise_share() const;

 private:
  struct Section {  // b0 + b1 z^-1 + b2 z^-2 over 1 + a1 z^-1 + a2 z^-2
    double b0, b1, b2, a1, a2;
  };
  void run(Eigen::Matrix3Xd& samples) const;

  std::vector<Section> sections_;
  double sample_rate_, cutoff_;
};

}  // namespace armtrue
