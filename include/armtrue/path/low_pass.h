#pragma once

#include <Eigen/Core>
#include <vector>

namespace armtrue {

/// Butterworth low-pass run forwards and backwards, so that nothing is delayed. The two passes
/// together have lost 3 dB at the cut-off: each alone is designed with a higher one.
class LowPass {
 public:
  /// `order` of one pass, 1 to 12; `cutoff` and `sample_rate` [Hz]. Throws std::invalid_argument
  /// unless the cut-off of a single pass lies below 0.45 of the sample rate.
  LowPass(int order, double cutoff, double sample_rate);

  /// Filters samples taken at the rate of the filter, channel by channel (rows); columns are
  /// samples. At both ends the samples are continued by their point reflection about the end of a
  /// straight line through the first, or last, samples, so that a slope goes on and the noise of
  /// one sample does not hold the end.
  Eigen::MatrixXd operator()(const Eigen::MatrixXd& samples) const;

  /// Share of white noise power that passes: the mean of the squared response of both passes.
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
