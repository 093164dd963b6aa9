// Cameras by their images: projection and derivatives against others, what images show, and
// campaigns of an arm that KDL simulates before a camera of its own.

#include <ceres/jet.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/campaign/sights.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/contact.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/planning/planning.h"
#include "armtrue/statistics/distributions.h"
#include "imaging.h"
#include "kinematics/jet_chain.h"
#include "kinematics/six_axes.h"
#include "support/temporary_file.h"
#include "touching.h"

namespace armtrue::camera_test {
namespace {

using armtrue_oracle::Dice;
using armtrue_oracle::Eye;
using armtrue_oracle::Grid;
using armtrue_oracle::ImagingPlan;
using armtrue_oracle::OracleArm;

const std::string kArm = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
constexpr int kPinhole = 9, kFisheye = 8;  // numbers of a lens

struct Projection {
  Eigen::Vector3d point;
  Eigen::Vector2d pinhole, fisheye;
};

// cv2.projectPoints() and cv2.fisheye.projectPoints() of OpenCV 5.0.0.
const std::vector<Projection> kByOpenCv{
    {{0.11, -0.07, 0.6},
     {875.238041336972, 346.702921442034},
     {874.512818527365, 347.121211363359}},
    {{-0.23, 0.18, 0.45}, {62.530933931129, 943.015413812813}, {84.784650250377, 925.523843007303}},
    {{0.02, 0.31, 0.9}, {677.962274441000, 898.329760762799}, {677.778765895015, 893.782838482690}},
    {{-0.3, -0.2, 0.5}, {-29.814959120000, 39.875364360000}, {0.471509423859, 58.831408732146}},
    {{0, 0, 0.7}, {651.25, 487.5}, {651.25, 487.5}},
    {{0.4, 0.05, 0.62},
     {1391.548069412886, 579.543923309182},
     {1366.042332008448, 575.781485112121}},
};

Intrinsics intrinsics_of(Lens lens) {
  Intrinsics values = Intrinsics::Zero();
  values.head<4>() << 1234.5, 1219.75, 651.25, 487.5;
  if (lens == Lens::pinhole)
    values.tail<6>() << -0.21, 0.13, 0.0011, -0.0007, -0.05, 0;
  else
    values.tail<6>() << 0.04, -0.012, 0, 0, 0.006, -0.0015;
  return values;
}

TEST(Camera, ProjectsAsOpenCvDoes) {
  for (const Projection& known : kByOpenCv) {
    EXPECT_LT(
        (project(Lens::pinhole, intrinsics_of(Lens::pinhole), known.point).pixel - known.pinhole)
            .norm(),
        1e-9);
    EXPECT_LT(
        (project(Lens::fisheye, intrinsics_of(Lens::fisheye), known.point).pixel - known.fisheye)
            .norm(),
        1e-9);
  }
}

// A point behind the camera has no image, and no number that a reading could resemble.
TEST(Camera, PointsBehindItAreFarOutside) {
  const PixelReading behind =
      project(Lens::pinhole, intrinsics_of(Lens::pinhole), {0.1, 0.1, -0.5});
  EXPECT_TRUE(behind.pixel.allFinite() && behind.by_point.allFinite());
  EXPECT_GT(behind.pixel.norm(), 1e5);
}

// The lens once more, of any scalar.
template <typename T>
Eigen::Matrix<T, 2, 1> pixel_by(Lens lens, const Eigen::Matrix<T, kIntrinsics, 1>& k,
                                const Eigen::Matrix<T, 3, 1>& u) {
  using std::atan2;
  using std::sqrt;
  const T x = u[0] / u[2], y = u[1] / u[2], s = x * x + y * y;
  T a, b;
  if (lens == Lens::pinhole) {
    const T g = T(1) + k[kK1] * s + k[kK2] * s * s + k[kK3] * s * s * s;
    a = x * g + T(2) * k[kP1] * x * y + k[kP2] * (s + T(2) * x * x);
    b = y * g + k[kP1] * (s + T(2) * y * y) + T(2) * k[kP2] * x * y;
  } else {
    const T r = sqrt(s), t = atan2(r, T(1)), t2 = t * t;
    const T d = t + t * t2 * (k[kK1] + t2 * (k[kK2] + t2 * (k[kK3] + t2 * k[kK4])));
    a = x * d / r;
    b = y * d / r;
  }
  return {k[kFx] * a + k[kCx], k[kFy] * b + k[kCy]};
}

Contact camera_with(Lens lens, bool on_arm, const Pose& place) {
  Contact camera;
  camera.name = "eye";
  camera.kind = ContactKind::camera;
  camera.lens = lens;
  camera.on_arm = on_arm;
  camera.intrinsics = intrinsics_of(lens);
  camera.place = place;
  return camera;
}

Contact board_with(bool on_arm, const Pose& place, const Grid& grid = {}) {
  Contact board;
  board.name = "plate";
  board.kind = ContactKind::board;
  board.on_arm = on_arm;
  board.place = place;
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column)
      board.points.push_back(
          {std::to_string(board.points.size()), Eigen::Vector3d(column, row, 0) * grid.pitch});
  return board;
}

Campaign read(const std::string& text, const Robot& robot) {
  Campaign campaign = read_campaign(TemporaryFile(text).path).campaign;
  bind_touches(campaign, robot.chain);
  return campaign;
}

// All derivatives of a pixel, those by the arm, the places and the lens, against automatic ones.
TEST(Camera, JacobianEqualsAutomaticDerivatives) {
  constexpr int kOfChain = kGeometricParameters, kOfContacts = 6 + kIntrinsics + 6;
  constexpr int kAll = kOfChain + kOfContacts;
  using Jet = ceres::Jet<double, kAll>;
  using Frame = armtrue_oracle::Transform<Jet>;
  for (const Lens lens : {Lens::pinhole, Lens::fisheye})
    for (const bool on_arm : {true, false}) {
      Robot robot = read_robot(kArm).robot;
      robot.chain.base = {rotation_exp({0.3, -0.2, 0.9}), {0.4, -0.3, 0.2}};
      const JointVector q =
          Eigen::VectorXd(Eigen::Vector<double, 6>(0.2, -0.9, 1.6, 0.4, 0.5, 0.7));
      const Pose measured = ChainEvaluator(robot.chain).pose(q);
      const Pose mount{rotation_exp({0.2, 0.4, -0.3}), {0.05, 0.02, 0.1}};
      const Pose view{rotation_exp({0.3, -0.4, 0.8}), {-0.04, -0.06, 0.6}};  // camera from board
      robot.chain.contacts =
          on_arm ? std::vector{camera_with(lens, true, mount),
                               board_with(false, measured * mount * view)}
                 : std::vector{camera_with(lens, false, measured * mount * inverse(view)),
                               board_with(true, mount)};
      std::string text = "pose,q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,q6_rad,corner,u_px,v_px\n";
      for (int corner : {0, 6, 17, 30, 34})
        text += "1,0.2,-0.9,1.6,0.4,0.5,0.7," + std::to_string(corner) + "," +
                std::to_string(600 + 11 * corner) + "," + std::to_string(700 - 7 * corner) + "\n";
      const Campaign campaign = read(text, robot);
      ASSERT_EQ(campaign.rows(), 10);
      const int first = first_contact_parameter(robot.chain);
      std::vector<int> parameters;
      for (int k = 0; k < kOfChain; ++k) parameters.push_back(k);
      for (int k = 0; k < 6; ++k) parameters.push_back(first + k);
      for (int k = 0; k < kIntrinsics; ++k) parameters.push_back(first + kFirstIntrinsic + k);
      for (int k = 0; k < 6; ++k) parameters.push_back(first + kParametersOfContact + k);
      const ObservationModel model(campaign, robot, parameters, {1.0, 1.0});
      const auto at = model.at(Eigen::VectorXd::Zero(kAll));
      Eigen::MatrixXd block(1, kAll + 1);

      const auto jets = jet_parameters<kAll>(robot.chain);
      const Frame arm = jet_frame<kAll>(robot.chain, jets, q);
      const auto moved = [&](const Contact& contact, int from) {
        Frame own =
            homogeneous(contact.place).cast<Jet>() *
            armtrue_oracle::shift<Jet>(Jet(0.0, from), Jet(0.0, from + 1), Jet(0.0, from + 2)) *
            armtrue_oracle::turn<Jet>(0, Jet(0.0, from + 3)) *
            armtrue_oracle::turn<Jet>(1, Jet(0.0, from + 4)) *
            armtrue_oracle::turn<Jet>(2, Jet(0.0, from + 5));
        return contact.on_arm ? Frame(arm * own) : own;
      };
      const Frame camera = moved(robot.chain.contacts[0], kOfChain);
      const Frame board = moved(robot.chain.contacts[1], kOfChain + 6 + kIntrinsics);
      Eigen::Matrix<Jet, kIntrinsics, 1> numbers;
      for (int k = 0; k < kIntrinsics; ++k)
        numbers[k] = Jet(robot.chain.contacts[0].intrinsics[k], kOfChain + 6 + k);
      for (int row = 0; row < campaign.rows(); ++row) {
        at.block(row, block);
        const int corner =
            std::stoi(campaign.contact_names[campaign.touch[row].contact].substr(2));  // of "//7"
        Eigen::Matrix<Jet, 4, 1> point;
        point << robot.chain.contacts[1].points[corner].position.cast<Jet>(), Jet(1.0);
        const Eigen::Matrix<Jet, 3, 1> in_a = (board * point).template head<3>();
        const Eigen::Matrix<Jet, 3, 1> from = in_a - camera.template topRightCorner<3, 1>();
        const Eigen::Matrix<Jet, 3, 1> seen =
            camera.template topLeftCorner<3, 3>().transpose() * from;
        ASSERT_GT(seen[2].a, 0.1);
        const Jet pixel = pixel_by<Jet>(lens, numbers, seen)[campaign.touch[row].axis];
        const double length = campaign.metre_per_pixel;
        EXPECT_NEAR(at.residual(row)[0], campaign.distance[row] - length * pixel.a, 1e-12);
        for (int k = 0; k < kAll; ++k)
          EXPECT_NEAR(block(0, k), length * pixel.v[k],
                      1e-9 * std::max(1.0, std::abs(length * pixel.v[k])))
              << parameter_name(robot.chain, parameters[k]) << " row " << row;
      }
    }
}

// A cell: camera and board in true places, which no robot file knows.
struct Cell {
  Eye eye;
  Grid grid;
};

Cell cell_with(bool on_arm, bool fisheye = false) {
  Cell cell;
  cell.eye.on_arm = on_arm;
  cell.eye.fisheye = fisheye;
  cell.eye.distortion = fisheye ? std::array<double, 5>{0.03, -0.01, 0.004, -0.001, 0}
                                : std::array<double, 5>{-0.12, 0.08, 0.0007, -0.0004, 0.01};
  const KDL::Frame mount(KDL::Rotation::RPY(0.1, -0.2, 0.3), {0.05, -0.03, 0.08});
  const KDL::Frame rest(
      on_arm ? KDL::Rotation::RPY(3.0, 0.1, 0.4) : KDL::Rotation::RPY(-2.2, 0.1, 1.4),
      {1.9, 0.2, 0.8});
  (on_arm ? cell.eye.place : cell.grid.place) = mount;
  (on_arm ? cell.grid.place : cell.eye.place) = rest;
  return cell;
}

// The nominal robot, with a data sheet's numbers of the camera: its focal length is 4 % off.
Robot robot_for(const Cell& cell) {
  Robot robot = read_robot(kArm).robot;
  Contact camera =
      camera_with(cell.eye.fisheye ? Lens::fisheye : Lens::pinhole, cell.eye.on_arm, {});
  camera.intrinsics.setZero();
  camera.intrinsics.head<4>() << 1250, 1250, 640, 480;
  robot.chain.contacts = {camera, board_with(!cell.eye.on_arm, {}, cell.grid)};
  for (Contact& contact : robot.chain.contacts) contact.is_placed = false;
  return robot;
}

Campaign images(const Cell& cell, const OracleArm& arm, const Robot& robot, const ImagingPlan& plan,
                Dice& dice) {
  return read(armtrue_oracle::images_csv(arm, {}, cell.eye, cell.grid, plan, dice), robot);
}

// An image shows where the board is before the camera, six numbers, and so all that poses show of
// an arm of n axes with foot and tool: 4 n + 6 (Schroer 1993); six of them are the place of the
// thing at rest, six that of the one on the arm, which absorb base and tool. The pitch of the board
// shows the scale. The lens adds its own numbers, of which a motion imitates none.
TEST(Camera, RanksOfImages) {
  for (const bool on_arm : {true, false})
    for (const bool fisheye : {true, false}) {
      const Cell cell = cell_with(on_arm, fisheye);
      const Robot robot = robot_for(cell);
      Dice dice(5);
      const IdentifiableSet set = choose_identifiable(
          robot, images(cell, armtrue_oracle::read_arm(kArm), robot, {.noise_px = 0}, dice));
      EXPECT_EQ(set.kept.size(), 4u * 6 + 6 + (fisheye ? kFisheye : kPinhole));
      for (int k = 0; k < 6; ++k) {
        EXPECT_THAT(set.kept, testing::Not(testing::Contains(kFirstBaseParameter + k)));
        EXPECT_THAT(set.kept, testing::Not(testing::Contains(kFirstToolParameter + k)));
      }
    }
}

struct Study {
  double squares = 0, bound = 0;
  int inside = 0, intervals = 0, lens_inside = 0, lens_intervals = 0;
};

// What the arm's calibration leaves of exact fresh images, in metres at the board, the places of
// camera and board and the lens fitted to them.
double left_of(const Robot& fitted, const Campaign& fresh) {
  const Robot placed = refit_set_up(fitted, fresh, {"base", "tool", "camera *"});
  return summarize(evaluate(placed, fresh).position).rms;
}

void add_campaign(const Cell& cell, unsigned seed, const ImagingPlan& plan, Study& study) {
  constexpr double kErrors = 3e-4;  // m, rad
  Dice dice(seed);
  const OracleArm truth =
      armtrue_oracle::with_errors(armtrue_oracle::read_arm(kArm), kErrors, kErrors, -1, dice);
  Robot robot = robot_for(cell);
  robot.noise.pixel = plan.noise_px;
  const Campaign campaign = images(cell, truth, robot, plan, dice);
  ImagingPlan exact = plan;
  exact.noise_px = exact.wrong_ids = 0;
  exact.poses = 30;
  Campaign fresh = images(cell, truth, robot, exact, dice);
  const CalibrationResult fit = calibrate(robot, campaign);
  study.squares += std::pow(left_of(fit.robot, fresh), 2);
  // The bound: the same poses with as much noise and no wrong ids, by least squares from the truth.
  Robot free = robot;
  free.free_links = true;
  CalibrationResult known = calibrate(free, fresh, fit.set);
  ImagingPlan clean = plan;
  clean.wrong_ids = 0;
  const Campaign sound = images(cell, truth, robot, clean, dice);
  study.bound +=
      std::pow(left_of(calibrate(robot, sound, fit.set, {.robust = false}).robot, fresh), 2);
  const double wide = student_t_975(plan.poses - 1);
  for (size_t i = 0; i < fit.set.kept.size(); ++i) {
    const int parameter = fit.set.kept[i];
    const Parameter named = parameter_of(robot.chain, parameter);
    const auto k = static_cast<Eigen::Index>(i);
    const double deviation = std::sqrt(fit.covariance(k, k));
    if (named.owner == Owner::camera && named.component >= kFirstIntrinsic) {
      const double value =
          fit.robot.chain.contacts[0].intrinsics[named.component - kFirstIntrinsic];
      const double true_value =
          known.robot.chain.contacts[0].intrinsics[named.component - kFirstIntrinsic];
      study.lens_inside += std::abs(value - true_value) <= wide * deviation;
      ++study.lens_intervals;
    } else if (named.owner == Owner::link) {
      const auto change = parameter_change(known.robot.chain, fit.robot.chain, parameter);
      study.inside += std::abs(*change) <= wide * deviation;
      ++study.intervals;
    }
  }
}

// Forty poses, corners off by 0.1 to 0.5 px, one in twenty under the id of another; links off by
// 0.3 mm and 0.3 mrad, nothing known of where camera and board are, and a focal length of a data
// sheet. Two campaigns of each kind on boards of 7 by 5 corners were at 1.12 and 1.14 of the bound
// with the camera on the arm, at 0.66 and 0.78 with the camera at rest, and covered 93.8 % of the
// links (144 intervals) and 97.2 % of the lens (72).
TEST(Camera, ArmAndLensAreAsGoodAsTheImages) {
  int inside = 0, intervals = 0, lens_inside = 0, lens_intervals = 0;
  for (const bool on_arm : {true, false})
    for (const double noise : {0.1, 0.5}) {
      Cell cell = cell_with(on_arm);
      cell.grid.columns = 5;
      cell.grid.rows = 4;
      Study study;
      add_campaign(cell, on_arm ? 1 : 2, {.noise_px = noise, .wrong_ids = 0.05}, study);
      const double ratio = std::sqrt(study.squares / study.bound);
      std::printf("camera %s, %.1f px: arm %.4f mm, %.2f of the bound\n",
                  on_arm ? "on the arm" : "at rest", noise, 1e3 * std::sqrt(study.squares), ratio);
      EXPECT_LT(ratio, 1.5);
      inside += study.inside;
      intervals += study.intervals;
      lens_inside += study.lens_inside;
      lens_intervals += study.lens_intervals;
    }
  const double coverage = static_cast<double>(inside) / intervals;
  const double of_lens = static_cast<double>(lens_inside) / lens_intervals;
  std::printf("coverage %.3f, of the lens %.3f\n", coverage, of_lens);
  EXPECT_GT(coverage, 0.85);
  EXPECT_GT(of_lens, 0.85);
}

// The campaigns of two cells as one file: poses of the second are numbered on.
std::string together(const std::string& a, const std::string& b) {
  std::string all = a;
  size_t begin = b.find('\n') + 1;
  for (size_t end; begin < b.size(); begin = end + 1) {
    end = b.find('\n', begin);
    all += "b" + b.substr(begin, end - begin) + "\n";
  }
  return all;
}

double distance_of(const Pose& pose, const KDL::Frame& truth) {
  return (pose.translation - Eigen::Vector3d(truth.p.x(), truth.p.y(), truth.p.z())).norm();
}

// A camera on the arm before a board in the cell, and a camera in the cell before a board on the
// arm, in one file. Lens and arm belong to both; the places of base and tool to the robot file.
TEST(Camera, OneOnTheArmAndOneAtRestInOneCampaign) {
  Cell moved = cell_with(true), fixed = cell_with(false);
  moved.eye.name = "wrist";
  moved.grid.name = "table";
  fixed.eye.name = "ceiling";
  fixed.grid.name = "flange";
  fixed.eye.fx = 1400;
  fixed.eye.fy = 1402;
  for (Cell* cell : {&moved, &fixed}) {
    cell->grid.columns = 5;
    cell->grid.rows = 4;
  }
  constexpr double kErrors = 3e-4;  // m, rad
  Dice dice(11);
  const OracleArm truth =
      armtrue_oracle::with_errors(armtrue_oracle::read_arm(kArm), kErrors, kErrors, -1, dice);
  Robot robot = robot_for(moved);
  for (Contact contact : robot_for(fixed).chain.contacts) {
    contact.name = contact.kind == ContactKind::camera ? "ceiling" : "flange";
    robot.chain.contacts.push_back(contact);
  }
  robot.chain.contacts[0].name = "wrist";
  robot.chain.contacts[1].name = "table";
  robot.chain.contacts[2].intrinsics.head<2>() << 1450, 1450;
  robot.noise.pixel = 0.2;
  const auto campaign_of = [&](const ImagingPlan& plan) {
    return read(together(images_csv(truth, {}, moved.eye, moved.grid, plan, dice),
                         images_csv(truth, {}, fixed.eye, fixed.grid, plan, dice)),
                robot);
  };
  const Campaign campaign = campaign_of({.poses = 25, .noise_px = 0.2});
  const Campaign fresh = campaign_of({.poses = 12, .noise_px = 0});
  const CalibrationResult fit = calibrate(robot, campaign);
  EXPECT_TRUE(fit.converged);
  // 4 n + 6 of an arm that both see, 6 more of the second pair, and two lenses.
  EXPECT_EQ(fit.set.kept.size(), 4u * 6 + 6 + 12 + 2 * kPinhole);
  const double left = summarize(evaluate(fit.robot, fresh).position).rms;
  std::printf("two cameras: exact other images are missed by %.3f px\n",
              left / fresh.metre_per_pixel);
  EXPECT_LT(left / fresh.metre_per_pixel, 0.15);
  EXPECT_NEAR(fit.robot.chain.contacts[0].intrinsics[kFx], moved.eye.fx, 3);
  EXPECT_NEAR(fit.robot.chain.contacts[2].intrinsics[kFx], fixed.eye.fx, 3);
}

// A tracker's readings of a reflector on the tool, which no camera looks at.
const KDL::Vector kBall(0.12, -0.04, 0.06);  // m

constexpr const char* kBothColumns =
    "pose,repeat,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,camera,board,corner,u_px,v_px,sigma_px,"
    "target,x_mm,y_mm,z_mm,sigma_mm\n";

// Rows of kBothColumns at random configurations; the points are off by `noise` [m] per axis.
std::string tracked(const OracleArm& arm, int poses, double noise, Dice& dice) {
  std::string text;
  for (int pose = 1; pose <= poses; ++pose) {
    std::array<double, 6> q{};
    text += "t" + std::to_string(pose) + ",1";
    for (size_t j = 0; j < q.size(); ++j) {
      q[j] = 0.9 * dice.uniform(arm.links[j].min, arm.links[j].max);
      text += "," + fmt::format("{:.12g}", q[j] * 180 / std::numbers::pi);
    }
    const KDL::Vector point = forward(arm, q) * kBall;
    text += ",,,,,,,ball";
    for (int i = 0; i < 3; ++i)
      text += fmt::format(",{:.12g}", 1e3 * (point[i] + noise * dice.normal()));
    text += fmt::format(",{}\n", 1e3 * std::max(noise, 1e-6));
  }
  return text;
}

// The same of images.
std::string seen(const std::string& images, double noise_px) {
  std::string text;
  for (size_t begin = images.find('\n') + 1, end = 0; begin < images.size(); begin = end + 1) {
    end = images.find('\n', begin);
    text += images.substr(begin, end - begin) + fmt::format(",{},,,,,\n", std::max(noise_px, 1e-3));
  }
  return text;
}

// What a calibration leaves of exact readings of a tracker, base and tool fitted to them [m].
double left_of_points(const Robot& fitted, const Campaign& points) {
  return summarize(evaluate(refit_set_up(fitted, points, {"base", "tool"}), points).position).rms;
}

// Thirty poses before a camera on the arm and twenty others before a tracker, in one file; links
// off by 0.3 mm and 0.3 mrad. Both together find the arm better than each alone: 0.040 mm, where
// points leave 0.054 mm, and images, which look at a small part of the travel, 1.2 mm. Their
// intervals hold 53 of 54 links.
TEST(Camera, ImagesAndATrackerInOneCampaign) {
  constexpr double kErrors = 3e-4, kNoise = 5e-5, kPixel = 0.2;  // m, rad; m; px
  Cell cell = cell_with(true);
  cell.grid.columns = 5;
  cell.grid.rows = 4;
  double of_images = 0, of_points = 0, of_both = 0;
  int inside = 0, intervals = 0;
  for (const unsigned seed : {21u, 22u, 23u}) {
    Dice dice(seed);
    const OracleArm truth =
        armtrue_oracle::with_errors(armtrue_oracle::read_arm(kArm), kErrors, kErrors, -1, dice);
    Robot robot = robot_for(cell);
    robot.chain.targets = {{"ball", {kBall.x(), kBall.y(), kBall.z()}}};
    const auto pixels = [&](const ImagingPlan& plan) {
      return seen(images_csv(truth, {}, cell.eye, cell.grid, plan, dice), plan.noise_px);
    };
    const std::string images = pixels({.poses = 30, .noise_px = kPixel});
    const std::string points = tracked(truth, 20, kNoise, dice);
    const Campaign fresh = read(kBothColumns + tracked(truth, 60, 0, dice), robot);
    const Campaign both = read(kBothColumns + points + images, robot);
    ASSERT_EQ(both.rows(), 20 * 3 + 30 * 20 * 2);
    EXPECT_TRUE(both.has_pixels() && !both.has_pixels_only());

    const CalibrationResult fit = calibrate(robot, both);
    const auto squared = [&](const CalibrationResult& of) {
      return std::pow(left_of_points(of.robot, fresh), 2);
    };
    of_both += squared(fit);
    of_images += squared(calibrate(robot, read(kBothColumns + images, robot)));
    of_points += squared(calibrate(robot, read(kBothColumns + points, robot)));

    const Evaluation evaluation = evaluate(fit.robot, both);
    const double of_all = (20 * mean_error_of_noise(kNoise, 3) +
                           600 * mean_error_of_noise(kPixel * both.metre_per_pixel, 2)) /
                          620;
    EXPECT_NEAR(mean_error(noise_floor(fit.robot, both, evaluation), both), of_all, 1e-12);
    const std::vector<KindErrors> kinds = errors_by_kind(evaluation, both);
    ASSERT_EQ(kinds.size(), 2u);
    EXPECT_EQ(kinds[0].errors.size(), 20u);         // points
    const double of_noise = std::sqrt(3) * kNoise;  // the unknowns take up to half of it
    EXPECT_LT(summarize(kinds[0].errors).rms, 1.1 * of_noise);
    EXPECT_GT(summarize(kinds[0].errors).rms, 0.5 * of_noise);
    EXPECT_EQ(kinds[1].errors.size(), 600u);
    EXPECT_NEAR(summarize(kinds[1].errors).rms / both.metre_per_pixel, std::sqrt(2) * kPixel,
                0.1 * kPixel);

    Robot free = robot;
    free.free_links = true;
    const Campaign exact = read(
        kBothColumns + tracked(truth, 60, 0, dice) + pixels({.poses = 30, .noise_px = 0}), robot);
    const Robot known = calibrate(free, exact, fit.set).robot;
    const double wide = student_t_975(50 - 1);
    for (size_t k = 0; k < fit.set.kept.size(); ++k) {
      if (parameter_of(robot.chain, fit.set.kept[k]).owner != Owner::link) continue;
      const auto change = parameter_change(known.chain, fit.robot.chain, fit.set.kept[k]);
      const auto place = static_cast<Eigen::Index>(k);
      inside += std::abs(*change) <= wide * std::sqrt(fit.covariance(place, place));
      ++intervals;
    }
  }
  std::printf("arm by images %.4f mm, by points %.4f mm, by both %.4f mm; coverage %d of %d\n",
              1e3 * std::sqrt(of_images / 3), 1e3 * std::sqrt(of_points / 3),
              1e3 * std::sqrt(of_both / 3), inside, intervals);
  EXPECT_LT(of_both, 0.8 * of_points);
  EXPECT_LT(of_both, 0.8 * of_images);
  EXPECT_GT(inside, 0.85 * intervals);
}

// What simulate() makes of a robot against the simulator of tests/support: the same pixels, and no
// corner that its camera has not in the image.
TEST(Camera, SimulatedPixelsAreThoseOfTheOracle) {
  for (const bool on_arm : {true, false}) {
    const Cell cell = cell_with(on_arm, !on_arm);
    Robot robot = robot_for(cell);
    const auto place = [](const KDL::Frame& frame) {
      Pose pose;
      for (int i = 0; i < 3; ++i) {
        pose.translation[i] = frame.p[i];
        for (int j = 0; j < 3; ++j) pose.rotation(i, j) = frame.M(i, j);
      }
      return pose;
    };
    Contact &camera = robot.chain.contacts[0], &board = robot.chain.contacts[1];
    camera.place = place(cell.eye.place);
    board.place = place(cell.grid.place);
    camera.is_placed = board.is_placed = true;
    camera.intrinsics.setZero();
    camera.intrinsics.head<4>() << cell.eye.fx, cell.eye.fy, cell.eye.cx, cell.eye.cy;
    const auto& k = cell.eye.distortion;
    if (cell.eye.fisheye)
      camera.intrinsics.tail<6>() << k[0], k[1], 0, 0, k[2], k[3];
    else
      camera.intrinsics.tail<6>() << k[0], k[1], k[2], k[3], k[4], 0;
    camera.image_size = {cell.eye.width, cell.eye.height};
    const OracleArm arm = armtrue_oracle::read_arm(kArm);
    // Sighted poses show the whole board; a turn of some tens of degrees moves parts of it out of
    // the image.
    std::vector<JointVector> commanded;
    for (const PlannedPose& pose :
         random_sighted_poses(robot.chain, {sights_of_boards(robot.chain)}, 20, 3)) {
      commanded.push_back(pose.q);
      commanded.push_back(pose.q);
      commanded.back()[4] += 0.5;
    }
    SimulationOptions options;
    options.images = true;
    const Campaign campaign = simulate(commanded, robot, options);
    std::vector<std::vector<bool>> is_seen(commanded.size(), std::vector<bool>(35, false));
    for (int row = 0; row < campaign.rows(); ++row) {
      const PixelName name(campaign.contact_names[campaign.touch[row].contact]);
      const int corner = std::stoi(name.corner);
      const int pose = std::stoi(campaign.pose_ids[campaign.pose[row]]) - 1;
      is_seen[pose][corner] = true;
    }
    int seen_of_all = 0, seen_of_turned = 0;
    for (size_t pose = 0; pose < commanded.size(); ++pose) {
      std::array<double, 6> q{};
      for (int j = 0; j < 6; ++j) q[j] = commanded[pose][j];
      const KDL::Frame measured = forward(arm, q);
      const KDL::Frame seen = on_arm ? (measured * cell.eye.place).Inverse() * cell.grid.place
                                     : cell.eye.place.Inverse() * measured * cell.grid.place;
      for (int corner = 0; corner < 35; ++corner) {
        const KDL::Vector point = seen * KDL::Vector(0.03 * (corner % 7), 0.03 * (corner / 7), 0);
        const auto [u, v] = pixel_of(cell.eye, point);
        const bool is_inside = point.z() > 0.05 && u >= 0 && v >= 0 && u <= cell.eye.width - 1 &&
                               v <= cell.eye.height - 1;
        EXPECT_EQ(is_seen[pose][corner], is_inside) << u << " " << v << " " << point.z();
        (pose % 2 ? seen_of_turned : seen_of_all) += is_inside;
      }
    }
    EXPECT_EQ(seen_of_all, 20 * 35);
    EXPECT_GT(seen_of_turned, 50);
    EXPECT_LT(seen_of_turned, 20 * 35 - 50);
    for (int row = 0; row < campaign.rows(); ++row) {
      const PixelName name(campaign.contact_names[campaign.touch[row].contact]);
      std::array<double, 6> q{};
      for (int j = 0; j < 6; ++j) q[j] = campaign.q[row][j];
      const KDL::Frame measured = forward(arm, q);
      const KDL::Frame seen = on_arm ? (measured * cell.eye.place).Inverse() * cell.grid.place
                                     : cell.eye.place.Inverse() * measured * cell.grid.place;
      const int corner = std::stoi(name.corner);
      const auto [u, v] =
          pixel_of(cell.eye, seen * KDL::Vector(0.03 * (corner % 7), 0.03 * (corner / 7), 0));
      EXPECT_NEAR(campaign.position[row].x(), u, 1e-6);
      EXPECT_NEAR(campaign.position[row].y(), v, 1e-6);
    }
  }
}

// Where a lens turns back, what lies far outside would come in again.
TEST(Camera, WhatALensCannotBendIsNotInTheImage) {
  Contact camera = camera_with(Lens::pinhole, true, {});
  camera.intrinsics << 1000, 1000, 640, 480, -0.3, 0, 0, 0, 0, 0;
  EXPECT_TRUE(is_in_image(camera, {0.2, 0.1, 0.5}, 0));
  EXPECT_FALSE(is_in_image(camera, {0.84, 0, 0.5}, 0));  // at x = 640 + 1000 * 1.68 (1 - 0.85)
  EXPECT_FALSE(is_in_image(camera, {0.1, 0.1, -0.5}, 0));
}

// Planned poses show all corners, under the oracle's camera too.
TEST(Camera, PlannedPosesShowTheWholeBoard) {
  const Cell cell = cell_with(true);
  Robot robot = robot_for(cell);
  Dice dice(13);
  const Campaign given =
      images(cell, armtrue_oracle::read_arm(kArm), robot, {.poses = 12, .noise_px = 0.1}, dice);
  robot.chain = calibrate(robot, given).robot.chain;
  robot.chain.contacts[0].image_size = {cell.eye.width, cell.eye.height};
  PlanOptions options;
  options.images = true;
  const PosePlanner planner(robot, options);
  const std::vector<PlannedPose> planned = planner.plan(15);
  ASSERT_EQ(planned.size(), 15u);
  const OracleArm arm = armtrue_oracle::read_arm(kArm);
  for (const PlannedPose& pose : planned) {
    std::array<double, 6> q{};
    for (int j = 0; j < 6; ++j) q[j] = pose.q[j];
    const KDL::Frame seen = (forward(arm, q) * cell.eye.place).Inverse() * cell.grid.place;
    for (int corner = 0; corner < 35; ++corner) {
      const KDL::Vector point = seen * KDL::Vector(0.03 * (corner % 7), 0.03 * (corner / 7), 0);
      const auto [u, v] = pixel_of(cell.eye, point);
      EXPECT_TRUE(point.z() > 0 && u > 0 && v > 0 && u < cell.eye.width && v < cell.eye.height);
    }
  }
  EXPECT_LT(planner.quality(planned).cloud_deviation,
            planner.quality(planner.random(15, 5)).cloud_deviation);
}

}  // namespace
}  // namespace armtrue::camera_test
