#include "armtrue/effects/sampling.h"

#include <cmath>
#include <numbers>

namespace armtrue {
namespace {

double halton(int index, int base) {
  double value = 0, place = 1;
  for (int i = index; i > 0; i /= base) {
    place /= base;
    value += place * (i % base);
  }
  return value;
}

}  // namespace

std::vector<JointVector> sample_joint_space(const KinematicChain& chain, int count) {
  static constexpr int kPrimes[kJoints] = {2, 3, 5, 7, 11, 13};
  std::vector<JointVector> samples(count);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < kJoints; ++j) {
      const auto [min, max] = travel(chain.links[j]);
      samples[i][j] = min + (max - min) * halton(i + 1, kPrimes[j]);
    }
  return samples;
}

}  // namespace armtrue
