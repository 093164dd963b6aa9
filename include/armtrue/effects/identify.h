#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// An entry of `identify`: `auto`, `paper-25`, `base`, `tool`, a name such as `A2.d`, or a pattern
/// of names, in which * stands for any characters and ? for one; a leading - takes away what
/// earlier entries have named.
struct IdentifyEntry {
  bool takes_away = false;
  std::string name;

  explicit IdentifyEntry(std::string_view text);
};

/// Whether a name is a pattern, and not the name of a parameter that has such characters.
bool is_pattern(const KinematicChain& chain, const std::string& name);

/// Whether a whole text matches a pattern of IdentifyEntry.
bool matches(std::string_view pattern, std::string_view text);

/// Why an entry of `identify` names nothing of a robot, with the names that are near; empty if all
/// are right.
std::string why_not_identified(const KinematicChain& chain,
                               const std::vector<std::string>& identify);

/// Whether these entries of `identify` allow every parameter: `auto` without a `-` entry.
bool identifies_all(const std::vector<std::string>& identify);

}  // namespace armtrue
