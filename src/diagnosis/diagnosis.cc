#include "armtrue/diagnosis/diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/conventions.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/contacts.h"
#include "armtrue/observation/placement.h"
#include "armtrue/observation/registration.h"
#include "armtrue/statistics/summary.h"
#include "armtrue/text/number_text.h"
#include "diagnosis/board_check.h"
#include "diagnosis/coupling_check.h"
#include "diagnosis/depth_check.h"
#include "diagnosis/exchanged_targets.h"
#include "diagnosis/far_set_up_change.h"
#include "diagnosis/impossible_change.h"
#include "diagnosis/mixed_rows.h"

namespace armtrue {
namespace {

constexpr double kImplausibleTurn = 0.1;  // rad
constexpr double kMuchBetter = 0.1;
constexpr int kRowsLookedAt = 500;
// Fewer poses determine the base, but not the tool beside it. Where the tool is elsewhere than in
// the file, a wrong sign may fit them much better by chance; a wrong unit does not.
constexpr size_t kFewestPoses = 6;

// Base and contacts placed, cameras by the intrinsics that the robot file gives them.
Robot with_places(Robot robot, const Campaign& campaign) {
  robot.effects.clear();
  robot.chain.base = registered_base(robot, campaign);
  return with_contacts_fitted(std::move(robot), campaign, FitContacts::all);
}

// Median position error with base and tool fitted completely; with the base alone if there are too
// few readings for both, or if they are distances and the fit fails.
double median_miss(Robot robot, const Campaign& campaign) {
  robot.effects.clear();
  if (const auto placed = place_base_and_tool(robot, campaign, kImplausibleMiss))
    return median(placed->miss);
  robot = with_places(std::move(robot), campaign);
  const double miss = median(evaluate(robot, campaign).position);
  if (!campaign.reads_one_number() || miss <= kImplausibleMiss) return miss;
  robot.identify = {"base", "tool"};
  if (campaign.has_pixels()) robot.identify.push_back("camera *");
  robot.identify_per_session.clear();
  try {
    robot = calibrate(robot, campaign, {.statistics = FitStatistics::weights}).robot;
    return std::min(miss, median(evaluate(robot, campaign).position));
  } catch (const std::invalid_argument&) {
    return miss;  // too few readings to show both
  }
}

// Median angle between the tool rotations that the orientations of the poses imply. The points
// alone determine the rotation of the base, and the rotation of the tool is free.
double median_turn(Robot robot, const Campaign& campaign) {
  robot.effects.clear();
  if (const auto placed = place_base_and_tool(robot, campaign, kImplausibleMiss))
    return common_turn(placed->turns).second;
  robot.chain.base = registered_base(robot, campaign);
  const RobotModel model(robot);
  std::vector<Eigen::Matrix3d> turns;
  for (int row = 0; row < campaign.rows(); ++row)
    turns.push_back(model.pose(campaign.context(row)).rotation.transpose() *
                    campaign.orientation[row].toRotationMatrix());
  return common_turn(turns).second;
}

// The robot whose geometry is that of the points, where they show one. The turns of the tool then
// do not hold what base and tool cannot take up, such as a positioner that stands elsewhere.
Robot calibrated_to_points(const Robot& given, Campaign campaign) {
  Robot robot = given;
  robot.effects.clear();
  robot.identify = {"auto"};
  robot.identify_per_session.clear();
  campaign.orientation.clear();
  try {
    return calibrate(robot, campaign, {.statistics = FitStatistics::weights}).robot;
  } catch (const std::invalid_argument&) {
    return given;  // too few readings
  }
}

struct Hypothesis {
  std::string remedy;
  std::function<void(Robot&, Campaign&)> change;
  double lengths = 1;  ///< times the lengths of the readings
};

void scale_lengths(Campaign& campaign, double factor) {
  for (Eigen::Vector3d& p : campaign.position) p *= factor;
  for (double& l : campaign.distance) l *= factor;
  for (std::optional<Coordinate>& c : campaign.coordinate)
    if (c) c->value *= factor;
}

// Whether no length of the links is that of an arm, but would be one a thousand times as long.
bool looks_like_metres(const KinematicChain& chain) {
  constexpr double kLongestInMetres = 0.01,
                   kShortestInMetres = 1e-5;  // m: 10 m and 10 mm, divided by 1000
  double longest = 0;
  for (const Link& link : chain.links)
    longest = std::max({longest, std::abs(link.d), std::abs(link.r)});
  return longest > kShortestInMetres && longest < kLongestInMetres;
}

std::vector<Hypothesis> length_hypotheses(const KinematicChain& chain, bool of_distances) {
  std::vector<Hypothesis> hypotheses;
  const auto add = [&](double factor, std::string remedy) {
    hypotheses.push_back(
        {std::move(remedy), [factor](Robot&, Campaign& c) { scale_lengths(c, factor); }, factor});
  };
  add(1000, of_distances
                ? "the distances look like metres under a _mm name; name the column l_m"
                : "the positions look like metres under a _mm name; name the columns x_m,y_m,z_m");
  add(25.4, "the lengths look like inches under a _mm name; convert them");
  add(10, "the lengths look like centimetres under a _mm name; convert them");
  add(1 / 25.4, "the lengths are 25.4 times too large, as mm that were taken for inches");
  add(0.1, "the lengths are 10 times too large, as mm that were taken for centimetres");
  add(1e-3,
      looks_like_metres(chain) ? "the lengths of the robot file look like metres under _mm names; "
                                 "multiply its d_mm and r_mm by 1000"
      : of_distances ? "the distances look like millimetres under a _m name; name the column l_mm"
                     : "the positions look like millimetres under a _m name; name the columns "
                       "x_mm,y_mm,z_mm");
  return hypotheses;
}

std::vector<Hypothesis> unit_hypotheses(const KinematicChain& chain,
                                        const std::vector<JointName>& names,
                                        const Campaign& campaign) {
  const auto revolute =
      std::ranges::count_if(names, [](const JointName& name) { return !name.is_length; });
  std::vector<Hypothesis> hypotheses{
      {"the joint angles look like radians under a _deg name; name the columns "
       "q1_rad to q" +
           std::to_string(revolute) + "_rad",
       [](Robot& r, Campaign& c) { scale_angles(c, r.chain, 1 / kDegree); }}};
  if (!campaign.has_pixels())
    std::ranges::copy(length_hypotheses(chain, campaign.reads_one_number()),
                      std::back_inserter(hypotheses));
  for (int j = 0; j < std::ssize(names); ++j)
    if (names[j].is_length)
      hypotheses.push_back({fmt::format("{} looks like metres under a _mm name; name the column {}",
                                        names[j].encoder(), names[j].column + "_m"),
                            [j](Robot&, Campaign& c) {
                              for (auto q : c.q) q[j] *= 1000;
                            }});
  return hypotheses;
}

// Whether a joint turns about an axis parallel to that of the joint before it, so that a controller
// may count its angle from the ground and not from that joint: axis 3 of many arms, axis 2 of some
// SCARAs.
bool is_parallel_to_the_one_before(const KinematicChain& chain, int joint) {
  constexpr double kParallel = 0.1;  // rad
  const int link = link_of_joint(chain, joint);
  const Link &own = chain.links[link], &before = chain.links[link - 1];
  return own.joint == JointKind::revolute && before.joint == JointKind::revolute &&
         std::abs(std::sin(own.alpha)) < kParallel && std::abs(std::sin(own.beta)) < kParallel;
}

// Units, and signs and orders if `with_conventions`.
std::vector<Hypothesis> position_hypotheses(const KinematicChain& chain, const Campaign& campaign,
                                            bool with_conventions) {
  const std::vector<JointName> names = joint_names(chain);
  std::vector<Hypothesis> hypotheses = unit_hypotheses(chain, names, campaign);
  if (!with_conventions) return hypotheses;
  for (int j = 0; j < std::ssize(names); ++j)
    hypotheses.push_back(
        {"joint " + names[j].words +
             " seems to count the other way; change its 'sign' in the "
             "robot file",
         [j](Robot& r, Campaign&) { r.chain.links[link_of_joint(r.chain, j)].sign *= -1; }});
  if (std::ranges::none_of(chain.links, [](const Link& link) { return link.beta != 0; }))
    hypotheses.push_back(
        {"the links look like a table of standard Denavit-Hartenberg parameters; write "
         "'convention: standard' into the robot file",
         [](Robot& r, Campaign&) { r.chain = from_standard(r.chain); }});
  for (int j = 0; j < std::ssize(names); ++j)
    for (int k = j + 1; k < std::ssize(names); ++k)
      if (names[j].is_length == names[k].is_length)
        hypotheses.push_back({fmt::format("the columns {} and {} look exchanged",
                                          names[j].encoder(), names[k].encoder()),
                              [j, k](Robot&, Campaign& c) {
                                for (auto q : c.q) std::swap(q[j], q[k]);
                              }});
  for (int j = 1; j < std::ssize(names); ++j)
    for (double sign : {1.0, -1.0})
      if (is_parallel_to_the_one_before(chain, j))
        hypotheses.push_back(
            {fmt::format("{0} looks as if {1} were {2} it; write {0} {3} {1} instead",
                         names[j].encoder(), names[j - 1].encoder(),
                         sign > 0 ? "taken off" : "added to", sign > 0 ? "+" : "-"),
             [j, sign](Robot&, Campaign& c) {
               for (auto q : c.q) q[j] += sign * q[j - 1];
             }});
  if (!campaign.reads_one_number())
    hypotheses.push_back(
        {"the positions look left-handed: an axis has the wrong sign, or two "
         "columns are exchanged",
         [](Robot&, Campaign& c) {
           for (Eigen::Vector3d& p : c.position) p.x() = -p.x();
         }});
  return hypotheses;
}

Hypothesis hypothesis_of(const ChangedCouplings& changed) {
  return {
      "joints look as if rods, gears or a screw moved them with others, otherwise than the "
      "robot file says: " +
          changed.words + "; compare its 'follows' and 'coupled' with the arm",
      [couplings = changed.couplings](Robot& r, Campaign&) { r.chain.couplings = couplings; }};
}

std::vector<Hypothesis> of_couplings(const std::vector<ChangedCouplings>& all) {
  std::vector<Hypothesis> hypotheses;
  for (const ChangedCouplings& changed : all) hypotheses.push_back(hypothesis_of(changed));
  return hypotheses;
}

// The rows of u and v of each corner of which both were read.
std::vector<std::array<int, 2>> corners_of(const Campaign& campaign) {
  std::vector<std::array<int, 2>> corners;
  for (int row = 0; row + 1 < campaign.rows(); ++row)
    if (campaign.touch[row].is_pixel && campaign.touch[row].axis == 0 &&
        campaign.touch[row + 1].axis == 1 &&
        campaign.touch[row + 1].contact == campaign.touch[row].contact)
      corners.push_back({row, row + 1});
  return corners;
}

// v from the lower edge in place of the upper one, as in a mirror.
void turn_v_over(const Robot& robot, Campaign& campaign) {
  const std::vector<ContactPoint> matched = match_contacts(campaign, robot.chain);
  for (int row = 0; row < campaign.rows(); ++row) {
    const Touch& touch = campaign.touch[row];
    if (!touch.is_pixel || touch.axis != 1) continue;
    const Contact& camera = robot.chain.contacts[matched[touch.contact].contact];
    campaign.distance[row] =
        2 * camera.intrinsics[kCy] * campaign.metre_per_pixel - campaign.distance[row];
  }
}

// What may be wrong in images. Images that are turned by half a turn are those of a camera that is.
std::vector<Hypothesis> image_hypotheses() {
  return {{"v_px seems to count upwards, or the images to be mirrored; v counts downwards from the "
           "upper edge, u from the left one",
           [](Robot& r, Campaign& c) { turn_v_over(r, c); }},
          {"the columns u_px and v_px look exchanged",
           [](Robot&, Campaign& c) {
             for (const auto& [u, v] : corners_of(c)) std::swap(c.distance[u], c.distance[v]);
           }},
          {"the camera looks fixed where the robot file has the board, and the board where it has "
           "the camera: exchange 'on' of both (arm: it moves with the tool; cell: it is at rest)",
           [](Robot& r, Campaign&) {
             for (Contact& contact : r.chain.contacts)
               if (contact.kind == ContactKind::camera || contact.kind == ContactKind::board) {
                 contact.on_arm = !contact.on_arm;
                 contact.is_placed = false;
               }
           }}};
}

// Of some rows the joint values that stand so many lines, or of images poses, before them among all
// rows of their session.
JointRows joints_before(const Campaign& all, const std::vector<int>& rows,
                        const std::vector<int>& chosen, int late) {
  const auto key = [&](int row) { return all.has_pixels_only() ? all.pose[row] : all.line[row]; };
  std::vector<int> first_rows;
  std::map<int, int> places;
  for (const int row : rows)
    if (places.try_emplace(key(row), static_cast<int>(first_rows.size())).second)
      first_rows.push_back(row);
  const auto count = static_cast<int>(first_rows.size());
  JointRows joints;
  for (const int row : chosen)
    joints.push_back(all.q[first_rows[(places.at(key(row)) + count - late) % count]]);
  return joints;
}

// Readings that stand a row or two away from their joint angles, as where one of two tables that
// were put side by side has lost a row.
std::vector<JointsOfOtherRows> joints_of_other_rows(const Campaign& all,
                                                    const std::vector<int>& rows,
                                                    const std::vector<int>& chosen) {
  const std::string_view what = all.has_pixels_only() ? "pose" : "row";
  std::vector<JointsOfOtherRows> others;
  for (const int late : {1, -1, 2, -2})
    others.push_back({fmt::format("readings stand {} {} than their joint angles",
                                  counted(std::abs(late), what), late > 0 ? "later" : "earlier"),
                      joints_before(all, rows, chosen, late)});
  return others;
}

// A hypothesis that changes the angles a, b, c.
Hypothesis of_angles(std::string remedy,
                     std::function<Eigen::Vector3d(const Eigen::Vector3d&)> by) {
  return {std::move(remedy), [by = std::move(by)](Robot&, Campaign& c) {
            for (Eigen::Quaterniond& q : c.orientation) {
              const Eigen::Vector3d abc = by(abc_from_rotation(q.toRotationMatrix()));
              q = Eigen::Quaterniond(rotation_from_abc(abc[0], abc[1], abc[2]));
            }
          }};
}

std::vector<Hypothesis> orientation_hypotheses() {
  const std::string contract = "; the contract is R = Rz(a) Ry(b) Rx(c)";
  using Angles = Eigen::Vector3d;
  return {
      of_angles("a_deg and c_deg look exchanged" + contract,
                [](const Angles& abc) { return Angles(abc[2], abc[1], abc[0]); }),
      of_angles("a_deg seems to have the wrong sign" + contract,
                [](const Angles& abc) { return Angles(-abc[0], abc[1], abc[2]); }),
      of_angles("b_deg seems to have the wrong sign" + contract,
                [](const Angles& abc) { return Angles(abc[0], -abc[1], abc[2]); }),
      of_angles("c_deg seems to have the wrong sign" + contract,
                [](const Angles& abc) { return Angles(abc[0], abc[1], -abc[2]); }),
      {"the quaternions look as if qw came first; name the columns in the order of their values",
       [](Robot&, Campaign& c) {
         for (Eigen::Quaterniond& q : c.orientation) q = {q.x(), q.y(), q.z(), q.w()};
       }},
      {"the quaternions look like x, y, z, w under the names qw,qx,qy,qz; name the columns in the "
       "order of their values",
       [](Robot&, Campaign& c) {
         for (Eigen::Quaterniond& q : c.orientation) q = {q.z(), q.w(), q.x(), q.y()};
       }},
      {"the orientations look turned the other way (tool from instrument); give the rotation that "
       "takes tool axes to R_A",
       [](Robot&, Campaign& c) {
         for (Eigen::Quaterniond& q : c.orientation) q = q.conjugate();
       }},
      of_angles("the angles a, b, c look like radians under a _deg name; name the columns "
                "a_rad,b_rad,c_rad",
                [](const Angles& abc) -> Angles { return abc / kDegree; })};
}

void invert_poses(Campaign& campaign) {
  for (int row = 0; row < campaign.rows(); ++row) {
    Eigen::Quaterniond& turn = campaign.orientation[row];
    turn = turn.conjugate();
    campaign.position[row] = -(turn * campaign.position[row]);
  }
}

// A pose the other way round, as a camera gives that of its board: the points then depend on the
// orientations, whose numbers may be in another convention as well.
std::vector<Hypothesis> inverse_pose_hypotheses() {
  const std::string inverted =
      "the poses look inverted (instrument from tool, such as camera from board); give the inverse: "
      "x, y, z and orientation of the tool in R_A";
  std::vector<Hypothesis> hypotheses{
      {inverted, [](Robot&, Campaign& c) { invert_poses(c); }}};
  for (const Hypothesis& other : orientation_hypotheses())
    hypotheses.push_back({other.remedy + "; with that, " + inverted,
                          [change = other.change](Robot& r, Campaign& c) {
                            change(r, c);
                            invert_poses(c);
                          }});
  return hypotheses;
}

// The board whose corners lie in other rows than those of the robot file.
std::optional<std::string> find_other_board(const Robot& robot, const Campaign& campaign) {
  for (int k = 0; k < contact_count(robot.chain); ++k) {
    const Contact& board = robot.chain.contacts[k];
    if (board.kind != ContactKind::board) continue;
    if (const auto columns = find_columns_of_board(robot, campaign, k))
      return fmt::format(
          "the corners of board '{}' lie in rows of {}, not as the robot file has them: compare "
          "its 'columns' or 'pattern' with the board (a charuco board has one corner less in a "
          "row than squares)",
          board.name, *columns);
  }
  return std::nullopt;
}

void try_hypotheses(const Robot& robot, const Campaign& campaign,
                    const std::vector<Hypothesis>& hypotheses, double as_it_stands,
                    double (*measure)(Robot, const Campaign&), std::vector<std::string>& findings,
                    double much_better = kMuchBetter) {
  constexpr double kSame = 1.01;
  double best = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, std::string>> better;
  for (const Hypothesis& hypothesis : hypotheses) {
    Robot changed_robot = robot;
    Campaign changed = campaign;
    hypothesis.change(changed_robot, changed);
    // What is left of readings that were made shorter is shorter, whatever they are.
    const double miss = measure(changed_robot, changed) / std::min(1.0, hypothesis.lengths);
    if (miss >= much_better * as_it_stands || miss > kSame * best) continue;
    best = std::min(best, miss);
    better.emplace_back(miss, hypothesis.remedy);
  }
  // Those that fit as well: a SCARA whose third joint counts the other way is a mirrored one.
  std::string remedies;
  for (const auto& [miss, remedy] : better)
    if (miss <= kSame * best) remedies += (remedies.empty() ? "" : "; or ") + remedy;
  if (!remedies.empty()) findings.push_back(remedies);
}

// Hypotheses on images, those first with which cameras and boards, as placed by the file's
// intrinsics, miss least. A calibration of each is slow, and with the intrinsics free a mirrored
// image fits as one whose columns are exchanged.
std::vector<Hypothesis> by_placement(const Robot& robot, const Campaign& campaign,
                                     const std::vector<Hypothesis>& hypotheses) {
  std::vector<std::pair<double, size_t>> order;
  for (size_t k = 0; k < hypotheses.size(); ++k) {
    Robot changed_robot = robot;
    Campaign changed = campaign;
    hypotheses[k].change(changed_robot, changed);
    const Robot placed = with_places(std::move(changed_robot), changed);
    order.emplace_back(median(evaluate(placed, changed).position), k);
  }
  std::ranges::stable_sort(order, {}, &std::pair<double, size_t>::first);
  std::vector<Hypothesis> sorted;
  for (const auto& [miss, k] : order) sorted.push_back(hypotheses[k]);
  return sorted;
}

// The first of the mistakes in images that explains them.
void try_image_hypotheses(const Robot& robot, const Campaign& campaign, double as_it_stands,
                          std::vector<std::string>& findings) {
  constexpr double kBetter = 0.3;  // of hundreds of corners, which few hypotheses fit by chance
  for (const Hypothesis& hypothesis : by_placement(robot, campaign, image_hypotheses()))
    if (findings.empty())
      try_hypotheses(robot, campaign, {hypothesis}, as_it_stands, median_miss, findings, kBetter);
}

using Measure = double (*)(Robot, const Campaign&);

// The pair of joints, one more or one of the robot file, with the coefficient that fits best. It is
// far from linear: coefficients at equal steps, then a golden section of the best.
Coupling best_coupling(const Robot& robot, const Campaign& campaign, Measure measure) {
  constexpr int kSteps = 20, kSections = 20;               // of each sign
  constexpr double kGolden = 0.618, kMostOfLength = 0.02;  // m per rad: a screw of 126 mm
  const auto miss_of = [&](Coupling coupling, double coefficient) {
    coupling.coefficient = coefficient;
    Robot changed = robot;
    changed.chain.couplings = with_coupling(robot.chain, coupling).couplings;
    return measure(std::move(changed), campaign);
  };
  Coupling best;
  double least = std::numeric_limits<double>::infinity(), step = 0;
  for (const Coupling& pair : near_couplings(robot.chain)) {
    const double most = is_prismatic(robot.chain.links[pair.follower]) ? kMostOfLength : 1;
    for (int k = -kSteps; k <= kSteps; ++k) {
      const double miss = miss_of(pair, most * k / kSteps);
      if (miss >= least) continue;
      least = miss;
      best = pair;
      best.coefficient = most * k / kSteps;
      step = most / kSteps;
    }
  }
  double low = best.coefficient - step, high = best.coefficient + step;
  for (int section = 0; section < kSections; ++section) {
    const double left = high - kGolden * (high - low), right = low + kGolden * (high - low);
    if (miss_of(best, left) < miss_of(best, right))
      high = right;
    else
      low = left;
  }
  best.coefficient = 0.5 * (low + high);
  return best;
}

// Couplings of the robot file with another sign, then one more or with another coefficient.
void try_couplings(const Robot& robot, const Campaign& campaign, Measure measure,
                   std::vector<std::string>& findings) {
  constexpr long kRows = 60;  // hundreds of coefficients are tried
  if (!findings.empty() || campaign.has_touches() || joint_count(robot.chain) < 2) return;
  const double as_it_stands = measure(robot, campaign);
  try_hypotheses(robot, campaign, of_couplings(other_signs_of_couplings(robot.chain)), as_it_stands,
                 measure, findings);
  if (!findings.empty() || std::ssize(robot.chain.couplings) >= kMaxCouplings) return;
  std::vector<int> rows(campaign.rows());
  std::iota(rows.begin(), rows.end(), 0);
  const Coupling best = best_coupling(robot, campaign.select(evenly_chosen(rows, kRows)), measure);
  try_hypotheses(robot, campaign, {hypothesis_of(with_coupling(robot.chain, best))}, as_it_stands,
                 measure, findings);
}

// Names what remains after a calibration, if it is larger than any error of an arm.
void try_calibration(const Robot& robot, const Campaign& campaign,
                     std::vector<std::string>& findings) {
  CalibrationResult result;
  try {
    result = calibrate(robot, campaign);
  } catch (const std::invalid_argument&) {
    return;  // too few readings to tell
  }
  const double miss = median(evaluate(result.robot, campaign).position);
  if (miss > kImplausibleMiss) {
    findings.push_back(
        fmt::format("these are no readings of this robot: calibrated to them it "
                    "still misses by {:.4g} mm (median){}",
                    miss / kMillimetre, kCheckColumnsAndJoints));
    return;
  }
  if (const auto change = find_impossible_change(robot, result)) findings.push_back(*change);
}

}  // namespace

namespace {

struct SessionFindings {
  std::vector<std::string> findings;
  bool fits = true;  // the robot file, with base and tool placed
};

// What is wrong with the readings of one session.
SessionFindings diagnose_session(const Robot& given, const Campaign& all,
                                 const std::vector<int>& rows) {
  // A copy of a million rows takes as much memory as the rest of a calibration.
  std::optional<Campaign> some;
  const Campaign& session = std::ssize(rows) == all.rows() ? all : some.emplace(all.select(rows));
  const std::vector<int> chosen = readings_evenly_chosen(all, rows, kRowsLookedAt);
  const Campaign campaign = all.select(chosen);
  const Robot robot = robot_at_row(given, campaign, 0);
  std::vector<std::string> findings;
  const size_t poses = std::set<int>(campaign.pose.begin(), campaign.pose.end()).size();
  if (poses < 4) return {};  // a base fits any three points
  const bool few = poses < kFewestPoses;
  if (!few)
    if (const auto exchanged = find_exchanged_targets(robot, session)) return {{*exchanged}, true};
  const double miss = median_miss(robot, campaign);
  const bool fits = miss <= kImplausibleMiss;
  const bool has_turns = !few && campaign.has_orientation();
  const bool turns_fit = !has_turns || median_turn(robot, campaign) <= kImplausibleTurn;
  // First of all: readings in two frames fit no arm, whatever is changed in all of them.
  if (!fits || !turns_fit)
    if (const auto moved = find_far_set_up_change(robot, session)) return {{*moved}, fits};
  if (campaign.has_pixels_only()) {
    constexpr double kOdd = kImplausibleMiss / 4;  // wrong images exceed it, few nominal arms do
    if (const auto other = find_other_board(robot, campaign)) return {{*other}, fits};
    if (miss > kOdd) try_image_hypotheses(robot, campaign, miss, findings);
  }
  const std::vector<JointsOfOtherRows> others = joints_of_other_rows(all, rows, chosen);
  if (!fits && findings.empty()) {
    std::vector<Hypothesis> hypotheses = position_hypotheses(robot.chain, campaign, !few);
    if (has_turns) std::ranges::copy(inverse_pose_hypotheses(), std::back_inserter(hypotheses));
    if (!few)
      for (const JointsOfOtherRows& other : others)
        hypotheses.push_back(
            {"the " + other.words + ": move them, or put the tables together again",
             [&other](Robot&, Campaign& c) { c.q = other.q; }});
    constexpr size_t kCalibrated = 6;  // as many starts as place_base_and_tool() follows to the end
    if (campaign.has_pixels_only() && hypotheses.size() > kCalibrated) {
      hypotheses = by_placement(robot, campaign, hypotheses);
      hypotheses.resize(kCalibrated);
    }
    try_hypotheses(robot, campaign, hypotheses, miss, median_miss, findings);
    constexpr int kRowsForDepth = 100;  // it is tried at many scales
    if (findings.empty() && !few && !campaign.has_pixels())
      if (const auto depth =
              find_gross_depth_scale(all.select(evenly_chosen(rows, kRowsForDepth)),
                                     [&](const Campaign& c) { return median_miss(robot, c); }))
        findings.push_back(*depth);
  }
  if (few) return {findings, fits};
  if (findings.empty())
    if (const auto mixed =
            find_mixed_rows(robot, campaign, others, kImplausibleMiss, kImplausibleTurn))
      findings.push_back(*mixed);
  if (!fits) try_couplings(robot, campaign, median_miss, findings);
  if (findings.empty() && !fits) try_calibration(robot, campaign, findings);
  if (findings.empty() && !turns_fit) {
    const Robot calibrated = calibrated_to_points(robot, campaign);
    const double turn = median_turn(calibrated, campaign);
    if (turn > kImplausibleTurn)
      try_hypotheses(calibrated, campaign, orientation_hypotheses(), turn, median_turn, findings);
    if (turn > kImplausibleTurn) try_couplings(robot, campaign, median_turn, findings);
    if (findings.empty() && turn > kImplausibleTurn)
      findings.push_back(fmt::format(
          "the orientations turn otherwise than this robot's tool, by {:.3g} deg from pose to pose "
          "(median); the contract is R = Rz(a) Ry(b) Rx(c) or qx,qy,qz,qw, from tool to R_A",
          turn / kDegree));
  }
  return {findings, fits};
}

}  // namespace

std::vector<std::string> diagnose(const Robot& given, const Campaign& all) {
  // One base must fit the rows that are tested, so each session is tested alone, the largest first.
  std::vector<std::vector<int>> sessions = rows_by_session(all);
  std::ranges::stable_sort(sessions, [](const std::vector<int>& a, const std::vector<int>& b) {
    return a.size() > b.size();
  });
  for (const std::vector<int>& rows : sessions) {
    SessionFindings found = diagnose_session(given, all, rows);
    // If the robot file itself does not fit, smaller sessions show it less clearly.
    if (found.findings.empty() && found.fits) continue;
    const bool is_of_one = &rows != &sessions.front();
    if (!found.findings.empty() && is_of_one)
      found.findings.front() =
          fmt::format("session '{}': {}", session_name(all, rows.front()), found.findings.front());
    return found.findings;
  }
  return {};
}

double largest_credible_error(const KinematicChain& chain, double noise) {
  constexpr double kTimesNoise = 20, kPerMetre = 1e-3;
  double length = 0;
  for (const Link& link : chain.links) length += std::hypot(link.d, link.r);
  return kTimesNoise * noise + kPerMetre * length;
}

}  // namespace armtrue
