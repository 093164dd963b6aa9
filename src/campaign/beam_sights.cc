#include "armtrue/campaign/beam_sights.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "armtrue/campaign/campaign.h"
#include "armtrue/kinematics/contact.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/inverse.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/random.h"
#include "campaign/random_joints.h"

namespace armtrue {
namespace {

constexpr double kMostIncidence = 60 * kDegree;  // off the normal; less comes back to the sensor
constexpr double kUsualTilt = 45 * kDegree;      // of random poses
constexpr int kTriesPerSight = 2000;
constexpr int kAxesOfPose = 6;  // fewer reach few of the poses that are drawn

// The plane in R_A: its normal, and a point in it.
struct Surface {
  Eigen::Vector3d normal, point;
};

Surface surface_of(const KinematicChain& chain, const BeamSight& sight) {
  const Contact& contact = chain.contacts[sight.contact];
  const ArtefactPoint& part = touched_part(contact, sight.point);
  return {contact.place.rotation * part.normal, contact.place * part.position};
}

std::string why_not(const Contact& beam, const Contact& contact) {
  for (const Contact* one : {&beam, &contact})
    if (!one->is_placed)
      return "the robot file does not say where '" + one->name +
             "' is; state its place, or take the product of a calibration, which has it";
  if (beam.range.isZero())
    return "the beam '" + beam.name +
           "' does not state what it can read; add range_mm: [least, largest] to the robot file";
  return "";
}

// From a random configuration the beam goes to the nearest point of the plane, turned in any
// direction about the plane's normal and about itself.
std::optional<JointVector> go_to(const KinematicChain& chain, const ChainEvaluator& evaluator,
                                 const BeamSight& sight, const JointVector& start, Random& random) {
  const Contact& beam = chain.contacts[sight.beam];
  const Surface surface = surface_of(chain, sight);
  const Pose end{Eigen::Matrix3d::Identity(), {0, 0, random.uniform(beam.range[0], beam.range[1])}};
  const Eigen::Vector3d here = evaluator.pose(start) * (beam.place * end.translation);
  const double azimuth = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double tilt = random.uniform(0, kUsualTilt);
  const Eigen::Matrix3d facing =
      shortest_rotation(Eigen::Vector3d::UnitZ(), -surface.normal) *
      rotation_exp(tilt * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0)) *
      rotation_exp({0, 0, random.uniform(-std::numbers::pi, std::numbers::pi)});
  const Pose a_from_end{facing, here - surface.normal * surface.normal.dot(here - surface.point)};
  return inverse_kinematics(chain, a_from_end * inverse(beam.place * end), std::vector{start});
}

}  // namespace

std::vector<BeamSight> beam_sights_of(const KinematicChain& chain) {
  std::vector<BeamSight> sights;
  const auto count = static_cast<int>(chain.contacts.size());
  for (int b = 0; b < count; ++b) {
    const Contact& beam = chain.contacts[b];
    if (beam.kind != ContactKind::beam) continue;
    for (int c = 0; c < count; ++c) {
      const Contact& contact = chain.contacts[c];
      const bool is_plane = contact.kind == ContactKind::plane;
      const auto parts = is_plane ? 1 : static_cast<int>(contact.points.size());
      for (int k = 0; k < parts && (is_plane || contact.kind == ContactKind::artefact); ++k) {
        const int point = is_plane ? -1 : k;
        if (touched_part(contact, point).kind != ContactKind::plane) continue;
        if (const std::string why = why_not(beam, contact); !why.empty())
          throw std::invalid_argument(why);
        sights.push_back(
            {b, c, point,
             BeamName(beam.name,
                      is_plane ? contact.name : contact.name + "/" + contact.points[k].name)
                 .text()});
      }
    }
  }
  if (sights.empty())
    throw std::invalid_argument(
        "the robot file has no beam and plane; add them under 'beams' and 'contacts'");
  return sights;
}

std::optional<double> beam_reading_at(const KinematicChain& chain, const BeamSight& sight,
                                      const Pose& a_from_measured) {
  const Contact &beam = chain.contacts[sight.beam], &contact = chain.contacts[sight.contact];
  const Pose seen = inverse(contact.place) * a_from_measured * beam.place;
  const Eigen::Vector3d along = seen.rotation.col(2);
  if (-touched_part(contact, sight.point).normal.dot(along) < std::cos(kMostIncidence))
    return std::nullopt;
  const double length = beam_reading(contact, sight.point, seen.translation, along).value;
  return length >= beam.range[0] && length <= beam.range[1] ? std::optional(length) : std::nullopt;
}

std::vector<BeamPose> random_beam_poses(const KinematicChain& chain, int count,
                                        std::uint64_t seed) {
  Random random(seed);
  const ChainEvaluator evaluator(chain);
  const std::vector<BeamSight> sights = beam_sights_of(chain);
  std::vector<BeamPose> poses;
  int tries = 0;  // since the last that was found
  while (std::ssize(poses) < count) {
    const BeamSight& sight = sights[poses.size() % sights.size()];
    if (++tries > kTriesPerSight)
      throw std::invalid_argument("hardly any configuration within the travel reads '" +
                                  sight.name +
                                  "'; check the places of beam and plane, which way the plane "
                                  "faces, and range_mm");
    std::optional<JointVector> q = random_joints(chain, random);
    if (joint_count(chain) >= kAxesOfPose) q = go_to(chain, evaluator, sight, *q, random);
    if (!q || beyond_travel(chain, *q)) continue;
    const auto length = beam_reading_at(chain, sight, evaluator.pose(*q));
    if (!length) continue;
    poses.push_back({*q, sight, *length});
    tries = 0;
  }
  return poses;
}

}  // namespace armtrue
