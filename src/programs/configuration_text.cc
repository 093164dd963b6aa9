#include "programs/configuration_text.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "armtrue/kinematics/units.h"
#include "programs/program_values.h"

namespace armtrue {
namespace {

constexpr int kTurnBits = 0x3f;                          // of T, of the joints
constexpr int kFlipped = 4;                              // of S: A5 is below zero
constexpr std::array<int, 3> kAxesOfQuadrants{0, 3, 5};  // cf1, cf4, cf6

int turn_bits(const JointVector& q) {
  int bits = 0;
  for (int j = 0; j < kProgramAxes; ++j)
    if (q[j] < 0) bits |= 1 << j;
  return bits;
}

// Whether a joint is programmed in a range, or beside it by less than the angles of a written pose
// are known, and commanded outside of it.
bool leaves(double low, double high, int joint, const ProgramCommand& command) {
  constexpr double kWritten = 1e-4 * kDegree;  // the decimals of a pose
  const double before = command.programmed[joint], now = command.q[joint];
  return before >= low - kRangeSlack && before <= high + kRangeSlack &&
         (now < low - kWritten || now > high + kWritten);
}

bool crosses_zero(int joint, bool is_below, const ProgramCommand& command) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return is_below ? leaves(-kInfinity, 0, joint, command) : leaves(0, kInfinity, joint, command);
}

// N U T, 0, 0, 0: the letters stay, the turns are those of the joints.
TextEdit fanuc_turns(const RobotProgram& program, const FanucDeclaration& whole,
                     const JointVector& q) {
  const std::string text = program.texts[0].text.substr(
      whole.configuration_begin, whole.configuration_end - whole.configuration_begin);
  const auto turn = [&](int joint) { return static_cast<int>(std::lround(q[joint] / kTurn)); };
  const size_t comma = text.find(',');
  return {0, whole.configuration_begin, whole.configuration_end,
          comma == std::string::npos
              ? text
              : fmt::format("{}, {}, {}, {}", text.substr(0, comma), turn(3), turn(4), turn(5))};
}

}  // namespace

std::vector<std::string> configuration_texts(Dialect dialect, const ProgramPoint& point,
                                             const ProgramCommand& command) {
  std::vector<std::string> texts(point.configuration.size());
  const auto change = [&](size_t i, int now) {
    const ProgramNumber& number = point.configuration[i];
    if ((number.is_written() || point.is_expression) && now != number.value)
      texts[i] = fmt::format("{}", now);
  };
  if (dialect == Dialect::krl && !texts.empty()) {
    int turn = static_cast<int>(point.configuration[0].value);
    int status = static_cast<int>(point.configuration[1].value);
    for (int j = 0; j < kProgramAxes; ++j)
      if (crosses_zero(j, turn & (1 << j), command)) turn ^= 1 << j;
    if (crosses_zero(4, status & kFlipped, command)) status ^= kFlipped;
    change(0, turn);
    change(1, status);
  }
  if (dialect == Dialect::rapid && texts.size() == 4)
    for (size_t i = 0; i < 3; ++i) {
      constexpr double kQuarter = 90 * kDegree;
      const int joint = kAxesOfQuadrants[i];
      const double low = kQuarter * point.configuration[i].value;
      if (leaves(low, low + kQuarter, joint, command)) change(i, quadrant(command.q[joint]));
    }
  return texts;
}

std::vector<TextEdit> configuration_edits(const RobotProgram& program, const ProgramPoint& point,
                                          const JointVector& q) {
  std::vector<TextEdit> edits;
  const auto change = [&](const ProgramNumber& number, int value) {
    edits.push_back({number.text, number.begin, number.end, fmt::format("{}", value)});
  };
  if (program.dialect == Dialect::krl && states_turn(point)) {
    const int written = static_cast<int>(point.configuration[0].value);
    if (const int turn = (written & ~kTurnBits) | turn_bits(q); turn != written)
      change(point.configuration[0], turn);
  }
  if (program.dialect == Dialect::rapid)
    for (size_t i = 0; i < 3; ++i) change(point.configuration[i], quadrant(q[kAxesOfQuadrants[i]]));
  if (program.dialect == Dialect::fanuc && point.declaration.configuration_begin > 0)
    edits.push_back(fanuc_turns(program, point.declaration, q));
  return edits;
}

}  // namespace armtrue
