#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <random>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/observation/session_models.h"
#include "kinematics/six_axes.h"

namespace armtrue::sessions_test {
namespace {

Robot shipped(const std::string& name) {
  return read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
}

std::string name_of(int session) { return "day " + std::to_string(session + 1); }

// Where the instrument saw the robot: the first as the file says, each further one metres away.
Pose base_of(const Robot& truth, int session) {
  if (session == 0) return truth.chain.base;
  const double s = session;
  return {rotation_exp({0.1 * s, -0.2, 1.1 * s}), {3 * s, -2 - s, 0.5}};
}

struct Readings {
  int sessions = 2;
  int poses = 30;  // of each session
  unsigned seed = 1;
  double noise_mm = 0, noise_mrad = 0;
  double coarser = 1;  // noise of the further sessions, in units of the first's
  bool orientation = true;
  double remastered = 0;  // rad, of A2 and the other way of A5, before each further session
};

// One campaign of several sessions; the poses differ from session to session.
Campaign measured(const Robot& truth, const Readings& readings) {
  Campaign all;
  for (int s = 0; s < readings.sessions; ++s) {
    Robot moved = truth;
    moved.chain.base = base_of(truth, s);
    moved.chain.links[1].theta += s * readings.remastered;
    moved.chain.links[4].theta -= s * readings.remastered;
    SimulationOptions options;
    options.poses = readings.poses;
    options.seed = 100 * readings.seed + static_cast<unsigned>(s);
    const double noise = s == 0 ? 1 : readings.coarser;
    options.noise_position = 1e-3 * readings.noise_mm * noise;
    options.noise_orientation = 1e-3 * readings.noise_mrad * noise;
    options.orientation = readings.orientation;
    const Campaign part = simulate(shipped("kr360-spindle"), moved, options);
    all.session_names.push_back(name_of(s));
    for (int row = 0; row < part.rows(); ++row) {
      all.session.push_back(s);
      all.pose.push_back(static_cast<int>(all.pose_ids.size()) + part.pose[row]);
      all.line.push_back(all.rows() + 2);
      all.q.push_back(part.q[row]);
      all.time_s.push_back(part.time_s[row]);
      all.position.push_back(part.position[row]);
      if (part.has_orientation()) all.orientation.push_back(part.orientation[row]);
    }
    for (const std::string& id : part.pose_ids) all.pose_ids.push_back(name_of(s) + " " + id);
  }
  return all;
}

// What an instrument that never moved would have read.
Campaign moved_back(const Campaign& campaign, const Robot& truth) {
  Campaign moved = campaign;
  for (int row = 0; row < campaign.rows(); ++row) {
    const Pose first_from_own = truth.chain.base * inverse(base_of(truth, campaign.session[row]));
    moved.position[row] = first_from_own * campaign.position[row];
    moved.orientation[row] =
        Eigen::Quaterniond(first_from_own.rotation) * campaign.orientation[row];
  }
  moved.session.clear();
  moved.session_names.clear();
  return moved;
}

double link_difference(const Robot& a, const Robot& b, int parameter) {
  const Link& u = a.chain.links[(parameter - kFirstLinkParameter) / 5];
  const Link& v = b.chain.links[(parameter - kFirstLinkParameter) / 5];
  const double differences[] = {u.alpha - v.alpha, u.d - v.d, u.theta - v.theta, u.r - v.r,
                                u.beta - v.beta};
  return differences[(parameter - kFirstLinkParameter) % 5];
}

// Errors in units of the stated deviations: links, then the bases of further sessions.
std::vector<double> scores(const CalibrationResult& result, const Robot& truth, int sessions) {
  std::vector<double> list;
  for (int k : result.set.kept)
    list.push_back(link_difference(result.robot, truth, k) /
                   result.robot.std.at(parameter_name(truth.chain, k)));
  for (int s = 1; s < sessions; ++s) {
    const Session& found = result.robot.sessions.at(name_of(s));
    const Pose expected = base_of(truth, s);
    Eigen::Matrix<double, 6, 1> error;
    error << found.base.translation - expected.translation,
        rotation_log(found.base.rotation * expected.rotation.transpose());
    for (int i = 0; i < 6; ++i)
      list.push_back(error[i] / found.std.at(parameter_name(truth.chain, i)));
  }
  return list;
}

// 95 per cent intervals hold the truth in 93 to 97 per cent, links and bases alike.
TEST(Sessions, StatedDeviationsCoverTheTruth) {
  const Robot truth = shipped("kr360-table4");
  Robot robot = shipped("kr360-spindle");
  robot.identify = {"paper-25"};
  for (int sessions : {2, 5}) {
    int inside = 0, all = 0;
    double squares = 0, worst = 0;
    for (unsigned seed = 1; seed <= 100; ++seed) {
      const Campaign campaign = measured(
          truth, {.sessions = sessions, .seed = seed, .noise_mm = 0.095, .noise_mrad = 0.15});
      const CalibrationResult result = calibrate(robot, campaign);
      EXPECT_TRUE(result.converged) << result.termination;
      EXPECT_EQ(result.rank, 25 + 6 * (sessions - 1));
      EXPECT_EQ(result.robot.sessions.size(), sessions);
      for (double score : scores(result, truth, sessions)) {
        inside += std::abs(score) <= 1.959964;
        squares += score * score;
        worst = std::max(worst, std::abs(score));
        ++all;
      }
    }
    const double coverage = static_cast<double>(inside) / all;
    std::printf(
        "%d sessions: coverage of 95 %% intervals %.4f, spread of scores %.4f, worst %.2f\n",
        sessions, coverage, std::sqrt(squares / all), worst);
    EXPECT_GT(coverage, 0.93);
    EXPECT_LT(coverage, 0.97);
    EXPECT_LT(worst, 5);
  }
}

TEST(Sessions, EqualOneCampaignWithThePointsMovedBack) {
  const Robot truth = shipped("kr360-table4");
  const Robot robot = shipped("kr360-spindle");
  for (int sessions : {2, 5}) {
    const Campaign campaign = measured(truth, {.sessions = sessions, .poses = 20});
    const CalibrationResult joint = calibrate(robot, campaign);
    const CalibrationResult single = calibrate(robot, moved_back(campaign, truth));
    ASSERT_TRUE(joint.converged) << joint.termination;
    EXPECT_EQ(joint.set.kept, single.set.kept);
    double worst =
        (joint.robot.chain.base.translation - single.robot.chain.base.translation).norm();
    for (int k : joint.set.kept)
      if (k >= kFirstLinkParameter && k < kFirstToolParameter)
        worst = std::max(worst, std::abs(link_difference(joint.robot, single.robot, k)));
    worst = std::max(
        worst, (joint.robot.chain.tool.translation - single.robot.chain.tool.translation).norm());
    const double error = summarize(evaluate(joint.robot, campaign).position).max;
    std::printf(
        "%d sessions: %d iterations, %.1e m or rad from one campaign, errors up to %.1e m\n",
        sessions, joint.iterations, worst, error);
    EXPECT_LT(worst, 1e-9);
    EXPECT_LT(error, 1e-9);
  }
}

// Bases that have to be found cost information: deviations grow, and never fall.
TEST(Sessions, TheirBasesCountInTheDeviations) {
  const Robot truth = shipped("kr360-table4");
  Robot robot = shipped("kr360-spindle");
  robot.identify = {"paper-25"};
  const Campaign campaign =
      measured(truth, {.sessions = 5, .poses = 12, .noise_mm = 0.095, .noise_mrad = 0.15});
  CalibrationOptions options;
  options.robust = false;
  const CalibrationResult joint = calibrate(robot, campaign, options);
  const CalibrationResult single = calibrate(robot, moved_back(campaign, truth), options);
  for (const auto& [name, deviation] : single.robot.std)
    EXPECT_GT(joint.robot.std.at(name), 0.95 * deviation) << name;
  EXPECT_GT(joint.robot.std.at("A1.theta"), 1.5 * single.robot.std.at("A1.theta"));
}

// The instrument of the second session names its axes anew: what was x is y, y is z, z is x. The
// deviations of its base take the new names.
TEST(Sessions, DeviationsOfABaseFollowTheAxesOfItsInstrument) {
  const Robot truth = shipped("kr360-table4");
  const Robot robot = shipped("kr360-spindle");
  const Campaign campaign =
      measured(truth, {.sessions = 2, .poses = 25, .noise_mm = 0.095, .noise_mrad = 0.15});
  Eigen::Matrix3d renamed;
  renamed << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  Campaign turned = campaign;
  for (int row = 0; row < campaign.rows(); ++row) {
    if (campaign.session[row] == 0) continue;
    turned.position[row] = renamed * campaign.position[row];
    turned.orientation[row] = Eigen::Quaterniond(renamed) * campaign.orientation[row];
  }
  const auto before = calibrate(robot, campaign).robot.sessions.at(name_of(1)).std;
  const auto after = calibrate(robot, turned).robot.sessions.at(name_of(1)).std;
  for (const auto& [was, is] :
       {std::pair("x", "y"), std::pair("y", "z"), std::pair("z", "x"), std::pair("rx", "ry"),
        std::pair("ry", "rz"), std::pair("rz", "rx")}) {
    const double old = before.at(std::string("base.") + was);
    EXPECT_NEAR(after.at(std::string("base.") + is), old, 1e-4 * old) << was;
  }
  const double x = before.at("base.x"), y = before.at("base.y"), z = before.at("base.z");
  EXPECT_GT(std::max({x, y, z}), 1.05 * std::min({x, y, z}));  // or the names would say nothing
}

TEST(Sessions, IgnoredTheyAreMetresOff) {
  const Robot truth = shipped("kr360-table4");
  const Campaign campaign = measured(truth, {});
  CalibrationResult result = calibrate(shipped("kr360-spindle"), campaign);
  EXPECT_LT(summarize(evaluate(result.robot, campaign).position).max, 1e-9);
  result.robot.sessions.clear();
  EXPECT_GT(summarize(evaluate(result.robot, campaign).position).max, 1);
}

TEST(Sessions, AColumnWithOneNameChangesNothing) {
  const Robot robot = shipped("kr360-spindle");
  Campaign campaign = measured(shipped("kr360-table4"),
                               {.sessions = 1, .poses = 40, .noise_mm = 0.1, .noise_mrad = 0.1});
  const CalibrationResult named = calibrate(robot, campaign);
  campaign.session.clear();
  campaign.session_names.clear();
  const CalibrationResult unnamed = calibrate(robot, campaign);
  EXPECT_EQ(named.change, unnamed.change);
  EXPECT_EQ(named.covariance, unnamed.covariance);
  EXPECT_TRUE(named.robot.sessions.empty());
}

// The ratio of deviations stated in the file holds between sessions too: one that is a hundred
// times coarser adds next to nothing, and takes nothing away. Unstated, it costs something, though
// Student's t holds most of it back.
TEST(Sessions, OwnDeviationsOfRowsWeighBetweenSessions) {
  const Robot truth = shipped("kr360-table4");
  Robot robot = shipped("kr360-spindle");
  robot.identify = {"paper-25"};
  robot.free_links = true;  // priors would say what the coarse readings hide
  Campaign campaign =
      measured(truth, {.noise_mm = 0.05, .noise_mrad = 0.1, .coarser = 100, .orientation = false});
  const double unstated = calibrate(robot, campaign).robot.std.at("A3.d");
  std::vector<int> first;
  for (int row = 0; row < campaign.rows(); ++row) {
    campaign.sigma_position.push_back(campaign.session[row] == 0 ? 0.05e-3 : 5e-3);
    if (campaign.session[row] == 0) first.push_back(row);
  }
  const double stated = calibrate(robot, campaign).robot.std.at("A3.d");
  const double first_alone = calibrate(robot, campaign.select(first)).robot.std.at("A3.d");
  EXPECT_NEAR(stated, first_alone, 0.3 * first_alone);
  EXPECT_GT(unstated, 1.1 * stated);
}

TEST(Sessions, OneThatDoesNotShowItsBaseIsAnError) {
  const Campaign campaign = measured(shipped("kr360-table4"), {.orientation = false});
  std::vector<int> rows;
  for (int row = 0; row < 32; ++row) rows.push_back(row);  // two points of the second
  EXPECT_THROW(calibrate(shipped("kr360-spindle"), campaign.select(rows)), std::invalid_argument);
}

// What choose_identifiable() chooses, column by column by least squares on the derivatives of all
// rows and sessions at once, zeros and all. The robot's angles are right ones as they stand.
IdentifiableSet choose_plainly(const Robot& robot, const Campaign& campaign) {
  const std::vector<int> order = allowed_parameters(robot, campaign);  // of auto: of preference
  const SessionModels models(campaign, robot, order, {1.0, 1.0});
  const Eigen::MatrixXd blocks = models.blocks();
  const int asked = static_cast<int>(order.size()), further = models.unknowns() - asked;
  Eigen::MatrixXd before = blocks.middleCols(asked, further);
  IdentifiableSet set;
  std::vector<int> kept;
  for (int c = 0; c < asked; ++c) {
    const Eigen::VectorXd column = blocks.col(c);
    const Eigen::VectorXd shares = before.householderQr().solve(column);
    const double norm = column.norm(), left = (column - before * shares).norm();
    const bool moves_readings = norm > 1e-12;  // the turn of a point does not
    if (moves_readings && before.cols() < before.rows() && left > 1e-6 * norm) {
      before.conservativeResize(Eigen::NoChange, before.cols() + 1);
      before.rightCols<1>() = column;
      kept.push_back(order[c]);
      continue;
    }
    AbsorbedParameter& absorbed = set.absorbed.emplace_back(AbsorbedParameter{order[c]});
    for (size_t k = 0; moves_readings && k < kept.size(); ++k)
      if (const double share = shares[further + static_cast<int>(k)]; std::abs(share) > 1e-4)
        absorbed.absorbed_by.emplace_back(kept[k], share);
  }
  std::sort(kept.begin(), kept.end());
  set.kept = kept;
  return set;
}

// Session by session the choice is the same, in whatever order their rows stand.
TEST(Sessions, AreChosenForAsAllRowsAtOnce) {
  const Robot truth = shipped("kr360-table4");
  int absorbed_all = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const bool orientation = seed % 2 == 0, remastered = seed % 3 == 0;
    Robot robot = shipped("kr360-spindle");
    if (remastered) robot.identify_per_session = {"A2.theta", "A5.theta"};
    const Campaign sorted = measured(truth, {.sessions = 2 + static_cast<int>(seed % 4),
                                             .poses = 4 + static_cast<int>(seed % 5),
                                             .seed = seed,
                                             .orientation = orientation});
    std::vector<int> rows(static_cast<size_t>(sorted.rows()));
    std::iota(rows.begin(), rows.end(), 0);
    std::shuffle(rows.begin(), rows.end(), std::mt19937(seed));
    const Campaign campaign = sorted.select(rows);
    const IdentifiableSet set = choose_identifiable(robot, campaign);
    const IdentifiableSet plain = choose_plainly(robot, campaign);
    EXPECT_EQ(set.kept, plain.kept) << seed;
    ASSERT_EQ(set.absorbed.size(), plain.absorbed.size()) << seed;
    for (size_t k = 0; k < set.absorbed.size(); ++k) {
      EXPECT_EQ(set.absorbed[k].parameter, plain.absorbed[k].parameter) << seed;
      const std::map<int, double> found(set.absorbed[k].absorbed_by.begin(),
                                        set.absorbed[k].absorbed_by.end());
      ASSERT_EQ(found.size(), plain.absorbed[k].absorbed_by.size()) << seed;
      for (const auto& [parameter, share] : plain.absorbed[k].absorbed_by)
        EXPECT_NEAR(found.at(parameter), share, 1e-6 * (1 + std::abs(share))) << seed;
    }
    absorbed_all += static_cast<int>(set.absorbed.size());
  }
  EXPECT_GT(absorbed_all, 0);
}

// Effects that predict with the coefficients that they have are no unknowns, and the base of a
// further session stands behind those that are.
TEST(Sessions, TheBaseOfAFurtherOneIsNoUncertaintyOfAnEffect) {
  Robot robot = shipped("kr360-spindle");
  robot.identify = {"base", "A2.d", "A3.d", "A4.r", "A2.theta", "A3.theta"};
  const Campaign campaign = measured(
      shipped("kr360-table4"), {.sessions = 2, .poses = 40, .noise_mm = 0.095, .noise_mrad = 0.15});
  const Eigen::Index without = uncertainty_of(calibrate(robot, campaign), campaign).root.rows();
  for (const char* parameter : {"A4.theta", "A5.theta"})
    robot.effects.push_back({"part of the remainder", parameter, *parse_driver("joint-angle 3"),
                             *parse_shape("harmonic 1"), {{"sin", 1e-6}, {"cos", 1e-6}}});
  CalibrationOptions options;
  options.fitted_effects = 0;
  EXPECT_EQ(uncertainty_of(calibrate(robot, campaign, options), campaign).root.rows(), without);
  options.fitted_effects = 1;
  EXPECT_EQ(uncertainty_of(calibrate(robot, campaign, options), campaign).root.rows(), without + 2);
}

// An uncertainty names the unknowns of the first session: of its readings the variance is exact,
// and those of a further one move with its own base about as much.
TEST(Sessions, PredictionsOfEachFollowItsOwnColumns) {
  Robot robot = shipped("kr360-spindle");
  robot.identify = {"base", "A2.d", "A3.d", "A4.r", "A2.theta", "A3.theta"};
  const Campaign campaign = measured(
      shipped("kr360-table4"), {.sessions = 2, .poses = 40, .noise_mm = 0.095, .noise_mrad = 0.15});
  const CalibrationResult fit = calibrate(robot, campaign);
  const SessionModels models(campaign, fit.robot, fit.set.kept, {1, 1});
  const Eigen::MatrixXd blocks = models.blocks();
  Robot found = fit.robot;
  found.uncertainty = uncertainty_of(fit, campaign);
  const std::vector<Prediction> predictions = predict(found, campaign);
  for (int row = 0; row < campaign.rows(); ++row) {
    const auto moved = blocks.middleRows(6 * row, 3).leftCols(models.unknowns());
    const double exact = (moved * fit.covariance * moved.transpose()).trace();
    const double predicted = predictions[row].leverage * found.uncertainty->largest_variance;
    if (campaign.session[row] == 0) {
      EXPECT_NEAR(predicted, exact, 1e-3 * exact) << row;
    } else {
      EXPECT_GT(predicted, 0.3 * exact) << row;
      EXPECT_LT(predicted, 3 * exact) << row;
    }
  }
}

// Four points leave the base of each session uncertain, and held-out poses of one say nothing of
// the base of another.
TEST(Sessions, AHeldOutPoseOfOneOfFewPointsIsBoundedByItsOwnBase) {
  constexpr int kCampaigns = 20, kMost = 4;  // of Binomial(20, 0.05) more has p 0.003
  const Robot robot = shipped("kr360-spindle");
  int beyond = 0;
  for (unsigned seed = 1; seed <= kCampaigns; ++seed) {
    const Campaign campaign = measured(
        robot, {.sessions = 10, .poses = 5, .seed = seed, .noise_mm = 0.03, .orientation = false});
    std::vector<int> training, rest;
    for (int row = 0; row < campaign.rows(); ++row) (row % 5 == 4 ? rest : training).push_back(row);
    const Campaign fitted = campaign.select(training), held_out = campaign.select(rest);
    const CalibrationResult fit = calibrate(robot, fitted);
    const IfComplete known = uncertainty_if_complete(fit, fitted);
    Robot found = fit.robot;
    found.uncertainty = known.uncertainty;
    beyond += p_of_errors(found, held_out, 0, known.roots) < 0.05;
  }
  EXPECT_LE(beyond, kMost);
}

TEST(Sessions, OwnZeroOffsetsAreFound) {
  const Robot truth = shipped("kr360-table4");
  Robot robot = shipped("kr360-spindle");
  robot.identify = {"paper-25"};
  const Campaign exact = measured(truth, {.sessions = 3, .remastered = 1e-3});
  EXPECT_GT(summarize(evaluate(calibrate(robot, exact).robot, exact).position).mean, 1e-4);
  robot.identify_per_session = {"A2.theta", "A5.theta"};
  const CalibrationResult found = calibrate(robot, exact);
  EXPECT_EQ(found.rank, 25 + 8 * 2);
  EXPECT_LT(summarize(evaluate(found.robot, exact).position).max, 1e-9);
  for (int s = 0; s < 3; ++s) {
    const Session& session = found.robot.sessions.at(name_of(s));
    EXPECT_NEAR(session.zero.at(1), truth.chain.links[1].theta + 1e-3 * s, 1e-9);
    EXPECT_NEAR(session.zero.at(4), truth.chain.links[4].theta - 1e-3 * s, 1e-9);
  }

  int inside = 0, all = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const Campaign campaign =
        measured(truth, {.seed = seed, .noise_mm = 0.095, .noise_mrad = 0.15, .remastered = 1e-3});
    const Session second = calibrate(robot, campaign).robot.sessions.at(name_of(1));
    for (int link : {1, 4}) {
      const double sign = link == 1 ? 1 : -1;
      const double error = second.zero.at(link) - truth.chain.links[link].theta - sign * 1e-3;
      const std::string name =
          parameter_name(truth.chain, link_parameter(link, LinkParameter::theta));
      inside += std::abs(error) <= 1.959964 * second.std.at(name);
      ++all;
    }
  }
  // Binomial(200, 0.95): 179 to 199 in all but one case of a thousand.
  std::printf("own zero offsets: %d of %d within their 95 %% intervals\n", inside, all);
  EXPECT_GE(inside, 179);
  EXPECT_LE(inside, 199);
}

