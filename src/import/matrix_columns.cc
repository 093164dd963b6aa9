#include "import/matrix_columns.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "armtrue/text/edit_distance.h"
#include "import/column_names.h"

namespace armtrue {
namespace {

constexpr std::array kLetters{"r",   "m",      "t",  "h",         "rot",  "rotation", "rotmat",
                              "mat", "matrix", "tf", "transform", "pose", "dcm"};

struct Element {
  std::string letters;
  int row, column;
};

std::optional<Element> element_of(std::string_view header) {
  std::string text = lower_case(column_name(header).stem);
  std::erase_if(text, [](char c) {
    return std::string_view("[](){},;:_ .-/").find(c) != std::string_view::npos;
  });
  const size_t digits = text.find_first_of("0123456789");
  if (digits == text.npos || digits + 2 != text.size()) return std::nullopt;
  const std::string letters = text.substr(0, digits);
  const int row = text[digits] - '0', column = text[digits + 1] - '0';
  if (std::ranges::find(kLetters, letters) == kLetters.end() || row > 4 || column > 4 || column < 0)
    return std::nullopt;
  return Element{letters, row, column};
}

using Places = std::map<std::pair<int, int>, int>;  // columns of the table by row and column

// The quantities of one matrix whose elements count from `first`; empty if some are missing.
std::map<int, std::string> quantities_of(const Places& places, int first) {
  std::map<int, std::string> quantities;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      const auto found = places.find({first + row, first + column});
      if (found == places.end()) return {};
      quantities[found->second] = "r" + std::to_string(row + 1) + std::to_string(column + 1);
    }
  for (int k = 0; k < 4; ++k) {
    if (const auto of_point = places.find({first + k, first + 3});
        k < 3 && of_point != places.end())
      quantities[of_point->second] = std::string(1, "xyz"[k]);
    if (const auto of_last = places.find({first + 3, first + k}); of_last != places.end())
      quantities[of_last->second] = "";
  }
  return quantities;
}

}  // namespace

bool is_matrix_element(std::string_view header) { return element_of(header).has_value(); }

std::map<int, std::string> matrix_columns(const PlainTable& table,
                                          const std::function<bool(int)>& is_free) {
  std::map<std::string, Places> by_letters;
  for (int k = 0; k < std::ssize(table.columns); ++k)
    if (const auto element = element_of(table.columns[k].name); element && is_free(k))
      by_letters[element->letters].emplace(std::pair(element->row, element->column), k);
  std::map<int, std::string> found;
  for (const auto& [letters, places] : by_letters) {
    const std::map<int, std::string> quantities =
        quantities_of(places, places.contains({0, 0}) ? 0 : 1);
    if (!quantities.empty() && !found.empty())
      table.fail_header("two matrices stand here, of " + table.columns[found.begin()->first].name +
                        " and of " + table.columns[quantities.begin()->first].name +
                        "; leave one out with --ignore");
    if (!quantities.empty()) found = quantities;
  }
  return found;
}

}  // namespace armtrue
