#include "armtrue/calibration/identifiability.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <stdexcept>

#include "armtrue/campaign/selection.h"
#include "armtrue/effects/identify.h"
#include "armtrue/effects/sampling.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/contacts.h"
#include "armtrue/observation/session_models.h"
#include "calibration/column_choice.h"
#include "calibration/prior.h"

namespace armtrue {
namespace {

constexpr double kRightAngleTolerance = kDegree;
constexpr int kMaxRows = 4000;  // rank needs no more; thinned evenly

double snap_to_right_angle(double angle) {
  constexpr double kRight = std::numbers::pi / 2;
  const double nearest = std::round(angle / kRight) * kRight;
  return std::abs(angle - nearest) < kRightAngleTolerance ? nearest : angle;
}

Robot ideal_structure(Robot robot) {
  for (Link& link : robot.chain.links) {
    link.alpha = snap_to_right_angle(link.alpha);
    link.beta = snap_to_right_angle(link.beta);
  }
  robot.effects.clear();
  return robot;
}

// Coordinates of anchors; last those that the base imitates best. Of six that a motion of R_A,
// with derivatives e_k^T (I, -[p]x / s) at an anchor p with the size s of all, changes almost
// alike, as the heights of three on one line, it could not take up the errors.
std::vector<int> coordinates_of_anchors(const KinematicChain& chain) {
  constexpr int kMotions = 6;
  constexpr double kLeast = 1e-3;  // of a derivative that the others leave
  const int count = anchor_count(chain);
  if (count == 0) return {};
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Anchor& anchor : chain.anchors) middle += anchor.position / count;
  double square = 0;
  for (const Anchor& anchor : chain.anchors)
    square += (anchor.position - middle).squaredNorm() / count;
  const double size = square > 0 ? std::sqrt(square) : 1;
  Eigen::MatrixXd motions(3 * count, kMotions);
  for (int a = 0; a < count; ++a)
    motions.middleRows<3>(3 * a) << Eigen::Matrix3d::Identity(),
        cross_matrix(middle - chain.anchors[a].position) / size;
  std::set<int> references;
  for (int k = 0; k < kMotions; ++k) {
    int best = 0;
    for (int row = 0; row < motions.rows(); ++row)
      if (motions.row(row).norm() >= motions.row(best).norm()) best = row;
    const Eigen::RowVectorXd along = motions.row(best);
    if (along.norm() < kLeast) break;
    references.insert(best);
    motions -= motions * along.transpose() * along / along.squaredNorm();
  }
  std::vector<int> order(motions.rows());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_partition(order, [&](int row) { return !references.contains(row); });
  for (int& row : order) row = first_anchor_parameter(chain) + 4 * (row / 3) + row % 3;
  return order;
}

std::vector<int> preference_order(const Robot& robot) {
  const KinematicChain& chain = robot.chain;
  std::vector<int> order;
  const int anchors = first_anchor_parameter(chain), contacts = first_contact_parameter(chain);
  for (int c = 0; c < std::ssize(chain.contacts); ++c)
    for (int k : parameters_of_contact(chain.contacts[c]))
      order.push_back(contacts + kParametersOfContact * c + k);
  for (int k = 0; k < 6; ++k) order.push_back(kFirstBaseParameter + k);
  std::ranges::copy(coordinates_of_anchors(chain), std::back_inserter(order));
  const ParameterLayout layout = layout_of(chain);
  for (int k = layout.targets; k < anchors; ++k) order.push_back(k);
  for (int k = 0; k < 6; ++k) order.push_back(layout.tool + k);
  // A joint's zero offset first: r of a prismatic one takes the place that theta has elsewhere.
  const auto in_turn = [&](LinkParameter which, int link) {
    if (!is_prismatic(chain.links[link])) return which;
    if (which == LinkParameter::theta) return LinkParameter::r;
    return which == LinkParameter::r ? LinkParameter::theta : which;
  };
  // Where a positioner stands is its set-up, as the base is; only then the links.
  for (const bool placing : {true, false})
    for (LinkParameter which : {LinkParameter::theta, LinkParameter::alpha, LinkParameter::d,
                                LinkParameter::r, LinkParameter::beta})
      for (int j = 0; j < link_count(chain); ++j)
        if (const int k = link_parameter(j, in_turn(which, j));
            places_positioner(robot, k) == placing)
          order.push_back(k);
  for (int k = layout.couplings; k < layout.geometric; ++k) order.push_back(k);
  for (int k = anchors + 3; k < contacts; k += 4) order.push_back(k);
  return order;
}

// Whether rows of the campaign read something that a parameter is part of: those of the links, the
// tool and the base always are.
class ReadParameters {
 public:
  ReadParameters(const Campaign& campaign, const KinematicChain& chain)
      : layout_(layout_of(chain)),
        targets_end_(first_anchor_parameter(chain)),
        anchors_end_(first_contact_parameter(chain)),
        targets_(!campaign.target_names.empty()),
        anchors_(campaign.reads_one_number() &&
                 !(campaign.has_touches() && match_anchors(campaign, chain).empty())) {
    const std::vector<ContactPoint> matched = match_contacts(campaign, chain);
    for (const Touch& touch : campaign.touch)
      if (touch.contact >= 0) {
        contacts_.insert(matched[touch.contact].contact);
        for (const int other : {matched[touch.contact].board, matched[touch.contact].beam})
          if (other >= 0) contacts_.insert(other);
      }
  }

