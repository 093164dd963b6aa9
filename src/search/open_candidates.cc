#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "armtrue/campaign/sessions.h"
#include "armtrue/effects/gravity.h"
#include "armtrue/effects/sampling.h"
#include "armtrue/kinematics/units.h"
#include "search/candidates.h"
#include "search/driver_span.h"
#include "search/frequency_grid.h"

namespace armtrue {
namespace {

// Per turn: two cycles per turn of the motor behind the highest ratio that gears of robots usually
// have. Strain wave gears (up to 160) err twice per turn of their generator, which has two lobes
// (Tuttle, Seering, IEEE Trans. Robotics and Automation 12, 1996), resolvers and input stages of
// cycloidal gears (up to 204, makers' tables) once and twice per turn of the motor.
constexpr double kMaxCycles = 410;
constexpr double kFinestPitch = 5e-3;  // m: of a rack or a screw
// Curves that a campaign of some tens of poses can carry.
constexpr int kCurveCosines = 6, kCurveSplines = 8;
constexpr int kPosesForCoefficient = 4;  // of a fine curve; fewer would leave it to its prior

bool slides(const Robot& robot, int joint) { return is_prismatic(joint_link(robot.chain, joint)); }

double degree_of(const Robot& robot, int joint) {
  return slides(robot, joint) ? kTravelForDegree : kDegree;
}

// The highest frequency that is searched, per radian or, times 2 pi, per metre.
double most_cycles(const Robot& robot, int joint) {
  return slides(robot, joint) ? kTurn / kFinestPitch : kMaxCycles;
}

class OpenSearch {
 public:
  OpenSearch(const Robot& robot, const Campaign& campaign)
      : robot_(robot),
        campaign_(campaign),
        span_(time_span(campaign)),
        between_sessions_(session_driver(campaign)),
        layout_(layout_of(robot.chain)),
        joints_(joint_count(robot.chain)) {}

  // The angles of the joints: by far the likeliest place of an unknown error.
  void add_joint_errors() {
    for (int j = 0; j < joints_; ++j) {
      const Parameter parameter = named(zero_offset(robot_.chain, j));
      for (int d = 0; d < joints_; ++d) add_angle_shapes(parameter, d);
      for (int d = 0; d < joints_; ++d)
        add(parameter, {DriverKind::arrival, d, -1, ""}, sign_shape());
      add_places(parameter, {DriverKind::joint_angle, j, -1, ""});
      add_torque_series(parameter, j);
      add_time_shapes(parameter);
      add_session_steps(parameter);
      add_conditions(parameter);
    }
    close_stage();
  }

  // Every other parameter, one at a time.
  void add_other_parameters() {
    for (int k = 0; k < layout_.couplings; ++k) {
      if (is_zero_offset(robot_.chain, k)) continue;
      for (int d = 0; d < joints_; ++d) add_angle_shapes(named(k), d);
      for (int d = 0; d < joints_; ++d)
        add(named(k), {DriverKind::arrival, d, -1, ""}, sign_shape());
      add_time_shapes(named(k));
      add_conditions(named(k));
      if (k < layout_.tool && parameter_unit(robot_.chain, k) == ParameterUnit::radian)
        add(named(k), {DriverKind::moment, -1, -1, ""}, Shape{});
    }
    close_stage();
  }

  // Slow curves of the time, of all of the base or the tool together.
  void add_slow_curves() {
    if (!has_time(span_)) return;
    for (const Owner owner : {Owner::base, Owner::tool})
      add({owner, "", Parameter::kWhole}, {DriverKind::time, -1, -1, ""}, time_series());
    close_stage();
  }

  // Joint errors that need two drivers: two angles, or a curve over an angle, or a compliance,
  // multiplied by another driver.
  void add_products() {
    for (int j = 0; j < joints_; ++j) {
      const Parameter parameter = named(zero_offset(robot_.chain, j));
      for (int a = 0; a < joints_; ++a)
        for (int b = a + 1; b < joints_; ++b) {
          add(parameter, {DriverKind::joint_angle, a, b, ""},
              series_shape(SeriesBasis::fourier, 1));
        }
      add_growth(parameter, j, {DriverKind::time, -1, -1, ""});
      add_growth(parameter, j, {DriverKind::payload, -1, -1, ""});
      for (const std::string& where : campaign_.temperature_names)
        add_growth(parameter, j, {DriverKind::temperature, -1, -1, where});
      add_growth(parameter, j, {DriverKind::arrival, j, -1, ""});
      add_growth(parameter, j, {DriverKind::force, -1, -1, ""});
    }
    close_stage();
  }

  // Errors of the gear train and encoder of each joint: single cycles, and curves that are not a
  // sum of a few cycles.
  void add_own_angles() {
    for (int j = 0; j < joints_; ++j) {
      const Parameter parameter = named(zero_offset(robot_.chain, j));
      const Driver own{DriverKind::joint_angle, j, -1, ""};
      add_periodogram(parameter, own);
      add_fine_curves(parameter, own);
    }
    close_stage();
  }

