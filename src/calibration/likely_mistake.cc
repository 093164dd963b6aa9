#include "calibration/likely_mistake.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/kinematics/contact.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/observation.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

class Corrections {
 public:
  Corrections(const Robot& fitted, const Campaign& readings, double off, double tolerance)
      : fitted_(fitted),
        readings_(readings),
        least_(std::min(off / 3, std::max(tolerance, 0.02 * off))) {}

  template <typename Change>
  void attempt(const std::string& mistake, const Change& change) {
    Campaign corrected = readings_;
    change(corrected);
    const double miss = worst_miss(fitted_, corrected);
    if (miss >= least_) return;
    least_ = miss;
    best_ = mistake;
  }

  /// Of what follows only a miss below this counts [m].
  void require(double miss) { least_ = std::min(least_, miss); }

  static double worst_miss(const Robot& robot, const Campaign& campaign) {
    return std::ranges::max(evaluate(robot, campaign).position);
  }

  double least() const { return least_; }
  const std::optional<std::string>& best() const { return best_; }

 private:
  const Robot& fitted_;
  const Campaign& readings_;
  double least_;
  std::optional<std::string> best_;
};

void give_joints(Campaign& campaign, const JointVector& q) {
  for (auto own : campaign.q) own = q;
}

bool is_one_of(const std::vector<std::vector<int>>& readings, const Campaign& campaign, int pose) {
  return std::ranges::any_of(
      readings, [&](const std::vector<int>& rows) { return campaign.pose[rows.front()] == pose; });
}

void attempt_other_poses(const Campaign& campaign, const std::vector<std::vector<int>>& readings,
                         size_t which, Corrections& corrections) {
  std::vector<bool> seen(campaign.pose_ids.size(), false);
  seen[campaign.pose[readings[which].front()]] = true;
  for (int row = 0; row < campaign.rows(); ++row) {
    const int pose = campaign.pose[row];
    if (seen[pose]) continue;
    seen[pose] = true;
    const std::string& id = campaign.pose_ids[pose];
    corrections.attempt(is_one_of(readings, campaign, pose)
                            ? "its joint angles and those of pose " + id + " look exchanged"
                            : "its readings fit the joint angles of pose " + id,
                        [&](Campaign& c) { give_joints(c, campaign.q[row]); });
  }
}

// Assigns to each reading the target that fits it best.
void attempt_targets(const Robot& fitted, const Campaign& readings, Corrections& corrections) {
  if (readings.target.empty() || readings.target_names.size() < 2) return;
  std::vector<int> better;
  std::string names;
  for (int row = 0; row < readings.rows(); ++row) {
    Campaign alone = readings.select({row});
    double least = std::numeric_limits<double>::infinity();
    int best = 0;
    for (int target = 0; target < std::ssize(readings.target_names); ++target) {
      alone.target[0] = target;
      const double miss = Corrections::worst_miss(fitted, alone);
      if (miss >= least) continue;
      least = miss;
      best = target;
    }
    better.push_back(best);
    names += fmt::format("{}{} reads {}", names.empty() ? "" : ", ",
                         readings.target_names[readings.target[row]], readings.target_names[best]);
  }
  corrections.attempt("the ids of targets look exchanged: " + names,
                      [&](Campaign& c) { c.target = better; });
}

void attempt_anchors(const Campaign& readings, Corrections& corrections) {
  const std::vector<std::string>& names = readings.anchor_names;
  for (int second = 1; second < std::ssize(names); ++second)
    for (int first = 0; first < second; ++first)
      corrections.attempt(
          fmt::format("the anchors '{}' and '{}' look exchanged", names[first], names[second]),
          [first, second](Campaign& c) {
            for (int& anchor : c.anchor)
              anchor = anchor == first ? second : anchor == second ? first : anchor;
          });
}

void attempt_sessions(const Campaign& readings, Corrections& corrections) {
  if (readings.session.empty()) return;
  for (int session = 0; session < std::ssize(readings.session_names); ++session)
    if (session != readings.session.front())
      corrections.attempt(fmt::format("its readings fit the session '{}', not '{}'",
                                      readings.session_names[session],
                                      readings.session_names[readings.session.front()]),
                          [session](Campaign& c) { std::ranges::fill(c.session, session); });
}

// Takes the touches of one pose as those of another contact with as many numbers.
void attempt_contacts(const Robot& fitted, const Campaign& readings, Corrections& corrections) {
  const std::vector<ContactPoint> contacts = match_contacts(readings, fitted.chain);
  const auto reads_three = [&](int name) {
    return reads_point(fitted.chain.contacts[contacts[name].contact], contacts[name].point);
  };
  for (int name = 0; name < std::ssize(contacts); ++name) {
    if (!fitted.chain.contacts[contacts[name].contact].is_placed || contacts[name].board >= 0)
      continue;
    const bool alike = std::ranges::all_of(readings.touch, [&](const Touch& touch) {
      return touch.contact >= 0 && reads_three(touch.contact) == reads_three(name) &&
             contacts[touch.contact].beam == contacts[name].beam;
    });
    if (!alike) continue;
    corrections.attempt((contacts[name].beam < 0 ? "it seems to touch " : "it seems to read ") +
                            readings.contact_names[name],
                        [name](Campaign& c) {
                          for (Touch& touch : c.touch) touch.contact = name;
                        });
  }
}

