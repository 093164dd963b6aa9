#include "planning/touch_poses.h"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "armtrue/kinematics/contact.h"
#include "armtrue/kinematics/names.h"
#include "armtrue/observation/contacts.h"

namespace armtrue {
namespace {

constexpr int kDrawsPerTouch = 32;
constexpr double kOff = 1e-3;  // m; a joint farther from the tip shows on which side the arm stands

PlannedPose touch_at(const Campaign& campaign, int row) {
  PlannedPose pose;
  pose.contact = campaign.contact_names[campaign.touch[row].contact];
  if (!campaign.target.empty()) pose.target = campaign.target_names[campaign.target[row]];
  return pose;
}

// Whether the tool touches in the row or, of beams, whether one reads there.
bool is_touch(const Campaign& campaign, int row, bool of_beams) {
  return campaign.kind(row) == ReadingKind::touch &&
         BeamName::is_one(campaign.contact_names[campaign.touch[row].contact]) == of_beams;
}

std::vector<std::string> names_of_points(const Contact& contact) {
  if (contact.kind != ContactKind::artefact) return {contact.name};
  std::vector<std::string> names;
  for (const ArtefactPoint& point : contact.points)
    names.push_back(contact.name + "/" + point.name);
  return names;
}

// On which side of a plane or a sphere the arm stands: the height above it of the frame nearest to
// the tip that is not there itself. 0 of a point, which has no sides.
class Sides {
 public:
  Sides(const PoseCloud& cloud) : chain_(cloud.robot.chain), evaluator_(chain_) {
    for (int row = 0; row < cloud.given.rows(); ++row) {
      if (!is_touch(cloud.given, row, false)) continue;
      const PlannedPose pose = touch_at(cloud.given, row);
      given_[pose.contact] += height(pose, cloud.given.q[row]) < 0 ? -1 : 1;
    }
  }

  bool is_reachable(const PlannedPose& pose) const {
    const double own = height(pose, pose.q);
    const auto given = given_.find(pose.contact);
    const bool has_back = contact_of(pose).kind == ContactKind::plane;  // or only an outside
    return !has_back || given == given_.end() || given->second >= 0 ? own >= 0 : own < 0;
  }

 private:
  const Contact& contact_of(const PlannedPose& pose) const {
    const std::string name = pose.contact.substr(0, pose.contact.find('/'));
    return *std::ranges::find(chain_.contacts, name, &Contact::name);
  }

  static int point_of(const Contact& contact, const PlannedPose& pose) {
    if (contact.kind != ContactKind::artefact) return -1;
    const std::string name = pose.contact.substr(pose.contact.find('/') + 1);
    return find_name(contact.points, name).value();
  }

  double height(const PlannedPose& pose, const JointVector& q) const {
    const Contact& contact = contact_of(pose);
    const int point = point_of(contact, pose);
    if (reads_point(contact, point)) return 0;
    const LinkFrames frames = evaluator_.link_frames(q);
    Eigen::Vector3d tip = chain_.base * (frames.back() * chain_.tool.translation);
    for (const Target& target : chain_.targets)
      if (target.name == pose.target)
        tip = chain_.base * (frames.back() * (chain_.tool * target.position));
    const Pose contact_from_a = inverse(contact.place);
    const Eigen::Vector3d seen = contact_from_a * tip;
    const Eigen::Vector3d outwards = touch_reading(contact, point, -1, seen).gradient;
    for (size_t j = frames.size(); j-- > 0;) {
      const Eigen::Vector3d arm = contact_from_a * (chain_.base * frames[j].translation);
      if ((arm - seen).norm() > kOff) return outwards.dot(arm - seen);
    }
    return 0;
  }

