#include "diagnosis/mixed_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <random>
#include <set>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/placement.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

constexpr int kPosesDrawn = 6;  // of one target: 9 equations more than unknowns
constexpr int kDraws = 150;     // of a third of wrong poses, 9 draws of 100 have none
constexpr int kPosesThatProve = 3;
constexpr double kTenth = 0.1;

struct RowMistake {
  std::string what, remedy;
  std::function<void(Campaign&)> correct;
};

void scale_points(Campaign& campaign, double factor) {
  for (Eigen::Vector3d& p : campaign.position) p *= factor;
}

std::vector<RowMistake> row_mistakes(const KinematicChain& chain) {
  std::vector<RowMistake> mistakes;
  for (const auto& [factor, unit] : {std::pair{1000.0, "metres among millimetres"},
                                     {1e-3, "millimetres among metres"},
                                     {25.4, "inches among millimetres"},
                                     {1 / 25.4, "millimetres among inches"},
                                     {10.0, "centimetres among millimetres"}})
    mistakes.push_back({std::string("their positions look like ") + unit, "convert them",
                        [factor = factor](Campaign& c) { scale_points(c, factor); }});
  for (const auto& [factor, unit] :
       {std::pair{1 / kDegree, "radians among degrees"}, {kDegree, "degrees among radians"}})
    mistakes.push_back(
        {std::string("their joint angles look like ") + unit, "convert them",
         [factor = factor, &chain](Campaign& c) { scale_angles(c, chain, factor); }});
  const std::vector<JointName> names = joint_names(chain);
  for (int j = 0; j < std::ssize(names); ++j) {
    mistakes.push_back(
        {names[j].column + " seems to have the wrong sign in them", "correct it", [j](Campaign& c) {
           for (auto q : c.q) q[j] = -q[j];
         }});
    if (!names[j].is_length)
      for (const auto& [factor, unit] :
           {std::pair{1 / kDegree, "radians among degrees"}, {kDegree, "degrees among radians"}})
        mistakes.push_back({names[j].column + " looks like " + unit + " in them", "convert it",
                            [j, factor = factor](Campaign& c) {
                              for (auto q : c.q) q[j] *= factor;
                            }});
    for (int k = 0; k < j; ++k)
      if (names[j].is_length == names[k].is_length)
        mistakes.push_back(
            {fmt::format("{} and {} look exchanged in them", names[k].column, names[j].column),
             "exchange them", [j, k](Campaign& c) {
               for (auto q : c.q) std::swap(q[j], q[k]);
             }});
  }
  for (int axis = 0; axis < 3; ++axis) {
    const int other = (axis + 1) % 3;
    mistakes.push_back({fmt::format("{} seems to have the wrong sign in them", "xyz"[axis]),
                        "correct it", [axis](Campaign& c) {
                          for (Eigen::Vector3d& p : c.position) p[axis] = -p[axis];
                        }});
    mistakes.push_back({fmt::format("{} and {} look exchanged in them", "xyz"[axis], "xyz"[other]),
                        "exchange them", [axis, other](Campaign& c) {
                          for (Eigen::Vector3d& p : c.position) std::swap(p[axis], p[other]);
                        }});
  }
  return mistakes;
}

std::vector<RowMistake> orientation_mistakes() {
  using Eigen::Quaterniond;
  const auto of_each = [](const char* what, const char* remedy, const auto& corrected) {
    return RowMistake{what, remedy, [corrected](Campaign& c) {
                        for (Quaterniond& q : c.orientation) q = corrected(q);
                      }};
  };
  const auto of_angles = [&](const char* what, const char* remedy, const auto& rotation) {
    return of_each(what, remedy, [rotation](const Quaterniond& q) {
      return Quaterniond(rotation(abc_from_rotation(q.toRotationMatrix())));
    });
  };
  const auto scaled = [](double factor) {
    return [factor](const Eigen::Vector3d& abc) {
      return rotation_from_abc(factor * abc[0], factor * abc[1], factor * abc[2]);
    };
  };
  const auto about = [](const Eigen::Vector3d& axis, double angle) {
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  };
  return {of_angles("their angles a, b, c look like radians among degrees", "convert them",
                    scaled(1 / kDegree)),
          of_angles("their angles a, b, c look like degrees among radians", "convert them",
                    scaled(kDegree)),
          of_angles(
              "their angles a and c look exchanged; the contract is R = Rz(a) Ry(b) Rx(c)",
              "exchange them",
              [](const Eigen::Vector3d& abc) { return rotation_from_abc(abc[2], abc[1], abc[0]); }),
          of_angles("their angles look like those of R = Rx(c) Ry(b) Rz(a); the contract is "
                    "R = Rz(a) Ry(b) Rx(c)",
                    "convert them",
                    [about](const Eigen::Vector3d& abc) -> Eigen::Matrix3d {
                      return about(Eigen::Vector3d::UnitX(), abc[2]) *
                             about(Eigen::Vector3d::UnitY(), abc[1]) *
                             about(Eigen::Vector3d::UnitZ(), abc[0]);
                    }),
          of_each("their orientations look turned the other way (tool from instrument)",
                  "invert them", [](const Quaterniond& q) { return q.conjugate(); }),
          of_each("their quaternions look like x, y, z, w in place of w, x, y, z", "reorder them",
                  [](const Quaterniond& q) { return Quaterniond(q.z(), q.w(), q.x(), q.y()); }),
          of_each("their quaternions look like w, x, y, z in place of x, y, z, w", "reorder them",
                  [](const Quaterniond& q) { return Quaterniond(q.x(), q.y(), q.z(), q.w()); })};
}

