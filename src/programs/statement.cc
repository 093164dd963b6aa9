#include "programs/statement.h"

#include <algorithm>

namespace armtrue {
namespace {

constexpr int kMostDepth = 16;

bool opens(char c) { return c == '(' || c == '[' || c == '{'; }
bool closes(char c) { return c == ')' || c == ']' || c == '}'; }
bool is_space(char c) { return is_blank(c) || c == '\n'; }

}  // namespace

std::string masked(std::string_view text, char comment, std::string_view quotes) {
  std::string result(text);
  char quote = 0;
  bool in_comment = false;
  for (char& c : result) {
    if (c == '\n') {
      quote = 0;
      in_comment = false;
    } else if (in_comment) {
      c = ' ';
    } else if (quote != 0) {
      if (c == quote)
        quote = 0;
      else
        c = '_';
    } else if (quotes.find(c) != std::string_view::npos) {
      quote = c;
    } else if (c == comment) {
      in_comment = true;
      c = ' ';
    }
  }
  return result;
}

std::vector<Statement> split_statements(std::string& text, char separator) {
  std::vector<Statement> result;
  int line = 1, depth = 0;
  Statement open;
  bool is_open = false;
  for (size_t i = 0; i < text.size(); ++i) {
    char& c = text[i];
    if (c == ';') depth = 0;  // stands in no brackets
    const bool is_end = c == separator && depth == 0;
    if (c == '\n') {
      ++line;
      c = ' ';
    }
    if (is_end) {
      if (is_open) result.push_back({open.line, open.begin, i});
      is_open = false;
      continue;
    }
    if (opens(c)) ++depth;
    if (closes(c)) depth = std::max(0, depth - 1);
    if (!is_open && !is_blank(c)) open = {line, i, i};
    is_open |= !is_blank(c);
  }
  if (is_open) result.push_back({open.line, open.begin, text.size()});
  return result;
}

std::vector<Statement> lines_of(std::string_view text, size_t begin) {
  std::vector<Statement> lines;
  for (int line = line_at(text, std::min(begin, text.size())); begin < text.size(); ++line) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back({line, begin, end});
    begin = end + 1;
  }
  return lines;
}

std::vector<Statement> split_arguments(std::string_view text, size_t begin, size_t end,
                                       std::string_view separators) {
  std::vector<Statement> result;
  int depth = 0;
  const auto add = [&](size_t from, size_t to) {
    while (from < to && is_space(text[from])) ++from;
    while (to > from && is_space(text[to - 1])) --to;
    result.push_back({0, from, to});
  };
  size_t from = begin;
  for (size_t i = begin; i < end; ++i) {
    if (opens(text[i])) ++depth;
    if (closes(text[i])) --depth;
    if (depth > 0 || separators.find(text[i]) == std::string_view::npos) continue;
    add(from, i);
    from = i + 1;
  }
  add(from, end);
  return result;
}

int line_at(std::string_view text, size_t at) {
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + at, '\n'));
}

int line_at(std::string_view original, const Statement& statement, size_t at) {
  return statement.line +
         line_at(original.substr(statement.begin, at - statement.begin), at - statement.begin) - 1;
}

size_t line_begin(std::string_view text, size_t at) {
  const size_t newline = at == 0 ? std::string_view::npos : text.rfind('\n', at - 1);
  return newline == std::string_view::npos ? 0 : newline + 1;
}

std::string line_end(std::string_view text, size_t at) {
  size_t newline = text.find('\n', at);
  if (newline == std::string_view::npos && line_begin(text, at) > 0)
    newline = line_begin(text, at) - 1;
  const bool returns =
      newline != std::string_view::npos && newline > 0 && text[newline - 1] == '\r';
  return returns ? "\r\n" : "\n";
}

size_t line_that_begins(std::string_view text, std::string_view word) {
  for (size_t at = text.find(word); at != std::string_view::npos; at = text.find(word, at + 1))
    if (at == 0 || text[at - 1] == '\n') return at;
  return std::string_view::npos;
}

bool is_plain_assignment(std::string_view text, size_t begin, size_t end) {
  TextCursor cursor(text, begin, end);
  if (cursor.take_name().empty()) return false;
  while (cursor.next() == '.' || cursor.next() == '[' || cursor.next() == '{') {
    const char close = cursor.next() == '[' ? ']' : '}';
    if (cursor.take('.')) {
      if (cursor.take_name().empty()) return false;
      continue;
    }
    cursor.skip_to(std::string_view(&close, 1));
    if (!cursor.take(close)) return false;
  }
  cursor.take(':');
  if (!cursor.take('=') || cursor.next() == '=') return false;
  char before = ' ';
  for (size_t i = cursor.at(); i < end; ++i) {
    if (text[i] == '(' && (is_letter(before) || is_digit(before))) return false;
    if (!is_blank(text[i])) before = text[i];
  }
  return true;
}

std::optional<std::vector<double>> ListItem::numbers(size_t count) const {
  if (kind != Kind::list || items.size() != count) return std::nullopt;
  std::vector<double> values;
  for (const ListItem& item : items) {
    if (item.kind != Kind::number) return std::nullopt;
    values.push_back(item.value);
  }
  return values;
}

ListItem take_item(TextCursor& cursor, int depth) {
  ListItem item;
  const char first = cursor.next();
  item.begin = cursor.at();
  const auto is_end = [&] { return cursor.done() || cursor.next() == ',' || cursor.next() == ']'; };
  if (first == '[' && depth < kMostDepth) {
    cursor.step();
    item.kind = ListItem::Kind::list;
    do {
      item.items.push_back(take_item(cursor, depth + 1));
    } while (cursor.take(','));
    if (!cursor.take(']')) item.kind = ListItem::Kind::other;
  } else if (const auto value = cursor.take_number()) {
    item.kind = ListItem::Kind::number;
    item.value = *value;
  }
  item.end = cursor.at();
  if (!is_end()) {
    item.kind = ListItem::Kind::other;
    cursor.skip_to(",]");
    item.end = cursor.at();
  }
  return item;
}

std::optional<ListItem> list_in(std::string_view text, size_t begin, size_t end) {
  TextCursor cursor(text, begin, end);
  if (cursor.next() != '[') return std::nullopt;
  const ListItem item = take_item(cursor);
  if (item.kind != ListItem::Kind::list || !cursor.done()) return std::nullopt;
  return item;
}

}  // namespace armtrue
