#include "programs/yaskawa/inform_positions.h"

#include <algorithm>

#include "armtrue/kinematics/units.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

constexpr size_t kNumbers = 6;

std::string_view without_blanks_behind(std::string_view line) {
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  return line;
}

class InformPositionReader {
 public:
  InformPositionReader(std::string_view text, const std::vector<double>* pulses)
      : text_(text), pulses_(pulses) {}

  std::map<std::string, InformPosition> read() {
    for (const auto& [line, begin, end] : lines_of(text_)) {
      TextCursor cursor(text_, begin, end);
      if (cursor.take('/'))
        read_head(cursor, without_blanks_behind(text_.substr(begin, end - begin)), end);
      else
        read_position(cursor, line);
    }
    return std::move(positions_);
  }

 private:
  // ///USER 1
  void read_head(TextCursor& cursor, std::string_view whole, size_t end) {
    while (cursor.take('/')) continue;
    const std::string word = cursor.take_name();
    const auto set = [&](InformHeads::Line line) { heads_.lines[line] = whole; };
    const auto number = [&]() -> std::optional<int> {
      constexpr double kMost = 1000;
      const auto value = cursor.take_number();
      return value && *value >= 0 && *value < kMost ? std::optional(static_cast<int>(*value))
                                                    : std::nullopt;
    };
    if (word == "USER") {
      set(InformHeads::user);
      user_ = number();
    } else if (word == "TOOL") {
      set(InformHeads::tool);
      tool_ = number();
    } else if (word == "POSTYPE") {
      set(InformHeads::type);
      type_ = cursor.take_name();
    } else if (word == "PULSE" || word == "RECTAN" || word == "ANGLE") {
      set(InformHeads::data);
      data_ = word;
    } else if (word == "RCONF") {
      set(InformHeads::configuration);
      cursor.next();
      configuration_ = inform_configuration(text_.substr(cursor.at(), end - cursor.at()));
    }
  }

  // C00001=1.0,2.0,3.0,4.0,5.0,6.0
  void read_position(TextCursor& cursor, int line) {
    cursor.next();
    const size_t begin = cursor.at();
    const std::string word = cursor.take_name();
    const std::string station = inform_station_name(word);
    const std::string name = station.empty() ? inform_position_name(word) : station;
    if (name.empty() || !cursor.take('=')) return;
    InformPosition position;
    size_t end = cursor.at();
    do {
      cursor.next();
      const size_t from = cursor.at();
      const auto value = cursor.take_number();
      if (!value) break;
      end = cursor.at();
      position.numbers.push_back({0, from, end, *value, ""});
    } while (cursor.take(','));
    position.begin = begin;
    position.end = end;
    position.line = line;
    position.heads = heads_;
    position.tool = tool_;
    describe(position);
    if (!cursor.done() || position.numbers.size() < kNumbers)
      position.why_not = "its position has no six plain numbers";
    const auto seventh = position.numbers.begin() + std::min(kNumbers, position.numbers.size());
    if (std::any_of(seventh, position.numbers.end(),
                    [](const ProgramNumber& number) { return number.value != 0; }))
      position.why_not = "its position has more than six axes";
    position.numbers.erase(seventh, position.numbers.end());
    const auto [known, is_new] = positions_.try_emplace(name, position);
    if (!is_new) known->second.why_not = "its position is given twice";
  }

  void describe(InformPosition& position) const {
    if ((type_ == "PULSE" || data_ == "PULSE") && pulses_) {
      position.kind = InformPosition::Kind::joints;
      position.pulses_per_degree = *pulses_;
    } else if (type_ == "PULSE" || data_ == "PULSE") {
      position.why_not =
          "its position is in pulses, and nothing says how many a degree has; give RC.PRM or "
          "ALL.PRM of the controller (--with), or save the job as a relative job";
    } else if (type_ == "ANGLE" || data_ == "ANGLE") {
      position.kind = InformPosition::Kind::joints;
    } else {
      position.kind = InformPosition::Kind::pose;
      position.configuration = configuration_;
      if (type_ == "USER") position.user = user_;
      if (type_ == "USER" && !user_) position.why_not = "its user frame has no number";
      if (type_ != "USER" && type_ != "ROBOT" && type_ != "BASE")
        position.why_not =
            "the type of its position is not followed: " + (type_.empty() ? "none" : type_);
    }
  }

  std::string_view text_;
  const std::vector<double>* pulses_;
  std::map<std::string, InformPosition> positions_;
  InformHeads heads_;
  std::optional<int> user_, tool_;
  std::string type_, data_;
  Configuration configuration_;
};

}  // namespace

std::string InformHeads::change_from(const InformHeads& now, const std::string& line_end) const {
  // A type begins a list of its own, so what follows it is said again.
  const bool is_other_type = lines[type] != now.lines[type] || lines[data] != now.lines[data];
  std::string text;
  for (size_t i = 0; i < lines.size(); ++i)
    if (!lines[i].empty() && (lines[i] != now.lines[i] || (is_other_type && i >= type)))
      text += lines[i] + line_end;
  return text;
}

std::string inform_position_name(std::string_view word) {
  constexpr size_t kMostDigits = 6;
  if (word.size() < 2 || word.size() > kMostDigits + 1 || (word[0] != 'C' && word[0] != 'P'))
    return "";
  if (!std::ranges::all_of(word.substr(1), is_digit)) return "";
  const size_t first = std::min(word.find_first_not_of('0', 1), word.size() - 1);
  return std::string(1, word[0]) + std::string(word.substr(first));
}

std::string inform_station_name(std::string_view word) {
  if (!word.starts_with("EC") && !word.starts_with("BC")) return "";
  const std::string number = inform_position_name(word.substr(1));
  return number.empty() ? "" : word[0] + number;
}

std::map<std::string, InformPosition> inform_positions(std::string_view text,
                                                       const std::vector<double>* pulses) {
  return InformPositionReader(text, pulses).read();
}

// At S L U R B T = 0 0 0 0 -90 0, the tool downwards, the wrist is not flipped (B below zero), the
// elbow is up and the arm in front.
Configuration inform_configuration(std::string_view numbers) {
  Configuration result;
  result.reference << 0, 0, 0, 0, -90, 0;
  result.reference *= kDegree;
  TextCursor cursor(numbers, 0, numbers.size());
  std::array<int, 6> flags{};
  for (int& flag : flags) {
    const auto value = cursor.take_number();
    if (!value || (*value != 0 && *value != 1)) return {};
    flag = static_cast<int>(*value);
    cursor.take(',');
  }
  result.sides = {flags[2] == 0 ? 1 : -1, flags[1] == 0 ? 1 : -1, flags[0] == 1 ? 1 : -1};
  constexpr std::array<int, 3> kAxes{3, 5, 0};  // R, T, S
  for (size_t i = 0; i < kAxes.size(); ++i) {
    if (flags[i + 3] != 0) continue;  // beyond 180 deg to either side
    result.low[kAxes[i]] = -180 * kDegree;
    result.high[kAxes[i]] = 180 * kDegree;
  }
  return result;
}

}  // namespace armtrue
