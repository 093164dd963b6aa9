#include "search/candidates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "armtrue/effects/gravity.h"
#include "armtrue/effects/sampling.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr int kStepGrid = 32;       // places of a step that are scanned; the best is then refined
constexpr size_t kMaxSteps = 2000;  // for its interval: finer than any campaign tells
constexpr double kMaxCycles = 300;  // per turn: motor order behind a reducer
// Of a periodogram, within its resolution: at the worst place between two steps 3 % of the
// amplitude are lost.
constexpr int kFrequencySteps = 4;
constexpr int kFinerSteps = 100;         // within one of those
constexpr int kSeriesCosines = 6;        // a curve that a campaign of some tens of poses can carry
constexpr int kPosesForCoefficient = 4;  // of a fine curve; fewer would leave it to its prior

// Values of a driver, distinct and ascending.
struct Span {
  std::vector<double> values;
  double length() const { return values.empty() ? 0 : values.back() - values.front(); }
};

Span time_span(const Campaign& campaign) {
  const std::set<double> distinct(campaign.time_s.begin(), campaign.time_s.end());
  return {{distinct.begin(), distinct.end()}};
}

// What a width of a degree becomes on a joint that slides: its arc on a pinion of 140 mm.
constexpr double kTravelForDegree = 2.5e-3;  // m
constexpr double kFinestPitch = 5e-3;        // m: of a rack or a screw

bool slides(const Robot& robot, int joint) { return is_prismatic(joint_link(robot.chain, joint)); }

double degree_of(const Robot& robot, int joint) {
  return slides(robot, joint) ? kTravelForDegree : kDegree;
}

// The highest frequency that is searched, per radian or, times 2 pi, per metre.
double most_cycles(const Robot& robot, int joint) {
  return slides(robot, joint) ? kTurn / kFinestPitch : kMaxCycles;
}

// Of the time or of a joint angle.
Span span_of(const Driver& driver, const Campaign& campaign) {
  if (driver.kind != DriverKind::joint_angle) return time_span(campaign);
  std::set<double> distinct;
  for (const JointVector& q : campaign.q) distinct.insert(q[driver.joint]);
  return {{distinct.begin(), distinct.end()}};
}

bool has_time(const Span& span) { return span.values.size() > 2; }

// Between readings, evenly over their number; the ends leave too few readings to show a step.
std::vector<double> step_places(const Span& span, int count) {
  std::vector<double> steps;
  const size_t n = span.values.size();
  for (int k = 1; k <= count; ++k) {
    const size_t i = n * static_cast<size_t>(k) / static_cast<size_t>(count + 1);
    if (i < 1 || i >= n) continue;
    const double at = 0.5 * (span.values[i - 1] + span.values[i]);
    if (steps.empty() || at > steps.back()) steps.push_back(at);
  }
  return steps;
}

std::vector<double> scales_of(const Shape& shape, const Span& span, double degree) {
  if (shape.kind == ShapeKind::pre_sliding)
    return {0.5 * degree, 1 * degree, 2 * degree, 4 * degree, 8 * degree, 16 * degree, 32 * degree};
  std::vector<double> constants;
  for (double share : {0.05, 0.1, 0.2, 0.4, 0.8}) constants.push_back(share * span.length());
  return constants;
}

// One shape without inner values, or each of its grid; `degree` as Candidate has it.
std::vector<Shape> with_inner_values(const Shape& shape, const Span& span, double degree) {
  std::vector<Shape> shapes;
  if (has_at(shape.kind))
    for (double at : step_places(span, kStepGrid)) {
      shapes.push_back(shape);
      shapes.back().at = at;
    }
  else if (has_tau(shape.kind))
    for (double tau : scales_of(shape, span, degree)) {
      shapes.push_back(shape);
      shapes.back().tau = tau;
    }
  else
    shapes.push_back(shape);
  return shapes;
}

template <typename Values>
bool varies(const Values& values) {
  return std::any_of(values.begin(), values.end(),
                     [&](const auto& value) { return value != values.front(); });
}

// Whether the campaign holds what drives the effect, and it changes.
bool is_driven(DriverKind kind, const std::string& where, const Campaign& campaign,
               const Span& span) {
  switch (kind) {
    case DriverKind::time:
      return has_time(span);
    case DriverKind::payload:
      return varies(campaign.payload_kg);
    case DriverKind::force:
      return varies(campaign.force_n);
    default:
      return missing_column(campaign, kind, where).empty();
  }
}
bool is_driven(const Driver& driver, const Campaign& campaign, const Span& span) {
  return is_driven(driver.kind, driver.where, campaign, span) &&
         (!driver.factor || is_driven(*driver.factor, driver.where, campaign, span));
}

