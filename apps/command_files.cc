#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <unordered_set>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/without_rows.h"
#include "armtrue/compensation/target_doubts.h"
#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/diagnosis/log_check.h"
#include "armtrue/diagnosis/mistakes.h"
#include "armtrue/diagnosis/other_arm.h"
#include "armtrue/diagnosis/renumbered_images.h"
#include "armtrue/diagnosis/size_check.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/effects/identify.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/parameters_io.h"
#include "armtrue/io/program_io.h"
#include "armtrue/io/source.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/observation.h"
#include "armtrue/text/number_text.h"
#include "command_line.h"
#include "option_text.h"

namespace armtrue::app {
namespace {

// Wherever the readings were taken: no place is more than 14 hours ahead of UTC.
std::string latest_date_now() {
  using namespace std::chrono;
  const year_month_day date{floor<days>(system_clock::now() + 14h)};
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
}

}  // namespace

RobotFile Command::read_robot(const std::string& path) {
  RobotFile file = armtrue::read_robot(path);
  add_robot_to_inputs(file);
  return file;
}

void Command::add_robot_to_inputs(const RobotFile& file) {
  inputs_.emplace_back(file.name, file.sha256);
  for (const std::string& doubt : doubts_of_sizes(file.robot.chain)) warn(file.name + ": " + doubt);
}

Campaign Command::read_campaign(const std::string& path, const Robot& robot, Copies copies) {
  progress("reading measurements");
  CampaignFile file = armtrue::read_campaign(path, robot.chain);
  inputs_.emplace_back(file.campaign.source, file.sha256);
  warn_of_unknown(file.unknown_columns);
  warn_of_turns(file.campaign.source, file.moved_by_turns, robot, file.campaign.line);
  if (file.campaign.skipped_rows > 0)
    warn(fmt::format("{} without a measurement skipped",
                     counted(file.campaign.skipped_rows, "row")));
  bind_touches(file.campaign, robot.chain);
  const Findings findings = check_log(file.campaign);
  if (!findings.errors.empty())
    throw InputError(file.campaign.source + ": " + findings.errors.front());
  for (const std::string& warning : findings.warnings) warn(file.campaign.source + ": " + warning);
  if (copies == Copies::leave_out) leave_out_copies(file.campaign);
  if (const RenumberedImages renumbered = find_renumbered_images(robot, file.campaign);
      !renumbered.rows.empty()) {
    warn(file.campaign.source + ": " + renumbered.words);
    file.campaign = without_rows(file.campaign, renumbered.rows);
  }
  begin_new_sessions(file.campaign, path == input);
  if (const auto computed = find_computed_orientations(robot, file.campaign)) {
    warn(file.campaign.source + ": " + *computed);
    leave_out_orientations(file.campaign);
  }
  return std::move(file.campaign);
}

void Command::leave_out_copies(Campaign& campaign) {
  const CopiedRows copies = copied_rows(campaign);
  if (copies.rows.empty()) return;
  warn(fmt::format(
      "{}: {} of {} rows read the same as another of their pose to the last digit, such as line {} "
      "and line {}: a copy is no second visit and says nothing of the noise; one row of each "
      "reading counts, the others are left out",
      campaign.source, copies.rows.size(), campaign.rows(), campaign.line[copies.row],
      campaign.line[copies.of]));
  campaign = without_rows(campaign, copies.rows);
}

void Command::warn_of_turns(const std::string& source, const std::vector<MovedByTurns>& moved,
                            const Robot& robot, const std::vector<int>& lines) {
  if (moved.empty()) return;
  warn(source + ": " + moved_text(moved, joint_names(robot.chain), lines));
}

void Command::begin_new_sessions(Campaign& campaign, bool is_input) const {
  if (new_sessions_s.empty()) return;
  if (campaign.has_touches())
    throw InputError(campaign.source +
                     ": --new-session-at-s is for an instrument that was moved, and contacts have "
                     "none; give a contact that was moved another name from then on");
  const std::vector<double>& times = campaign.time_s;
  if (times.empty())
    throw InputError(campaign.source +
                     ": --new-session-at-s needs the time of each reading; add the column t_s");
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  for (double start : new_sessions_s)
    if (is_input && !(start > *first && start <= *last))  // held-out poses may all lie on one side
      throw InputError(fmt::format(
          "{}: --new-session-at-s {} leaves no reading on one side; t_s goes from {} to {}",
          campaign.source, start, *first, *last));
  begin_sessions(campaign, new_sessions_s);
}

PathFile Command::read_path(const std::string& path, KeepRows keep,
                            const std::optional<Robot>& robot) {
  PathFile file =
      armtrue::read_path(path, keep, robot ? joint_names(robot->chain) : six_axis_names());
  inputs_.emplace_back(file.source, file.sha256);
  if (keep == KeepRows::no) warn_of_unknown(file.unknown_columns);
  return file;
}

PathFile Command::read_force_record(const std::string& path) {
  PathFile file = armtrue::read_force_record(path);
  inputs_.emplace_back(file.source, file.sha256);
  return file;
}

namespace {

// Whether angles that were read as degrees are those of an arm in radians: it moves by most of its
// joints, but never leaves the zero pose by more than a turn in radians, 6.28 deg.
bool look_like_radians(const JointRows& q, const std::vector<JointName>& joints) {
  constexpr size_t kFewestTargets = 5;
  constexpr double kTurn = 2 * std::numbers::pi * kDegree, kMoves = 0.5 * kDegree;
  if (q.size() < kFewestTargets) return false;
  int angles = 0, moving = 0;
  for (size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].is_length) continue;
    const auto at = [j](const JointVector& joint) { return joint[j]; };
    const auto [least, largest] = std::ranges::minmax(q, {}, at);
    if (std::max(-at(least), at(largest)) > kTurn) return false;
    ++angles;
    moving += at(largest) - at(least) > kMoves;
  }
  return angles > 2 && 2 * moving > angles;
}

}  // namespace

