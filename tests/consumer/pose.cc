// Where the last frame of an arm stands, with armtrue::io alone: what it links reads files and
// computes poses, and loads no solver.
//
//     pose ROBOT      such as share/armtrue/robots/kr360-spindle.yaml
#include <cstdio>
#include <exception>

#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    const armtrue::KinematicChain chain = armtrue::read_robot(argv[1]).robot.chain;
    const armtrue::JointVector zero = armtrue::JointVector::Zero(armtrue::joint_count(chain));
    const Eigen::Vector3d place = armtrue::ChainEvaluator(chain).pose(zero).translation;
    std::printf("at zero: %.4f %.4f %.4f m\n", place.x(), place.y(), place.z());
    return 0;
  } catch (const std::exception& error) {  // names file, line and remedy
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
