#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <tuple>

#include "armtrue/kinematics/contact.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/names.h"
#include "armtrue/observation/observation.h"
#include "armtrue/statistics/summary.h"

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
  return std::find(column.begin(), column.end(), number) - column.begin();
}

}  // namespace

std::vector<int> match_targets(const Campaign& campaign, const KinematicChain& chain) {
  std::vector<int> indices;
  for (const std::string& name : campaign.target_names) {
    const auto found = find_name(chain.targets, name);
    if (!found)
      fail_at(campaign, first_row_of(indices.size(), campaign.target),
              "column 'target': the robot file has no target '" + name +
                  "'; add its offset in the measured frame to the robot file, under 'targets'");
    indices.push_back(*found);
  }
  return indices;
}

std::vector<int> match_anchors(const Campaign& campaign, const KinematicChain& chain) {
  if (!campaign.reads_one_number()) return {};
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
  const auto first_row_from = [&](std::ptrdiff_t anchor) {
    int row = 0;
    while (row < campaign.rows() &&
           (campaign.kind(row) != ReadingKind::distance || campaign.anchor[row] != anchor))
      ++row;
    return row;
  };
  std::vector<int> indices;
  for (const std::string& name : campaign.anchor_names) {
    const auto found = find_name(chain.anchors, name);
    if (!found)
      fail_at(campaign, first_row_from(indices.size()),
              "column 'anchor': the robot file has no anchor '" + name + "'" + kRemedy);
    indices.push_back(*found);
  }
  return indices;
}

namespace {

// The only contact of a kind with a name, or of an empty name the only one of the kind.
std::optional<int> of_kind(const KinematicChain& chain, ContactKind kind, const std::string& name) {
  std::optional<int> found;
  for (int c = 0; c < std::ssize(chain.contacts); ++c) {
    if (chain.contacts[c].kind != kind || (!name.empty() && chain.contacts[c].name != name))
      continue;
    if (found) return std::nullopt;
    found = c;
  }
  return found;
}

std::optional<ContactPoint> find_pixel(const KinematicChain& chain, const std::string& text) {
  const PixelName name(text);
  const auto camera = of_kind(chain, ContactKind::camera, name.camera);
  const auto board = of_kind(chain, ContactKind::board, name.board);
  if (!camera || !board) return std::nullopt;
  const auto point = find_name(chain.contacts[*board].points, name.corner);
  if (!point) return std::nullopt;
  return ContactPoint{*camera, *point, *board};
}

// How a robot file states one.
std::string example_of(ContactKind kind) {
  if (kind == ContactKind::beam) return "";
  return std::string(", such as ") +
         (kind == ContactKind::camera
              ? "eye: {on: arm, fx_px: 1500, fy_px: 1500, cx_px: 640, cy_px: 512}"
              : "board: {on: cell, pattern: \"checkerboard:9x6:25mm\"}") +
         "; armtrue-formats(5), IMAGES, has both";
}

// Why a beam, a camera or a board is not found.
std::string why_not_one(const KinematicChain& chain, ContactKind kind, const std::string& name) {
  const std::string word = kind == ContactKind::camera  ? "camera"
                           : kind == ContactKind::board ? "board"
                                                        : "beam";
  const std::string section = "'" + word + "s' of the robot file";
  if (!name.empty())
    return "column '" + word + "': " + section + " has no '" + name + "'; add it there";
  const bool any = std::ranges::count(chain.contacts, kind, &Contact::kind) > 0;
  return any ? "has no name of a " + word + ", and " + section + " has several; say in a column '" +
                   word + "' which one it is"
             : std::string("a row with ") +
                   (kind == ContactKind::beam ? "a beam" : "u_px and v_px") + " needs the " + word +
                   "; add it to the robot file, under '" + word + "s'" + example_of(kind);
}

std::string why_no_pixel(const KinematicChain& chain, const std::string& text) {
  const PixelName name(text);
  if (!of_kind(chain, ContactKind::camera, name.camera))
    return why_not_one(chain, ContactKind::camera, name.camera);
  const auto board = of_kind(chain, ContactKind::board, name.board);
  if (!board) return why_not_one(chain, ContactKind::board, name.board);
  return "column 'corner': the board '" + chain.contacts[*board].name + "' has no point '" +
         name.corner + "'; points of a grid are counted from 0, row by row";
}

// Of `bar/2` the artefact `bar` and its point `2`.
std::optional<ContactPoint> find_contact(const KinematicChain& chain, const std::string& name) {
  for (int c = 0; c < std::ssize(chain.contacts); ++c) {
    const Contact& contact = chain.contacts[c];
    if (!is_touched(contact.kind)) continue;
    if (contact.kind != ContactKind::artefact && contact.name == name) return ContactPoint{c};
    for (int p = 0; p < std::ssize(contact.points); ++p)
      if (contact.name + "/" + contact.points[p].name == name) return ContactPoint{c, p};
  }
  return std::nullopt;
}

// Of `laser:bar/2` the beam `laser` and what it ends on.
std::optional<ContactPoint> find_beam_reading(const KinematicChain& chain,
                                              const std::string& text) {
  if (!BeamName::is_one(text)) return std::nullopt;
  const BeamName name(text);
  const auto beam = of_kind(chain, ContactKind::beam, name.beam);
  std::optional<ContactPoint> found = find_contact(chain, name.contact);
  if (!beam || !found) return std::nullopt;
  found->beam = *beam;
  return found;
}

size_t first_touch_of(const Campaign& campaign, std::ptrdiff_t contact) {
  size_t row = 0;
  while (row < campaign.touch.size() && campaign.touch[row].contact != contact) ++row;
  return row;
}

std::string why_untouched(const KinematicChain& chain, const std::string& name,
                          const std::string& usual_kind) {
  for (const Contact& contact : chain.contacts)
    if (contact.name == name && contact.kind == ContactKind::beam)
      return "'" + name +
             "' is a beam; name it in a column 'beam', and here the plane on which it ends";
  for (const Contact& contact : chain.contacts)
    if (contact.name == name && is_of_images(contact.kind))
      return "'" + name +
             "' is seen, not touched; give its points as rows with the columns corner, u_px and "
             "v_px";
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
         "'; add it to the robot file, under 'contacts', such as '" + name +
         ": {kind: " + usual_kind + "}'";
}

std::string why_unknown(const KinematicChain& chain, const std::string& text) {
  const bool is_of_beam = BeamName::is_one(text);
  const BeamName name(text);
  if (is_of_beam && !of_kind(chain, ContactKind::beam, name.beam))
    return why_not_one(chain, ContactKind::beam, name.beam);
  return "column 'contact': " + (is_of_beam ? why_untouched(chain, name.contact, "plane")
                                            : why_untouched(chain, text, "point"));
}

}  // namespace