// Ranges come from the travel limits, never from the data: a range that follows the data makes
// predictions elsewhere worse.
Shape series_on_joint(const Robot& robot, int joint, SeriesBasis basis, int count) {
  Shape shape;
  shape.kind = ShapeKind::series;
  shape.basis = basis;
  shape.count = count;
  const auto [low, high] = travel(joint_link(robot.chain, joint));
  shape.low[0] = low;
  shape.high[0] = high;
  return shape;
}

Shape harmonic(double n) {
  Shape shape;
  shape.kind = ShapeKind::harmonic;
  shape.harmonic = n;
  return shape;
}

// No campaign shows more digits of a frequency.
double readable(double cycles_per_turn) { return std::round(1e4 * cycles_per_turn) / 1e4; }

class OpenSearch {
 public:
  OpenSearch(const Robot& robot, const Campaign& campaign)
      : robot_(robot),
        campaign_(campaign),
        span_(time_span(campaign)),
        layout_(layout_of(robot.chain)),
        joints_(joint_count(robot.chain)) {}

  // The angles of the joints: by far the likeliest place of an unknown error.
  void add_joint_errors() {
    for (int j = 0; j < joints_; ++j) {
      const std::string parameter = name(zero_offset(robot_.chain, j));
      for (int d = 0; d < joints_; ++d) add_angle_shapes(parameter, d);
      for (int d = 0; d < joints_; ++d) add(parameter, {DriverKind::arrival, d, -1, ""}, sign());
      add_places(parameter, {DriverKind::joint_angle, j, -1, ""});
      add_torque_series(parameter, j);
      add_time_shapes(parameter);
      add_conditions(parameter);
    }
    close_stage();
  }

  // Every other parameter, one at a time.
  void add_other_parameters() {
    for (int k = 0; k < layout_.geometric; ++k) {
      if (is_zero_offset(robot_.chain, k)) continue;
      for (int d = 0; d < joints_; ++d) add_angle_shapes(name(k), d);
      for (int d = 0; d < joints_; ++d) add(name(k), {DriverKind::arrival, d, -1, ""}, sign());
      add_time_shapes(name(k));
      add_conditions(name(k));
      if (k < layout_.tool && parameter_unit(robot_.chain, k) == ParameterUnit::radian)
        add(name(k), {DriverKind::moment, -1, -1, ""}, Shape{});
    }
    close_stage();
  }

  // Slow curves of the time, of all of the base or the tool together.
  void add_slow_curves() {
    if (!has_time(span_)) return;
    for (const char* group : {"base", "tool"})
      add(group, {DriverKind::time, -1, -1, ""}, time_series());
    close_stage();
  }

