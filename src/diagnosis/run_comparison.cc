#include "armtrue/diagnosis/run_comparison.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "armtrue/calibration/identified_values.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/text/number_text.h"

namespace armtrue {
namespace {

// The name of what a search finds and no entry of the catalogue explains.
constexpr const char* kUnexplained = "unexplained";

// A number that a run states, with the poses that its standard deviation comes from; 0: not said.
struct Stated {
  double value = 0, std = 0;
  int poses = 0;
};

// Of independent readings; p-value of this number alone.
void test_change(const Stated& before, const Stated& after, NumberChange& number) {
  constexpr double kManyPoses = 1e6;
  const double a = before.std * before.std, b = after.std * after.std;
  if (!number.change || a <= 0 || b <= 0) return;
  const auto freedom_of = [](const Stated& one) {
    return one.poses > 0 ? std::max(1.0, one.poses - 1.0) : kManyPoses;
  };
  const double freedom =
      (a + b) * (a + b) / (a * a / freedom_of(before) + b * b / freedom_of(after));
  number.std = std::sqrt(a + b);
  const double half = student_t_quantile(0.975, freedom) * *number.std;
  number.ci95 = {*number.change - half, *number.change + half};
  number.p_value = 2 * student_t_above(std::abs(*number.change) / *number.std, freedom);
}

int poses_of(const ComparedRun& run) {
  if (run.robot && run.robot->uncertainty) return run.robot->uncertainty->poses;
  return run.errors ? run.errors->poses : 0;
}

double std_of(const Robot& robot, const std::string& name) {
  const auto found = robot.std.find(name);
  return found == robot.std.end() ? 0 : found->second;
}

bool is_of_arm(const Parameter& parameter) {
  return parameter.owner == Owner::link || parameter.owner == Owner::coupling;
}

// How a parameter of both chains has changed; nothing if it has no number.
std::optional<double> change_of(const KinematicChain& before, const KinematicChain& after,
                                const std::string& name) {
  const auto from = find_parameter(before, name), to = find_parameter(after, name);
  if (!from || !to) return std::nullopt;
  const auto change = parameter_change(before, after, *from);
  const bool is_same_place = *from == *to;
  if (!is_same_place) {  // of a target among others
    const auto a = parameter_value(before, *from), b = parameter_value(after, *to);
    return a && b ? std::optional(*b - *a) : std::nullopt;
  }
  const bool turns = Parameter(name).owner == Owner::link &&
                     parameter_unit(before, *from) == ParameterUnit::radian;
  return change && turns ? std::remainder(*change, 2 * std::numbers::pi) : change;
}

std::optional<double> value_of(const KinematicChain& chain, const std::string& name) {
  const auto index = find_parameter(chain, name);
  return index ? parameter_value(chain, *index) : std::nullopt;
}

// Those that one run or both identified, in the order of the chain.
std::vector<ComparedParameter> compared_parameters(const ComparedRun& before,
                                                   const ComparedRun& after) {
  std::vector<ComparedParameter> found;
  std::set<std::string> named;
  const auto add = [&](const std::string& name, const KinematicChain& chain, int index) {
    const double s1 = std_of(*before.robot, name), s2 = std_of(*after.robot, name);
    if ((s1 == 0 && s2 == 0) || !named.insert(name).second) return;
    ComparedParameter& one = found.emplace_back();
    one.name = name;
    one.unit = unit_in_files(chain, index);
    one.of_arm = is_of_arm(Parameter(name));
    one.in = s1 == 0 ? InRuns::after : s2 == 0 ? InRuns::before : InRuns::both;
    one.number.before = value_of(before.robot->chain, name);
    one.number.after = value_of(after.robot->chain, name);
    one.number.change = change_of(before.robot->chain, after.robot->chain, name);
  };
  for (const ComparedRun* run : {&after, &before}) {
    const KinematicChain& chain = run->robot->chain;
    for (int index = 0; index < parameter_count(chain); ++index)
      add(parameter_name(chain, index), chain, index);
  }
  return found;
}

// Parameters of links that neither run identified and that are not the same.
std::vector<std::string> held_apart(const Robot& before, const Robot& after) {
  constexpr double kRounding = 1e-9;  // m or rad: files of other programs round
  std::vector<std::string> names;
  const ParameterLayout layout = layout_of(before.chain);
  for (int index = 0; index < layout.geometric; ++index) {
    const std::string name = parameter_name(before.chain, index);
    if (!is_of_arm(Parameter(name)) || std_of(before, name) > 0 || std_of(after, name) > 0)
      continue;
    const auto change = change_of(before.chain, after.chain, name);
    if (change && std::abs(*change) > kRounding) names.push_back(name);
  }
  return names;
}

// For each effect of the run after, that of the run before, or -1. A model may have several of one
// form, such as steps in time: those of the same inner values first.
std::vector<std::ptrdiff_t> matches(const std::vector<NamedEffect>& after,
                                    const std::vector<NamedEffect>& before) {
  std::vector<std::ptrdiff_t> found(after.size(), -1);
  for (const bool with_inner : {true, false})
    for (size_t i = 0; i < after.size(); ++i)
      for (std::ptrdiff_t k = 0; k < std::ssize(before) && found[i] < 0; ++k)
        if (before[k].parameter == after[i].parameter && before[k].driver == after[i].driver &&
            before[k].shape == after[i].shape &&
            (!with_inner || before[k].inner == after[i].inner) &&
            std::ranges::find(found, k) == found.end())
          found[i] = k;
  return found;
}

std::vector<ComparedEffect> compared_effects(const ComparedRun& before, const ComparedRun& after) {
  std::vector<ComparedEffect> found;
  const std::vector<std::ptrdiff_t> matched = matches(after.effects, before.effects);
  for (size_t i = 0; i < after.effects.size(); ++i) {
    const NamedEffect& effect = after.effects[i];
    ComparedEffect& one = found.emplace_back(ComparedEffect{effect, InRuns::after, true, {}, {}});
    for (const NamedCoefficient& coefficient : effect.coefficients)
      one.numbers.push_back({{}, coefficient.value, {}, {}, {}, {}});
    if (matched[i] < 0) continue;
    const NamedEffect& old = before.effects[matched[i]];
    one.in = InRuns::both;
    one.same_inner = old.inner == effect.inner;
    for (size_t c = 0; c < one.numbers.size() && c < old.coefficients.size(); ++c) {
      one.numbers[c].before = old.coefficients[c].value;
      one.std_before.push_back(old.coefficients[c].std);
      if (one.same_inner) one.numbers[c].change = *one.numbers[c].after - old.coefficients[c].value;
    }
  }
  for (size_t k = 0; k < before.effects.size(); ++k) {
    if (std::ranges::find(matched, static_cast<std::ptrdiff_t>(k)) != matched.end()) continue;
    ComparedEffect& one =
        found.emplace_back(ComparedEffect{before.effects[k], InRuns::before, true, {}, {}});
    for (const NamedCoefficient& coefficient : one.effect.coefficients)
      one.numbers.push_back({coefficient.value, {}, {}, {}, {}, {}});
  }
  return found;
}

bool is_in_curve(const Effect& effect, const std::string& parameter, int joint) {
  return is_nameless(effect) && is_of_one_angle(effect) && effect.driver.joint == joint &&
         to_string(effect.parameter) == parameter;
}

double value_at(const Robot& robot, const std::string& parameter, int joint, double q) {
  double sum = 0;
  for (const Effect& effect : robot.effects) {
    if (!is_in_curve(effect, parameter, joint)) continue;
    std::vector<double> values(effect.coefficients.size());
    const double x = effect.driver_range
                         ? std::clamp(q, (*effect.driver_range)[0], (*effect.driver_range)[1])
                         : q;
    evaluate(effect.shape, x, values.data());
    for (size_t k = 0; k < values.size(); ++k) sum += values[k] * effect.coefficients[k].value;
  }
  return sum;
}

double rms_about_mean(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (const double value : values) sum += value;
  const auto count = static_cast<double>(values.size());
  for (const double value : values) squares += (value - sum / count) * (value - sum / count);
  return std::sqrt(squares / count);
}

std::vector<RemainderCurve> compared_remainder(const Robot& before, const Robot& after) {
  constexpr int kPoints = 37;  // every 10 deg of a turn
  std::vector<RemainderCurve> curves;
  const std::vector<JointName> names = joint_names(after.chain);
  for (const Robot* robot : {&after, &before})
    for (const Effect& effect : robot->effects) {
      const int joint = effect.driver.joint;
      const std::string parameter = to_string(effect.parameter);
      if (!is_in_curve(effect, parameter, joint)) continue;
      if (std::ranges::any_of(curves, [&](const RemainderCurve& curve) {
            return curve.parameter == parameter && curve.joint == joint;
          }))
        continue;
      const Link& link = joint_link(after.chain, joint);
      double low = link.min, high = link.max;
      for (const Robot* one : {&before, &after})
        for (const Effect& other : one->effects)
          if (is_in_curve(other, parameter, joint) && other.driver_range) {
            low = std::max(low, (*other.driver_range)[0]);
            high = std::min(high, (*other.driver_range)[1]);
          }
      if (!(low < high) || !std::isfinite(high - low)) continue;
      RemainderCurve& curve = curves.emplace_back();
      curve.parameter = parameter;
      curve.joint = joint;
      curve.name = names[joint];
      curve.unit = display_unit(after.chain, effect.parameter);
      std::vector<double> change;
      for (int k = 0; k < kPoints; ++k) {
        curve.q.push_back(low + (high - low) * k / (kPoints - 1));
        curve.before.push_back(value_at(before, parameter, joint, curve.q.back()));
        curve.after.push_back(value_at(after, parameter, joint, curve.q.back()));
        change.push_back(curve.after.back() - curve.before.back());
      }
      curve.rms_before = rms_about_mean(curve.before);
      curve.rms_after = rms_about_mean(curve.after);
      curve.rms_change = rms_about_mean(change);
    }
  return curves;
}

// The first ones, and how many there are beside them.
std::string some_of(const std::vector<std::string>& names, const char* between) {
  constexpr size_t kShown = 4;  // of a sentence
  if (names.size() <= kShown) return fmt::format("{}", fmt::join(names, between));
  return fmt::format("{}{}and {} others", fmt::join(names.begin(), names.begin() + kShown, between),
                     between, names.size() - kShown);
}

// Whether an effect is a curve that readings determined and no prior.
bool has_curve(const Robot& robot) {
  return std::ranges::any_of(robot.effects, [](const Effect& effect) {
    return is_nameless(effect) && effect.name != kRemainder;
  });
}

// Whether one run is the robot file from which calibrations start, or another with such values.
bool has_nominal(const ComparedRun& before, const ComparedRun& after) {
  return before.robot && after.robot &&
         !(is_calibrated(*before.robot) && is_calibrated(*after.robot));
}

// Of which side something is, behind a name.
const char* in_brackets(InRuns in, ComparedArms arms) {
  if (arms == ComparedArms::two) return in == InRuns::after ? " (second arm)" : " (first arm)";
  return in == InRuns::after ? " (after)" : " (before)";
}

// The same behind a figure.
const char* behind_figure(InRuns in, ComparedArms arms) {
  if (arms == ComparedArms::two)
    return in == InRuns::after ? "for the second" : "for the first arm";
  return in == InRuns::after ? "after" : "before";
}

// Another way to ask whether one arm changed.
const char* or_ask_since(ComparedArms arms) {
  return arms == ComparedArms::one ? ", or ask trace-residual --since" : "";
}

// Why a change of a number may be none of the arm.
std::vector<std::string> why_untested(const ComparedRun& before, const ComparedRun& after,
                                      const RunComparison& found) {
  std::vector<std::string> reasons;
  if (has_nominal(before, after))
    return {"one of the files has nominal values, which have no standard deviations"};
  if (found.readings == Shared::all)
    reasons.emplace_back(
        "both runs are of the same readings: they differ by their models, and standard deviations "
        "say nothing about that");
  if (found.readings == Shared::some)
    reasons.emplace_back(
        "some readings are in both runs, so that their errors are not independent");
  std::vector<std::string> one_sided;
  for (const ComparedParameter& parameter : found.parameters)
    if (parameter.of_arm && parameter.in != InRuns::both)
      one_sided.push_back(parameter.name + in_brackets(parameter.in, found.arms));
  if (!one_sided.empty())
    reasons.push_back(fmt::format(
        "only one run identified {}, so that other parameters of the other run take its part; "
        "calibrate both with the same unknowns (calibrate --identify)",
        some_of(one_sided, ", ")));
  if (!found.held_apart.empty())
    reasons.push_back(
        fmt::format("the runs hold {} at different values, {}", some_of(found.held_apart, ", "),
                    before.nominal == after.nominal
                        ? "where loops have left the means of their effects; compare what "
                          "calibrate makes of both"
                        : "as of different nominal robots; calibrate both from one robot file"));
  if (before.robot && after.robot && (has_curve(*before.robot) || has_curve(*after.robot)))
    reasons.push_back(
        std::string("a model has curves over joints that no cause explains, which differ from run "
                    "to run; compare what calibrate makes of both") +
        or_ask_since(found.arms));
  std::vector<std::string> effects;
  for (const ComparedEffect& effect : found.effects)
    if (!found.parameters.empty() && effect.in != InRuns::both && !effect.effect.may_be_none())
      effects.push_back(effect.effect.in_words() + in_brackets(effect.in, found.arms));
  if (!effects.empty())
    reasons.push_back(fmt::format(
        "only one model has {}, whose part parameters of the other take; compare what calibrate "
        "makes of both{}",
        some_of(effects, "; "), or_ask_since(found.arms)));
  return reasons;
}

void test_numbers(const ComparedRun& before, const ComparedRun& after, RunComparison& found) {
  const int poses_before = poses_of(before), poses_after = poses_of(after);
  std::vector<NumberChange*> tested;
  const auto test = [&](double s1, double s2, NumberChange& number) {
    test_change({number.before.value_or(0), s1, poses_before},
                {number.after.value_or(0), s2, poses_after}, number);
    if (number.p_value) tested.push_back(&number);
  };
  for (ComparedParameter& parameter : found.parameters)
    test(std_of(*before.robot, parameter.name), std_of(*after.robot, parameter.name),
         parameter.number);
  for (ComparedEffect& effect : found.effects) {
    if (effect.in != InRuns::both || !effect.same_inner) continue;
    for (size_t k = 0; k < effect.std_before.size(); ++k)
      test(effect.std_before[k], effect.effect.coefficients[k].std, effect.numbers[k]);
  }
  found.tested = static_cast<int>(tested.size());
  for (NumberChange* number : tested)
    number->p_value = std::min(1.0, *number->p_value * found.tested);
}

// The robot with one parameter of the arm as another run has it.
Robot with_change(Robot robot, const ComparedParameter& parameter) {
  move_parameter(robot.chain, *find_parameter(robot.chain, parameter.name),
                 *parameter.number.change);
  return robot;
}

std::string mm(double metres) {
  constexpr double kShownAsZero = 5e-8;  // m: half of a tenth of a um
  return metres < kShownAsZero ? "0 mm" : fmt::format("{:.2g} mm", metres / kMillimetre);
}

std::string moved_in_words(const ComparedParameter& parameter, const KinematicChain& chain) {
  const DisplayUnit unit =
      display_unit(parameter_unit(chain, *find_parameter(chain, parameter.name)));
  const double half = ((*parameter.number.ci95)[1] - (*parameter.number.ci95)[0]) / 2;
  return fmt::format("{} by {:.3g} {} (+- {:.2g})", parameter.name,
                     *parameter.number.change / unit.si, unit.name, half / unit.si);
}

std::string moved_in_words(const ComparedEffect& effect) {
  std::string text = effect.effect.in_words();
  for (size_t k = 0; k < effect.numbers.size(); ++k)
    if (const NumberChange& number = effect.numbers[k]; number.moved())
      text += fmt::format(", {} from {:.3g} to {:.3g} {}", effect.effect.coefficients[k].name,
                          *number.before, *number.after, effect.effect.coefficients[k].unit);
  return text;
}

std::string listed(const std::vector<std::string>& items) {
  if (items.size() < 2) return items.empty() ? "" : items.front();
  return fmt::format("{} and {}", fmt::join(items.begin(), items.end() - 1, ", "), items.back());
}

std::string arms_in_words(const RunComparison& found) {
  return fmt::format(
      "{} at the tool on average, {} at most{}", mm(found.arm->mean), mm(found.arm->max),
      found.largest_pose.empty() ? "" : fmt::format(", in pose '{}'", found.largest_pose));
}

// What base and tool, which are fitted to few poses, take up of the distance.
std::string hidden_in_words(const ArmDifference& arm) {
  if (arm.hidden.words.empty()) return "";
  const std::string fit = fmt::format(" Base and tool of the first are fitted to these {}",
                                      counted(arm.q.size(), "pose"));
  if (arm.hidden.freedom == 0)
    return fit + " and take up all of the distance: compare at more poses.";
  return fit + fmt::format(
                   ", which takes up a part of the distance: at other poses of this region "
                   "expect {} RMS.",
                   mm(arm.rms * arm.times_elsewhere()));
}

bool number_of_arm_moved(const RunComparison& found) {
  const auto moved = [](const ComparedParameter& parameter) {
    return parameter.of_arm && parameter.number.moved();
  };
  const auto changed = [](const ComparedEffect& effect) {
    return effect.effect.of_arm() && std::ranges::any_of(effect.numbers, &NumberChange::moved);
  };
  return std::ranges::any_of(found.parameters, moved) ||
         std::ranges::any_of(found.effects, changed);
}

// The readings decide only on a distance above what chance makes on average.
bool arm_as_a_whole_moved(const RunComparison& found) {
  if (!found.arm) return false;
  return found.arm->moved() || (found.by_readings && found.by_readings->moved() &&
                                found.arm->rms > found.arm->by_chance.value_or(0));
}

// Whether one scale of all lengths explains the difference of the arms, and no parameter does
// alone.
bool is_of_scale(const RunComparison& found) {
  if (!found.arm || !found.arm->scale || !arm_as_a_whole_moved(found)) return false;
  const CommonScale& scale = *found.arm->scale;
  const double left = found.by_readings
                          ? std::min(scale.p_value, found.by_readings->p_value_beside_scale)
                          : scale.p_value;
  return left >= kChangeSignificance &&
         std::ranges::none_of(found.parameters, [&](const ComparedParameter& parameter) {
           return parameter.left_beside && *parameter.left_beside <= scale.mean;
         });
}

std::string chance_in_words(const ArmDifference& arm) {
  if (!arm.by_chance) return "";
  return fmt::format(" ({} RMS, where chance alone makes {})", mm(arm.rms), mm(*arm.by_chance));
}

// What differs between two arms, that which counts most at the tool first; base and tool are each
// arm's own.
std::string sentence_of_two_arms(const RunComparison& found, const KinematicChain& chain) {
  const ArmDifference& arm = *found.arm;
  const std::string program =
      hidden_in_words(arm) +
      " A program of one errs by as much on the other, with $BASE and $TOOL measured there: "
      "correct its original for the arm that runs it (compensate --robot).";
  if (!found.untested.empty())
    return fmt::format("The arms differ by {}; whether by more than chance is not tested: {}.",
                       arms_in_words(found), found.untested.front()) +
           program;
  if (const std::string why = found.undecided(); !why.empty())
    return fmt::format("Whether the arms differ is undecided: {}.", why);
  if (!found.arm_moved().value_or(false)) {
    const std::optional<double> seen = found.smallest_seen();
    return fmt::format("The arms differ by no more than chance: {}{}.{}", arms_in_words(found),
                       chance_in_words(arm),
                       seen && arm.hidden.freedom > 0
                           ? fmt::format(" A difference of more than {} RMS would have been seen: "
                                         "a program of one may run on the other if it tolerates "
                                         "an error of that size.",
                                         mm(*seen * arm.times_elsewhere()))
                           : hidden_in_words(arm));
  }
  std::vector<const ComparedParameter*> moved;
  for (const ComparedParameter& parameter : found.parameters)
    if (parameter.of_arm && parameter.number.moved()) moved.push_back(&parameter);
  std::ranges::stable_sort(moved, std::ranges::greater(), [](const ComparedParameter* parameter) {
    return parameter->at_tool.value_or(0);
  });
  std::vector<std::string> words;
  for (const ComparedParameter* parameter : moved)
    words.push_back(moved_in_words(*parameter, chain));
  for (const ComparedEffect& effect : found.effects)
    if (effect.effect.of_arm() && std::ranges::any_of(effect.numbers, &NumberChange::moved))
      words.push_back(moved_in_words(effect));
  return fmt::format(
             "The arms differ by {}{}: {}.", arms_in_words(found), chance_in_words(arm),
             words.empty() ? "no parameter alone does, several share it" : some_of(words, ", ")) +
         program;
}

std::string sentence_of_arm(const RunComparison& found, bool is_from_nominal,
                            const KinematicChain& chain) {
  const ArmDifference& arm = *found.arm;
  if (is_from_nominal)
    return fmt::format("The calibrated arm differs from the nominal one by {}.",
                       arms_in_words(found));
  if (found.arms == ComparedArms::two) return sentence_of_two_arms(found, chain);
  if (found.readings == Shared::all)
    return fmt::format("Two models of the same readings: they differ by {}.", arms_in_words(found));
  if (!found.untested.empty())
    return fmt::format(
        "The two models differ by {}; whether the arm has changed does not follow from them: {}.",
        arms_in_words(found), found.untested.front());
  std::vector<std::string> of_arm, of_station;
  for (const ComparedParameter& parameter : found.parameters)
    if (parameter.number.moved())
      (parameter.of_arm ? of_arm : of_station)
          .push_back(parameter.of_arm ? moved_in_words(parameter, chain) : parameter.name);
  for (const ComparedEffect& effect : found.effects)
    if (std::ranges::any_of(effect.numbers, &NumberChange::moved))
      (effect.effect.of_arm() ? of_arm : of_station).push_back(moved_in_words(effect));
  const std::string station =
      of_station.empty()
          ? ""
          : fmt::format(" {} changed: the station was set up anew, which is no change of the arm.",
                        listed(of_station));
  const std::string by_chance = chance_in_words(arm);
  if (const std::string why = found.undecided(); !why.empty())
    return fmt::format("Whether the arm changed is undecided: {}.{}", why, station);
  if (of_arm.empty() && arm_as_a_whole_moved(found))
    return fmt::format(
               "The arm changed by more than chance: {}{}; no parameter alone did, several share "
               "it.",
               arms_in_words(found), by_chance) +
           station;
  if (of_arm.empty())
    return fmt::format(
        "{} changed by more than chance: the arms differ by {}{}{}.{}",
        of_station.empty() ? "Nothing" : "Nothing of the arm", arms_in_words(found), by_chance,
        found.smallest_seen() ? fmt::format("; above {} RMS a change would have been seen",
                                            mm(*found.smallest_seen()))
                              : "",
        station);
  return fmt::format("The arm moved: {}; {}{}. Nothing else of it changed by more than chance.{}",
                     listed(of_arm), arms_in_words(found), by_chance, station);
}

std::string error_change(const RunErrors& before, const RunErrors& after, ComparedArms arms) {
  if (!before.after || !after.after) return "";
  return fmt::format("Mean error of the model of each run: {} {}, {} {}", mm(*before.after),
                     behind_figure(InRuns::before, arms), mm(*after.after),
                     behind_figure(InRuns::after, arms)) +
         (before.floor && after.floor
              ? fmt::format("; the noise of the readings alone, as the run takes it, would make {} "
                            "and {}.",
                            mm(*before.floor), mm(*after.floor))
              : ".");
}

std::string sentence_of_errors(const RunErrors& before, const RunErrors& after, ComparedArms arms) {
  std::string text;
  if (!before.verdict.empty() && !after.verdict.empty())
    text = before.verdict == after.verdict
               ? fmt::format("Both loops end {}.", after.verdict)
               : fmt::format("The loop ended {} {} and {} {}.", before.verdict,
                             behind_figure(InRuns::before, arms), after.verdict,
                             behind_figure(InRuns::after, arms));
  const std::string change = error_change(before, after, arms);
  return text + (text.empty() || change.empty() ? "" : " ") + change;
}

std::string sentence_of_effects(const std::vector<ComparedEffect>& effects, ComparedArms arms) {
  std::vector<std::string> added, gone, moved;
  for (const ComparedEffect& effect : effects) {
    if (effect.in == InRuns::after) added.push_back(effect.effect.in_words());
    if (effect.in == InRuns::before) gone.push_back(effect.effect.in_words());
    if (std::ranges::any_of(effect.numbers, &NumberChange::moved))
      moved.push_back(moved_in_words(effect));
  }
  std::string text;
  const auto tell = [&](const char* what, const std::vector<std::string>& which) {
    if (!which.empty()) text += fmt::format(" {}: {}.", what, some_of(which, "; "));
  };
  const bool is_one = arms == ComparedArms::one;
  tell(is_one ? "Only before" : "Only the first arm", gone);
  tell(is_one ? "Only after" : "Only the second arm", added);
  tell(is_one ? "Changed by more than chance" : "Different by more than chance", moved);
  return text;
}

// Whether rows may be one number each, as of distances, touches and images.
bool may_read_numbers(const ComparedRun& run) {
  return run.robot && !(run.robot->chain.anchors.empty() && run.robot->chain.contacts.empty());
}

// `by_chance`: share of the rows that may be alike by chance.
Shared shared_rows(const TrainingRows& before, const TrainingRows& after, double by_chance) {
  if (before.marks.empty() || after.marks.empty()) return Shared::unknown;
  // Of many rows the smallest marks are kept: beyond the last of either, rows cannot be looked up.
  const std::uint32_t end = std::min(before.marks.back(), after.marks.back());
  const auto count_to = [&](const TrainingRows& rows) {
    return std::ranges::upper_bound(rows.marks, end) - rows.marks.begin();
  };
  std::vector<std::uint32_t> both;
  std::ranges::set_intersection(before.marks, after.marks, std::back_inserter(both));
  const auto fewer = static_cast<double>(std::min(count_to(before), count_to(after)));
  if (static_cast<double>(both.size()) <= by_chance * fewer) return Shared::none;
  const bool is_all = before.rows == after.rows && std::ssize(both) == count_to(before) &&
                      std::ssize(both) == count_to(after);
  return is_all ? Shared::all : Shared::some;
}

Shared shared_files(const std::vector<std::string>& before, const std::vector<std::string>& after) {
  if (before.empty() || after.empty()) return Shared::unknown;
  if (before == after) return Shared::all;
  const bool any = std::ranges::any_of(before, [&](const std::string& file) {
    return std::ranges::find(after, file) != after.end();
  });
  return any ? Shared::some : Shared::none;
}

}  // namespace

bool is_nameless(const Effect& effect) {
  return effect.name == kRemainder || (effect.name == kUnexplained && is_of_one_angle(effect));
}

bool NamedEffect::of_arm() const { return is_of_arm(Parameter(parameter)); }

bool NamedEffect::may_be_none() const {
  constexpr double kHalfWidth = 1.96;  // of a 95 % interval of the normal law
  return std::ranges::all_of(coefficients, [](const NamedCoefficient& c) {
    return c.std > 0 && std::abs(c.value) < kHalfWidth * c.std;
  });
}

std::string NamedEffect::in_words() const {
  return fmt::format("{} ({} follows {})", name, parameter, driver);
}

Shared shared_readings(const ComparedRun& before, const ComparedRun& after) {
  if (before.training && after.training) {
    // A number that is measured again at one pose is often the same to its last step.
    constexpr double kOfNumbers = 0.5;
    const bool may_be_alike = may_read_numbers(before) || may_read_numbers(after);
    const Shared by_rows =
        shared_rows(*before.training, *after.training, may_be_alike ? kOfNumbers : 0);
    if (by_rows != Shared::unknown) return by_rows;
  }
  return shared_files(before.readings, after.readings);
}

std::vector<std::string> notes_of_runs(const ComparedRun& before, const ComparedRun& after,
                                       ComparedArms arms) {
  std::vector<std::string> notes;
  if (has_nominal(before, after))
    return {
        fmt::format("{} states no standard deviations: its values are nominal ones, and what "
                    "differs is what the calibration found.",
                    is_calibrated(*before.robot) ? "The later file" : "The earlier file")};
  if (arms == ComparedArms::two)
    notes.push_back(fmt::format("First arm: {}; second: {}.", before.name, after.name));
  switch (shared_readings(before, after)) {
    case Shared::all:
      notes.emplace_back("Both runs are of the same readings: two models of one campaign.");
      break;
    case Shared::some:
      notes.emplace_back("Some readings are in both runs.");
      break;
    case Shared::none:
      notes.push_back(
          fmt::format("The runs are of different readings, so that {} have standard deviations.",
                      arms == ComparedArms::one ? "changes" : "differences"));
      break;
    case Shared::unknown:
      notes.emplace_back(
          "The files do not tell whether the runs are of the same readings; they are taken as of "
          "other ones.");
      break;
  }
  if (before.nominal.empty() || after.nominal.empty())
    notes.emplace_back("The files do not tell from which robot file each run started.");
  else
    notes.emplace_back(before.nominal == after.nominal
                           ? "Both started from the same robot file."
                           : "They started from different robot files.");
  if (!before.command.empty() && !after.command.empty()) {
    const std::string one = before.command + " " + before.version,
                      other = after.command + " " + after.version;
    notes.push_back(one == other ? fmt::format("Both were made by {}.", one)
                                 : fmt::format("They were made by {} and {}.", one, other));
  }
  if (before.robot && after.robot && before.robot->name != after.robot->name)
    notes.push_back(
        fmt::format("The robots are called {} and {}.", before.robot->name, after.robot->name));
  if (before.spread && after.spread)
    notes.push_back(
        fmt::format("The calibrations leave residuals of {} {} and {} {}, per axis (RMS).",
                    mm(before.spread->position), behind_figure(InRuns::before, arms),
                    mm(after.spread->position), behind_figure(InRuns::after, arms)));
  return notes;
}

std::optional<bool> RunComparison::arm_moved() const {
  if (!untested.empty() || tested == 0 || !undecided().empty()) return std::nullopt;
  return arm_as_a_whole_moved(*this) || number_of_arm_moved(*this);
}

std::optional<double> RunComparison::smallest_seen() const {
  if (!arm) return std::nullopt;
  if (by_readings && by_readings->times_seen > 0)
    return std::max(arm->rms / std::sqrt(by_readings->times_seen), arm->by_chance.value_or(0));
  return arm->smallest_seen;
}

std::string RunComparison::undecided() const {
  if (!untested.empty() || !arm) return "";
  if (is_of_scale(*this))
    return fmt::format(
        "all lengths of the {} differ by one ratio, {:.3g} um in each metre: {}; measure a length "
        "that is known, or give the instrument's scale before calibrating",
        arms == ComparedArms::one ? "arm" : "arms", arm->scale->ratio / 1e-6,
        arms == ComparedArms::one
            ? "the instrument has another scale, or the arm another temperature"
            : "the instruments have different scales, or the arms different temperatures");
  if (by_readings || !arm->is_undecided() || number_of_arm_moved(*this)) return "";
  return fmt::format(
      "the arms differ by {} RMS, more than the noise of the readings makes; the models lack "
      "something, and only a {} above {} would stand out from that. Put the files of "
      "readings where they stood when both were calibrated{}, or compare models of close-loop that "
      "lack less",
      mm(arm->rms), arms == ComparedArms::one ? "change" : "difference",
      mm(arm->smallest_seen.value()),
      arms == ComparedArms::one ? ", ask trace-residual --since" : "");
}

std::string why_not_comparable(const Robot& before, const std::string& name_before,
                               const Robot& after, const std::string& name_after) {
  constexpr double kOtherConvention = 5 * kDegree;  // no calibration turns a frame so far
  const KinematicChain &a = before.chain, &b = after.chain;
  const std::string remedy =
      "; compare two calibrations of one robot file, or bring both into one form first "
      "(convert-robot)";
  if (encoder_columns(a) != encoder_columns(b))
    return fmt::format("{} has the joints {}, and {} the joints {}: give two models of one arm",
                       name_before, encoder_columns(a), name_after, encoder_columns(b));
  if (link_count(a) != link_count(b))
    return fmt::format("{} has {} links, and {} has {}{}", name_before, link_count(a), name_after,
                       link_count(b), remedy);
  for (int j = 0; j < link_count(a); ++j) {
    const Link &one = a.links[j], &other = b.links[j];
    if (one.name != other.name)
      return fmt::format("link {} is {} in {} and {} in {}{}", j + 1, one.name, name_before,
                         other.name, name_after, remedy);
    if (one.joint != other.joint || one.sign != other.sign)
      return fmt::format("joint or sign of {} differ between {} and {}{}", one.name, name_before,
                         name_after, remedy);
    const auto apart = [](double x, double y) {
      return std::abs(std::remainder(x - y, 2 * std::numbers::pi));
    };
    for (const auto& [what, x, y] :
         {std::tuple("alpha", one.alpha, other.alpha), std::tuple("theta", one.theta, other.theta),
          std::tuple("beta", one.beta, other.beta)})
      if (apart(x, y) > kOtherConvention)
        return fmt::format(
            "{}.{} is {:.4g} deg in {} and {:.4g} deg in {}, as in two conventions or of two "
            "arms{}",
            one.name, what, x / kDegree, name_before, y / kDegree, name_after, remedy);
  }
  return "";
}

std::array<int, 2> moved_of_tested(const RunComparison& found) {
  std::array<int, 2> count{0, 0};
  for (const ComparedParameter& parameter : found.parameters) {
    if (!parameter.of_arm || !parameter.number.p_value) continue;
    count[0] += parameter.number.moved() ? 1 : 0;
    ++count[1];
  }
  return count;
}

RunComparison compare_runs(const ComparedRun& before, const ComparedRun& after,
                           const NamedPoses& poses, ComparedArms arms) {
  RunComparison found;
  found.arms = arms;
  found.readings = shared_readings(before, after);
  if (before.errors && after.errors) found.errors = {*before.errors, *after.errors};
  const bool has_robots = before.robot && after.robot;
  found.effects = compared_effects(before, after);
  if (has_robots) {
    found.parameters = compared_parameters(before, after);
    found.held_apart = held_apart(*before.robot, *after.robot);
    found.remainder = compared_remainder(*before.robot, *after.robot);
  }
  found.untested = why_untested(before, after, found);
  if (found.untested.empty()) test_numbers(before, after, found);
  if (!has_robots) {
    found.sentence = found.errors
                         ? sentence_of_errors(before.errors.value(), after.errors.value(), arms)
                         : std::string();
    found.sentence += sentence_of_effects(found.effects, arms);
    return found;
  }
  const std::vector<JointVector> at =
      poses.q.empty() ? poses_of_both(*before.robot, *after.robot) : poses.q;
  found.arm = arm_difference(*before.robot, *after.robot, at);
  if (!poses.names.empty()) found.largest_pose = poses.names[found.arm->largest];
  if (found.untested.empty() && found.readings == Shared::none && before.campaign &&
      after.campaign && before.spread && after.spread)
    found.by_readings = readings_difference(*before.robot, {before.campaign, *before.spread},
                                            *after.robot, {after.campaign, *after.spread});
  if (!found.untested.empty()) {  // by the same reasons
    found.arm->p_value.reset();
    found.arm->by_chance.reset();
    found.arm->p_value_of_noise.reset();
    found.arm->smallest_seen.reset();
    found.arm->scale.reset();
  }
  for (ComparedParameter& parameter : found.parameters)
    if (parameter.of_arm && parameter.number.moved()) {
      const Robot changed = with_change(*before.robot, parameter);
      parameter.at_tool = mean_arm_difference(*before.robot, changed, at);
      parameter.left_beside = mean_arm_difference(changed, *after.robot, at);
    }
  found.sentence = sentence_of_arm(found, has_nominal(before, after), after.robot->chain);
  if (arms == ComparedArms::one) found.sentence += hidden_in_words(*found.arm);
  if (found.errors) found.sentence += " " + sentence_of_errors(*before.errors, *after.errors, arms);
  return found;
}

}  // namespace armtrue
