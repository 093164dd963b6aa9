#include "armtrue/campaign/touch_sights.h"

#include <stdexcept>

#include "armtrue/kinematics/contact.h"

namespace armtrue {
namespace {

// Above a surface that is touched at `tip`, in R_A, the frame of the arm nearest to the tip; 0 of a
// point.
double height_of_arm(const KinematicChain& chain, const TouchSight& sight, const JointVector& q) {
  constexpr double kOff = 1e-3;  // m; a joint farther from the tip shows where the arm stands
  const Contact& contact = chain.contacts[sight.contact];
  if (reads_point(contact, sight.point)) return 0;
  const LinkFrames frames = ChainEvaluator(chain).link_frames(q);
  const Eigen::Vector3d tip =
      chain.base * (frames.back() * (chain.tool * touching_point(chain, sight)));
  const Pose contact_from_a = inverse(contact.place);
  const Eigen::Vector3d seen = contact_from_a * tip;
  const Eigen::Vector3d outwards = touch_reading(contact, sight.point, -1, seen).gradient;
  for (size_t j = frames.size(); j-- > 0;) {
    const Eigen::Vector3d arm = contact_from_a * (chain.base * frames[j].translation);
    if ((arm - seen).norm() > kOff) return outwards.dot(arm - seen);
  }
  return 0;
}

}  // namespace

std::vector<TouchSight> touch_sights_of(const KinematicChain& chain) {
  std::vector<TouchSight> sights;
  std::string unplaced;
  for (int c = 0; c < contact_count(chain); ++c) {
    const Contact& contact = chain.contacts[c];
    if (!is_touched(contact.kind)) continue;
    if (!contact.is_placed) {
      if (unplaced.empty()) unplaced = contact.name;
      continue;
    }
    const bool has_parts = contact.kind == ContactKind::artefact;
    const int parts = has_parts ? static_cast<int>(contact.points.size()) : 1;
    for (int part = 0; part < parts; ++part)
      for (int target = chain.targets.empty() ? -1 : 0; target < target_count(chain); ++target)
        sights.push_back({c, has_parts ? part : -1, target,
                          has_parts ? contact.name + "/" + contact.points[part].name : contact.name,
                          false});
  }
  if (sights.empty())
    throw std::invalid_argument(
        unplaced.empty()
            ? "the robot file has nothing that is touched; add it under 'contacts'"
            : "the robot file does not say where the contact '" + unplaced +
                  "' is; state its place, or take the product of a calibration, which has it");
  return sights;
}

std::optional<TouchSight> touch_at(const PlannedPose& pose, const KinematicChain& chain,
                                   const std::vector<TouchSight>& sights) {
  for (const TouchSight& sight : sights)
    if (sight.name == pose.contact && (sight.target < 0 || pose.target.empty() ||
                                       chain.targets[sight.target].name == pose.target))
      return sight;
  return std::nullopt;
}

Eigen::Vector3d touching_point(const KinematicChain& chain, const TouchSight& sight) {
  return sight.target < 0 ? Eigen::Vector3d::Zero() : chain.targets[sight.target].position;
}

Eigen::VectorXd off_surface(const KinematicChain& chain, const TouchSight& sight,
                            const Eigen::Vector3d& place, Eigen::MatrixX3d& gradients) {
  const Contact& contact = chain.contacts[sight.contact];
  const Eigen::Vector3d seen = inverse(contact.place) * place;
  const int count = reads_point(contact, sight.point) ? 3 : 1;
  Eigen::VectorXd off(count);
  gradients.resize(count, 3);
  for (int axis = 0; axis < count; ++axis) {
    const TouchReading reading = touch_reading(contact, sight.point, axis, seen);
    off[axis] = reading.value;
    gradients.row(axis) = contact.place.rotation * reading.gradient;
  }
  return off;
}

bool is_on_its_side(const KinematicChain& chain, const TouchSight& sight, const JointVector& q) {
  const double height = height_of_arm(chain, sight, q);
  return sight.from_below ? height < 0 : height >= 0;
}

}  // namespace armtrue
