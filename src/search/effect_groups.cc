#include "armtrue/search/effect_groups.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "armtrue/campaign/selection.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/units.h"
#include "linear_algebra/decompositions.h"
#include "search/candidates.h"
#include "search/driver_span.h"

namespace armtrue {
namespace {

// Usual sizes of what an effect adds to its parameter, RMS over the poses [rad]; lengths move by
// as much at a lever of a metre. Gears give way by 0.1 to 0.5 mrad under the arm's own weight, links and
// the foot by less; gears and bearings run true to some 0.1 mrad over a turn and to some 30 urad within
// it; what else an angle follows moves a point at a metre by hundredths of a millimetre.
constexpr double kOfGravity = 2e-4, kOfBending = 1e-4, kOfFoot = 5e-5, kOfCurve = 1e-4,
                 kOfFrame = 4e-5, kOfFineCurve = 3e-5, kOfOthers = 2e-5, kOfArrival = 5e-5,
                 kOfTemperature = 3e-5, kOfTime = 3e-5;
constexpr double kOfInstrument = 3e-4;  // m: three times the noise of a tracker, as in the fit's prior
constexpr double kLever = 1.0;           // m
constexpr double kWithinThree = 1.0986;  // ln 3: two thirds of all arms are within a factor of three
constexpr int kFinest = 60;              // cosines of a curve
constexpr int kContexts = 1000;          // tell an RMS to two digits
constexpr double kMinNew = 1e-6, kRounding = 1e-12;  // of a sum of squares

class Groups {
 public:
  Groups(const Robot& robot, const Campaign& campaign)
      : robot_(robot),
        campaign_(campaign),
        chain_(robot.chain),
        span_(time_span(campaign)),
        joints_(joint_count(robot.chain)),
        layout_(layout_of(robot.chain)) {
    std::vector<int> rows(campaign.rows());
    for (int row = 0; row < campaign.rows(); ++row) rows[row] = row;
    for (int row : evenly_chosen(rows, kContexts)) contexts_.push_back(campaign.context(row));
  }

  std::vector<EffectGroup> of_instrument(const std::vector<Candidate>& candidates) {
    begin("errors of the instrument", EffectGroup::Owner::station);
    int finest = 0;  // a distortion contains the coarser ones
    for (const Candidate& candidate : candidates)
      if (is_polynomial(candidate.effect.shape))
        finest = std::max(finest, candidate.effect.shape.count);
    const double range =
        std::max(1.0, (robot_.chain.base.translation - instrument_place(robot_)).norm());
    for (const Candidate& candidate : candidates) {
      if (!is_lasting_of_instrument(candidate.effect)) continue;
      RandomEffect random{candidate.effect, {}};
      if (is_polynomial(random.effect.shape) && random.effect.shape.count < finest) continue;
      const bool turns =
          unit_of_parameter(robot_.chain, random.effect.parameter) == ParameterUnit::radian;
      const BoundEffect bound(random.effect, robot_, campaign_.temperature_names);
      const Eigen::MatrixXd of_axis =
          orthonormal(values_of(bound), turns ? kOfInstrument / range : kOfInstrument);
      const Eigen::Index values = of_axis.rows(), numbers = of_axis.cols();
      const Eigen::Index axes = bound.coefficient_count() / values;
      random.root = Eigen::MatrixXd::Zero(axes * values, axes * numbers);
      for (Eigen::Index axis = 0; axis < axes; ++axis)
        random.root.block(axis * values, axis * numbers, values, numbers) = of_axis;
      if (numbers > 0) groups_.back().effects.push_back(std::move(random));
    }
    if (groups_.back().effects.empty()) return {};
    strain();
    return std::move(groups_);
  }

  EffectGroup walk(const std::vector<Parameter>& parameters) {
    begin("what wanders in time", EffectGroup::Owner::station);
    const int count = std::clamp(static_cast<int>(span_.values.size()) / 2, 1, kFinest);
    for (const Parameter& parameter : parameters)
      if (const auto index = find_parameter(robot_.chain, parameter); index && has_time(span_))
        add_walk(*index, count, kOfCurve);
    return std::move(groups_.back());
  }

