#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "armtrue/programs/program_text.h"

namespace armtrue {

/// A position register of group 1, as POSREG.VA lists it.
struct FanucRegister {
  bool is_joints = false;
  std::vector<double> numbers;  ///< X Y Z W P R or J1 to J6 [mm, deg]
  std::string configuration;    ///< F U T, 0, 0, 0; empty of joints
};

/// Whether a text lists variables of a controller that count: POSREG.VA, SYSFRAME.VA.
bool is_fanuc_listing(const std::string& text);

/// The position registers to which a program, given by masked_fanuc(), gives values, each as it
/// stands: PR[1], PR[GP1:1,3:name].
std::set<std::string> fanuc_registers_set_in(std::string_view program);

/// The position registers of a controller that no program assigns, its user frames and tools.
class FanucRegisters {
 public:
  /// `texts`: listings, $POSREG, $MNUFRAME and $MNUTOOL, and programs. `program`: the text of the
  /// program itself, by masked_fanuc().
  FanucRegisters(std::string_view program, const ProgramText* begin, const ProgramText* end);

  /// Null if the register is not listed, is not taught for six axes, or is given values.
  const FanucRegister* find(double number) const;
  /// X Y Z W P R of a user frame or a tool; null if it is not listed.
  const FanucRegister* find_frame(bool is_tool, double number) const;

 private:
  using Listed = std::map<double, FanucRegister>;
  void read_listing(const std::string& text);
  void note_assignments(std::string_view text);

  Listed registers_, frames_, tools_;
  std::set<double> changed_;
  bool is_any_changed_ = false;
};

}  // namespace armtrue
