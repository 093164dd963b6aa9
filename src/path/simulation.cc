#include "armtrue/path/simulation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <string>

#include "armtrue/effects/arrival.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/random.h"

namespace armtrue {
namespace {

using Angles = JointMatrix;
using Eigen::Vector3d;

// A random function of arc length with mean 0 and RMS 1: a sum of sines with half to twice the
// wavelength at which the force of the paper's table 5 changes.
class Variation {
 public:
  explicit Variation(std::uint64_t seed) {
    constexpr double kWavelength = 55e-3;  // [m]
    Random random(seed);
    for (Sine& sine : sines_) {
      sine.wave_number = 2 * std::numbers::pi / (kWavelength * std::exp2(random.uniform(-1, 1)));
      sine.phase = random.uniform(0, 2 * std::numbers::pi);
    }
  }
  double operator()(double s) const {
    double sum = 0;
    for (const Sine& sine : sines_) sum += std::sin(sine.wave_number * s + sine.phase);
    return sum * std::sqrt(2.0 / static_cast<double>(sines_.size()));
  }

 private:
  struct Sine {
    double wave_number, phase;
  };
  std::array<Sine, 6> sines_;
};

std::string number(double length) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.6g", length / kMillimetre);
  return buffer;
}

// Share of the cut at an arc length: 0 outside, 1 inside, linear over entry and exit.
double engagement(double s, const std::array<double, 2>& engaged, double ramp) {
  const double inside = std::min(s - engaged[0], engaged[1] - s);
  if (inside <= 0) return 0;
  return inside < ramp ? inside / ramp : 1;
}

// Angles behind a first-order lag, exact for commands that are linear between samples.
Angles lagging(const Eigen::VectorXd& time, Angles angles, double lag) {
  if (lag <= 0) return angles;
  JointVector last = angles.col(0);  // commanded
  for (Eigen::Index i = 1; i < time.size(); ++i) {
    const double step = time[i] - time[i - 1];
    const JointVector commanded = angles.col(i);
    const JointVector drag = lag / step * (commanded - last);
    angles.col(i) = commanded - drag + std::exp(-step / lag) * (angles.col(i - 1) - last + drag);
    last = commanded;
  }
  return angles;
}

// Directions and strokes of the joints at each sample of the controller.
std::vector<Arrival> arrivals(const Angles& angles) {
  std::vector<Arrival> all;
  Arrival arrival(angles.col(0));
  for (const auto& q : angles.colwise()) {
    arrival.go_to(q);
    all.push_back(arrival);
  }
  return all;
}

// Linear between samples i and i + 1; u from 0 to 1.
template <typename Columns>
auto between(const Columns& columns, Eigen::Index i, double u) {
  return ((1 - u) * columns.col(i) + u * columns.col(i + 1)).eval();
}

Path record(const Eigen::VectorXd& time, const Angles& angles, const Eigen::Matrix3Xd& force,
            const RobotModel& truth, const PathRecorder& recorder) {
  const std::vector<Arrival> arrival = arrivals(angles);
  Random random(recorder.seed);
  const double period = recorder.period / (1 + recorder.clock_rate);
  const double begin = time[0] + period * random.uniform(0, 1);
  const double end = time[time.size() - 1];
  const auto ticks = static_cast<Eigen::Index>(std::max(0.0, (end - begin) / period)) + 2;
  Path path;
  path.time.resize(ticks);
  path.position.resize(3, ticks);
  path.force.resize(3, ticks);
  path.q.resize(angles.rows(), ticks);
  Eigen::Index i = 0, n = 0;
  for (int tick = 0;; ++tick) {
    const double t = begin + tick * period;
    if (t > end) break;
    while (i + 2 < time.size() && time[i + 1] <= t) ++i;
    const double u = (t - time[i]) / (time[i + 1] - time[i]);
    Context context;
    context.q = between(angles, i, u);
    context.arrival = arrival[i + 1].direction();
    context.stroke = arrival[i + 1].stroke();
    context.time_s = t;
    context.force_n = between(force, i, u);
    const Vector3d noise = recorder.noise * random.normal3();
    const Vector3d force_noise = recorder.force_noise * random.normal3();
    if (random.uniform(0, 1) < recorder.lost) continue;
    path.time[n] = (1 + recorder.clock_rate) * t + recorder.clock_offset;
    path.position.col(n) = truth.pose(context).translation + noise;
    path.force.col(n) = context.force_n + force_noise;
    path.q.col(n) = context.q;
    ++n;
  }
  path.time.conservativeResize(n);
  path.position.conservativeResize(Eigen::NoChange, n);
  path.force.conservativeResize(Eigen::NoChange, n);
  path.q.conservativeResize(Eigen::NoChange, n);
  return path;
}

}  // namespace

Eigen::Matrix3Xd cutting_force(const Path& path, const Cut& cut) {
  const Eigen::VectorXd length = arc_length(path);
  const Eigen::Matrix3Xd feed = tangents(path);
  const std::array<double, 2> engaged =
      cut.engaged.value_or(std::array<double, 2>{0, length[length.size() - 1]});
  if (engaged[0] >= std::min(engaged[1], length[length.size() - 1]))
    throw std::invalid_argument("the tool would cut from " + number(engaged[0]) + " to " +
                                number(engaged[1]) + " mm of a path of " +
                                number(length[length.size() - 1]) +
                                " mm; give the engagement as arc lengths s0,s1 within the path");
  const Variation variation(cut.part_seed);
  Eigen::Matrix3Xd force(3, path.samples());
  for (Eigen::Index i = 0; i < path.samples(); ++i) {
    const double share =
        engagement(length[i], engaged, cut.ramp) * (1 + cut.variation * variation(length[i]));
    const Vector3d across = Vector3d::UnitZ().cross(feed.col(i));
    const Vector3d normal = across.norm() > 1e-3 ? across.normalized() : Vector3d::Zero();
    const Vector3d along = cut.depth * share * cut.force_per_depth;
    force.col(i) = along.x() * feed.col(i) + along.y() * normal + along.z() * Vector3d::UnitZ();
  }
  return force;
}

Path simulate_pass(const Path& programmed, const Robot& robot, const Robot& truth,
                   const PassOptions& options) {
  const Angles followed =
      lagging(programmed.time, joint_path(programmed, robot.chain, options.joints), options.lag);
  const Path& part = options.part ? *options.part : programmed;
  if (!part.has_times_of(programmed))
    throw std::invalid_argument("the path of the part has other times than the path that runs");
  return record(programmed.time, followed, cutting_force(part, options.cut), RobotModel(truth),
                options.recorder);
}

}  // namespace armtrue
