#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/krl_syntax.h"
#include "programs/program_warnings.h"

namespace armtrue {

/// Follows $BASE and $TOOL through a KRL program, in the order of the text: direct assignments,
/// BAS(#BASE,n) and BAS(#TOOL,n), the FDAT of inline forms, and WITH of spline moves (KUKA, KSS
/// 8.x operating and programming instructions for system integrators).
class KrlSetUps {
 public:
  /// `src`: the text of the .src. All must outlive it.
  KrlSetUps(const std::string& src, const KrlSyntax& syntax, const KnownFrames& known,
            std::vector<ProgramFrame>& frames, ProgramWarnings& warnings)
      : src_(src), syntax_(syntax), known_(known), frames_(frames), warnings_(warnings) {}

  struct SetUp {
    int base = -1, tool = -1;      ///< in the frames; -1: not stated
    bool is_external_tcp = false;  ///< the tool is stationary, the robot holds the part
  };

  /// Base and tool at a move; call with the moves in their order.
  SetUp at(const KrlMove& move);

 private:
  void apply(const KrlSetUp& statement);
  void apply(const std::string& fdat, int line, SetUp& set_up);
  void read_with(const KrlMove& move, SetUp& set_up);
  int frame_of(size_t begin, size_t end, int line, bool is_tool);
  int add(const std::string& name, const std::optional<Pose>& pose);
  int number_of(const char* list, int number);

  const std::string& src_;
  const KrlSyntax& syntax_;
  const KnownFrames& known_;
  std::vector<ProgramFrame>& frames_;
  ProgramWarnings& warnings_;
  size_t next_ = 0;  // statement that is not applied yet
  SetUp now_;
  bool set_before_ = false;  // in an earlier DEF, and not in this one
};

}  // namespace armtrue