using Errors = std::vector<double> Evaluation::*;

// The mistake that most poses share: its correction makes their errors small.
std::optional<std::string> shared_mistake(const Robot& placed, const Campaign& campaign,
                                          Errors errors, double good,
                                          const std::vector<RowMistake>& mistakes) {
  const std::vector<double> miss = evaluate(placed, campaign).*errors;
  std::vector<int> off;
  for (int row = 0; row < campaign.rows(); ++row)
    if (miss[row] > good) off.push_back(row);
  if (off.empty()) return std::nullopt;
  std::optional<std::string> finding;
  size_t most_poses = kPosesThatProve - 1;
  for (const RowMistake& mistake : mistakes) {
    Campaign corrected = campaign;
    mistake.correct(corrected);
    corrected = corrected.select(off);
    const std::vector<double> left = evaluate(placed, corrected).*errors;
    std::vector<int> found;
    std::set<int> poses;
    for (size_t k = 0; k < off.size(); ++k)
      if (left[k] <= std::min(good, kTenth * miss[off[k]])) {
        found.push_back(off[k]);
        poses.insert(campaign.pose[off[k]]);
      }
    // What most rows share is the mistake of a column, not of some rows.
    if (poses.size() <= most_poses || 2 * std::ssize(found) > campaign.rows()) continue;
    most_poses = poses.size();
    finding = fmt::format(
        "{} rows of {} poses, the first in line {}, do not fit the others: {}; {}", found.size(),
        poses.size(), campaign.line[found.front()], mistake.what, mistake.remedy);
  }
  return finding;
}

// The robot with the base and tool that fit most rows.
std::optional<Robot> placed_by_most(const Robot& robot, const Campaign& campaign, double good) {
  const auto all = place_base_and_tool(robot, campaign, good);
  if (!all) return std::nullopt;
  if (median(all->miss) <= good) return placed_robot(robot, campaign, *all);
  std::vector<std::vector<int>> rows_of_pose(campaign.pose_ids.size());
  for (int row = 0; row < campaign.rows(); ++row) rows_of_pose[campaign.pose[row]].push_back(row);
  if (rows_of_pose.size() < 2 * kPosesDrawn) return std::nullopt;
  std::mt19937_64 random(1);
  std::optional<Robot> best;
  long most = kPosesDrawn + kPosesThatProve;
  for (int draw = 0; draw < kDraws; ++draw) {
    // A mistake of many poses begins with a new file or day: every second draw is of neighbours.
    const size_t count = rows_of_pose.size();
    const size_t window = draw % 2 == 0 ? count : std::max<size_t>(2 * kPosesDrawn, count / 4);
    const size_t first = random() % (count - window + 1);
    std::set<size_t> poses;
    while (poses.size() < kPosesDrawn) poses.insert(first + random() % window);
    std::vector<int> rows;
    for (size_t pose : poses) rows.push_back(rows_of_pose[pose].front());
    const Campaign few = campaign.select(rows);
    const auto placement = place_base_and_tool(robot, few, good);
    if (!placement || std::ranges::max(placement->miss) > good) continue;
    const Robot placed = placed_robot(robot, few, *placement);
    const long near = std::ranges::count_if(evaluate(placed, campaign).position,
                                            [&](double miss) { return miss <= good; });
    if (near <= most) continue;
    most = near;
    best = placed;
  }
  return best;
}

}  // namespace

std::optional<std::string> find_mixed_rows(const Robot& given, const Campaign& campaign,
                                           const std::vector<JointsOfOtherRows>& others,
                                           double good, double good_turn) {
  Robot robot = given;
  robot.effects.clear();
  const auto placed = placed_by_most(robot, campaign, good);
  if (!placed) return std::nullopt;
  std::vector<RowMistake> mistakes = row_mistakes(placed->chain);
  for (const JointsOfOtherRows& other : others)
    mistakes.push_back({"their " + other.words, "was a row lost? Put the tables together again",
                        [&other](Campaign& c) { c.q = other.q; }});
  const auto finding = shared_mistake(*placed, campaign, &Evaluation::position, good, mistakes);
  if (finding || !campaign.has_orientation()) return finding;
  return shared_mistake(*placed, campaign, &Evaluation::orientation, good_turn,
                        orientation_mistakes());
}

}  // namespace armtrue