  const KinematicChain& chain_;
  ChainEvaluator evaluator_;
  std::map<std::string, int> given_;  // above less below
};

}  // namespace

std::vector<PlannedPose> touches_to_plan(const Robot& robot, const Campaign& given) {
  std::vector<PlannedPose> touches;
  for (int row = 0; row < given.rows(); ++row)
    if (is_touch(given, row, false))
      if (PlannedPose pose = touch_at(given, row);
          std::ranges::find(touches, pose) == touches.end())
        touches.push_back(std::move(pose));
  if (!touches.empty()) return touches;
  for (const Contact& contact : robot.chain.contacts) {
    if (!is_touched(contact.kind)) continue;
    if (!contact.is_placed)
      throw std::invalid_argument("the robot file does not say where the contact '" + contact.name +
                                  "' is; state its place, or give poses that touch it (--given)");
    for (const std::string& name : names_of_points(contact)) {
      if (robot.chain.targets.empty()) touches.push_back({{}, name, ""});
      for (const Target& target : robot.chain.targets) touches.push_back({{}, name, target.name});
    }
  }
  return touches;
}

void state_ranges(const Campaign& given, KinematicChain& chain) {
  const std::vector<ContactPoint> matched = match_contacts(given, chain);
  std::map<int, Eigen::Vector2d> ranges;
  for (int row = 0; row < given.rows(); ++row) {
    if (!is_touch(given, row, true)) continue;
    const double length = given.distance[row];
    auto& range =
        ranges.try_emplace(matched[given.touch[row].contact].beam, length, length).first->second;
    range = {std::min(range[0], length), std::max(range[1], length)};
  }
  for (const auto& [beam, range] : ranges)
    if (chain.contacts[beam].range.isZero()) chain.contacts[beam].range = range;
}

std::vector<PlannedPose> random_touches(const PoseCloud& cloud, int count, std::uint64_t seed) {
  const Sides sides(cloud);
  std::vector<PlannedPose> poses;
  for (int draws = 2; draws <= kDrawsPerTouch; draws *= 2) {
    std::vector<PlannedPose> drawn;
    for (const JointVector& q :
         random_configurations(cloud.robot, draws * count, std::nullopt, seed)) {
      drawn.push_back(cloud.touches[drawn.size() % cloud.touches.size()]);
      drawn.back().q = q;
    }
    Campaign campaign = touch_readings(cloud, drawn);
    campaign.line = campaign.pose;  // which of those drawn it is
    const Campaign moved = moved_onto_contacts(cloud.robot, campaign);
    poses.clear();
    for (int row = 0; row < moved.rows() && std::ssize(poses) < count; ++row) {
      if (moved.touch[row].axis > 0) continue;
      PlannedPose pose = drawn[moved.line[row]];
      pose.q = moved.q[row];
      if (!beyond_travel(cloud.robot.chain, pose.q) && is_above_floor(cloud, pose.q) &&
          sides.is_reachable(pose))
        poses.push_back(std::move(pose));
    }
    if (std::ssize(poses) == count) break;
  }
  return poses;
}

Campaign touch_readings(const PoseCloud& cloud, const std::vector<PlannedPose>& poses) {
  Campaign campaign;
  campaign.source = "the poses to be planned";
  const bool by_target = !cloud.robot.chain.targets.empty();
  for (const Target& target : cloud.robot.chain.targets)
    campaign.target_names.push_back(target.name);
  for (int pose = 0; pose < std::ssize(poses); ++pose) {
    campaign.pose_ids.push_back(std::to_string(pose + 1));
    campaign.pose.push_back(pose);
    campaign.line.push_back(pose + 1);
    campaign.q.push_back(poses[pose].q);
    campaign.distance.push_back(0);
    campaign.touch.push_back({index_of(campaign.contact_names, poses[pose].contact), -1});
    if (by_target) campaign.target.push_back(index_of(campaign.target_names, poses[pose].target));
  }
  bind_touches(campaign, cloud.robot.chain);
  return campaign;
}

std::vector<PlannedPose> given_touches(const PoseCloud& cloud) {
  std::vector<PlannedPose> poses;
  std::vector<bool> is_in(cloud.given.pose_ids.size(), false);
  for (int row = 0; row < cloud.given.rows(); ++row) {
    const size_t pose = cloud.given.pose[row];
    if (is_in[pose] || !is_touch(cloud.given, row, cloud.options.beams)) continue;
    is_in[pose] = true;
    poses.push_back(touch_at(cloud.given, row));
    poses.back().q = cloud.given.q[row];
  }
  return poses;
}

}  // namespace armtrue
