#include "report/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "report/page_script.h"
#include "report/page_style.h"

namespace armtrue {
namespace {

constexpr double kShownAsZero = 5e-5;  // half the last digit of 0.0000, in mm or mrad

// Signs beside the colours, for those who see none.
const char* sign_of(Tone tone) {
  switch (tone) {
    case Tone::good:
      return "&#10003;";
    case Tone::attention:
      return "!";
    case Tone::bad:
      break;
  }
  return "&#10007;";
}

const char* name_of(Tone tone) {
  switch (tone) {
    case Tone::good:
      return "good";
    case Tone::attention:
      return "warn";
    case Tone::bad:
      break;
  }
  return "bad";
}

std::string path_of(const std::string& list, size_t item) {
  return list + "/" + std::to_string(item);
}

// "KR 360, no. 864201", without what is not stated.
std::string with_serial(const std::string& name, const std::string& serial) {
  return escaped(name) + (serial.empty() ? "" : ", no. " + escaped(serial));
}

std::string about_line(const PageHead& head) {
  if (!head.about) return "";
  const About& about = *head.about;
  std::string html = "<dl>\n";
  const auto item = [&](const char* name, const std::string& text) {
    if (!text.empty())
      html += std::string("<div><dt>") + name + "</dt><dd>" + text + "</dd></div>\n";
  };
  item("Robot", with_serial(about.type, about.serial));
  item("Date", escaped(about.date));
  item("Instrument", with_serial(about.instrument, about.instrument_serial));
  item("Operator", escaped(about.operator_name));
  item("Place", escaped(about.place));
  return html + "</dl>\n";
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string result;
  for (const unsigned char c : text) switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        if (c >= 0x20 || c == '\t' || c == '\n') result += c;
    }
  return result;
}

std::string keyed(const std::string& text, const std::string& key) {
  return "<span data-key=\"" + escaped(key) + "\">" + escaped(text) + "</span>";
}

std::string keyed_value(const std::optional<double>& si, double unit, const std::string& key) {
  if (!si) return "-";
  const double shown = *si / unit;
  return keyed(std::abs(shown) < kShownAsZero ? "0.0000" : fmt::format("{:.4f}", shown), key);
}

std::string keyed_share(double share, const std::string& key) {
  return fmt::format("<span data-key=\"{}\" data-unit=\"%\">{:.3g}</span> %", key, 100 * share);
}

std::string table(const TableRow& head, const std::vector<TableRow>& rows) {
  std::string html = "<div class=\"scroll\" tabindex=\"0\"><table>\n";
  if (std::ranges::any_of(head, [](const std::string& cell) { return !cell.empty(); })) {
    html += "<thead><tr>";
    for (const std::string& cell : head)
      html += cell.empty() ? "<td></td>" : "<th scope=\"col\">" + cell + "</th>";
    html += "</tr></thead>\n";
  }
  html += "<tbody>\n";
  for (const TableRow& row : rows) {
    html += "<tr>";
    for (size_t k = 0; k < row.size(); ++k)
      html += k == 0 ? "<th scope=\"row\">" + row[k] + "</th>" : "<td>" + row[k] + "</td>";
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string share_bar(double share) {
  return fmt::format("<div class=\"share\"><i style=\"width:{:.1f}%\"></i></div>\n",
                     100 * std::clamp(share, 0.0, 1.0));
}

std::string folded(const std::string& summary, const std::string& html) {
  return "<details><summary>" + summary + "</summary>\n" + html + "</details>\n";
}

std::string paragraph(const std::string& html) { return "<p>" + html + "</p>\n"; }

Page::Page(const PageHead& head, const std::string& robot, const std::string& what)
    : head_(head), title_(robot + ": " + what) {
  body_ = "<header>\n<p class=\"kind\">" + escaped(what) + "</p>\n<h1>" + escaped(robot) +
          "</h1>\n" + about_line(head) + "</header>\n";
}

void Page::verdict(Tone tone, std::string word, const std::string& sentence) {
  if (head_.arm_in_doubt) {
    tone = std::max(tone, Tone::attention);
    word += "; is the robot file that of this arm?";
  }
  body_ += std::string("<div class=\"verdict ") + name_of(tone) + "\"><p><strong class=\"badge\">" +
           "<span aria-hidden=\"true\">" + sign_of(tone) + "</span> " + escaped(word) +
           "</strong></p><p class=\"sentence\">" + sentence + "</p></div>\n";
  if (head_.warnings.empty()) return;
  body_ += "<h2>Warnings</h2>\n";
  std::vector<std::string> warnings;
  for (const std::string& warning : head_.warnings) warnings.push_back(escaped(warning));
  list(warnings);
}

void Page::tiles(const std::vector<Tile>& tiles) {
  body_ += "<div class=\"tiles\">\n";
  for (const Tile& tile : tiles)
    body_ += "<div class=\"tile\"><p class=\"label\">" + tile.label + "</p><p class=\"value\">" +
             tile.value + "</p><p class=\"note\">" + tile.note + "</p></div>\n";
  body_ += "</div>\n";
}

void Page::section(const std::string& heading) { body_ += "<h2>" + heading + "</h2>\n"; }

void Page::folded_section(const std::string& heading) {
  body_ += "<h2 class=\"screen\">" + heading + "</h2>\n";
}

void Page::pictures(const std::vector<Drawing>& pictures) {
  if (std::ranges::all_of(pictures, [](const Drawing& picture) { return !picture; })) return;
  body_ += "<div class=\"pictures\">\n";
  for (const Drawing& picture : pictures) {
    if (!picture) continue;
    body_ += "<figure>" + picture->svg() + "<figcaption>" + escaped(picture->description()) +
             "</figcaption></figure>\n";
    files_.push_back({picture->name() + ".svg", stand_alone({picture})});
  }
  body_ += "</div>\n";
}

void Page::list(const std::vector<std::string>& items) {
  body_ += "<ul>\n";
  for (const std::string& item : items) body_ += "<li>" + item + "</li>\n";
  body_ += "</ul>\n";
}

std::string Page::value(const std::string& key) const {
  const std::string* const value = head_.product.value(key);
  if (!value) return "-";
  const bool has_unit = key.find("_mm") != key.npos || key.find("_mrad") != key.npos;
  const double size = std::abs(std::strtod(value->c_str(), nullptr));
  return keyed(has_unit && size > 0 && size < kShownAsZero ? "0.0000" : *value, key);
}

std::string Page::file_name(const std::string& key) const {
  const std::string* const name = head_.product.value(key);
  return "<span class=\"file\" data-key=\"" + key + "\">" + escaped(name ? *name : "-") + "</span>";
}

std::vector<std::string> Page::values(const std::string& list) const {
  std::vector<std::string> items;
  for (size_t k = 0; has(path_of(list, k)); ++k) items.push_back(value(path_of(list, k)));
  return items;
}

std::vector<TableRow> Page::rows(const std::string& list,
                                 const std::vector<std::string>& keys) const {
  std::vector<TableRow> rows;
  for (size_t k = 0; has(path_of(list, k) + "/" + keys.front()); ++k) {
    rows.emplace_back();
    for (const std::string& key : keys) rows.back().push_back(value(path_of(list, k) + "/" + key));
  }
  return rows;
}

TableRow Page::error_row(const std::string& name, const std::string& key) const {
  return {name, value(key + "/mean"), value(key + "/rms"), value(key + "/p95"),
          value(key + "/max")};
}

std::string Page::inputs() const {
  std::vector<TableRow> rows;
  for (size_t k = 0; has(path_of("provenance/inputs", k) + "/file"); ++k) {
    const std::string input = path_of("provenance/inputs", k);
    rows.push_back({file_name(input + "/file"), file_name(input + "/sha256")});
  }
  return table({"file", "SHA-256"}, rows) +
         paragraph("Made by " + value("provenance/command") + " of armtrue " +
                   value("provenance/version") + ".");
}

Report Page::finish(bool folds_inputs) {
  if (folds_inputs) body_ += folded("Input files and their SHA-256", inputs());
  return {
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<link rel=\"icon\" href=\"data:,\"><title>" +
          escaped(title_) + "</title>\n<style>" + picture_style() + page_style() +
          "</style></head>\n<body>\n<main>\n" + body_ + "</main>\n<script>" + page_script() +
          "</script>\n</body></html>\n",
      files_};
}

}  // namespace armtrue
