#include "report/html.h"

#include <sstream>

namespace armtrue {

std::string escaped(const std::string& text) {
  std::string result;
  for (char c : text) switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      default:
        result += c;
    }
  return result;
}

std::string number(double value) {
  std::ostringstream text;
  text.precision(4);
  text << value;
  return text.str();
}

std::string html_page(const std::string& title, const std::string& body) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
         escaped(title) +
         "</title><style>body{font-family:sans-serif;max-width:800px;margin:2em auto}"
         "table{border-collapse:collapse}td,th{padding:.2em .6em;text-align:right;"
         "border-bottom:1px solid #ccc}td:first-child,th:first-child{text-align:left}"
         "</style></head><body>\n<h1>" +
         escaped(title) + "</h1>\n" + body + "</body></html>\n";
}

}  // namespace armtrue
