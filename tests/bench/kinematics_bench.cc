// Forward kinematics with the full Jacobian (47 columns) against Ceres's automatic differentiation
// of the same chain, in one run.

#include <benchmark/benchmark.h>
#include <ceres/autodiff_cost_function.h>

#include <cstdio>
#include <vector>

#include "armtrue/effects/sampling.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "bench/times.h"
#include "support/autodiff_chain.h"

namespace {

using namespace armtrue;

struct Arm {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  std::vector<JointVector> poses = sample_joint_space(robot.chain, 256);
};

const Arm& arm() {
  static const Arm arm;
  return arm;
}

Eigen::Matrix4d matrix(const Pose& pose) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = pose.rotation;
  m.topRightCorner<3, 1>() = pose.translation;
  return m;
}

// Position and the three columns' worth of orientation that a left perturbation turns: as much as a
// pose residual needs.
struct ChainFunctor {
  const JointVector& q;
  const double* sign;
  const Eigen::Matrix4d &base, &tool;

  template <typename T>
  bool operator()(const T* p, T* out) const {
    const armtrue_oracle::Transform<T> end = armtrue_oracle::chain(p, q.data(), sign, base, tool);
    for (int i = 0; i < 3; ++i) out[i] = end(i, 3);
    out[3] = end(2, 1);
    out[4] = end(0, 2);
    out[5] = end(1, 0);
    return true;
  }
};

void analytic(benchmark::State& state) {
  const ChainEvaluator evaluator(arm().robot.chain);
  PoseJacobian jacobian;
  size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(evaluator.pose(arm().poses[k++ % arm().poses.size()], jacobian));
    benchmark::DoNotOptimize(jacobian);
  }
}

void forward_only(benchmark::State& state) {
  const ChainEvaluator evaluator(arm().robot.chain);
  size_t k = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(evaluator.pose(arm().poses[k++ % arm().poses.size()]));
}

void automatic(benchmark::State& state) {
  const KinematicChain& chain = arm().robot.chain;
  double parameters[kGeometricParameters] = {}, sign[kJoints];
  for (int j = 0; j < kLinks; ++j) {
    const Link& link = chain.links[j];
    const double values[] = {link.alpha, link.d, link.theta, link.r, link.beta};
    std::copy(values, values + 5, parameters + link_parameter(j, LinkParameter::alpha));
    if (j < kJoints) sign[j] = link.sign;
  }
  const Eigen::Matrix4d base = matrix(chain.base), tool = matrix(chain.tool);
  double residual[6], jacobian[6 * kGeometricParameters];
  const double* blocks[] = {parameters};
  double* jacobians[] = {jacobian};
  size_t k = 0;
  for (auto _ : state) {
    const JointVector& q = arm().poses[k++ % arm().poses.size()];
    const ceres::AutoDiffCostFunction<ChainFunctor, 6, kGeometricParameters> cost(
        new ChainFunctor{q, sign, base, tool});
    benchmark::DoNotOptimize(cost.Evaluate(blocks, residual, jacobians));
    benchmark::DoNotOptimize(jacobian);
  }
}

BENCHMARK(forward_only)->MinTime(0.5);
BENCHMARK(analytic)->MinTime(0.5);
BENCHMARK(automatic)->MinTime(0.5);

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  armtrue_bench::Times times;
  benchmark::RunSpecifiedBenchmarks(&times);
  std::printf("\nforward kinematics with 47 columns: %.0f ns; autodiff takes %.1f times as long\n",
              times.nanoseconds("analytic"), times.ratio("automatic", "analytic"));
}
