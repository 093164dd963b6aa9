#include "programs/yaskawa/inform_listing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "programs/path_name.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

constexpr size_t kAxes = 6;

void add(std::map<int, std::vector<double>>& all, int number, const std::vector<double>& values) {
  const auto [known, is_new] = all.try_emplace(number, values);
  if (!is_new && known->second != values) known->second.clear();
}

std::optional<std::vector<double>> find(const std::map<int, std::vector<double>>& all, int number) {
  const auto found = all.find(number);
  if (found == all.end() || found->second.empty()) return std::nullopt;
  return found->second;
}

std::vector<double> numbers_in(TextCursor& cursor) {
  std::vector<double> numbers;
  while (const auto number = cursor.take_number()) {
    numbers.push_back(*number);
    if (!cursor.take(',')) break;
  }
  return numbers;
}

// Where the parameters of a robot, ///RC1G, have the gear ratios and, to check them, the upper
// limits of the axes in pulses. DX controllers have 1700 parameters, YRC1000 3000.
struct Places {
  size_t limits, denominators, numerators;
};
Places places_among(size_t parameters) {
  constexpr size_t kLongest = 2000;
  return parameters < kLongest ? Places{924, 972, 980} : Places{1030, 1090, 1100};
}

// Pulses per deg = 4096 / 360 * numerator / denominator, whose signs are those of the motors.
// Nothing of an arm of other than six axes, or if the limits are not angles then.
std::optional<std::vector<double>> pulses_by(const std::vector<double>& parameters) {
  constexpr double kPulsesOfMotor = 4096, kTurn = 360, kMostDegrees = 1000;
  const Places places = places_among(parameters.size());
  if (parameters.size() < places.numerators + kAxes + 1) return std::nullopt;
  if (parameters[places.denominators + kAxes] * parameters[places.numerators + kAxes] != 0)
    return std::nullopt;
  std::vector<double> pulses;
  for (size_t i = 0; i < kAxes; ++i) {
    const double ratio =
        std::abs(parameters[places.numerators + i] / parameters[places.denominators + i]);
    const double value = kPulsesOfMotor / kTurn * ratio;
    const double limit = parameters[places.limits + i] / value;
    if (!std::isfinite(value) || !(limit > 0 && limit < kMostDegrees)) return std::nullopt;
    pulses.push_back(value);
  }
  return pulses;
}

class ListingReader {
 public:
  ListingReader(const std::string& text, InformListing& listing) : text_(text), listing_(listing) {}

  void read() {
    for (size_t begin = 0; begin < text_.size();) {
      const size_t end = std::min(text_.find('\n', begin), text_.size());
      TextCursor cursor(text_, begin, end);
      int slashes = 0;
      while (cursor.take('/')) ++slashes;
      if (slashes > 0)
        read_head(cursor, slashes);
      else
        read_numbers(cursor);
      begin = end + 1;
    }
    end_robot();
  }

 private:
  void read_head(TextCursor& cursor, int slashes) {
    const std::string word = cursor.take_name();
    if (word == "BUSER" && user_) return keep(listing_.users, user_, numbers_in(cursor));
    end_robot();
    if (word == "PULSES") {  // of text_of()
      const auto number = take_index(cursor);
      if (number) keep(listing_.pulses, number, numbers_in(cursor));
    }
    if (slashes == 2) {
      tool_ = word == "TOOL" ? take_index(cursor) : std::nullopt;
      user_ = word == "UFRAME" ? take_index(cursor) : std::nullopt;
    }
    // RC1G
    if (word.size() == 4 && word.starts_with("RC") && word[3] == 'G' && is_digit(word[2]))
      robot_ = word[2] - '0';
  }

  void read_numbers(TextCursor& cursor) {
    if (!robot_ && !tool_) return;
    const std::vector<double> numbers = numbers_in(cursor);
    if (robot_) parameters_.insert(parameters_.end(), numbers.begin(), numbers.end());
    if (tool_ && !numbers.empty()) {  // the first line of numbers; load and inertia follow
      keep(listing_.tools, tool_, numbers);
      tool_.reset();
    }
  }

  static std::optional<int> take_index(TextCursor& cursor) {
    constexpr double kMost = 1000;
    const auto number = cursor.take_number();
    return number && *number >= 0 && *number < kMost ? std::optional(static_cast<int>(*number))
                                                     : std::nullopt;
  }

  static void keep(std::map<int, std::vector<double>>& all, std::optional<int> number,
                   const std::vector<double>& values) {
    if (number && values.size() == kAxes) add(all, *number, values);
  }

  void end_robot() {
    if (const auto pulses = robot_ ? pulses_by(parameters_) : std::nullopt)
      add(listing_.pulses, *robot_, *pulses);
    robot_.reset();
    parameters_.clear();
  }

  const std::string& text_;
  InformListing& listing_;
  std::optional<int> robot_, tool_, user_;  // whose lines are read
  std::vector<double> parameters_;          // of the robot
};

}  // namespace

const std::vector<double>* InformListing::pulses_of(int robot) const {
  const auto found = pulses.find(robot);
  return found == pulses.end() || found->second.empty() ? nullptr : &found->second;
}

std::optional<std::vector<double>> InformListing::tool(int number) const {
  return find(tools, number);
}

std::optional<std::vector<double>> InformListing::user(int number) const {
  return find(users, number);
}

bool is_inform_listing(const std::string& name) {
  const std::string ending = ending_of(name);
  return ending == ".PRM" || ending == ".CND";
}

void read_inform_listing(const std::string& text, InformListing& listing) {
  ListingReader(text, listing).read();
}

std::string text_of(const InformListing& listing) {
  std::string text;
  for (const auto& [robot, values] : listing.pulses)
    text += fmt::format("///PULSES {} {}\n", robot, fmt::join(values, ","));
  for (const auto& [number, values] : listing.tools)
    text += fmt::format("//TOOL {}\n{}\n", number, fmt::join(values, ","));
  for (const auto& [number, values] : listing.users)
    text += fmt::format("//UFRAME {}\n////BUSER {}\n", number, fmt::join(values, ","));
  return text;
}

}  // namespace armtrue