  std::vector<EffectGroup> all() {
    gravity();
    curves();
    others();
    arrivals();
    conditions();
    station();
    std::erase_if(groups_, [](const EffectGroup& group) { return group.effects.empty(); });
    return std::move(groups_);
  }

 private:
  void begin(const char* name, EffectGroup::Owner owner = EffectGroup::Owner::arm) {
    groups_.push_back({name, owner, kWithinThree, {}});
  }

  // The values of an effect in some contexts, without their means: contexts x values.
  Eigen::MatrixXd values_of(const BoundEffect& bound) const {
    Eigen::MatrixXd values(std::ssize(contexts_), bound.value_count());
    Eigen::VectorXd row(bound.value_count());
    for (Eigen::Index k = 0; k < values.rows(); ++k) {
      const Context& context = contexts_[k];
      ArmFrames frames;
      PoseJacobian jacobian;
      if (bound.needs_frames()) frames = chain_.link_frames(context.q);
      if (bound.needs_jacobian()) chain_.pose(context.q, jacobian);
      bound.values(context, &frames, &jacobian, row.data());
      values.row(k) = row;
    }
    const Eigen::RowVectorXd mean = values.colwise().mean();
    const double before = values.squaredNorm();
    values.rowwise() -= mean;
    // A constant leaves only what was rounded off.
    if (values.squaredNorm() < kRounding * before) values.setZero();
    return values;
  }

  // Coefficients by which values in these contexts have a usual RMS: values x random numbers.
  // Values of a smaller mean square than `least` are taken for as large.
  static Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& values, double size, double least = 0) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes{
        Eigen::MatrixXd(values.transpose() * values / static_cast<double>(values.rows()))};
    const Eigen::VectorXd squares = axes.eigenvalues().cwiseMax(least);
    std::vector<Eigen::Index> kept;
    for (Eigen::Index k = 0; k < squares.size(); ++k)
      if (axes.eigenvalues()[k] > kMinNew * squares.maxCoeff()) kept.push_back(k);
    return axes.eigenvectors()(Eigen::all, kept) *
           squares(kept).cwiseSqrt().cwiseInverse().asDiagonal() * size /
           std::sqrt(static_cast<double>(kept.size()));
  }

  // `weights` of the values; empty: an orthonormal basis of the values takes their place, those of
  // a smaller mean square than `least` taken for as large.
  void add(int parameter, const Driver& driver, const Shape& shape, double angle,
           const std::vector<double>& weights = {}, double least = 0) {
    if (!is_driven(driver, campaign_, span_)) return;
    RandomEffect random{{"", parameter_of(robot_.chain, parameter), driver, shape, {}}, {}};
    if (is_of_one_angle(random.effect)) {
      const auto [low, high] = travel_covered(campaign_, driver.joint);
      random.effect.driver_range = {low, high};
    }
    const BoundEffect bound(random.effect, robot_, campaign_.temperature_names);
    if (bound.value_count() == 0) return;
    const double size =
        parameter_unit(robot_.chain, parameter) == ParameterUnit::metre ? angle * kLever : angle;
    const Eigen::Index count = bound.value_count();
    if (weights.empty()) {
      random.root = orthonormal(values_of(bound), size, least);
      if (random.root.cols() == 0) return;
    } else {
      random.root = Eigen::MatrixXd::Zero(count, count);
      double squares = 0;
      for (double weight : weights) squares += 0.5 * weight * weight;
      for (Eigen::Index k = 0; k < count; ++k)
        random.root(k, k) = size * weights[k] / std::sqrt(squares);
    }
    groups_.back().effects.push_back(std::move(random));
  }