  bool contains(int parameter) const {
    if (parameter < layout_.targets) return true;
    if (parameter < targets_end_) return targets_;
    if (parameter < anchors_end_) return anchors_;
    return contacts_.contains((parameter - anchors_end_) / kParametersOfContact);
  }

 private:
  ParameterLayout layout_;
  int targets_end_, anchors_end_;
  bool targets_, anchors_;
  std::set<int> contacts_;
};

// Table 2 of the seed paper.
std::vector<int> paper_25(const KinematicChain& chain) {
  if (!is_six_axis_arm(chain))
    throw std::invalid_argument(
        "identify: paper-25 names parameters of six revolute joints and one fixed link, which this "
        "robot is not; use auto, or names such as A2.d");
  std::vector<int> set;
  const auto add = [&](LinkParameter which, std::initializer_list<int> joints) {
    for (int joint : joints) set.push_back(link_parameter(joint - 1, which));
  };
  add(LinkParameter::alpha, {1, 2, 3, 4, 5, 6});
  add(LinkParameter::d, {1, 2, 3, 4, 5, 6, 7});
  add(LinkParameter::r, {1, 2, 4, 5, 6});
  add(LinkParameter::theta, {1, 2, 3, 4, 5, 6});
  add(LinkParameter::beta, {3});
  return set;
}

// What one right entry names, without its sign.
std::vector<int> named_parameters(const Robot& robot, const ReadParameters& read,
                                  const std::string& name) {
  const KinematicChain& chain = robot.chain;
  const int targets = layout_of(chain).targets, anchors = first_anchor_parameter(chain);
  std::vector<int> named;
  // Those that are read, from `first` to before `end`.
  const auto add_read = [&](int first, int end, const std::string& pattern = "*") {
    for (int k : preference_order(robot))
      if (k >= first && k < end && read.contains(k) && matches(pattern, parameter_name(chain, k)))
        named.push_back(k);
  };
  // Where contacts are, with the tool those that are on the arm; not the numbers of a camera, which
  // no set-up changes.
  const auto add_places = [&](Owner owner) {
    const int first = first_contact_parameter(chain);
    for (int c = 0; c < std::ssize(chain.contacts); ++c)
      if (chain.contacts[c].on_arm == (owner == Owner::tool))
        add_read(first + kParametersOfContact * c,
                 first + kParametersOfContact * c + kFirstIntrinsic);
  };
  if (name == "paper-25") return paper_25(chain);
  if (name == "auto") {
    add_read(0, parameter_count(chain));
    // A screw and rods are as exact as they are made: nothing is asked of their coefficients,
    // unless the file says how exact that is.
    std::erase_if(named, [&](int k) {
      return layout_of(chain).is_of_couplings(k) &&
             !robot.priors.contains(parameter_name(chain, k));
    });
  } else if (is_pattern(chain, name)) {
    add_read(0, parameter_count(chain), name);
  } else if (const Parameter whole(name); group_size(whole) == kParametersPerPose) {
    const int first = *first_parameter(chain, whole);
    for (int k = 0; k < kParametersPerPose; ++k) named.push_back(first + k);
    if (whole.owner == Owner::tool) add_read(targets, anchors);
    if (whole.owner == Owner::base) add_read(anchors, first_contact_parameter(chain));
    add_places(whole.owner);
  } else {
    named.push_back(*find_parameter(chain, name));
  }
  return named;
}

struct Listed {
  std::vector<int> named;    // by any entry
  std::vector<int> allowed;  // and not taken away
};

Listed listed_parameters(const Robot& robot, const Campaign& campaign) {
  if (robot.identify.empty())
    throw std::invalid_argument(
        "identify: names nothing; use auto, paper-25, base, tool, or names such as A2.d");
  if (const std::string why = why_not_identified(robot.chain, robot.identify); !why.empty())
    throw std::invalid_argument("identify: " + why);
  const ReadParameters read(campaign, robot.chain);
  Listed listed;
  for (const std::string& text : robot.identify) {
    const IdentifyEntry entry(text);
    const std::vector<int> named = named_parameters(robot, read, entry.name);
    if (entry.takes_away) {
      std::erase_if(listed.allowed, [&](int k) { return std::ranges::count(named, k) > 0; });
    } else {
      for (std::vector<int>* list : {&listed.named, &listed.allowed})
        list->insert(list->end(), named.begin(), named.end());
    }
  }
  if (listed.allowed.empty())
    throw std::invalid_argument(
        fmt::format("identify: '{}' names nothing that was read; name more, or take away less",
                    fmt::join(robot.identify, ",")));
  return listed;
}

// `order`: of preference, of the parameters that are allowed.
IdentifiableSet choose_in_order(const Robot& ideal, const Campaign& rows,
                                const std::vector<int>& order) {
  // Lengths weigh against angles as at arm's length: only the ratio matters, and little.
  const SessionModels models(rows, ideal, order, {1.0, 1.0}, kAllEffects,
                             SessionModels::Split::by_target);
  return choose_columns(models, ideal.chain);
}

// The nominal length that a parameter of a link is [m]; 0 of angles and of what an encoder adds to.
double length_of(const KinematicChain& chain, int parameter) {
  if (!layout_of(chain).is_of_links(parameter) || is_zero_offset(chain, parameter)) return 0;
  const Link& link = chain.links[link_of_parameter(parameter)];
  const LinkParameter which = kind_of_parameter(parameter);
  return which == LinkParameter::d ? link.d : which == LinkParameter::r ? link.r : 0;
}

// Whether these parts of an artefact can be touched as well by an arm that is larger by one factor.
// With c the artefact's shift and g the growth of the radius r of what touches, per factor,
//     c - b = 0                    for each point b,
//     c - b = 0 and g - R - r = 0  for each ball with centre b and radius R,
//     n . (c - b) + g - r = 0      for each face through b with the normal n:
// a radius that is known does not grow.
bool imitates_scale(const Contact& artefact, const std::set<int>& parts) {
  constexpr double kExactTo = 1e-9;  // m
  std::vector<Eigen::Vector4d> rows;
  std::vector<double> right;
  const double growing = artefact.radius_is_known ? 0 : 1;
  const auto add = [&](const Eigen::Vector3d& by_shift, double by_growth, double value) {
    rows.emplace_back(by_shift.x(), by_shift.y(), by_shift.z(), by_growth * growing);
    right.push_back(value);
  };
  for (int k : parts) {
    const ArtefactPoint& part = artefact.points[k];
    if (part.kind == ContactKind::plane) {
      add(part.normal, 1, part.normal.dot(part.position) + artefact.radius);
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) add(Eigen::Vector3d::Unit(axis), 0, part.position[axis]);
    if (part.kind == ContactKind::sphere) add({0, 0, 0}, 1, part.radius + artefact.radius);
  }
  Eigen::MatrixXd equations(rows.size(), 4);
  for (size_t k = 0; k < rows.size(); ++k) equations.row(k) = rows[k];
  const Eigen::Map<const Eigen::VectorXd> wanted(right.data(), std::ssize(right));
  const Eigen::VectorXd solution =
      equations.completeOrthogonalDecomposition().solve(Eigen::VectorXd(wanted));
  return (equations * solution - wanted).norm() < kExactTo;
}

// Touches in the same configurations are as well those of an arm that is larger, with the contacts,
// by one factor. An encoder of lengths knows the factor, as do a beam and a profile, whose readings
// are lengths, and an artefact of which enough is touched.
bool scale_is_free(const KinematicChain& chain, const Campaign& campaign) {
  if (!campaign.has_touches_only() || campaign.has_pixels() || campaign.has_profiles())
    return false;
  for (int j = 0; j < joint_count(chain); ++j)
    if (is_prismatic(joint_link(chain, j))) return false;
  const std::vector<ContactPoint> matched = match_contacts(campaign, chain);
  std::map<int, std::set<int>> parts;  // of each artefact
  for (const Touch& touch : campaign.touch) {
    const ContactPoint& which = matched[touch.contact];
    if (which.beam >= 0) return false;
    if (which.point >= 0) parts[which.contact].insert(which.point);
  }
  return std::ranges::all_of(
      parts, [&](const auto& of) { return imitates_scale(chain.contacts[of.first], of.second); });
}

// Whether the columns of the lengths of links, each times its length, add up to nothing. A column
// that is absorbed stands for those that imitate it: with l the lengths and s the shares,
//     l_kept + sum over the absorbed of s l_absorbed = 0   for each length that is kept.
bool lengths_cancel(const KinematicChain& chain, const IdentifiableSet& set) {
  constexpr double kCancelledShare = 1e-3;  // of the longest length
  std::map<int, double> sums;
  double longest = 0;
  const auto length = [&](int parameter) {
    const double value = length_of(chain, parameter);
    longest = std::max(longest, std::abs(value));
    return value;
  };
  for (int k : set.kept) sums[k] = length(k);
  for (const AbsorbedParameter& absorbed : set.absorbed) {
    const double own = length(absorbed.parameter);
    for (const auto& [kept, share] : absorbed.absorbed_by) sums[kept] += share * own;
  }
  return std::ranges::all_of(sums, [&](const auto& entry) {
    return length_of(chain, entry.first) == 0 || std::abs(entry.second) < kCancelledShare * longest;
  });
}

// Number of lengths of links that imitate an absorbed parameter.
auto lengths_in(const KinematicChain& chain, const AbsorbedParameter& absorbed) {
  return std::ranges::count_if(
      absorbed.absorbed_by, [&](const auto& entry) { return length_of(chain, entry.first) != 0; });
}

}  // namespace

