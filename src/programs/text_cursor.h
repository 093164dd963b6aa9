#pragma once

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

// The characters of robot programs: names, numbers, blanks.

namespace armtrue {

inline bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '$';
}
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// The text with the letters a to z as capitals: most languages do not tell them apart.
inline std::string upper(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return result;
}

/// In capitals, without blanks.
inline std::string compact(std::string_view text) {
  std::string result = upper(text);
  std::erase_if(result, is_blank);
  return result;
}

inline bool contains(std::initializer_list<std::string_view> words, std::string_view word) {
  return std::ranges::find(words, word) != words.end();
}

/// Reads a part of a text from left to right. Blanks before whatever is asked for are skipped.
class TextCursor {
 public:
  TextCursor(std::string_view text, size_t begin, size_t end)
      : text_(text), at_(begin), end_(end) {}

  size_t at() const { return at_; }
  size_t end() const { return end_; }
  /// Whether only blanks are left.
  bool done() {
    skip_blanks();
    return at_ == end_;
  }
  /// The next character that is no blank; 0 at the end.
  char next() {
    skip_blanks();
    return at_ < end_ ? text_[at_] : '\0';
  }
  void step() { ++at_; }
  /// Steps behind `c` and returns true if `c` is the next character.
  bool take(char c) {
    if (next() != c) return false;
    ++at_;
    return true;
  }
  /// Takes a name and returns it in capitals; empty if none stands here.
  std::string take_name();
  /// Takes a decimal number with its sign; takes nothing if none stands here.
  std::optional<double> take_number();
  /// Moves to the next of the separators, or to the end.
  void skip_to(std::string_view separators) {
    while (at_ < end_ && separators.find(text_[at_]) == std::string_view::npos) ++at_;
  }

 private:
  void skip_blanks() {
    while (at_ < end_ && is_blank(text_[at_])) ++at_;
  }

  std::string_view text_;
  size_t at_, end_;
};

}  // namespace armtrue
