#include "armtrue/path/simulation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <string>

#include "armtrue/effects/robot_model.h"
#include "armtrue/identification/campaign.h"
#include "armtrue/identification/random.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

using Angles = Eigen::Matrix<double, kJoints, Eigen::Dynamic>;
using Eigen::Vector3d;

// A random function of arc length with mean 0 and RMS 1: sines of half to twice the wavelength.
class Variation {
 public:
  Variation(double wavelength, std::uint64_t seed) {
    Random random(seed);
    for (Sine& sine : sines_) {
      sine.wave_number = 2 * std::numbers::pi / (wavelength * std::exp2(random.uniform(-1, 1)));
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

// First order, exact for commands that are linear between samples.
Angles lagging(const Eigen::VectorXd& time, const Angles& commanded, double lag) {
  if (lag <= 0) return commanded;
  Angles followed = commanded;
  for (Eigen::Index i = 1; i < time.size(); ++i) {
    const double step = time[i] - time[i - 1];
    const JointVector drag = lag / step * (commanded.col(i) - commanded.col(i - 1));
    followed.col(i) = commanded.col(i) - drag +
                      std::exp(-step / lag) * (followed.col(i - 1) - commanded.col(i - 1) + drag);
  }
  return followed;
}

// What the effects may depend on, at each sample of the controller.
Campaign controller_samples(const Eigen::VectorXd& time, const Angles& angles) {
  Campaign samples;
  for (Eigen::Index i = 0; i < time.size(); ++i) samples.q.push_back(angles.col(i));
  derive_arrival(samples);
  return samples;
}

// Between samples i and i + 1, u of the way.
template <typename Columns>
auto between(const Columns& columns, Eigen::Index i, double u) {
  return ((1 - u) * columns.col(i) + u * columns.col(i + 1)).eval();
}

// Rows of a recording, until their count is known.
struct Rows {
  std::vector<double> time;
  std::vector<Vector3d> position, force;
  std::vector<JointVector> q;

  Path path() const {
    const auto n = static_cast<Eigen::Index>(time.size());
    Path path;
    path.time = Eigen::Map<const Eigen::VectorXd>(time.data(), n);
    path.position.resize(3, n);
    path.force.resize(3, n);
    path.q.resize(kJoints, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto row = static_cast<size_t>(i);
      path.position.col(i) = position[row];
      path.force.col(i) = force[row];
      path.q.col(i) = q[row];
    }
    return path;
  }
};

Path record(const Eigen::VectorXd& time, const Angles& angles, const Eigen::Matrix3Xd& force,
            const RobotModel& truth, const PathRecorder& recorder) {
  const Campaign controller = controller_samples(time, angles);
  Random random(recorder.seed);
  const double period = recorder.period / (1 + recorder.clock_rate);
  const double begin = time[0] + period * random.uniform(0, 1);
  Rows rows;
  Eigen::Index i = 0;
  for (int tick = 0;; ++tick) {
    const double t = begin + tick * period;
    if (t > time[time.size() - 1]) break;
    while (i + 2 < time.size() && time[i + 1] <= t) ++i;
    const double u = (t - time[i]) / (time[i + 1] - time[i]);
    Context context;
    context.q = between(angles, i, u);
    context.arrival = controller.arrival[static_cast<size_t>(i + 1)];
    context.time_s = t;
    context.force_n = between(force, i, u);
    const Vector3d noise = recorder.noise * random.normal3();
    const Vector3d force_noise = recorder.force_noise * random.normal3();
    if (random.uniform(0, 1) < recorder.lost) continue;
    rows.time.push_back((1 + recorder.clock_rate) * t + recorder.clock_offset);
    rows.position.emplace_back(truth.pose(context).translation + noise);
    rows.force.emplace_back(context.force_n + force_noise);
    rows.q.push_back(context.q);
  }
  return rows.path();
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
  const Variation variation(cut.wavelength, cut.part_seed);
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
  const Angles commanded = joint_path(programmed, robot.chain, options.joints);
  const Angles followed = lagging(programmed.time, commanded, options.lag);
  return record(programmed.time, followed, cutting_force(programmed, options.cut),
                RobotModel(truth), options.recorder);
}

}  // namespace armtrue