ProgramFile Command::read_program(const std::string& path, const Robot& robot) {
  ProgramFile file = armtrue::read_program(path, robot.chain);
  if (look_like_radians(file.program.visits.q, file.joints))
    warn(file.source +
         ": all joint angles lie within 6.28 deg of zero: are these radians? Then name the columns "
         "q1_rad and so on");
  warn_of_turns(file.source, file.moved_by_turns, robot, file.program.visits.line);
  inputs_.emplace_back(file.source, file.sha256);
  return file;
}

About Command::read_about(const std::string& path) {
  AboutFile file = armtrue::read_about(path);
  inputs_.emplace_back(file.name, file.sha256);
  if (const std::string latest = latest_date_now(); file.about.date > latest)
    warn(
        fmt::format("{}: date: {} is not yet, by the clock of this computer (now at most {}): "
                    "correct the date of the readings",
                    path, file.about.date, latest));
  return std::move(file.about);
}

CertifiedValues Command::read_certificate(const std::string& path) {
  CertificateFile file = armtrue::read_certificate(path);
  inputs_.emplace_back(file.name, file.sha256);
  return std::move(file.values);
}

std::vector<ProgramText> Command::read_program_texts(const std::string& path,
                                                     const std::string& dat, bool with_dat) {
  std::vector<ProgramText> texts;
  for (const TextFile& file : armtrue::read_program_texts(path, dat, with_dat)) {
    inputs_.emplace_back(file.text.name, file.sha256);
    texts.push_back(file.text);
  }
  return texts;
}

std::vector<ProgramText> Command::read_program_folder(const std::string& folder) {
  std::vector<ProgramText> texts;
  for (const TextFile& file : armtrue::read_program_folder(folder)) {
    inputs_.emplace_back(file.text.name, file.sha256);
    texts.push_back(file.text);
  }
  return texts;
}

std::vector<ProgramText> Command::read_program_archive(const Archive& archive,
                                                       const std::string& path) {
  inputs_.emplace_back(path, archive.sha256());
  std::vector<ProgramText> texts;
  for (const ArchiveMember& member : archive.members()) {
    if (member.is_folder || !is_program_text(member.path)) continue;
    ProgramText text = program_text(path + ": " + member.path, member.content);
    text.name = member.path;
    texts.push_back(std::move(text));
  }
  std::ranges::sort(texts, {}, &ProgramText::name);
  if (texts.empty()) throw no_program_in(path);
  return texts;
}

void Command::warn_of_unknown(const std::vector<std::string>& columns) {
  if (columns.empty()) return;
  std::string list;
  for (const std::string& column : columns) list += (list.empty() ? "" : ", ") + column;
  warn("columns not used: " + list);
}

Provenance Command::provenance() const { return {name_, ARMTRUE_VERSION, inputs_, warnings_}; }

void Command::warn_if_calibrated(const Robot& robot, const std::string& path) {
  if (!is_calibrated(robot)) return;
  warn(path +
       ": is calibrated already; what it states as nominal are results of other readings, and "
       "errors of those stay: give the nominal robot, if you have it; after a change of the same "
       "arm, or for a second one of the type, this file is right");
}

