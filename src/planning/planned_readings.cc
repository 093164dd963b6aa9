#include "planning/planned_readings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "armtrue/campaign/selection.h"
#include "armtrue/campaign/usual_noise.h"
#include "armtrue/observation/observation.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

const std::string& name_of(const Campaign& campaign, int row) {
  return campaign.contact_names[campaign.touch[row].contact];
}

bool is_of_beam(const Campaign& campaign, int row) {
  return campaign.kind(row) == ReadingKind::touch && BeamName::is_one(name_of(campaign, row));
}

bool is_touch(const Campaign& campaign, int row) {
  return campaign.kind(row) == ReadingKind::touch && !campaign.has_profiles() &&
         !is_of_beam(campaign, row);
}

Scanner scanner_that_read(const Campaign& given) {
  double nearest = given.profile.front().z, farthest = nearest, widest = 0;
  for (const ProfilePoint& point : given.profile) {
    nearest = std::min(nearest, point.z);
    farthest = std::max(farthest, point.z);
    widest = std::max(widest, std::abs(std::atan2(point.y, std::abs(point.z))));
  }
  return {Eigen::Vector2d(nearest, farthest), 2 * widest};
}

}  // namespace

ReadingKinds kinds_of(const Campaign& given) {
  ReadingKinds kinds;
  kinds.orientation = given.has_orientation();
  if (given.has_profiles()) {
    kinds.profiles = scanner_that_read(given);
    return kinds;
  }
  for (int row = 0; row < given.rows(); ++row) switch (given.kind(row)) {
      case ReadingKind::point:
      case ReadingKind::coordinate:
        kinds.points = true;
        break;
      case ReadingKind::distance:
        kinds.distances = true;
        break;
      case ReadingKind::pixel:
        kinds.images = true;
        break;
      case ReadingKind::touch:
        (is_of_beam(given, row) ? kinds.beams : kinds.touches) = true;
        break;
    }
  return kinds;
}

PlannedPose planned_pose_at(const Campaign& given, int row) {
  PlannedPose pose{given.q[row], "", ""};
  if (!is_touch(given, row)) return pose;
  pose.contact = name_of(given, row);
  if (!given.target.empty()) pose.target = given.target_names[given.target[row]];
  return pose;
}

std::vector<TouchSight> touches_of(const Campaign& given, const KinematicChain& chain) {
  const std::vector<TouchSight> all = touch_sights_of(chain);
  std::vector<TouchSight> touches;
  std::map<int, int> above;  // by contact: touches from its own side minus those from the other
  for (int row = 0; row < given.rows(); ++row) {
    if (!is_touch(given, row) || given.touch[row].axis > 0) continue;
    const auto sight = touch_at(planned_pose_at(given, row), chain, all);
    if (!sight) continue;
    above[sight->contact] += is_on_its_side(chain, *sight, given.q[row]) ? 1 : -1;
    if (std::ranges::none_of(touches, [&](const TouchSight& one) {
          return one.name == sight->name && one.target == sight->target;
        }))
      touches.push_back(*sight);
  }
  for (TouchSight& touch : touches)
    touch.from_below =
        chain.contacts[touch.contact].kind == ContactKind::plane && above[touch.contact] < 0;
  return touches;
}

void state_ranges(const Campaign& given, KinematicChain& chain) {
  const std::vector<ContactPoint> matched = match_contacts(given, chain);
  std::map<int, Eigen::Vector2d> ranges;
  for (int row = 0; row < given.rows(); ++row) {
    if (!is_of_beam(given, row)) continue;
    const double length = given.distance[row];
    auto& range =
        ranges.try_emplace(matched[given.touch[row].contact].beam, length, length).first->second;
    range = {std::min(range[0], length), std::max(range[1], length)};
  }
  for (const auto& [beam, range] : ranges)
    if (chain.contacts[beam].range.isZero()) chain.contacts[beam].range = range;
}

std::map<ReadingKind, double> stated_by_kind(const Campaign& given) {
  std::map<ReadingKind, std::vector<double>> all;
  for (size_t row = 0; row < given.sigma_position.size(); ++row) {
    const ReadingKind kind = given.kind(static_cast<int>(row));
    const double unit = kind == ReadingKind::pixel ? given.metre_per_pixel : 1;
    all[kind].push_back(given.sigma_position[row] / unit);
  }
  std::map<ReadingKind, double> stated;
  for (auto& [kind, values] : all) stated[kind] = median(std::move(values));
  return stated;
}

