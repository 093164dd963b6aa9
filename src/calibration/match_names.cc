#include <algorithm>
#include <optional>
#include <stdexcept>

#include "armtrue/calibration/observation.h"
#include "armtrue/kinematics/contact.h"

namespace armtrue {
namespace {

[[noreturn]] void fail_at(const Campaign& campaign, size_t row, const std::string& what) {
  const std::string line =
      row < campaign.line.size() ? ":" + std::to_string(campaign.line[row]) : "";
  throw std::invalid_argument(campaign.source + line + ": " + what);
}

bool has_kind(const Campaign& campaign, ReadingKind kind) {
  for (int row = 0; row < campaign.rows(); ++row)
    if (campaign.kind(row) == kind) return true;
  return false;
}

// The first row that has the name of this number in its column.
size_t first_row_of(size_t number, const std::vector<int>& column) {
  return static_cast<size_t>(std::find(column.begin(), column.end(), static_cast<int>(number)) -
                             column.begin());
}

}  // namespace

std::vector<int> match_targets(const Campaign& campaign, const KinematicChain& chain) {
  std::vector<int> indices;
  for (const std::string& name : campaign.target_names) {
    const auto found = std::find_if(chain.targets.begin(), chain.targets.end(),
                                    [&](const Target& target) { return target.name == name; });
    if (found == chain.targets.end())
      fail_at(campaign, first_row_of(indices.size(), campaign.target),
              "column 'target': the robot file has no target '" + name +
                  "'; add its offset in the measured frame to the robot file, under 'targets'");
    indices.push_back(static_cast<int>(found - chain.targets.begin()));
  }
  return indices;
}

std::vector<int> match_anchors(const Campaign& campaign, const KinematicChain& chain) {
  if (!campaign.has_distances()) return {};
  if (campaign.anchor_names.empty() && !has_kind(campaign, ReadingKind::distance)) return {};
  constexpr const char* kRemedy = "; add its place in R_A to the robot file, under 'anchors'";
  const auto the_only = [&] {
    if (chain.anchors.empty())
      fail_at(campaign, 0,
              std::string("column 'l_mm': the robot file has no anchor to measure from") + kRemedy);
    if (chain.anchors.size() > 1)
      fail_at(
          campaign, 0,
          "the robot file has " + std::to_string(chain.anchors.size()) +
              " anchors; say in a column 'anchor' from which of them each distance is measured");
    return 0;
  };
  if (campaign.anchor.empty()) return {the_only()};
  const auto first_row_from = [&](int anchor) {
    int row = 0;
    while (row < campaign.rows() &&
           (campaign.kind(row) != ReadingKind::distance || campaign.anchor[row] != anchor))
      ++row;
    return static_cast<size_t>(row);
  };
  std::vector<int> indices;
  for (const std::string& name : campaign.anchor_names) {
    const auto found = std::find_if(chain.anchors.begin(), chain.anchors.end(),
                                    [&](const Anchor& anchor) { return anchor.name == name; });
    if (found == chain.anchors.end())
      fail_at(campaign, first_row_from(static_cast<int>(indices.size())),
              "column 'anchor': the robot file has no anchor '" + name + "'" + kRemedy);
    indices.push_back(static_cast<int>(found - chain.anchors.begin()));
  }
  return indices;
}

namespace {

// Of `bar/2` the artefact `bar` and its point `2`.
std::optional<ContactPoint> find_contact(const KinematicChain& chain, const std::string& name) {
  for (size_t c = 0; c < chain.contacts.size(); ++c) {
    const Contact& contact = chain.contacts[c];
    if (contact.kind != ContactKind::artefact && contact.name == name)
      return ContactPoint{static_cast<int>(c)};
    for (size_t p = 0; p < contact.points.size(); ++p)
      if (contact.name + "/" + contact.points[p].name == name)
        return ContactPoint{static_cast<int>(c), static_cast<int>(p)};
  }
  return std::nullopt;
}

size_t first_touch_of(const Campaign& campaign, int contact) {
  size_t row = 0;
  while (row < campaign.touch.size() && campaign.touch[row].contact != contact) ++row;
  return row;
}

std::string why_unknown(const KinematicChain& chain, const std::string& name) {
  for (const Contact& contact : chain.contacts)
    if (contact.name == name)
      return "'" + name + "' is an artefact; say which of its points is touched, such as '" + name +
             "/" + contact.points.front().name + "'";
  const std::string artefact = name.substr(0, name.find('/'));
  for (const Contact& contact : chain.contacts)
    if (contact.kind == ContactKind::artefact && contact.name == artefact)
      return "the artefact '" + artefact + "' has no point '" +
             name.substr(std::min(name.size(), artefact.size() + 1)) +
             "'; add it to the robot file, under 'contacts'";
  return "the robot file has no contact '" + name +
         "'; add it to the robot file, under 'contacts', such as '" + name + ": {kind: point}'";
}

}  // namespace

std::vector<ContactPoint> match_contacts(const Campaign& campaign, const KinematicChain& chain) {
  std::vector<ContactPoint> matched;
  for (const std::string& name : campaign.contact_names) {
    const auto found = find_contact(chain, name);
    if (!found)
      fail_at(campaign, first_touch_of(campaign, static_cast<int>(matched.size())),
              "column 'contact': " + why_unknown(chain, name));
    matched.push_back(*found);
  }
  return matched;
}

void bind_touches(Campaign& campaign, const KinematicChain& chain) {
  if (!campaign.has_touches()) return;
  if (!campaign.session_names.empty())
    fail_at(
        campaign, 0,
        "column 'session': contacts are at rest beside the robot, and their readings are of one "
        "session; leave the column out, and give a contact that was moved another name");
  std::vector<bool> is_point;
  for (const ContactPoint& matched : match_contacts(campaign, chain))
    is_point.push_back(reads_point(chain.contacts[matched.contact].kind));
  for (int row = 0; row < campaign.rows(); ++row)
    if (campaign.kind(row) == ReadingKind::touch && campaign.distance[row] != 0 &&
        is_point[campaign.touch[row].contact])
      fail_at(
          campaign, static_cast<size_t>(row),
          "column 'l_mm': a gauge shows how far the tool stands off a plane or a sphere, and '" +
              campaign.contact_names[campaign.touch[row].contact] + "' is a point; empty the cell");
  touches_to_coordinates(campaign, is_point);
}

}  // namespace armtrue
