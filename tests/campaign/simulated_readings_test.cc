// What simulate() reads of each kind, against an arm and things that KDL computes.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "imaging.h"
#include "oracle.h"
#include "support/temporary_file.h"

namespace armtrue {
namespace {

// Places in R_A, as KDL has them.
const KDL::Vector kPlate(1.9, 0.1, 0.6), kSocket(1.8, -0.3, 0.9), kBall(1.7, 0.4, 0.9),
    kAnchor(3.0, -1.0, 0.2), kLaser(0.05, -0.03, 0.08), kAlong(0.2, 0.1, 1);
const KDL::Rotation kPlateAxes = KDL::Rotation::RPY(10 * kDegree, 5 * kDegree, 0);
const KDL::Frame kEye(KDL::Rotation::RPY(6 * kDegree, -11 * kDegree, 17 * kDegree),
                      {0.05, -0.03, 0.08});
const KDL::Frame kGrid(KDL::Rotation::RPY(172 * kDegree, 6 * kDegree, 23 * kDegree),
                       {1.9, 0.2, 0.8});
constexpr double kRadius = 0.1;
constexpr const char* kThings = R"(contacts:
  plate: {kind: plane, x_mm: 1900, y_mm: 100, z_mm: 600, a_deg: 0, b_deg: 5, c_deg: 10}
  ball: {kind: sphere, x_mm: 1700, y_mm: 400, z_mm: 900, radius_mm: 100}
  socket: {kind: point, x_mm: 1800, y_mm: -300, z_mm: 900}
beams: {laser: {x_mm: 50, y_mm: -30, z_mm: 80, direction: [0.2, 0.1, 1], range_mm: [60, 260]}}
anchors: {"1": {x_mm: 3000, y_mm: -1000, z_mm: 200, zero_mm: 3}}
cameras: {eye: {on: arm, fx_px: 1200, fy_px: 1205, cx_px: 660, cy_px: 470, width_px: 1280, height_px: 960,
                x_mm: 50, y_mm: -30, z_mm: 80, a_deg: 17, b_deg: -11, c_deg: 6}}
boards: {grid: {on: cell, columns: 7, rows: 5, pitch_mm: 30,
                x_mm: 1900, y_mm: 200, z_mm: 800, a_deg: 23, b_deg: 6, c_deg: 172}}
)";

std::string robot_text() {
  std::ostringstream text;
  text << std::ifstream(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").rdbuf() << kThings;
  return text.str();
}

class SimulatedReadings : public testing::Test {
 protected:
  SimulatedReadings() : file_(robot_text()), robot_(read_robot(file_.path).robot) {}

  KDL::Frame measured(const Campaign& campaign, int row) const {
    std::array<double, 6> q;
    for (size_t j = 0; j < 6; ++j) q[j] = campaign.q[row][static_cast<Eigen::Index>(j)];
    return armtrue_oracle::forward(arm_, q);
  }
  Campaign read(const SimulationOptions& options) const {
    return simulate(robot_, robot_, options);
  }
  static std::string name(const Campaign& campaign, int row) {
    const int contact = campaign.touch[row].contact;
    return contact < 0 ? "" : campaign.contact_names[contact];
  }
  // How far a point is off the surface.
  static double off(const std::string& contact, const KDL::Vector& point) {
    if (contact == "plate") return (kPlateAxes.Inverse() * (point - kPlate)).z();
    if (contact == "ball") return (point - kBall).Norm() - kRadius;
    return (point - kSocket).Norm();
  }

  TemporaryFile file_;
  Robot robot_;
  armtrue_oracle::OracleArm arm_ =
      armtrue_oracle::read_arm(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml");
};

TEST_F(SimulatedReadings, TouchesAreOnTheirContactsFromOutside) {
  SimulationOptions options;
  options.touches = true;
  const Campaign exact = read(options);
  std::map<std::string, int> count;
  for (int row = 0; row < exact.rows(); ++row) {
    EXPECT_NEAR(off(name(exact, row), measured(exact, row).p), 0, 1e-9);
    ++count[name(exact, row)];
  }
  EXPECT_EQ(count.size(), 3u);
  options.noise_position = 1e-4;
  options.repeats = 20;
  const Campaign noisy = read(options);
  double squares = 0, plates = 0;
  for (int row = 0; row < noisy.rows(); ++row) {
    if (name(noisy, row) != "plate") continue;
    squares += std::pow(off("plate", measured(noisy, row).p), 2);
    ++plates;
  }
  EXPECT_NEAR(std::sqrt(squares / plates), 1e-4, 1e-5);
}

TEST_F(SimulatedReadings, ProfilesLieOnTheSurfacesThatTheScannerSees) {
  SimulationOptions options;
  options.profiles = Scanner{{0.08, 0.4}, 30 * kDegree};
  const Campaign campaign = read(options);
  std::map<std::string, int> count;
  for (int row = 0; row < campaign.rows(); ++row) {
    const ProfilePoint& at = campaign.profile[row];
    EXPECT_NEAR(off(name(campaign, row), measured(campaign, row) * KDL::Vector(0, at.y, at.z)), 0,
                1e-9);
    EXPECT_GE(at.z, 0.08);
    EXPECT_LE(at.z, 0.4);
    EXPECT_LE(std::abs(std::atan2(at.y, at.z)), 15.001 * kDegree);
    ++count[name(campaign, row)];
  }
  EXPECT_GT(count["plate"], 200);
  EXPECT_GT(count["ball"], 100);
}

// A tracker, a draw-wire, a laser, a camera and touches at once: each row reads what its columns
// say, and each kind reads.
TEST_F(SimulatedReadings, SeveralKindsReadAtTheSamePoses) {
  SimulationOptions options;
  options.points = options.distances = options.touches = options.beams = options.images = true;
  const Campaign campaign = read(options);
  const armtrue_oracle::Eye eye;
  std::map<std::string, int> count;
  for (int row = 0; row < campaign.rows(); ++row) {
    const KDL::Frame tool = measured(campaign, row);
    EXPECT_GT(campaign.sigma_position[row], 0);
    const std::string read_of = name(campaign, row);
    const Eigen::Vector3d& p = campaign.position[row];
    if (read_of.empty() && campaign.distance[row] > 0) {
      ++count["distance"];
      EXPECT_NEAR(campaign.distance[row], (tool.p - kAnchor).Norm() + 3e-3, 1e-9);
    } else if (read_of.empty()) {
      ++count["point"];
      EXPECT_LT((tool.p - KDL::Vector(p.x(), p.y(), p.z())).Norm(), 1e-9);
    } else if (campaign.touch[row].is_pixel) {
      ++count["pixel"];
      const int corner = std::stoi(PixelName(read_of).corner);
      const KDL::Vector on_board(0.03 * (corner % 7), 0.03 * (corner / 7), 0);
      const auto pixel = armtrue_oracle::pixel_of(eye, (tool * kEye).Inverse() * kGrid * on_board);
      EXPECT_LT(std::hypot(pixel[0] - p.x(), pixel[1] - p.y()), 1e-6);
    } else if (BeamName::is_one(read_of)) {
      ++count["beam"];
      const KDL::Vector end = kLaser + campaign.distance[row] * kAlong / kAlong.Norm();
      EXPECT_NEAR(off(BeamName(read_of).contact, tool * end), 0, 1e-9);
    } else {
      ++count["touch"];
      EXPECT_NEAR(off(read_of, tool.p), 0, 1e-9);
    }
  }
  EXPECT_EQ(count["point"], 60);
  EXPECT_EQ(count["distance"], 60);
  EXPECT_GE(count["touch"], 12);
  EXPECT_GE(count["beam"], 12);
  EXPECT_GE(count["pixel"], 12 * 35);
}

}  // namespace
}  // namespace armtrue