TEST(Sessions, OwnZeroOffsetsAreKeptWhereTheRobotIsCarried) {
  Robot robot = shipped("kr360-spindle");
  robot.identify_per_session = {"A2.theta", "A5.theta"};
  Campaign campaign = measured(shipped("kr360-table4"), {.remastered = 1e-3});
  const Robot calibrated = calibrate(robot, campaign).robot;
  const Pose station{rotation_exp({0.3, -0.2, 1.1}), {0.8, -2.0, 0.4}};
  for (int row = 0; row < campaign.rows(); ++row) {
    campaign.position[row] = station * campaign.position[row];
    campaign.orientation[row] = Eigen::Quaterniond(station.rotation) * campaign.orientation[row];
  }
  const Robot carried = refit_set_up(calibrated, campaign, {"base", "tool"});
  EXPECT_LT(summarize(evaluate(carried, campaign).position).max, 1e-8);
  EXPECT_EQ(carried.identify_per_session, calibrated.identify_per_session);
}

TEST(Sessions, AZeroOffsetThatItsBaseImitatesIsAnError) {
  const Campaign campaign = measured(shipped("kr360-table4"), {});
  Robot robot = shipped("kr360-spindle");
  for (const char* name : {"A1.theta", "A2.d", "A9.theta", "tool.x"}) {
    robot.identify_per_session = {name};
    EXPECT_THROW(calibrate(robot, campaign), std::invalid_argument) << name;
  }
}

