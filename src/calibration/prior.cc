#include "calibration/prior.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "armtrue/calibration/usual_errors.h"
#include "armtrue/kinematics/names.h"
#include "armtrue/kinematics/parameters.h"
#include "linear_algebra/decompositions.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr double kMaxEffect = 0.005;  // m, rad: of a parameter, by one effect
constexpr double kTypicalCurve = 5e-4, kMinWidth = 1e-6;
constexpr size_t kMinOfCurve = 3;  // coefficients
constexpr double kSettled = 0.01;  // relative change of a width
// Typical error of an instrument, as a multiple of the scatter of its readings, and the residual of
// its laws, as a share of that: estimates that the readings may correct.
constexpr double kTimesNoise = 3, kRest = 0.3;
constexpr double kTypicalNoise = 1e-4;  // m, where the robot file states none
// Of a coefficient whose driver is zero in all rows, about the value that it has: it only keeps
// the information regular.
constexpr double kUndriven = 1;
constexpr double kFree = std::numeric_limits<double>::infinity();

enum Class { lengths, angles, zero_offsets, kClasses };

// Typical errors of links against data sheets: angles by the same tolerances as lengths, zero
// offsets by mastering by gauge or by mark.
std::vector<PriorWidth> typical_widths() {
  return {{"lengths", kUsualErrorOfLength, kSpreadOfArms, kUsualErrorOfLength},
          {"angles", 3e-4, kSpreadOfArms, 3e-4},
          {"zero offsets", 2e-3, kSpreadOfArms, 2e-3}};
}

Class class_of(const KinematicChain& chain, int parameter) {
  const int link = link_of_parameter(parameter);
  const bool moves = chain.links[link].joint != JointKind::fixed;
  if (moves && parameter == zero_of_link(chain, link)) return zero_offsets;
  return parameter_unit(chain, parameter) == ParameterUnit::metre ? lengths : angles;
}

double link_value(const KinematicChain& chain, int parameter) {
  const Link& link = chain.links[link_of_parameter(parameter)];
  switch (kind_of_parameter(parameter)) {
    case LinkParameter::alpha:
      return link.alpha;
    case LinkParameter::d:
      return link.d;
    case LinkParameter::theta:
      return link.theta;
    case LinkParameter::r:
      return link.r;
    case LinkParameter::beta:
      break;
  }
  return link.beta;
}

// Difference of a parameter of the links from its nominal value.
double from_nominal(const Robot& robot, int parameter, double value) {
  return robot.nominal ? value - link_value(*robot.nominal, parameter) : 0.0;
}

void add_geometry(const Robot& robot, const SessionModels& models, Priors& priors) {
  const ParameterLayout layout = layout_of(robot.chain);
  const auto add = [&](int unknown, int parameter, double value) {
    if (!layout.is_of_links(parameter) || places_positioner(robot, parameter)) return;
    const Class width = class_of(robot.chain, parameter);
    priors.of_unknowns.push_back(
        {unknown, priors.widths[width].deviation, from_nominal(robot, parameter, value), width});
  };
  for (int k = 0; k < models.geometric_count(); ++k) {
    const int parameter = models.geometric()[k];
    if (!robot.priors.contains(parameter_name(robot.chain, parameter)))
      add(k, parameter, layout.is_of_links(parameter) ? link_value(robot.chain, parameter) : 0);
  }
  for (int s = 1; s < models.sessions(); ++s)
    for (int k = 0; k < std::ssize(models.own(s)); ++k) {
      const int parameter = models.own(s)[k];
      if (!layout.is_of_links(parameter)) continue;
      double value = link_value(robot.chain, parameter);
      if (const auto known = robot.sessions.find(models.name(s)); known != robot.sessions.end())
        if (const auto own = known->second.zero.find(link_of_parameter(parameter));
            own != known->second.zero.end())
          value = own->second;
      add(models.first_own(s) + k, parameter, value);
    }
}

// A tool that gives way alike along all three axes is moved along gravity in every pose, which is a
// place of the base: only a difference of these coefficients shows. It gives way least along its
// axis, so this one stays.
constexpr size_t kAlongAxis = 8;  // "z c3"
constexpr double kHeld = 1e-6;    // share of the typical size