  // Joint errors that need two drivers: two angles, or a course over an angle, or a compliance,
  // that grows with another.
  void add_products() {
    for (int j = 0; j < joints_; ++j) {
      const std::string parameter = name(zero_offset(robot_.chain, j));
      for (int a = 0; a < joints_; ++a)
        for (int b = a + 1; b < joints_; ++b) {
          Shape shape;
          shape.kind = ShapeKind::series;
          shape.basis = SeriesBasis::fourier;
          shape.count = 1;
          add(parameter, {DriverKind::joint_angle, a, b, ""}, shape);
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

  // What each joint's gear train and encoder do: single cycles, and curves that are no sum of few.
  void add_own_angles() {
    for (int j = 0; j < joints_; ++j) {
      const std::string parameter = name(zero_offset(robot_.chain, j));
      const Driver own{DriverKind::joint_angle, j, -1, ""};
      add_periodogram(parameter, own);
      add_fine_curves(parameter, own);
    }
    close_stage();
  }

  std::vector<Candidate> take() { return std::move(candidates_); }

 private:
  std::string name(int parameter) const { return parameter_name(robot_.chain, parameter); }
  static Shape sign() {
    Shape shape;
    shape.kind = ShapeKind::sign;
    return shape;
  }

  void add(const std::string& parameter, const Driver& driver, const Shape& shape,
           bool detail = false) {
    if (!is_driven(driver, campaign_, span_)) return;
    Candidate candidate;
    candidate.effect = {"unexplained", parameter, driver, shape, {}};
    candidate.detail = detail;
    if (is_travel(driver, robot_.chain)) candidate.degree = kTravelForDegree;
    candidates_.push_back(std::move(candidate));
  }

  void add_angle_shapes(const std::string& parameter, int joint) {
    const Driver driver{DriverKind::joint_angle, joint, -1, ""};
    add(parameter, driver, Shape{});
    if (!slides(robot_, joint))
      for (int n : {1, 2, 3}) add(parameter, driver, harmonic(n));
    if (is_zero_offset(robot_.chain, *find_parameter(robot_.chain, parameter)))
      add_bumps(parameter, driver);
    add(parameter, driver, series_on_joint(robot_, joint, SeriesBasis::cosine, kSeriesCosines));
    add(parameter, driver, series_on_joint(robot_, joint, SeriesBasis::spline, 8));
  }

  void add_growth(const std::string& parameter, int joint, const Driver& with) {
    const auto times = [&](DriverKind kind, int of) {
      return Driver{kind, of, with.joint, with.where, with.kind};
    };
    for (int d = 0; d < joints_; ++d)
      for (const Shape& shape : {Shape{}, harmonic(1)})
        if (shape.kind == ShapeKind::linear || !slides(robot_, d))
          add(parameter, times(DriverKind::joint_angle, d), shape);
    // What arrival and force do to a joint is no matter of its load.
    if (with.kind != DriverKind::arrival && with.kind != DriverKind::force)
      add(parameter, times(DriverKind::gravity_torque, joint), Shape{});
  }

  // From where the cosines of the open series end, and a whole cycle is covered, to the highest
  // motor order.
  void add_periodogram(const std::string& parameter, const Driver& driver) {
    const auto [low, high] = travel_covered(driver.joint);
    const double covered = (high - low) / (2 * std::numbers::pi);
    if (covered * most_cycles(robot_, driver.joint) < 1) return;  // not one cycle of any
    const Shape whole = series_on_joint(robot_, driver.joint, SeriesBasis::cosine, kSeriesCosines);
    const double step = 1 / (kFrequencySteps * covered);
    const double first =
        std::max(1 / covered, kSeriesCosines * std::numbers::pi / (whole.high[0] - whole.low[0]));
    for (double n = std::ceil(first / step) * step; n <= most_cycles(robot_, driver.joint);
         n += step) {
      add(parameter, driver, harmonic(readable(n)));
      candidates_.back().frequency_resolution = 1 / covered;
    }
  }

  // On a grid of knots that does not depend on where the poses are.
  void add_fine_curves(const std::string& parameter, const Driver& driver) {
    const auto [low, high] = travel_covered(driver.joint);
    for (double step : {20.0, 10.0, 5.0, 2.5}) {
      const double knot = step * degree_of(robot_, driver.joint);
      const double first = std::floor(low / knot), last = std::ceil(high / knot);
      const int count = static_cast<int>(last - first) + 2;
      if (count < 3 || count * kPosesForCoefficient > static_cast<int>(campaign_.pose_ids.size()))
        continue;
      Shape shape = series_on_joint(robot_, driver.joint, SeriesBasis::spline, count);
      shape.low[0] = first * knot;
      shape.high[0] = last * knot;
      add(parameter, driver, shape);
      candidates_.back().fine = candidates_.back().detail = true;
    }
  }

  std::pair<double, double> travel_covered(int joint) const {
    const auto [low, high] =
        std::minmax_element(campaign_.q.begin(), campaign_.q.end(),
                            [&](const auto& a, const auto& b) { return a[joint] < b[joint]; });
    return {(*low)[joint], (*high)[joint]};
  }

  // Something local: a dent in a track, a collision of cables. Neighbours overlap at half height.
  // The widths are those of mechanical parts, whatever the travel limits say.
  void add_bumps(const std::string& parameter, const Driver& driver) {
    const bool own =
        *find_parameter(robot_.chain, parameter) == zero_offset(robot_.chain, driver.joint);
    const double degree = degree_of(robot_, driver.joint);
    const auto [low, high] = travel_covered(driver.joint);
    for (double width : {80 * degree, 40 * degree, 20 * degree, 10 * degree}) {
      const bool narrow = width < 40 * degree;
      if (!own && narrow) continue;
      for (double k = std::floor(low / width); k <= std::ceil(high / width); ++k) {
        Shape shape = series_on_joint(robot_, driver.joint, SeriesBasis::bump, 1);
        shape.low[0] = (k - 0.5) * width;
        shape.high[0] = (k + 0.5) * width;
        add(parameter, driver, shape, narrow);
      }
    }
  }

  // Something that begins at an angle: a stop, a cable that tightens, a worn segment.
  void add_places(const std::string& parameter, const Driver& driver) {
    for (ShapeKind kind : {ShapeKind::step, ShapeKind::kink}) {
      Shape shape;
      shape.kind = kind;
      for (const Shape& inner : with_inner_values(shape, span_of(driver, campaign_), kDegree))
        add(parameter, driver, inner, true);
    }
  }

  void add_time_shapes(const std::string& parameter) {
    const Driver driver{DriverKind::time, -1, -1, ""};
    if (!has_time(span_)) return;
    add(parameter, driver, Shape{});
    for (ShapeKind kind : {ShapeKind::step, ShapeKind::exponential}) {
      Shape shape;
      shape.kind = kind;
      for (const Shape& inner : with_inner_values(shape, span_, kDegree))
        add(parameter, driver, inner);
    }
    add(parameter, driver, time_series());
  }

  Shape time_series() const {
    Shape series;
    series.kind = ShapeKind::series;
    series.count = 4;
    series.low[0] = span_.values.front();
    series.high[0] = span_.values.back();
    return series;
  }

  void add_conditions(const std::string& parameter) {
    for (const std::string& where : campaign_.temperature_names)
      add(parameter, {DriverKind::temperature, -1, -1, where}, Shape{});
    add(parameter, {DriverKind::payload, -1, -1, ""}, Shape{});
  }

  // A torque that does not act in proportion: free play, stiffening, saturation.
  void add_torque_series(const std::string& parameter, int joint) {
    if (robot_.bodies.empty()) return;
    const GravityLoad load(robot_, zero_offset(robot_.chain, joint));
    const ChainEvaluator chain(robot_.chain);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const JointVector& q : sample_joint_space(robot_.chain, 512)) {
      Context context;
      context.q = q;
      double torque = 0;
      load.values(context, chain.link_frames(q), &torque);
      low = std::min(low, torque);
      high = std::max(high, torque);
    }
    if (high - low < 1.0) return;  // N m: gravity does not turn this joint
    const Driver driver{DriverKind::gravity_torque, joint, -1, ""};
    Shape series;
    series.kind = ShapeKind::series;
    series.basis = SeriesBasis::spline;
    series.count = 4;
    series.low[0] = low;
    series.high[0] = high;
    add(parameter, driver, series);
    add(parameter, driver, sign());
    for (double share : {0.4, 0.2, 0.1, 0.05}) {
      Shape saturating;
      saturating.kind = ShapeKind::series;
      saturating.basis = SeriesBasis::saturating;
      saturating.count = 1;
      saturating.high[0] = share * std::max(std::abs(low), std::abs(high));
      saturating.low[0] = -saturating.high[0];
      add(parameter, driver, saturating);
    }
  }

  void close_stage() {
    const double choices = std::log(static_cast<double>(std::max<size_t>(1, candidates_.size())));
    for (size_t k = stage_; k < candidates_.size(); ++k) candidates_[k].log_choices = choices;
    stage_ = candidates_.size();
  }

  const Robot& robot_;
  const Campaign& campaign_;
  Span span_;
  ParameterLayout layout_;
  int joints_;
  std::vector<Candidate> candidates_;
  size_t stage_ = 0;
};

}  // namespace

namespace {

bool is_load(DriverKind kind) {
  return kind == DriverKind::gravity_torque || kind == DriverKind::moment;
}

// Whether gravity has one basis for all components of a group that its moment turns; arms whose
// first axis is not upright need masses for that.
bool has_common_basis(const Effect& effect, const Robot& robot) {
  if (effect.driver.kind != DriverKind::moment || group_size(effect.parameter) != 6) return true;
  std::set<int> sizes;
  const int first = *first_parameter(robot.chain, effect.parameter);
  for (int k = first + 3; k < first + 6; ++k)
    if (const int size = GravityLoad(robot, k).value_count(); size > 0) sizes.insert(size);
  return sizes.size() <= 1;
}

// Whether the robot has what an entry of the catalogue needs, and the campaign reads what it moves.
bool is_shown(const Effect& effect, const Robot& robot, const Campaign& campaign) {
  const Driver& driver = effect.driver;
  const bool needs_masses = (is_load(driver.kind) && effect.shape.kind != ShapeKind::linear) ||
                            (driver.factor && is_load(*driver.factor));
  if (needs_masses && robot.bodies.empty()) return false;
  if (!has_common_basis(effect, robot)) return false;
  const std::string& parameter = effect.parameter;
  if (parameter.starts_with("target "))
    return std::ranges::count(campaign.target_names, parameter.substr(7)) > 0;
  if (parameter.starts_with("anchor ")) return campaign.has_distances();
  if (parameter == kPointOfInstrument) return !campaign.has_distances();
  const bool by_sight = parameter.starts_with("instrument.") && parameter != "instrument.scale";
  return !by_sight ||
         (knows_instrument(robot) && (!campaign.has_distances() || campaign.has_coordinates()));
}

// A cube about the places measured.
void set_range_of_places(const Robot& robot, const Campaign& campaign, Shape& shape) {
  const ChainEvaluator chain(robot.chain);
  Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array3d high = -low;
  for (const JointVector& q : campaign.q) {
    const Eigen::Vector3d place = chain.link_frames(q).back() * robot.chain.tool.translation;
    low = low.min(place.array());
    high = high.max(place.array());
  }
  const double half = 0.5 * (high - low).maxCoeff();
  for (int axis = 0; axis < 3; ++axis) {
    shape.low[axis] = 0.5 * (low[axis] + high[axis]) - half;
    shape.high[axis] = 0.5 * (low[axis] + high[axis]) + half;
  }
}

// Whether nearly all ways since a reversal are so long that the shape is backlash, an effect of
// its own: its values correlate with the direction by more than what counts as the same.
bool is_plain_sign(const Shape& shape, const Driver& driver, const Campaign& campaign) {
  if (shape.kind != ShapeKind::pre_sliding) return false;
  constexpr double kSame = 0.98;
  double product = 0, squares = 0, moved = 0;
  for (const JointVector& stroke : campaign.stroke) {
    double value = 0;
    const double way = stroke[driver.joint];
    evaluate(shape, way, &value);
    product += way < 0 ? -value : value;
    squares += value * value;
    moved += way != 0;
  }
  return product >= kSame * std::sqrt(squares * moved);
}

}  // namespace

std::vector<Candidate> catalogue_candidates(const Catalogue& catalogue, const Robot& robot,
                                            const Campaign& campaign) {
  const Span span = time_span(campaign);
  std::vector<Candidate> candidates;
  std::vector<Usual> usual;
  for (const CatalogueEntry& entry : catalogue)
    for (const Effect& effect : expand(entry, robot)) {
      std::vector<Driver> drivers{effect.driver};
      if (effect.driver.kind == DriverKind::temperature && effect.driver.where.empty()) {
        drivers.clear();
        for (const std::string& where : campaign.temperature_names)
          drivers.push_back({DriverKind::temperature, -1, -1, where});
      }
      if (!is_shown(effect, robot, campaign)) continue;
      for (const Driver& driver : drivers) {
        if (!is_driven(driver, campaign, span)) continue;
        const double degree = is_travel(driver, robot.chain) ? kTravelForDegree : kDegree;
        for (const Shape& shape :
             with_inner_values(effect.shape, span_of(driver, campaign), degree)) {
          if (is_plain_sign(shape, driver, campaign)) continue;
          Candidate candidate{effect, 0, entry.only_positive, true, entry.separated_by};
          candidate.effect.driver = driver;
          candidate.effect.shape = shape;
          if (is_polynomial(shape)) set_range_of_places(robot, campaign, candidate.effect.shape);
          candidate.degree = degree;
          candidate.in_words = entry.in_words;
          candidate.of_most_arms = entry.usual == Usual::most_arms;
          candidates.push_back(std::move(candidate));
          usual.push_back(entry.usual);
        }
      }
    }
  // One of the candidates that are at least as usual.
  for (size_t k = 0; k < candidates.size(); ++k)
    candidates[k].log_choices = std::log(static_cast<double>(
        std::ranges::count_if(usual, [&](Usual other) { return other <= usual[k]; })));
  return candidates;
}

namespace {

constexpr int kPosesForLoads = 256;
constexpr double kMinTorque = 1.0;         // N m, RMS: gravity does not turn such a joint
constexpr double kLeverOfWrist = 1.0 / 3;  // of the longest lever

// RMS of the values of an effect (of their norm, if it has several): over the travel of the joints
// where gravity drives it, over the readings otherwise.
double typical_value(const BoundEffect& bound, const Effect& effect, const Robot& robot,
                     const Campaign& campaign) {
  const bool by_gravity =
      effect.driver.kind == DriverKind::gravity_torque || effect.driver.kind == DriverKind::moment;
  std::vector<Context> contexts;
  if (by_gravity)
    for (const JointVector& q : sample_joint_space(robot.chain, kPosesForLoads)) {
      contexts.push_back(campaign.context(0));
      contexts.back().q = q;
    }
  else
    for (int row = 0; row < campaign.rows(); ++row) contexts.push_back(campaign.context(row));
  const ChainEvaluator chain(robot.chain);
  Eigen::VectorXd values(bound.value_count());
  double squares = 0;
  for (const Context& context : contexts) {
    ArmFrames frames;
    PoseJacobian jacobian;
    if (bound.needs_frames()) frames = chain.link_frames(context.q);
    if (bound.needs_jacobian()) chain.pose(context.q, jacobian);
    bound.values(context, &frames, &jacobian, values.data());
    squares += values.squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(contexts.size()));
}

// How far each joint moves the measured frame, RMS over the travel [m per rad or per m].
std::vector<double> levers(const Robot& robot) {
  const ChainEvaluator chain(robot.chain);
  std::vector<double> squares(static_cast<size_t>(joint_count(robot.chain)));
  for (const JointVector& q : sample_joint_space(robot.chain, kPosesForLoads)) {
    PoseJacobian jacobian;
    chain.pose(q, jacobian);
    for (size_t j = 0; j < squares.size(); ++j)
      squares[j] +=
          joint_column(robot.chain, jacobian, static_cast<int>(j)).head<3>().squaredNorm();
  }
  for (double& square : squares) square = std::sqrt(square / kPosesForLoads);
  return squares;
}

// Joint whose load drives an effect; -1: none does.
int loaded_joint(const Driver& driver) {
  if (driver.kind == DriverKind::gravity_torque || driver.kind == DriverKind::tool_weight)
    return driver.joint;
  return driver.factor == DriverKind::gravity_torque || driver.factor == DriverKind::tool_weight
             ? driver.second_joint
             : -1;
}

// Turns the typical size of what each member adds to its parameter into that of its coefficients.
// A joint is as stiff as its load demands, or the load that it passes on: its reference is the
// largest torque from it, or the joint before the last, to the tip.
void set_typical_coefficients(std::vector<Effect>& members, std::vector<double> values,
                              int joints) {
  std::vector<double> reference = values;
  for (size_t m = 0; m < members.size(); ++m)
    if (const int joint = loaded_joint(members[m].driver); joint >= 0)
      for (size_t other = 0; other < members.size(); ++other)
        if (loaded_joint(members[other].driver) >= std::min(joint, joints - 2))
          reference[m] = std::max(reference[m], values[other]);
  for (size_t m = 0; m < members.size(); ++m) members[m].family->typical /= reference[m];
}

}  // namespace

std::vector<Candidate> family_candidates(const std::vector<Candidate>& singles, const Robot& robot,
                                         const Campaign& campaign) {
  std::vector<Candidate> families;
  std::vector<std::vector<double>> values;  // typical, of each member
  const std::vector<double> lever = levers(robot);
  // Without masses the loads have no scale. Those of a wrist are small beside those of the arm.
  const auto is_of_wrist = [&](const Driver& driver) {
    return robot.bodies.empty() && driver.kind == DriverKind::gravity_torque &&
           lever[static_cast<size_t>(driver.joint)] < kLeverOfWrist * std::ranges::max(lever);
  };
  const auto same_family = [](const Candidate& family, const Candidate& single) {
    const Effect& first = family.effect.members.front();
    return first.family->name == single.effect.family->name &&
           first.driver.kind == single.effect.driver.kind &&
           first.driver.where == single.effect.driver.where && first.shape == single.effect.shape;
  };
  for (const Candidate& single : singles) {
    if (!single.effect.family || is_of_wrist(single.effect.driver)) continue;
    const BoundEffect bound(single.effect, robot, campaign.temperature_names);
    const double value = typical_value(bound, single.effect, robot, campaign);
    const bool by_torque = single.effect.driver.kind == DriverKind::gravity_torque;
    if (value < (by_torque ? kMinTorque : 1e-12)) continue;
    auto family = std::ranges::find_if(
        families, [&](const Candidate& other) { return same_family(other, single); });
    if (family == families.end()) {
      family = families.insert(families.end(), single);
      family->effect.name = family->effect.parameter = single.effect.family->name;
      family->log_choices = single.log_choices;
      values.emplace_back();
    }
    values[static_cast<size_t>(family - families.begin())].push_back(value);
    Effect& member = family->effect.members.emplace_back(single.effect);
    member.coefficients.resize(static_cast<size_t>(bound.coefficient_count()));
    for (size_t k = 0; k < member.coefficients.size(); ++k)
      member.coefficients[k].name = bound.coefficient_names()[k];
  }
  for (size_t f = 0; f < families.size(); ++f)
    set_typical_coefficients(families[f].effect.members, values[f], joint_count(robot.chain));
  std::erase_if(families, [](const Candidate& family) { return family.effect.members.size() < 2; });
  return families;
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
  const bool is_length = first && layout_of(chain).is_of_links(*first) &&
                         !is_zero_offset(chain, *first) &&
                         parameter_unit(chain, *first) == ParameterUnit::metre;
  if (effect.driver.involves(DriverKind::joint_angle))
    return is_length || effect.parameter.starts_with("base");
  return is_length && effect.driver.kind == DriverKind::time &&
         effect.shape.kind == ShapeKind::step;
}

std::vector<Candidate> steps_anywhere(const Candidate& step, const Campaign& campaign) {
  const Span span = span_of(step.effect.driver, campaign);
  std::vector<Candidate> steps;
  for (double at : step_places(span, static_cast<int>(std::min(span.values.size(), kMaxSteps)))) {
    steps.push_back(step);
    steps.back().effect.shape.at = at;
    for (Effect& member : steps.back().effect.members) member.shape.at = at;
  }
  return steps;
}

std::vector<Candidate> refined_candidates(const Candidate& candidate, const Campaign& campaign) {
  const Shape& shape = candidate.effect.shape;
  std::vector<Candidate> refined;
  const Span span = span_of(candidate.effect.driver, campaign);
  const auto add = [&](const Shape& inner) {
    refined.push_back(candidate);
    refined.back().effect.shape = inner;
    for (Effect& member : refined.back().effect.members) member.shape = inner;
  };
  if (has_at(shape.kind)) {
    refined = steps_anywhere(candidate, campaign);
    const double reach = 2.0 * span.length() / kStepGrid;
    std::erase_if(refined, [&](const Candidate& step) {
      return std::abs(step.effect.shape.at - shape.at) > reach;
    });
  } else if (candidate.frequency_resolution > 0) {
    const double step = candidate.frequency_resolution / kFrequencySteps / kFinerSteps;
    for (int k = -kFinerSteps; k <= kFinerSteps; ++k) {
      Shape inner = shape;
      inner.harmonic = readable(shape.harmonic + k * step);
      add(inner);
    }
  } else if (shape.kind == ShapeKind::series && shape.basis == SeriesBasis::bump) {
    const double width = shape.high[0] - shape.low[0];
    const double middle = 0.5 * (shape.low[0] + shape.high[0]);
    for (double other : {5.0, 7.0, 10.0, 14.0, 20.0, 28.0, 40.0, 56.0, 80.0, 112.0}) {
      const double wide = other * candidate.degree, step = wide / 6;
      if (std::abs(std::log(wide / width)) > std::log(2.1)) continue;
      for (double k = std::ceil((middle - width) / step); k * step <= middle + width; ++k) {
        Shape inner = shape;
        inner.low[0] = k * step - 0.5 * wide;
        inner.high[0] = k * step + 0.5 * wide;
        add(inner);
      }
    }
  } else if (has_tau(shape.kind)) {
    // Steps of a grid that does not depend on where the search has come from.
    const double whole =
        shape.kind == ShapeKind::pre_sliding ? 32 * candidate.degree : span.length();
    for (double tau = whole / 64; tau <= 2 * whole; tau *= 1.15) {
      if (std::abs(std::log(tau / shape.tau)) > std::log(2.0)) continue;
      Shape inner = shape;
      inner.tau = tau;
      add(inner);
    }
  }
  return refined;
}

}  // namespace armtrue
