#include "armtrue/certification/certificate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include "armtrue/calibration/prediction.h"
#include "armtrue/certification/doubts.h"
#include "armtrue/certification/stray_visits.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/distributions.h"

namespace armtrue {
namespace {

constexpr double kCoverage = 2;  // k of a difference

// Whether a name of figures is that of the pose. Reflector and session stand behind the pose.
bool is_of(const std::string& name, const std::string& pose) {
  return name == pose || name.starts_with(pose + ", ");
}

// The figures of the named poses; empty if one of them is not there and `is_asked` is not set.
std::vector<PoseFigures> named(const CampaignFigures& found, const std::vector<std::string>& names,
                               bool is_asked) {
  std::vector<PoseFigures> list;
  for (const std::string& name : names) {
    const size_t before = list.size();
    std::ranges::copy_if(found.poses, std::back_inserter(list),
                         [&](const PoseFigures& figures) { return is_of(figures.pose, name); });
    if (list.size() > before) continue;
    if (!is_asked) return {};
    throw std::invalid_argument(
        std::ranges::any_of(found.single,
                            [&](const std::string& single) { return is_of(single, name); })
            ? fmt::format("pose '{}' of the cube has one visit; return to it at least once", name)
            : fmt::format("pose '{}' of the cube is not among the measured poses; correct --cube",
                          name));
  }
  return list;
}

double largest_range(const Robot& robot, const Campaign& campaign) {
  double largest = 0;
  for (const Eigen::Vector3d& point : campaign.position)
    largest = std::max(largest, (point - instrument_place(robot)).norm());
  return largest;
}

std::string first_of(const std::vector<std::string>& names) {
  constexpr size_t kShown = 5;
  std::string text;
  for (size_t k = 0; k < std::min(kShown, names.size()); ++k)
    text += (k == 0 ? "" : "; ") + names[k];
  return names.size() > kShown ? text + "; ..." : text;
}

void add_notes_on_visits(const CampaignFigures& found, Certificate& certificate) {
  std::vector<std::string>& notes = certificate.notes;
  if (certificate.all.fewest_visits < kStandardCycles)
    notes.push_back(
        fmt::format("ISO 9283 asks for {} cycles; the pose with the fewest visits has {}.",
                    kStandardCycles, certificate.all.fewest_visits));
  if (!certificate.all.rp_ci95)
    notes.emplace_back(
        "The pose with the largest RP has two visits, which do not show how uncertain RP is.");
  if (!found.single.empty())
    notes.push_back(fmt::format("Poses with one visit are not judged: {} ({}).",
                                found.single.size(), first_of(found.single)));
  if (!found.not_left.empty())
    notes.push_back(fmt::format(
        "Poses of which visits follow each other without another pose between: {} ({}). Their RP "
        "holds only if the robot left the pose.",
        found.not_left.size(), first_of(found.not_left)));
  const auto mixed = std::ranges::count_if(
      found.poses, [](const PoseFigures& figures) { return figures.directions > 1; });
  if (mixed > 0)
    notes.push_back(fmt::format(
        "Poses whose visits came from several directions: {}. Their RP contains the variation "
        "between directions, which the RP of the standard does not.",
        mixed));
}

void add_path(const PathFigures& path, double range, Certificate& certificate) {
  certificate.path = path;
  certificate.path_budget = budget_of(certificate.about.stated, path.scatter, path.passes, range,
                                      std::nullopt, path.at_of_scatter, path.at_of_frame);
  std::vector<std::string>& notes = certificate.notes;
  if (path.passes < kStandardPathCycles)
    notes.push_back(fmt::format("ISO 9283 asks for {} cycles of a path; there {}.",
                                kStandardPathCycles,
                                path.passes == 1 ? "is one, which shows no repeatability, and the "
                                                   "uncertainty of AT has none"
                                                 : fmt::format("are {}", path.passes)));
  if (!path.is_whole())
    notes.push_back(fmt::format(
        "All passes meet {} of the {} planes of the path; AT and RT do not hold for the rest.",
        path.planes, path.of_path));
  if (path.rt && !path.rt_ci95) notes.emplace_back("Two passes do not show how uncertain RT is.");
  if (path.frame_is_fitted)
    notes.emplace_back(
        "The frame of the instrument was fitted to the passes of the path, one for all, by least "
        "squares of the deviation across it. AT is that in this frame: it holds nothing of a "
        "displaced or turned path, and the budget has a row of what looks like that. RT contains "
        "all that differs from pass to pass.");
  if (path.at < certificate.path_budget->expanded)
    notes.push_back(
        "AT is smaller than its uncertainty: errors of the measurement make it larger.");
}

void add_notes(const CertificateOptions& options, const Robot& robot, Certificate& certificate) {
  std::vector<std::string>& notes = certificate.notes;
  if (!options.refitted.empty())
    notes.push_back(fmt::format("Fitted to these readings first: {}; AP contains no error of them.",
                                options.refitted));
  if (options.robot_knows_readings)
    notes.push_back(
        "The robot file was made from this file of readings: not all poses are held out, and AP is "
        "too small.");
  else if (options.seen.seen > 0)
    notes.push_back(fmt::format(
        "{} of {} poses took part in the calibration of the robot file: AP is too small.",
        options.seen.seen, options.seen.compared));
  if (options.points_look_computed)
    notes.push_back(
        "The robot file predicts these points more closely than an instrument reads. If the "
        "controller computed them, AP and RP say nothing of the arm.");
  if (!robot.uncertainty)
    notes.push_back("The robot file states no uncertainty: the budget has no row of the model.");
  if (certificate.all.ap.value < certificate.budget.expanded)
    notes.push_back(
        "AP is smaller than its uncertainty: errors of the measurement make it larger.");
}

// Per axis: a third of the mean square of the length.
std::optional<double> model_uncertainty(const Robot& robot, const Campaign& campaign) {
  if (!robot.uncertainty) return std::nullopt;
  return std::sqrt(mean_square_by_uncertainty(robot, campaign).expected / 3);
}

void add_figures(const SetFigures& set, double expanded, const std::string& prefix,
                 std::vector<CertifiedValue>& values) {
  values.push_back({prefix + "ap", set.ap.value, expanded});
  values.push_back({prefix + "rp", set.rp.value, set.rp_expanded()});
}

// The joint that differs most, if the values are those of two poses. Joints return within some
// hundredths, and commands that compensate writes differ by some tenths.
std::optional<OtherPose> other_pose(const CertifiedValue& before, const CertifiedValue& now) {
  constexpr double kSamePose = 1;  // deg, or mm of a rail
  OtherPose other{now.name, "", kSamePose};
  for (const auto& [column, value] : now.joints) {
    const auto old = before.joints.find(column);
    if (old == before.joints.end()) continue;
    const double apart = std::abs(value - old->second);
    if (apart > other.apart) other = {now.name, column, apart};
  }
  if (other.joint.empty()) return std::nullopt;
  return other;
}

std::vector<OtherPose> other_poses(const std::vector<CertifiedValue>& before,
                                   const std::vector<CertifiedValue>& now) {
  std::vector<OtherPose> others;
  for (const CertifiedValue& value : now)
    if (const auto old = std::ranges::find(before, value.name, &CertifiedValue::name);
        old != before.end())
      if (const auto other = other_pose(*old, value)) others.push_back(*other);
  return others;
}

// Values of equal names, not judged yet.
std::vector<CertifiedChange> differences(const std::vector<CertifiedValue>& before,
                                         const std::vector<CertifiedValue>& now) {
  std::vector<CertifiedChange> list;
  for (const CertifiedValue& value : now) {
    const auto old = std::ranges::find(before, value.name, &CertifiedValue::name);
    if (old == before.end()) continue;
    CertifiedChange difference{value.name, old->value, value.value, value.value - old->value, {}};
    if (old->expanded && value.expanded)
      difference.expanded = std::hypot(*old->expanded, *value.expanded);
    list.push_back(difference);
  }
  return list;
}

void judge(std::vector<CertifiedChange>& differences, double factor) {
  for (CertifiedChange& difference : differences) {
    if (!difference.expanded) continue;
    *difference.expanded *= factor;
    difference.significant = std::abs(difference.difference) > *difference.expanded;
  }
}

}  // namespace

namespace {

// Whether something is known against the figures: they may be too small.
bool is_doubtful(const Certificate& certificate, const CertificateOptions& options) {
  return !certificate.doubts.empty() || !doubts_of(certificate.about).empty() ||
         options.points_look_computed || options.robot_knows_readings;
}

// What a fit hides and what is doubtful keep an arm from passing and never from failing.
Decision decision_on(const Certificate& certificate, const CertificateOptions& options,
                     double with_hidden) {
  const double expanded = certificate.budget.expanded, tolerance = *options.tolerance;
  const Decision shown = decide(certificate.all.ap.value, expanded, tolerance);
  const bool is_shown = decide(with_hidden, expanded, tolerance) == Decision::pass &&
                        !is_doubtful(certificate, options);
  return shown == Decision::pass && !is_shown ? Decision::undecided : shown;
}

}  // namespace

Certificate certify(const Robot& robot, const Campaign& campaign, const Evaluation& evaluation,
                    const About& about, const CertificateOptions& options) {
  CampaignFigures found = figures_of(campaign, evaluation);
  if (found.poses.empty())
    throw std::invalid_argument(
        fmt::format("each of the {} poses has one visit only, which shows no repeatability; leave "
                    "each pose and "
                    "return to it, ISO 9283 asks for {} cycles, and give the visits the same name "
                    "in the column "
                    "pose",
                    found.single.size(), kStandardCycles));
  static const std::vector<std::string> kStandardPoses{"P1", "P2", "P3", "P4", "P5"};
  const std::vector<PoseFigures> cube =
      named(found, options.cube.empty() ? kStandardPoses : options.cube, !options.cube.empty());
  Certificate certificate;
  certificate.about = about;
  certificate.robot = robot.name;
  certificate.joints = joint_names(robot.chain);
  certificate.refitted = options.refitted;
  certificate.tolerance = options.tolerance;
  certificate.all = largest_of(found.poses);
  if (!cube.empty()) certificate.cube = largest_of(cube);
  const double range = about.range.value_or(largest_range(robot, campaign));
  certificate.budget =
      budget_of(about.stated, scatter_of(found.poses), certificate.all.fewest_visits, range,
                model_uncertainty(robot, campaign));
  const double with_hidden =
      certificate.all.ap.value * most_with_hidden(options.hidden, normal_below(kCoverage));
  certificate.doubts = doubts_of_visits(robot, campaign, evaluation, about.stated.noise);
  if (options.tolerance)
    certificate.decision = no_arm_in_words(campaign, evaluation).empty()
                               ? decision_on(certificate, options, with_hidden)
                               : Decision::undecided;  // such an AP is none of an arm
  add_notes_on_visits(found, certificate);
  add_notes(options, robot, certificate);
  for (const std::string& doubt : certificate.doubts)
    certificate.notes.push_back("Doubt: " + doubt + ".");
  if (!options.hidden.words.empty())
    certificate.notes.push_back("Doubt: " + options.hidden.words + ".");
  const auto decide_on = [&](double ap) {
    return decide(ap, certificate.budget.expanded, *options.tolerance);
  };
  const bool is_met = options.tolerance && decide_on(certificate.all.ap.value) == Decision::pass;
  if (is_met && is_doubtful(certificate, options))
    certificate.notes.push_back(
        "AP meets the tolerance, but doubts stand against the figures, see the notes and warnings: "
        "the tolerance is not known to be met. Remove their causes and certify again.");
  if (is_met && decide_on(with_hidden) != Decision::pass)
    certificate.notes.push_back(
        fmt::format("With what the fit of {} to few poses hides, AP may be {}: the tolerance is "
                    "not known to be met; measure more poses.",
                    options.refitted,
                    std::isfinite(with_hidden) ? fmt::format("{:.3g} mm", with_hidden / kMillimetre)
                                               : "anything"));
  if (options.path) add_path(*options.path, range, certificate);
  certificate.poses = std::move(found.poses);
  return certificate;
}

Certificate certify_path(const About& about, const PathFigures& path) {
  Certificate certificate;
  certificate.about = about;
  certificate.notes.emplace_back(
      "Of a recorded path alone: AP and RP of poses are not certified; they need poses that were "
      "visited several times, and the robot.");
  if (!about.range && about.stated.mpe_per_metre > 0)
    certificate.notes.push_back(
        fmt::format("The instrument is taken to have read over {:.3g} m, the farthest sample from "
                    "the origin of its frame; if it stood elsewhere, state range_mm.",
                    path.range));
  add_path(path, about.range.value_or(path.range), certificate);
  return certificate;
}

JointColumns joint_columns(const PoseFigures& figures, const std::vector<JointName>& joints) {
  JointColumns columns;
  for (size_t j = 0; j < joints.size(); ++j)
    columns[joints[j].encoder()] = figures.q[static_cast<Eigen::Index>(j)] / joints[j].si();
  return columns;
}

CertifiedValues values_of(const Certificate& certificate) {
  CertifiedValues values{
      certificate.about.serial, certificate.about.type, certificate.about.date, {}, {}};
  const double expanded = certificate.budget.expanded;
  if (certificate.has_poses()) add_figures(certificate.all, expanded, "", values.figures);
  if (certificate.cube) add_figures(*certificate.cube, expanded, "cube ", values.figures);
  if (const auto& path = certificate.path) {
    values.figures.push_back({"at", path->at, certificate.path_budget->expanded});
    if (path->rt) values.figures.push_back({"rt", *path->rt, path->rt_expanded()});
  }
  for (const PoseFigures& figures : certificate.poses)
    values.poses.push_back(
        {figures.pose, figures.ap, expanded, joint_columns(figures, certificate.joints)});
  return values;
}

Comparison compare(const CertifiedValues& before, const CertifiedValues& now) {
  if (before.serial != now.serial)
    throw std::invalid_argument(
        fmt::format("is the certificate of the robot with the serial number '{}', not '{}'; give "
                    "the older certificate of the same robot",
                    before.serial, now.serial));
  Comparison comparison{before.date, differences(before.figures, now.figures),
                        differences(before.poses, now.poses), other_poses(before.poses, now.poses)};
  std::erase_if(comparison.poses, [&](const CertifiedChange& change) {
    return std::ranges::find(comparison.others, change.name, &OtherPose::name) !=
           comparison.others.end();
  });
  judge(comparison.figures, 1);
  if (comparison.poses.empty()) return comparison;
  // P(|N(0, 1)| > 2) = 4.55 %, shared by the poses.
  const double tail = (1 - normal_below(kCoverage)) / static_cast<double>(comparison.poses.size());
  constexpr double kFreedomOfNormal = 1e6;  // the law of t is normal there
  judge(comparison.poses, student_t_quantile(1 - tail, kFreedomOfNormal) / kCoverage);
  return comparison;
}

std::string doubt_of_poses(const Comparison& comparison) {
  const std::vector<OtherPose>& others = comparison.others;
  if (others.empty()) return "";
  std::vector<std::string> names;
  for (const OtherPose& other : others) names.push_back(other.name);
  const OtherPose& most = *std::ranges::max_element(others, {}, &OtherPose::apart);
  return fmt::format(
      "poses of {} of {} names have other joint values ({}; {} of {} differs by {:.4g}): their "
      "differences are not those of one pose, and are left out. AP and RP of all poses are of "
      "other "
      "poses, too; visit the poses of the older certificate",
      others.size(), others.size() + comparison.poses.size(), first_of(names), most.joint,
      most.name, most.apart);
}

}  // namespace armtrue
