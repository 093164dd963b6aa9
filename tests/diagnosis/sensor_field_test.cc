// Sensors that err by the place within them: scanners whose axes are not square, lenses that the
// model of a camera does not contain, boards that are bent. Arms that KDL simulates.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/diagnosis/mistakes.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/observation/observation.h"
#include "imaging.h"
#include "support/temporary_file.h"
#include "touching.h"

namespace armtrue::sensor_field_test {
namespace {

using armtrue_oracle::Dice;
using armtrue_oracle::Fixture;
using armtrue_oracle::OracleArm;
using testing::HasSubstr;
using testing::IsEmpty;
using Kind = Fixture::Kind;
using Bend = std::function<void(double&, double&)>;  // what a sensor makes of a place [m or px]

const std::string kArm = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
constexpr double kErrors = 3e-4;  // m, rad

const std::vector<Fixture> kPlates{{"a", Kind::plane, {1.9, 0.1, 0.6}, {0.2, 0.3, 1}},
                                   {"b", Kind::plane, {2.0, 0.0, 0.7}, {-1, 0.2, 0.1}},
                                   {"c", Kind::plane, {1.3, 1.2, 1.0}, {0.1, -1, 0.2}}};

struct Measured {
  Robot robot;
  Campaign campaign;
  Campaign points;  // what a tracker without noise reads of the true arm, at other poses
};

Robot robot_with(const std::string& lines) {
  std::ifstream file(kArm);
  std::ostringstream text;
  text << file.rdbuf() << lines;
  return read_robot(TemporaryFile(text.str()).path).robot;
}

Measured measured(const std::string& csv, const std::string& lines, const std::string& points) {
  Measured all{robot_with(lines), {}, {}};
  all.campaign = read_campaign(TemporaryFile(csv).path, all.robot.chain).campaign;
  bind_touches(all.campaign, all.robot.chain);
  all.points = read_campaign(TemporaryFile(points).path).campaign;
  return all;
}

std::vector<armtrue_oracle::TouchedPose> elsewhere(const OracleArm& arm, Dice& dice) {
  return armtrue_oracle::touch(
      arm, {{"p", Kind::point, {1.9, 0.2, 0.9}}, {"q", Kind::point, {1.5, 0.9, 1.1}}}, 40, 0, dice);
}

Measured profiles(unsigned seed, int poses, const Bend& bend) {
  Dice dice(seed);
  const OracleArm truth =
      armtrue_oracle::with_errors(armtrue_oracle::read_arm(kArm), kErrors, kErrors, -1, dice);
  const KDL::Frame sensor(KDL::Rotation::RPY(0.03, -0.02, 0.04), {0.004, -0.003, 0.005});
  auto read = armtrue_oracle::read_profiles(truth, sensor, kPlates, poses, 20, 3e-5, dice);
  for (auto& pose : read)
    for (auto& [y, z] : pose.points) bend(y, z);
  const std::string points = armtrue_oracle::points_csv(truth, elsewhere(truth, dice), 0, dice);
  return measured(armtrue_oracle::profiles_csv(read, kPlates),
                  "contacts: {a: {kind: plane}, b: {kind: plane}, c: {kind: plane}}\n", points);
}

// Changes the last two numbers of each line of a file.
std::string bent(const std::string& csv, const Bend& bend) {
  std::istringstream lines(csv);
  std::ostringstream all;
  all.precision(12);
  std::string line;
  std::getline(lines, line);
  all << line << '\n';
  while (std::getline(lines, line)) {
    const size_t v_at = line.rfind(','), u_at = line.rfind(',', v_at - 1);
    double u = std::stod(line.substr(u_at + 1)), v = std::stod(line.substr(v_at + 1));
    bend(u, v);
    all << line.substr(0, u_at) << ',' << u << ',' << v << '\n';
  }
  return all.str();
}

constexpr const char* kCamera =
    "cameras: {eye: {on: arm, fx_px: 1200, fy_px: 1200, cx_px: 640, cy_px: 480}}\n"
    "boards: {plate: {on: cell, pattern: \"checkerboard:7x5:30mm\"}}\n";

Measured images(unsigned seed, int poses, const Bend& bend, double sag = 0) {
  Dice dice(seed);
  const OracleArm truth =
      armtrue_oracle::with_errors(armtrue_oracle::read_arm(kArm), kErrors, kErrors, -1, dice);
  armtrue_oracle::Eye eye;
  eye.place = KDL::Frame(KDL::Rotation::RPY(0.3, -0.2, 0.1), {0.05, -0.03, 0.08});
  armtrue_oracle::Grid grid;
  grid.place = KDL::Frame(KDL::Rotation::RPY(0.1, 0.05, 3.0), {1.9, 0.2, 0.8});
  armtrue_oracle::ImagingPlan plan;
  plan.poses = poses;
  plan.noise_px = 0.2;
  const armtrue_oracle::HiddenEffect effect = [sag](const armtrue_oracle::Moment& moment,
                                                    OracleArm& arm) {
    arm.links[2].theta += sag * moment.torque[2];
  };
  const std::string csv =
      bent(armtrue_oracle::images_csv(truth, effect, eye, grid, plan, dice), bend);
  const std::string points = armtrue_oracle::points_csv(truth, elsewhere(truth, dice), 0, dice);
  return measured(csv, kCamera, points);
}

// A lens with a flaw: some pixels in one part of the image.
Bend bump(double pixels) {
  return [pixels](double& u, double& v) {
    const double x = (u - 896) / 256, y = (v - 352) / 256;
    const double g = pixels * std::exp(-(x * x + y * y) / 2);
    u += g;
    v += g / 2;
  };
}

void as_it_is(double&, double&) {}

// The mean error of the arm in mm, base and tool fitted to the true points.
double error_of(const Measured& of, const Robot& arm) {
  Robot placed = read_robot(kArm).robot;
  placed.chain.links = arm.chain.links;
  placed.identify = {"base", "tool"};
  const CalibrationResult fit = calibrate(placed, of.points);
  return 1e3 * summarize(evaluate(fit.robot, of.points).position).mean;
}

TEST(SensorField, AScannerWhoseAxesAreNotSquareIsNamedAndTakenOff) {
  for (const unsigned seed : {1, 2, 3}) {
    Measured of = profiles(seed, 60, [](double& y, double& z) { y += 0.005 * z; });
    const double nominal = error_of(of, of.robot);
    const double before = error_of(of, calibrate(of.robot, of.campaign).robot);
    const Findings found = find_mistakes(of.robot, of.campaign);
    ASSERT_FALSE(found.warnings.empty()) << seed;
    EXPECT_THAT(found.warnings.front(), HasSubstr("off a right angle by 0.2")) << seed;
    EXPECT_FALSE(found.sensor.is_left);
    found.sensor.take_off(of.campaign, of.robot.chain);
    const double after = error_of(of, calibrate(of.robot, of.campaign).robot);
    std::printf("nominal %.3f, before %.3f, after %.3f mm\n", nominal, before, after);
    EXPECT_LT(after, 0.5 * before) << seed;
    EXPECT_LT(after, nominal) << seed;
  }
}

TEST(SensorField, AScaleAlongTheLineOfAScannerIsNamed) {
  const Measured of = profiles(4, 60, [](double& y, double&) { y *= 1.01; });
  const SensorError error = find_sensor_error(of.robot, of.campaign);
  EXPECT_THAT(error.words, HasSubstr("% more than that of z"));
  ASSERT_EQ(error.fields.size(), 1);
  EXPECT_NEAR(error.fields[0].values[1] / error.fields[0].half.x(), 0.01, 1e-3);
}

TEST(SensorField, ALensThatTheModelLacksIsNamedAndTakenOff) {
  double before = 0, after = 0;
  for (const unsigned seed : {1, 3, 5}) {
    Measured of = images(seed, 40, bump(10));
    before += error_of(of, calibrate(of.robot, of.campaign).robot);
    const Findings found = find_mistakes(of.robot, of.campaign);
    ASSERT_FALSE(found.warnings.empty()) << seed;
    EXPECT_THAT(found.warnings.front(),
                HasSubstr("the residuals of camera 'eye' depend on where in the image"))
        << seed;
    found.sensor.take_off(of.campaign, of.robot.chain);
    after += error_of(of, calibrate(of.robot, of.campaign).robot);
  }
  std::printf("before %.3f, after %.3f mm\n", before / 3, after / 3);
  EXPECT_LT(after, 0.6 * before);
}

// A lens of the robot file that is another one is no flaw of the lens: the other one is named.
TEST(SensorField, TheOtherModelOfALensIsNamedIfItFits) {
  Dice dice(1);
  armtrue_oracle::Eye eye;
  eye.fisheye = true;
  eye.fx = eye.fy = 300;
  eye.place = KDL::Frame(KDL::Rotation::RPY(0.3, -0.2, 0.1), {0.05, -0.03, 0.08});
  armtrue_oracle::Grid grid;
  grid.place = KDL::Frame(KDL::Rotation::RPY(0.1, 0.05, 3.0), {1.9, 0.2, 0.8});
  armtrue_oracle::ImagingPlan plan;
  plan.noise_px = 0.1;
  plan.near = 0.07;
  plan.far = 0.2;
  const std::string csv =
      armtrue_oracle::images_csv(armtrue_oracle::read_arm(kArm), {}, eye, grid, plan, dice);
  Robot robot = robot_with(
      "cameras: {eye: {on: arm, fx_px: 300, fy_px: 300, cx_px: 640, cy_px: 480}}\n"
      "boards: {plate: {on: cell, pattern: \"checkerboard:7x5:30mm\"}}\n");
  Campaign campaign = read_campaign(TemporaryFile(csv).path, robot.chain).campaign;
  bind_touches(campaign, robot.chain);
  EXPECT_THAT(find_sensor_error(robot, campaign).words, HasSubstr("`lens: fisheye` fits"));
  robot.chain.contacts.front().lens = Lens::fisheye;
  EXPECT_THAT(find_sensor_error(robot, campaign).words, IsEmpty());
}

// Hand-eye alone with the lens of a data sheet: what its numbers err would stand in the place of
// the camera. Right ones are not suspected, though the arm errs.
TEST(SensorField, NumbersOfALensThatAreHeldAndWrongAreNamed) {
  for (const unsigned seed : {1, 2, 3}) {
    Measured of = images(300 + seed, 20, as_it_is, seed == 2 ? 2e-7 : 0);
    of.robot.identify = {"base", "tool"};
    const SensorError error = find_sensor_error(of.robot, of.campaign);
    EXPECT_THAT(error.words, HasSubstr("the lens of camera 'eye' is not that of the robot file"));
    EXPECT_THAT(error.words, HasSubstr("--identify \"base,tool,camera eye.*\""));
    EXPECT_TRUE(error.fields.empty());
    EXPECT_TRUE(error.is_left);
    of.robot.identify = {"base", "tool", "camera *"};
    EXPECT_THAT(find_sensor_error(of.robot, of.campaign).words, IsEmpty()) << seed;
    const armtrue_oracle::Eye eye;
    of.robot.chain.contacts.front().intrinsics.head<4>() << eye.fx, eye.fy, eye.cx, eye.cy;
    for (const auto& held : {std::vector<std::string>{"base", "tool"}, {"auto", "-camera *"}}) {
      of.robot.identify = held;
      EXPECT_THAT(find_sensor_error(of.robot, of.campaign).words, IsEmpty()) << seed;
    }
  }
}

// The points of a board of which one end is bent up: other points in the robot file show the same.
TEST(SensorField, ABoardThatIsBentIsNotTakenForALens) {
  Measured of = images(2, 40, as_it_is);
  for (Contact& contact : of.robot.chain.contacts)
    for (ArtefactPoint& point : contact.points) {
      const double x = (point.position.x() - 0.09) / 0.09;
      point.position.x() += 0.0005 * x * x;
    }
  const Findings found = find_mistakes(of.robot, of.campaign);
  EXPECT_THAT(found.sensor.words, HasSubstr("where on the board 'plate' a corner lies"));
  EXPECT_TRUE(found.sensor.fields.empty());
  EXPECT_THAT(found.wrong_readings, HasSubstr("where on the board"));
}

// Of 400 campaigns of profiles and 300 of images, with and without a sag, none was suspected.
TEST(SensorField, RightSensorsAreNotSuspected) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const Measured of = profiles(100 + seed, seed % 2 == 0 ? 30 : 60, as_it_is);
    EXPECT_THAT(find_sensor_error(of.robot, of.campaign).words, IsEmpty()) << seed;
  }
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Measured of = images(200 + seed, 20, as_it_is, seed % 2 == 0 ? 2e-7 : 0);
    EXPECT_THAT(find_sensor_error(of.robot, of.campaign).words, IsEmpty()) << seed;
  }
}

}  // namespace
}  // namespace armtrue::sensor_field_test
