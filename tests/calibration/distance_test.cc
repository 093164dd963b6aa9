// Measurements by distance to anchors: derivatives, what they show, and where they start from.

#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/calibration/zone.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/diagnosis/change.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/planning/planning.h"
#include "calibration/carried_campaign.h"
#include "kinematics/jet_chain.h"
#include "kinematics/six_axes.h"

namespace armtrue::distance_test {
namespace {

using testing::Contains;
using testing::IsSupersetOf;
using testing::Not;

Robot shipped(const std::string& name, size_t anchors) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
  robot.chain.anchors = {{"1", {2.5, 1.5, 0.1}}, {"2", {2.5, -1.5, 0.3}}, {"3", {-0.5, 2.8, 1.5}}};
  robot.chain.anchors.resize(anchors);
  return robot;
}

Campaign measured(const Robot& truth, int poses, unsigned seed, double noise_mm = 0,
                  int repeats = 1) {
  SimulationOptions options;
  options.poses = poses;
  options.seed = seed;
  options.repeats = repeats;
  options.noise_position = 1e-3 * noise_mm;
  return simulate(shipped("kr360-spindle", 0), truth, options);
}

std::vector<std::string> kept_names(const Robot& robot, const Campaign& campaign) {
  std::vector<std::string> names;
  for (int k : choose_identifiable(robot, campaign).kept)
    names.push_back(parameter_name(robot.chain, k));
  return names;
}

double worst(const Robot& robot, const Campaign& campaign) {
  return summarize(evaluate(robot, campaign).position).max;
}

double link_value(const Robot& robot, int parameter) {
  const Link& link = robot.chain.links[(parameter - kFirstLinkParameter) / 5];
  const double values[] = {link.alpha, link.d, link.theta, link.r, link.beta};
  return values[(parameter - kFirstLinkParameter) % 5];
}

// Of the identified link parameters: how many of the 95 % intervals hold the exact value.
void count_links(const CalibrationResult& exact, const CalibrationResult& noisy, int& inside,
                 int& all) {
  for (int k : exact.set.kept) {
    if (k < kFirstLinkParameter || k >= kFirstToolParameter) continue;
    inside += std::abs(link_value(noisy.robot, k) - link_value(exact.robot, k)) <=
              1.959964 * noisy.robot.std.at(parameter_name(exact.robot.chain, k));
    ++all;
  }
}

// All parameters of the chain, then scale, target and anchor.
constexpr int kAll = kTargetParameters + 3 + 4;
using Jet = ceres::Jet<double, kAll>;

Jet autodiff_distance(const KinematicChain& chain, const JointVector& q) {
  const JetParameters<kAll> p = jet_parameters<kAll>(chain);
  const auto frame = jet_frame<kAll>(chain, p, q);
  const Target& target = chain.targets.front();
  const Anchor& anchor = chain.anchors.front();
  Jet squares(0.0);
  for (int i = 0; i < 3; ++i) {
    Jet x = frame(i, 3) - (p[kTargetParameters + 3 + i] + anchor.position[i]);
    for (int c = 0; c < 3; ++c) x += frame(i, c) * (p[kTargetParameters + c] + target.position[c]);
    squares += x * x;
  }
  return (1.0 + p[kInstrumentScale]) * sqrt(squares) + p[kAll - 1] + anchor.zero;
}

TEST(Distance, JacobianEqualsAutodiff) {
  Robot robot = shipped("kr360-table4", 1);
  robot.chain.base = {rotation_exp({0.3, -0.2, 0.9}), {0.4, -0.3, 0.2}};
  robot.chain.tool = {rotation_exp({-0.1, 0.7, 0.2}), {0.1, 0.05, 0.3}};
  robot.chain.targets = {{"a", {0.03, -0.02, 0.05}}};
  robot.chain.anchors[0].zero = 2e-3;
  const Campaign campaign = measured(robot, 50, 3);
  std::vector<int> all(kAll);
  for (int k = 0; k < kAll; ++k) all[k] = k;
  const ObservationModel model(campaign, robot, all, {1.0, 1.0});
  ASSERT_EQ(model.row_size(), 1);
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(kAll));
  Eigen::MatrixXd block(1, kAll + 1);
  for (int row = 0; row < campaign.rows(); ++row) {
    at.block(row, block);
    const Jet expected = autodiff_distance(robot.chain, campaign.q[row]);
    EXPECT_NEAR(campaign.distance[row], expected.a, 1e-12);
    EXPECT_NEAR(block(0, kAll), 0, 1e-12);
    for (int k = 0; k < kAll; ++k)
      EXPECT_NEAR(block(0, k), expected.v[k], 1e-9 * (std::abs(expected.v[k]) + 1e-3))
          << parameter_name(robot.chain, k);
  }
}