std::optional<int> length_of_scale(const Robot& robot, const Campaign& campaign,
                                   const IdentifiableSet& set) {
  const KinematicChain& chain = robot.chain;
  if (!scale_is_free(chain, campaign) || !lengths_cancel(chain, set)) return std::nullopt;
  // Another length that is absorbed, such as one between parallel axes, takes few others with it.
  const AbsorbedParameter* scale = nullptr;
  for (const AbsorbedParameter& absorbed : set.absorbed) {
    if (length_of(chain, absorbed.parameter) == 0 || lengths_in(chain, absorbed) == 0) continue;
    if (!scale || lengths_in(chain, absorbed) > lengths_in(chain, *scale)) scale = &absorbed;
  }
  return scale ? std::optional(scale->parameter) : std::nullopt;
}

std::vector<int> allowed_parameters(const Robot& robot, const Campaign& campaign) {
  return listed_parameters(robot, campaign).allowed;
}

namespace {

// What was taken away stays as it is, and so does what would only imitate it.
void hold(const Listed& listed, IdentifiableSet& set) {
  const auto is_held = [&](int k) { return std::ranges::count(listed.allowed, k) == 0; };
  std::erase_if(set.kept, is_held);
  std::erase_if(set.absorbed,
                [&](const AbsorbedParameter& absorbed) { return is_held(absorbed.parameter); });
}

}  // namespace

