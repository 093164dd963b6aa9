#pragma once

#include <string>

namespace armtrue {

/// Text with the characters that HTML reserves written as entities.
std::string escaped(const std::string& text);

/// A number with four significant digits.
std::string number(double value);

/// A whole page around the HTML of its body, with `title` (plain text) as its heading.
std::string html_page(const std::string& title, const std::string& body);

}  // namespace armtrue