// Away from the start as well, where turns of base and tool are no longer small.
TEST(Distance, JacobianEqualsDifferencesAnywhere) {
  const Robot robot = shipped("kr360-table4", 2);
  const Campaign campaign = measured(robot, 10, 4);
  const ObservationModel model(campaign, robot, choose_identifiable(robot, campaign).kept, {1, 1});
  const int p = model.unknowns();
  Eigen::VectorXd x(p);
  for (int k = 0; k < p; ++k) x[k] = 0.05 * std::sin(1.0 + k);
  Eigen::MatrixXd block(1, p + 1);
  constexpr double kStep = 1e-5;
  for (int row = 0; row < campaign.rows(); ++row) {
    model.at(x).block(row, block);
    for (int k = 0; k < p; ++k) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(p, k);
      const double difference =
          (model.at(x - step).residual(row)[0] - model.at(x + step).residual(row)[0]) / (2 * kStep);
      EXPECT_NEAR(block(0, k), difference, 1e-8) << model.unknown_names()[k];
    }
  }
}

TEST(Distance, OneAnchorShowsTheTranslationOfTheBaseAndThreeAllOfIt) {
  const Robot one = shipped("kr360-spindle", 1), three = shipped("kr360-spindle", 3);
  const auto of_one = kept_names(one, measured(one, 80, 1));
  EXPECT_THAT(of_one, IsSupersetOf({"base.x", "base.y", "base.z", "anchor 1.zero"}));
  for (const char* name :
       {"base.rx", "base.ry", "base.rz", "anchor 1.x", "anchor 1.y", "anchor 1.z"})
    EXPECT_THAT(of_one, Not(Contains(name)));
  const auto of_three = kept_names(three, measured(three, 80, 1));
  EXPECT_THAT(of_three, IsSupersetOf({"base.x", "base.ry", "base.rz", "anchor 3.zero"}));
  // Nine coordinates less the six of the base are shapes of their triangle.
  EXPECT_EQ(std::ranges::count_if(of_three,
                                  [](const std::string& name) {
                                    return name.starts_with("anchor") && !name.ends_with("zero");
                                  }),
            3);
  // What moves an arm as a whole looks the same from one point or from three.
  EXPECT_EQ(of_one.size() - 4, of_three.size() - 12);
}

TEST(Distance, WhatAbsorbsTheAnchorIsNamed) {
  const Robot robot = shipped("kr360-spindle", 1);
  for (const AbsorbedParameter& absorbed :
       choose_identifiable(robot, measured(robot, 80, 1)).absorbed)
    if (parameter_name(robot.chain, absorbed.parameter) == "anchor 1.y") {
      ASSERT_EQ(absorbed.absorbed_by.size(), 1u);
      EXPECT_EQ(parameter_name(robot.chain, absorbed.absorbed_by[0].first), "base.y");
      EXPECT_NEAR(absorbed.absorbed_by[0].second, -1, 1e-9);
      return;
    }
  FAIL() << "anchor 1.y is not absorbed";
}

// Seen from above, three of these anchors stand on one line to 5 mm: their heights do not show how
// R_A is tilted. What is held must show each of its six motions, here by 1 m and by 1 rad at 3 m.
TEST(Distance, AnchorsOnOneLineAreNotWhatTheBaseIsBoundTo) {
  Robot robot = shipped("kr360-spindle", 1);
  robot.chain.anchors = {{"1", {-2.5, -2.5, 0.1}},
                         {"2", {-2.2, 2.75, 0.1}},
                         {"3", {4.1, -3.0, 0.05}},
                         {"4", {0.36, 0.42, 4.5}}};
  const auto kept = kept_names(robot, measured(robot, 80, 6));
  Eigen::MatrixXd motions(0, 6);
  for (const Anchor& anchor : robot.chain.anchors)
    for (int axis : {0, 1, 2}) {
      if (std::ranges::count(kept, "anchor " + anchor.name + "." + "xyz"[axis]) > 0) continue;
      motions.conservativeResize(motions.rows() + 1, 6);
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
      motions.bottomRows<1>() << unit.transpose(), anchor.position.cross(unit).transpose() / 3;
    }
  ASSERT_EQ(motions.rows(), 6);
  EXPECT_GT(motions.jacobiSvd().singularValues()[5], 0.1);
}

