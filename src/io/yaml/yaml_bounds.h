#pragma once

#include <string>

namespace armtrue {

/// Throws InputError if a text is no YAML, or more of it than a file of armtrue can hold: more than
/// 64 MB, 500,000 values (each alias counts what it stands for), 50 levels, or a value of 100 kB.
/// The text is read as a stream of events, before a tree of nodes takes memory for it. yaml-cpp 0.7
/// itself never ends on a text that begins with a comma, because it makes one empty document of it
/// after another.
void check_yaml_bounds(const std::string& text, const std::string& file);

}  // namespace armtrue
