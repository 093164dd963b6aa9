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

std::vector<int> readings_evenly_chosen(const Campaign& campaign, const std::vector<int>& rows,
                                        long count) {
  std::vector<int> pixels, others;
  for (int row : rows) (campaign.kind(row) == ReadingKind::pixel ? pixels : others).push_back(row);
  std::vector<int> chosen = evenly_chosen(others, count);
  std::vector<std::pair<std::string, std::string>> pair_of_name;  // camera and board
  for (const std::string& text : campaign.contact_names) {
    const PixelName name(text);
    pair_of_name.emplace_back(name.camera, name.board);
  }
  using Image = std::pair<int, int>;  // pose and repeat
  std::map<std::pair<std::string, std::string>, std::map<Image, std::vector<int>>> images;
  for (int row : pixels)
    images[pair_of_name[campaign.touch[row].contact]]
          [{campaign.pose[row], campaign.repeat.empty() ? 0 : campaign.repeat[row]}]
              .push_back(row);
  for (const auto& [pair, of_pair] : images) {
    const long available = std::ssize(of_pair), kept = std::min(available, kImagesOfPair);
    long place = 0;
    for (const auto& [image, own] : of_pair) {
      if (place * kept / available != (place + 1) * kept / available)
        chosen.insert(chosen.end(), own.begin(), own.end());
      ++place;
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
