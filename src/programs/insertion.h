#pragma once

#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/text_edit.h"

namespace armtrue {

/// A point that a move gets for itself in place of a declared one.
struct OwnPoint {
  size_t target = 0;
  std::vector<TextEdit> changes;  ///< of the declaration, in its text: what the own point states
  std::string text;               ///< the own point; empty: it is the declaration with the changes
};

/// Writes moves into the text of a program, and points into its moves. Here a point stands in its
/// move; a maker whose points are declared elsewhere has a writer of its own.
class MoveWriter {
 public:
  explicit MoveWriter(const RobotProgram& program)
      : program_(program), text_(program.texts[0].text) {}
  MoveWriter(const MoveWriter&) = delete;
  MoveWriter& operator=(const MoveWriter&) = delete;
  virtual ~MoveWriter() = default;

  /// What stands in an inserted move for a point with these changes of its declaration.
  virtual std::string inserted_point(const ProgramPoint& point,
                                     const std::vector<TextEdit>& changes);
  /// The same in the move of the target itself.
  virtual std::string own_point(const ProgramTarget& target, const std::vector<TextEdit>& changes);
  /// What stands in a move for a point that is written out as `text`.
  virtual std::string placed(const std::string& text);
  /// What ends an inserted move that is passed within a radius [m].
  virtual std::string ending(double blend) const;
  /// A move before a place: its text before the point, and from the point on.
  struct Move {
    size_t at;
    std::string head, rest;
  };
  virtual void insert(const Move& move);
  void replace(size_t begin, size_t end, const std::string& text) {
    edits_.push_back({0, begin, end, text});
  }
  /// All edits, once everything is written.
  std::vector<TextEdit> take();

 protected:
  /// What follows from all that was written: declarations, numbers of lines.
  virtual void finish() {}
  /// The text of a declared point after the edits of its numbers.
  std::string changed(const ProgramPoint& point, std::vector<TextEdit> edits) const;

  const RobotProgram& program_;
  const std::string& text_;

 private:
  std::string on_one_line(std::string point) const;

  std::vector<TextEdit> edits_;
};

/// The edits that insert a move for each point `between`, in the order in which the arm passes
/// them, replace the auxiliary points of divided arcs, and write own points into their moves.
/// `changes`: for each point between, the edits that make it from the point of its target. The
/// moves of the points have no obstacle.
std::vector<TextEdit> insertion_edits(const RobotProgram& program,
                                      const std::vector<ProgramPointBetween>& between,
                                      const std::vector<std::vector<TextEdit>>& changes,
                                      const std::vector<OwnPoint>& own);

}  // namespace armtrue
