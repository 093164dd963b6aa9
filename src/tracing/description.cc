#include "armtrue/tracing/description.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "armtrue/effects/flange_or_tool.h"
#include "armtrue/effects/gravity_basis.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "armtrue/tracing/verdict.h"

namespace armtrue {
namespace {

// "0.8 mrad", "0.3 mm", "12 ppm".
std::string size_text(const Robot& robot, const Parameter& parameter, double value) {
  const DisplayUnit unit = display_unit(robot.chain, parameter);
  return fmt::format("{:.3g} {}", value / unit.si, unit.name);
}

std::string driver_text(const Effect& effect, double value, const Robot& robot) {
  if (is_travel(effect.driver, robot.chain)) return fmt::format("{:.0f} mm", value / kMillimetre);
  switch (effect.driver.kind) {
    case DriverKind::joint_angle:
      return fmt::format("{:.0f} deg", value / kDegree);
    case DriverKind::time:
      return fmt::format("{:.0f} s", value);
    default:
      return fmt::format("{:.1f} degC", value);
  }
}

// "37.41 +- 0.03 cycles per turn, amplitude 0.21 +- 0.04 mrad, phase 41 deg".
std::string cycle_text(const Effect& effect, const Cycle& cycle, const Robot& robot) {
  const double unit = display_unit(robot.chain, effect.parameter).si;
  const double half_width = 0.5 * (cycle.amplitude_ci95[1] - cycle.amplitude_ci95[0]);
  std::string frequency = fmt::format("{:g}", effect.shape.harmonic);
  if (cycle.frequency_std > 0) {
    const double of_frequency = 0.5 * (cycle.frequency_ci95[1] - cycle.frequency_ci95[0]);
    const int digits =
        static_cast<int>(std::clamp(std::ceil(1 - std::log10(of_frequency)), 0.0, 6.0));
    frequency = fmt::format("{:.{}f} +- {:.2g}", effect.shape.harmonic, digits, of_frequency);
  }
  if (is_length(effect.driver, robot.chain))
    return fmt::format("one cycle in {:.5g} mm, amplitude {:.3g} +- {:.2g} {}, phase {:.0f} deg",
                       kTurn / effect.shape.harmonic / kMillimetre, cycle.amplitude / unit,
                       half_width / unit, amplitude_unit(effect, robot), cycle.phase / kDegree);
  return fmt::format("{} cycles per turn, amplitude {:.3g} +- {:.2g} {}, phase {:.0f} deg",
                     frequency, cycle.amplitude / unit, half_width / unit,
                     amplitude_unit(effect, robot), cycle.phase / kDegree);
}

// "a step of 0.33 mrad between 1580 and 1660 s", "a kink between 31 and 35 deg".
std::string step_text(const TracedEffect& step, const Robot& robot) {
  const std::vector<Coefficient>& c = step.effect.coefficients;
  const bool sized = c.size() == 1 && step.effect.shape.kind == ShapeKind::step;
  const std::string size =
      sized ? " of " + size_text(robot, step.effect.parameter, c.front().value) : "";
  const auto [low, high] = *step.step_ci95;
  const Driver& driver = step.effect.driver;
  const bool angle = is_angle_or_travel(driver.kind), travel = is_travel(driver, robot.chain);
  const double unit = travel ? kMillimetre : angle ? kDegree : 1.0;
  return fmt::format("a {}{} between {:.0f} and {:.0f} {}", to_string(step.effect.shape), size,
                     low / unit, high / unit,
                     travel  ? "mm"
                     : angle ? "deg"
                             : "s");
}

// "a step of 0.33 mrad since session 'day 2'".
std::string session_step_text(const Effect& step, const Robot& robot) {
  const std::vector<Coefficient>& c = step.coefficients;
  return fmt::format(
      "a step{} since session '{}'",
      c.size() == 1 ? " of " + size_text(robot, step.parameter, c.front().value) : "",
      first_session_after(step));
}

// The curve of an effect in words: "0.8 mrad peak at 90 deg, even".
std::string course(const Effect& effect, const std::vector<CurvePoint>& curve, const Robot& robot) {
  if (curve.empty()) return "";
  const auto peak =
      std::max_element(curve.begin(), curve.end(), [](const CurvePoint& a, const CurvePoint& b) {
        return std::abs(a.value) < std::abs(b.value);
      });
  std::string text = fmt::format("{} at {}", size_text(robot, effect.parameter, peak->value),
                                 driver_text(effect, peak->driver, robot));
  if (effect.driver.kind != DriverKind::joint_angle) return text;
  double even = 0, odd = 0;
  for (size_t i = 0; i < curve.size(); ++i) {
    const double a = curve[i].value, b = curve[curve.size() - 1 - i].value;
    even += (a + b) * (a + b);
    odd += (a - b) * (a - b);
  }
  const bool about_zero = std::abs(curve.front().driver + curve.back().driver) <
                          0.1 * (curve.back().driver - curve.front().driver);
  if (about_zero && even > 9 * odd) text += ", even";
  if (about_zero && odd > 9 * even) text += ", odd";
  if (const auto cycle = strongest_cycle(curve))
    text += fmt::format(", of which {:.0f} % is a cycle of {} and {}", 100 * cycle->share,
                        is_travel(effect.driver, robot.chain)
                            ? fmt::format("{:.4g} mm", kTurn / cycle->per_turn / kMillimetre)
                            : fmt::format("{:.4g} per turn", cycle->per_turn),
                        size_text(robot, effect.parameter, cycle->amplitude));
  return text;
}

void replace(std::string& text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  if (at != std::string::npos) text.replace(at, from.size(), to);
}

// "3", "3 (elbow)"; "E1" of an external axis.
std::string axis_name(const Robot& robot, int joint) {
  return joint < 0 ? "0" : joint_names(robot.chain)[joint].words;
}

// The joint that an effect acts on; 0 if on none.
std::string joint_of(const TracedEffect& traced, const Robot& robot) {
  const auto parameter = find_parameter(robot.chain, traced.effect.parameter);
  if (!parameter || !layout_of(robot.chain).is_of_links(*parameter)) return "0";
  const int link = link_of_parameter(*parameter);
  const int joint = joint_of_link(robot.chain, link);
  const Link& own = robot.chain.links[link];
  if (!own.has_encoder) return own.name;
  return joint < 0 ? std::to_string(link + 1) : axis_name(robot, joint);
}

// An effect is added only if training poses that were left out gain by it.
std::string of_prediction(const HeldOutGain* gain) {
  if (!gain || gain->ci95[0] > 0) return "prediction improves";
  return "prediction improves for training poses left out, not clearly for the held-out ones";
}

// Whose motion it is, where no cause is known.
std::string moved_in_words(const Rival& rival) {
  switch (moved_by(rival)) {
    case Moved::arm:
      return "the arm itself";
    case Moved::station:
      return "the station or the foot of the arm";
    case Moved::fastened:
      break;
  }
  return "the tool or a target";
}

std::set<std::string> names_of(const std::vector<Effect>& effects) {
  std::set<std::string> names;
  for (const Effect& effect : effects) names.insert(to_string(effect.parameter));
  return names;
}

std::string statement(const TracedEffect& effect, const HeldOutGain* gain) {
  if (!effect.beaten_cause.empty())
    return of_prediction(gain) + "; a curve that no listed cause explains: '" +
           effect.beaten_cause + "' comes nearest, and a curve without a name explains far more";
  if (!effect.from_catalogue) return of_prediction(gain) + "; no known cause";
  if (is_polynomial(effect.effect.shape))
    return of_prediction(gain) + "; a polynomial describes it and shows no cause";
  if (effect.incomplete)
    return "incomplete: what it leaves still follows the same driver, see the other effect on it";
  if (!effect.shared_with.empty())
    return of_prediction(gain) + "; shown for its family as a whole, for no member alone";
  if (effect.indistinguishable.empty())
    return "cause shown: no other candidate explains these readings";
  return of_prediction(gain) + "; cause is one of the class under indistinguishable";
}

// Of which effects it is not known whether they are the arm's, in a sentence, if no cause has a
// rival.
std::string only_doubtful(const std::vector<TracedEffect>& effects) {
  std::vector<std::string> of_instrument, of_tool;
  for (const TracedEffect& traced : effects) {
    if (!traced.shared_with.empty() ||
        std::ranges::any_of(traced.indistinguishable, [&](const Rival& rival) {
          return is_other_cause(traced.effect, rival);
        }))
      return "";
    if (traced.effect.may_be_instrument) of_instrument.push_back(describe(traced.effect));
    if (is_of_flange_or_tool(traced.effect)) of_tool.push_back(describe(traced.effect));
  }
  std::vector<std::string> sentences;
  if (!of_instrument.empty())
    sentences.push_back("these poses cannot tell whether it is the arm that moves where " +
                        listed(of_instrument) + ": programs are not corrected by that");
  if (!of_tool.empty())
    sentences.push_back("one tool cannot tell whether the flange gives way or the tool where " +
                        listed(of_tool) +
                        ": only programs of the measured tool (--tool-is-measured) are corrected "
                        "by that");
  return fmt::format("{}", fmt::join(sentences, "; "));
}

}  // namespace

std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (size_t k = 0; k < items.size(); ++k)
    text += (k == 0 ? "" : k + 1 < items.size() ? ", " : " and ") + items[k];
  return text;
}