namespace {

// At most `most` corners of each image, which span it, each with the weight of those that it stands
// for. None of an image with fewer than four corners: it does not show where the board is.
Campaign with_fewer_corners(const Campaign& campaign, size_t most) {
  constexpr size_t kFewest = 4;
  std::vector<bool> is_kept(campaign.q.size(), true);
  std::vector<double> sigma = campaign.sigma_position;
  for (const std::vector<int>& image : rows_by_image(campaign)) {
    for (const int row : image) is_kept[row] = false;
    if (image.size() < kFewest) continue;
    const size_t used = std::min(image.size(), most);
    for (size_t k = 0; k < used; ++k) {
      const int row = image[k * (image.size() - 1) / (used - 1)];
      is_kept[row] = true;
      sigma[row] *= std::sqrt(static_cast<double>(used) / static_cast<double>(image.size()));
    }
  }
  std::vector<int> kept;
  for (int row = 0; row < campaign.rows(); ++row)
    if (is_kept[row]) kept.push_back(row);
  Campaign chosen = campaign.select(kept);
  chosen.sigma_position.clear();
  for (const int row : kept) chosen.sigma_position.push_back(sigma[row]);
  return chosen;
}

// Whether the rows of readings() state their standard deviations.
bool is_stated(const ReadingKinds& kinds) { return kinds.images || kinds.count() > 1; }

void state_noise(const PoseCloud& cloud, Campaign& campaign) {
  campaign.sigma_position.resize(campaign.q.size());
  for (int row = 0; row < campaign.rows(); ++row) {
    const ReadingKind kind = campaign.kind(row);
    const auto stated = cloud.stated_noise.find(kind);
    campaign.sigma_position[row] = stated != cloud.stated_noise.end() ? stated->second
                                   : kind == ReadingKind::pixel       ? cloud.noise_pixel
                                                                      : cloud.noise_length;
  }
}

}  // namespace

Campaign readings(const PoseCloud& cloud, const std::vector<PlannedPose>& poses, Corners corners) {
  constexpr size_t kMostCorners = 12;  // of an image; more show the same of a pose
  SimulationOptions options;
  static_cast<ReadingKinds&>(options) = cloud.options;
  options.order = VisitOrder::as_given;
  Campaign campaign = simulate(poses, cloud.robot, options);
  campaign.source = "the poses to be planned";
  campaign.repeat.clear();
  campaign.time_s.clear();
  campaign.arrival.clear();
  campaign.stroke.clear();
  if (options.points && options.count() > 1) points_to_coordinates(campaign);
  if (is_stated(options)) state_noise(cloud, campaign);
  if (options.images)
    campaign =
        with_fewer_corners(campaign, corners == Corners::some ? kMostCorners : campaign.q.size());
  bind_touches(campaign, cloud.robot.chain);
  return campaign;
}

ReadingSigma sigma_of(const PoseCloud& cloud, const Campaign& campaign) {
  ReadingSigma sigma = cloud.noise;
  if (!is_stated(cloud.options)) return sigma;
  if (!campaign.sigma_position.empty())
    sigma.position = cloud.noise_factor * median(std::vector(campaign.sigma_position));
  else if (campaign.has_pixels_only())
    sigma.position = cloud.noise_factor * cloud.noise_pixel * campaign.metre_per_pixel;
  return sigma;
}

void set_noise_by_spread(PoseCloud& cloud, const ReadingSigma& spread) {
  if (cloud.given.has_orientation() && spread.orientation > 0)
    cloud.noise.orientation = std::max(spread.orientation, cloud.robot.noise.orientation);
  if (!(spread.position > 0)) return;
  if (!is_stated(cloud.options)) {
    cloud.noise.position = std::max(spread.position, cloud.robot.noise.position);
    return;
  }
  const double stated = sigma_of(cloud, cloud.given).position;
  const bool is_known = !cloud.given.sigma_position.empty() || cloud.robot.noise.pixel > 0;
  const double factor =
      is_known ? std::max(1.0, spread.position / stated) : spread.position / stated;
  cloud.noise_factor *= factor;
  cloud.noise.position *= factor;
}

}  // namespace armtrue
