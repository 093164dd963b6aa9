#include "armtrue/diagnosis/diagnosis.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/random.h"
#include "armtrue/statistics/summary.h"
#include "kinematics/six_axes.h"

namespace armtrue::diagnosis_test {
namespace {

Robot shipped(const std::string& name) {
  return read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
}

Eigen::Vector3d any_direction(Random& random) {
  return Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

Eigen::Matrix3d any_rotation(Random& random) {
  return rotation_exp(random.uniform(0, std::numbers::pi) * any_direction(random));
}

// An arm of real errors: zeros 0.3 deg, skew axes 0.05 deg, lengths 0.5 mm (one standard deviation
// each).
Robot real_arm(const Robot& nominal, Random& random) {
  Robot truth = nominal;
  for (int j = 0; j < kJoints; ++j) {
    Link& link = truth.chain.links[static_cast<size_t>(j)];
    link.theta += 5e-3 * random.normal();
    link.alpha += 1e-3 * random.normal();
    link.d += 0.5e-3 * random.normal();
    link.r += 0.5e-3 * random.normal();
  }
  return truth;
}

struct RightCampaign {
  Robot robot;  // the file's
  Campaign campaign;
};

// A campaign without a mistake: the instrument stands anywhere, and the tool is not the file's.
RightCampaign right_campaign(unsigned seed) {
  Random random(seed);
  const Robot nominal = shipped("kr360-spindle");
  Robot truth = real_arm(nominal, random);
  if (seed % 2 == 0) truth.effects = shipped("kr360-roughing").effects;
  truth.chain.base = {any_rotation(random), 4 * random.uniform(0, 1) * any_direction(random)};
  truth.chain.tool = {any_rotation(random), nominal.chain.tool.translation +
                                                random.uniform(0, 0.5) * any_direction(random)};
  SimulationOptions options;
  options.poses = static_cast<int>(random.uniform(10, 81));
  options.noise_position = random.uniform(0, 0.3e-3);
  options.noise_orientation = random.uniform(0, 0.5e-3);
  options.orientation = seed % 4 < 2;
  options.seed = seed;
  return {nominal, simulate(nominal, truth, options)};
}

// Whatever stands elsewhere than in the robot file, right data are not refused, and the calibration
// finds its way to them.
TEST(Diagnosis, CorrectDataAreNeverRefused) {
  int refused = 0, astray = 0, calibrated = 0;
  const int campaigns = 120;
  for (unsigned seed = 1; seed <= campaigns; ++seed) {
    const auto [robot, campaign] = right_campaign(seed);
    if (const auto findings = diagnose(robot, campaign); !findings.empty()) {
      ++refused;
      ADD_FAILURE() << "seed " << seed << ", " << campaign.rows() << " poses, orientations "
                    << campaign.has_orientation() << ": " << findings.front();
    }
    CalibrationResult result;
    try {
      result = calibrate(robot, campaign);
    } catch (const std::invalid_argument&) {
      continue;  // too few readings for so many parameters
    }
    ++calibrated;
    const double miss = median(evaluate(result.robot, campaign).position);
    if (miss < 2e-3) continue;
    ++astray;
    ADD_FAILURE() << "seed " << seed << ": still misses by " << 1e3 * miss << " mm";
  }
  std::printf("of %d campaigns %d refused; of %d calibrated %d astray\n", campaigns, refused,
              calibrated, astray);
  EXPECT_GT(calibrated, campaigns / 2);
}

// What is wrong is still named, with a tool that the robot file does not know either.
TEST(Diagnosis, MistakesAreNamedWhateverTheTool) {
  using Change = void (*)(Campaign&);
  const auto by_abc = [](Campaign& c, const Eigen::Vector3d& signs) {
    for (Eigen::Quaterniond& q : c.orientation) {
      const Eigen::Vector3d abc = abc_from_rotation(q.toRotationMatrix()).cwiseProduct(signs);
      q = Eigen::Quaterniond(rotation_from_abc(abc[0], abc[1], abc[2]));
    }
  };
  static const auto signs = by_abc;
  const std::vector<std::pair<std::string, Change>> mistakes = {
      {"left-handed",
       [](Campaign& c) {
         for (auto& p : c.position) p.y() = -p.y();
       }},
      {"left-handed",
       [](Campaign& c) {
         for (auto& p : c.position) std::swap(p.x(), p.y());
       }},
      {"metres",
       [](Campaign& c) {
         for (auto& p : c.position) p *= 1e-3;
       }},
      {"radians",
       [](Campaign& c) {
         for (auto q : c.q) q *= std::numbers::pi / 180;
       }},
      {"q2_deg and q3_deg look exchanged",
       [](Campaign& c) {
         for (auto q : c.q) std::swap(q[1], q[2]);
       }},
      {"joint 2 seems to count",
       [](Campaign& c) {
         for (auto q : c.q) q[1] = -q[1];
       }},
      {"joint 5 seems to count",
       [](Campaign& c) {
         for (auto q : c.q) q[4] = -q[4];
       }},
      {"turned the other way",
       [](Campaign& c) {
         for (auto& q : c.orientation) q = q.conjugate();
       }},
      {"b_deg seems",
       [](Campaign& c) {
         signs(c, {1, -1, 1});
       }},
  };
  for (unsigned k = 0; k < 24; ++k) {
    const auto& [name, make] = mistakes[k % mistakes.size()];
    RightCampaign given = right_campaign(4 * k + (k % 2 == 0 ? 4 : 5));
    if (given.campaign.rows() < 20) continue;
    make(given.campaign);
    const auto findings = diagnose(given.robot, given.campaign);
    ASSERT_FALSE(findings.empty()) << name << ", " << k;
    EXPECT_THAT(findings.front(), testing::HasSubstr(name)) << k;
  }
}

}  // namespace
}  // namespace armtrue::diagnosis_test