// A ball-bar of one length cannot tell its zero error from the size of the arm.
TEST(Distance, OfOneLengthDoesNotShowTheZero) {
  Robot robot = shipped("kr360-spindle", 1);
  robot.chain.links[6].r = 0.3;  // off the axis of the wrist
  // On a sphere about the anchor: the arm as it is, the anchor where each pose wants it, is no
  // ball-bar; so bend q3 until the length is right.
  Campaign campaign = measured(robot, 4000, 5);
  const ChainEvaluator arm(robot.chain);
  constexpr double kLength = 2.0;
  std::vector<int> rows;
  for (int row = 0; row < campaign.rows(); ++row) {
    auto q = campaign.q[row];
    const auto miss = [&] {
      return (arm.pose(q).translation - robot.chain.anchors[0].position).norm() - kLength;
    };
    for (int step = 0; step < 50 && std::abs(miss()) > 1e-13; ++step) {
      const double here = miss();
      q[2] += 1e-6;
      const double slope = (miss() - here) / 1e-6;
      q[2] -= 1e-6 + std::clamp(here / slope, -0.2, 0.2);
    }
    campaign.distance[row] = kLength;
    if (std::abs(miss()) < 1e-12) rows.push_back(row);
  }
  ASSERT_GT(rows.size(), 100u);
  EXPECT_THAT(kept_names(robot, campaign.select(rows)), Not(Contains("anchor 1.zero")));
  EXPECT_THAT(kept_names(robot, measured(robot, 100, 5)), Contains("anchor 1.zero"));
}

TEST(Distance, IdentifiesTheArmAndTheZero) {
  for (size_t anchors : {1u, 2u, 3u}) {
    Robot truth = shipped("kr360-table4", anchors);
    for (Anchor& anchor : truth.chain.anchors) {
      anchor.position += Eigen::Vector3d(0.03, -0.02, 0.01);
      anchor.zero = 1.5e-3;
    }
    const CalibrationResult result =
        calibrate(shipped("kr360-spindle", anchors), measured(truth, 80, 6));
    EXPECT_TRUE(result.converged) << result.termination;
    EXPECT_LT(worst(result.robot, measured(truth, 50, 7)), 1e-9) << anchors << " anchors";
    for (const Anchor& anchor : result.robot.chain.anchors) EXPECT_NEAR(anchor.zero, 1.5e-3, 1e-9);
  }
}

TEST(Distance, FindsAnAnchorThatNobodyKnew) {
  for (size_t anchors : {1u, 3u}) {
    Robot truth = shipped("kr360-table4", anchors);
    truth.chain.base = {rotation_exp({0.1, -0.2, 2.0}), {1.5, -2, 0.5}};
    const CalibrationResult result =
        calibrate(shipped("kr360-spindle", anchors), measured(truth, 60, 8));
    EXPECT_TRUE(result.converged) << result.termination;
    EXPECT_LT(worst(result.robot, measured(truth, 50, 9)), 1e-9) << anchors << " anchors";
  }
}

// 95 per cent intervals hold the truth in 93 per cent at least. With 36 unknowns from three
// readings of each of 60 poses, a covariance by pose errs to the wide side.
TEST(Distance, StatedDeviationsCoverTheTruth) {
  const Robot truth = shipped("kr360-table4", 3);
  Robot robot = shipped("kr360-spindle", 3);
  int inside = 0, all = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const CalibrationResult exact = calibrate(robot, measured(truth, 60, seed));
    const CalibrationResult noisy = calibrate(robot, measured(truth, 60, seed, 0.095));
    for (Eigen::Index k = 0; k < exact.change.size(); ++k) {
      inside += std::abs(noisy.change[k] - exact.change[k]) <=
                1.959964 * std::sqrt(noisy.covariance(k, k));
      ++all;
    }
  }
  const double coverage = static_cast<double>(inside) / all;
  std::printf("distances: coverage of 95 %% intervals %.4f\n", coverage);
  EXPECT_GT(coverage, 0.93);
  EXPECT_LT(coverage, 0.98);
}

TEST(Distance, AMovedAnchorIsNamed) {
  Robot truth = shipped("kr360-table4", 3);
  const CalibrationResult previous =
      calibrate(shipped("kr360-spindle", 3), measured(truth, 60, 10, 0.095, 3));
  EXPECT_TRUE(detect_change(previous.robot, previous.sigma, measured(truth, 10, 11, 0.095)).holds);
  truth.chain.anchors[1].position += Eigen::Vector3d(1e-3, 1e-3, -1e-3);
  const ChangeResult change =
      detect_change(previous.robot, previous.sigma, measured(truth, 10, 11, 0.095));
  EXPECT_FALSE(change.holds);
  EXPECT_EQ(change.moved.front().what, "anchor 2");
  EXPECT_LT(change.after, 0.5 * change.before);
}

