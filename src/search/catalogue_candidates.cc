#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "armtrue/campaign/sessions.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/effects/sampling.h"
#include "armtrue/kinematics/units.h"
#include "search/candidates.h"
#include "search/driver_span.h"
#include "search/frequency_grid.h"

namespace armtrue {
namespace {

bool is_load(DriverKind kind) {
  return kind == DriverKind::gravity_torque || kind == DriverKind::moment;
}

// Whether a driver takes its load from the masses of the arm and the tool, which a positioner does
// not carry.
bool is_about_positioner(DriverKind kind, int joint, const Robot& robot) {
  return (kind == DriverKind::gravity_torque || kind == DriverKind::tool_weight) &&
         is_of_positioner(robot, zero_offset(robot.chain, joint));
}

// Which joints gravity turns. About an axis along it the torque is rounding, or what a tilt of the
// base of microradians makes of it: such a driver takes a coefficient that no gear has.
class GravityTurns {
 public:
  explicit GravityTurns(const Robot& robot) : robot_(robot) {}

  // `effect`: with this driver.
  bool turns(const Effect& effect, DriverKind kind, int joint) {
    constexpr double kLeastShare = 1e-4;  // of the largest range
    std::vector<double>& ranges = ranges_[kind];
    if (ranges.empty()) ranges = torque_ranges(effect, kind);
    return ranges[joint] > kLeastShare * std::ranges::max(ranges);
  }

 private:
  // Of the torque on each joint over the travel, by the masses or by 1 kg at the measured frame [N
  // m, or N]. A positioner does not carry them.
  std::vector<double> torque_ranges(Effect effect, DriverKind kind) const {
    constexpr int kPoses = 128;
    effect.shape = Shape{};
    effect.coefficients.clear();
    const std::vector<JointVector> poses = sample_joint_space(robot_.chain, kPoses);
    const ChainEvaluator chain(robot_.chain);
    std::vector<double> ranges;
    for (int joint = 0; joint < joint_count(robot_.chain); ++joint) {
      ranges.push_back(0);
      if (is_about_positioner(kind, joint, robot_)) continue;
      effect.driver = Driver{kind, joint, -1, ""};
      const BoundEffect torque(effect, robot_, {});
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (const JointVector& q : poses) {
        Context context;
        context.q = q;
        const ArmFrames frames = chain.link_frames(q);
        double value = 0;
        torque.values(context, &frames, nullptr, &value);
        low = std::min(low, value);
        high = std::max(high, value);
      }
      ranges.back() = high - low;
    }
    return ranges;
  }

