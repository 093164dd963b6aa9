#include "armtrue/diagnosis/renumbered_images.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <stdexcept>
#include <tuple>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/observation/contacts.h"
#include "armtrue/observation/observation.h"

namespace armtrue {
namespace {

// Of each name of a corner the name of the one at the same place of the board turned by half a
// turn; -1: no reading has it.
std::vector<int> names_from_other_end(const KinematicChain& chain,
                                      const std::vector<ContactPoint>& names) {
  std::map<std::tuple<int, int, int>, int> of_corner;
  for (int name = 0; name < std::ssize(names); ++name)
    if (names[name].board >= 0)
      of_corner[{names[name].contact, names[name].board, names[name].point}] = name;
  std::vector<int> others(names.size(), -1);
  for (size_t name = 0; name < names.size(); ++name) {
    const auto& [camera, point, board, beam] = names[name];
    if (board < 0) continue;
    const auto last = static_cast<int>(chain.contacts[board].points.size()) - 1;
    if (const auto other = of_corner.find({camera, board, last - point}); other != of_corner.end())
      others[name] = other->second;
  }
  return others;
}

// Cameras and boards where most images show them; nothing if too few do.
std::optional<Robot> placed(const Robot& robot, const Campaign& campaign) {
  try {
    return with_contacts_fitted(robot, campaign, FitContacts::all);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

}  // namespace

RenumberedImages find_renumbered_images(const Robot& robot, const Campaign& campaign) {
  constexpr double kFarBetter = 0.1;  // of the mean error of an image
  if (!campaign.has_pixels_only()) return {};
  const std::optional<Robot> start = placed(robot, campaign);
  if (!start) return {};
  const std::vector<int> others =
      names_from_other_end(start->chain, match_contacts(campaign, start->chain));
  Campaign turned = campaign;
  for (Touch& touch : turned.touch)
    if (others[touch.contact] >= 0) touch.contact = others[touch.contact];
  const std::vector<double> as_read = evaluate(*start, campaign).position,
                            from_other_end = evaluate(*start, turned).position;
  RenumberedImages found;
  std::vector<std::string> ids;
  for (const std::vector<int>& image : rows_by_image(campaign)) {
    double before = 0, after = 0, compared = 0;
    for (const int row : image) {
      if (others[campaign.touch[row].contact] < 0) continue;
      before += as_read[row];
      after += from_other_end[row];
      ++compared;
    }
    if (2 * compared < static_cast<double>(image.size()) || after >= kFarBetter * before) continue;
    found.rows.insert(found.rows.end(), image.begin(), image.end());
    const std::string& id = campaign.pose_ids[campaign.pose[image.front()]];
    if (ids.empty() || ids.back() != id) ids.push_back(id);
  }
  std::ranges::sort(found.rows);
  if (!ids.empty())
    found.words = fmt::format(
        "{} of {} {} as if the corners were numbered from the other end of the board, by half a "
        "turn, and {} left out: number them as the others, or take a board whose two ends differ",
        ids.size() == 1 ? "the image" : "the images", fmt::join(ids, ", "),
        ids.size() == 1 ? "looks" : "look", ids.size() == 1 ? "is" : "are");
  return found;
}

}  // namespace armtrue