void attempt_joints(const KinematicChain& chain, Corrections& corrections) {
  const std::vector<JointName> names = joint_names(chain);
  const auto joints = std::ssize(names);
  for (int j = 0; j < joints; ++j)
    corrections.attempt(names[j].column + " seems to have the wrong sign", [j](Campaign& c) {
      for (auto q : c.q) q[j] = -q[j];
    });
  for (int j = 0; j + 1 < joints; ++j)
    if (names[j].is_length == names[j + 1].is_length)
      corrections.attempt(
          fmt::format("{} and {} look exchanged", names[j].column, names[j + 1].column),
          [j](Campaign& c) {
            for (auto q : c.q) std::swap(q[j], q[j + 1]);
          });
  corrections.attempt("its joint angles look like radians among degrees",
                      [&](Campaign& c) { scale_angles(c, chain, 180 / std::numbers::pi); });
}

// How far one joint must turn for the readings to fit best [rad or m], by Gauss and Newton's
// method.
double best_turn(const Robot& fitted, const Campaign& readings, Eigen::Index joint) {
  constexpr int kSteps = 20;
  constexpr double kDifference = 1e-6, kLongest = 0.5, kSmallest = 1e-9;  // rad or m
  const auto residuals_at = [&](double turn) {
    Campaign turned = readings;
    for (auto q : turned.q) q[joint] += turn;
    return evaluate(fitted, turned).residuals;
  };
  double turn = 0;
  for (int step = 0; step < kSteps; ++step) {
    const auto here = residuals_at(turn), beside = residuals_at(turn + kDifference);
    double squares = 0, product = 0;
    for (size_t row = 0; row < here.size(); ++row) {
      const Eigen::Vector3d slope = (beside[row] - here[row]).head<3>() / kDifference;
      squares += slope.squaredNorm();
      product += slope.dot(here[row].head<3>());
    }
    if (squares <= 0) break;  // the joint does not move the point
    const double change = std::clamp(-product / squares, -kLongest, kLongest);
    turn += change;
    if (std::abs(change) < kSmallest) break;
  }
  return turn;
}

// One joint value that is wrong by any amount. It must fit far better than the other mistakes: a
// chance error of a point lies so close to the way of one of six joints in one case of 300. An
// effect of that joint, such as a cable at the end of its travel, does the same as a small amount.
void attempt_one_joint(const Robot& fitted, const Campaign& readings, double off,
                       Corrections& corrections) {
  constexpr double kOfTheError = 1.0 / 30;
  if (corrections.best() || off < kNoEffect) return;
  corrections.require(kOfTheError * off);
  const std::vector<JointName> names = joint_names(fitted.chain);
  for (Eigen::Index j = 0; j < std::ssize(names); ++j) {
    const JointName& name = names[static_cast<size_t>(j)];
    const double turn = best_turn(fitted, readings, j), value = readings.q[0][j];
    corrections.attempt(fmt::format("its {} of {:.6g} looks wrong, {:.6g} would fit",
                                    name.encoder(), value / name.si(), (value + turn) / name.si()),
                        [j, turn](Campaign& c) {
                          for (auto q : c.q) q[j] += turn;
                        });
  }
}

void attempt_lengths(const Campaign& readings, Corrections& corrections) {
  const std::array<std::pair<double, const char*>, 4> units = {
      {{1000, "metres among millimetres"},
       {1e-3, "millimetres among metres"},
       {25.4, "inches among millimetres"},
       {10, "centimetres among millimetres"}}};
  for (const auto& [factor, name] : units)
    corrections.attempt(std::string("its readings look like ") + name,
                        [factor = factor](Campaign& c) {
                          for (Eigen::Vector3d& p : c.position) p *= factor;
                          for (double& l : c.distance) l *= factor;
                        });
  if (readings.position.empty()) return;
  for (int axis = 0; axis < 3; ++axis) {
    corrections.attempt(fmt::format("its {} seems to have the wrong sign", "xyz"[axis]),
                        [axis](Campaign& c) {
                          for (Eigen::Vector3d& p : c.position) p[axis] = -p[axis];
                        });
    const int other = (axis + 1) % 3;
    corrections.attempt(fmt::format("its {} and {} look exchanged", "xyz"[axis], "xyz"[other]),
                        [axis, other](Campaign& c) {
                          for (Eigen::Vector3d& p : c.position) std::swap(p[axis], p[other]);
                        });
  }
}

}  // namespace

