#include "programs/kuka/krl_zones.h"

#include <string_view>

#include "armtrue/kinematics/units.h"
#include "programs/kuka/krl_words.h"
#include "programs/statement.h"

namespace armtrue {
namespace {

constexpr double kNotKnown = -1;

}  // namespace

KrlZones::KrlZones(const std::string& src, const KrlSyntax& syntax) : src_(src), syntax_(syntax) {
  std::vector<ProgramFlow::Setting> settings;
  for (const KrlSetUp& statement : syntax.zones) {
    TextCursor cursor(src, statement.begin, statement.end);
    std::optional<double> distance;
    if (cursor.take_name() == "$APO")
      distance = set_behind_apo(cursor);
    else if (cursor.take('='))
      distance = distance_of_ldat(cursor.take_name());
    if (!distance) continue;
    settings.push_back({statement.begin, *distance < 0 ? -1 : static_cast<int>(distances_.size())});
    distances_.push_back(*distance);
  }
  values_ = syntax.steps.flow().follow(settings, -1);
}

std::optional<double> KrlZones::set_behind_apo(TextCursor cursor) const {
  const bool is_component = cursor.take('.');
  if (is_component && cursor.take_name() != "CDIS") return std::nullopt;
  if (!cursor.take('=')) return kNotKnown;
  if (!is_component) {
    if (!cursor.take('{'))
      return cursor.take_name() == "SAPO" && cursor.take('(') ? distance_of_ldat(cursor.take_name())
                                                              : kNotKnown;
    while (cursor.take_name() != "CDIS") {
      cursor.skip_to(",}");
      if (!cursor.take(',')) return std::nullopt;
    }
  }
  const std::optional<double> number = cursor.take_number();
  const bool is_plain = std::string_view("+-*/").find(cursor.next()) == std::string_view::npos;
  return number && is_plain ? *number : kNotKnown;
}

double KrlZones::distance_of_ldat(const std::string& name) const {
  const auto found = syntax_.ldats.find(name);
  return found == syntax_.ldats.end() ? kNotKnown : found->second;
}

double KrlZones::blend_of(const KrlMove& move) const {
  bool is_approximated = false;
  std::optional<double> own;
  each_word(src_, {move.line, move.target.end, move.end},
            [&](const std::string& word, size_t, const TextCursor& cursor) {
              is_approximated |= word == "C_DIS" || word == "C_SPL";
              if (word == "$APO") own = set_behind_apo(cursor);
            });
  if (!is_approximated) return 0;
  const int value = values_.at(move.begin);
  const double distance = own ? *own : value < 0 ? kNotKnown : distances_[value];
  return distance < 0 ? 0 : distance * kMillimetre;
}

}  // namespace armtrue
