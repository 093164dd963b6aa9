#include <fmt/format.h>

#include "armtrue/kinematics/units.h"
#include "armtrue/report/comparison_page.h"
#include "report/comparison_words.h"

namespace armtrue {
namespace {

std::string cell(const std::optional<double>& si, double unit, const char* form) {
  return fmt::format("{:>12}", si ? fmt::format(fmt::runtime(form), *si / unit) : std::string("-"));
}

std::string number_row(const std::string& name, const std::string& unit, double si,
                       const NumberChange& number, const char* form, const ComparisonWords& words) {
  return fmt::format("{:<28}{:<11}", name, unit) + cell(number.before, si, form) +
         cell(number.after, si, form) + cell(number.change, si, "{:.4g}") +
         cell(number.std, si, "{:.2g}") + (number.moved() ? std::string("  ") + words.moved : "") +
         "\n";
}

}  // namespace

std::string comparison_table(const RunComparison& found, const std::vector<std::string>& notes) {
  const ComparisonWords words = words_of(found.arms);
  std::string text;
  for (const std::string& note : notes) text += note + "\n";
  text += fmt::format("{:<28}{:<11}{:>12}{:>12}{:>12}{:>12}\n", "", "unit", words.before,
                      words.after, words.change, "std");
  for (const ComparedParameter& parameter : found.parameters)
    text += number_row(parameter.in == InRuns::both
                           ? parameter.name
                           : fmt::format("{} ({})", parameter.name, words.of(parameter.in)),
                       parameter.unit.name, parameter.unit.si, parameter.number, "{:.4f}", words);
  for (const ComparedEffect& effect : found.effects) {
    text += effect.effect.in_words() +
            (effect.in == InRuns::both ? "" : std::string(": ") + words.of(effect.in)) + "\n";
    for (size_t k = 0; k < effect.numbers.size(); ++k)
      text += number_row("  " + effect.effect.coefficients[k].name,
                         effect.effect.coefficients[k].unit, 1, effect.numbers[k], "{:.4g}", words);
  }
  const auto row = [&](const std::string& what, const std::optional<double>& value) {
    if (value) text += fmt::format("{:<44}{:>9.4f}\n", what, *value / kMillimetre);
  };
  if (found.arm) {
    row("mean distance of the arms, mm", found.arm->mean);
    row("RMS distance, mm", found.arm->rms);
    row("RMS distance by chance alone, mm", found.arm->by_chance);
    row("largest distance, mm", found.arm->max);
  }
  if (found.errors) {
    row(fmt::format("mean error, {}, mm", words.before), (*found.errors)[0].after);
    row(fmt::format("mean error, {}, mm", words.after), (*found.errors)[1].after);
  }
  return text;
}

}  // namespace armtrue