IdentifiableSet choose_identifiable(const Robot& robot, const Campaign& campaign) {
  const Listed listed = listed_parameters(robot, campaign);
  std::vector<int> order;
  for (int k : preference_order(robot))
    if (std::ranges::count(listed.named, k) > 0) order.push_back(k);

  Campaign rows = campaign.select(thinned_rows(campaign, std::min(campaign.rows(), kMaxRows)));
  Robot ideal = ideal_structure(robot);
  if (campaign.has_touches()) {
    ideal = with_contacts_fitted(std::move(ideal), rows, FitContacts::all);
    rows = moved_onto_contacts(ideal, rows);
    if (rows.rows() == 0)
      throw std::invalid_argument(
          campaign.source +
          ": the robot of the file reaches none of the contacts near these joint angles; check the "
          "column 'contact', units and signs");
  }
  IdentifiableSet set = choose_in_order(ideal, rows, order);
  if (const auto scale = length_of_scale(ideal, rows, set)) {
    // Where a positioner stands is known roughly only.
    const auto length = [&](int k) {
      return places_positioner(ideal, k) ? 0.0 : std::abs(length_of(ideal.chain, k));
    };
    const int longest = *std::ranges::max_element(set.kept, {}, length);
    if (length(longest) > length(*scale)) {
      std::erase(order, longest);
      order.push_back(longest);
      set = choose_in_order(ideal, rows, order);
    }
  }
  hold(listed, set);
  return set;
}