// Campaigns of the oracle: the arm is carried by metres between two sessions, and what follows is
// that of a calibration without noise as far as the stated deviations say.
TEST(Distance, DeviationsOfSeveralSessionsCoverTheTruth) {
  for (size_t anchors : {1u, 2u, 3u}) {
    const Robot robot = shipped("kr360-spindle", anchors);
    armtrue_oracle::CampaignPlan plan;
    for (const Anchor& anchor : robot.chain.anchors)
      plan.anchors.push_back(
          {{anchor.position[0] + 0.01, anchor.position[1], anchor.position[2]}, 1e-3});
    int inside = 0, all = 0;
    for (plan.seed = 1; plan.seed <= 30; ++plan.seed) {
      const auto calibrated = [&](double noise_mm) {
        plan.noise_mm = noise_mm;
        const Campaign campaign = carried_campaign({60, 60}, plan);
        const CalibrationResult result = calibrate(robot, campaign);
        EXPECT_TRUE(result.converged) << result.termination;
        if (noise_mm == 0) EXPECT_LT(worst(result.robot, campaign), 1e-7) << anchors;
        return result;
      };
      const CalibrationResult exact = calibrated(0), noisy = calibrated(0.095);
      count_links(exact, noisy, inside, all);
    }
    const double coverage = static_cast<double>(inside) / all;
    std::printf("distances of two sessions, %zu anchors: coverage %.4f of %d\n", anchors, coverage,
                all);
    EXPECT_GT(coverage, 0.92);  // 540 of them: one per cent of deviation
    EXPECT_LT(coverage, 0.98);
  }
}

TEST(Distance, AZeroOffsetThatMovedBetweenTwoSessionsIsNamed) {
  const Robot robot = shipped("kr360-spindle", 3);
  armtrue_oracle::CampaignPlan plan;
  for (const Anchor& anchor : robot.chain.anchors)
    plan.anchors.push_back({{anchor.position[0], anchor.position[1], anchor.position[2]}, 1e-3});
  for (double offset : {0.0, 1e-3}) {
    const Campaign all = carried_campaign({90, 12, 12}, plan, [&](int j, int session) {
      return j == 2 && session == 2 ? offset : 0;
    });
    const CalibrationResult previous = calibrate(robot, sessions_of(all, 0, 0));
    const ChangeResult change =
        detect_change(previous.robot, previous.sigma, sessions_of(all, 1, 2));
    EXPECT_EQ(change.holds, offset == 0);
    if (offset == 0) continue;
    ASSERT_EQ(change.moved.size(), 1u);
    EXPECT_EQ(change.moved.front().what, "A3.theta");
    EXPECT_EQ(change.moved.front().sessions, std::vector<std::string>{"day 2"});
  }
}

// A model that cannot follow everywhere follows in the zone, in whichever session it is read.
TEST(Distance, InAZoneCountForMore) {
  const Robot robot = shipped("kr360-spindle", 3);
  Robot truth = shipped("kr360-undeclared", 3);
  truth.chain.anchors = robot.chain.anchors;
  Campaign campaign = measured(truth, 120, 20, 0.02);
  Campaign weighted = campaign;
  const Zone zone{{1.6, 0, 1.0}, 0.4};
  weight_by_zone(weighted, robot, zone);
  SimulationOptions options;
  options.poses = 40;
  options.box = Box{{1.3, -0.3, 0.7}, {1.9, 0.3, 1.3}};
  const Campaign there = simulate(shipped("kr360-spindle", 0), truth, options);
  const auto mean = [&](const Campaign& readings) {
    return summarize(evaluate(calibrate(robot, readings).robot, there).position).mean;
  };
  EXPECT_LT(mean(weighted), 0.9 * mean(campaign));
}

// Points of one instrument and, at other poses, distances of another, coarser one.
Campaign points_and_distances(const Robot& truth, unsigned seed, double noise_mm) {
  const double coarser = 3;
  Robot without = truth;
  without.chain.anchors.clear();
  SimulationOptions options;
  options.poses = 40;
  options.orientation = false;
  options.seed = seed;
  options.noise_position = 1e-3 * noise_mm;
  Campaign all = simulate(shipped("kr360-spindle", 0), without, options);
  const Campaign distances = measured(truth, 40, 1000 + seed, coarser * noise_mm);
  all.distance.assign(all.q.size(), 0);
  all.anchor.assign(all.q.size(), 0);
  all.sigma_position.assign(all.q.size(), 1e-4);
  all.anchor_names = distances.anchor_names;
  for (int row = 0; row < distances.rows(); ++row) {
    all.pose.push_back(40 + distances.pose[row]);
    all.line.push_back(all.line.back() + 1);
    all.q.push_back(distances.q[row]);
    all.position.emplace_back(0, 0, 0);
    all.distance.push_back(distances.distance[row]);
    all.anchor.push_back(distances.anchor[row]);
    all.sigma_position.push_back(coarser * 1e-4);
  }
  for (const std::string& id : distances.pose_ids) all.pose_ids.push_back("d" + id);
  all.repeat.clear();
  all.time_s.clear();
  all.arrival.clear();
  all.stroke.clear();
  points_to_coordinates(all);
  return all;
}

