#include "observation/beams.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>

#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/contact.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr int kOfBeam = 5, kOfPlane = 3;  // unknowns

// The points p of a plane: normal . p = height, in R_A.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double height = 0;
  bool is_known = false;
};

Plane plane_of(const Contact& contact, int point) {
  const ArtefactPoint& part = touched_part(contact, point);
  Plane plane;
  plane.normal = contact.place.rotation * part.normal;
  plane.height = plane.normal.dot(contact.place * part.position);
  plane.is_known = true;
  return plane;
}

struct Reading {
  Pose measured;  // R_A from the measured frame
  double length;
  size_t plane;
};

struct ReadBeam {
  std::vector<Reading> readings;
  std::vector<Plane> planes;
};

// One iterate of the fit of a beam and the planes that it reads.
class Guess {
 public:
  Guess(const ReadBeam& read, const Eigen::Vector3d& direction)
      : read_(&read), planes_(read.planes), along_(direction) {
    for (size_t k = 0; k < planes_.size(); ++k)
      if (!planes_[k].is_known) lay_plane(k);
  }

  const Eigen::Vector3d& origin() const { return origin_; }
  const Eigen::Vector3d& along() const { return along_; }

  // Sum of squares of the errors along the beam.
  double miss() const {
    double sum = 0;
    for (const Reading& reading : read_->readings) {
      const Plane& plane = planes_[reading.plane];
      const double cosine = plane.normal.dot(reading.measured.rotation * along_);
      sum += std::pow(off(reading) / std::max(kGrazing, std::abs(cosine)), 2);
    }
    return sum;
  }

  void refine() {
    constexpr int kMaxSteps = 60;
    constexpr double kFirstDamping = 1e-3, kLeastDamping = 1e-12, kStands = 1e-12;
    double damping = kFirstDamping;
    for (int k = 0; k < kMaxSteps && damping < 1 / kFirstDamping; ++k) {
      const Guess before = *this;
      const double size = step(damping), cost = before.cost();
      if (!(this->cost() < cost)) {
        *this = before;
        damping *= 10;
        continue;
      }
      if (size < kStands) return;
      damping = std::max(kLeastDamping, 0.1 * damping);
    }
  }

 private:
  Eigen::Vector3d end_of(const Reading& reading) const {
    return reading.measured * Eigen::Vector3d(origin_ + reading.length * along_);
  }
  double off(const Reading& reading) const {
    const Plane& plane = planes_[reading.plane];
    return plane.normal.dot(end_of(reading)) - plane.height;
  }
  double cost() const {
    double sum = 0;
    for (const Reading& reading : read_->readings) sum += std::pow(off(reading), 2);
    return sum;
  }

  // Through the ends of the beam, by the smallest singular vector.
  void lay_plane(size_t number) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    double count = 0;
    for (const Reading& reading : read_->readings)
      if (reading.plane == number) {
        mean += end_of(reading);
        ++count;
      }
    mean /= count;
    for (const Reading& reading : read_->readings)
      if (reading.plane == number) {
        const Eigen::Vector3d from = end_of(reading) - mean;
        squares += from * from.transpose();
      }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(squares, Eigen::ComputeThinU);
    planes_[number].normal = svd.matrixU().col(2);
    planes_[number].height = planes_[number].normal.dot(mean);
  }

  // Unknowns: origin, direction, then normal and height of each unknown plane. For each unit vector
  // one equation more keeps its change orthogonal to it. Returns the length of the step.
  double step(double damping) {
    std::vector<Eigen::Index> first(planes_.size(), -1);
    Eigen::Index count = 6;
    for (size_t k = 0; k < planes_.size(); ++k)
      if (!planes_[k].is_known) {
        first[k] = count;
        count += 4;
      }
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(count, count);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
    for (const Reading& reading : read_->readings) {
      const Plane& plane = planes_[reading.plane];
      const Eigen::Vector3d by_origin = reading.measured.rotation.transpose() * plane.normal;
      Eigen::VectorXd column = Eigen::VectorXd::Zero(count);
      column.segment<3>(0) = by_origin;
      column.segment<3>(3) = reading.length * by_origin;
      if (const Eigen::Index at = first[reading.plane]; at >= 0) {
        column.segment<3>(at) = end_of(reading);
        column[at + 3] = -1;
      }
      normal += column * column.transpose();
      right -= column * off(reading);
    }
    const auto weight = static_cast<double>(read_->readings.size());
    normal.block<3, 3>(3, 3) += weight * along_ * along_.transpose();
    for (size_t k = 0; k < planes_.size(); ++k)
      if (first[k] >= 0)
        normal.block<3, 3>(first[k], first[k]) +=
            weight * planes_[k].normal * planes_[k].normal.transpose();
    normal.diagonal().array() += damping * normal.trace();
    const Eigen::VectorXd step = normal.ldlt().solve(right);
    origin_ += step.head<3>();
    along_ = (along_ + step.segment<3>(3)).normalized();
    for (size_t k = 0; k < planes_.size(); ++k)
      if (first[k] >= 0) {
        planes_[k].normal = (planes_[k].normal + step.segment<3>(first[k])).normalized();
        planes_[k].height += step[first[k] + 3];
      }
    return step.norm();
  }

  const ReadBeam* read_;
  std::vector<Plane> planes_;
  Eigen::Vector3d origin_{0, 0, 0}, along_;
};