  std::vector<Candidate> take() { return std::move(candidates_); }

 private:
  Parameter named(int index) const { return parameter_of(robot_.chain, index); }

  void add(const Parameter& parameter, const Driver& driver, const Shape& shape,
           bool detail = false) {
    if (!is_driven(driver, campaign_, span_)) return;
    Candidate candidate;
    candidate.effect = {"unexplained", parameter, driver, shape, {}};
    candidate.detail = detail;
    if (driver.kind == DriverKind::time && counts_from(shape.kind))
      candidate.effect.shape.at = begin_of_time(span_);
    if (is_travel(driver, robot_.chain)) candidate.degree = kTravelForDegree;
    candidates_.push_back(std::move(candidate));
  }

  void add_angle_shapes(const Parameter& parameter, int joint) {
    const Driver driver{DriverKind::joint_angle, joint, -1, ""};
    add(parameter, driver, Shape{});
    if (!slides(robot_, joint))
      for (int n : {1, 2, 3}) add(parameter, driver, harmonic_shape(n));
    if (is_zero_offset(robot_.chain, *find_parameter(robot_.chain, parameter)))
      add_bumps(parameter, driver);
    add_curves(parameter, driver);
  }

  // Outside the readings a curve keeps its value (Effect::driver_range). On a part of their range
  // cosines are nearly dependent: those of the whole travel would swing between few readings far
  // beyond their values.
  void add_curves(const Parameter& parameter, const Driver& driver) {
    const auto [low, high] = range_of_curve(campaign_, driver.joint, robot_.chain);
    if (!(low < high)) return;
    add(parameter, driver, series_shape(SeriesBasis::cosine, kCurveCosines, low, high));
    add(parameter, driver, series_shape(SeriesBasis::spline, kCurveSplines, low, high));
  }

  void add_growth(const Parameter& parameter, int joint, const Driver& with) {
    const auto times = [&](DriverKind kind, int of) {
      return Driver{kind, of, with.joint, with.where, with.kind};
    };
    for (int d = 0; d < joints_; ++d)
      for (const Shape& shape : {Shape{}, harmonic_shape(1)})
        if (shape.kind == ShapeKind::linear || !slides(robot_, d))
          add(parameter, times(DriverKind::joint_angle, d), shape);
    // Effects of arrival and force on a joint do not depend on its load.
    if (with.kind != DriverKind::arrival && with.kind != DriverKind::force)
      add(parameter, times(DriverKind::gravity_torque, joint), Shape{});
  }

  // From one whole cycle over the travel to the highest motor order.
  void add_periodogram(const Parameter& parameter, const Driver& driver) {
    const auto [low, high] = travel_covered(campaign_, driver.joint);
    const double covered = (high - low) / (2 * std::numbers::pi);
    if (covered * most_cycles(robot_, driver.joint) < 1) return;  // not one cycle of any
    const double step = 1 / (kFrequencySteps * covered);
    for (double n = 1 / covered; n <= most_cycles(robot_, driver.joint); n += step) {
      add(parameter, driver, harmonic_shape(readable(n)));
      candidates_.back().frequency_resolution = 1 / covered;
    }
  }

  // On a grid of knots that does not depend on where the poses are.
  void add_fine_curves(const Parameter& parameter, const Driver& driver) {
    const auto [low, high] = travel_covered(campaign_, driver.joint);
    for (double step : {20.0, 10.0, 5.0, 2.5}) {
      const double knot = step * degree_of(robot_, driver.joint);
      const double first = std::floor(low / knot), last = std::ceil(high / knot);
      const int count = static_cast<int>(last - first) + 2;
      if (count < 3 || count * kPosesForCoefficient > static_cast<int>(campaign_.pose_ids.size()))
        continue;
      add(parameter, driver, series_shape(SeriesBasis::spline, count, first * knot, last * knot));
      candidates_.back().fine = candidates_.back().detail = true;
    }
  }

  // A local error: a dent in a track, a collision of cables. Neighbours overlap at half height. The
  // widths are those of mechanical parts and do not depend on the travel limits.
  void add_bumps(const Parameter& parameter, const Driver& driver) {
    const bool own =
        *find_parameter(robot_.chain, parameter) == zero_offset(robot_.chain, driver.joint);
    const double degree = degree_of(robot_, driver.joint);
    const auto [low, high] = travel_covered(campaign_, driver.joint);
    const Span readings = span_of(driver, campaign_);
    for (double width : {80 * degree, 40 * degree, 20 * degree, 10 * degree}) {
      const bool narrow = width < 40 * degree;
      if (!own && narrow) continue;
      for (double k = std::floor(low / width); k <= std::ceil(high / width); ++k) {
        const Shape bump = series_shape(SeriesBasis::bump, 1, (k - 0.5) * width, (k + 0.5) * width);
        if (shows_bump(bump, readings)) add(parameter, driver, bump, narrow);
      }
    }
  }

