#include "armtrue/diagnosis/size_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

// Each is as far below the smallest as the largest is above it in m: arms reach 0.2 to 30 m.
constexpr double kShortestArm = 0.03;       // m, all lengths together
constexpr double kSmallestBall = 0.05e-3;   // m, radius; a stylus has 0.1 mm, a ball of 50 mm in m
constexpr double kSmallestArtefact = 3e-3;  // m, from end to end; a bar of 3 m in m
constexpr double kLargestBall = 1;          // m, radius; one of 1 mm in um

void check_radius(const std::string& what, double radius, std::vector<std::string>& doubts) {
  if (radius == 0 || (radius >= kSmallestBall && radius <= kLargestBall)) return;
  doubts.push_back(fmt::format("{} has a radius of {:.4g} mm: is it in {}? Give it in mm", what,
                               radius / kMillimetre, radius < kSmallestBall ? "m" : "um"));
}

void check_contact(const Contact& contact, std::vector<std::string>& doubts) {
  const std::string name = "contact '" + contact.name + "': ";
  if (contact.kind == ContactKind::sphere && contact.is_placed)
    check_radius(name + "the sphere", contact.radius, doubts);
  if (contact.kind != ContactKind::artefact) return;
  if (contact.radius_is_known)
    check_radius(name + "the tip that touches it", contact.radius, doubts);
  double longest = 0;
  for (const ArtefactPoint& one : contact.points)
    for (const ArtefactPoint& other : contact.points)
      longest = std::max(longest, (one.position - other.position).norm());
  if (longest > 0 && longest < kSmallestArtefact)
    doubts.push_back(fmt::format(
        "{}its points, faces and balls lie within {:.3g} mm: are their places in m? Give them in "
        "mm",
        name, longest / kMillimetre));
  const auto ball = std::ranges::find(contact.points, ContactKind::sphere, &ArtefactPoint::kind);
  if (ball != contact.points.end()) check_radius(name + "its balls", ball->radius, doubts);
}

}  // namespace

std::vector<std::string> doubts_of_sizes(const KinematicChain& chain) {
  std::vector<std::string> doubts;
  double together = 0;
  for (const Link& link : chain.links) together += std::abs(link.d) + std::abs(link.r);
  if (together > 0 && together < kShortestArm)
    doubts.push_back(fmt::format(
        "all lengths of the links together are {:.3g} mm: are d_mm and r_mm in m? Give them in mm",
        together / kMillimetre));
  for (const Contact& contact : chain.contacts) check_contact(contact, doubts);
  return doubts;
}

}  // namespace armtrue