TEST(Distance, BesidePointsIdentifyTheArmAndTheAnchor) {
  Robot truth = shipped("kr360-table4", 1);
  truth.chain.base = {rotation_exp({0.1, -0.2, 2.0}), {1.5, -2, 0.5}};
  truth.chain.anchors[0].position += Eigen::Vector3d(0.03, -0.02, 0.01);
  truth.chain.anchors[0].zero = 1.5e-3;
  const Robot robot = shipped("kr360-spindle", 1);
  const CalibrationResult exact = calibrate(robot, points_and_distances(truth, 1, 0));
  EXPECT_TRUE(exact.converged) << exact.termination;
  const Anchor& found = exact.robot.chain.anchors[0];
  EXPECT_LT((found.position - truth.chain.anchors[0].position).norm(), 1e-8);
  EXPECT_NEAR(found.zero, 1.5e-3, 1e-8);
  EXPECT_LT(worst(exact.robot, points_and_distances(truth, 2, 0)), 1e-9);

  int inside = 0, all = 0;
  for (unsigned seed = 1; seed <= 150; ++seed) {
    const CalibrationResult noisy = calibrate(robot, points_and_distances(truth, seed, 0.095));
    const Anchor& anchor = noisy.robot.chain.anchors[0];
    const Eigen::Vector3d error = anchor.position - truth.chain.anchors[0].position;
    const double errors[] = {error.x(), error.y(), error.z(), anchor.zero - 1.5e-3};
    const char* names[] = {"anchor 1.x", "anchor 1.y", "anchor 1.z", "anchor 1.zero"};
    for (int i = 0; i < 4; ++i) {
      inside += std::abs(errors[i]) <= 1.959964 * noisy.robot.std.at(names[i]);
      ++all;
    }
    count_links(exact, noisy, inside, all);
  }
  const double coverage = static_cast<double>(inside) / all;
  std::printf("points and distances: coverage %.4f of %d\n", coverage, all);
  EXPECT_GT(coverage, 0.93);
  EXPECT_LT(coverage, 0.97);
}

TEST(Distance, PlannedPosesAreReadAsDistances) {
  const Robot robot = shipped("kr360-spindle", 3);
  const PosePlanner planner(robot, {}, measured(robot, 5, 12));
  const PlanQuality planned = planner.quality(planner.plan(30));
  EXPECT_LT(planned.cloud_deviation, planner.quality(planner.random(30, 13)).cloud_deviation);
}

// The variance of a point exceeds that of a length.
TEST(Distance, PointsOfTheMeasuredPosesAreNotOutside) {
  const Campaign lengths = measured(shipped("kr360-spindle", 3), 60, 15, 0.095);
  const CalibrationResult fit = calibrate(shipped("kr360-spindle", 3), lengths);
  Robot robot = fit.robot;
  robot.uncertainty = uncertainty_of(fit, lengths);
  Campaign points = lengths;
  points.distance.clear();
  points.anchor.clear();
  points.anchor_names.clear();
  points.position.assign(points.q.size(), Eigen::Vector3d::Zero());
  const auto largest = [&](const Campaign& campaign) {
    double most = 0;
    for (const Prediction& prediction : predict(robot, campaign))
      most = std::max(most, prediction.leverage);
    return most;
  };
  EXPECT_NEAR(largest(lengths), 1, 1e-9);
  EXPECT_NEAR(largest(points), 1, 1e-9);
}

TEST(Distance, WithoutItsAnchorIsAnError) {
  const Campaign campaign = measured(shipped("kr360-spindle", 2), 40, 14);
  EXPECT_THROW(calibrate(shipped("kr360-spindle", 0), campaign), std::invalid_argument);
  EXPECT_THROW(evaluate(shipped("kr360-spindle", 1), campaign), std::invalid_argument);
  Campaign unnamed = campaign;
  unnamed.anchor.clear();
  unnamed.anchor_names.clear();
  EXPECT_THROW(evaluate(shipped("kr360-spindle", 2), unnamed), std::invalid_argument);
}

}  // namespace
}  // namespace armtrue::distance_test
