#include "command_line.h"

#include <malloc.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <limits>
#include <new>

#include "armtrue/io/inputs_stay.h"
#include "armtrue/io/output.h"
#include "armtrue/io/output_folder.h"
#include "armtrue/text/edit_distance.h"
#include "armtrue/text/number_text.h"
#include "standard_streams.h"

// Only this file and options.cc include CLI11: it takes some 10 s to compile.

namespace armtrue::app {
namespace {

// Keeps freed memory for the next pass; glibc would return it, and the system would clear it again
// (10 % of the time of a million rows). Large columns go back: what they leave as they grow fits
// nothing else, and was 25 MB of a million rows.
void keep_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 23);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

constexpr const char* kInputName = "file";  // of the argument FILE

// With the options of all groups.
std::vector<const CLI::Option*> all_options(const CLI::App& app) {
  std::vector<const CLI::Option*> all = app.get_options();
  for (const CLI::App* group : app.get_subcommands([](const CLI::App*) { return true; }))
    for (const CLI::Option* option : all_options(*group)) all.push_back(option);
  return all;
}

// An empty argument comes from an unset variable of a script; it does not stand for standard input.
// CLI11 would take one behind the last positional for the name of a group of options, and never
// end, and for the value of `--robot=` the next argument.
void refuse_empty(int argc, char** argv) {
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k], before = argv[k - 1];
    const bool is_unset = argument.starts_with("--") && argument.find('=') + 1 == argument.size();
    if (!argument.empty() && !is_unset) continue;
    throw CLI::ValidationError(is_unset                  ? argument.substr(0, argument.size() - 1)
                               : before.starts_with('-') ? before
                                                         : "argument " + std::to_string(k),
                               "has an empty value; leave it out or fill it");
  }
}

// CLI11 accepts nan as a number in every range, and --flag=off, which counts as given.
void check_values(const CLI::App& app) {
  for (const CLI::Option* option : all_options(app)) {
    const bool is_flag = option->get_items_expected_max() == 0;
    if (is_flag && option->results() != std::vector<std::string>(option->count(), "true"))
      throw CLI::ValidationError(option->get_name(),
                                 "takes no value; leave the flag out to turn it off");
    if (!option->get_type_name().starts_with("FLOAT")) continue;
    for (const std::string& text : option->results())
      if (!std::isfinite(std::strtod(text.c_str(), nullptr)))
        throw CLI::ValidationError(option->get_name(), "'" + text + "' is not finite");
  }
}

// "--count,--targets" with a blank behind each comma.
std::string spaced(std::string names) {
  for (size_t at = names.find(','); at != names.npos; at = names.find(',', at + 1))
    names.insert(at + 1, " ");
  return names;
}

// The option that an unknown one seems to be: the beginning of its name, or its name with slips of
// the pen; empty if none is near.
std::string nearest_option(const std::string& name, const std::vector<const CLI::Option*>& options) {
  const auto bare = [](std::string text) {
    std::erase_if(text, [](char c) { return c == '-' || c == '_'; });
    return lower_case(text);
  };
  const std::string wanted = bare(name);
  std::string nearest;
  size_t least = wanted.size() / 3 + 1;  // a third of the letters may be wrong
  for (const CLI::Option* option : options)
    for (const std::string& known : option->get_lnames()) {
      const bool begins = wanted.size() > 1 && bare(known).starts_with(wanted);
      const size_t distance = begins ? 0 : edit_distance(bare(known), wanted);
      if (distance >= least) continue;
      least = distance;
      nearest = "--" + known;
      if (distance == 0) return nearest;
    }
  return nearest;
}

std::string unknown_option(const std::string& argument,
                           const std::vector<const CLI::Option*>& options) {
  const std::string name = argument.substr(0, argument.find('='));
  const std::string nearest = nearest_option(name, options);
  return "there is no option '" + name + "'" +
         (nearest.empty() ? "" : "; did you mean " + nearest + "?");
}