std::vector<ContactPoint> match_contacts(const Campaign& campaign, const KinematicChain& chain) {
  std::vector<ContactPoint> matched;
  for (const std::string& name : campaign.contact_names) {
    auto found = find_contact(chain, name);
    if (!found) found = find_beam_reading(chain, name);
    if (!found) found = find_pixel(chain, name);
    if (!found) {
      const size_t row = first_touch_of(campaign, matched.size());
      const bool is_pixel = row < campaign.touch.size() && campaign.touch[row].is_pixel;
      fail_at(campaign, row, is_pixel ? why_no_pixel(chain, name) : why_unknown(chain, name));
    }
    matched.push_back(*found);
  }
  return matched;
}

namespace {

void require_arm_between(const Campaign& campaign, const KinematicChain& chain,
                         const std::vector<ContactPoint>& matched) {
  for (int k = 0; k < std::ssize(matched); ++k) {
    if (matched[k].board < 0) continue;
    const Contact &camera = chain.contacts[matched[k].contact],
                  &board = chain.contacts[matched[k].board];
    if (camera.on_arm == board.on_arm)
      fail_at(campaign, first_touch_of(campaign, k),
              "the camera '" + camera.name + "' and the board '" + board.name + "' are both " +
                  (camera.on_arm ? "on the arm" : "at rest") +
                  ": their images do not show the arm; write on: arm at one of them in the robot "
                  "file, and on: cell at the other");
  }
}

// Median over the images of the length of a pixel at the board [m]: the standard deviation of the
// board's points over that of their pixels. Oblique views, in which the board looks smaller, count
// like others.
double length_of_pixel(const Campaign& campaign, const KinematicChain& chain,
                       const std::vector<ContactPoint>& matched) {
  constexpr int kFewestCorners = 4;  // corners from which the place of a board follows
  struct Sums {
    int count = 0;
    double squares = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();

    void add(const Eigen::Vector3d& point) {
      ++count;
      squares += point.squaredNorm();
      sum += point;
    }
    double spread() const { return std::sqrt(std::max(0.0, squares - sum.squaredNorm() / count)); }
  };
  std::map<std::tuple<int, int, int, int>, std::pair<Sums, Sums>> images;
  for (int row = 0; row < campaign.rows(); ++row) {
    if (campaign.kind(row) != ReadingKind::pixel) continue;
    const ContactPoint& seen = matched[campaign.touch[row].contact];
    auto& [on_board, in_image] =
        images[{campaign.pose[row], campaign.repeat.empty() ? 0 : campaign.repeat[row],
                seen.contact, seen.board}];
    on_board.add(chain.contacts[seen.board].points[seen.point].position);
    in_image.add(campaign.position[row]);
  }
  std::vector<double> lengths;
  for (const auto& [image, sums] : images)
    if (sums.first.count >= kFewestCorners && sums.second.spread() > 0 && sums.first.spread() > 0)
      lengths.push_back(sums.first.spread() / sums.second.spread());
  if (lengths.empty())
    fail_at(campaign, 0,
            "no image shows four points of a board: rows of one image have the same pose (and "
            "repeat), camera and board, and each its corner");
  return median(std::move(lengths));
}

// Pixels, one coordinate per row, become lengths at the board.
void scale_pixels(Campaign& campaign, double metre_per_pixel) {
  for (int row = 0; row < campaign.rows(); ++row) {
    if (campaign.kind(row) != ReadingKind::pixel) continue;
    campaign.distance[row] = metre_per_pixel * campaign.position[row][campaign.touch[row].axis];
    if (!campaign.sigma_position.empty()) campaign.sigma_position[row] *= metre_per_pixel;
  }
  campaign.position.clear();
  campaign.metre_per_pixel = metre_per_pixel;
}

// Refuses a beam that runs along its plane by the places in the robot file: rough places do not do
// that, so the plane is another one, or the places are wrong.
void require_beams_on_planes(const Campaign& campaign, const KinematicChain& chain,
                             const std::vector<ContactPoint>& matched) {
  if (std::ranges::all_of(matched, [](const ContactPoint& one) { return one.beam < 0; })) return;
  const ChainEvaluator evaluator(chain);
  for (int row = 0; row < campaign.rows(); ++row) {
    if (campaign.kind(row) != ReadingKind::touch) continue;
    const ContactPoint& which = matched[campaign.touch[row].contact];
    if (which.beam < 0) continue;
    const Contact &beam = chain.contacts[which.beam], &contact = chain.contacts[which.contact];
    const BeamName name(campaign.contact_names[campaign.touch[row].contact]);
    const ArtefactPoint& part = touched_part(contact, which.point);
    if (part.kind != ContactKind::plane)
      fail_at(campaign, row,
              "column 'contact': a beam reads how far a plane or a face of an artefact is, and '" +
                  name.contact + "' is a " +
                  (part.kind == ContactKind::point ? "point" : "sphere") +
                  "; name the plane on which the beam ends");
    if (!beam.is_placed || !contact.is_placed) continue;
    const Eigen::Vector3d along =
        evaluator.pose(campaign.q[row]).rotation * beam.place.rotation.col(2);
    if (std::abs(along.dot(contact.place.rotation * part.normal)) < kGrazing)
      fail_at(campaign, row,
              "the beam '" + beam.name + "' runs along the plane '" + name.contact +
                  "' and does not meet it, as the robot file has both; leave the row out, or state "
                  "neither where the beam is nor where the plane is: a calibration finds them");
  }
}

void require_profiles_on_surfaces(const Campaign& campaign, const KinematicChain& chain,
                                  const std::vector<ContactPoint>& matched) {
  if (!campaign.has_profiles()) return;
  for (int row = 0; row < campaign.rows(); ++row) {
    const int name = campaign.touch[row].contact;
    const ContactKind kind = chain.contacts[matched[name].contact].kind;
    if (kind != ContactKind::plane && kind != ContactKind::sphere)
      fail_at(campaign, row,
              "column 'contact': a profile lies on a plane or a sphere, and '" +
                  campaign.contact_names[name] +
                  "' is neither; name one of these, or give each part a contact of its own");
  }
}

}  // namespace