std::string unidentifiable(const TracedEffect& traced, const Rival& rival) {
  const double apart = std::sqrt(std::max(0.0, 1.0 - rival.correlation * rival.correlation));
  std::string text = fmt::format(
      "more of '{}' and less of '{}'{}: they differ here by {:.2g} % of their size",
      describe(traced.effect), describe(rival.effect),
      rival.refitted.empty() ? "" : ", with " + listed(rival.refitted) + " refitted", 100 * apart);
  std::vector<std::string> readings;
  for (const std::string& reading : {traced.separated_by, rival.separated_by})
    if (!reading.empty() && (readings.empty() || readings.front() != reading))
      readings.push_back(reading);
  if (!readings.empty()) text += "; readings that separate them: " + readings.front();
  if (readings.size() > 1) text += "; or " + readings.back();
  return text;
}

std::string amplitude_unit(const Effect& effect, const Robot& robot) {
  const ParameterUnit moved = unit_of_parameter(robot.chain, effect.parameter);
  const std::string unit = display_unit(moved).name;
  const Driver& driver = effect.driver;
  const std::string of_factor =
      driver.factor ? unit_of(robot.chain, *driver.factor, driver.second_joint, moved) : "";
  return of_factor.empty() ? unit : unit + " per " + of_factor;
}