void Command::forget_remainder(Robot& robot, const std::string& path) {
  const auto count =
      std::erase_if(robot.effects, [](const Effect& effect) { return effect.name == kRemainder; });
  if (count > 0)
    warn(fmt::format("{}: {} called '{}', of other readings, {} no part here", path,
                     counted(count, "effect"), kRemainder, count == 1 ? "takes" : "take"));
}

bool Command::warn_if_computed(const Robot& robot, const Campaign& campaign) {
  const auto computed = find_computed_points(robot, campaign);
  if (computed) warn(campaign.source + ": " + *computed);
  return computed.has_value();
}

void Command::warn_if_needless(const Robot& robot, const Campaign& campaign) {
  if (warn_if_computed(robot, campaign)) return;
  if (const auto needless = find_needless_calibration(robot, campaign))
    warn(campaign.source + ": " + *needless);
}

void Command::warn_of_training(const RobotFile& robot, const Campaign& campaign,
                               const std::string& consequence) {
  const SeenPoses poses = seen_poses(robot.training, campaign);
  if (poses.seen == 0) return;
  warn(fmt::format(
      "{}: {} of {} poses took part in the calibration of {}{}: {}; measure poses that it did not "
      "use",
      campaign.source, poses.seen, poses.compared, robot.name,
      poses.compared < campaign.poses()
          ? fmt::format(" (of {} poses; its file marks a part of its rows)",
                        campaign.pose_ids.size())
          : "",
      consequence));
}

void Command::warn_of_own_readings(const RobotFile& robot) {
  for (const auto& [file, sha256] : inputs_)
    if (std::ranges::find(robot.made_of, sha256) != robot.made_of.end())
      warn(file + ": " + robot.name +
           " was calibrated with these readings, which cannot show what has changed since; give "
           "new ones");
}

extern const std::vector<std::pair<const char*, const char*>> kShippedRobots;

namespace {

// Names the robot file of armtrue that the readings fit, if they do not fit the one that was given.
std::string shipped_arm_in_words(const Robot& robot, const Campaign& campaign) {
  constexpr int kMostRows = 10000;  // beyond, nobody waits for it
  if (campaign.rows() > kMostRows || !may_be_another_arm(robot, campaign)) return "";
  std::vector<Robot> arms;
  for (const auto& [name, text] : kShippedRobots) arms.push_back(parse_robot(text, name));
  const FittingArm found = arm_that_fits(arms, robot, campaign);
  if (found.index < 0) return "";
  return fmt::format(
      "config/robots/{} ({}) fits the points to {:.3g} mm, and the file of --robot ({}) to {:.3g} "
      "mm (median, base and tool placed): is that the arm?",
      kShippedRobots[found.index].first, arms[found.index].name, found.miss / kMillimetre,
      robot.name, placed_miss(robot, campaign).value_or(0) / kMillimetre);
}

}  // namespace

void refuse_mistakes(Command& command, const Robot& robot, const Campaign& campaign) {
  const Findings found = find_mistakes(robot, campaign);
  const std::string source = campaign.source + ": ";
  const std::string shipped = shipped_arm_in_words(robot, campaign);
  if (!found.errors.empty())
    throw InputError(source + found.errors.front() + (shipped.empty() ? "" : "; " + shipped));
  for (const std::string& warning : found.warnings) command.warn(source + warning);
  if (!shipped.empty()) command.warn(source + shipped);
  command.warned_of_change = found.of_change;
  if (!found.wrong_readings.empty()) command.wrong_readings = found.wrong_readings;
  command.angles_read_early |= !found.early_angles.empty();
  command.sensor_error = found.sensor;
  command.arm_in_doubt = !found.other_arm.empty() || !shipped.empty();
}

JointVector joints_of(Command& command, const std::vector<double>& numbers, const Robot& robot,
                      const std::string& option) {
  JointVector q = joints_of(numbers, robot, option);
  const std::vector<JointName> joints = joint_names(robot.chain);
  std::vector<double> degrees;
  for (size_t j = 0; j < joints.size(); ++j)
    if (!joints[j].is_length) degrees.push_back(numbers[j]);
  warn_of_all(command, {doubt_of_joints(option, degrees)});
  return q;
}

void warn_of_all(Command& command, const std::vector<std::string>& doubts) {
  for (const std::string& doubt : doubts)
    if (!doubt.empty()) command.warn(doubt);
}