IdentifiableSet require_identifiable(const Robot& robot, const Campaign& campaign) {
  IdentifiableSet set = choose_identifiable(robot, campaign);
  if (set.kept.empty())
    throw std::invalid_argument(
        campaign.source + ": these readings show none of the parameters to be identified" +
        (set.absorbed.empty()
             ? ""
             : ", such as " + parameter_name(robot.chain, set.absorbed.front().parameter)) +
        "; identify others, or measure more (points alone do not show how the tool is turned)");
  return set;
}

namespace {

// So many rows, of which each quantity has as many.
std::vector<int> every_touch(const Campaign& campaign, int count) {
  std::vector<int> rows;
  if (campaign.has_profiles()) {  // their points differ
    for (long k = 0; k < count; ++k) rows.push_back(static_cast<int>(k * campaign.rows() / count));
    return rows;
  }
  std::map<int, int> first_rows;
  for (int row = 0; row < campaign.rows(); ++row)
    first_rows.try_emplace(campaign.quantity(row), row);
  while (std::ssize(rows) < count)
    for (const auto& [quantity, row] : first_rows) rows.push_back(row);
  rows.resize(count);
  return rows;
}

}  // namespace

std::vector<int> set_up_not_shown(const KinematicChain& chain, const IdentifiableSet& set) {
  const ParameterLayout layout = layout_of(chain);
  std::vector<int> parameters;
  for (const AbsorbedParameter& absorbed : set.absorbed)
    if (layout.is_of_tool(absorbed.parameter) && !absorbed.absorbed_by.empty())
      parameters.push_back(absorbed.parameter);
  std::ranges::sort(parameters);
  return parameters;
}

