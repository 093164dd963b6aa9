#include "diagnosis/scale_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "armtrue/calibration/usual_errors.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/distributions.h"

namespace armtrue {

std::optional<std::string> find_scale_of_anchor(const PlainFit& fit) {
  constexpr double kShareThatMatters = 0.25, kLeastScale = 1e-3;
  const Campaign& readings = fit.readings;
  if (!readings.reads_one_number() || readings.anchor_names.size() < 2) return std::nullopt;
  const KinematicChain& chain = fit.result.robot.chain;
  const FitEquations equations = fit_equations(fit, {layout_of(chain).instrument_scale});
  std::set<int> readings_of_poses;  // repeats have one error of the model
  for (int row = 0; row < readings.rows(); ++row)
    readings_of_poses.insert(readings.pose_by_quantity(row));
  std::optional<std::string> found;
  double best = kClearFall;
  for (int anchor = 0; anchor < std::ssize(readings.anchor_names); ++anchor) {
    Eigen::VectorXd is_of_anchor(readings.rows());
    for (int row = 0; row < readings.rows(); ++row)
      is_of_anchor[row] =
          readings.anchor[row] == anchor && readings.kind(row) == ReadingKind::distance ? 1 : 0;
    const JointFit scale =
        fit_beside(times_of_rows(equations.columns.col(0), is_of_anchor), equations);
    const double fall = fall_of_bic(scale, equations, static_cast<double>(readings_of_poses.size()),
                                    static_cast<double>(readings.anchor_names.size()));
    if (std::abs(scale.value[0]) < kLeastScale || scale.share < kShareThatMatters || fall <= best)
      continue;
    best = fall;
    found = fmt::format(
        "the distances from anchor {} are too {} by {:.2g} %, those from the others are not: check "
        "the scale of that instrument (its drum, its unit)",
        readings.anchor_names[anchor], scale.value[0] > 0 ? "long" : "short",
        100 * std::abs(scale.value[0]));
  }
  return found;
}

namespace {

std::string what_sets_the_scale(const Campaign& readings) {
  if (readings.has_pixels_only()) return "the pitch of the board";
  if (readings.has_touches_only() && !readings.has_beams_only())
    return "the sizes of what is touched";
  return "the scale and the unit of the instrument";
}

// Of a link; where a positioner stands is known roughly only.
bool is_length_of_arm(const Robot& nominal, int parameter) {
  return layout_of(nominal.chain).is_of_links(parameter) &&
         parameter_unit(nominal.chain, parameter) == ParameterUnit::metre &&
         !places_positioner(nominal, parameter);
}

double nominal_length(const KinematicChain& chain, int parameter) {
  const Link& link = chain.links[link_of_parameter(parameter)];
  return kind_of_parameter(parameter) == LinkParameter::d ? link.d : link.r;
}

// Of each fitted parameter that is a length of the arm, the length and its change; 0 of the others.
struct FittedLengths {
  Eigen::VectorXd length, change;
  int count = 0;
};

// Of lengths along parallel axes the fit has one, which stands for their sum.
FittedLengths fitted_lengths(const PlainFit& fit, const Robot& nominal) {
  const std::vector<int>& kept = fit.result.set.kept;
  FittedLengths fitted{Eigen::VectorXd::Zero(fit.result.change.size()),
                       Eigen::VectorXd::Zero(fit.result.change.size())};
  std::vector<int> others;
  std::vector<double> of_others;
  for (int parameter = 0; parameter < parameter_count(nominal.chain); ++parameter) {
    if (!is_length_of_arm(nominal, parameter)) continue;
    const double length = nominal_length(nominal.chain, parameter);
    const auto k = std::ranges::find(kept, parameter) - kept.begin();
    if (k < std::ssize(kept)) {
      fitted.length[k] = length;
      fitted.change[k] = fit.result.change[k];
      ++fitted.count;
    } else if (length != 0) {
      others.push_back(parameter);
      of_others.push_back(length);
    }
  }
  const Eigen::VectorXd alike = like_changes(
      fit, others, Eigen::Map<const Eigen::VectorXd>(of_others.data(), std::ssize(of_others)));
  for (Eigen::Index k = 0; k < std::ssize(kept); ++k)
    if (is_length_of_arm(nominal, kept[k])) fitted.length[k] += alike[k];
  return fitted;
}

// The probability that lengths without a common scale show one of this size, by chance. `scaled`:
// what the scale changes, as a root of a sum of squares; `rest`: the sum of squares of what it
// leaves of so many numbers [m]. Both follow the errors of this arm, whose size s is known from
// `rest` and from other arms: ln s ~ N(ln kUsualErrorOfLength, kSpreadOfArms^2).
double p_of_scale(double scaled, double rest, double numbers) {
  constexpr int kSteps = 200;
  constexpr double kDeviations = 6;
  double sum = 0, above = 0;
  for (int step = -kSteps; step <= kSteps; ++step) {
    const double deviations = kDeviations * step / kSteps;
    const double size = kUsualErrorOfLength * std::exp(kSpreadOfArms * deviations);
    const double weight = std::exp(-0.5 * deviations * deviations - 0.5 * rest / (size * size)) *
                          std::pow(kUsualErrorOfLength / size, numbers);
    sum += weight;
    above += weight * normal_below(-scaled / size);
  }
  return sum > 0 ? above / sum : 1;  // no arm errs so much
}

}  // namespace

std::optional<std::string> find_scale_of_links(const PlainFit& fit, const Robot& nominal) {
  constexpr double kLeastScale = 1e-3, kChance = 1e-4, kClearly = 5;  // standard deviations
  constexpr int kFewestLengths = 3;
  constexpr double kLeastLength = 1e-3;  // m
  const auto [lengths, changes, changed] = fitted_lengths(fit, nominal);
  if ((lengths.array().abs() > kLeastLength).count() < kFewestLengths) return std::nullopt;
  const double square = lengths.squaredNorm(), scale = lengths.dot(changes) / square;
  const double by_readings =
      std::sqrt(std::max(0.0, lengths.dot(fit.result.covariance * lengths))) / square;
  const double rest = (changes - scale * lengths).squaredNorm();
  if (std::abs(scale) < std::max(kLeastScale, kClearly * by_readings)) return std::nullopt;
  if (p_of_scale(std::abs(scale) * std::sqrt(square), rest, changed - 1) > kChance)
    return std::nullopt;
  return fmt::format(
      "the links come out {} by {:.2g} % alike, as no arm is made: check {}, or the lengths of the "
      "robot file",
      scale > 0 ? "longer" : "shorter", 100 * std::abs(scale), what_sets_the_scale(fit.readings));
}

}  // namespace armtrue
