#include "campaign/simulated_readings.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "armtrue/campaign/beam_sights.h"
#include "armtrue/campaign/profile_sights.h"
#include "armtrue/campaign/usual_noise.h"
#include "armtrue/campaign/views.h"

namespace armtrue {

double ReadingErrors::of_length() const {
  const double noise = options_->noise_position * random_->normal();
  return is_blunder() ? noise + random_->uniform(2e-3, 20e-3) : noise;
}

Eigen::Vector3d ReadingErrors::of_point() const {
  Eigen::Vector3d error = options_->noise_position * random_->normal3();
  if (is_blunder()) {
    const Eigen::Vector3d direction = random_->normal3().normalized();
    error += random_->uniform(2e-3, 20e-3) * direction;
  }
  return error;
}

Eigen::Vector2d ReadingErrors::of_pixel() const {
  Eigen::Vector2d error;
  for (double& value : error) value = options_->noise_pixel * random_->normal();
  if (is_blunder()) {
    const Eigen::Vector2d direction = random_->normal3().head<2>().normalized();
    error += random_->uniform(2, 20) * direction;
  }
  return error;
}

Eigen::Vector3d ReadingErrors::of_rotation() const {
  return options_->noise_orientation * random_->normal3();
}

Eigen::VectorXd ReadingErrors::of_touch(Eigen::Index numbers) const {
  if (numbers == 3) return of_point();
  return Eigen::VectorXd::Constant(1, of_length());
}

namespace {

// Indices of the targets; -1, the point of the tool, without any.
std::vector<int> targets_of(const KinematicChain& chain) {
  std::vector<int> targets;
  for (int k = chain.targets.empty() ? -1 : 0; k < target_count(chain); ++k) targets.push_back(k);
  return targets;
}

Instrument points_of(const Robot& truth, bool with_orientation, const ReadingErrors& errors) {
  return [&chain = truth.chain, model = RobotModel(truth), with_orientation,
          errors](const Visit& visit) {
    std::vector<ReadRow> rows;
    for (const int target : targets_of(chain)) {
      ReadRow row{.target = std::max(0, target)};
      row.position = model.point(visit.context, target) + errors.of_point();
      if (with_orientation)
        row.orientation = Eigen::Matrix3d(rotation_exp(errors.of_rotation()) *
                                          model.pose(visit.context).rotation);
      rows.push_back(row);
    }
    return rows;
  };
}

Instrument distances_of(const Robot& truth, const ReadingErrors& errors) {
  if (truth.chain.anchors.empty())
    throw std::invalid_argument(
        "the robot file has nothing that distances are measured from; add it under 'anchors'");
  return [&chain = truth.chain, model = RobotModel(truth), errors](const Visit& visit) {
    std::vector<ReadRow> rows;
    for (int anchor = 0; anchor < anchor_count(chain); ++anchor)
      for (const int target : targets_of(chain))
        rows.push_back(
            {.target = std::max(0, target),
             .anchor = anchor,
             .length = model.distance(visit.context, target, anchor) + errors.of_length()});
    return rows;
  };
}

Instrument cameras_of(const KinematicChain& chain, const ReadingErrors& errors,
                      std::vector<std::string>& all_names) {
  struct Corner {
    View view;
    int point = 0, name = 0;
  };
  std::vector<Corner> corners;
  for (const View& view : views_of(chain)) {
    const std::vector<std::string> names = corner_names(chain, view);
    for (int point = 0; point < std::ssize(names); ++point) {
      corners.push_back({view, point, static_cast<int>(all_names.size())});
      all_names.push_back(names[point]);
    }
  }
  return [&chain, corners, errors](const Visit& visit) {
    std::vector<ReadRow> rows;
    for (const auto& [view, point, name] : corners) {
      if (!shows(chain, view, visit.a_from_measured, point, 0)) continue;
      ReadRow row{.name = name, .is_pixel = true};
      row.position.head<2>() =
          pixel_of(chain, view, visit.a_from_measured, point) + errors.of_pixel();
      rows.push_back(row);
    }
    return rows;
  };
}

Instrument beams_of(const KinematicChain& chain, const ReadingErrors& errors,
                    std::vector<std::string>& all_names) {
  const std::vector<BeamSight> sights = beam_sights_of(chain);
  const int first_name = static_cast<int>(all_names.size());
  for (const BeamSight& sight : sights) all_names.push_back(sight.name);
  return [&chain, sights, first_name, errors](const Visit& visit) {
    std::map<int, std::pair<double, int>> nearest;  // of each beam
    for (int k = 0; k < std::ssize(sights); ++k)
      if (const auto length = beam_reading_at(chain, sights[k], visit.a_from_measured)) {
        const std::pair found(*length, k);
        const auto [known, is_new] = nearest.try_emplace(sights[k].beam, found);
        if (!is_new) known->second = std::min(known->second, found);
      }
    std::vector<ReadRow> rows;
    for (const auto& [beam, found] : nearest)
      rows.push_back(
          {.name = first_name + found.second, .length = found.first + errors.of_length()});
    return rows;
  };
}

Instrument scanner_of(const KinematicChain& chain, const Scanner& scanner,
                      const ReadingErrors& errors, std::vector<std::string>& all_names) {
  const std::vector<int> contacts = scanned_contacts(chain);
  std::map<int, int> names;  // of each contact
  for (const int contact : contacts) {
    names[contact] = static_cast<int>(all_names.size());
    all_names.push_back(chain.contacts[contact].name);
  }
  return [&chain, scanner, contacts, names, errors](const Visit& visit) {
    std::vector<ReadRow> rows;
    for (const auto& [contact, point] :
         profile_at(chain, scanner, contacts, visit.a_from_measured)) {
      ReadRow row{.name = names.at(contact), .profile = point};
      row.profile.z += errors.of_length();
      rows.push_back(row);
    }
    return rows;
  };
}

// The visit is the reading, with its error in the joint angles.
Instrument touches_of(const KinematicChain& chain, std::vector<std::string>& all_names) {
  std::map<std::string, int> names;
  for (const TouchSight& sight : touch_sights_of(chain))
    if (names.try_emplace(sight.name, static_cast<int>(all_names.size())).second)
      all_names.push_back(sight.name);
  return [names](const Visit& visit) {
    std::vector<ReadRow> rows;
    if (visit.touched)
      rows.push_back(
          {.target = std::max(0, visit.touched->target), .name = names.at(visit.touched->name)});
    return rows;
  };
}

}  // namespace

std::vector<Instrument> instruments_of(const Robot& truth, const SimulationOptions& options,
                                       const ReadingErrors& errors, Campaign& campaign) {
  const KinematicChain& chain = truth.chain;
  std::vector<Instrument> instruments;
  if (options.images) instruments.push_back(cameras_of(chain, errors, campaign.contact_names));
  if (options.touches) instruments.push_back(touches_of(chain, campaign.contact_names));
  if (options.beams) instruments.push_back(beams_of(chain, errors, campaign.contact_names));
  if (options.profiles)
    instruments.push_back(scanner_of(chain, *options.profiles, errors, campaign.contact_names));
  if (options.distances) instruments.push_back(distances_of(truth, errors));
  if (options.points) instruments.push_back(points_of(truth, options.orientation, errors));
  return instruments;
}

void append_reading(const ReadRow& row, const Robot& truth, const SimulationOptions& options,
                    Campaign& campaign) {
  const bool names_things = options.needs_sights();
  if (options.points || options.images) campaign.position.push_back(row.position);
  if (options.distances || names_things) campaign.distance.push_back(row.length);
  if (names_things) campaign.touch.push_back({row.name, -1, row.is_pixel});
  if (options.profiles) campaign.profile.push_back(row.profile);
  if (options.distances) campaign.anchor.push_back(row.anchor);
  if (!campaign.target_names.empty()) campaign.target.push_back(row.target);
  if (options.orientation) campaign.orientation.push_back(row.orientation);
  if (options.count() < 2) return;
  campaign.sigma_position.push_back(
      row.is_pixel
          ? stated_or_usual(options.noise_pixel, truth.noise.pixel, kUsualPixelNoise)
          : stated_or_usual(options.noise_position, truth.noise.position, kUsualPositionNoise));
}

}  // namespace armtrue