void add_sizes(const Robot& robot, const Effect& effect, std::vector<double>& sizes) {
  const size_t first = sizes.size();
  sizes.insert(sizes.end(), effect.coefficients.size(), effect.family->typical);
  if (effect.driver.kind == DriverKind::gravity_direction && is_group(effect.parameter) &&
      effect.shape.kind == ShapeKind::linear && !robot.ground_link)
    sizes[first + kAlongAxis] *= kHeld;
}

// Typical size of each coefficient of an effect that belongs to a family or is one; else empty.
std::vector<double> typical_sizes(const Robot& robot, const Effect& effect) {
  std::vector<double> sizes;
  if (effect.family && effect.members.empty()) add_sizes(robot, effect, sizes);
  for (const Effect& member : effect.members) add_sizes(robot, member, sizes);
  return sizes;
}

// The width that the members of the effect's family share, a factor of their typical sizes.
int width_of(const Effect& effect, Priors& priors) {
  constexpr double kWithinThree = 1.0986;  // ln 3: causes differ more than tolerances do
  const std::string& name =
      effect.members.empty() ? effect.family->name : effect.members.front().family->name;
  return index_of(priors.widths, PriorWidth{name, 1, kWithinThree, 1});
}

// No law describes an instrument exactly: a distortion beside other errors is their residual.
bool is_rest_of_instrument(const Robot& robot, const Effect& effect) {
  return is_polynomial(effect.shape) &&
         std::ranges::any_of(robot.effects, [&](const Effect& other) {
           return is_lasting_of_instrument(other) && !is_polynomial(other.shape);
         });
}

// Deviation of a coefficient at which an error of the instrument moves the readings by 1 m, RMS.
double unit_of_instrument(const Robot& robot, const Effect& effect, double mean_square) {
  const double range = (robot.chain.base.translation - instrument_place(robot)).norm();
  const bool turns = unit_of_parameter(robot.chain, effect.parameter) == ParameterUnit::radian;
  const auto count = static_cast<double>(effect.coefficients.size()) / group_size(effect.parameter);
  const double lever = turns ? std::max(1.0, range) : 1.0;
  return 1.0 / (lever * std::sqrt(mean_square * count));
}

// The residual has its own width: where a law is exact, the readings show that the residual is
// small, and it takes nothing from the lengths, however large the coefficient of the law is.
int width_of_instrument(const Robot& robot, const Effect& effect, Priors& priors) {
  constexpr double kWithinThree = 1.0986;  // ln 3
  const bool is_rest = is_rest_of_instrument(robot, effect);
  const std::string name = is_rest ? "rest of the instrument" : "errors of the instrument";
  const double noise = robot.noise.position > 0 ? robot.noise.position : kTypicalNoise;
  const double typical = (is_rest ? kRest : 1.0) * kTimesNoise * noise;
  return index_of(priors.widths, PriorWidth{name, typical, kWithinThree, typical});
}

void add_coefficients(const Robot& robot, const SessionModels& models, Priors& priors) {
  int k = models.geometric_count();
  for (int e = 0; e < models.fitted_effects(); ++e) {
    const Effect& effect = robot.effects[e];
    const bool of_instrument = is_lasting_of_instrument(effect);
    const bool is_curve = !of_instrument && effect.shape.kind == ShapeKind::series &&
                          effect.coefficients.size() >= kMinOfCurve;
    double squares = 0;
    for (const Coefficient& c : effect.coefficients) squares += c.value * c.value;
    const double as_before = std::sqrt(squares / static_cast<double>(effect.coefficients.size()));
    const double curve = squares > 0 ? std::max(kMinWidth, as_before) : kTypicalCurve;
    const auto width = static_cast<int>(priors.widths.size());
    if (is_curve) priors.widths.push_back({"", kTypicalCurve, kFree, curve});
    const std::vector<double> typical = typical_sizes(robot, effect);
    const int of_family = typical.empty() ? -1 : width_of(effect, priors);
    for (const Coefficient& c : effect.coefficients) {
      const double value = models.mean_square_value(k - models.geometric_count());
      if (of_instrument && value > 0) {
        const double unit = unit_of_instrument(robot, effect, value);
        const int shared = width_of_instrument(robot, effect, priors);
        priors.of_unknowns.push_back(
            {k, priors.widths[shared].deviation * unit, c.value, shared, unit});
      } else if (is_curve)
        priors.of_unknowns.push_back({k, curve, c.value, width});
      else if (!typical.empty()) {
        const double unit = typical[&c - effect.coefficients.data()];
        priors.of_unknowns.push_back(
            {k, priors.widths[of_family].deviation * unit, c.value, of_family, unit});
      } else if (value > 0)
        priors.of_unknowns.push_back({k, kMaxEffect / std::sqrt(value), c.value});
      else
        priors.of_unknowns.push_back({k, kUndriven});
      ++k;
    }
  }
}

