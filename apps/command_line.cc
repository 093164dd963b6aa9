#include "command_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <unordered_set>

#include "armtrue/identification/diagnosis.h"
#include "armtrue/io/input_error.h"
#include "armtrue/io/output.h"
#include "armtrue/kinematics/units.h"

namespace armtrue::app {
namespace {

// Throws std::invalid_argument, which says what was expected.
std::vector<double> parse_numbers(const std::string& text, size_t count, const std::string& form) {
  std::vector<double> numbers;
  for (const std::string& item : split_list(text)) {
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

// CLI11 takes nan for a number, and for one in every range.
void check_finite(const CLI::App& app) {
  for (const CLI::App* group : app.get_subcommands([](const CLI::App*) { return true; }))
    check_finite(*group);
  for (const CLI::Option* option : app.get_options()) {
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
  app_.add_option("-o,--output", output, "Where the product goes; standard output if absent or -");
}

void Command::add_seed() {
  app_.add_option("--seed", seed, "Seed of all random choices")->capture_default_str();
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
    check_finite(app_);
  } catch (const CLI::ParseError& error) {
    return app_.exit(error) == 0 ? kSuccess : kBadUsage;
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
  for (const std::string& name : file.campaign.target_names)
    if (std::none_of(robot.chain.targets.begin(), robot.chain.targets.end(),
                     [&](const Target& target) { return target.name == name; }))
      throw InputError(file.campaign.source + ": the target '" + name +
                       "' is not in the robot file; add its offset under 'targets'");
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

Provenance Command::provenance() const { return {name_, ARMTRUE_VERSION, inputs_}; }

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> items;
  size_t begin = 0;
  while (begin <= text.size()) {
    const size_t end = std::min(text.find(',', begin), text.size());
    if (end > begin) items.push_back(text.substr(begin, end - begin));
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

CLI::Validator above_zero() {
  return number_check([](double value) { return value > 0; }, "above 0");
}

CLI::Validator not_below_zero() {
  return number_check([](double value) { return value >= 0; }, "0 or above");
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
