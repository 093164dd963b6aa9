#include "command_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <limits>
#include <unordered_set>
#include <utility>

#include "armtrue/diagnosis/diagnosis.h"
#include "armtrue/io/output.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"

namespace armtrue::app {
namespace {

// Throws std::invalid_argument, which says what was expected.
std::vector<double> parse_numbers(const std::string& text, size_t count, const std::string& form) {
  std::vector<double> numbers;
  const std::vector<std::string> items = split_list(text);
  if (static_cast<size_t>(std::ranges::count(text, ',')) + 1 != items.size())
    throw std::invalid_argument("'" + text + "' has an empty place; give " + form);
  for (const std::string& item : items) {
    char* end = nullptr;
    numbers.push_back(std::strtod(item.c_str(), &end));
    if (*end != '\0' || !std::isfinite(numbers.back()))
      throw std::invalid_argument("'" + item + "' is not a number; give " + form);
  }
  if (numbers.size() != count)
    throw std::invalid_argument(fmt::format("'{}' has {} numbers instead of {}; give {}", text,
                                            numbers.size(), count, form));
  return numbers;
}

// Those of its groups too.
std::vector<const CLI::Option*> all_options(const CLI::App& app) {
  std::vector<const CLI::Option*> all = app.get_options();
  for (const CLI::App* group : app.get_subcommands([](const CLI::App*) { return true; }))
    for (const CLI::Option* option : all_options(*group)) all.push_back(option);
  return all;
}

// CLI11 takes nan for a number, and for one in every range. An empty text is what an unset variable
// of a script leaves, not standard input.
void check_values(const CLI::App& app) {
  for (const CLI::Option* option : all_options(app)) {
    if (std::ranges::count(option->results(), "") > 0)
      throw CLI::ValidationError(option->get_name(), "has an empty value; leave it out or fill it");
    if (!option->get_type_name().starts_with("FLOAT")) continue;
    for (const std::string& text : option->results())
      if (!std::isfinite(std::strtod(text.c_str(), nullptr)))
        throw CLI::ValidationError(option->get_name(), "'" + text + "' is not finite");
  }
}

CLI::Validator number_check(bool (*holds)(double), const std::string& wanted) {
  return CLI::Validator(
      [holds, wanted](const std::string& text) {
        char* end = nullptr;
        const double value = std::strtod(text.c_str(), &end);
        if (text.empty() || *end != '\0') return "'" + text + "' is not a number";
        if (!std::isfinite(value)) return "'" + text + "' is not finite";
        return holds(value) ? std::string() : "'" + text + "' must be " + wanted;
      },
      "NUMBER");
}

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Command::Command(std::string name, const std::string& purpose, const std::string& example)
    : name_(std::move(name)), app_(purpose, name_) {
  app_.footer(
      "Example:\n  " + example +
      "\n\nExit codes: 0 success, 1 bad data or input/output, 2 usage, 3 a criterion failed.");
  app_.set_version_flag("--version", name_ + " (armtrue) " ARMTRUE_VERSION);
  app_.add_flag("-v,--verbose", verbose, "Say what is done");
  app_.add_flag("-q,--quiet", quiet, "No warnings");
}

void Command::add_input(const std::string& what) {
  app_.add_option("file", input, what + "; standard input if absent or -");
}

void Command::add_output() {
  add_output("-o,--output", output, "Where the product goes; standard output if absent or -");
}

CLI::Option* Command::add_output(const std::string& name, std::string& path,
                                 const std::string& what) {
  CLI::Option* const option = app_.add_option(name, path, what);
  outputs_.push_back(option);
  return option;
}

void Command::add_seed() {
  app_.add_option("--seed", seed, "Seed of all random choices")
      ->check(seed_number())
      ->capture_default_str();
}

void Command::add_new_sessions() {
  app_.add_option("--new-session-at-s", new_sessions_s,
                  "From this time on the instrument stood elsewhere: a session with a base of its "
                  "own begins, as after a knock of the tracker, which loop.yaml shows as a step of "
                  "the base (its at_s is the time). May be given several times")
      ->allow_extra_args(false);  // or the file that follows would be taken for another time
}

int Command::run(int argc, char** argv, const std::function<int()>& work) {
  std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is a write error like any other
  try {
    app_.parse(argc, argv);
    check_values(app_);
    check_outputs();
  } catch (const CLI::ParseError& error) {
    return app_.exit(error) == 0 ? kSuccess : kBadUsage;
  } catch (const OutputError& error) {
    fmt::print(stderr, "{}: {}\n", name_, error.what());
    return kBadInput;
  }
  started_ = seconds();
  int code = kBadInput;
  try {
    code = work();
  } catch (const std::exception& error) {
    if (progress_shown_) std::fputs("\r\033[K", stderr);
    progress_shown_ = false;
    fmt::print(stderr, "{}: {}\n", name_, error.what());
  }
  if (progress_shown_) std::fputs("\r\033[K", stderr);
  return code;
}

// Before hours of work, not after.
void Command::check_outputs() const {
  namespace fs = std::filesystem;
  std::error_code none;
  const auto whole_path = [&](const std::string& path) {
    return fs::weakly_canonical(fs::absolute(path, none), none);
  };
  bool standard_output_taken = false;
  for (const CLI::Option* output : outputs_) {
    const bool is_product = output == outputs_.front();
    if (output->results().empty() && !is_product) continue;
    const std::string path = is_product ? this->output : output->results().front();
    if (path == "-") {
      if (std::exchange(standard_output_taken, true))
        throw CLI::ValidationError(output->get_name(),
                                   "two products cannot both go to standard output; give one of "
                                   "them a file");
      continue;
    }
    if (fs::is_directory(path, none))
      throw CLI::ValidationError(output->get_name(), "'" + path + "' is a folder; name a file");
    if (is_device_or_pipe(path)) continue;
    const fs::file_type folder = fs::status(fs::absolute(path, none).parent_path(), none).type();
    if (folder != fs::file_type::directory && folder != fs::file_type::none)  // none: not told
      throw CLI::ValidationError(output->get_name(), "'" + path + "': there is no such folder");
    check_writable(path);
    const fs::path whole = whole_path(path);
    for (const CLI::Option* option : all_options(app_))
      for (const std::string& other : option->results())
        if (option != output && option->get_type_name() == "TEXT" && whole_path(other) == whole)
          throw CLI::ValidationError(output->get_name(),
                                     "'" + path + "' is named by " + option->get_name() +
                                         " too; give each product a file of its own");
  }
}

void Command::warn(const std::string& message) const {
  if (!quiet) fmt::print(stderr, "{}: {}\n", name_, message);
}

void Command::tell(const std::string& message) const {
  if (verbose) fmt::print(stderr, "{}", message);
}

void Command::progress(const std::string& message) {
  if (quiet || !isatty(STDERR_FILENO) || seconds() - started_ < 1.0) return;
  fmt::print(stderr, "\r\033[K{}: {} ...", name_, message);
  std::fflush(stderr);
  progress_shown_ = true;
}

RobotFile Command::robot(const std::string& path) {
  RobotFile file = read_robot(path);
  inputs_.emplace_back(file.name, file.sha256);
  return file;
}

Campaign Command::campaign(const std::string& path, const Robot& robot) {
  progress("reading measurements");
  CampaignFile file = read_campaign(path);
  inputs_.emplace_back(file.campaign.source, file.sha256);
  warn_of_unknown(file.unknown_columns);
  if (file.campaign.skipped_rows > 0)
    warn(fmt::format("{} rows without a measurement skipped", file.campaign.skipped_rows));
  begin_new_sessions(file.campaign, path == input);
  if (const auto findings = diagnose(robot, file.campaign); !findings.empty())
    throw InputError(file.campaign.source + ": " + findings.front());
  return std::move(file.campaign);
}

void Command::begin_new_sessions(Campaign& campaign, bool is_input) const {
  if (new_sessions_s.empty()) return;
  const std::vector<double>& times = campaign.time_s;
  if (times.empty())
    throw InputError(campaign.source +
                     ": --new-session-at-s needs the time of each reading; add the column t_s");
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  for (double start : new_sessions_s)
    if (is_input && !(start > *first && start <= *last))  // held-out poses may be of one side
      throw InputError(fmt::format(
          "{}: --new-session-at-s {} leaves no reading on one side; t_s goes from {} to {}",
          campaign.source, start, *first, *last));
  begin_sessions(campaign, new_sessions_s);
}

PathFile Command::path(const std::string& path, KeepRows keep) {
  PathFile file = read_path(path, keep);
  inputs_.emplace_back(file.source, file.sha256);
  if (keep == KeepRows::no) warn_of_unknown(file.unknown_columns);
  return file;
}

void Command::warn_of_unknown(const std::vector<std::string>& columns) const {
  if (columns.empty()) return;
  std::string list;
  for (const std::string& column : columns) list += (list.empty() ? "" : ", ") + column;
  warn("columns not used: " + list);
}

InputError at_its_line(const PathFile& file, const UnreachableSample& error) {
  return InputError(
      file.source + ":" + std::to_string(file.line[static_cast<size_t>(error.sample)]) +
      ": the sample at t_s = " + number_text(file.path.time[error.sample]) + ": " + error.what());
}

Provenance Command::provenance() const { return {name_, ARMTRUE_VERSION, inputs_}; }

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> items;
  size_t begin = 0;
  while (begin <= text.size()) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const size_t first = std::min(text.find_first_not_of(' ', begin), end);
    const size_t last = end > first ? text.find_last_not_of(' ', end - 1) + 1 : first;
    if (last > first) items.push_back(text.substr(first, last - first));
    begin = end + 1;
  }
  return items;
}

