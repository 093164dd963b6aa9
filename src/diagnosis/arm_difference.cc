#include "armtrue/diagnosis/arm_difference.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

// Poses without a clock, a direction of arrival, a temperature or a motor torque.
bool lacks_driver(const Effect& effect, const Campaign& visits) {
  const Driver& driver = effect.driver;
  const auto lacks = [&](DriverKind kind) {
    return kind == DriverKind::stroke || !missing_column(visits, kind, driver.where).empty();
  };
  return lacks(driver.kind) || (driver.factor && lacks(*driver.factor));
}

// The arm as joint angles decide it.
Robot arm_of(const Robot& robot, const Campaign& visits) {
  Robot arm = without_station_effects(robot, false);
  std::erase_if(arm.effects, [&](const Effect& effect) { return lacks_driver(effect, visits); });
  arm.sessions.clear();
  arm.identify = {"base", "tool"};
  arm.identify_per_session.clear();
  arm.uncertainty.reset();
  return arm;
}

Campaign visits_of(const std::vector<JointVector>& poses) {
  Campaign visits;
  visits.source = "the poses of the comparison";
  for (const JointVector& q : poses) {
    const int number = visits.rows();
    visits.q.push_back(q);
    visits.pose.push_back(number);
    visits.pose_ids.push_back(std::to_string(number + 1));
    visits.line.push_back(number + 1);
  }
  return visits;
}

void read_points(const Robot& arm, Campaign& visits) {
  const RobotModel model(arm);
  for (int row = 0; row < visits.rows(); ++row)
    visits.position.push_back(model.pose(visits.context(row)).translation);
}

std::vector<double> distances(const Robot& before, const Campaign& points) {
  return position_errors(refit_set_up(before, points, before.identify), points);
}

// Those of a calibration: all, or those that come from the noise of its readings alone.
enum class ErrorsOf { all, noise };

// Of the standard deviation of a reading about the model.
double share_of_noise(const Uncertainty& known) {
  const double reading = known.reading.position;
  return reading > known.rest ? std::sqrt(1 - std::pow(known.rest / reading, 2)) : 0;
}

// The unknowns of two calibrations as those of one robot, which has the effects of both.
class UnknownsOfBoth {
 public:
  UnknownsOfBoth(const Robot& before, const Robot& after) : robot_(after) {
    for (const Effect& effect : before.effects)
      if (place_of(effect) < 0) {
        robot_.effects.push_back(effect);
        for (Coefficient& coefficient : robot_.effects.back().coefficients) coefficient.value = 0;
      }
  }

  // Adds the errors of a calibration; false if its file does not state those of all its effects.
  // `file`: the robot as it was read. `errors`: all of them, or those by the noise of its readings.
  bool add(const Robot& file, ErrorsOf errors) {
    if (!file.uncertainty) return false;
    const Uncertainty& known = *file.uncertainty;
    const double of_noise = share_of_noise(known);
    std::vector<std::pair<int, Eigen::RowVectorXd>> own;  // unknown, its row of the root
    const auto take = [&](int unknown, Eigen::Index row, double std) {
      const double by_root = known.root.row(row).norm();
      // The standard deviations of a fit that leaves far more than noise are widened, its root not.
      // The root contains what poses do not show, they do not.
      const double widened = std > by_root && by_root > 0 ? std / by_root : 1;
      own.emplace_back(unknown,
                       (errors == ErrorsOf::all ? widened : of_noise) * known.root.row(row));
    };
    for (size_t k = 0; k < known.parameters.size(); ++k) {
      const std::string& name = known.parameters[k];
      if (!find_parameter(robot_.chain, name)) continue;
      const auto std = file.std.find(name);
      take(number_of(name), k, std == file.std.end() ? 0 : std->second);
    }
    Eigen::Index row = known.parameters.size();
    for (const Effect& effect : file.effects) {
      const int place = place_of(effect);
      for (int k = 0; k < std::ssize(effect.coefficients); ++k, ++row) {
        if (place < 0) continue;
        if (row >= known.root.rows()) return false;
        take(-1 - place - k, row, effect.coefficients[k].std);
      }
    }
    errors_.push_back(std::move(own));
    columns_.push_back(known.root.cols());
    return true;
  }

