// Both methods together: a pass with joint angles and forces, cut by an arm whose joints give way,
// on a cell and an arm that share nothing with armtrue. From it the mirror method makes poses, and
// the loop has to find the joints.

#include <gtest/gtest.h>
#include <stdlib.h>

#include <Eigen/LU>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "armtrue/io/campaign_io.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/products/deviation_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/tracing/loop.h"
#include "kinematics/six_axes.h"
#include "path/plant_pass.h"
#include "support/oracle.h"

namespace armtrue::pass_test {
namespace {

using armtrue_oracle::OracleArm;
using Angles = std::array<double, 6>;

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
const std::string kCatalogue = ARMTRUE_CONFIG "/effects/catalogue.yaml";

// How the pose changes with each angle.
Eigen::Matrix<double, 6, 6> jacobian(const OracleArm& arm, const Angles& q) {
  constexpr double kStep = 1e-6;
  Eigen::Matrix<double, 6, 6> columns;
  const KDL::Frame here = forward(arm, q);
  for (size_t j = 0; j < 6; ++j) {
    Angles moved = q;
    moved[j] += kStep;
    const KDL::Twist by = KDL::diff(here, forward(arm, moved)) / kStep;
    for (int i = 0; i < 6; ++i) columns(i, static_cast<Eigen::Index>(j)) = by[i];
  }
  return columns;
}

// Newton, from angles nearby.
Angles angles_at(const OracleArm& arm, const KDL::Frame& wanted, Angles q) {
  for (int round = 0; round < 20; ++round) {
    const KDL::Twist off = KDL::diff(forward(arm, q), wanted);
    Eigen::Matrix<double, 6, 1> left;
    for (int i = 0; i < 6; ++i) left[i] = off[i];
    if (left.norm() < 1e-10) break;
    const Eigen::Matrix<double, 6, 1> step = jacobian(arm, q).lu().solve(left);
    for (size_t j = 0; j < 6; ++j) q[j] += step[static_cast<Eigen::Index>(j)];
  }
  return q;
}

// Geometry off by some 0.3 mm and 0.3 mrad everywhere.
OracleArm true_arm(OracleArm arm) {
  armtrue_oracle::Dice dice(7);
  for (auto& link : arm.links) {
    for (double* angle : {&link.alpha, &link.theta}) *angle += 3e-4 * dice.normal();
    for (double* length : {&link.d, &link.r}) *length += 3e-4 * dice.normal();
  }
  return arm;
}

// The arm in the cell: what the controller commands, where that takes the true arm, and how this
// gives way there by its joints [rad/(N m)].
struct Cell {
  plant::Program program = plant::program(plant::Shape::pocket);
  Path programmed = path_of(program);
  Eigen::Matrix3Xd reached{3, programmed.samples()};
  std::vector<Eigen::Matrix3d> compliance;

  explicit Cell(const Angles& joint_compliance) {
    const OracleArm nominal = armtrue_oracle::read_arm(kNominal), truth = true_arm(nominal);
    Angles q{0, -0.8, 1.7, 0.1, 0.7, 0.2};
    const KDL::Rotation spindle = forward(nominal, q).M;
    programmed.q.resize(kJoints, programmed.samples());
    for (Eigen::Index i = 0; i < programmed.samples(); ++i) {
      const Eigen::Vector3d p = programmed.position.col(i);
      q = angles_at(nominal, {spindle, KDL::Vector(p.x(), p.y(), p.z())}, q);
      programmed.q.col(i) = Eigen::Map<const JointVector>(q.data(), kJoints);
      const KDL::Frame there = forward(truth, q);
      reached.col(i) << there.p.x(), there.p.y(), there.p.z();
      const Eigen::Matrix<double, 3, 6> arms = jacobian(truth, q).topRows<3>();
      compliance.emplace_back(
          arms * Eigen::Map<const JointVector>(joint_compliance.data(), kJoints).asDiagonal() *
          arms.transpose());
    }
  }

  // The poses that mirror-correct makes of a pass on such a part.
  Campaign poses_of_pass(std::uint64_t part) const {
    plant::Options options = cell(static_cast<int>(part));
    options.static_offset.setZero();
    options.reversal_step = {0, 0};
    options.compliance_along = compliance;
    const Path measured = record_of(plant::run(program, reached, options));
    const MirrorResult result = mirror_correct(programmed, {measured}, {});
    std::string folder = std::filesystem::temp_directory_path() / "armtrue-pass-XXXXXX";
    if (!mkdtemp(folder.data())) throw std::runtime_error("cannot create " + folder);
    std::ofstream(folder + "/poses.csv")
        << write_pass_as_poses(programmed, programmed.q, result.deviation, 20);
    Campaign campaign = read_campaign(folder + "/poses.csv").campaign;
    std::filesystem::remove_all(folder);
    return campaign;
  }
};

TEST(PassOfAnArm, ShowsWhichJointsTheForceTurns) {
  const Cell cell({6e-6, 5e-6, 8e-6, 0, 0, 0});
  const LoopResult result = close_loop(read_robot(kNominal).robot, cell.poses_of_pass(1),
                                       cell.poses_of_pass(2), read_catalogue(kCatalogue));
  // The joint angles change little over a part: the force may come with a function of one of them.
  // Along the path the clock is known to some 3 ms at 27 mm/s; what else is found may be that.
  std::set<std::string> turned;
  for (const TracedEffect& traced : result.trace.effects)
    if (to_string(traced.effect.driver).find("force") != std::string::npos)
      turned.insert(to_string(traced.effect.parameter));
  EXPECT_EQ(turned, (std::set<std::string>{"A1.theta", "A2.theta", "A3.theta"}));
  EXPECT_GT(result.before, 0.2 * kMillimetre);
  EXPECT_LT(result.after, 0.3 * result.before);
  EXPECT_GT(result.gain_ci95[0], 0.1 * kMillimetre);
}

}  // namespace
}  // namespace armtrue::pass_test