std::vector<JointTarget> numbered(const std::vector<JointVector>& configurations,
                                  const std::vector<std::string>& taken) {
  const std::unordered_set<std::string> ids(taken.begin(), taken.end());
  std::vector<JointTarget> targets;
  for (int number = 1; targets.size() < configurations.size(); ++number) {
    const std::string id = std::to_string(number);
    if (!ids.contains(id)) targets.push_back({id, configurations[targets.size()]});
  }
  return targets;
}

void add_numbers(CLI::App& options, const std::string& name, std::vector<double>& numbers,
                 size_t count, const std::string& form, const std::string& help) {
  options.add_option_function<std::string>(
      name,
      [&numbers, name, count, form](const std::string& text) {
        try {
          numbers = parse_numbers(text, count, form);
        } catch (const std::invalid_argument& error) {
          throw CLI::ValidationError(name, error.what());
        }
      },
      help);
}

std::string not_converged(const CalibrationResult& fit) {
  return fmt::format(
      "not converged after {} iterations ({}); measure poses that move every joint over its "
      "travel, or identify fewer parameters",
      fit.iterations, fit.termination);
}

CLI::Validator above_zero() {
  return number_check([](double value) { return value > 0; }, "above 0");
}

CLI::Validator not_below_zero() {
  return number_check([](double value) { return value >= 0; }, "0 or above");
}

