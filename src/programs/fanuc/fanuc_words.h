#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "programs/statement.h"

namespace armtrue {

/// The word of an English listing for one of a German listing, in capitals: CALL for AUFRUF; others
/// stay. A[1] and I[1] of German are DO[1] and R[1]; A and I alone stay.
std::string in_english(const std::string& word, bool has_index = false);

/// each_word() with the words of an English listing.
template <class With>
void each_fanuc_word(std::string_view text, const Statement& statement, With with) {
  each_word(text, statement, [&](const std::string& word, size_t at, TextCursor& cursor) {
    with(in_english(word, cursor.next() == '['), at, cursor);
  });
}

/// The next word, with that of an English listing for a German one.
std::string take_fanuc_word(TextCursor& cursor);

/// Adds lines to LINE_COUNT of a program; nothing if it states none.
struct FanucLineCount {
  size_t begin = 0, end = 0;  ///< of the number; 0: none
  std::string text;           ///< the new one
};
FanucLineCount fanuc_line_count(std::string_view text, size_t added);

}  // namespace armtrue
