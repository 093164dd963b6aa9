#include "armtrue/effects/sampling.h"

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
  static constexpr int kPrimes[kMaxJoints] = {2,  3,  5,  7,  11, 13, 17, 19,
                                              23, 29, 31, 37, 41, 43, 47, 53};
  const int joints = joint_count(chain);
  std::vector<JointVector> samples(count, JointVector(joints));
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < joints; ++j) {
      const auto [min, max] = travel(joint_link(chain, j));
      samples[i][j] = min + (max - min) * halton(i + 1, kPrimes[j]);
    }
  return samples;
}

}  // namespace armtrue