std::string in_words(const TracedEffect& traced, const HeldOutGain* gain,
                     const std::vector<CurvePoint>& curve, const Robot& robot) {
  const std::string words = traced.cycle       ? cycle_text(traced.effect, *traced.cycle, robot)
                            : traced.step_ci95 ? step_text(traced, robot)
                            : traced.effect.driver.kind == DriverKind::session
                                ? session_step_text(traced.effect, robot)
                                               : course(traced.effect, curve, robot);
  std::string text = to_string(traced.effect.parameter) + " depends on " + to_string(traced.effect.driver) +
                     (words.empty() ? "" : ", " + words) + "; " + statement(traced, gain);
  // A step of the base is a knock of the instrument, not a property of the robot.
  const Effect& effect = traced.effect;
  if (owner_of(effect) == Owner::base && effect.driver.kind == DriverKind::time &&
      effect.shape.kind == ShapeKind::step)
    text += "; --new-session-at-s " + number_text(traced.effect.shape.at) +
            " begins a new session there";
  const DriverKind driver = traced.effect.driver.kind;
  if ((driver == DriverKind::gravity_torque || driver == DriverKind::moment) &&
      !robot.bodies.empty())
    text += "; intervals take the masses of the robot file as exact";
  if (has_gravity_basis(effect))
    text +=
        "; the robot file has no masses, so the coefficients contain them and are no compliances";
  return text;
}

std::string for_the_cell(const TracedEffect& traced, const HeldOutGain* gain, const Robot& robot) {
  std::string text = traced.in_words;
  if (text.empty()) {
    text = to_string(traced.effect.parameter) + " follows " + to_string(traced.effect.driver) +
           " along a curve that no listed cause explains";
  } else {
    replace(text, "{j}", joint_of(traced, robot));
    const Driver& driver = traced.effect.driver;
    replace(text, "{k}", axis_name(robot, driver.joint < 0 ? driver.second_joint : driver.joint));
    if (traced.effect.driver.kind == DriverKind::session) {
      replace(text, "during the campaign", "between two sessions");
      text += fmt::format(": it stands otherwise since session '{}'",
                          first_session_after(traced.effect));
    }
    if (traced.cycle) {
      const double unit = display_unit(robot.chain, traced.effect.parameter).si;
      text += fmt::format(", {:.3g} {}", traced.cycle->amplitude / unit,
                          amplitude_unit(traced.effect, robot));
    }
  }
  std::vector<std::string> others;
  std::set<std::string> told;
  for (const Rival& rival : traced.indistinguishable)
    if (is_other_cause(traced.effect, rival) && others.size() < 2 &&
        told.insert(rival.from_catalogue ? rival.effect.name : moved_in_words(rival)).second)
      others.push_back(rival.from_catalogue
                           ? "'" + rival.effect.name + "' of " + to_string(rival.effect.parameter)
                           : moved_in_words(rival) + " (" + to_string(rival.effect.parameter) +
                                 ")");
  for (const Rival& rival : traced.indistinguishable)
    if (!traced.in_words.empty() && others.empty() &&
        is_unlisted_cause(robot.chain, traced.effect, rival))
      others.push_back(to_string(rival.effect.parameter) + " follows " +
                       to_string(rival.effect.driver) + " for a cause that is not listed");
  if (!others.empty()) text += "; or " + listed(others) + ": these poses cannot tell which";
  if (std::set<std::string> members = names_of(traced.shared_with); !members.empty())
    text += "; or " + listed({members.begin(), members.end()}) +
            ", or all of these: these poses cannot tell how much each";
  if (traced.effect.may_be_instrument) text += "; may be the instrument";
  if (gain && !gain->confirmed()) text += " (not confirmed on held-out poses)";
  return text;
}

