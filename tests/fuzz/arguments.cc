// The command line: one option of every kind, files that are read and written, and the readers of
// lists, boxes and zones. Nothing is written.

#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "../../apps/command_line.h"
#include "../../apps/option_text.h"
#include "fuzz/targets.h"

namespace armtrue::fuzz {
namespace {

struct Arguments {
  std::string text, zone, unit = "mm", number = "1", file, report, pictures;
  double value = 1, above = 1, range = 1;
  int count = 1;
  std::optional<double> maybe;
  std::vector<std::string> texts, each, files;
  std::vector<double> box, joints;
  bool flag = false, left = false, right = false;
};

void add_files(app::Command& command, Arguments& arguments) {
  command.add_input("What is read");
  command.add_output();
  command.file("--file", arguments.file, "A file");
  command.file("--files", arguments.files, "Files")
      .excludes(command.add_output("--report", arguments.report, "A further product"));
  command.add_output_folder("--pictures", arguments.pictures, "A folder");
  app::OptionGroup sides = command.group("Sides");
  sides.flag("--left", arguments.left, "A flag");
  sides.flag("--right", arguments.right, "A flag");
  sides.require_one();
}

void add_options(app::Command& command, Arguments& arguments) {
  command.add_seed();
  command.add_new_sessions();
  command.add_columns("Columns: text");
  const app::Option text = command.option("--text", arguments.text, "A text").default_shown();
  command.option("--value", arguments.value, "A number");
  command.option("--above", arguments.above, "A number").check(app::above_zero());
  command.option("--range", arguments.range, "A number").check(app::in_range(0.0, 1.0));
  command.option("--count", arguments.count, "A number").check(app::in_range(1, 100));
  command.option("--maybe", arguments.maybe, "A number").check(app::not_below_zero()).needs(text);
  command.option("--number", arguments.number, "A number").check(app::above_zero_or_auto());
  command.option("--texts", arguments.texts, "Texts");
  command.option("--each", arguments.each, "Texts").one_each();
  command.option("--unit", arguments.unit, "A word").check(app::one_of({"mm", "m", "in"}));
  command.numbers("--box", arguments.box, 6, "x0,x1,y0,y1,z0,z1 in mm", "A box");
  command.joints("--joints", arguments.joints, "Angles");
  command.zone(arguments.zone, "A zone");
  command.flag("--flag", arguments.flag, "A flag");
  add_files(command, arguments);
}

// Numbers that the checks let through are finite, and what is read of them again is.
void use(const app::Command& command, const Arguments& arguments) {
  require(std::isfinite(arguments.value) && arguments.above > 0, "a number is none");
  require(arguments.range >= 0 && arguments.range <= 1, "a number is out of its range");
  require(arguments.count >= 1 && arguments.count <= 100, "a count is out of its range");
  require(!arguments.maybe || *arguments.maybe >= 0, "a number is below zero");
  if (const auto number = app::number_or_auto(arguments.number))
    require(*number > 0, "a number is not above zero");
  else
    require(arguments.number == "auto", "a number is lost");
  if (!arguments.zone.empty())
    require(app::zone_from_text(arguments.zone).radius > 0, "a zone has no radius");
  if (const auto box = app::box_from_numbers(arguments.box))
    require(box->low.allFinite() && box->high.allFinite(), "a box is not finite");
  for (double time : command.new_sessions_s) require(std::isfinite(time), "a time is none");
  require(arguments.left != arguments.right, "one of two is not asked for");
  app::split_list(arguments.text);
  if (!arguments.file.empty()) command.check_derived_output(arguments.file + ".dat");
}

// Messages of every kind, and an end with each exit code.
int say(app::Command& command, const Arguments& arguments) {
  command.progress(arguments.text);
  command.warn(arguments.text);
  command.tell(arguments.text);
  command.report(arguments.text);
  if (arguments.count == 2) throw app::UsageError(arguments.text);
  if (arguments.count == 3) throw InputError(arguments.text);
  return app::kSuccess;
}

// One argument on each line.
void parse_arguments(const std::string& bytes) {
  std::vector<std::string> words{"fuzz"};
  std::istringstream lines(bytes.substr(0, bytes.find('\0')));
  for (std::string line; std::getline(lines, line);) words.push_back(line);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  app::Command command("fuzz", "Reads arguments.", "fuzz --value 1");
  Arguments arguments;
  add_options(command, arguments);
  command.run(static_cast<int>(argv.size()), argv.data(), [&] {
    use(command, arguments);
    return say(command, arguments);
  });
}

constexpr Target kArguments[] = {{"arguments", parse_arguments}};

}  // namespace

std::span<const Target> argument_targets() { return kArguments; }

}  // namespace armtrue::fuzz
