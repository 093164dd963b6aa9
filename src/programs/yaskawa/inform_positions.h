#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// The lines of //POS that hold for the positions behind them.
struct InformHeads {
  enum Line { user, tool, type, data, configuration };  ///< ///USER 1, ///POSTYPE USER, ///RECTAN
  std::array<std::string, 5> lines;                     ///< as they stand; empty: none yet

  /// The lines that make these hold where `now` holds.
  std::string change_from(const InformHeads& now, const std::string& line_end) const;
};

/// A position of //POS: C00001=.. of a step, P00001=.. of a variable, EC00001=.. of a station.
struct InformPosition {
  enum class Kind { pulses, joints, pose } kind = Kind::pulses;
  std::vector<double> pulses_per_degree;  ///< of joints that are written in pulses; else empty
  std::vector<ProgramNumber> numbers;  ///< X Y Z Rx Ry Rz [mm, deg], S L U R B T [deg] or pulses
  InformHeads heads;
  std::optional<int> user;  ///< user frame; nothing: the frame of the robot or of its base
  std::optional<int> tool;
  std::string why_not;          ///< cannot be followed; empty if it can
  Configuration configuration;  ///< of RCONF
  size_t begin = 0, end = 0;    ///< of the whole, from its name on
  int line = 0;
  int point = -1;  ///< in RobotProgram::points, once a move uses it
};

/// C1 or P1 of C00001 or P001; empty if a word is neither.
std::string inform_position_name(std::string_view word);

/// EC1 of EC00001, the axes of a station, BC1 of BC00001, those of a base; empty if a word is none.
std::string inform_station_name(std::string_view word);

/// The positions by inform_position_name(), those of stations by inform_station_name(). `text`: the
/// job by masked(), /JOB to //INST. `pulses`: per deg of each axis, if it is known.
std::map<std::string, InformPosition> inform_positions(std::string_view text,
                                                       const std::vector<double>* pulses = nullptr);

/// What RCONF says (DX100, "Interface with an easy offline teaching system"): wrist not flipped,
/// lower arm, rear, R, T, S beyond 180 deg.
Configuration inform_configuration(std::string_view numbers);

}  // namespace armtrue