namespace {

// The held-out error, and that of parts of the readings or of the model.
std::string errors_in_words(const LoopResult& result) {
  const bool held_out = result.held_out_poses > 0;
  const std::string floor = result.noise.source == NoiseFloor::Source::none
                                ? "unknown"
                                : fmt::format("{:.3g} mm", result.floor / kMillimetre);
  std::string text =
      held_out ? fmt::format("held-out error {:.3g} -> {:.3g} mm, {:+.0f} %, floor {}",
                             result.before / kMillimetre, result.after / kMillimetre,
                             100 * (result.after / std::max(result.before, 1e-300) - 1), floor)
               : fmt::format("no poses held out, floor {}", floor);
  if (result.rejected) text += "; effects predict worse and are left out";
  if (const size_t effects = result.without_gain.size(); effects > 0)
    text += fmt::format("; {} that held-out poses do not support {} left out",
                        counted(effects, "found effect"), effects == 1 ? "is" : "are");
  if (result.applied && held_out)
    text += fmt::format("; {:.3g} mm without what has no name", result.after_named / kMillimetre);
  std::vector<std::string> wrong;
  if (const size_t rows = result.contradicted_rows.size(); rows > 0)
    wrong.push_back(fmt::format("{} that the others of {} contradict",
                                counted(rows, "held-out reading"),
                                rows == 1 ? "its pose" : "their poses"));
  if (result.are_blunders)
    wrong.push_back(fmt::format("{} that {} off as blunders of the training poses are",
                                counted(result.gross_held_out.size(), "held-out pose"),
                                result.gross_held_out.size() == 1 ? "is" : "are"));
  if (!wrong.empty())
    text += fmt::format("; {:.3g} mm without {}", result.after_sound / kMillimetre, listed(wrong));
  if (const size_t rows = result.not_judged_rows.size(); rows > 0)
    text += fmt::format("; {} at a step in time may be of either side and {} not judged",
                        counted(rows, "held-out reading"), rows == 1 ? "is" : "are");
  if (result.after_arm && *result.after_arm > kCountsAsWorse * result.after)
    text += fmt::format("; {:.3g} mm with the arm alone, without what station and tool do",
                        *result.after_arm / kMillimetre);
  if (result.after_readings && kCountsAsWorse * *result.after_readings < result.after)
    text += fmt::format(
        "; {:.3g} mm of the readings, if what follows the time or the ways of this campaign "
        "is taken off, too",
        *result.after_readings / kMillimetre);
  return text;
}

std::string not_separable_in_words(const LoopResult& result) {
  const std::vector<TracedEffect>& effects = result.trace.effects;
  if (std::string doubtful = only_doubtful(effects); !doubtful.empty()) return doubtful;
  const auto shared = std::ranges::find_if(
      effects, [](const TracedEffect& traced) { return !traced.shared_with.empty(); });
  if (shared != effects.end())
    return fmt::format("'{}' is there, but these poses cannot tell in which parts",
                       shared->effect.family->name);
  return "the cause is one of several that these poses cannot distinguish";
}

std::string wandering_in_words(const std::vector<Parameter>& wandering) {
  std::vector<std::string> names;
  for (const Parameter& parameter : wandering) names.push_back(to_string(parameter));
  return fmt::format(
      "{} {} again and again during the campaign, which is no event: friction that remembers, or "
      "something slips. Programs are not corrected by it; drive to one pose from several others to "
      "see it",
      listed(names), names.size() == 1 ? "changes" : "change");
}

std::string unexplained_in_words(const LoopResult& result) {
  constexpr double kUnlikely = 0.01;  // p, as for the verdict
  if (!result.wrong_readings.empty())
    return "but " + result.wrong_readings + "; do not correct programs with this result";
  if (result.angles_read_early)
    return "the joint angles were not read at standstill, so the result is the geometry: measure "
           "again, with the angles at which the arm stands";
  if (const auto& left_out = result.trace.left_out)
    return fmt::format(
        "the rest is of {} that 'identify' leaves out: with them {:.3g} mm of {:.3g} "
        "would be left in the training poses",
        counted(left_out->parameters.size(), "parameter"), left_out->with / kMillimetre,
        left_out->without / kMillimetre);
  if (!result.explanation.empty())
    return "a change among the readings explains what is left: " + result.explanation +
           (result.moved ? "; do not correct programs with this result" : "");
  if (!result.wandering.empty()) return wandering_in_words(result.wandering);
  if (result.outside_p < kUnlikely && !result.gross_held_out.empty() && !result.are_blunders)
    return fmt::format(
        "{} of {} held-out poses {} wrong as {}, and hardly any training pose is: look at their "
        "readings, or the model lacks something that the training poses do not show",
        result.gross_held_out.size(), result.held_out_poses,
        result.gross_held_out.size() == 1 ? "is" : "are",
        result.gross_held_out.size() == 1 ? "a whole" : "wholes");
  if (result.outside_p < kUnlikely)
    return "held-out poses lie beyond their predicted bounds: the model lacks something that the "
           "training poses do not show";
  if (result.trace.pattern_remains)
    return fmt::format("what is left is no noise, p {:.2g}: {}", result.trace.remaining_p,
                       result.pattern);
  const auto curve = std::ranges::find_if(result.trace.effects, is_curve_of_time);
  if (curve != result.trace.effects.end())
    return describe(curve->effect) +
           ", a curve that no listed cause explains: it holds for the time of these readings, "
           "and nobody knows what it does on another day";
  const bool fits = !(result.lack_of_fit && *result.lack_of_fit < kUnlikely);
  if (fits && !result.left_out_together.empty()) return result.left_out_together;
  if (fits && !result.unconfirmed_curve.empty())
    return "held-out poses do not confirm that " + result.unconfirmed_curve +
           ", a curve that no listed cause explains";
  return result.noise.source == NoiseFloor::Source::replicates
             ? "a rest remains that no listed cause explains"
             : "unexplained, or the instrument is noisier than stated";
}

std::string conclusion_in_words(const LoopResult& result) {
  switch (result.verdict) {
    case Verdict::closed:
      return "nothing is left that these poses could show";
    case Verdict::nothing_to_explain:
      return "nothing to explain: what is left is noise";
    case Verdict::not_separable:
      return not_separable_in_words(result);
    case Verdict::too_few_poses:
      if (result.all_from_few)
        return fmt::format(
            "too few poses to hold any out, so nothing is known of others: measure some {} more",
            result.more_poses);
      return fmt::format("too few poses to explain the rest: measure some {} more",
                         result.more_poses);
    case Verdict::unknown_noise:
      return "neither repeats nor the robot file say how large the noise is, so nothing shows "
             "whether more than noise is left";
    case Verdict::unexplained:
      break;
  }
  return unexplained_in_words(result);
}

}  // namespace