// A floor that gives way about one axis does so about that axis of the robot, wherever the
// instrument stands.
TEST(Sessions, AnEffectOnTheBaseActsAlongTheAxesOfTheRobot) {
  Robot robot = shipped("kr360-spindle");
  robot.effects = {
      {"floor compliance", "base.rx", {DriverKind::moment, -1, -1, ""}, {}, {{"c", 0, 0, {0, 0}}}}};
  Robot truth = shipped("kr360-table4");
  truth.bodies = robot.bodies;
  truth.effects = robot.effects;
  truth.effects[0].coefficients[0].value = 1e-7;
  SimulationOptions options;
  Campaign campaign = simulate(robot, truth, options);
  const Pose second_from_first = base_of(truth, 1) * inverse(truth.chain.base);
  campaign.session_names = {name_of(0), name_of(1)};
  for (int row = 0; row < campaign.rows(); ++row) {
    campaign.session.push_back(row % 2);
    if (row % 2 == 0) continue;
    campaign.position[row] = second_from_first * campaign.position[row];
    campaign.orientation[row] =
        Eigen::Quaterniond(second_from_first.rotation) * campaign.orientation[row];
  }
  // Moments are those of the nominal chain, 1e-3 off; along other axes it would be millimetres.
  const CalibrationResult result = calibrate(robot, campaign);
  EXPECT_NEAR(result.robot.effects[0].coefficients[0].value, 1e-7, 1e-10);
  EXPECT_LT(summarize(evaluate(result.robot, campaign).position).max, 1e-5);
}

