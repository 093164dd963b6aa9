#include "path_plant.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace plant {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kPi = 3.14159265358979323846;
constexpr double kSpeed = 0.027, kAcceleration = 0.3, kProgramPeriod = 0.016, kStand = 1.0;
constexpr double kStep = 0.001;  // of the simulation [s]

// A piece of path between two stops.
struct Piece {
  double length;
  std::function<Vector3d(double)> at;  // by arc length
};

std::vector<Piece> pieces(Shape shape) {
  switch (shape) {
    case Shape::line:
      return {{0.3, [](double s) { return Vector3d(1.5 + s, -0.12, 0.85); }}};
    case Shape::arc:
      return {{0.18 * 0.9 * kPi, [](double s) {
                 return Vector3d(1.7 + 0.18 * std::cos(s / 0.18), 0.18 * std::sin(s / 0.18), 0.9);
               }}};
    case Shape::corner:
      return {{0.15, [](double s) { return Vector3d(1.5 + s, -0.1, 0.85); }},
              {0.15, [](double s) { return Vector3d(1.65, -0.1 + s, 0.85); }}};
    case Shape::pocket: {
      std::vector<Vector3d> corners;
      for (int k = 0; k < 3; ++k) {
        const double x = 0.3 - 0.08 * k, z = 0.85 + 0.08 * k;
        for (const auto& [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
          corners.emplace_back(1.7 + a * x, b * x, z);
      }
      std::vector<Piece> sides;
      for (size_t k = 1; k < corners.size(); ++k) {
        const Vector3d from = corners[k - 1], side = corners[k] - from;
        sides.push_back(
            {side.norm(), [=](double s) -> Vector3d { return from + s * side.normalized(); }});
      }
      return sides;
    }
    case Shape::spiral:
      break;
  }
  // Arc length of r = r0 + c phi, and the angle to a length by Newton.
  constexpr double kInner = 0.02, kOuter = 0.07, kAngle = 4 * kPi,
                   kPitch = (kOuter - kInner) / kAngle;
  const auto primitive = [](double r) {
    return (r * std::hypot(r, kPitch) + kPitch * kPitch * std::asinh(r / kPitch)) / (2 * kPitch);
  };
  const double start = primitive(kInner);
  return {{primitive(kOuter) - start, [=](double s) {
             double r = kInner + (kOuter - kInner) * s / (primitive(kOuter) - start);
             for (int i = 0; i < 20; ++i)
               r -= (primitive(r) - start - s) * kPitch / std::hypot(r, kPitch);
             const double phi = (r - kInner) / kPitch;
             return Vector3d(1.6 + r * std::cos(phi), r * std::sin(phi), 0.8);
           }}};
}

// Arc length at `t` of a move from stop to stop with a trapezoid of speed, and how long it takes.
double duration(double length) { return length / kSpeed + kSpeed / kAcceleration; }
double travelled(double length, double t) {
  const double ramp = kSpeed / kAcceleration, whole = duration(length);
  t = std::clamp(t, 0.0, whole);
  if (t < ramp) return 0.5 * kAcceleration * t * t;
  if (t > whole - ramp) return length - 0.5 * kAcceleration * (whole - t) * (whole - t);
  return kSpeed * (t - 0.5 * ramp);
}

// Linear between samples at equal steps from 0 on, the end values beyond.
template <typename Values>
auto interpolate(const VectorXd& time, const Values& values, double t) {
  const auto i = static_cast<Eigen::Index>(
      std::clamp(std::floor(t / time[1]), 0.0, static_cast<double>(time.size() - 2)));
  const double u = std::clamp((t - time[i]) / (time[i + 1] - time[i]), 0.0, 1.0);
  return ((1 - u) * values.col(i) + u * values.col(i + 1)).eval();
}

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  double normal() { return normal_(engine_); }
  Vector3d normal3() {
    const double x = normal(), y = normal(), z = normal();
    return {x, y, z};
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

// A slow random function of time with RMS 1: sines with periods of 1.5 to 8 s.
class SlowChange {
 public:
  explicit SlowChange(Dice& dice) {
    for (Sine& sine : sines_) sine = {2 * kPi / dice.uniform(1.5, 8.0), dice.uniform(0, 2 * kPi)};
  }
  double operator()(double t) const {
    double sum = 0;
    for (const Sine& sine : sines_) sum += std::sin(sine.omega * t + sine.phase);
    return sum * std::sqrt(2.0 / static_cast<double>(sines_.size()));
  }

 private:
  struct Sine {
    double omega, phase;
  };
  std::array<Sine, 5> sines_;
};

// Elastic, then sliding: from -1 (the axis moves down) to 1 (up) over `wind_up` of travel.
class Friction {
 public:
  explicit Friction(double wind_up) : wind_up_(wind_up) {}
  double moved(double by) { return state_ = std::clamp(state_ + 2 * by / wind_up_, -1.0, 1.0); }

 private:
  double wind_up_, state_ = -1;
};

Vector3d direction(const Program& program, double t) {
  // Standing: that of the nearest motion, which the tool is about to make or has made.
  for (double half = kProgramPeriod; half < program.time[program.time.size() - 1]; half *= 2) {
    const Vector3d chord = interpolate(program.time, program.position, t + half) -
                           interpolate(program.time, program.position, t - half);
    if (chord.norm() > 1e-6) return chord.normalized();
  }
  return Vector3d::Zero();
}

double engagement(const Program& program, double s, double ramp) {
  const double in = std::min(s - program.entry, program.exit - s);
  if (in <= 0) return 0;
  return in >= ramp ? 1.0 : in / ramp;
}

// What the part does to the tool at a time of the program.
Vector3d cutting_force(const Program& program, const Options& options, const SlowChange& change,
                       double t) {
  const double s = interpolate(program.time, program.arc_length.transpose(), t)[0];
  const double share = engagement(program, s, options.ramp);
  if (share == 0) return Vector3d::Zero();
  const Vector3d feed = direction(program, t), up = Vector3d::UnitZ(), left = up.cross(feed);
  const Vector3d f =
      options.force_per_depth * options.depth * share * (1 + options.force_variation * change(t));
  return f.x() * feed + f.y() * left + f.z() * up;
}

struct Motion {
  VectorXd time;
  Matrix3Xd position, force;
};

Motion move(const Program& program, const Matrix3Xd& commanded, const Options& options) {
  Dice part(options.part_seed), pass(options.pass_seed ^ 0x5bd1e995);
  const SlowChange force_change(part);
  const std::array<SlowChange, 3> drift{SlowChange(pass), SlowChange(pass), SlowChange(pass)};
  std::array<Friction, 2> friction{Friction(options.wind_up), Friction(options.wind_up)};
  const double c = std::cos(options.axes_angle), s = std::sin(options.axes_angle);
  const std::array<Vector3d, 2> axes{Vector3d(c, s, 0), Vector3d(-s, c, 0)};

  const auto n =
      static_cast<Eigen::Index>(std::floor(program.time[program.time.size() - 1] / kStep)) + 2;
  Motion motion{VectorXd(n), Matrix3Xd(3, n), Matrix3Xd(3, n)};
  Vector3d servo = commanded.col(0), told = servo;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) * kStep;
    const Vector3d before = told;
    told = interpolate(program.time, commanded, t);
    if (options.lag > 0) {
      // Exact for a command that is linear over the step.
      const double decay = std::exp(-kStep / options.lag);
      const Vector3d slope = (told - before) / kStep;
      servo = told - options.lag * slope + decay * (servo - before + options.lag * slope);
    } else {
      servo = told;
    }
    const Vector3d force = cutting_force(program, options, force_change, t);
    Matrix3d compliance = options.compliance;
    if (!options.compliance_along.empty()) {
      const auto k = static_cast<size_t>(std::lround(t / kProgramPeriod));
      compliance = options.compliance_along[std::min(k, options.compliance_along.size() - 1)];
    }
    Vector3d tool = servo + options.static_offset + compliance * force;
    for (int k = 0; k < 2; ++k)
      tool -=
          0.5 * options.reversal_step[k] * friction[k].moved(axes[k].dot(told - before)) * axes[k];
    if (options.repeatability > 0)
      tool += options.repeatability * Vector3d(drift[0](t), drift[1](t), drift[2](t));
    motion.time[i] = t;
    motion.position.col(i) = tool;
    motion.force.col(i) = force;
  }
  return motion;
}

double distance_to_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double u = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (p - a - u * ab).norm();
}

}  // namespace

