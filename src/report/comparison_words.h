#pragma once

#include "armtrue/diagnosis/run_comparison.h"

namespace armtrue {

/// The words of page and table of a comparison: of one arm at two times, or of two arms.
struct ComparisonWords {
  const char *title, *before, *after, *only_before, *only_after, *change, *moved;

  const char* of(InRuns in) const {
    return in == InRuns::both ? "both" : in == InRuns::before ? only_before : only_after;
  }
};

inline ComparisonWords words_of(ComparedArms arms) {
  if (arms == ComparedArms::one)
    return {"Two runs compared", "before", "after", "only before", "only after", "change", "moved"};
  return {"Two arms compared", "first arm",  "second arm", "only first",
          "only second",       "difference", "differs"};
}

}  // namespace armtrue
