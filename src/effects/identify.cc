#include "armtrue/effects/identify.h"

#include <algorithm>
#include <cctype>
#include <numeric>

#include "armtrue/effects/effect.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {
namespace {

constexpr size_t kMostNamed = 6;  // in a message

// The names that an entry may have: of the parameters that have a constant.
std::vector<std::string> names_of(const KinematicChain& chain) {
  const ParameterLayout layout = layout_of(chain);
  std::vector<std::string> names;
  for (int index = 0; index < parameter_count(chain); ++index)
    if (layout.has_constant(index)) names.push_back(parameter_name(chain, index));
  return names;
}

enum class Letters { exact, any_case };

bool same(char a, char b, Letters letters) {
  const auto lower = [](unsigned char c) { return std::tolower(c); };
  return letters == Letters::exact ? a == b : lower(a) == lower(b);
}

// Levenshtein distance of a text from the nearest text that matches the pattern.
int distance(std::string_view pattern, std::string_view text, Letters letters) {
  std::vector<int> before(text.size() + 1);
  std::iota(before.begin(), before.end(), 0);
  for (const char wanted : pattern) {
    std::vector<int> now(before.size());
    const bool any = wanted == '*';
    now[0] = before[0] + (any ? 0 : 1);
    for (size_t j = 1; j <= text.size(); ++j) {
      const bool fits = wanted == '?' || same(wanted, text[j - 1], letters);
      now[j] = any ? std::min({before[j], now[j - 1], before[j - 1]})
                   : std::min({before[j] + 1, now[j - 1] + 1, before[j - 1] + (fits ? 0 : 1)});
    }
    before = std::move(now);
  }
  return before.back();
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (size_t k = 0; k < std::min(names.size(), kMostNamed); ++k)
    text += (k == 0 ? "" : ", ") + names[k];
  if (names.size() > kMostNamed)
    text += " and " + std::to_string(names.size() - kMostNamed) + " more";
  return text;
}

// The names that are nearest to one that the robot does not have; "" if none is near.
std::string did_you_mean(const KinematicChain& chain, const std::string& name) {
  std::vector<std::string> known = names_of(chain), nearest;
  for (const char* word : {"auto", "paper-25", "base", "tool"}) known.emplace_back(word);
  int least = static_cast<int>(name.size()) / 3 + 1;  // a third of the characters may be wrong
  for (const std::string& one : known) {
    const int apart = distance(name, one, Letters::any_case);
    if (apart > least) continue;
    if (apart < least) nearest.clear();
    least = apart;
    nearest.push_back(one);
  }
  if (nearest.empty()) return "";
  return "; did you mean " + listed(nearest) + "?";
}

}  // namespace

IdentifyEntry::IdentifyEntry(std::string_view text) {
  takes_away = text.starts_with('-');
  if (takes_away) text.remove_prefix(1);
  while (text.starts_with(' ')) text.remove_prefix(1);
  name = text;
}

bool matches(std::string_view pattern, std::string_view text) {
  return distance(pattern, text, Letters::exact) == 0;
}

bool is_pattern(const KinematicChain& chain, const std::string& name) {
  return name.find_first_of("*?") != name.npos && !find_parameter(chain, name);
}

std::string why_not_identified(const KinematicChain& chain,
                               const std::vector<std::string>& identify) {
  if (!identify.empty() && IdentifyEntry(identify.front()).takes_away)
    return "'" + identify.front() +
           "' takes away from nothing: name first what stays, such as auto," + identify.front();
  for (const std::string& text : identify) {
    const std::string name = IdentifyEntry(text).name;
    if (name == "auto" || name == "paper-25") continue;
    if (is_pattern(chain, name)) {
      const auto is_matched = [&](const std::string& one) { return matches(name, one); };
      if (std::ranges::any_of(names_of(chain), is_matched)) continue;
      return "no parameter of the robot is as '" + name + "' says" + did_you_mean(chain, name);
    }
    if (group_size(Parameter(name)) == kParametersPerPose) continue;
    const auto index = find_parameter(chain, name);
    if (index && *index == layout_of(chain).arm_scale)
      return "'" + name + "' is all lengths at once; its constant is 0, and only effects change it";
    if (index && layout_of(chain).is_of_instrument(*index))
      return "'" + name +
             "' belongs to the instrument; its constant is 0, and only effects change it";
    if (index) continue;
    const std::string near = did_you_mean(chain, name);
    std::string links;
    for (const Link& link : chain.links) links += (links.empty() ? "" : ", ") + link.name;
    const std::string example = chain.links[chain.links.size() > 1 ? 1 : 0].name + ".d";
    return "the robot has no parameter '" + name + "'" +
           (near.empty() ? "; use auto, paper-25, base, tool, names such as " + example +
                               ", base.x, tool.rz, patterns such as *.theta, and - before what is "
                               "taken away, as in auto,-" +
                               example + "; the links are " + links
                         : near);
  }
  return "";
}

bool identifies_all(const std::vector<std::string>& identify) {
  return std::ranges::count(identify, "auto") > 0 &&
         std::ranges::none_of(
             identify, [](const std::string& entry) { return IdentifyEntry(entry).takes_away; });
}

}  // namespace armtrue
