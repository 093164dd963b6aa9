#include "programs/fanuc/fanuc_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

// The words of German listings are those that 211 public programs have in both languages.

namespace armtrue {

std::string in_english(const std::string& word, bool has_index) {
  static const std::map<std::string, std::string> kWords{
      {"AUFRUF", "CALL"},       {"BALM", "UALM"},
      {"BENUTZER", "UFRAME"},   {"BENUTZER_NUM", "UFRAME_NUM"},
      {"ENDE", "END"},          {"GA", "GO"},
      {"INTERRUPT", "SKIP"},    {"KONFIG", "CONFIG"},
      {"LABEL", "LBL"},         {"MAX_GESCHW", "MAX_SPEED"},
      {"MELDUNG", "MESSAGE"},   {"SEK", "SEC"},
      {"SONST", "ELSE"},        {"SPRUNG", "JMP"},
      {"TRAGLST", "PAYLOAD"},   {"WARTE", "WAIT"},
      {"WENN", "IF"},           {"WKZ", "UTOOL"},
      {"WKZ_NUM", "UTOOL_NUM"}, {"WKZ_OFFSET", "TOOL_OFFSET"},
      {"ZEILEN", "LINE_COUNT"}};
  if (has_index && word == "A") return "DO";
  if (has_index && word == "I") return "R";
  const auto found = kWords.find(word);
  return found == kWords.end() ? word : found->second;
}

std::string take_fanuc_word(TextCursor& cursor) {
  const std::string word = cursor.take_name();
  return word.empty() ? word : in_english(word, cursor.next() == '[');
}

// LINE_COUNT = 3;
FanucLineCount fanuc_line_count(std::string_view text, size_t added) {
  const size_t begin = line_that_begins(text, "/ATTR");
  const size_t end = std::min(line_that_begins(text, "/MN"), text.size());
  FanucLineCount count;
  if (begin >= end) return count;
  each_fanuc_word(text, {0, begin, end}, [&](const std::string& word, size_t, TextCursor cursor) {
    if (word != "LINE_COUNT" || count.end > 0 || !cursor.take('=')) return;
    cursor.next();
    const size_t at = cursor.at();
    if (const auto lines = cursor.take_number())
      count = {at, cursor.at(), fmt::format("{}", *lines + static_cast<double>(added))};
  });
  return count;
}

}  // namespace armtrue
