#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "armtrue/compensation/compensation.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

struct NoteText {
  CommandNote note;
  const char* word;
  const char* remedy;
};

constexpr NoteText kNoteTexts[] = {
    {CommandNote::unreachable, "unreachable",
     "left as programmed: the arm does not reach them; move them"},
    {CommandNote::limit, "limit", "left as programmed: a joint would leave its travel; move them"},
    {CommandNote::beyond_max, "beyond-max",
     "left as programmed: the correction is larger than --max-mm; check --controller and --robot"},
    {CommandNote::singular, "singular",
     "near a singular posture, the correction damped as far as it was large; bend the wrist more"},
    {CommandNote::outside_readings, "outside-readings",
     "outside what was measured; measure poses near them"},
    {CommandNote::below_std, "below-std", "with a correction smaller than its standard deviation"},
    {CommandNote::turn, "turn", "with a joint that crosses zero: its turn changes"},
    {CommandNote::arrival, "arrival", "where the correction reverses the arrival of a joint"},
    {CommandNote::fewer_axes, "fewer-axes",
     "corrected in what the axes of the arm can do, the position first; what is predicted after "
     "the correction is the rest"},
};

const NoteText& text_of(CommandNote note) {
  return *std::ranges::find_if(kNoteTexts, [&](const NoteText& t) { return t.note == note; });
}

double mean_of(const std::vector<CorrectedTarget>& targets, auto value) {
  double sum = 0;
  for (const CorrectedTarget& target : targets) sum += value(target);
  return sum / static_cast<double>(targets.size());
}

}  // namespace

std::string to_string(CommandNote note) { return text_of(note).word; }

const std::vector<CommandNote>& command_notes() {
  static const std::vector<CommandNote> all = [] {
    std::vector<CommandNote> notes;
    for (const NoteText& text : kNoteTexts) notes.push_back(text.note);
    return notes;
  }();
  return all;
}

bool CorrectedTarget::has(CommandNote note) const {
  return std::ranges::find(notes, note) != notes.end();
}

double CorrectedTarget::expected() const {
  return std::hypot(after.position, deviation.value_or(0));
}

int count_of(const std::vector<CorrectedTarget>& targets, CommandNote note) {
  return static_cast<int>(
      std::ranges::count_if(targets, [&](const CorrectedTarget& t) { return t.has(note); }));
}

std::vector<int> worst_targets(const std::vector<CorrectedTarget>& targets, int count) {
  std::vector<int> rows(targets.size());
  std::iota(rows.begin(), rows.end(), 0);
  const auto rank = [&](int row) {
    const CorrectedTarget& target = targets[row];
    return std::tuple(-target.expected(), -target.before.position, row);
  };
  std::ranges::sort(rows, {}, rank);
  rows.resize(std::min(rows.size(), static_cast<size_t>(count)));
  return rows;
}

bool need_no_correction(const std::vector<CorrectedTarget>& targets) {
  constexpr double kNoError = 1e-9;  // [m], [rad]
  return std::ranges::all_of(targets, [](const CorrectedTarget& t) {
    return std::max(t.before.position, t.before.orientation) < kNoError;
  });
}

std::string compensation_sentence(const std::vector<CorrectedTarget>& targets) {
  if (need_no_correction(targets))
    return fmt::format(
        "None of {} targets needs a correction: the controller already runs the model of the arm.",
        targets.size());
  const auto corrected = std::ranges::count_if(targets, &CorrectedTarget::is_corrected);
  std::string text = fmt::format(
      "{} of {} targets are corrected; the mean predicted error is {:.3g} mm without and {:.3g} mm "
      "with the corrections",
      corrected, targets.size(),
      mean_of(targets, [](const CorrectedTarget& t) { return t.before.position; }) / kMillimetre,
      mean_of(targets, [](const CorrectedTarget& t) { return t.expected(); }) / kMillimetre);
  if (targets.front().deviation)
    text += ", standard deviations included";
  else
    text += ", if the model is exact: how well it is known, the robot file does not say";
  for (const NoteText& note : kNoteTexts)
    if (const int count = count_of(targets, note.note); count > 0)
      text += fmt::format("; {} ({}) {}", count, note.word, note.remedy);
  return text + ".";
}

}  // namespace armtrue