  const Robot& robot_;
  std::map<DriverKind, std::vector<double>> ranges_;
};

// Whether the robot has what an entry of the catalogue needs, and the campaign reads what it moves.
bool is_shown(const Effect& effect, const Robot& robot, const Campaign& campaign,
              GravityTurns& gravity) {
  const Driver& driver = effect.driver;
  const bool needs_masses = (is_load(driver.kind) && effect.shape.kind != ShapeKind::linear) ||
                            (driver.factor && is_load(*driver.factor));
  const auto of_positioner = [&](std::optional<DriverKind> kind, int joint) {
    return kind && is_about_positioner(*kind, joint, robot);
  };
  const bool by_positioner = of_positioner(driver.kind, driver.joint);
  if (needs_masses && (robot.bodies.empty() || by_positioner)) return false;
  if (driver.kind == DriverKind::tool_weight && by_positioner) return false;
  if (of_positioner(driver.factor, driver.second_joint)) return false;
  const auto turns = [&](std::optional<DriverKind> kind, int joint) {
    const bool by_masses = kind == DriverKind::gravity_torque && !robot.bodies.empty() &&
                           !is_about_positioner(*kind, joint, robot);
    return !(by_masses || kind == DriverKind::tool_weight) || gravity.turns(effect, *kind, joint);
  };
  if (!turns(driver.kind, driver.joint) || !turns(driver.factor, driver.second_joint)) return false;
  // The part does not stand on the floor.
  const Parameter& parameter = effect.parameter;
  if (robot.ground_link && driver.kind == DriverKind::moment && parameter.owner == Owner::base)
    return false;
  if (parameter.owner == Owner::target)
    return std::ranges::count(campaign.target_names, parameter.of) > 0;
  if (parameter.owner == Owner::anchor) return campaign.reads_one_number();
  if (parameter.owner == Owner::instrument && is_group(parameter))
    return !campaign.reads_one_number();
  const bool by_sight = parameter.owner == Owner::instrument &&
                        !is_instrument_parameter(parameter, InstrumentParameter::scale);
  return !by_sight ||
         (knows_instrument(robot) && (!campaign.reads_one_number() || campaign.has_coordinates()));
}

// The length of a link as it was built; 1 of the scale of all.
double length_of(const Parameter& parameter, const Robot& robot) {
  if (is_arm_scale(parameter)) return 1;
  const KinematicChain& chain = robot.nominal ? *robot.nominal : robot.chain;
  const Link& link = chain.links[link_of_parameter(*find_parameter(chain, parameter))];
  return is_link_parameter(parameter, LinkParameter::d) ? link.d : link.r;
}

// Whether nearly all strokes are so long that the shape looks like backlash, which is another
// effect: its values correlate with the direction so much that both count as the same.
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

// One cycle over the lengths that the readings cover [1 / (2 pi m)]; 0 if they cover none of the
// cycles of an entry.
double resolution_of(const CatalogueEntry& entry, const Effect& effect, const Robot& robot,
                     const Campaign& campaign) {
  Effect linear = effect;
  linear.shape = Shape{};
  const BoundEffect length(linear, robot, campaign.temperature_names);
  const ChainEvaluator chain(robot.chain);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int row = 0; row < campaign.rows(); ++row) {
    const Context context = campaign.context(row);
    const ArmFrames frames = chain.link_frames(context.q);
    double value = 0;
    length.values(context, &frames, nullptr, &value);
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return high - low >= entry.cycle[0] ? kTurn / (high - low) : 0;
}

// A harmonic whose cycle is searched: from the longest, or one over all readings, to the shortest.
std::vector<Shape> cycles_of(const CatalogueEntry& entry, double resolution) {
  std::vector<Shape> shapes;
  if (resolution == 0) return shapes;
  const double least = std::max(kTurn / entry.cycle[1], resolution);
  for (double n = least; n <= kTurn / entry.cycle[0]; n += resolution / kFrequencySteps)
    shapes.push_back(harmonic_shape(readable(n)));
  return shapes;
}

// The shapes of an entry that are searched. Torques at which a joint becomes stiffer are tried as
// shares of the largest that gravity has on it.
std::vector<Shape> shapes_of(const Effect& effect, const Driver& driver, const Robot& robot,
                             const Span& span, double degree) {
  const Shape& shape = effect.shape;
  if (shape.kind != ShapeKind::series || shape.basis != SeriesBasis::saturating ||
      shape.low[0] < shape.high[0])
    return with_inner_values(shape, span, degree);
  std::vector<Shape> shapes;
  if (driver.kind == DriverKind::gravity_torque)
    if (const auto range = gravity_torques(robot, driver.joint))
      for (double share : {0.4, 0.2, 0.1}) shapes.push_back(saturating_at(share, *range));
  return shapes;
}

}  // namespace

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

namespace {

// To a tenth of a degree. The model fits no constants of the instrument, so what the temperature
// does to it has its zero where it does not change the lengths of the arm.
double mean_temperature(const Driver& driver, const Campaign& campaign) {
  const std::vector<double> values = values_of(driver, campaign);
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  return std::round(10 * sum / static_cast<double>(values.size())) / 10;
}

// The candidates of a catalogue, one entry after the other.
class CatalogueSearch {
 public:
  CatalogueSearch(const Robot& robot, const Campaign& campaign)
      : robot_(robot),
        campaign_(campaign),
        span_(time_span(campaign)),
        between_sessions_(session_driver(campaign)),
        gravity_(robot) {}

  void add(const CatalogueEntry& entry) {
    for (const Effect& effect : expand(entry, robot_))
      if (is_shown(effect, robot_, campaign_, gravity_)) add_effect(entry, effect);
  }

