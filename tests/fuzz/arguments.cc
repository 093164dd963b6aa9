// The command line: one option of every kind, and the readers of lists, boxes and zones.

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "../../apps/command_line.h"
#include "fuzz/targets.h"

namespace armtrue::fuzz {
namespace {

struct Arguments {
  std::string text, zone, unit = "mm", number = "1";
  double value = 1, above = 1, range = 1;
  int count = 1;
  std::optional<double> maybe;
  std::vector<std::string> texts, each;
  std::vector<double> box, joints;
  bool flag = false;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_seed();
  command.add_new_sessions();
  const app::Option text = command.option("--text", arguments.text, "A text");
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
  app::split_list(arguments.text);
}

// One argument on each line.
void parse_arguments(const std::string& bytes) {
  std::vector<std::string> words{"fuzz", ""};
  for (char c : bytes.substr(0, bytes.find('\0')))
    if (c == '\n')
      words.emplace_back();
    else
      words.back() += c;
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  app::Command command("fuzz", "Reads arguments.", "fuzz --value 1");
  Arguments arguments;
  add_options(command, arguments);
  command.run(static_cast<int>(argv.size()), argv.data(), [&] {
    use(command, arguments);
    return app::kSuccess;
  });
}

constexpr Target kTargets[] = {{"arguments", parse_arguments}};

}  // namespace

std::span<const Target> argument_targets() { return kTargets; }

}  // namespace armtrue::fuzz