  // The robot with the covariance of the difference of both calibrations.
  Robot robot() const {
    const Eigen::Index geometric = names_.size();
    Eigen::Index coefficients = 0, columns = 0;
    for (const Effect& effect : robot_.effects) coefficients += std::ssize(effect.coefficients);
    for (const Eigen::Index of_one : columns_) columns += of_one;
    Robot robot = robot_;
    Uncertainty& both = robot.uncertainty.emplace();
    both.parameters = names_;
    both.root = Eigen::MatrixXd::Zero(geometric + coefficients, columns);
    Eigen::Index first = 0;
    for (size_t one = 0; one < errors_.size(); ++one) {
      for (const auto& [unknown, row] : errors_[one])
        both.root.row(unknown >= 0 ? unknown : geometric - 1 - unknown)
            .segment(first, columns_[one]) = row;
      first += columns_[one];
    }
    return robot;
  }

 private:
  int number_of(const std::string& name) {
    const auto [entry, is_new] = numbers_.emplace(name, names_.size());
    if (is_new) names_.push_back(name);
    return entry->second;
  }

  // Number of the first coefficient of an effect of this form; -1: there is none.
  int place_of(const Effect& effect) const {
    int place = 0;
    for (const Effect& own : robot_.effects) {
      if (same_form(own, effect)) return place;
      place += static_cast<int>(own.coefficients.size());
    }
    return -1;
  }

  Robot robot_;
  std::vector<std::string> names_;
  std::map<std::string, int> numbers_;
  std::vector<std::vector<std::pair<int, Eigen::RowVectorXd>>> errors_;
  std::vector<Eigen::Index> columns_;
};

// What chance alone makes of the mean square distance, after base and tool are fitted.
std::optional<MeanSquare> mean_square_by_chance(const Robot& before, const Robot& after,
                                                const Robot& arm_before, const Robot& arm_after,
                                                const Campaign& points, ErrorsOf errors) {
  UnknownsOfBoth unknowns(arm_before, arm_after);
  if (!unknowns.add(before, errors) || !unknowns.add(after, errors)) return std::nullopt;
  Robot both = unknowns.robot();
  Robot links_only = both;
  links_only.effects.clear();
  const IdentifiableSet placed = require_identifiable(links_only, points);
  both.uncertainty = after_refit(both, points, placed.kept);
  return mean_square_by_uncertainty(both, points);
}

int poses_of_calibration(const Robot& robot) {
  return robot.uncertainty ? robot.uncertainty->poses : 0;
}

// Of a mean square distance.
double p_of(double square, const MeanSquare& by_chance, int fewest_poses) {
  return fisher_f_above(square / by_chance.expected, by_chance.freedom,
                        std::max(1, fewest_poses - 1));
}

// The mean square of the distances is a parabola of the scale.
CommonScale common_scale(const Robot& arm_before, const Campaign& points,
                         const MeanSquare& by_chance, int fewest_poses) {
  const auto at = [&](double scale) {
    Campaign scaled = points;
    for (Eigen::Vector3d& point : scaled.position) point *= 1 + scale;
    return summarize(distances(arm_before, scaled));
  };
  const auto square = [&](double scale) { return std::pow(at(scale).rms, 2); };
  constexpr double kStep = 1e-4;
  const double here = square(0), up = square(kStep), down = square(-kStep);
  const double bend = (up + down - 2 * here) / (kStep * kStep);
  if (bend <= 0) return {0, at(0).mean, p_of(here, by_chance, fewest_poses)};
  const double best = (down - up) / (2 * kStep) / bend;
  const ErrorSummary left = at(best);
  return {-best, left.mean, p_of(left.rms * left.rms, by_chance, fewest_poses)};
}

bool has_remainder(const Robot& robot) {
  return std::ranges::any_of(robot.effects,
                             [](const Effect& effect) { return effect.name == kRemainder; });
}

}  // namespace

