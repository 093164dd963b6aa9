#include "armtrue/report/comparison_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "report/comparison_words.h"
#include "report/page.h"

namespace armtrue {
namespace {

std::string moved_cell(const NumberChange& number, const ComparisonWords& words) {
  return !number.p_value ? "-" : number.moved() ? words.moved : "by chance";
}

// Changes of one unit with their 95 % intervals, those farthest from zero first.
Drawing changes_picture(const RunComparison& found, bool of_arm, const std::string& unit_in_files) {
  const ComparisonWords side = words_of(found.arms);
  constexpr size_t kShown = 5;  // more names have no room beside each other
  std::vector<const ComparedParameter*> shown;
  for (const ComparedParameter& parameter : found.parameters)
    if (parameter.of_arm == of_arm && parameter.unit.name == unit_in_files &&
        parameter.in == InRuns::both && parameter.number.change)
      shown.push_back(&parameter);
  const auto clearness = [](const ComparedParameter* parameter) {
    const NumberChange& number = parameter->number;
    return std::abs(*number.change) / number.std.value_or(1);
  };
  std::ranges::stable_sort(shown, std::ranges::greater(), clearness);
  const size_t all = shown.size();
  if (all > kShown) shown.resize(kShown);
  if (shown.empty()) return nullptr;
  const bool is_length = unit_in_files == "mm";
  const double si = is_length ? kMillimetre : kMilliradian;
  const std::string unit = is_length ? "mm" : "mrad";
  double low = 0, high = 0;
  const auto interval = [&](const NumberChange& number) {
    return number.ci95.value_or(std::array{*number.change, *number.change});
  };
  for (const ComparedParameter* parameter : shown) {
    low = std::min(low, interval(parameter->number)[0] / si);
    high = std::max(high, interval(parameter->number)[1] / si);
  }
  if (low == high) return nullptr;
  const std::string of = of_arm ? "arm" : "station";
  auto picture = std::make_shared<Picture>(
      of + (is_length ? "-lengths" : "-angles"),
      found.arms == ComparedArms::two
          ? fmt::format("Difference of the arms: {}", is_length ? "lengths" : "angles")
          : fmt::format("Change of the {}: {}", of, is_length ? "lengths" : "angles"),
      fmt::format("{} minus {}, with the 95 % interval; {} of {}, the clearest first.", side.after,
                  side.before, shown.size(), all),
      Axis{0, static_cast<double>(shown.size()), 1, ""});
  Panel& panel = picture->panel(round_axis(low, high, std::string(side.change) + ", " + unit), 200);
  panel.rule_y(0, Look::mark, "");
  std::vector<std::pair<double, std::string>> words;
  for (int k = 0; k < std::ssize(shown); ++k) {
    const NumberChange& number = shown[k]->number;
    const double place = k + 0.5;
    const auto [from, to] = interval(number);
    words.emplace_back(place, shown[k]->name);
    panel.range(place, from / si, *number.change / si, to / si,
                number.moved() ? Look::after : Look::nominal,
                number.moved()   ? side.moved
                : number.p_value ? "not beyond chance"
                                 : "not tested",
                fmt::format("{}: {:.3g} {}, from {:.3g} to {:.3g}", shown[k]->name,
                            *number.change / si, unit, from / si, to / si));
  }
  picture->words(std::move(words));
  return picture;
}

std::string parameters_table(const Page& page, const std::vector<ComparedParameter>& parameters,
                             const ComparisonWords& words) {
  std::vector<TableRow> rows;
  for (size_t k = 0; k < parameters.size(); ++k) {
    const ComparedParameter& parameter = parameters[k];
    const NumberChange& number = parameter.number;
    const double si = parameter.unit.si;
    const std::string ending = parameter.unit.name == "1" ? "" : "_" + parameter.unit.name;
    const std::string key = fmt::format("parameters/{}/", k);
    rows.push_back(
        {escaped(parameter.name), parameter.of_arm ? "arm" : "station", words.of(parameter.in),
         parameter.unit.name, keyed_value(number.before, si, key + "before" + ending),
         keyed_value(number.after, si, key + "after" + ending), page.value(key + "change" + ending),
         page.value(key + "std" + ending), moved_cell(number, words)});
  }
  return table({"parameter", "of", "identified in", "unit", words.before, words.after, words.change,
                "standard deviation", "judgement"},
               rows);
}

void add_effects(Page& page, const RunComparison& found) {
  if (found.effects.empty()) return;
  page.section("Effects");
  const ComparisonWords words = words_of(found.arms);
  std::vector<TableRow> rows;
  for (size_t k = 0; k < found.effects.size(); ++k) {
    const ComparedEffect& effect = found.effects[k];
    for (size_t c = 0; c < effect.numbers.size(); ++c) {
      const NumberChange& number = effect.numbers[c];
      const NamedCoefficient& coefficient = effect.effect.coefficients[c];
      const std::string key = fmt::format("effects/{}/coefficients/{}/", k, c);
      const auto value = [&](const std::optional<double>& of, const char* which) {
        return of ? keyed(fmt::format("{:.4g}", *of), key + which) : std::string("-");
      };
      rows.push_back({escaped(effect.effect.in_words() + ": " + coefficient.name),
                      words.of(effect.in), escaped(coefficient.unit),
                      value(number.before, "before"), value(number.after, "after"),
                      page.value(key + "change"), page.value(key + "std"),
                      effect.same_inner ? moved_cell(number, words) : "other shape"});
    }
  }
  page.add(table({"effect", "found in", "unit", words.before, words.after, words.change,
                  "standard deviation", "judgement"},
                 rows));
}

Drawing curve_picture(const RemainderCurve& curve, size_t number, const ComparisonWords& words) {
  Points before, after;
  double low = 0, high = 0;
  for (size_t k = 0; k < curve.q.size(); ++k) {
    const double x = curve.q[k] / curve.name.si();
    before.emplace_back(x, curve.before[k] / curve.unit.si);
    after.emplace_back(x, curve.after[k] / curve.unit.si);
    low = std::min({low, before.back().y(), after.back().y()});
    high = std::max({high, before.back().y(), after.back().y()});
  }
  auto picture = std::make_shared<Picture>(
      fmt::format("remainder-{}", number + 1),
      fmt::format("{} over joint {}", curve.parameter, curve.joint + 1),
      fmt::format("Effects without a name, added up: {} and {}.", words.before, words.after),
      exact_axis(before.front().x(), before.back().x(),
                 curve.name.is_length ? "travel, mm" : "joint angle, deg"));
  Panel& panel = picture->panel(round_axis(low, high, curve.unit.name, 4), 110);
  panel.line(before, Look::before, words.before);
  panel.line(after, Look::after, words.after);
  return picture;
}

constexpr size_t kCurvesShown = 6;  // as pictures

// Indices of the curves: angles before lengths, the largest change first.
std::vector<size_t> by_change(const std::vector<RemainderCurve>& curves) {
  std::vector<size_t> order(curves.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, [&](size_t a, size_t b) {
    return std::pair(curves[a].unit.name == "mm", -curves[a].rms_change) <
           std::pair(curves[b].unit.name == "mm", -curves[b].rms_change);
  });
  return order;
}

void add_errors(Page& page, const RunComparison& found) {
  if (!found.errors) return;
  page.section("Error and verdict");
  const bool is_one = found.arms == ComparedArms::one;
  const ComparisonWords words = words_of(found.arms);
  std::vector<TableRow> rows;
  for (const auto& [run, word] :
       {std::pair("before", words.before), std::pair("after", words.after)}) {
    const std::string key = std::string("errors/") + run + "/";
    rows.push_back({word, page.value(key + "verdict"), page.value(key + "before_mm"),
                    page.value(key + "after_mm"), page.value(key + "floor_mm")});
  }
  page.add(table({"run", "verdict", "error before, mm", "error after, mm", "floor, mm"}, rows));
  if (!(*found.errors)[0].sentence.empty())
    page.add(
        paragraph((is_one ? "Before: " : "First arm: ") + page.value("errors/before/sentence")));
  if (!(*found.errors)[1].sentence.empty())
    page.add(
        paragraph((is_one ? "After: " : "Second arm: ") + page.value("errors/after/sentence")));
}

}  // namespace

Report comparison_page(const RunComparison& found, const std::string& robot, const PageHead& head) {
  const std::optional<bool> moved = found.arm_moved();
  const ComparisonWords words = words_of(found.arms);
  const bool is_one = found.arms == ComparedArms::one;
  Page page(head, robot, words.title);
  page.verdict(!moved || *moved ? Tone::attention : Tone::good,
               !found.undecided().empty() ? "undecided"
               : !moved                   ? "not tested"
               : *moved                   ? is_one ? "the arm moved" : "the arms differ"
                                          : "nothing beyond chance",
               page.value("sentence"));
  if (found.arm) {
    page.tiles(
        {{"Mean", page.value("arm/mean_mm") + " mm",
          "distance of the arms at " + page.value("arm/poses") + " poses, base and tool placed"},
         {"Largest", page.value("arm/max_mm") + " mm", "of these distances"},
         {"RMS", page.value("arm/rms_mm") + " mm",
          found.arm->by_chance ? "by chance " + page.value("arm/by_chance_mm") + " mm"
                               : "of these distances; chance was not tested"}});
  }
  page.section("What the runs are made of");
  std::vector<std::string> items = page.values("notes");
  for (const std::string& untested : page.values("untested"))
    items.push_back("Not tested: " + untested + ".");
  page.list(items);
  if (!found.parameters.empty()) {
    page.section(is_one ? "Changes of the parameters" : "Differences of the parameters");
    std::vector<Drawing> pictures;
    for (const bool of_arm : {true, false})
      for (const char* unit : {"deg", "mm"})
        if (of_arm || is_one) pictures.push_back(changes_picture(found, of_arm, unit));
    page.pictures(pictures);
    page.add(folded(counted(found.parameters.size(), "parameter"),
                    parameters_table(page, found.parameters, words)));
  }
  add_effects(page, found);
  if (!found.remainder.empty()) {
    page.section("Effects without a name");
    std::vector<Drawing> pictures;
    std::vector<TableRow> rows;
    for (const size_t k : by_change(found.remainder)) {
      const RemainderCurve& curve = found.remainder[k];
      if (pictures.size() < kCurvesShown) pictures.push_back(curve_picture(curve, k, words));
      const auto cell = [&](const char* which) {
        return page.value(fmt::format("remainder/{}/rms_{}_{}", k, which, curve.unit.name));
      };
      rows.push_back({escaped(curve.parameter), std::to_string(curve.joint + 1), curve.unit.name,
                      cell("before"), cell("after"), cell("change")});
    }
    page.pictures(pictures);
    page.add(folded(
        counted(rows.size(), "curve"),
        table({"parameter", "over joint", "unit", std::string("RMS, ") + words.before,
               std::string("RMS, ") + words.after, std::string("RMS of the ") + words.change},
              rows)));
  }
  add_errors(page, found);
  return page.finish();
}

}  // namespace armtrue