// Of what should not happen. `said` stands in another library's words, for the report.
std::string internal_error(const std::string& said) {
  return "the computation failed inside the program, which no input should bring about; look for "
         "numbers far from those of an arm (units, zeros), and report it with the files and the "
         "arguments" +
         (said.empty() ? std::string("; -v shows more") : " (a library says \"" + said + "\")");
}

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Command::Command(std::string name, const std::string& purpose, std::string example)
    : OptionGroup(std::make_shared<CLI::App>(purpose, name)),
      name_(std::move(name)),
      example_(std::move(example)) {
  app_->set_version_flag("--version", name_ + " (armtrue) " ARMTRUE_VERSION);
  flag("-v,--verbose", verbose, "Report each step");
  flag("-q,--quiet", quiet, "No warnings");
}

void Command::add_input(const std::string& what) {
  has_input_ = true;
  file(kInputName, input, what + "; standard input if absent or -");
}

void Command::add_output(ProductKind kind) {
  add_output("-o,--output", output,
             kind != ProductKind::other
                 ? "File for the product, JSON if it ends in .json; standard output if absent or -"
                 : "File for the product; standard output if absent or -",
             kind);
}

Option Command::add_output(const std::string& name, std::string& path, const std::string& what,
                           ProductKind kind) {
  CLI::Option* const option = app_->add_option(name, path, what)->type_name(kFileType);
  outputs_.push_back(option);
  if (kind != ProductKind::other) with_json_.push_back(option);
  return Option(option);
}

Option Command::add_output_folder(const std::string& name, std::string& path,
                                  const std::string& what) {
  CLI::Option* const option = app_->add_option(name, path, what)->type_name(kFolderType);
  folders_.push_back(option);
  return Option(option);
}

void Command::add_seed() {
  option("--seed", seed, "Seed of all random choices").check(seed_number()).default_shown();
}

void Command::add_new_sessions() {
  app_->add_option("--new-session-at-s", new_sessions_s,
                   "The instrument stood elsewhere from this time on, for example after a knock of "
                   "the tracker: a new session with its own base begins. loop.yaml shows a knock "
                   "as a step of the base; its at_s is the time. May be given several times")
      ->allow_extra_args(false);  // else the file that follows would be read as a further time
}

// What is wrong with the arguments, in words of our own.
std::string Command::usage_mistake(const CLI::ParseError& error) const {
  // A misspelt option is the cause, where its absence is reported.
  for (const std::string& argument : app_->remaining(true))
    if (argument.size() > 1 && argument.front() == '-' && argument != "--" &&
        !read_number(argument))
      return unknown_option(argument, all_options(*app_));
  for (const std::string& argument : app_->remaining(true))
    for (const char* const dash : {"\xE2\x80\x93", "\xE2\x80\x94", "\xE2\x88\x92"})
      if (argument.starts_with(dash))
        return "'" + argument + "' begins with a dash of a text; options begin with - or --";
  const std::string said = error.what();
  const auto parted = [&](const std::string& between) {
    const size_t at = said.find(between);
    return std::pair(said.substr(0, at),
                     at == said.npos ? "" : said.substr(at + between.size()));
  };
  if (dynamic_cast<const CLI::ExtrasError*>(&error))
    return "'" + app_->remaining(true).front() + "' is one argument too many" +
           (has_input_ ? "; one file is read, and '" + input + "' is it" : "");
  if (dynamic_cast<const CLI::ConversionError*>(&error)) {
    const auto [name, value] = parted(" = ");
    std::string with_point = value;
    std::ranges::replace(with_point, ',', '.');
    return name.substr(name.rfind(' ') + 1) + ": '" + value + "' is not a number of this option" +
           (with_point != value && read_number(with_point) ? "; write " + with_point : "");
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error)) {
    const std::string name = parted(": ").first;
    return name + (said.find("missing") != said.npos ? ": needs a value after it"
                                                     : ": stands more than once; give it once");
  }
  if (dynamic_cast<const CLI::RequiredError*>(&error) && said.find('[') != said.npos) {
    const std::string options = said.substr(said.find('[') + 1, said.find(']') - said.find('[') - 1);
    return "give exactly one of " + spaced(options);
  }
  return said;  // of a Check, or that an option is required, or requires or excludes another
}