// The root tau of sum of squares / tau^2 = determined + ln(tau / typical) / log_spread^2, of which
// the left side falls and the right side rises.
double most_likely(const PriorWidth& width, double squares, double determined) {
  if (width.log_spread == kFree)
    return std::clamp(std::sqrt(squares / std::max(determined, 0.5)), kMinWidth, kMaxEffect);
  const double pull = 1 / (width.log_spread * width.log_spread);
  double low = std::log(width.typical) - 20, high = std::log(width.typical) + 20;
  while (high - low > 1e-6) {
    const double middle = 0.5 * (low + high);
    const double excess =
        squares * std::exp(-2 * middle) - determined - pull * (middle - std::log(width.typical));
    (excess > 0 ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

}  // namespace

Priors priors_of(const Robot& robot, const SessionModels& models) {
  Priors priors;
  for (int k = 0; k < models.geometric_count(); ++k) {
    const auto found = robot.priors.find(parameter_name(robot.chain, models.geometric()[k]));
    if (found == robot.priors.end()) continue;
    const int parameter = models.geometric()[k];
    const double start = layout_of(robot.chain).is_of_links(parameter)
                             ? from_nominal(robot, parameter, link_value(robot.chain, parameter))
                             : 0.0;
    priors.of_unknowns.push_back({k, found->second, start});
  }
  if (!robot.free_links) {
    priors.widths = typical_widths();
    add_geometry(robot, models, priors);
  }
  add_coefficients(robot, models, priors);
  return priors;
}

double prior_deviation(const Robot& robot, int parameter,
                       const std::map<std::string, double>& widths) {
  const auto stated = robot.priors.find(parameter_name(robot.chain, parameter));
  if (stated != robot.priors.end()) return stated->second;
  if (!layout_of(robot.chain).is_of_links(parameter) || places_positioner(robot, parameter))
    return 0;
  const PriorWidth typical = typical_widths()[class_of(robot.chain, parameter)];
  const auto found = widths.find(typical.name);
  return found == widths.end() ? typical.deviation : found->second;
}

Eigen::VectorXd prior_information(const std::vector<Prior>& priors, Eigen::Index unknowns) {
  Eigen::VectorXd information = Eigen::VectorXd::Zero(unknowns);
  for (const Prior& prior : priors)
    information[prior.unknown] += 1.0 / (prior.deviation * prior.deviation);
  return information;
}

namespace {

// Of the diagonal of (L L^T)^-1 the places of unknowns with priors: the squares of columns of L^-1,
// which are zero above the diagonal.
void set_diagonal_of_inverse(const Eigen::LLT<Eigen::MatrixXd>& llt,
                             const std::vector<Prior>& priors, Eigen::VectorXd& inverse) {
  constexpr int kColumnsPerBlock = 128;  // fewer are faster than a thread
  std::vector<Eigen::Index> asked;
  for (const Prior& prior : priors) asked.push_back(prior.unknown);
  std::sort(asked.begin(), asked.end());
  // No range: clang 14 does not compile that of libstdc++ 12.
  asked.erase(std::unique(asked.begin(), asked.end()), asked.end());
  for_ordered_blocks<int>(
      static_cast<int>(asked.size()), kColumnsPerBlock,
      [&](int begin, int end) {
        const Eigen::Index first = asked[begin];
        const Eigen::Index left = llt.cols() - first;
        Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(left, end - begin);
        for (int k = begin; k < end; ++k) columns(asked[k] - first, k - begin) = 1;
        llt.matrixLLT()
            .bottomRightCorner(left, left)
            .triangularView<Eigen::Lower>()
            .solveInPlace(columns);
        for (int k = begin; k < end; ++k) inverse[asked[k]] = columns.col(k - begin).squaredNorm();
        return 0;
      },
      [](int) {});
}

// Posterior variances of the unknowns that have priors, which are few of those of many sessions:
// those of the others are not computed. `of_readings` counts `factor` times.
Eigen::VectorXd variances(const Eigen::MatrixXd& of_readings, const Priors& priors, double factor,
                          const SparseCholesky::Blocks& blocks) {
  const Eigen::Index p = of_readings.cols();
  const Eigen::VectorXd of_priors = prior_information(priors.of_unknowns, p) / factor;
  if (is_sparse(of_readings)) {
    const SparseCholesky sparse(of_readings, of_priors, blocks);
    Eigen::VectorXd variances = Eigen::VectorXd::Zero(p);
    for (const Prior& prior : priors.of_unknowns)
      if (sparse.succeeded()) variances[prior.unknown] = sparse.variance(prior.unknown) / factor;
    if (sparse.succeeded()) return variances;
  }
  Eigen::MatrixXd information = of_readings;
  information.diagonal() += of_priors;
  const Eigen::VectorXd unit = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(p);
  const Eigen::LLT<Eigen::MatrixXd> llt(scaled);
  if (llt.info() == Eigen::Success)
    set_diagonal_of_inverse(llt, priors.of_unknowns, inverse);
  else
    inverse = Eigen::MatrixXd(scaled.ldlt().solve(identity(p))).diagonal();
  return inverse.cwiseProduct(unit.cwiseAbs2()) / factor;
}

double share_of_prior(const Prior& prior, const Eigen::VectorXd& variances) {
  return std::clamp(variances[prior.unknown] / (prior.deviation * prior.deviation), 0.0, 1.0);
}

void set_deviations(Priors& priors) {
  for (Prior& prior : priors.of_unknowns)
    if (prior.width >= 0) prior.deviation = priors.widths[prior.width].deviation * prior.unit;
}

}  // namespace

void scale_widths(double factor, Priors& priors) {
  for (PriorWidth& width : priors.widths)
    if (width.log_spread != kFree) width.deviation = factor * width.typical;
  set_deviations(priors);
}

void set_widths(const std::map<std::string, double>& widths, Priors& priors) {
  for (PriorWidth& width : priors.widths)
    if (const auto known = widths.find(width.name); known != widths.end())
      width.deviation = known->second;
  set_deviations(priors);
}

double undetermined(const Eigen::MatrixXd& information, const Priors& priors,
                    const SparseCholesky::Blocks& blocks) {
  if (priors.widths.empty()) return 0;
  const Eigen::VectorXd variance = variances(information, priors, 1, blocks);
  double sum = 0;
  for (const Prior& prior : priors.of_unknowns)
    if (prior.width >= 0) sum += share_of_prior(prior, variance);
  return sum;
}

bool update_widths(const Eigen::MatrixXd& information, const Eigen::VectorXd& x, Priors& priors,
                   double factor, const SparseCholesky::Blocks& blocks) {
  if (priors.widths.empty()) return true;
  const Eigen::VectorXd variance = variances(information, priors, factor, blocks);
  struct Sum {
    double determined = 0, squares = 0;
    int count = 0;
  };
  std::vector<Sum> sums(priors.widths.size());
  for (const Prior& prior : priors.of_unknowns) {
    if (prior.width < 0) continue;
    const double change = (prior.start + x[prior.unknown]) / prior.unit;
    sums[prior.width].determined += 1.0 - share_of_prior(prior, variance);
    sums[prior.width].squares += change * change;
    ++sums[prior.width].count;
  }
  bool settled = true;
  for (size_t w = 0; w < sums.size(); ++w) {
    if (sums[w].count == 0) continue;
    PriorWidth& width = priors.widths[w];
    const double deviation = most_likely(width, sums[w].squares, sums[w].determined);
    settled = settled && std::abs(deviation - width.deviation) < kSettled * width.deviation;
    width.deviation = deviation;
  }
  set_deviations(priors);
  return settled;
}

}  // namespace armtrue