  // An error that begins at an angle: a stop, a cable that tightens, a worn segment.
  void add_places(const Parameter& parameter, const Driver& driver) {
    for (ShapeKind kind : {ShapeKind::step, ShapeKind::kink})
      for (const Shape& inner : with_inner_values(Shape{kind}, span_of(driver, campaign_), kDegree))
        add(parameter, driver, inner, true);
  }

  void add_time_shapes(const Parameter& parameter) {
    const Driver driver{DriverKind::time, -1, -1, ""};
    if (!has_time(span_)) return;
    add(parameter, driver, Shape{});
    for (ShapeKind kind : {ShapeKind::step, ShapeKind::exponential})
      for (const Shape& inner : with_inner_values(Shape{kind}, span_, kDegree))
        add(parameter, driver, inner);
    add(parameter, driver, time_series());
  }

  void add_session_steps(const Parameter& parameter) {
    if (!between_sessions_ || is_of_each_session(parameter, robot_)) return;
    for (const Shape& inner :
         with_inner_values(Shape{ShapeKind::step}, span_of(*between_sessions_, campaign_), kDegree))
      add(parameter, *between_sessions_, inner);
  }

  Shape time_series() const {
    return series_shape(SeriesBasis::cosine, 4, span_.values.front(), span_.values.back());
  }

  void add_conditions(const Parameter& parameter) {
    for (const std::string& where : campaign_.temperature_names)
      add(parameter, {DriverKind::temperature, -1, -1, where}, Shape{});
    const Driver payload{DriverKind::payload, -1, -1, ""};
    add(parameter, payload, Shape{});
    // Free play that any load takes up.
    const std::set<double> loads(campaign_.payload_kg.begin(), campaign_.payload_kg.end());
    if (loads.contains(0) && loads.size() > 2) add(parameter, payload, sign_shape());
  }

  // A nonlinear effect of a torque: free play, stiffening, saturation.
  void add_torque_series(const Parameter& parameter, int joint) {
    const auto range = gravity_torques(robot_, joint);
    if (!range) return;
    const Driver driver{DriverKind::gravity_torque, joint, -1, ""};
    add(parameter, driver, series_shape(SeriesBasis::spline, 4, range->first, range->second));
    add(parameter, driver, sign_shape());
    for (double share : {0.4, 0.2, 0.1, 0.05}) add(parameter, driver, saturating_at(share, *range));
  }

  void close_stage() {
    const double choices = std::log(static_cast<double>(std::max<size_t>(1, candidates_.size())));
    for (size_t k = stage_; k < candidates_.size(); ++k) candidates_[k].log_choices = choices;
    stage_ = candidates_.size();
  }

  const Robot& robot_;
  const Campaign& campaign_;
  Span span_;
  std::optional<Driver> between_sessions_;
  ParameterLayout layout_;
  int joints_;
  std::vector<Candidate> candidates_;
  size_t stage_ = 0;
};

}  // namespace

std::optional<std::pair<double, double>> gravity_torques(const Robot& robot, int joint) {
  const GravityLoad load(robot, zero_offset(robot.chain, joint));
  if (!load.is_by_masses()) return std::nullopt;
  const ChainEvaluator chain(robot.chain);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const JointVector& q : sample_joint_space(robot.chain, 512)) {
    Context context;
    context.q = q;
    double torque = 0;
    load.values(context, chain.link_frames(q), &torque);
    low = std::min(low, torque);
    high = std::max(high, torque);
  }
  constexpr double kSmallestTorque = 1;  // N m: less does not turn a joint
  if (high - low < kSmallestTorque) return std::nullopt;
  return std::pair(low, high);
}

Shape saturating_at(double share, const std::pair<double, double>& range) {
  const double most = share * std::max(std::abs(range.first), std::abs(range.second));
  return series_shape(SeriesBasis::saturating, 1, -most, most);
}

std::vector<Candidate> open_candidates(const Robot& robot, const Campaign& campaign) {
  OpenSearch search(robot, campaign);
  search.add_joint_errors();
  search.add_products();
  search.add_other_parameters();
  search.add_slow_curves();
  search.add_own_angles();
  return search.take();
}

bool is_of_no_arm(const Effect& effect, const KinematicChain& chain) {
  const auto first = first_parameter(chain, effect.parameter);
  const bool is_length =
      is_arm_scale(effect.parameter) ||
      (first && layout_of(chain).is_of_links(*first) && !is_zero_offset(chain, *first) &&
       parameter_unit(chain, *first) == ParameterUnit::metre);
  if (effect.driver.involves(DriverKind::joint_angle))
    return !is_travel(effect.driver, chain) && (is_length || owner_of(effect) == Owner::base);
  const bool is_step_in_time =
      effect.driver.kind == DriverKind::time && effect.shape.kind == ShapeKind::step;
  return is_length && is_step_in_time;
}

}  // namespace armtrue
