#pragma once

#include <random>

namespace armtrue_oracle {

/// Uniform numbers for random chains and poses.
class Uniform {
 public:
  explicit Uniform(unsigned seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_()) + 0.5) / 4294967296.0;
  }

 private:
  std::mt19937 engine_;
};

}  // namespace armtrue_oracle
