#include "armtrue/campaign/selection.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace armtrue {
namespace {

constexpr int kMinAlike = 50;            // rows: enough to locate a base, a target or an anchor
constexpr long kMinPosesOfSession = 30;  // enough for a base and a few offsets of its own
constexpr long kImagesOfPair = 15;       // of a camera and a board: enough to place both

}  // namespace

std::vector<int> evenly_chosen(const std::vector<int>& rows, long count) {
  const long available = rows.size();
  const long kept = std::min(available, count);
  std::vector<int> chosen;
  for (long i = 0; i < kept; ++i) chosen.push_back(rows[i * available / kept]);
  return chosen;
}

namespace {

using Pair = std::pair<std::string, std::string>;  // camera and board

// The rows of the pixels of each image, by its pose and repeat, of each camera and board.
std::map<Pair, std::map<std::pair<int, int>, std::vector<int>>> images_by_pair(
    const Campaign& campaign, const std::vector<int>& pixels) {
  std::vector<Pair> pair_of_name;
  for (const std::string& text : campaign.contact_names) {
    const PixelName name(text);
    pair_of_name.emplace_back(name.camera, name.board);
  }
  std::map<Pair, std::map<std::pair<int, int>, std::vector<int>>> images;
  for (int row : pixels)
    images[pair_of_name[campaign.touch[row].contact]]
          [{campaign.pose[row], campaign.repeat.empty() ? 0 : campaign.repeat[row]}]
              .push_back(row);
  return images;
}

std::vector<int> pixels_of(const Campaign& campaign) {
  std::vector<int> pixels;
  for (int row = 0; row < campaign.rows(); ++row)
    if (campaign.kind(row) == ReadingKind::pixel) pixels.push_back(row);
  return pixels;
}

// Whether the k-th of `available` is among `kept` that are evenly drawn.
bool is_drawn(long k, long kept, long available) {
  return k * kept / available != (k + 1) * kept / available;
}

}  // namespace

std::vector<int> readings_evenly_chosen(const Campaign& campaign, const std::vector<int>& rows,
                                        long count) {
  std::vector<int> pixels, others;
  for (int row : rows) (campaign.kind(row) == ReadingKind::pixel ? pixels : others).push_back(row);
  std::vector<int> chosen = evenly_chosen(others, count);
  for (const auto& [pair, of_pair] : images_by_pair(campaign, pixels)) {
    const long available = std::ssize(of_pair), kept = std::min(available, kImagesOfPair);
    long place = 0;
    for (const auto& [image, own] : of_pair)
      if (is_drawn(place++, kept, available)) chosen.insert(chosen.end(), own.begin(), own.end());
  }
  std::ranges::sort(chosen);
  return chosen;
}

std::vector<std::vector<int>> rows_by_image(const Campaign& campaign) {
  std::vector<std::vector<int>> all;
  for (auto& [pair, of_pair] : images_by_pair(campaign, pixels_of(campaign)))
    for (auto& [image, own] : of_pair) all.push_back(std::move(own));
  return all;
}

std::vector<int> corners_evenly_chosen(const Campaign& campaign, long images, long corners) {
  std::vector<int> chosen;
  for (const auto& [pair, of_pair] : images_by_pair(campaign, pixels_of(campaign))) {
    const long available = std::ssize(of_pair), kept = std::min(available, images);
    long place = 0;
    for (const auto& [image, own] : of_pair) {
      if (!is_drawn(place++, kept, available)) continue;
      std::map<int, std::vector<int>> rows_of_corner;
      for (int row : own) rows_of_corner[campaign.touch[row].contact].push_back(row);
      const long seen = std::ssize(rows_of_corner), taken = std::min(seen, corners);
      long corner = 0;
      for (const auto& [name, rows] : rows_of_corner)
        if (is_drawn(corner++, taken, seen)) chosen.insert(chosen.end(), rows.begin(), rows.end());
    }
  }
  std::ranges::sort(chosen);
  return chosen;
}

std::vector<int> thinned_rows(const Campaign& campaign, int count) {
  std::map<std::array<int, 3>, std::vector<int>> alike;  // by session, target and quantity
  const auto of = [](const std::vector<int>& column, int row) {
    return column.empty() ? 0 : column[row];
  };
  for (int row = 0; row < campaign.rows(); ++row)
    alike[{of(campaign.session, row), of(campaign.target, row), campaign.quantity(row)}].push_back(
        row);
  std::vector<int> chosen;
  for (const auto& [key, rows] : alike) {
    const long available = rows.size();
    const long share = count * available / campaign.rows();
    const long kept = std::min(available, std::max<long>(share, kMinAlike));
    const std::vector<int> own = evenly_chosen(rows, kept);
    chosen.insert(chosen.end(), own.begin(), own.end());
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

std::vector<int> rows_of_some_poses(const Campaign& campaign, long count) {
  const long available = campaign.pose_ids.size();
  const std::vector<int> pose_by_id = campaign.pose_by_id();
  std::map<int, std::set<int>> poses_of_session;
  for (int row = 0; row < campaign.rows(); ++row)
    poses_of_session[campaign.session.empty() ? 0 : campaign.session[row]].insert(pose_by_id[row]);
  std::set<int> chosen;
  for (const auto& [session, poses] : poses_of_session) {
    const long own = poses.size();
    const long taken = std::clamp(own * count / available, std::min(own, kMinPosesOfSession), own);
    long place = 0;
    for (int pose : poses) {
      if (place * taken / own != (place + 1) * taken / own) chosen.insert(pose);
      ++place;
    }
  }
  std::vector<int> rows;
  for (int row = 0; row < campaign.rows(); ++row)
    if (chosen.contains(pose_by_id[row])) rows.push_back(row);
  return rows;
}

std::vector<int> rows_of_some_visits(const Campaign& campaign, const std::vector<int>& rows,
                                     long count) {
  std::map<std::array<int, 3>, std::vector<int>> replicates;  // by session, pose and channel
  for (int row : rows)
    replicates[{campaign.session.empty() ? 0 : campaign.session[row], campaign.pose[row],
                campaign.channel(row)}]
        .push_back(row);
  std::vector<int> chosen;
  for (const auto& [key, own] : replicates) {
    const std::vector<int> some =
        evenly_chosen(own, std::max(1L, std::ssize(own) * count / std::ssize(rows)));
    chosen.insert(chosen.end(), some.begin(), some.end());
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace armtrue