namespace {

// Of each pose, whether the readings of a calibration cover it, see Prediction::leverage. All of a
// robot that does not tell.
std::vector<bool> covered(const Robot& robot, const std::vector<JointVector>& poses) {
  std::vector<bool> inside(poses.size(), true);
  if (!robot.uncertainty) return inside;
  Campaign points = visits_of(poses);
  Robot arm = robot;
  std::erase_if(arm.effects, [&](const Effect& effect) { return lacks_driver(effect, points); });
  if (arm.effects.size() != robot.effects.size()) return inside;  // their errors stand in the root
  arm.sessions.clear();
  if (const double of_point = arm.uncertainty->largest_variance_of_point; of_point > 0)
    arm.uncertainty->largest_variance = of_point;
  read_points(arm, points);
  const std::vector<Prediction> predictions = predict(arm, points);
  for (size_t k = 0; k < poses.size(); ++k) inside[k] = predictions[k].leverage <= 1;
  return inside;
}

// To the angles that curves over a joint have seen.
void clip_travel(const Robot& robot, KinematicChain& chain) {
  for (const Effect& effect : robot.effects) {
    if (!effect.driver_range || !is_of_one_angle(effect)) continue;
    Link& link = chain.links[link_of_joint(chain, effect.driver.joint)];
    const double low = std::max(link.min, (*effect.driver_range)[0]),
                 high = std::min(link.max, (*effect.driver_range)[1]);
    if (low < high) {
      link.min = low;
      link.max = high;
    }
  }
}

}  // namespace

std::vector<JointVector> poses_of_both(const Robot& before, const Robot& after) {
  constexpr size_t kPoses = 200;  // the mean distance is then known to some 4 %
  constexpr size_t kFewest = 40;  // readings of a region that the travel hardly meets
  constexpr int kDrawn = 2000;
  constexpr std::ptrdiff_t kAtOnce = 250;
  Robot within = after;
  for (const Robot* robot : {&before, &after}) clip_travel(*robot, within.chain);
  const std::vector<JointVector> drawn = random_configurations(within, kDrawn, {}, 1);
  std::vector<JointVector> poses;
  for (auto first = drawn.begin(); first != drawn.end() && poses.size() < kPoses;
       first += kAtOnce) {
    const std::vector<JointVector> some(first, first + kAtOnce);
    const std::vector<bool> by_one = covered(before, some), by_other = covered(after, some);
    for (size_t k = 0; k < some.size() && poses.size() < kPoses; ++k)
      if (by_one[k] && by_other[k]) poses.push_back(some[k]);
  }
  if (poses.size() < kFewest) poses.assign(drawn.begin(), drawn.begin() + kPoses);
  return poses;
}

ArmDifference arm_difference(const Robot& before, const Robot& after,
                             const std::vector<JointVector>& poses) {
  Campaign points = visits_of(poses);
  const Robot arm_before = arm_of(before, points), arm_after = arm_of(after, points);
  read_points(arm_after, points);
  ArmDifference found;
  found.q = poses;
  found.distance = distances(arm_before, points);
  found.hidden = hidden_by_refit({"base", "tool"}, arm_before, points);
  const ErrorSummary summary = summarize(found.distance);
  found.mean = summary.mean;
  found.rms = summary.rms;
  found.max = summary.max;
  found.largest =
      static_cast<int>(std::ranges::max_element(found.distance) - found.distance.begin());
  for (const Robot* robot : {&before, &after})
    for (const Effect& effect : robot->effects) {
      if (!moves_program(effect, false) || !lacks_driver(effect, points)) continue;
      std::string text = to_string(effect.parameter) + " follows " + to_string(effect.driver);
      if (std::ranges::find(found.left_out, text) == found.left_out.end())
        found.left_out.push_back(std::move(text));
    }
  if (has_remainder(before) || has_remainder(after)) return found;
  const int fewest = std::min(poses_of_calibration(before), poses_of_calibration(after));
  const auto chance =
      mean_square_by_chance(before, after, arm_before, arm_after, points, ErrorsOf::all);
  if (!chance || chance->expected <= 0) return found;
  found.by_chance = std::sqrt(chance->expected);
  found.p_value = p_of(found.rms * found.rms, *chance, fewest);
  found.smallest_seen =
      *found.by_chance * std::sqrt(fisher_f_quantile(1 - kChangeSignificance, chance->freedom,
                                                     std::max(1, fewest - 1)));
  const auto noise =
      mean_square_by_chance(before, after, arm_before, arm_after, points, ErrorsOf::noise);
  found.p_value_of_noise =
      noise && noise->expected > 0 ? p_of(found.rms * found.rms, *noise, fewest) : 0;
  found.scale = common_scale(arm_before, points, *chance, fewest);
  return found;
}

double mean_arm_difference(const Robot& before, const Robot& after,
                           const std::vector<JointVector>& poses) {
  Campaign points = visits_of(poses);
  const Robot arm_before = arm_of(before, points);
  read_points(arm_of(after, points), points);
  return summarize(distances(arm_before, points)).mean;
}

}  // namespace armtrue
