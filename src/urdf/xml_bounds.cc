#include "urdf/xml_bounds.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "armtrue/text/xml_tags.h"

namespace armtrue {
namespace {

constexpr size_t kMaxXmlBytes = 16 << 20;
constexpr int kMaxXmlElements = 20'000, kMaxXmlAttributes = 1000, kMaxXmlLevels = 100;

// Walks over the tags of a text.
class XmlScanner {
 public:
  XmlScanner(const std::string& text, const std::string& file) : text_(text), file_(file) {}

  void scan() {
    while ((at_ = text_.find('<', at_)) != std::string_view::npos) {
      if (skip("<!--", "-->") || skip("<![CDATA[", "]]>") || skip("<?", "?>")) continue;
      if (starts_with("<!"))
        declaration();
      else if (starts_with("</"))
        closing_tag();
      else
        opening_tag();
    }
    if (level_ > 0) fail("ends within an element; is it cut off?", text_.size());
  }

 private:
  [[noreturn]] void fail(const std::string& what, size_t at) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + at, '\n');
    throw InputError(file_ + ":" + std::to_string(line) + ": is no valid URDF: " + what);
  }
  [[noreturn]] void fail(const std::string& what) const { fail(what, std::min(at_, text_.size())); }

  bool starts_with(std::string_view begin) const { return text_.substr(at_).starts_with(begin); }

  bool skip(std::string_view begin, std::string_view end) {
    if (!starts_with(begin)) return false;
    const size_t found = text_.find(end, at_ + begin.size());
    if (found == std::string_view::npos)
      fail("'" + std::string(begin) + "' is not closed by '" + std::string(end) + "'");
    at_ = found + end.size();
    return true;
  }

  // <!DOCTYPE robot>, without entities.
  void declaration() {
    const size_t end = text_.find_first_of("[<>", at_ + 1);
    if (end == std::string_view::npos || text_[end] != '>')
      fail("it declares entities or is not closed; write them out and remove the declaration");
    at_ = end + 1;
  }

  void closing_tag() {
    const size_t end = text_.find_first_of("<>", at_ + 1);
    if (end == std::string_view::npos || text_[end] != '>') fail("a tag is not closed by '>'");
    if (--level_ < 0) fail("a tag closes what was not opened");
    at_ = end + 1;
  }

  void opening_tag() {
    if (++elements_ > kMaxXmlElements)
      fail("it has more than " + std::to_string(kMaxXmlElements) + " elements");
    if (++level_ > kMaxXmlLevels)
      fail("it is more than " + std::to_string(kMaxXmlLevels) + " levels deep");
    ++at_;
    name();
    for (int attributes = 0;; ++attributes) {
      blanks();
      if (starts_with(">")) {
        ++at_;
        return;
      }
      if (starts_with("/>")) {
        --level_;
        at_ += 2;
        return;
      }
      if (attributes == kMaxXmlAttributes)
        fail("an element has more than " + std::to_string(kMaxXmlAttributes) + " attributes");
      attribute();
    }
  }

  void name() {
    const size_t end = std::min(text_.find_first_of(" \t\r\n<>/='\"&", at_), text_.size());
    if (end == at_) fail("a name is missing in a tag");
    at_ = end;
  }

  void blanks() { at_ = std::min(text_.find_first_not_of(kXmlBlanks, at_), text_.size()); }

  void attribute() {
    const size_t begin = at_;
    name();
    const std::string_view attribute_name = text_.substr(begin, at_ - begin);
    blanks();
    if (!starts_with("=")) fail("an attribute has no value; write name=\"value\"");
    ++at_;
    blanks();
    if (!starts_with("\"") && !starts_with("'"))
      fail("the value of an attribute stands without quotes; write name=\"value\"");
    const size_t end = text_.find(text_[at_], at_ + 1);
    if (end == std::string_view::npos) fail("a quote is not closed");
    if (attribute_name == "rpy") check_angles(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
  }

  // An rpy beyond two turns is in degrees: 45 or 90.
  void check_angles(std::string_view rpy) const {
    constexpr double kMostOfAngle = 4 * std::numbers::pi;
    for (size_t begin = 0; begin < rpy.size();) {
      const size_t end = std::min(rpy.find_first_of(kXmlBlanks, begin), rpy.size());
      const std::optional<double> angle = read_number(rpy.substr(begin, end - begin));
      if (angle && std::abs(*angle) > kMostOfAngle)
        fail("rpy=\"" + std::string(rpy) + "\" are more than two turns; write rad, not deg");
      begin = end + 1;
    }
  }

  std::string_view text_;
  const std::string& file_;
  size_t at_ = 0;
  int elements_ = 0, level_ = 0;
};

}  // namespace

void check_xml_bounds(const std::string& text, const std::string& file) {
  if (text.size() > kMaxXmlBytes)
    throw InputError(file + ": is larger than 16 MB; no URDF of one arm is: check its name");
  XmlScanner(text, file).scan();
}

}  // namespace armtrue