  // A space that is stretched or compressed along some directions, as by a camera whose depth has
  // another scale. With R the rotation of the base and x a place in its frame, a symmetric strain S
  // moves readings by S R x.
  void strain() {
    begin("strain of the space of the instrument", EffectGroup::Owner::station);
    RandomEffect random{{"", "instrument.point", {DriverKind::place, -1, -1, ""},
                         series_shape(SeriesBasis::polynomial, 1), {}}, {}};
    set_range_of_places(robot_, campaign_, random.effect.shape);
    const Eigen::MatrixXd values =
        values_of(BoundEffect(random.effect, robot_, campaign_.temperature_names));
    random.root.resize(9, 6);
    Eigen::Index k = 0;
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b, ++k) {
        Eigen::Matrix3d strain = Eigen::Matrix3d::Zero();
        strain(a, b) = strain(b, a) = 1;
        const Eigen::Matrix3d moved = strain * robot_.chain.base.rotation;
        const double size = std::sqrt((values * moved.transpose()).squaredNorm() /
                                      static_cast<double>(values.rows()));
        random.root.col(k) = kOfInstrument / std::sqrt(6.0) / std::max(size, 1e-300) *
                             moved.transpose().reshaped();  // by axis, then by coordinate
      }
    groups_.back().effects.push_back(std::move(random));
  }

  static Driver angle_of(int joint) { return {DriverKind::joint_angle, joint, -1, ""}; }

  double mean_square(int parameter, const Driver& driver) const {
    const Effect effect{"", parameter_of(robot_.chain, parameter), driver, Shape{}, {}};
    return values_of(BoundEffect(effect, robot_, campaign_.temperature_names)).squaredNorm() /
           static_cast<double>(contexts_.size());
  }

  // A part that turns or bends under gravity is as stiff as its place in the arm demands, and at
  // most a hundred times softer than the part that carries most. So a torque of nearly zero, as on
  // a flange whose mass lies on its axis, does not set the size of its coefficient, which a payload
  // would multiply.
  void add_of_gravity(const std::vector<std::pair<int, Driver>>& places, double size) {
    constexpr double kSofter = 100;
    double largest = 0;
    for (const auto& [parameter, driver] : places)
      largest = std::max(largest, mean_square(parameter, driver));
    for (const auto& [parameter, driver] : places)
      add(parameter, driver, Shape{}, size, {}, largest / (kSofter * kSofter));
  }

  void gravity() {
    std::vector<std::pair<int, Driver>> turned, bent;
    for (int j = 0; j < joints_; ++j)
      turned.emplace_back(zero_offset(robot_.chain, j),
                          Driver{DriverKind::gravity_torque, j, -1, ""});
    for (int k = kFirstLinkParameter; k < layout_.tool; ++k)
      if (!is_zero_offset(robot_.chain, k) &&
          parameter_unit(robot_.chain, k) == ParameterUnit::radian)
        bent.emplace_back(k, Driver{DriverKind::moment, -1, -1, ""});
    begin("gravity");
    add_of_gravity(turned, kOfGravity);
    begin("bending");
    add_of_gravity(bent, kOfBending);
    begin("foot");
    if (!robot_.ground_link)
      for (int k = 3; k < 6; ++k) add(k, {DriverKind::moment, -1, -1, ""}, Shape{}, kOfFoot);
  }

  // Cosines over the angles covered and a margin, weight of the k-th 1 / k^power.
  void add_curve(int parameter, int joint, int count, double power, int first, double size) {
    const auto [low, high] = range_of_curve(campaign_, joint, robot_.chain);
    if (!(low < high)) return;
    std::vector<double> weights;
    for (int k = 1; k <= count; ++k) weights.push_back(k < first ? 0 : std::pow(k, -power));
    add(parameter, angle_of(joint), series_shape(SeriesBasis::cosine, count, low, high), size,
        weights);
  }

  void curves() {
    const int poses = static_cast<int>(campaign_.pose_ids.size());
    begin("curves of the joints");
    for (int j = 0; j < joints_; ++j)
      add_curve(zero_offset(robot_.chain, j), j, 12, 2, 1, kOfCurve);
    begin("fine curves of the joints");
    const int fine = std::min(kFinest, poses / 2);
    if (fine > 6)
      for (int j = 0; j < joints_; ++j)
        add_curve(zero_offset(robot_.chain, j), j, fine, 1, 4, kOfFineCurve);
    begin("curves of the frames");
    for (int k = kFirstLinkParameter; k < layout_.tool; ++k) {
      if (is_zero_offset(robot_.chain, k)) continue;
      const int link = link_of_parameter(k);
      for (int j = 0; j < joints_; ++j) {
        const int of_joint = link_of_parameter(zero_offset(robot_.chain, j));
        if (of_joint == link || of_joint == link - 1) add_curve(k, j, 6, 2, 1, kOfFrame);
      }
    }
  }

  void others() {
    begin("angles of other joints");
    for (int j = 0; j < joints_; ++j)
      for (int d = 0; d < joints_; ++d)
        if (d != j) add_curve(zero_offset(robot_.chain, j), d, 4, 1, 1, kOfOthers);
    begin("pairs of angles");
    for (int j = 0; j < joints_; ++j)
      for (int a = 0; a < joints_; ++a)
        for (int b = a + 1; b < joints_; ++b)
          if (!is_prismatic(joint_link(robot_.chain, a)) && !is_prismatic(joint_link(robot_.chain, b)))
            add(zero_offset(robot_.chain, j), {DriverKind::joint_angle, a, b, ""},
              series_shape(SeriesBasis::fourier, 1), kOfOthers);
  }

  void arrivals() {
    begin("arrival");
    for (int j = 0; j < joints_; ++j)
      add(zero_offset(robot_.chain, j), {DriverKind::arrival, j, -1, ""}, sign_shape(), kOfArrival);
  }

  // A campaign at constant temperature gives no size either: a metre of steel grows by 12 um per
  // kelvin.
  void conditions() {
    constexpr double kKelvin = 1;
    begin("temperature");
    for (const std::string& where : campaign_.temperature_names)
      for (int k = kFirstLinkParameter; k < layout_.tool; ++k)
        add(k, {DriverKind::temperature, -1, -1, where}, Shape{}, kOfTemperature, {},
            kKelvin * kKelvin);
  }

  // A random walk of a parameter: its k-th cosine over the campaign has the weight 1 / k.
  void add_walk(int parameter, int count, double size) {
    std::vector<double> weights;
    for (int k = 1; k <= count; ++k) weights.push_back(1.0 / k);
    add(parameter, {DriverKind::time, -1, -1, ""},
        series_shape(SeriesBasis::cosine, count, span_.values.front(), span_.values.back()), size,
        weights);
  }

  void station() {
    begin("time", EffectGroup::Owner::station);
    if (!has_time(span_)) return;
    constexpr int kSlow = 8;
    for (int k = 0; k < 6; ++k) add_walk(k, kSlow, kOfTime);
    for (int k = layout_.tool; k < layout_.tool + 3; ++k) add_walk(k, kSlow, kOfTime);
  }

  const Robot& robot_;
  const Campaign& campaign_;
  ChainEvaluator chain_;
  Span span_;
  int joints_;
  ParameterLayout layout_;
  std::vector<Context> contexts_;
  std::vector<EffectGroup> groups_;
};

}  // namespace

std::vector<EffectGroup> errors_of_instrument(const Robot& robot, const Campaign& campaign,
                                              const Catalogue& catalogue) {
  return Groups(robot, campaign).of_instrument(catalogue_candidates(catalogue, robot, campaign));
}

EffectGroup random_walk(const Robot& robot, const Campaign& campaign,
                        const std::vector<Parameter>& parameters) {
  return Groups(robot, campaign).walk(parameters);
}

std::vector<EffectGroup> effect_groups(const Robot& robot, const Campaign& campaign) {
  return Groups(robot, campaign).all();
}

}  // namespace armtrue
