#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace armtrue::app {

/// What --help calls the values of options that name a file or a folder.
inline constexpr const char* kFileType = "FILE";
inline constexpr const char* kFolderType = "FOLDER";

/// Arguments that do not fit together, where that shows only after files are read.
class UsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A condition on the text of an option.
struct Check {
  std::string form;  ///< stands in --help after the type of the option; may be empty
  /// Why a text is wrong; empty if it is right.
  std::function<std::string(const std::string&)> why_wrong;
};

Check above_zero();
Check not_below_zero();
Check payload_of_arm();
Check temperature_of_arm();
Check above_zero_or_auto();
/// Of a text that above_zero_or_auto() passed. Nothing for "auto", which leaves the choice to the
/// data.
std::optional<double> number_or_auto(const std::string& text);
/// A whole number from 0 to 2^64 - 1. CLI11 would read -1 as 2^64 - 1.
Check seed_number();
/// Bounds included.
Check in_range(int low, int high);
Check in_range(double low, double high);
Check one_of(const std::vector<std::string>& words);

/// Handle of an option; a copy stands for the same option. Each member function returns the handle.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option required() const;
  Option needs(Option other) const;
  Option excludes(Option other) const;
  Option check(const Check& check) const;
  /// --help shows the value that the variable has now.
  Option default_shown() const;
  /// For an option with several values: it takes one value each time that it is given.
  Option one_each() const;

 private:
  CLI::Option* option_;
};

/// Options under one heading of --help. The variables of the options must live as long as the
/// command.
class OptionGroup {
 public:
  Option option(const std::string& names, std::string& value, const std::string& help);
  Option option(const std::string& names, double& value, const std::string& help);
  Option option(const std::string& names, int& value, const std::string& help);
  Option option(const std::string& names, std::uint64_t& value, const std::string& help);
  /// Empty unless the option is given.
  Option option(const std::string& names, std::optional<double>& value, const std::string& help);
  /// One or more values after the option.
  Option option(const std::string& names, std::vector<std::string>& values,
                const std::string& help);
  /// A file that is read, or several.
  Option file(const std::string& names, std::string& path, const std::string& help);
  Option file(const std::string& names, std::vector<std::string>& paths, const std::string& help);
  /// A folder that is read.
  Option folder(const std::string& names, std::string& path, const std::string& help);
  Option flag(const std::string& names, bool& value, const std::string& help);
  /// `count` numbers separated by commas, such as `x,y,z,radius in mm` (the `form`, for messages).
  /// They are one text: with several texts, the last could be the file that follows.
  Option numbers(const std::string& names, std::vector<double>& values, size_t count,
                 const std::string& form, const std::string& help);
  /// Encoder values separated by commas; how many the robot needs, and their units, joints_of()
  /// says.
  Option joints(const std::string& names, std::vector<double>& values, const std::string& help);
  /// --identify; see app::use_identify().
  Option identify(std::string& list);
  /// --zone x,y,z,radius [mm]; see zone_from_text().
  Option zone(std::string& zone, const std::string& help);

  OptionGroup group(const std::string& heading, const std::string& help = "");
  /// Exactly one option of this group must be given.
  void require_one();

 protected:
  explicit OptionGroup(std::shared_ptr<CLI::App> app) : app_(std::move(app)) {}

  std::shared_ptr<CLI::App> app_;
};

}  // namespace armtrue::app