// An instrument that is wrong by a scale is so about itself.
TEST(Sessions, TheScaleOfTheInstrumentIsAboutWhereItStands) {
  Robot robot = shipped("kr360-spindle");
  robot.effects = {{"warming instrument",
                    "instrument.scale",
                    {DriverKind::time, -1, -1, ""},
                    {},
                    {{"c", 0, 0, {0, 0}}}}};
  Robot truth = shipped("kr360-table4");
  truth.effects = robot.effects;
  truth.effects[0].coefficients[0].value = 1e-7;
  const Campaign campaign = measured(truth, {});
  const CalibrationResult result = calibrate(robot, campaign);
  EXPECT_NEAR(result.robot.effects[0].coefficients[0].value, 1e-7, 1e-13);
  EXPECT_LT(summarize(evaluate(result.robot, campaign).position).max, 1e-9);
}

TEST(Sessions, BeginWhereTheyAreToldTo) {
  Campaign campaign = measured(shipped("kr360-table4"), {.sessions = 1, .poses = 6});
  campaign.session.clear();
  begin_sessions(campaign, {campaign.time_s[4], campaign.time_s[2]});
  EXPECT_EQ(campaign.session, (std::vector<int>{0, 0, 1, 1, 2, 2}));
  EXPECT_EQ(campaign.session_names, (std::vector<std::string>{"1", "2", "3"}));
  begin_sessions(campaign, {campaign.time_s[3]});
  EXPECT_EQ(campaign.session, (std::vector<int>{0, 0, 1, 2, 3, 3}));
  EXPECT_EQ(campaign.session_names, (std::vector<std::string>{"1", "2", "2 (2)", "3 (2)"}));
}

TEST(Sessions, ArrivalIsTakenWithinThem) {
  Campaign campaign;
  campaign.session_names = {"a", "b"};
  for (const auto& [angle, session] : {std::pair{0.0, 0}, {5.0, 1}, {1.0, 0}, {4.0, 1}}) {
    campaign.q.push_back(JointVector::Constant(6, angle));
    campaign.session.push_back(session);
  }
  derive_arrival(campaign);
  std::vector<int> first_joint;
  for (const auto& arrival : campaign.arrival) first_joint.push_back(arrival[0]);
  EXPECT_EQ(first_joint, (std::vector<int>{0, 0, 1, -1}));
}

}  // namespace
}  // namespace armtrue::sessions_test