std::string not_shown(const KinematicChain& chain, int parameter) {
  const int axis = parameter - layout_of(chain).tool;
  const std::string value =
      axis < 3 ? fmt::format(" at {:.6g} mm", chain.tool.translation[axis] / kMillimetre) : "";
  return fmt::format(
      "{} is not shown by these readings and stays{}, as the robot file has it: enter it",
      parameter_name(chain, parameter), value);
}

IdentifiableSet with_tool_of_small_angles(const Robot& fitted, const Campaign& campaign,
                                          const IdentifiableSet& set) {
  constexpr int kAxes = 3;  // how the tool is turned is seen in orientations, or not at all
  const int tool = layout_of(fitted.chain).tool;
  std::vector<int> hidden = set_up_not_shown(fitted.chain, set);
  std::erase_if(hidden, [&](int k) { return k >= tool + kAxes; });
  if (hidden.empty() || campaign.has_touches()) return set;
  const Campaign rows =
      campaign.select(thinned_rows(campaign, std::min(campaign.rows(), kMaxRows)));
  // As in the order of preference, the tool stands before the links: a length of the last link that
  // moves the readings as its z does gives way to it.
  std::vector<int> order;
  const auto add_kept = [&](bool of_links) {
    for (const int k : set.kept)
      if (layout_of(fitted.chain).is_of_links(k) == of_links) order.push_back(k);
  };
  add_kept(false);
  order.insert(order.end(), hidden.begin(), hidden.end());
  add_kept(true);
  Robot arm = fitted;
  arm.effects.clear();
  IdentifiableSet with = choose_in_order(arm, rows, order);
  std::ranges::copy_if(hidden, std::back_inserter(with.by_small_angles), [&](int k) {
    return std::ranges::find(with.kept, k) != with.kept.end();
  });
  if (with.by_small_angles.empty()) return set;
  for (const AbsorbedParameter& absorbed : set.absorbed)
    if (std::ranges::find(order, absorbed.parameter) == order.end())
      with.absorbed.push_back(absorbed);
  std::ranges::sort(with.kept);
  return with;
}

std::string shown_by_small_angles(const KinematicChain& chain, int parameter, double value,
                                  double deviation) {
  return fmt::format(
      "{} is {:.6g} mm in the robot file and {:.0f} +- {:.0f} mm by these readings, which show it "
      "by the small angles of the arm alone: enter it",
      parameter_name(chain, parameter),
      chain.tool.translation[parameter - layout_of(chain).tool] / kMillimetre,
      value / kMillimetre, deviation / kMillimetre);
}

std::vector<int> lost_to_poses(const Robot& robot, const Campaign& campaign,
                               const IdentifiableSet& set) {
  constexpr int kPoses = 200;
  if (campaign.has_pixels()) return {};  // few poses of the joint space show the board
  Campaign everywhere = campaign.select(campaign.has_touches() ? every_touch(campaign, kPoses)
                                                               : std::vector<int>(kPoses, 0));
  everywhere.q = sample_joint_space(robot.chain, kPoses);
  const int targets = campaign.targets();
  for (int row = 0; row < kPoses && !campaign.target.empty(); ++row)
    everywhere.target[row] = row % targets;
  for (int row = 0; row < kPoses && !campaign.has_touches(); ++row)
    everywhere.set_quantity(row, row / targets % campaign.quantities());
  const IdentifiableSet possible = choose_identifiable(robot, everywhere);
  std::vector<int> lost;
  if (possible.kept.size() <= set.kept.size()) return lost;
  for (int k : possible.kept)
    if (std::find(set.kept.begin(), set.kept.end(), k) == set.kept.end()) lost.push_back(k);
  return lost;
}

}  // namespace armtrue