CLI::Validator seed_number() {
  return CLI::Validator(
      [](const std::string& text) {
        std::uint64_t value = 0;
        const char* const end = text.data() + text.size();
        const auto [rest, error] = std::from_chars(text.data(), end, value);
        if (error == std::errc{} && rest == end) return std::string();
        return fmt::format("'{}' is no whole number from 0 to {}", text,
                           std::numeric_limits<std::uint64_t>::max());
      },
      "NUMBER");
}

Catalogue catalogue(const std::string& path) {
  extern const char* const kShippedCatalogue;
  return path.empty() ? parse_catalogue(kShippedCatalogue, "the shipped catalogue")
                      : read_catalogue(path);
}

void add_zone(CLI::App& options, std::string& zone, const std::string& help) {
  options.add_option("--zone-mm,--zone", zone, help)->check([](const std::string& text) {
    try {
      app::zone(text);
      return std::string();
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
  });
}

Zone zone(const std::string& text) {
  const std::vector<double> numbers = parse_numbers(text, 4, "x,y,z,radius in mm");
  if (numbers[3] <= 0) throw std::invalid_argument("the radius must be above zero");
  return {Eigen::Vector3d(numbers[0], numbers[1], numbers[2]) * kMillimetre,
          numbers[3] * kMillimetre};
}

}  // namespace armtrue::app