void add_parameter_tables(Command& command, std::string& parameters, std::string& correlations) {
  command.add_output("--parameters", parameters,
                     "Write a table of the identified parameters here: nominal, value, change, "
                     "standard deviation, 95 % interval, share of the readings",
                     ProductKind::table);
  command.add_output("--correlations", correlations, "Write their correlations here",
                     ProductKind::table);
}

void write_parameter_tables(const std::string& parameters, const std::string& correlations,
                            const Robot& nominal, const CalibrationResult& result, int poses) {
  if (!parameters.empty()) write_output(parameters, write_parameters(nominal, result, poses));
  if (!correlations.empty()) write_output(correlations, write_correlations(result));
}

void use_identify(const std::string& list, Robot& robot) {
  if (!list.empty()) robot.identify = parameters_of("--identify", list, robot);
}

std::vector<std::string> parameters_of(const std::string& option, const std::string& list,
                                       const Robot& robot) {
  std::vector<std::string> names = split_list(list);
  if (const std::string why = why_not_identified(robot.chain, names); !why.empty())
    throw InputError(option + ": " + why);
  return names;
}

void require_sessions(const Robot& robot, const Campaign& campaign) {
  if (robot.sessions.empty()) return;
  for (int session : campaign.session)
    if (const std::string& name = campaign.session_names[session]; !robot.sessions.contains(name))
      throw InputError(campaign.source +
                       ": the robot file does not say where the instrument of session '" + name +
                       "' stood; add --refit base");
}

InputError at_its_line(const PathFile& file, const UnreachableSample& error) {
  return InputError(file.source + ":" + std::to_string(file.line[error.sample]) +
                    ": the sample at t_s = " + number_text(file.path.time[error.sample]) + ": " +
                    error.what());
}

void require_same_joints(const Robot& robot, const std::string& a, const Robot& other,
                         const std::string& b) {
  const std::string own = encoder_columns(robot.chain), others = encoder_columns(other.chain);
  if (own != others)
    throw InputError(
        fmt::format("{} has the joints {}, and {} the joints {}: give two models of "
                    "one arm",
                    a, own, b, others));
}

void require_one_arm(Command& command, const Robot& robot, const std::string& a, const Robot& truth,
                     const std::string& b) {
  require_same_joints(robot, a, truth, b);
  if (const double apart = distance_between_arms(robot, truth); apart > kImplausibleMiss)
    command.warn(fmt::format(
        "{} and {} are no models of one arm: with base and tool fitted, their points lie {:.4g} mm "
        "apart (median over the travel); compare lengths, zeros and signs of the joints",
        a, b, apart / kMillimetre));
}

void warn_beyond_travel(Command& command, const std::string& file,
                        const std::vector<JointTarget>& targets, const KinematicChain& chain) {
  const auto beyond = [&](const JointTarget& target) {
    return beyond_travel(chain, target.q).has_value();
  };
  const auto first = std::ranges::find_if(targets, beyond);
  if (first == targets.end()) return;
  const auto [index, value] = *beyond_travel(chain, first->q);
  const Link& link = chain.links[index];
  const double unit = is_prismatic(link) ? kMillimetre : kDegree;
  const char* const unit_name = is_prismatic(link) ? "mm" : "deg";
  const auto count = std::ranges::count_if(targets, beyond);
  command.warn(fmt::format(
      "{}:{}: {} of {} {} beyond the travel of the joints; in the first, '{}', {} stands "
      "at {:.6g} {}, outside {:.6g} to {:.6g} {}",
      file, first->line, count, counted(targets.size(), "target"), count == 1 ? "lies" : "lie",
      first->pose, link.name, value / unit, unit_name, link.min / unit, link.max / unit,
      unit_name));
}

std::vector<JointTarget> numbered(const std::vector<PlannedPose>& poses,
                                  const std::vector<std::string>& taken) {
  const std::unordered_set<std::string> ids(taken.begin(), taken.end());
  std::vector<JointTarget> targets;
  for (int number = 1; targets.size() < poses.size(); ++number) {
    const std::string id = std::to_string(number);
    if (ids.contains(id)) continue;
    const PlannedPose& pose = poses[targets.size()];
    targets.push_back({id, pose.q, 0, pose.contact, pose.target});
  }
  return targets;
}

Catalogue catalogue(const std::string& path) {
  extern const char* const kShippedCatalogue;
  return path.empty() ? parse_catalogue(kShippedCatalogue, "the shipped catalogue")
                      : read_catalogue(path);
}

}  // namespace armtrue::app
