#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "programs/text_cursor.h"

// Statements and nested lists, as RAPID, URScript and LS files have them.

namespace armtrue {

/// A part of a text; `line` counts from 1.
struct Statement {
  int line = 0;
  size_t begin = 0, end = 0;
};

/// The text with blanks in place of comments, and `_` in place of what stands between quotes:
/// every other byte keeps its place. A comment goes from `comment` to the end of its line.
std::string masked(std::string_view text, char comment, std::string_view quotes);

/// The parts between separators that stand in no brackets, without blanks before them; line ends
/// within them become blanks of `text`. With '\n' as the separator brackets join lines.
std::vector<Statement> split_statements(std::string& text, char separator);

/// The lines of a text from a place on, each without its line end.
std::vector<Statement> lines_of(std::string_view text, size_t begin = 0);

/// Calls with(word, at, cursor) for each word of a statement, in capitals; `cursor` stands behind
/// it and may be moved.
template <class With>
void each_word(std::string_view text, const Statement& statement, With with) {
  TextCursor cursor(text, statement.begin, statement.end);
  while (!cursor.done()) {
    const size_t at = cursor.at();
    const std::string word = cursor.take_name();
    if (word.empty())
      cursor.step();
    else
      with(word, at, cursor);
  }
}

/// Parts of `text` from `begin` to `end` between separators outside of brackets, without blanks
/// around them.
std::vector<Statement> split_arguments(std::string_view text, size_t begin, size_t end,
                                       std::string_view separators);

/// The number of the line that a place stands in, from 1.
int line_at(std::string_view text, size_t at);
/// The same of a place in a statement; `original`: the text with its line ends.
int line_at(std::string_view original, const Statement& statement, size_t at);
/// Where the line begins that a place stands in.
size_t line_begin(std::string_view text, size_t at);
/// The end of the line that a place stands in, or of the line before it: "\n" or "\r\n".
std::string line_end(std::string_view text, size_t at);

/// Where the first line begins that begins with a word; npos if there is none.
size_t line_that_begins(std::string_view text, std::string_view word);

/// Whether a part of a text is an assignment, NAME = .. or NAME := .., that calls nothing: it
/// drives no arm.
bool is_plain_assignment(std::string_view text, size_t begin, size_t end);

/// A number, a list in square brackets, or anything else.
struct ListItem {
  enum class Kind { number, list, other } kind = Kind::other;
  size_t begin = 0, end = 0;  ///< in the text
  double value = 0;
  std::vector<ListItem> items;

  /// The numbers of a list of so many numbers; nothing if it is anything else.
  std::optional<std::vector<double>> numbers(size_t count) const;
};

/// Reads what stands from the cursor to the next comma or bracket that closes. At most 16 lists
/// stand in one another; nothing else is a list.
ListItem take_item(TextCursor& cursor, int depth = 0);

/// The list that makes up a whole part of a text.
std::optional<ListItem> list_in(std::string_view text, size_t begin, size_t end);

}  // namespace armtrue
