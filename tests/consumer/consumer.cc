// Uses an installed armtrue as another project would.
#include <cstdio>

#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const armtrue::Robot robot = armtrue::read_robot(argv[1]).robot;
  const armtrue::ChainEvaluator chain(robot.chain);
  armtrue::JointVector q = armtrue::JointVector::Zero(6);
  std::printf("%.3f\n", chain.pose(q).translation.norm());
  return 0;
}
