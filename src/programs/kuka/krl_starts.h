#pragma once

#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/kuka/krl_set_up.h"
#include "programs/kuka/krl_syntax.h"

namespace armtrue {

/// Where the arm stands before each move of a KRL program, as far as that is the same on all ways
/// that lead there.
class KrlStarts {
 public:
  /// `parts`: what must be known of a point; else its move is left alone. All must outlive it.
  KrlStarts(const KrlSyntax& syntax, const KrlSetUps::List& set_ups, TargetParts parts);

  /// The pose before a move, in its frame and with its tool: it completes what the first point
  /// leaves out.
  const KrlValues& before(size_t move) const { return starts_[move].values; }
  /// The same of its last point: of a circle what the auxiliary point does not change.
  KrlValues before_end(size_t move) const { return before_end(move, before(move)); }
  /// The complete pose at the end of a move, with all that its point leaves out.
  KrlValues reached(size_t index) const;
  /// The moves after which the arm comes to a move; none if one of them is not known.
  const std::vector<int>& moves_before(size_t move) const { return starts_[move].moves; }
  /// Whether the arm always comes from the move before in the text, which is not left alone.
  bool follows(size_t move) const;
  /// Whether a way through the text leads to a move.
  bool runs(size_t move) const { return runs_[move]; }
  /// Why a move is left alone; empty if it is not.
  std::string why_left_alone(size_t move) const { return why_left_alone(move, before(move)); }

 private:
  struct Start {
    bool is_reached = false;  // a way that leads here has been followed
    KrlValues values = unknown_krl_values();
    KrlSetUps::SetUp set_up;  // in which the values hold
    std::vector<int> moves{};
  };

  void find_what_runs();
  bool follow_ways();
  Start end_of(size_t move) const;
  static void meet(const Start& way, Start& here);
  KrlValues before_end(size_t move, const KrlValues& before) const;
  std::string why_left_alone(size_t index, const KrlValues& before) const;
  std::string why_left_alone(const KrlMove& move, const KrlValues& before) const;
  std::string why_left_alone(const KrlTarget& target, const KrlValues& before) const;
  const KrlFrame& frame_of(const KrlTarget& target) const;

  const KrlSyntax& syntax_;
  const KrlSetUps::List& set_ups_;
  const TargetParts parts_;
  std::vector<char> runs_;     // of the moves
  std::vector<Start> starts_;  // of the moves
  std::vector<Start> ends_;    // of the nodes
};

}  // namespace armtrue