// Prints help, version or a mistake in the arguments.
int Command::finish_parsing(const CLI::ParseError& error) const {
  const bool is_mistake = error.get_exit_code() != 0;
  if (is_mistake)
    print_error(name_ + ": " + printable(usage_mistake(error)) + "; " + name_ +
                " --help lists the options\n");
  else
    app_->exit(error);
  std::cout.flush();
  if (is_mistake) return kBadUsage;
  if (std::cout) return kSuccess;
  print_error(name_ + ": <stdout>: cannot be written\n");
  return kBadInput;
}

int Command::parse_and_work(int argc, char** argv, const std::function<int()>& work) {
  try {
    refuse_empty(argc, argv);
    app_->parse(argc, argv);
    check_values(*app_);
    check_outputs();
    check_folders();
    started_ = seconds();
    return work();  // may find that a derived product is named by an argument
  } catch (const CLI::ParseError& error) {
    return finish_parsing(error);
  }
}

int Command::run(int argc, char** argv, const std::function<int()>& work) {
  keep_memory();
  const InputsStay inputs_stay;
  std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is a write error like any other
  std::signal(SIGXFSZ, SIG_IGN);  // so is a file that grows beyond the limit of the shell
  reserve_standard_streams();
  app_->footer(
      "Example:\n  " + example_ + "\n" + columns_ +
      "\nExit codes: 0 success, 1 bad data or input/output, 2 usage, 3 a criterion failed.");
  int code = kBadInput;
  std::string message;
  try {
    code = parse_and_work(argc, argv, work);
  } catch (const std::bad_alloc&) {
    message = "there is not enough memory for this input; check its size, or free memory";
  } catch (const UsageError& error) {
    message = error.what();
    code = kBadUsage;
  } catch (const InputWouldBeLost& error) {
    message = error.what();
    code = kBadUsage;
  } catch (const InputError& error) {
    message = error.what();
  } catch (const OutputError& error) {
    message = error.what();
  } catch (const UnreachableTarget& error) {
    message = error.what();
  } catch (const std::invalid_argument& error) {  // what a function of the library needs
    message = error.what();
  } catch (const std::exception& error) {
    message = internal_error(verbose ? error.what() : "");
  } catch (...) {
    message = internal_error("");
  }
  if (std::exchange(progress_shown_, false)) print_error("\r\033[K");
  if (!message.empty()) print_error(name_ + ": " + printable(message) + "\n");
  return code;
}

// The files that the arguments name, apart from `own`, with the option of each.
std::vector<std::pair<std::string, std::string>> Command::named_files(
    const CLI::Option* own) const {
  std::vector<std::pair<std::string, std::string>> files;
  for (const CLI::Option* option : all_options(*app_)) {
    const std::string type = option->get_type_name();
    if (option == own || (type != kFileType && type != kFolderType)) continue;
    const bool is_output = std::ranges::find(outputs_, option) != outputs_.end();
    for (const std::string& path : option->results())
      files.emplace_back(option->get_name(),
                         path != "-" ? path : (is_output ? "/dev/stdout" : "/dev/stdin"));
  }
  if (has_input_ && input == "-") files.emplace_back("standard input", "/dev/stdin");
  return files;
}

void Command::refuse_named(const std::string& path, const std::string& name,
                           const CLI::Option* own) const {
  struct stat status {};
  if (stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) return;  // a device, a pipe
  for (const auto& [option, named] : named_files(own))
    if (same_file(named, path))
      throw CLI::ValidationError(name, "'" + path + "' is named by " +
                                           (option == kInputName ? "the argument FILE" : option) +
                                           " too; give each product a file of its own");
}