  // Each is charged for one of the candidates that are at least as usual, and may be chosen.
  std::vector<Candidate> take() {
    std::map<Usual, long> alone;
    for (size_t k = 0; k < candidates_.size(); ++k)
      alone[usual_[k]] += may_be_alone(candidates_[k]);
    for (size_t k = 0; k < candidates_.size(); ++k) {
      long choices = 0;
      for (const auto& [usual, count] : alone)
        if (usual <= usual_[k]) choices += count;
      candidates_[k].log_choices = std::log(static_cast<double>(std::max(1L, choices)));
    }
    return std::move(candidates_);
  }

 private:
  void add_effect(const CatalogueEntry& entry, const Effect& effect) {
    double furthest = 0;
    if (entry.most_of_length != 0) {
      furthest = entry.most_of_length * length_of(effect.parameter, robot_);
      if (furthest == 0) return;  // what has no length does not grow
    }
    const bool is_searched = entry.cycle[1] > 0;
    const double resolution = is_searched ? resolution_of(entry, effect, robot_, campaign_) : 0;
    for (const Driver& driver : drivers_of(effect)) {
      if (!is_driven(driver, campaign_, span_)) continue;
      const double degree = is_travel(driver, robot_.chain) ? kTravelForDegree : kDegree;
      for (const Shape& shape :
           is_searched ? cycles_of(entry, resolution)
                       : shapes_of(effect, driver, robot_, span_of(driver, campaign_), degree)) {
        if (is_plain_sign(shape, driver, campaign_)) continue;
        Candidate& candidate = candidates_.emplace_back(candidate_of(entry, effect, driver, shape));
        candidate.degree = degree;
        candidate.frequency_resolution = resolution;
        candidate.furthest = furthest;
        usual_.push_back(entry.usual);
      }
    }
  }

  // The driver of an effect, or each that a campaign has in its place.
  std::vector<Driver> drivers_of(const Effect& effect) const {
    std::vector<Driver> drivers{effect.driver};
    if (effect.driver.involves(DriverKind::temperature) && effect.driver.where.empty()) {
      drivers.clear();
      for (const std::string& where : campaign_.temperature_names) {
        drivers.push_back(effect.driver);
        drivers.back().where = where;
      }
    }
    // A step in time may have come between two sessions.
    if (effect.driver.kind == DriverKind::time && effect.shape.kind == ShapeKind::step &&
        between_sessions_ && !is_of_each_session(effect.parameter, robot_)) {
      drivers.push_back(effect.driver);
      drivers.back().kind = DriverKind::session;
      drivers.back().sessions = between_sessions_->sessions;
    }
    return drivers;
  }

  Candidate candidate_of(const CatalogueEntry& entry, const Effect& effect, const Driver& driver,
                         const Shape& shape) const {
    Candidate candidate{effect, 0, entry.only_positive, true, entry.separated_by};
    candidate.effect.driver = driver;
    candidate.effect.shape = shape;
    Shape& own = candidate.effect.shape;
    if (driver.kind == DriverKind::time && counts_from(shape.kind)) own.at = begin_of_time(span_);
    if (driver.kind == DriverKind::temperature && counts_from(shape.kind) &&
        effect.parameter.owner == Owner::instrument)
      own.at = mean_temperature(driver, campaign_);
    if (is_polynomial(shape)) set_range_of_places(robot_, campaign_, own);
    candidate.in_words = entry.in_words;
    candidate.of_most_arms = entry.usual == Usual::most_arms;
    if (effect.family) candidate.of_family = effect.family->name;
    candidate.only_together = entry.only_together;
    candidate.alike = entry.alike;
    return candidate;
  }

  const Robot& robot_;
  const Campaign& campaign_;
  const Span span_;
  const std::optional<Driver> between_sessions_;
  GravityTurns gravity_;
  std::vector<Candidate> candidates_;
  std::vector<Usual> usual_;  // of each candidate
};

}  // namespace

std::vector<Candidate> catalogue_candidates(const Catalogue& catalogue, const Robot& robot,
                                            const Campaign& campaign) {
  CatalogueSearch search(robot, campaign);
  for (const CatalogueEntry& entry : catalogue) search.add(entry);
  return search.take();
}

}  // namespace armtrue
