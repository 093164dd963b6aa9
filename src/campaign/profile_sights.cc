#include "armtrue/campaign/profile_sights.h"

#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "armtrue/campaign/beam_sights.h"
#include "armtrue/kinematics/contact.h"

namespace armtrue {
namespace {

// How far along a unit direction a surface is, both in the axes of the contact [m].
std::optional<double> length_of_ray(const Contact& contact, const Eigen::Vector3d& origin,
                                    const Eigen::Vector3d& along) {
  const double least_cosine = std::cos(kMostIncidence);
  if (contact.kind == ContactKind::plane) {
    if (-along.z() < least_cosine) return std::nullopt;
    return beam_reading(contact, -1, origin, along).value;
  }
  const double middle = -origin.dot(along);
  const double half = std::pow(contact.radius, 2) - (origin.squaredNorm() - middle * middle);
  if (half < std::pow(least_cosine * contact.radius, 2)) return std::nullopt;
  return middle - std::sqrt(half);
}

}  // namespace

std::vector<int> scanned_contacts(const KinematicChain& chain) {
  std::vector<int> contacts;
  std::string unplaced;
  for (int c = 0; c < contact_count(chain); ++c) {
    const Contact& contact = chain.contacts[c];
    if (contact.kind != ContactKind::plane && contact.kind != ContactKind::sphere) continue;
    if (contact.is_placed)
      contacts.push_back(c);
    else if (unplaced.empty())
      unplaced = contact.name;
  }
  if (contacts.empty())
    throw std::invalid_argument(
        unplaced.empty()
            ? "the robot file has no plane and no sphere that a scanner could read; add them "
              "under 'contacts'"
            : "the robot file does not say where '" + unplaced +
                  "' is; state its place, or take the product of a calibration, which has it");
  return contacts;
}

std::vector<ScannedPoint> profile_at(const KinematicChain& chain, const Scanner& scanner,
                                     const std::vector<int>& contacts,
                                     const Pose& a_from_measured) {
  std::vector<Pose> contact_from_scanner;
  for (const int c : contacts)
    contact_from_scanner.push_back(inverse(chain.contacts[c].place) * a_from_measured);
  const double ahead = scanner.range.sum() < 0 ? -1 : 1;
  std::vector<ScannedPoint> points;
  for (int ray = 0; ray < scanner.rays; ++ray) {
    const double angle = scanner.view * (static_cast<double>(ray) / (scanner.rays - 1) - 0.5);
    const Eigen::Vector3d along(0, std::sin(angle), ahead * std::cos(angle));
    std::optional<ScannedPoint> nearest;
    for (size_t k = 0; k < contacts.size(); ++k) {
      const Pose& seen = contact_from_scanner[k];
      const auto length =
          length_of_ray(chain.contacts[contacts[k]], seen.translation, seen.rotation * along);
      if (!length) continue;
      const ProfilePoint at{*length * along.y(), *length * along.z()};
      if (at.z < scanner.range.minCoeff() || at.z > scanner.range.maxCoeff()) continue;
      if (!nearest || std::abs(at.z) < std::abs(nearest->at.z)) nearest = {contacts[k], at};
    }
    if (nearest) points.push_back(*nearest);
  }
  return points;
}

}  // namespace armtrue
