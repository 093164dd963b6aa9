#include "io/yaml/yaml_bounds.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string_view>
#include <vector>

#include "armtrue/text/input_error.h"
#include "armtrue/text/utf8.h"

namespace armtrue {
namespace {

constexpr size_t kMaxYamlBytes = 64 << 20;
constexpr std::ptrdiff_t kMaxYamlPiece =
    100'000;  // bytes in one line without a sign that ends a value
constexpr long kMaxYamlValues = 500'000;
constexpr size_t kMaxYamlLevels = 50;

class BoundsHandler : public YAML::EventHandler {
 public:
  explicit BoundsHandler(const std::string& file) : file_(file) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ > 0 && mark.pos == document_)
      fail(mark, "a sign such as ',' stands where a value should begin; correct or remove it");
    document_ = mark.pos;
    sizes_.clear();
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { scalar(mark, anchor); }
  void OnScalar(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                const std::string& /*value*/) override {
    scalar(mark, anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto size = sizes_.find(anchor);
    if (size == sizes_.end())
      fail(mark, "an alias stands for the value that holds it; write the value out");
    count(mark, size->second);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    begin(mark, anchor);
  }
  void OnSequenceEnd() override { end(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    begin(mark, anchor);
  }
  void OnMapEnd() override { end(); }

 private:
  struct Open {
    YAML::anchor_t anchor;
    long before;
  };

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& what) const {
    throw InputError(file_ + ":" + std::to_string(mark.line + 1) + ": is no valid YAML: " + what);
  }

  void count(const YAML::Mark& mark, long values) {
    values_ += values;
    if (values_ > kMaxYamlValues)
      throw InputError(file_ + ":" + std::to_string(mark.line + 1) + ": holds more than " +
                       std::to_string(kMaxYamlValues) +
                       " values, aliases written out; no file of armtrue does: check its name");
  }

  void scalar(const YAML::Mark& mark, YAML::anchor_t anchor) {
    count(mark, 1);
    if (anchor != YAML::NullAnchor) sizes_[anchor] = 1;
  }

  void begin(const YAML::Mark& mark, YAML::anchor_t anchor) {
    open_.push_back({anchor, values_});
    if (open_.size() > kMaxYamlLevels)
      throw InputError(file_ + ":" + std::to_string(mark.line + 1) + ": is more than " +
                       std::to_string(kMaxYamlLevels) +
                       " levels deep; no file of armtrue is: check its name");
    count(mark, 1);
  }

  void end() {
    const Open closed = open_.back();
    open_.pop_back();
    if (closed.anchor != YAML::NullAnchor) sizes_[closed.anchor] = values_ - closed.before;
  }

  const std::string& file_;
  long documents_ = 0, values_ = 0;
  int document_ = -1;  // where the last one begins
  std::vector<Open> open_;
  std::map<YAML::anchor_t, long> sizes_;
};

// The reader, and whoever compares a name with what is known, take seconds for each MB of a value.
void check_pieces(const std::string& text, const std::string& file) {
  const auto ends_value = [](char c) {
    return std::string_view(",[]{}\r\n").find(c) != std::string_view::npos;
  };
  for (auto from = text.begin(); from != text.end();) {
    const auto end = std::find_if(from, text.end(), ends_value);
    if (end - from > kMaxYamlPiece)
      throw InputError(
          file + ":" + std::to_string(1 + std::count(text.begin(), from, '\n')) +
          ": holds a value of more than 100 kB; no file of armtrue does: check its name");
    from = end == text.end() ? end : end + 1;
  }
}

// Where a document cannot be read further, with the line as it stands there.
std::string near(const std::string& text, const YAML::Mark& mark) {
  std::istringstream lines(text);
  std::string line;
  for (int k = 0; k <= mark.line; ++k)
    if (!std::getline(lines, line)) line.clear();
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
  if (line.empty()) return ": it ends too early; close its brackets and quotes";
  constexpr size_t kShown = 60;  // bytes of the line
  std::string shown = line.substr(0, kShown);
  while (!is_utf8(shown)) shown.pop_back();
  const bool has_tab = line.substr(0, line.find_first_not_of(" \t")).find('\t') != line.npos;
  return " at column " + std::to_string(mark.column + 1) + ": '" + shown + "'; " +
         (has_tab ? "indent by blanks, not by tabs"
                  : "correct the indents, colons, brackets and quotes of this line and of the one "
                    "before");
}

}  // namespace

void check_yaml_bounds(const std::string& text, const std::string& file) {
  if (text.size() > kMaxYamlBytes)
    throw InputError(file + ": is larger than 64 MB; no file of armtrue is: check its name");
  check_pieces(text, file);
  std::istringstream stream(text);
  BoundsHandler handler(file);
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(handler)) {
    }
  } catch (const YAML::Exception& error) {
    throw InputError(file + ":" + std::to_string(error.mark.line + 1) + ": is no valid YAML" +
                     near(text, error.mark));
  }
}

}  // namespace armtrue