namespace {

// A page in a .pdf opens nowhere.
void refuse_foreign_ending(const std::string& path, const std::string& option) {
  for (const char* const ending : {".pdf", ".png", ".jpg", ".xlsx", ".docx", ".ods"})
    if (path.ends_with(ending))
      throw CLI::ValidationError(option, "'" + path +
                                             "': no product is of this kind; pages end in " +
                                             ".html, tables in .csv, documents in .yaml or .json");
}

}  // namespace

void Command::check_derived_output(const std::string& path) const {
  refuse_named(path, path, nullptr);
  expect_output(path);
  check_writable(path);
}

// A product that cannot be written is reported before hours of work, not after.
void Command::check_outputs() const {
  namespace fs = std::filesystem;
  std::error_code none;
  bool standard_output_taken = false;
  for (const CLI::Option* option : outputs_) {
    const bool is_product = option == outputs_.front();
    if (option->results().empty() && !is_product) continue;
    const std::string path = is_product ? output : option->results().front();
    if (path == "-") {
      if (std::exchange(standard_output_taken, true))
        throw CLI::ValidationError(option->get_name(),
                                   "two products cannot both go to standard output; give one of "
                                   "them a file");
      refuse_named("/dev/stdout", "standard output", option);
      expect_output(path);
      continue;
    }
    if (fs::is_directory(path, none))
      throw CLI::ValidationError(option->get_name(), "'" + path + "' is a folder; name a file");
    if (is_json_file(path) && std::ranges::find(with_json_, option) == with_json_.end())
      throw CLI::ValidationError(option->get_name(),
                                 "'" + path +
                                     "': JSON is written of documents and tables, and this product "
                                     "is a text or a page; give the file another ending");
    refuse_foreign_ending(path, option->get_name());
    refuse_named(path, option->get_name(), option);
    expect_output(path);
    if (is_device_or_pipe(path)) continue;
    const fs::file_type folder = fs::status(fs::absolute(path, none).parent_path(), none).type();
    if (folder != fs::file_type::directory && folder != fs::file_type::none)  // none: not told
      throw CLI::ValidationError(option->get_name(),
                                 "'" + path + "': there is no such folder; make it first");
    check_writable(path);
  }
}

void Command::check_folders() const {
  namespace fs = std::filesystem;
  std::error_code none;
  for (const CLI::Option* option : folders_) {
    if (option->results().empty()) continue;
    const std::string path = option->results().front();
    check_replaceable(path);
    expect_output(path);
    const fs::path folder = fs::weakly_canonical(fs::absolute(path, none), none);
    for (const auto& [name, named] : named_files(option)) {
      const fs::path file = fs::weakly_canonical(fs::absolute(named, none), none);
      if (std::ranges::mismatch(folder, file).in1 == folder.end())
        throw CLI::ValidationError(option->get_name(),
                                   "'" + named + "' of " + name + " lies in '" + path +
                                       "', which is replaced as a whole; give one of them another "
                                       "folder");
    }
  }
}

void Command::warn(const std::string& message) {
  // What files of a controller say may be found with each program of it.
  if (std::ranges::find(warnings_, message) != warnings_.end()) return;
  warnings_.push_back(message);
  if (!quiet) print_error(name_ + ": " + printable(message) + "\n");
}

void Command::tell(const std::string& message) const {
  if (verbose) print_error(without_controls(message));
}

bool Command::reports() const { return verbose || (!quiet && isatty(STDERR_FILENO)); }

void Command::report(const std::string& message) const {
  const bool terminal = isatty(STDERR_FILENO);
  if (reports()) print_error((terminal ? "\r\033[K" : "") + without_controls(message));
}

void Command::report_written(const std::string& path, const std::string& note) const {
  if (!path.empty() && path != "-") report("wrote " + path + note + "\n");
}

void Command::progress(const std::string& message) {
  if (quiet || !isatty(STDERR_FILENO) || seconds() - started_ < 1.0) return;
  print_error("\r\033[K" + name_ + ": " + printable(message) + " ...");
  progress_shown_ = true;
}

}  // namespace armtrue::app
