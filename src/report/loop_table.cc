#include "armtrue/report/loop_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "armtrue/calibration/doubts.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/tracing/description.h"

namespace armtrue {
namespace {

// Breaks a text at spaces; all lines but the first are indented.
std::vector<std::string> in_lines(const std::string& text, size_t width) {
  std::vector<std::string> lines{""};
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > width)
      lines.push_back("   ");
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

// The share of each effect, and the effects that could be the largest, given these poses.
std::string shares_table(const std::vector<TracedEffect>& effects) {
  if (effects.empty()) return "";
  std::string table = "share of the variance that the effects explain";
  table += effects.size() > 1 ? ", 95 %\n" : "\n";
  std::vector<std::string> leading;
  for (const TracedEffect& traced : effects) {
    const auto& [share, ci95, may_lead] = traced.variance_share;
    table += fmt::format("{:>7.1f} %  ", 100 * share);
    if (effects.size() > 1)
      table += fmt::format("{:>3.0f} to {:>3.0f}  ", 100 * ci95[0], 100 * ci95[1]);
    table += describe(traced.effect) + "\n";
    const std::string place = to_string(traced.effect.parameter) + " by " + to_string(traced.effect.driver);
    if (may_lead && std::find(leading.begin(), leading.end(), place) == leading.end())
      leading.push_back(place);
  }
  if (leading.size() > 1)
    table += "these poses cannot show which explains most: " + listed(leading) + "\n";
  return table;
}

}  // namespace

std::string before_after_table(const LoopResult& result) {
  std::string table = fmt::format("{:<44} {:>6} {:>12} {:>12} {:>12}\n", "stage", "unkn.",
                                  "training", "held-out", "held-out");
  table +=
      fmt::format("{:<44} {:>6} {:>12} {:>12} {:>12}\n", "", "", "mean mm", "mean mm", "max mm");
  const auto if_held_out = [&](double value) {
    return result.held_out_poses > 0 ? fmt::format("{:.4f}", value / kMillimetre) : "-";
  };
  for (const Stage& stage : result.stages) {
    const std::vector<std::string> name = in_lines(stage.name, 44);
    table += fmt::format("{:<44} {:>6} {:>12.4f} {:>12} {:>12}\n", name.front(), stage.parameters,
                         stage.training.position.mean / kMillimetre,
                         if_held_out(stage.held_out.position.mean),
                         if_held_out(stage.held_out.position.max));
    for (size_t k = 1; k < name.size(); ++k) table += name[k] + "\n";
  }
  const bool is_known = result.noise.source != NoiseFloor::Source::none;
  table += fmt::format("{:<44} {:>6} {:>12} {:>12}\n", "noise floor", "", "",
                       is_known ? fmt::format("{:.4f}", result.floor / kMillimetre) : "unknown");
  if (result.worst)
    table += fmt::format("worst held-out pose: '{}', {:.4f} mm after\n", result.worst->pose,
                         result.worst->error / kMillimetre);
  if (const std::string lines = lines_in_words(result.excluded_rows); !lines.empty())
    table += "left out as blunders: " + lines + "\n";
  if (const std::string lines = lines_in_words(result.contradicted_rows); !lines.empty())
    table += "held out, and contradicted by the others of the pose: " + lines + "\n";
  if (const std::string lines = lines_in_words(result.not_judged_rows); !lines.empty())
    table += "held out at a step in time, on either side of it, and not judged: " + lines + "\n";
  table += shares_table(result.trace.effects);
  if (const auto& nested = result.nested)
    table += fmt::format(
        "{:<44} {:>6} {:>12} {:>12.4f} before, {:.4f} after (standard errors {:.4f}, {:.4f})\n",
        fmt::format("nested cross-validation, {} folds", nested->folds), "", "",
        nested->before.mean / kMillimetre, nested->after.mean / kMillimetre,
        nested->before.error / kMillimetre, nested->after.error / kMillimetre);
  for (size_t k = 0; k < result.trace.effects.size(); ++k)
    table +=
        "- " +
        for_the_cell(result.trace.effects[k], k < result.gains.size() ? &result.gains[k] : nullptr,
                     result.trace.fit.robot) +
        "\n";
  table += fmt::format("verdict: {}: {}\n", to_string(result.verdict), verdict_in_words(result));
  return table;
}

}  // namespace armtrue
