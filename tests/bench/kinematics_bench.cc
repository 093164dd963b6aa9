// Forward kinematics with the full Jacobian (47 columns) against automatic differentiation, central
// differences and the Jacobians of KDL and Pinocchio, one pose after another and several at once;
// inverse kinematics and corrected targets against KDL's inverse kinematics; all in one run. Before
// they are timed, all are compared: their columns and joint angles are the same numbers.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_nr.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#ifdef ARMTRUE_HAS_PINOCCHIO
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <pinocchio/multibody.hpp>
#endif

#include "armtrue/compensation/compensation.h"
#include "armtrue/effects/sampling.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/inverse.h"
#include "bench/times.h"
#include "kinematics/economical_jet_chain.h"
#include "kinematics/kdl_arm.h"
#include "kinematics/six_axes.h"

namespace {

using namespace armtrue;

using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic>;

const KinematicChain& chain() {
  static const KinematicChain chain =
      read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot.chain;
  return chain;
}

const std::vector<JointVector>& poses() {
  static const std::vector<JointVector> poses = sample_joint_space(chain(), 256);
  return poses;
}

constexpr std::array<int, kGeometricParameters> all_parameters() {
  std::array<int, kGeometricParameters> all{};
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// What is commonly identified of this arm: alpha, d, theta and r of the seven links, and beta where
// an axis is parallel to the one before (A3).
constexpr int kCommonParameters = 29;
constexpr std::array<int, kCommonParameters> common_parameters() {
  std::array<int, kCommonParameters> common{};
  int size = 0;
  for (int j = 0; j < kLinks; ++j)
    for (int k = 0; k < 5; ++k)
      if (k < 4 || j == 2) common[size++] = kFirstLinkParameter + 5 * j + k;
  return common;
}

constexpr auto kAll = all_parameters();
constexpr auto kCommon = common_parameters();

// Each opponent is a function of the joint angles that leaves its Jacobian behind.

class CentralDifferences {
 public:
  const PoseJacobian& operator()(const JointVector& q) {
    constexpr double kStep = 1e-6;
    const Pose here = evaluator_.pose(q);
    for (int k = 0; k < kGeometricParameters; ++k) {
      offsets_[k] = kStep;
      const Pose plus = evaluator_.pose(q, offsets_);
      offsets_[k] = -kStep;
      const Pose minus = evaluator_.pose(q, offsets_);
      offsets_[k] = 0;
      jacobian_.col(k).head<3>() = (plus.translation - minus.translation) / (2 * kStep);
      const Eigen::Matrix3d d = (plus.rotation - minus.rotation) / (2 * kStep);
      for (int i = 0; i < 3; ++i)
        jacobian_(3 + i, k) = d.row((i + 2) % 3).dot(here.rotation.row((i + 1) % 3));
    }
    return jacobian_;
  }

 private:
  ChainEvaluator evaluator_{chain()};
  ParameterOffsets offsets_ = ParameterOffsets::Zero(kGeometricParameters);
  PoseJacobian jacobian_{6, kGeometricParameters};
};

template <int N>
class Jets {
 public:
  explicit Jets(std::span<const int, N> free) : jets_(chain(), free) {}
  const auto& operator()(const JointVector& q) {
    benchmark::DoNotOptimize(jets_.pose(q, jacobian_));
    return jacobian_;
  }

 private:
  EconomicalJetChain<N> jets_;
  typename EconomicalJetChain<N>::Jacobian jacobian_;
};

class Kdl {
 public:
  const auto& operator()(const JointVector& q) {
    angles_.data = q;
    solver_.JntToJac(angles_, jacobian_);
    return jacobian_.data;
  }

 private:
  KDL::Chain arm_ = kdl_arm(chain());
  KDL::ChainJntToJacSolver solver_{arm_};
  KDL::JntArray angles_{kJoints};
  KDL::Jacobian jacobian_{kJoints};
};

#ifdef ARMTRUE_HAS_PINOCCHIO
// The kinematic regressor: six columns for the placement of each driven joint, a twist in its axes
// before it turns.
class Pinocchio {
 public:
  static constexpr int kPlacements = 6 * kJoints;

  Pinocchio() {
    Pose before = chain().base;
    for (int j = 0; j < kJoints; ++j) {
      before = before * placement(chain().links[j]);
      model_.addJoint(j, pinocchio::JointModelRZ(), {before.rotation, before.translation},
                      "A" + std::to_string(j + 1));
      before = {};
    }
    const Pose end = placement(chain().links[kJoints]) * chain().tool;
    end_ = {end.rotation, end.translation};
    data_ = pinocchio::Data(model_);
  }

  const Columns& operator()(const JointVector& q) {
    for (int j = 0; j < kJoints; ++j) angles_[j] = chain().links[j].sign * q[j];
    pinocchio::forwardKinematics(model_, data_, angles_);
    pinocchio::computeJointKinematicRegressor(model_, data_, kJoints,
                                              pinocchio::LOCAL_WORLD_ALIGNED, end_, regressor_);
    return regressor_;
  }

 private:
  static Pose placement(const Link& link) {
    KinematicChain one;
    one.links = {link};
    return ChainEvaluator(one).pose(JointVector::Zero(joint_count(one)));
  }

  pinocchio::Model model_;
  pinocchio::Data data_;
  pinocchio::SE3 end_;
  Eigen::VectorXd angles_{kJoints};
  Columns regressor_{6, kPlacements};
};

// The columns of armtrue's parameters of the driven links that the twists of the placements give:
// rows 0-2 of a twist are the translation of the placed frame, rows 3-5 its rotation, in its axes.
Columns of_link_parameters(const Columns& placements) {
  Columns result(6, 5 * kJoints);
  for (int j = 0; j < kJoints; ++j) {
    const Link& link = chain().links[j];
    const double c = std::cos(link.theta), s = std::sin(link.theta);
    const double ca = std::cos(link.alpha), sa = std::sin(link.alpha);
    const auto moved = placements.middleCols<3>(6 * j),
               turned = placements.middleCols<3>(6 * j + 3);
    // The axes before theta, seen from the axes after it.
    const Eigen::Vector3d x(c, -s, 0), y(s, c, 0), z(0, 0, 1), lever = link.d * x + link.r * z;
    const Eigen::Vector3d old_y = ca * y - sa * z;
    const auto rotation = [&](const Eigen::Vector3d& axis) {
      return (moved * axis.cross(lever) + turned * axis).eval();
    };
    result.col(5 * j + 0) = rotation(x);
    result.col(5 * j + 1) = moved * x;
    result.col(5 * j + 2) = turned * z;
    result.col(5 * j + 3) = moved * z;
    result.col(5 * j + 4) = rotation(old_y);
  }
  return result;
}
#endif

template <typename Opponent>
void measure(benchmark::State& state, Opponent opponent) {
  size_t k = 0;
  for (auto _ : state) {
    const auto& jacobian = opponent(poses()[k++ % poses().size()]);
    benchmark::DoNotOptimize(jacobian.data());
    benchmark::ClobberMemory();
  }
}

void forward_only(benchmark::State& state) {
  const ChainEvaluator evaluator(chain());
  size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(evaluator.pose(poses()[k++ % poses().size()]));
}

void armtrue_47(benchmark::State& state) {
  const ChainEvaluator evaluator(chain());
  PoseJacobian jacobian;
  measure(state, [&](const JointVector& q) -> const PoseJacobian& {
    benchmark::DoNotOptimize(evaluator.pose(q, jacobian));
    return jacobian;
  });
}

void central_differences_47(benchmark::State& state) { measure(state, CentralDifferences{}); }
void ceres_jets_47(benchmark::State& state) { measure(state, Jets<kGeometricParameters>(kAll)); }
void ceres_jets_29(benchmark::State& state) { measure(state, Jets<kCommonParameters>(kCommon)); }
void kdl_joints_6(benchmark::State& state) {
  Kdl kdl;  // its solver keeps a reference to its chain
  measure(state, std::ref(kdl));
}
#ifdef ARMTRUE_HAS_PINOCCHIO
void pinocchio_placements_36(benchmark::State& state) {
  Pinocchio pinocchio;
  measure(state, std::ref(pinocchio));
}
#endif

// As many poses in a call as a fold takes; the time of each is printed.
constexpr size_t kPosesInCall = 8;

void forward_only_batched(benchmark::State& state) {
  const ChainEvaluator evaluator(chain());
  std::vector<Pose> reached(kPosesInCall);
  size_t k = 0;
  for (auto _ : state) {
    evaluator.poses(std::span(poses()).subspan(k % poses().size(), kPosesInCall), {}, reached);
    benchmark::DoNotOptimize(reached.data());
    benchmark::ClobberMemory();
    k += kPosesInCall;
  }
}

void armtrue_47_batched(benchmark::State& state) {
  const ChainEvaluator evaluator(chain());
  std::vector<Pose> reached(kPosesInCall);
  std::vector<LaneJacobians> jacobians(kPosesInCall / LaneJacobians::kCount);
  size_t k = 0;
  for (auto _ : state) {
    evaluator.poses(std::span(poses()).subspan(k % poses().size(), kPosesInCall), {}, reached,
                    jacobians);
    benchmark::DoNotOptimize(jacobians.data());
    benchmark::ClobberMemory();
    k += kPosesInCall;
  }
}

// An arm as a calibration finds it, every length and angle a little off. KDL knows no beta.
const Robot& controller() {
  static const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  return robot;
}
const Robot& identified() {
  static const Robot robot = [] {
    Robot moved = controller();
    for (int k = kFirstLinkParameter; k < kFirstToolParameter; ++k)
      if (kind_of_parameter(k) != LinkParameter::beta)
        move_parameter(moved.chain, k, 5e-4 * std::sin(3.0 * k));
    return moved;
  }();
  return robot;
}

// Where the controller's model has each posture, R_0 from R_7, and the start of every solver.
const std::vector<Pose>& wanted() {
  static const std::vector<Pose> wanted = [] {
    KinematicChain arm = controller().chain;
    arm.base = arm.tool = Pose{};
    std::vector<Pose> list;
    for (const JointVector& q : poses()) list.push_back(ChainEvaluator(arm).pose(q));
    return list;
  }();
  return wanted;
}

KinematicChain identified_links() {
  KinematicChain arm = identified().chain;
  arm.base = arm.tool = Pose{};
  return arm;
}

class ArmtrueInverse {
 public:
  JointVector operator()(size_t k) const {
    return inverse_kinematics(arm_, wanted()[k], poses()[k]).q;
  }

 private:
  KinematicChain arm_ = identified_links();
};

// To the same 1e-10 as armtrue's. KDL's other solver, ChainIkSolverPos_LMA of KDL 1.5, writes
// behind its arrays where a chain ends with a fixed segment.
class KdlInverse {
 public:
  JointVector operator()(size_t k) {
    start_.data = poses()[k];
    newton_.CartToJnt(start_, kdl_frame(wanted()[k]), found_);
    return found_.data;
  }

 private:
  KDL::Chain arm_ = kdl_arm(identified_links());
  KDL::ChainFkSolverPos_recursive forward_{arm_};
  KDL::ChainIkSolverVel_pinv velocity_{arm_};
  KDL::ChainIkSolverPos_NR newton_{arm_, forward_, velocity_, 100, 1e-10};
  KDL::JntArray start_{kJoints}, found_{kJoints};
};

std::vector<CorrectedTarget> corrected_targets() {
  Program program;
  program.visits.source = "benchmark";
  for (const JointVector& q : poses()) {
    const int number = program.rows();
    program.visits.q.push_back(q);
    program.visits.pose.push_back(number);
    program.visits.pose_ids.push_back(std::to_string(number));
    program.visits.line.push_back(number + 2);
  }
  CompensationOptions options;
  options.max_correction = 1;  // none is left as programmed
  return compensate(identified(), controller(), program, options);
}

template <typename Inverse>
void invert(benchmark::State& state, Inverse& inverse) {
  size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(inverse(k++ % poses().size()));
}
void armtrue_inverse(benchmark::State& state) {
  ArmtrueInverse inverse;
  invert(state, inverse);
}
void kdl_inverse(benchmark::State& state) {
  KdlInverse inverse;
  invert(state, inverse);
}
void compensate_targets(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(corrected_targets().data());
}

// Prints on how many postures a solver misses the pose by more than 1 um, and on how many it
// reaches it with other joint angles than armtrue's.
template <typename Inverse>
void compare_inverse(const char* name, Inverse&& inverse) {
  const ArmtrueInverse armtrue_own;
  const ChainEvaluator identified_arm(identified_links());
  int missed = 0, other = 0;
  for (size_t k = 0; k < poses().size(); ++k) {
    const JointVector q = inverse(k);
    if (!((identified_arm.pose(q).translation - wanted()[k].translation).norm() < 1e-6))
      ++missed;
    else if (!((q - armtrue_own(k)).cwiseAbs().maxCoeff() < 1e-4))
      ++other;
  }
  std::printf("%s: misses the pose on %d, takes other joint angles on %d of %zu postures\n", name,
              missed, other, poses().size());
}

void compare_inverses() {
  compare_inverse("kdl_inverse", KdlInverse());
  const std::vector<CorrectedTarget> targets = corrected_targets();
  compare_inverse("compensate_targets", [&](size_t k) { return targets[k].q; });
}

// Stops unless the columns are armtrue's.
void compare(const char* name, const Columns& expected, const Columns& own, double tolerance) {
  const double apart = (expected - own).cwiseAbs().maxCoeff();
  if (apart <= tolerance) return;
  std::fprintf(stderr, "%s differs from armtrue's Jacobian by %.2g, more than %.2g\n", name, apart,
               tolerance);
  std::exit(1);
}

template <size_t N>
Columns selected(const PoseJacobian& jacobian, const std::array<int, N>& columns) {
  return jacobian(Eigen::all, columns);
}

void compare_all() {
  const ChainEvaluator evaluator(chain());
  CentralDifferences differences;
  Jets<kGeometricParameters> jets(kAll);
  Jets<kCommonParameters> common_jets(kCommon);
  Kdl kdl;
#ifdef ARMTRUE_HAS_PINOCCHIO
  Pinocchio pinocchio;
#endif
  for (const JointVector& q : poses()) {
    PoseJacobian own;
    evaluator.pose(q, own);
    compare("ceres_jets_47", own, jets(q), 1e-9);
    compare("ceres_jets_29", selected(own, kCommon), common_jets(q), 1e-9);
    compare("central_differences_47", own, differences(q), 1e-6);
    Pose reached;
    LaneJacobians batched;
    evaluator.poses(std::span(&q, 1), {}, std::span(&reached, 1), std::span(&batched, 1));
    compare("armtrue_47_batched", own, batched[0], 1e-12);
    Columns joints(6, kJoints);
    for (int j = 0; j < kJoints; ++j)
      joints.col(j) = chain().links[j].sign * own.col(link_parameter(j, LinkParameter::theta));
    compare("kdl_joints_6", joints, kdl(q), 1e-9);
#ifdef ARMTRUE_HAS_PINOCCHIO
    compare("pinocchio_placements_36", own.middleCols<5 * kJoints>(kFirstLinkParameter),
            of_link_parameters(pinocchio(q)), 1e-9);
#endif
  }
}

void repeated(benchmark::internal::Benchmark* run) { run->MinTime(0.1)->Repetitions(9); }

BENCHMARK(forward_only)->Apply(repeated);
BENCHMARK(armtrue_47)->Apply(repeated);
BENCHMARK(ceres_jets_47)->Apply(repeated);
BENCHMARK(ceres_jets_29)->Apply(repeated);
BENCHMARK(central_differences_47)->Apply(repeated);
BENCHMARK(kdl_joints_6)->Apply(repeated);
#ifdef ARMTRUE_HAS_PINOCCHIO
BENCHMARK(pinocchio_placements_36)->Apply(repeated);
#endif
BENCHMARK(forward_only_batched)->Apply(repeated);
BENCHMARK(armtrue_47_batched)->Apply(repeated);
BENCHMARK(armtrue_inverse)->Apply(repeated);
BENCHMARK(kdl_inverse)->Apply(repeated);
BENCHMARK(compensate_targets)->Apply(repeated);

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  compare_all();
  compare_inverses();
  armtrue_bench::Times times;
  benchmark::RunSpecifiedBenchmarks(&times);
  std::printf("\nforward kinematics with 47 columns: %.0f ns (pose alone %.0f ns)\n",
              times.nanoseconds("armtrue_47"), times.nanoseconds("forward_only"));
  const auto print = [&](const char* function, const char* what) {
    std::printf("%-40s %7.0f ns, %5.1f times as long\n", what, times.nanoseconds(function),
                times.ratio(function, "armtrue_47"));
  };
  print("ceres_jets_47", "Ceres Jets, the same 47 columns");
  print("ceres_jets_29", "Ceres Jets, 29 of them");
  print("central_differences_47", "central differences, 47 columns");
  print("kdl_joints_6", "KDL's Jacobian, 6 columns of joints");
#ifdef ARMTRUE_HAS_PINOCCHIO
  print("pinocchio_placements_36", "Pinocchio's regressor, 36 of placements");
#endif

  const double batched = times.nanoseconds("armtrue_47_batched") / kPosesInCall;
  const double batched_only = times.nanoseconds("forward_only_batched") / kPosesInCall;
  std::printf(
      "\n%zu poses at once: %.0f ns a pose with 47 columns, %.2f of one at a time (pose alone "
      "%.0f ns, %.2f)\n",
      kPosesInCall, batched, batched / times.nanoseconds("armtrue_47"), batched_only,
      batched_only / times.nanoseconds("forward_only"));
  const double inverse = times.nanoseconds("armtrue_inverse");
  const double target =
      times.nanoseconds("compensate_targets") / static_cast<double>(poses().size());
  std::printf(
      "\ninverse kinematics of the identified arm from the nominal angles: %.0f ns; a target "
      "of compensate %.0f ns\n",
      inverse, target);
  std::printf(
      "KDL's Newton-Raphson %.0f ns; armtrue's takes %.2f of it, a target of compensate %.2f\n",
      times.nanoseconds("kdl_inverse"), inverse / times.nanoseconds("kdl_inverse"),
      target / times.nanoseconds("kdl_inverse"));
}
