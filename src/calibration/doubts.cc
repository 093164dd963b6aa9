#include "armtrue/calibration/doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <set>

#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

constexpr double kNoChance = 1e-3;
constexpr int kFewest = 3;  // visits or readings

// Readings of one pose, one after the other.
struct Visit {
  int first_row, last_row;
  bool is_left_out;
};

std::vector<Visit> visits_of(const Campaign& campaign, const std::vector<bool>& left_out) {
  std::vector<int> order(static_cast<size_t>(campaign.rows()));
  std::iota(order.begin(), order.end(), 0);
  if (!campaign.time_s.empty())
    std::ranges::stable_sort(order, {}, [&](int row) { return campaign.time_s[row]; });
  std::vector<Visit> visits;
  for (int row : order) {
    if (visits.empty() || campaign.pose[visits.back().last_row] != campaign.pose[row])
      visits.push_back({row, row, false});
    visits.back().last_row = row;
    if (left_out[row]) visits.back().is_left_out = true;
  }
  return visits;
}

// The stretch of visits, from one that is left out to another, that has the most surprising number
// of them: p by the hypergeometric law, times the number of stretches.
std::string in_a_stretch(const Campaign& campaign, const std::vector<bool>& left_out) {
  const std::vector<Visit> visits = visits_of(campaign, left_out);
  const auto all = static_cast<int>(visits.size());
  std::vector<int> left;  // visits that are left out
  for (int k = 0; k < all; ++k)
    if (visits[k].is_left_out) left.push_back(k);
  const auto count = static_cast<int>(left.size());
  double least = kNoChance / (0.5 * all * (all + 1.0));
  int first = -1, last = -1;
  for (int from = 0; from < count; ++from)
    for (int within = kFewest; from + within <= count; within += 1 + within / 8) {
      const int to = from + within - 1, length = left[to] - left[from] + 1;
      if (static_cast<double>(within) * all <= static_cast<double>(count) * length) continue;
      const double p = hypergeometric_at_least(within, length, count, all);
      if (p >= least) continue;
      least = p;
      first = from;
      last = to;
    }
  if (first < 0) return "";
  const auto place = [&](int row) {
    return campaign.time_s.empty() ? fmt::format("line {}", campaign.line[row])
                                   : fmt::format("t_s = {:.10g}", campaign.time_s[row]);
  };
  return fmt::format(
      "readings are left out in {} of {} visits from {} to {}: no blunders, but something that was "
      "off for a while (a brake, a loose tool, somebody at the instrument); find out what it was, "
      "or "
      "measure these poses again",
      last - first + 1, left[last] - left[first] + 1, place(visits[left[first]].first_row),
      place(visits[left[last]].last_row));
}

std::string on_one_target(const Campaign& campaign, const std::vector<bool>& left_out) {
  const auto targets = static_cast<int>(campaign.target_names.size());
  if (targets < 2 || campaign.target.empty()) return "";
  std::vector<int> readings(targets, 0), left(targets, 0);
  for (int row = 0; row < campaign.rows(); ++row) {
    ++readings[campaign.target[row]];
    left[campaign.target[row]] += left_out[row];
  }
  const auto all = static_cast<int>(std::ranges::count(left_out, true));
  for (int target = 0; target < targets; ++target)
    if (left[target] >= kFewest &&
        targets * hypergeometric_at_least(left[target], readings[target], all, campaign.rows()) <
            kNoChance)
      return fmt::format(
          "{} of the {} readings of target '{}' are left out, more than of the others: look "
          "whether "
          "it is damaged, dirty or loose, or leave its readings out",
          left[target], readings[target], campaign.target_names[target]);
  return "";
}

}  // namespace

std::string left_out_together(const Campaign& campaign, const std::vector<int>& lines) {
  if (lines.empty()) return "";
  std::vector<bool> left_out(static_cast<size_t>(campaign.rows()));
  for (int row = 0; row < campaign.rows(); ++row)
    left_out[row] = std::ranges::binary_search(lines, campaign.line[row]);
  const std::string on_target = on_one_target(campaign, left_out);
  return on_target.empty() ? in_a_stretch(campaign, left_out) : on_target;
}