Program program(Shape shape) {
  const std::vector<Piece> parts = pieces(shape);
  double end = 2 * kStand, length = 0;
  for (const Piece& piece : parts) {
    end += duration(piece.length);
    length += piece.length;
  }
  const auto n = static_cast<Eigen::Index>(std::ceil(end / kProgramPeriod)) + 1;
  Program program;
  program.time = VectorXd(n);
  program.arc_length = VectorXd(n);
  program.position = Matrix3Xd(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) * kProgramPeriod;
    double since = t - kStand, done = 0;
    size_t k = 0;
    for (; k + 1 < parts.size() && since > duration(parts[k].length); ++k) {
      since -= duration(parts[k].length);
      done += parts[k].length;
    }
    const double s = travelled(parts[k].length, since);
    program.time[i] = t;
    program.position.col(i) = parts[k].at(s);
    program.arc_length[i] = done + s;
  }
  program.entry = 0.08 * length;
  program.exit = 0.92 * length;
  return program;
}

Options ideal() {
  Options options;
  options.depth = 0;
  options.reversal_step = {0, 0};
  options.lag = 0;
  options.static_offset.setZero();
  options.clock_offset = options.clock_rate = 0;
  options.noise = options.force_noise = options.lost = 0;
  return options;
}

Record run(const Program& program, const Matrix3Xd& commanded, const Options& options) {
  const Motion motion = move(program, commanded, options);
  Record record;
  record.true_time = program.time;
  record.true_position.resize(3, program.time.size());
  record.true_force.resize(3, program.time.size());
  for (Eigen::Index i = 0; i < program.time.size(); ++i) {
    record.true_position.col(i) = interpolate(motion.time, motion.position, program.time[i]);
    record.true_force.col(i) = interpolate(motion.time, motion.force, program.time[i]);
  }

  Dice dice(options.pass_seed);
  const double begin = dice.uniform(0, options.period), end = program.time[program.time.size() - 1];
  std::vector<double> time;
  std::vector<Vector3d> position, force;
  for (int i = 0;; ++i) {
    // The instrument ticks evenly by its own clock.
    const double t = begin + i * options.period / (1 + options.clock_rate);
    if (t > end) break;
    const Vector3d seen =
        interpolate(motion.time, motion.position, t) + options.noise * dice.normal3();
    const Vector3d felt =
        interpolate(motion.time, motion.force, t) + options.force_noise * dice.normal3();
    if (dice.uniform(0, 1) < options.lost) continue;
    time.push_back((1 + options.clock_rate) * t + options.clock_offset);
    position.push_back(seen);
    force.push_back(felt);
  }
  const auto n = static_cast<Eigen::Index>(time.size());
  record.time = Eigen::Map<const VectorXd>(time.data(), n);
  record.position = Eigen::Map<const Matrix3Xd>(position.data()->data(), 3, n);
  record.force = Eigen::Map<const Matrix3Xd>(force.data()->data(), 3, n);
  return record;
}

VectorXd distances(const Program& program, const Matrix3Xd& position) {
  constexpr Eigen::Index kNear = 60;  // samples to either side: 26 mm at full speed
  const Eigen::Index n = program.time.size();
  VectorXd distance(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    double least = (position.col(i) - program.position.col(i)).norm();
    for (Eigen::Index k = std::max<Eigen::Index>(i - kNear, 0); k < std::min(i + kNear, n - 1); ++k)
      least = std::min(least, distance_to_segment(position.col(i), program.position.col(k),
                                                  program.position.col(k + 1)));
    distance[i] = least;
  }
  return distance;
}

double mean_distance(const Program& program, const Matrix3Xd& position) {
  const VectorXd distance = distances(program, position);
  double sum = 0;
  int count = 0;
  for (Eigen::Index i = 1; i < distance.size(); ++i)
    if (program.arc_length[i] > program.arc_length[i - 1]) {
      sum += distance[i];
      ++count;
    }
  return sum / count;
}

}  // namespace plant