// The 26 directions towards the faces, edges and corners of a cube.
std::vector<Eigen::Vector3d> directions_all_around() {
  std::vector<Eigen::Vector3d> directions;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x != 0 || y != 0 || z != 0) directions.push_back(Eigen::Vector3d(x, y, z).normalized());
  return directions;
}

void place_beam(const ReadBeam& read, Contact& beam) {
  std::optional<Guess> best;
  double least = 0;
  for (const Eigen::Vector3d& direction : directions_all_around()) {
    Guess guess(read, direction);
    guess.refine();
    const double miss = guess.miss();
    if (best && !(miss < least)) continue;
    best.emplace(guess);
    least = miss;
  }
  beam.place.translation = best->origin();
  beam.place.rotation = shortest_rotation(Eigen::Vector3d::UnitZ(), best->along());
  beam.is_placed = true;
}

std::map<int, ReadBeam> readings_by_beam(const Robot& robot, const Campaign& campaign,
                                         const std::vector<bool>& known) {
  const std::vector<ContactPoint> matched = match_contacts(campaign, robot.chain);
  Robot arm = robot;
  arm.effects.clear();
  const RobotModel model(arm);
  std::map<int, ReadBeam> all;
  std::map<std::tuple<int, int, int>, size_t> numbers;  // of the planes of each beam
  for (int row = 0; row < campaign.rows(); ++row) {
    if (campaign.kind(row) != ReadingKind::touch) continue;
    const ContactPoint& which = matched[campaign.touch[row].contact];
    if (which.beam < 0 || known[which.beam]) continue;
    ReadBeam& read = all[which.beam];
    const auto [number, is_new] =
        numbers.try_emplace(std::tuple(which.beam, which.contact, which.point), read.planes.size());
    if (is_new)
      read.planes.push_back(known[which.contact]
                                ? plane_of(robot.chain.contacts[which.contact], which.point)
                                : Plane{});
    read.readings.push_back(
        {model.pose(campaign.context(row)), campaign.distance[row], number->second});
  }
  return all;
}

}  // namespace

Eigen::Vector3d end_of_beam(const Contact& beam, double reading) {
  return beam.place * Eigen::Vector3d(0, 0, reading);
}

Robot with_beams_placed(Robot robot, const Campaign& campaign, std::vector<bool>& known) {
  for (const auto& [number, read] : readings_by_beam(robot, campaign, known)) {
    Contact& beam = robot.chain.contacts[number];
    const auto unknown = std::ranges::count(read.planes, false, &Plane::is_known);
    const auto needed = kOfBeam + kOfPlane * unknown;
    if (std::ssize(read.readings) < needed)
      throw std::invalid_argument(
          fmt::format("{}: the beam '{}' has too few readings: {}, and its place and those of "
                      "unknown planes, {}, "
                      "follow from {} or more; measure more, or state the place of the beam in the "
                      "robot file, under 'beams'",
                      campaign.source, beam.name, read.readings.size(), unknown, needed));
    place_beam(read, beam);
    known[number] = true;
  }
  return robot;
}

}  // namespace armtrue
