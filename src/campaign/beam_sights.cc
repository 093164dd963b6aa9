#include "armtrue/campaign/beam_sights.h"

#include <cmath>
#include <stdexcept>

#include "armtrue/campaign/campaign.h"
#include "armtrue/kinematics/contact.h"

namespace armtrue {
namespace {

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

}  // namespace

std::vector<BeamSight> beam_sights_of(const KinematicChain& chain) {
  std::vector<BeamSight> sights;
  const int count = contact_count(chain);
  for (int b = 0; b < count; ++b) {
    const Contact& beam = chain.contacts[b];
    if (beam.kind != ContactKind::beam) continue;
    for (int c = 0; c < count; ++c) {
      const Contact& contact = chain.contacts[c];
      const bool is_plane = contact.kind == ContactKind::plane;
      const auto parts = is_plane ? 1 : std::ssize(contact.points);
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

}  // namespace armtrue
