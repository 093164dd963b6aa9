#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "armtrue/programs/program_text.h"

namespace armtrue {

/// A position register of group 1.
struct FanucRegister {
  enum class Meaning { not_said, pose, joints };
  Meaning meaning = Meaning::not_said;
  std::vector<double> numbers;     ///< X Y Z W P R or J1 to J6 [mm, deg]
  std::string configuration;       ///< F U T, 0, 0, 0; empty of joints
  std::optional<int> frame, tool;  ///< of the position that it is a copy of

  bool is_joints() const { return meaning == Meaning::joints; }
};

/// Begins the name of the text that says what a call assigns (FolderTexts).
constexpr std::string_view kFanucCall = "CALL ";

/// Whether a text lists variables of a controller that count: POSREG.VA, SYSFRAME.VA.
bool is_fanuc_listing(const std::string& text);

/// What a program, given by masked_fanuc(), gives values, each as it stands: of "PR" its position
/// registers, PR[1], PR[GP1:1,3:name]; of "UFRAME" user frames, of "UTOOL" tools.
std::set<std::string> fanuc_values_set_in(std::string_view program, std::string_view kind);

/// Whether such a program may select or set user frames or tools, or state conditions of offsets.
bool sets_fanuc_frames(std::string_view program);

/// The position registers of a controller, its user frames and tools, as listings have them.
class FanucRegisters {
 public:
  /// Listings, $POSREG, $MNUFRAME and $MNUTOOL, and other programs, or the texts of FolderTexts.
  FanucRegisters(const ProgramText* begin, const ProgramText* end);

  /// Null if the register is not listed, is not taught for six axes, or another program assigns it.
  const FanucRegister* find(double number) const;
  /// Whether a program that is called, or one that this calls, may assign a position register.
  bool may_be_set_by(const std::string& program, double number) const;
  /// Whether such a program may do what sets_fanuc_frames() tells.
  bool may_set_frames(const std::string& program) const;
  /// X Y Z W P R of a user frame or a tool; null if it is not listed.
  const FanucRegister* find_frame(bool is_tool, double number) const;
  /// Whether another program sets a user frame or a tool.
  bool is_set_by_others(bool is_tool, double number) const;

 private:
  using Listed = std::map<double, FanucRegister>;
  void read_listing(const std::string& text);
  // The numbers of what a program sets.
  struct Changes {
    std::set<double> numbers;
    bool is_any = false;  // one whose number is calculated

    void note(std::string_view program, std::string_view kind);
    bool contains(double number) const { return is_any || numbers.contains(number); }
  };

  Listed registers_, frames_, tools_;
  Changes changed_, changed_frames_, changed_tools_;
  struct Call {
    Changes registers;
    bool sets_frames = false;
  };
  std::map<std::string, Call> calls_;  // by the programs that they call
};

}  // namespace armtrue