std::string verdict_in_words(const LoopResult& result) {
  return errors_in_words(result) + "; " + conclusion_in_words(result);
}

std::string rejection_in_words(const LoopResult& result) {
  if (!result.rejected) return "";
  const RejectedModel& rejected = *result.rejected;
  return fmt::format(
      "with effects ({}{}) held-out poses are predicted worse than by the geometry alone, {:.4g} "
      "mm against {:.4g} (worse by {:.2g} to {:.2g} mm, 95 %): the result is the geometry, and "
      "none of them is written",
      rejected.effects.front(),
      rejected.effects.size() > 1 ? fmt::format(" and {} more", rejected.effects.size() - 1) : "",
      rejected.after / kMillimetre, result.before / kMillimetre,
      -rejected.gain_ci95[1] / kMillimetre, -rejected.gain_ci95[0] / kMillimetre);
}

std::string unknown_noise_in_words(const LoopResult& result) {
  if (result.noise.source != NoiseFloor::Source::none || result.after < kFinestReading) return "";
  return fmt::format(
      "neither repeats nor 'noise' of the robot file say how large the noise is: {:.4g} mm may be "
      "noise or something the model lacks; visit poses twice, or state noise: {}",
      result.after / kMillimetre, result.of_images ? "pixel_px" : "position_mm");
}

std::string describe(const Effect& effect) {
  return to_string(effect.parameter) + " follows " + to_string(effect.driver) + " (" +
         to_string(effect.shape) + ")";
}

}  // namespace armtrue
