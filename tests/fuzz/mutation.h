#pragma once

#include <random>
#include <string>
#include <utility>
#include <vector>

namespace armtrue {

/// Random changes of a text: words put in or instead of something, bytes changed, parts removed or
/// written twice.
class Mutation {
 public:
  Mutation(unsigned seed, std::vector<std::string> words)
      : random_(seed), words_(std::move(words)) {}

  std::string operator()(std::string text) {
    for (size_t count = 1 + below(8); count > 0; --count) change(text);
    return text;
  }

 private:
  size_t below(size_t limit) { return limit ? random_() % limit : 0; }

  void change(std::string& text) {
    const size_t at = below(text.size() + 1), count = below(40);
    switch (below(5)) {
      case 0:
        text.insert(at, words_[below(words_.size())]);
        break;
      case 1:
        text.erase(at, count);
        break;
      case 2:
        text.insert(below(text.size() + 1), text.substr(at, count));
        break;
      case 3:
        text.replace(at, count, words_[below(words_.size())]);
        break;
      default:
        if (at < text.size()) text[at] = static_cast<char>(below(256));
    }
  }

  std::mt19937_64 random_;
  std::vector<std::string> words_;
};

}  // namespace armtrue
