#include "options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "armtrue/campaign/heaviest_payload.h"
#include "armtrue/text/number_text.h"
#include "option_text.h"

// Only this file and command_line.cc include CLI11: it takes some 10 s to compile.

namespace armtrue::app {
namespace {

constexpr const char* kNumbersType = "NUMBERS";

Check number_check(bool (*holds)(double), const std::string& wanted) {
  return {"NUMBER", [holds, wanted](const std::string& text) {
            const std::optional<double> value = read_number(text);
            if (!value) return "'" + text + "' is not a number";
            if (!std::isfinite(*value)) return "'" + text + "' is not finite";
            return holds(*value) ? std::string() : "'" + text + "' must be " + wanted;
          }};
}

Option add_numbers(CLI::App& app, const std::string& names, std::vector<double>& values,
                   std::optional<size_t> count, const std::string& form, const std::string& help) {
  return Option(app.add_option_function<std::string>(
                       names,
                       [&values, names, count, form](const std::string& text) {
                         try {
                           values = numbers_from_text(text, count, form);
                         } catch (const std::invalid_argument& error) {
                           throw CLI::ValidationError(names, error.what());
                         }
                       },
                       help)
                    ->type_name(kNumbersType));
}

template <typename Number>
Check range_check(Number low, Number high) {
  return {CLI::Range(low, high).get_description(), [low, high](const std::string& text) {
            const std::optional<double> value = read_number(text);
            if (!value) return "'" + text + "' is not a number";
            if (*value >= low && *value <= high) return std::string();
            return fmt::format("'{}' must be from {} to {}", text, low, high);
          }};
}

}  // namespace

// CLI11 itself would name the largest double in the message of a bound.
Check above_zero() {
  return number_check([](double value) { return value > 0; }, "above 0");
}

Check not_below_zero() {
  return number_check([](double value) { return value >= 0; }, "0 or above");
}

Check payload_of_arm() {
  return number_check([](double value) { return value >= 0 && value <= kHeaviestPayload; },
                      fmt::format("a payload in kg, from 0 to {:g}", kHeaviestPayload));
}

Check temperature_of_arm() {
  return number_check([](double value) { return value >= -100 && value <= 200; },
                      "a temperature in deg C, from -100 to 200; take 273.15 off of kelvin");
}

Check above_zero_or_auto() {
  return {"NUMBER or auto", [](const std::string& text) {
            return text == "auto" ? std::string() : above_zero().why_wrong(text);
          }};
}

std::optional<double> number_or_auto(const std::string& text) {
  if (text == "auto") return std::nullopt;
  return read_number(text);
}

Check seed_number() {
  return {"NUMBER", [](const std::string& text) {
            std::uint64_t value = 0;
            const char* const end = text.data() + text.size();
            const auto [rest, error] = std::from_chars(text.data(), end, value);
            if (error == std::errc{} && rest == end) return std::string();
            return fmt::format("'{}' is no whole number from 0 to {}", text,
                               std::numeric_limits<std::uint64_t>::max());
          }};
}

Check in_range(int low, int high) { return range_check(low, high); }

Check in_range(double low, double high) { return range_check(low, high); }

Check one_of(const std::vector<std::string>& words) {
  return {CLI::IsMember(words).get_description(), [words](const std::string& text) {
            if (std::ranges::find(words, text) != words.end()) return std::string();
            return fmt::format("'{}' is none of {}", text, fmt::join(words, ", "));
          }};
}

Option Option::required() const {
  option_->required();
  return *this;
}

Option Option::needs(Option other) const {
  option_->needs(other.option_);
  return *this;
}

Option Option::excludes(Option other) const {
  option_->excludes(other.option_);
  return *this;
}

Option Option::check(const Check& check) const {
  option_->check(check.why_wrong, check.form);
  return *this;
}

Option Option::default_shown() const {
  option_->capture_default_str();
  return *this;
}

Option Option::one_each() const {
  option_->allow_extra_args(false);
  return *this;
}

Option OptionGroup::option(const std::string& names, std::string& value, const std::string& help) {
  return Option(app_->add_option(names, value, help));
}

Option OptionGroup::option(const std::string& names, double& value, const std::string& help) {
  return Option(app_->add_option(names, value, help));
}

Option OptionGroup::option(const std::string& names, int& value, const std::string& help) {
  return Option(app_->add_option(names, value, help));
}

Option OptionGroup::option(const std::string& names, std::uint64_t& value,
                           const std::string& help) {
  return Option(app_->add_option(names, value, help));
}

Option OptionGroup::option(const std::string& names, std::optional<double>& value,
                           const std::string& help) {
  return Option(app_->add_option_function<double>(
      names, [&value](const double& number) { value = number; }, help));
}

Option OptionGroup::option(const std::string& names, std::vector<std::string>& values,
                           const std::string& help) {
  return Option(app_->add_option(names, values, help));
}

Option OptionGroup::file(const std::string& names, std::string& path, const std::string& help) {
  return Option(app_->add_option(names, path, help)->type_name(kFileType));
}

Option OptionGroup::file(const std::string& names, std::vector<std::string>& paths,
                         const std::string& help) {
  return Option(app_->add_option(names, paths, help)->type_name(kFileType));
}

Option OptionGroup::folder(const std::string& names, std::string& path, const std::string& help) {
  return Option(app_->add_option(names, path, help)->type_name(kFolderType));
}

Option OptionGroup::flag(const std::string& names, bool& value, const std::string& help) {
  return Option(app_->add_flag(names, value, help));
}

Option OptionGroup::numbers(const std::string& names, std::vector<double>& values, size_t count,
                            const std::string& form, const std::string& help) {
  return add_numbers(*app_, names, values, count, form, help);
}

Option OptionGroup::joints(const std::string& names, std::vector<double>& values,
                           const std::string& help) {
  return add_numbers(*app_, names, values, std::nullopt,
                     "q1,...,q6 in deg, a number for each joint", help);
}

Option OptionGroup::identify(std::string& list) {
  return Option(app_->add_option(
      "--identify", list,
      "auto, paper-25, or a list such as A1.alpha,A2.d,base,tool.z; *.theta and A?.d name all that "
      "are so, and auto,-A3.d all but A3.d; replaces 'identify' of the robot file"));
}

Option OptionGroup::zone(std::string& zone, const std::string& help) {
  const auto why_wrong = [](const std::string& text) {
    try {
      zone_from_text(text);
      return std::string();
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
  };
  return Option(app_->add_option("--zone-mm,--zone", zone, help)->type_name(kNumbersType))
      .check({"", why_wrong});
}

// A group lives in the app that it was added to.
OptionGroup OptionGroup::group(const std::string& heading, const std::string& help) {
  return OptionGroup(std::shared_ptr<CLI::App>(app_, app_->add_option_group(heading, help)));
}

void OptionGroup::require_one() { app_->require_option(1); }

}  // namespace armtrue::app
