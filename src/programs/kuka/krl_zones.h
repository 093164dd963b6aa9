#pragma once

#include <optional>
#include <string>
#include <vector>

#include "programs/kuka/krl_syntax.h"
#include "programs/program_flow.h"
#include "programs/text_cursor.h"

namespace armtrue {

/// Follows $APO.CDIS through a KRL program: direct assignments, the LDAT of inline forms, which
/// BAS(#CP_PARAMS) takes it from, and WITH of spline moves (KUKA, KSS 8.x operating and programming
/// instructions for system integrators, "Approximate positioning").
class KrlZones {
 public:
  /// `src`: the text of the .src. Both must outlive it.
  KrlZones(const std::string& src, const KrlSyntax& syntax);

  /// The distance before the end of a move at which C_DIS or C_SPL may leave its path [m]. 0: it
  /// stops there, or approximates in another way, or the text does not say for certain how far.
  double blend_of(const KrlMove& move) const;

 private:
  // Behind $APO: .CDIS=5, ={CDIS 5,..} or =SAPO(LCPDAT1). Nothing if it does not set the distance;
  // a negative number if it is not known.
  std::optional<double> set_behind_apo(TextCursor cursor) const;
  double distance_of_ldat(const std::string& name) const;

  const std::string& src_;
  const KrlSyntax& syntax_;
  std::vector<double> distances_;  // [mm]
  ProgramFlow::Values values_;     // index of the distance; -1: not known
};

}  // namespace armtrue
