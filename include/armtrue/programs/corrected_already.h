#pragma once

#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "armtrue/text/input_error.h"

namespace armtrue {

/// A program is corrected already.
class CorrectedAlready : public InputError {
  using InputError::InputError;
};

/// The remedy in words: what to give `compensate` in place of a program that a corrector has
/// changed.
const std::string& instead_of_corrected(Corrector by);

/// Throws CorrectedAlready if a text has the mark of a corrector. `instead`: the remedy.
void refuse_mark(const std::vector<ProgramText>& texts, Corrector by, const std::string& instead);
/// The same if its numbers have check digits.
void refuse_check_digits(const RobotProgram& program, Corrector by, const std::string& instead);

/// The same for both correctors: marks of texts; check digits of a program's numbers, and marks of
/// the texts of others that declare its points.
void refuse_corrected_texts(const std::vector<ProgramText>& texts);
void refuse_corrected_points(const RobotProgram& program);

}  // namespace armtrue