void bind_touches(Campaign& campaign, const KinematicChain& chain) {
  if (!campaign.has_touches()) return;
  const bool has_pixels = campaign.has_pixels();
  if (!campaign.session_names.empty())
    fail_at(
        campaign, 0,
        has_pixels
            ? "column 'session': images are of one session; leave the column out, and give a "
              "camera "
              "or a board that was moved another name"
            : "column 'session': contacts are at rest beside the robot, and their readings are of "
              "one session; leave the column out, and give a contact that was moved another name");
  const std::vector<ContactPoint> matched = match_contacts(campaign, chain);
  require_arm_between(campaign, chain, matched);
  require_beams_on_planes(campaign, chain, matched);
  require_profiles_on_surfaces(campaign, chain, matched);
  std::vector<bool> is_point;
  for (const ContactPoint& touched : matched)
    is_point.push_back(touched.board < 0 &&
                       reads_point(chain.contacts[touched.contact], touched.point));
  for (int row = 0; row < campaign.rows(); ++row)
    if (campaign.kind(row) == ReadingKind::touch && campaign.distance[row] != 0 &&
        is_point[campaign.touch[row].contact])
      fail_at(
          campaign, row,
          "column 'l_mm': a gauge shows how far the tool stands off a plane or a sphere, and '" +
              campaign.contact_names[campaign.touch[row].contact] + "' is a point; empty the cell");
  const double length = has_pixels ? length_of_pixel(campaign, chain, matched) : 0;
  touches_to_coordinates(campaign, is_point);
  if (has_pixels) scale_pixels(campaign, length);
}

}  // namespace armtrue