namespace {

// What poses may show elsewhere: its place in a robot, and whether a row shows it.
struct Thing {
  std::string words;
  std::function<Eigen::Vector3d&(Robot&)> place;
  std::function<bool(int)> is_shown;
};

std::vector<Thing> things_of(const Robot& fitted, const Campaign& campaign) {
  const KinematicChain& chain = fitted.chain;
  std::vector<Thing> things;
  const auto add = [&](const char* kind, const std::string& name, auto place, auto is_shown) {
    things.push_back({fmt::format("{} '{}'", kind, name), place, is_shown});
  };
  const std::vector<ContactPoint> contacts = match_contacts(campaign, chain);
  for (int k = 0; campaign.has_touches() && k < contact_count(chain); ++k)
    if (is_touched(chain.contacts[k].kind))
      add(
          "contact", chain.contacts[k].name,
          [k](Robot& r) -> Eigen::Vector3d& { return r.chain.contacts[k].place.translation; },
          [&campaign, contacts, k](int row) {
            return campaign.kind(row) == ReadingKind::touch &&
                   contacts[campaign.touch[row].contact].contact == k;
          });
  const std::vector<int> targets = match_targets(campaign, chain);
  for (int k = 0; campaign.targets() > 1 && k < std::ssize(targets); ++k)
    add(
        "target", campaign.target_names[k],
        [of = targets[k]](Robot& r) -> Eigen::Vector3d& { return r.chain.targets[of].position; },
        [&campaign, k](int row) { return campaign.target[row] == k; });
  const std::vector<int> anchors = match_anchors(campaign, chain);
  for (int k = 0; campaign.anchor_names.size() > 1 && k < std::ssize(anchors); ++k)
    add(
        "anchor", campaign.anchor_names[k],
        [of = anchors[k]](Robot& r) -> Eigen::Vector3d& { return r.chain.anchors[of].position; },
        [&campaign, k](int row) {
          return campaign.kind(row) == ReadingKind::distance && campaign.anchor[row] == k;
        });
  return things;
}

Eigen::VectorXd position_residuals(const Robot& robot, const Campaign& readings) {
  const int size = readings.reading_size().position;
  const Evaluation evaluation = evaluate(robot, readings);
  Eigen::VectorXd all(size * readings.rows());
  for (int row = 0; row < readings.rows(); ++row)
    all.segment(size * row, size) = evaluation.residuals[row].head(size);
  return all;
}

// The shift of a thing with which all these readings fit [m]; nothing if they are too few to tell,
// or do not.
std::optional<double> common_shift(const Robot& fitted, const Thing& thing,
                                   const Campaign& readings, double tolerance) {
  constexpr int kSteps = 4;
  constexpr Eigen::Index kSpareNumbers = 3;
  constexpr double kOfTheError = 0.1;  // three numbers are so small by chance in one of 1000 cases
  constexpr double kDifference = 1e-6, kShown = 1e-6;  // m; of the largest column
  Robot moved = fitted;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::VectorXd here = position_residuals(moved, readings);
    Eigen::MatrixXd slope(here.size(), 3);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      Robot beside = moved;
      thing.place(beside)[axis] += kDifference;
      slope.col(axis) = (position_residuals(beside, readings) - here) / kDifference;
    }
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(slope.rows(), slope.cols());
    qr.setThreshold(kShown);
    qr.compute(slope);
    if (here.size() - qr.rank() < kSpareNumbers) return std::nullopt;
    thing.place(moved) -= qr.solve(here);
  }
  const double most = std::min(tolerance, kOfTheError * Corrections::worst_miss(fitted, readings));
  if (Corrections::worst_miss(moved, readings) >= most) return std::nullopt;
  Robot before = fitted;
  return (thing.place(moved) - thing.place(before)).norm();
}

}  // namespace

std::vector<MovedThing> moved_things(const Robot& fitted, const Campaign& campaign,
                                     const std::vector<std::vector<int>>& readings,
                                     double tolerance) {
  std::vector<MovedThing> found;
  for (const Thing& thing : things_of(fitted, campaign)) {
    MovedThing moved;
    std::vector<int> rows;
    for (size_t pose = 0; pose < readings.size(); ++pose)
      if (std::ranges::all_of(readings[pose], thing.is_shown)) {
        moved.poses.push_back(pose);
        rows.insert(rows.end(), readings[pose].begin(), readings[pose].end());
      }
    if (moved.poses.size() < 2) continue;
    const auto shift = common_shift(fitted, thing, campaign.select(rows), tolerance);
    if (!shift) continue;
    moved.words = fmt::format(
        "they show the {} {:.3g} mm from where the others do: was it moved? Then give it another "
        "name there",
        thing.words, *shift / kMillimetre);
    found.push_back(std::move(moved));
  }
  return found;
}

std::optional<std::string> likely_mistake(const Robot& fitted, const Campaign& campaign,
                                          const std::vector<std::vector<int>>& readings,
                                          size_t which, double off, double tolerance) {
  const Campaign own = campaign.select(readings[which]);
  Corrections corrections(fitted, own, off, tolerance);
  attempt_joints(fitted.chain, corrections);
  attempt_lengths(own, corrections);
  attempt_targets(fitted, own, corrections);
  attempt_anchors(own, corrections);
  attempt_sessions(own, corrections);
  // Every pose that touches the same contact has joint angles that fit.
  if (own.kind(0) == ReadingKind::touch)
    attempt_contacts(fitted, own, corrections);
  else
    attempt_other_poses(campaign, readings, which, corrections);
  attempt_one_joint(fitted, own, off, corrections);
  return corrections.best();
}

}  // namespace armtrue
