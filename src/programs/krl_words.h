#pragma once

#include <string>
#include <string_view>
#include <unordered_map>

#include "programs/krl_syntax.h"
#include "programs/text_cursor.h"

namespace armtrue {

/// A word that begins a move.
struct KrlKeyword {
  std::string_view name;
  KrlMotion motion;
  bool spline;
  bool relative;
};

/// The keyword with this name in capitals; null if there is none.
const KrlKeyword* find_krl_motion(std::string_view name);

/// Reads FP1={TOOL_NO 1,BASE_NO 3,IPO_FRAME #BASE,..} behind DECL FDAT.
void take_krl_fdat(TextCursor& cursor, std::unordered_map<std::string, KrlFdat>& fdats);

}  // namespace armtrue
