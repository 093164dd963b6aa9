#include "pass_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/kinematics/pose.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/path/mirror/pass_doubts.h"
#include "armtrue/path/mirror/record_doubts.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"

namespace armtrue::app {
namespace {

// Count, lines and distances of the bad samples.
std::string describe_bad(const PathFile& pass, const std::vector<BadSample>& bad) {
  constexpr size_t kNamed = 5;
  std::string text = fmt::format(
      "{}:{}: {} of {} samples are no readings of the tool, which does not move so:", pass.source,
      pass.line[bad.front().sample], bad.size(), pass.path.samples());
  for (size_t i = 0; i < std::min(bad.size(), kNamed); ++i)
    text += fmt::format("{} line {} ({:.4g} mm off)", i > 0 ? "," : "", pass.line[bad[i].sample],
                        bad[i].off / kMillimetre);
  return text + (bad.size() > kNamed ? ", ..." : "");
}

constexpr double kMaxAlong = 2e-3;  // [m], off its place along the path

// Why a record does not show the places of the program at their times; empty if it does. A
// correction that belongs elsewhere on the path is wrong at corners by as much as it is off. An
// arm that errs along the path errs across it too, unless the path is straight.
std::string why_out_of_time(const PathFile& programmed, const PathFile& record,
                            const RecordDoubts& doubts, const ClockOptions& options) {
  if (doubts.pause && !is_straight(programmed.path, kMaxAlong))
    return record.source + ": the tool " + in_words(*doubts.pause);
  if (!doubts.lag) return "";
  const TimeLag& lag = *doubts.lag;
  constexpr double kMaxByArm = 0.02;  // [s], by which it lags more or less in fast motion
  constexpr double kMaxTimesAcross = 4;
  const auto is_of_time = [&](double late) {
    const double along = late * lag.speed;
    return late > kMaxByArm && along > kMaxAlong && along > kMaxTimesAcross * lag.across &&
           !is_straight(programmed.path, along);
  };
  const double spread = lag.latest - lag.earliest;
  const auto aside = is_of_time(spread) ? find_aside(programmed.path, record.path) : std::nullopt;
  if (aside && !options.fit_frame &&
      (aside->explains(lag.spread()) || aside->explains(-lag.spread())))
    return record.source + ": " + in_words(*aside);
  if (is_of_time(spread))
    return fmt::format(
        "{}: does not keep the time of {}: along the path it is {:.3g} s later in one quarter of "
        "the pass than in another, {:.3g} mm at its speed. Was the override not 100 %, did the "
        "pass pause, or are the times of the program not those of the controller? Record the pass "
        "at the programmed speed, or give the program with the times at which it ran",
        record.source, programmed.source, spread, lag.spread() / kMillimetre);
  const double late = std::abs(lag.median);
  if (options.offset && is_of_time(late))
    return fmt::format(
        "{}: with --offset-s {:.6g} the pass is {:.3g} s {} the program, {:.3g} mm along the path; "
        "correct it, or leave it out: then it is fitted",
        record.source, *options.offset, late, lag.median > 0 ? "behind" : "ahead of",
        late * lag.speed / kMillimetre);
  return "";
}

// None is certain: an arm may have the same error all along a path.
void warn_of_record(Command& command, const PathFile& programmed, const PathFile& record,
                    const RecordDoubts& doubts, bool frame_is_fitted,
                    const std::string& consequence) {
  if (doubts.pause && is_straight(programmed.path, kMaxAlong))
    command.warn(record.source + ": the tool " + in_words(*doubts.pause));
  if (doubts.feed) command.warn(record.source + ": the measured path " + *doubts.feed);
  if (doubts.aside) command.warn(record.source + ": " + in_words(*doubts.aside));
  if (doubts.step)
    command.warn(fmt::format(
        "{}:{}: from here on the record lies {:.3g} mm off the samples before: was the instrument "
        "knocked, or does another frame begin? {}; measure the pass again",
        record.source, record.line[doubts.step->sample], doubts.step->moved / kMillimetre,
        consequence));
  // A fitted frame leaves no other motion of the record: what looks like one is the arm's.
  if (doubts.rigid && !frame_is_fitted)
    command.warn(fmt::format(
        "{}: most of the deviation, {:.3g} of {:.3g} mm (rms), is a motion of the whole record by "
        "{:.3g} mm and {:.3g} deg: give --fit-frame, unless the frame of the instrument is that "
        "certain. {}",
        record.source, (doubts.rigid->before - doubts.rigid->after) / kMillimetre,
        doubts.rigid->before / kMillimetre, doubts.rigid->moved / kMillimetre,
        doubts.rigid->turned / kDegree, consequence));
  if (doubts.turned && !frame_is_fitted)
    command.warn(fmt::format(
        "{}: the record is turned by {:.3g} deg about the part: along the path it lies {:.3g} mm "
        "(median) {}, where the tool stands too, as neither its clock nor a lag of the arm leaves "
        "it. Each deviation stands as far from its place; give --fit-frame, or measure the frame "
        "of the instrument again",
        record.source, doubts.turned->turned / kDegree,
        std::abs(doubts.turned->along) / kMillimetre,
        doubts.turned->along > 0 ? "ahead" : "behind"));
  if (doubts.scaled)
    command.warn(fmt::format(
        "{}: the record is {:.3g} % {} than the program, along its way, too, where neither a force "
        "nor a lag of the arm makes it so: is it of a part of another size, or is a scale wrong? "
        "{}",
        record.source, 100 * std::abs(*doubts.scaled), *doubts.scaled > 0 ? "larger" : "smaller",
        consequence));
  if (doubts.open)
    command.warn(fmt::format(
        "{}:{}: the program ends where it starts, and the record from here to line {} ends {:.3g} "
        "mm beside its start; where the tool starts, stops and turns, its deviation changes by "
        "{:.3g} mm in all. Did the instrument drift, or was it or the part moved? {}; measure the "
        "pass again",
        record.source, record.line[doubts.open->first], record.line[doubts.open->last],
        doubts.open->apart / kMillimetre, doubts.open->changes / kMillimetre, consequence));
  if (doubts.other_shape)
    command.warn(fmt::format(
        "{}: deviates by {:.3g} mm (rms), and by {:.3g} mm wherever the whole record is moved to: "
        "an arm errs by less within a part. Is it the record of this program? {}",
        record.source, doubts.other_shape->before / kMillimetre,
        doubts.other_shape->after / kMillimetre, consequence));
  if (doubts.unfollowed)
    command.warn(fmt::format(
        "{}:{}: from here to line {} the program bends by {:.3g} mm (rms), and the record follows "
        "by {:.0f} %: is it the record of this program?",
        record.source, record.line[doubts.unfollowed->first], record.line[doubts.unfollowed->last],
        doubts.unfollowed->shape / kMillimetre, 100 * doubts.unfollowed->followed));
}

// What the digits of a record leave out is no noise, so the forecast does not know it.
void warn_of_steps(Command& command, const std::vector<PathFile>& passes,
                   const MirrorResult& result) {
  const double noise = result.deviation.noise * std::sqrt(passes.size());
  for (const PathFile& pass : passes) {
    const auto step = step_that_hides(pass.path, noise);
    if (!step || *step / 2 <= result.expected_after) continue;
    command.warn(
        fmt::format("{}: its coordinates have steps of {:g} mm, which hide up to {:g} mm of the "
                    "deviation: this is not corrected; record more digits",
                    pass.source, *step / kMillimetre, *step / 2 / kMillimetre));
  }
}

// The mean of passes of different kinds corrects neither kind.
void warn_of_unlike(Command& command, const PathFile& programmed,
                    const std::vector<PathFile>& passes, const MirrorResult& result) {
  std::vector<Path> records;
  for (const PathFile& pass : passes) records.push_back(pass.path);
  const auto unlike = find_unlike_pass(programmed.path, records, result);
  if (!unlike) return;
  command.warn(fmt::format(
      "{}: deviates by {:.3g} mm (rms) from the other passes, and all by {:.3g} mm in the mean: "
      "does one cut air, another depth, or a correction? The mean corrects neither; give passes of "
      "one kind",
      passes[unlike->pass].source, unlike->apart / kMillimetre, unlike->mean / kMillimetre));
}

// A frame that is fitted to the path takes up what of the deviation looks like a motion of it.
void warn_of_uncertain_frame(Command& command, const PathFile& pass, const MirrorResult& result) {
  const double rms = result.frame.rms();
  const bool is_most =
      std::numbers::pi / 4 * result.frame.mean_square > 0.5 * std::pow(result.expected_after, 2);
  constexpr double kFinestCorrection = 0.01e-3;  // [m]: no arm is corrected so finely
  if (!is_most || rms < kFinestCorrection) return;
  command.warn(fmt::format(
      "{}: the frame that --fit-frame fits takes up a part of the deviation: across the path it is "
      "uncertain by {:.3g} mm (rms), most of the {:.3g} mm that are expected after the correction; "
      "measure the frame of the instrument, and leave --fit-frame out",
      pass.source, rms / kMillimetre, result.expected_after / kMillimetre));
}

// A mirrored axis turns the frame of a straight path by half a turn, and that of a flat path over,
// and fits.
void check_frame(Command& command, const PathFile& programmed, const std::vector<PathFile>& passes,
                 const MirrorResult& result) {
  constexpr double kMuchTurned = 5 * kDegree;
  const double off = result.before.rms;
  const bool straight = is_straight(programmed.path, off);
  const auto normal = normal_of_flat(programmed.path, off);
  if (!normal) return;  // a straight path is flat, too
  for (size_t p = 0; p < passes.size(); ++p) {
    const Eigen::Matrix3d& frame = result.passes[p].clock.program_from_instrument.rotation;
    const double turned = rotation_log(frame).norm();
    if (turned <= kMuchTurned) {
      // A frame that happens to be moved by just twice the height of the path is none.
      const std::string mistake = mistaken_columns(programmed.path, passes[p].path);
      if (!mistake.empty())
        throw InputError(fmt::format(
            "{}: lies on {} with {}, without any frame: check the columns of the record and their "
            "signs, and correct them. A fitted frame hides this on a flat path, and the correction "
            "would double the deviation across its plane",
            passes[p].source, programmed.source, mistake));
      continue;
    }
    const std::string found = fmt::format("{}: the fitted frame is turned by {:.3g} deg",
                                          passes[p].source, turned / kDegree);
    if (straight)
      command.warn(
          found +
          ", and a straight path does not show how it is turned about the path, nor whether an "
          "axis has the wrong sign: the correction may point to any side; fit the frame on a path "
          "with corners, or measure it");
    else if (normal->dot(frame * *normal) < 0)
      throw InputError(
          found +
          " and turns the path over: either an axis of the record has the wrong sign, or the "
          "instrument hangs upside down. A flat path does not show which, and the correction "
          "would double the deviation across its plane; correct the sign, or turn the record "
          "by half a turn first");
    else
      command.warn(
          found +
          ", and a flat path does not show whether an axis has the wrong sign: the correction "
          "across its plane may point to the wrong side; fit the frame on a path that leaves its "
          "plane, or measure it");
  }
}

}  // namespace

void refuse_the_same(Command& command, const std::vector<const PathFile*>& files) {
  for (size_t i = 0; i < files.size(); ++i)
    for (size_t k = 0; k < i; ++k) {
      if (files[i]->sha256 != files[k]->sha256 &&
          (files[i]->path.position.cols() != files[k]->path.position.cols() ||
           files[i]->path.position != files[k]->path.position))
        continue;
      const std::string same = files[i]->source + ": holds the same as " + files[k]->source +
                               "; name the program and each record once";
      if (k > 0 || files[i]->sha256 == files[k]->sha256) throw InputError(same);
      command.warn(same);  // a simulated arm may be as exact
    }
}

void refuse_copies(const std::vector<PathFile>& records) {
  for (size_t i = 0; i < records.size(); ++i)
    for (size_t k = 0; k < i; ++k)
      if (const auto first = find_copy(records[i].path, records[k].path))
        throw InputError(fmt::format(
            "{}:{}: from here on it holds the readings of {} from line {} on, noise and all: a "
            "pass that counts twice shows no scatter; name each record once",
            records[i].source, records[i].line[first->first], records[k].source,
            records[k].line[first->second]));
}

void warn_of_interpolated(Command& command, const std::vector<PathFile>& records) {
  for (const PathFile& record : records)
    if (const double share = interpolated_share(record.path); share > 0)
      command.warn(fmt::format(
          "{}: {:.0f} % of the samples lie just on the straight line between their neighbours, and "
          "the others have noise: the record was interpolated, and its noise looks like a motion "
          "of the tool; give the samples that the instrument read",
          record.source, 100 * share));
}

void warn_of_copied(Command& command, const PathFile& programmed,
                    const std::vector<PathFile>& records) {
  for (const PathFile& record : records) {
    std::string names;
    for (const Eigen::Index axis : find_copied_coordinates(programmed.path, record.path))
      names += (names.empty() ? "" : " and ") + record.columns[record.position[axis].column];
    if (!names.empty())
      command.warn(fmt::format(
          "{}: {}: no noise at all, but one value, or those of {} to the last digit, in all {} "
          "samples, so it was not measured. The deviation along it is that of no tool; give what "
          "the instrument recorded",
          record.source, names, programmed.source, record.path.samples()));
    else if (const auto frozen = find_frozen_coordinate(record.path))
      command.warn(
          fmt::format("{}:{}: from here to line {} {} has one value, {:.10g} mm, in {} of {} "
                      "samples, while the other coordinates change: it was not measured there. The "
                      "deviation along it is that of no tool; record the pass again",
                      record.source, record.line[frozen->first], record.line[frozen->last],
                      record.columns[record.position[frozen->axis].column],
                      record.path.position(frozen->axis, frozen->first) / kMillimetre,
                      frozen->last - frozen->first + 1, record.path.samples()));
  }
}

void refuse_corrected(const PathFile& path, const std::string& instead,
                      const std::string& of_mirror) {
  if (!path.corrected_by) return;
  const bool is_mirror = *path.corrected_by == Corrector::mirror;
  throw InputError(fmt::format(
      "{}: the last digits of its positions are those that {} writes: it is a corrected path; give "
      "{}{}",
      path.source, is_mirror ? "mirror-correct" : "compensate", instead,
      is_mirror ? of_mirror : ""));
}

void warn_of_computed(Command& command, const PathFile& programmed,
                      const std::vector<PathFile>& records) {
  for (const PathFile& record : records)
    if (record.sha256 != programmed.sha256 && looks_computed(programmed.path, record.path))
      command.warn(record.source + ": has the times of " + programmed.source +
                   " and no noise, as no instrument records it: is it a corrected path? Give the "
                   "pass that the instrument recorded");
}

void warn_of_bad(Command& command, const PathFile& pass, const std::vector<BadSample>& bad) {
  if (!bad.empty())
    command.warn(describe_bad(pass, bad) + "; left out; check the line of sight of the instrument");
}

void warn_of_bad_kept(Command& command, const PathFile& pass, const std::vector<BadSample>& bad) {
  if (!bad.empty())
    command.warn(describe_bad(pass, bad) +
                 "; they count; if the instrument did not see the tool, empty their position");
}

[[noreturn]] void refuse(const PathFile& pass, const std::vector<BadSample>& bad) {
  throw InputError(describe_bad(pass, bad) +
                   "; that is more than a tenth: measure the pass again with a clear line of "
                   "sight, or empty the position of the rows without one");
}

void warn_of_doubts(Command& command, const PathFile& programmed,
                    const std::vector<PathFile>& passes, const MirrorResult& result,
                    const MirrorOptions& options) {
  for (size_t p = 0; p < passes.size(); ++p) {
    const RecordDoubts doubts = record_doubts(programmed.path, passes[p].path,
                                              result.passes[p].clock, result.passes[p].bad);
    const std::string why = why_out_of_time(programmed, passes[p], doubts, options.clock);
    if (!why.empty()) throw InputError(why);
    warn_of_record(command, programmed, passes[p], doubts, options.clock.fit_frame,
                   "The correction carries that into the part");
  }
  warn_of_steps(command, passes, result);
  warn_of_unlike(command, programmed, passes, result);
  if (options.clock.fit_frame) {
    check_frame(command, programmed, passes, result);
    warn_of_uncertain_frame(command, passes.front(), result);
  }
  if (deviates_against_force(programmed.path, result, options))
    command.warn(
        passes.front().source +
        ": the tool deviates against the force on it, as no arm does: has an axis of the record or "
        "of the force the wrong sign? The correction would double the deviation");
  if (const auto axes = exchanged_forces(programmed.path, result, options))
    command.warn(
        fmt::format("{}: the tool yields to f{}_n along {} and to f{}_n along {}, as no arm does: "
                    "are these columns "
                    "of the force exchanged?",
                    passes.front().source, "xyz"[axes->second], "xyz"[axes->first],
                    "xyz"[axes->first], "xyz"[axes->second]));
  if (options.executed && deviates_as_before(programmed.path, result, *options.executed))
    command.warn(
        passes.front().source +
        ": deviates as the path did before the correction of --previous: did this pass run "
        "that path? If it ran the program, leave --previous out, or the correction counts "
        "twice");
  if (!options.executed && hardly_deviates(result))
    command.warn(fmt::format(
        "{}: deviates by {:.3g} mm (rms), no more than the noise of a sample, {:.3g} mm: did this "
        "pass run a corrected path? Then name that as --previous, or its correction is lost",
        passes.front().source, result.before.rms / kMillimetre,
        result.deviation.noise / kMillimetre));
}

void warn_of_certified(Command& command, const PathFile& commanded,
                       const std::vector<PathFile>& passes, const std::vector<ClockFit>& clocks,
                       const ClockOptions& options) {
  for (size_t p = 0; p < passes.size(); ++p) {
    const RecordDoubts doubts = record_doubts(commanded.path, passes[p].path, clocks[p],
                                              find_bad_samples(commanded.path, passes[p].path));
    warn_of_all(command, {why_out_of_time(commanded, passes[p], doubts, options)});
    warn_of_record(command, commanded, passes[p], doubts, options.fit_frame, "AT contains that");
  }
}

void warn_of_prediction(Command& command, const PathFile& pass, const ForceLine& measured) {
  constexpr double kMostTimes = 3, kLeastShare = 0.2;  // of a model that is only rough, with noise
  if (!measured.k) return;
  const double times = measured.k->value;
  if (times > 1 / kMostTimes && times < kMostTimes && measured.r2 > kLeastShare) return;
  command.warn(
      fmt::format("{}: the tool deviates {:.3g} times as far as --robot predicts from the force, "
                  "which explains "
                  "{:.0f} % of it: check unit and axes of fx_n, fy_n and fz_n, and the robot file",
                  pass.source, times, 100 * std::max(0.0, measured.r2)));
}

void warn_of_force_law(Command& command, const PathFile& pass, const ForceLaw& measured) {
  // mm/N: arms yield by 1e-5 to 1e-2, a small one with a long tool by some hundredths.
  constexpr double kStiffest = 1e-6, kSoftest = 0.1;
  const std::optional<Estimate>& k = measured.magnitude.k;
  if (!k) return;
  const double least = k->ci95[0] / kMillimetre, most = k->ci95[1] / kMillimetre;
  if (least <= 0 || (least <= kSoftest && most >= kStiffest)) return;
  command.warn(
      fmt::format("{}: the tool deviates by {:.3g} mm for each N of the force, and arms by {:g} to "
                  "{:g} mm: are "
                  "fx_n, fy_n and fz_n in N?",
                  pass.source, k->value / kMillimetre, kStiffest, kSoftest));
}

void warn_of_forces(Command& command, const PathFile& programmed, const Eigen::Matrix3Xd& deviation,
                    const MirrorOptions& options) {
  // m: no arm is corrected so finely, and none bends so far under a cut.
  constexpr double kNoBending = 0.01e-3, kMostBending = 0.02;
  const double most = deviation.colwise().norm().maxCoeff();
  const std::string found = fmt::format(
      "{}: the forces, {:.3g} N at most, make the tool deviate by up to {:.3g} mm",
      programmed.source, programmed.path.force.colwise().norm().maxCoeff(), most / kMillimetre);
  if (most < kNoBending)
    command.warn(found + ", which is nothing: are they in N, and has --robot effects of them?");
  if (most > kMostBending)
    command.warn(found + ", as no arm does that cuts: are they in N?");
  else if (most > options.max)
    command.warn(fmt::format("{}, and no correction is longer than {:g} mm (--max-mm)", found,
                             options.max / kMillimetre));
}

void warn_of_gaps(Command& command, const PathFile& programmed, const MirrorResult& result) {
  const double most = 0.5 / result.cutoff;
  if (const double step = longest_step_in_motion(programmed.path); step > most)
    command.warn(fmt::format(
        "{}: moves for {:.3g} s between two of its samples. Between them the correction is "
        "straight, and the forecast does not hold there; give a sample at least every {:.2g} s",
        programmed.source, step, most));
  if (result.unrecorded > 0)
    command.warn(fmt::format(
        "not corrected: {} in motion before or after the record; the "
        "correction grows from nothing in {:.2g} s beside them; record from before the tool moves "
        "until it stands again",
        counted(result.unrecorded, "sample"), 1 / result.cutoff));
  for (const Pass& pass : result.passes)
    if (pass.longest_gap > most)
      command.warn(fmt::format(
          "the record has a gap of {:.2f} s, longer than the correction can follow: there it is "
          "only interpolated",
          pass.longest_gap));
}

void warn_of_clipping(Command& command, const MirrorResult& result, const MirrorOptions& options) {
  constexpr double kLeastShare = 0.05;  // of the deviation: less is no correction
  if (result.clipped == 0) return;
  if (options.max > kLeastShare * result.before.mean)
    command.warn(fmt::format(
        "--max-mm {:g} cuts the correction of {} of {} samples; the rest of their deviation stays. "
        "Give a larger --max-mm if it is that of the tool",
        options.max / kMillimetre, result.clipped, result.position.cols()));
  else
    command.warn(fmt::format(
        "--max-mm {:g} leaves the mean deviation of {:.3g} mm nearly as it is, and cuts the "
        "correction of {}: is it in mm?",
        options.max / kMillimetre, result.before.mean / kMillimetre,
        counted(result.clipped, "sample")));
}

}  // namespace armtrue::app
