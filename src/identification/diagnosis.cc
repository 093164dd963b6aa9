#include "armtrue/identification/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "armtrue/effects/robot_model.h"
#include "armtrue/identification/evaluation.h"
#include "armtrue/identification/statistics.h"
#include "registration.h"
#include "sessions.h"

namespace armtrue {
namespace {

constexpr double kImplausibleMiss =
    0.02;  // m, median with the base registered: no calibration error
constexpr double kImplausibleTurn = 0.1;  // rad
constexpr double kMuchBetter = 0.1;
constexpr int kRowsLookedAt = 500;

double median_miss(Robot robot, const Campaign& campaign) {
  robot.effects.clear();
  robot.chain.base = registered_base(robot, campaign);
  return median(evaluate(robot, campaign).position);
}

// How far the turns of tool and base that the orientations ask for differ from pose to pose.
double median_turn(Robot robot, const Campaign& campaign) {
  robot.effects.clear();
  robot.chain.base = registered_base(robot, campaign);
  const RobotModel model(robot);
  // The tool's own turn is unknown: take it from each reading, compare with the first ones.
  std::vector<Eigen::Quaterniond> turns;
  for (int row = 0; row < campaign.rows(); ++row)
    turns.emplace_back(model.pose(campaign.context(row)).rotation.transpose() *
                       campaign.orientation[row].toRotationMatrix());
  double best = std::numbers::pi;
  for (size_t reference = 0; reference < std::min<size_t>(turns.size(), 9); ++reference) {
    std::vector<double> angles;
    for (const Eigen::Quaterniond& turn : turns)
      angles.push_back(turns[reference].angularDistance(turn));
    best = std::min(best, median(angles));
  }
  return best;
}

struct Hypothesis {
  std::string remedy;
  std::function<void(Robot&, Campaign&)> change;
};

void scale_lengths(Campaign& campaign, double factor) {
  for (Eigen::Vector3d& p : campaign.position) p *= factor;
  for (double& l : campaign.distance) l *= factor;
}

std::vector<Hypothesis> position_hypotheses(bool of_distances) {
  std::vector<Hypothesis> hypotheses;
  hypotheses.push_back(
      {"the joint angles look like radians under a _deg name; name the columns "
       "q1_rad to q6_rad",
       [](Robot&, Campaign& c) {
         for (JointVector& q : c.q) q *= 180 / std::numbers::pi;
       }});
  hypotheses.push_back({of_distances
                            ? "the distances look like metres under a _mm name; name the column l_m"
                            : "the positions look like metres under a _mm name; name the columns "
                              "x_m,y_m,z_m",
                        [](Robot&, Campaign& c) { scale_lengths(c, 1000); }});
  hypotheses.push_back(
      {of_distances ? "the distances look like millimetres under a _m name; name the column l_mm"
                    : "the positions look like millimetres under a _m name; name the columns "
                      "x_mm,y_mm,z_mm",
       [](Robot&, Campaign& c) { scale_lengths(c, 1e-3); }});
  for (int j = 0; j < kJoints; ++j)
    hypotheses.push_back({"joint " + std::to_string(j + 1) +
                              " seems to count the other way; change its 'sign' in the "
                              "robot file",
                          [j](Robot& r, Campaign&) { r.chain.links[j].sign *= -1; }});
  return hypotheses;
}

std::vector<Hypothesis> orientation_hypotheses() {
  return {
      {"a_deg and c_deg look exchanged; the contract is R = Rz(a) Ry(b) Rx(c)",
       [](Robot&, Campaign& c) {
         for (Eigen::Quaterniond& q : c.orientation) {
           const Eigen::Vector3d abc = abc_from_rotation(q.toRotationMatrix());
           q = Eigen::Quaterniond(rotation_from_abc(abc[2], abc[1], abc[0]));
         }
       }},
      {"the orientations look turned the other way (tool from instrument); give the rotation that "
       "takes tool axes to R_A",
       [](Robot&, Campaign& c) {
         for (Eigen::Quaterniond& q : c.orientation) q = q.conjugate();
       }},
      {"the angles a, b, c look like radians under a _deg name; name the columns "
       "a_rad,b_rad,c_rad",
       [](Robot&, Campaign& c) {
         for (Eigen::Quaterniond& q : c.orientation) {
           const Eigen::Vector3d abc =
               abc_from_rotation(q.toRotationMatrix()) * (180 / std::numbers::pi);
           q = Eigen::Quaterniond(rotation_from_abc(abc[0], abc[1], abc[2]));
         }
       }}};
}

void try_hypotheses(const Robot& robot, const Campaign& campaign,
                    const std::vector<Hypothesis>& hypotheses, double as_it_stands,
                    double (*measure)(Robot, const Campaign&), std::vector<std::string>& findings) {
  double best = kMuchBetter * as_it_stands;
  std::string remedy;
  for (const Hypothesis& hypothesis : hypotheses) {
    Robot changed_robot = robot;
    Campaign changed = campaign;
    hypothesis.change(changed_robot, changed);
    const double miss = measure(changed_robot, changed);
    if (miss >= best) continue;
    best = miss;
    remedy = hypothesis.remedy;
  }
  if (!remedy.empty()) findings.push_back(remedy);
}

}  // namespace

std::vector<std::string> diagnose(const Robot& given, const Campaign& all) {
  // One base must fit what is looked at: the session with most rows.
  const std::vector<std::vector<int>> sessions = rows_by_session(all);
  const std::vector<int>& own =
      *std::max_element(sessions.begin(), sessions.end(),
                        [](const auto& a, const auto& b) { return a.size() < b.size(); });
  const long available = static_cast<long>(own.size());
  const long looked_at = std::min<long>(available, kRowsLookedAt);
  std::vector<int> rows;
  for (long i = 0; i < looked_at; ++i) rows.push_back(own[i * available / looked_at]);
  const Campaign campaign = all.select(rows);
  const Robot robot = robot_at_row(given, campaign, 0);
  std::vector<std::string> findings;
  if (campaign.rows() < 4) return findings;  // a base fits any three points
  const double miss = median_miss(robot, campaign);
  if (miss > kImplausibleMiss)
    try_hypotheses(robot, campaign, position_hypotheses(campaign.has_distances()), miss,
                   median_miss, findings);
  if (findings.empty() && campaign.has_orientation()) {
    const double turn = median_turn(robot, campaign);
    if (turn > kImplausibleTurn)
      try_hypotheses(robot, campaign, orientation_hypotheses(), turn, median_turn, findings);
  }
  return findings;
}

}  // namespace armtrue
