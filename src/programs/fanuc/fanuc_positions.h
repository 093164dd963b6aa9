#pragma once

#include <map>
#include <optional>
#include <string>

#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// A position of /POS in an LS file.
struct FanucPosition {
  std::map<std::string, ProgramNumber> numbers;  ///< X .. R, J1 .. J6, of group 1
  std::map<std::string, double> others;          ///< of other groups and external axes
  std::optional<int> frame, tool;
  bool is_in_active_frame = false, has_active_tool = false;  ///< UF : F, UT : F
  std::string configuration;                                 ///< N U T, 0, 0, 0
  bool is_changed = false;                                   ///< given twice, or P[1]=LPOS
  bool is_shared = false;                                    ///< other statements than moves use it
  size_t begin = 0, end = 0;                                 ///< from `P` to behind `}`
  std::optional<ProgramNumber> configuration_place;          ///< of its text, between the quotes
  int line = 0;
  int point = -1;  ///< in RobotProgram::points, once a move uses it
};

/// The positions by their numbers. `text`: the file by masked_fanuc(); /POS stands in [begin, end).
std::map<double, FanucPosition> fanuc_positions(const std::string& original,
                                                const std::string& text, size_t begin, size_t end);

/// What CONFIG says.
Configuration fanuc_configuration(const std::string& text);

}  // namespace armtrue