std::string contradiction_of_noise(const Robot& robot, const Campaign& campaign,
                                   const CalibrationResult& fit, const NoiseFloor& noise) {
  constexpr double kMuchMore = 1.25, kMuchLess = 0.33;  // of the stated one
  constexpr double kResolution = 1e-6;                  // m: less is a simulation without noise
  const bool of_rows = !campaign.sigma_position.empty();
  const double stated =
      of_rows ? median(campaign.sigma_position) : stated_position_noise(robot, campaign);
  const std::string where = campaign.has_pixels() ? of_rows ? "sigma_px" : "noise: pixel_px"
                            : of_rows             ? "sigma_mm"
                                                  : "noise: position_mm";
  if (stated <= 0) return "";
  const double freedom = noise.degrees_of_freedom, ratio = noise.position / stated;
  // Of replicates the sigma of the rows only weighs them.
  if (noise.source == NoiseFloor::Source::replicates && !of_rows && ratio > kMuchMore &&
      chi_squared_above(freedom * ratio * ratio, freedom) < kNoChance)
    return fmt::format(
        "replicates scatter {:.3g} times as much as the noise that the robot file states, {:.4g} "
        "mm "
        "per axis: the instrument is noisier, or something changes from visit to visit, which all "
        "figures here take for noise",
        ratio, stated / kMillimetre);
  const double sigma = fit.sigma.position, left = sigma / stated;
  const double left_freedom = noise.axes * campaign.rows() - fit.determined[0];
  if (noise.source == NoiseFloor::Source::instrument && sigma > kResolution && left < kMuchLess &&
      left_freedom > 1 &&
      1 - chi_squared_above(left_freedom * left * left, left_freedom) < kNoChance)
    return fmt::format(
        "{} a noise of {:.4g} mm per axis, and the readings scatter by {:.4g} mm about the model: "
        "correct {}, beside which hardly anything can be found",
        of_rows ? "the rows state" : "the robot file states", stated / kMillimetre,
        sigma / kMillimetre, where);
  constexpr double kAnotherUnit = 100;  // um, or m, in place of mm are 1000
  if (noise.source == NoiseFloor::Source::instrument && left > kAnotherUnit)
    return fmt::format(
        "{} a noise of {:.4g} mm per axis, and the readings scatter by {:.4g} mm about the best "
        "model, {:.3g} times as much: is it in another unit? Correct {}, or nothing looks "
        "explained",
        of_rows ? "the rows state" : "the robot file states", stated / kMillimetre,
        sigma / kMillimetre, left, where);
  const double turned = robot.noise.orientation;
  if (campaign.has_orientation() && campaign.sigma_orientation.empty() && turned > 0 &&
      noise.source == NoiseFloor::Source::instrument && fit.sigma.orientation > kResolution)
    if (const double times = fit.sigma.orientation / turned;
        times > kAnotherUnit || times * kAnotherUnit < 1)
      return fmt::format(
          "the robot file states a noise of {:.4g} mrad per axis, and the orientations scatter by "
          "{:.4g} mrad about the best model: is it in another unit? Correct noise: "
          "orientation_mrad",
          turned / kMilliradian, fit.sigma.orientation / kMilliradian);
  return "";
}

namespace {

constexpr double kFarAbove = 5;
constexpr double kLeastNoise = 1e-6;  // m, rad: below it is a simulation without noise

// In position and orientation.
std::array<double, 2> ratios(const FitQuality& quality) {
  const auto ratio = [](double left, double pure) {
    return pure > 0 ? left / std::max(kLeastNoise, pure) : 0.0;
  };
  return {ratio(quality.left.position, quality.pure.position),
          ratio(quality.left.orientation, quality.pure.orientation)};
}

}  // namespace

double times_of_noise(const FitQuality& quality) {
  const double times = std::ranges::max(ratios(quality));
  return times > kFarAbove ? times : 1;
}

std::string far_above_noise(const FitQuality& quality) {
  const auto [in_position, in_orientation] = ratios(quality);
  const double times = std::max(in_position, in_orientation);
  if (times <= kFarAbove) return "";
  const bool is_of_position = in_position >= in_orientation;
  return fmt::format(
      "the readings scatter about the model by {:.4g} {} per axis, {:.3g} times {}: the model "
      "lacks something, and standard deviations are {:.3g} times as wide for it; close-loop looks "
      "for what it is, or compare zeros and lengths of the robot file with the arm",
      is_of_position ? quality.left.position / kMillimetre
                     : quality.left.orientation / kMilliradian,
      is_of_position ? "mm" : "mrad", times,
      quality.noise.source == NoiseFloor::Source::replicates ? "as much as replicates of a pose"
                                                             : "the stated noise",
      times);
}

void widen_deviations(double factor, CalibrationResult& fit) {
  for (auto& [name, deviation] : fit.robot.std) deviation *= factor;
  for (auto& [name, session] : fit.robot.sessions)
    for (auto& [parameter, deviation] : session.std) deviation *= factor;
  for (Effect& effect : fit.robot.effects)
    for (Coefficient& c : effect.coefficients) {
      c.std *= factor;
      for (double& bound : c.ci95) bound = c.value + factor * (bound - c.value);
    }
}

std::string broken_bounds(const Robot& robot, const Campaign& campaign,
                          const Evaluation& evaluation,
                          const std::vector<Prediction>& predictions) {
  constexpr double kFewInside = 0.8;
  if (!robot.uncertainty || predictions.empty()) return "";
  const auto share_inside = [&](const std::vector<Prediction>& bounds) {
    double inside = 0;
    for (size_t row = 0; row < bounds.size(); ++row)
      inside += evaluation.position[row] <= bounds[row].bound_95;
    return inside / static_cast<double>(bounds.size());
  };
  double inside = share_inside(predictions);
  if (inside >= kFewInside) return "";
  // A noisier instrument is no other arm.
  Robot judged = robot;
  InstrumentNoise& reading = judged.uncertainty->reading;
  const double noise = noise_floor(robot, campaign, evaluation).position;
  if (noise > reading.position) {
    reading.position = noise;
    inside = share_inside(predict(judged, campaign));
  }
  if (inside >= kFewInside || p_of_errors(judged, campaign) >= kNoChance) return "";
  std::set<int> beyond;
  for (int row = 0; row < campaign.rows(); ++row)
    if (predictions[row].leverage > 1) beyond.insert(campaign.pose[row]);
  const size_t poses = campaign.pose_ids.size();
  return fmt::format(
      "only {:.0f} % of the readings lie within the 95 % bounds that the robot file promises, at "
      "{} poses, which is no chance: {}",
      100 * inside, poses,
      2 * beyond.size() > poses
          ? fmt::format("{} of them lie outside what the calibration measured, where its model "
                        "does not hold; measure there, or look for effects with close-loop",
                        beyond.size())
          : "this is another arm or set-up than the calibrated one, or its model lacks something; "
            "refit base and tool if they are others, or calibrate anew");
}

}  // namespace armtrue
