#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/program_flow.h"
#include "programs/statement.h"
#include "programs/ur/urscript_structure.h"

namespace armtrue {

/// What an argument of a URScript move stands for: a literal, or a name that is given one.
struct UrValue {
  TargetKind kind = TargetKind::cartesian;
  std::string name;      ///< for messages
  std::string variable;  ///< that is given it; empty: none
  ListItem list;
  size_t literal_end = 0;  ///< behind the literal, or behind the expression that holds it
  int line = 0;
  int base = -1;  ///< of pose_trans, in the frames
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< of pose_add, in that frame [m]
  /// Whether that frame is calculated at run time, and --frame does not give it.
  bool is_in_calculated_frame = false;
  size_t begin = 0, end = 0;  ///< where the literal or the name stands in the call
  size_t literal = 0;         ///< where p[..] or [..] begins, or an expression of it
  size_t open = 0;            ///< the bracket of the call
  std::optional<JointVector> near;
  bool is_inverse = false;  ///< of get_inverse_kin
  /// Of a name whose elements were given other values, NAME[2]=0.1, or that is made of another one,
  /// NAME=pose_add(OTHER, ..): the literal as it is written, and what stands beside it there.
  std::optional<ListItem> declared;
  std::string before, behind;
};

/// The values of a URScript program: p[..], [..], names whose value is certain where they stand,
/// and get_inverse_kin(pose, qnear) and pose_trans(frame, pose) of them.
class UrValues {
 public:
  /// `text`: the program, `original`, by masked(), its line ends are blanks. All must outlive it.
  UrValues(const std::string& text, const std::string& original, std::vector<ProgramFrame>& frames,
           const KnownFrames& known)
      : text_(text), original_(original), frames_(frames), known_(known) {}

  /// Reads the assignments, [global|local] NAME = VALUE. `structure`: of these statements; it must
  /// outlive this.
  void read(const std::vector<Statement>& statements, const UrStructure& structure);
  /// Nothing if it is no value of this kind.
  std::optional<UrValue> value_of(const Statement& argument) { return value_of(argument, 0); }
  /// Why it is none.
  std::string why_not(const Statement& argument);
  /// The pose that constants make; nothing if an argument is none.
  std::optional<Pose> constant_pose(const Statement& argument) { return constant(argument, 0); }
  /// Whether an argument has a name that is given several values, or one of a function's own: its
  /// text does not mean the same everywhere.
  bool names_several(const Statement& argument);
  bool names_local(const Statement& argument);
  /// Where get_tcp_offset() gave a name its value, if that is certain: the tool there.
  std::optional<size_t> place_of_tool(const Statement& argument);
  /// The point of a value among `points`, where it is added by its first use.
  int point_of(const UrValue& value, std::vector<ProgramPoint>& points);
  /// A move to the point is left alone. A declaration that it names must stay; an expression starts
  /// from a declared point, and follows it if all moves to the point are in no frame and have this
  /// tool.
  void leave(const Statement& argument, int tool);
  /// Once all moves are read: marks the points that other statements use, too.
  void finish(const std::vector<Statement>& statements, const std::vector<ProgramTarget>& targets,
              std::vector<ProgramPoint>& points);

  /// The parameter that a move drives to: its argument is it, or an expression of it that
  /// value_of() understands; nothing of any other.
  std::optional<RoutineParameter> parameter_in(const Statement& argument);
  /// From now on the parameters of a function stand for the arguments of a call of it.
  void hand_over(const std::string& function, const std::vector<Statement>& arguments);
  /// Once all moves are read: notes which parameters other statements use.
  void note_uses(const std::vector<Statement>& statements,
                 const std::vector<ProgramTarget>& targets);
  /// Whether moves alone use a parameter, and it is what a call states.
  bool only_moves_use(const RoutineParameter& parameter);

  /// The arguments between the brackets of a call.
  std::vector<Statement> arguments_in(int line, size_t open, size_t close) const;
  /// The bracket that closes the one at `open`; `end` if there is none.
  size_t closing(size_t open, size_t end) const;
  std::string part_of(const Statement& part) const {
    return text_.substr(part.begin, part.end - part.begin);
  }

 private:
  struct Assignment {
    Statement value;
    int scope = 0;
    bool is_element = false;   // of one element
    std::optional<int> index;  // of the element, if it is a plain number
  };
  // What stands left of an assignment.
  struct Assigned {
    std::string name;
    size_t end = 0;  // of the name
    bool is_local = false;
  };
  struct Variable {
    std::vector<Assignment> assignments;
    std::optional<ProgramFlow::Values> flow;      // which of them holds, once it was asked for
    bool is_calculated = false;                   // its value is that of a call
    std::optional<RoutineParameter> parameter;    // that it is
    std::optional<Statement> handed;              // that stands for it
    bool is_used = false;                         // a parameter, by other statements than moves
  };

  void read_assignments(const Statement& statement);
  void read_assignment(const Assigned& to, const Statement& from_equals);
  // The assignment whose value a variable has at a place; null if that is not certain.
  const Assignment* assignment_at(Variable& variable, size_t at);
  std::optional<UrValue> assigned_value(const Assignment& assignment, const std::string& name,
                                        int depth);
  std::optional<UrValue> with_elements(Variable& variable, const Assignment* assignment,
                                       const std::string& name, int depth);
  int point_of_literal(const UrValue& value, std::vector<ProgramPoint>& points);
  int computed_point_of(const UrValue& value, std::vector<ProgramPoint>& points);
  std::optional<int> take_index(TextCursor& cursor) const;
  std::optional<double> number_of(const Statement& expression);
  std::optional<double> number_in(const Statement& part);
  std::optional<double> take_named_number(TextCursor& cursor);
  void find_numbers(ListItem& list);
  std::optional<ListItem> list_of_expressions(size_t begin, size_t end) const;
  bool begins_pose(const std::string& word, TextCursor cursor) const;
  template <class With>
  void each_variable(const Statement& argument, With with);
  // The variable of a name at a place; null if its value there is not certain.
  Variable* find(const std::string& name, size_t at);
  // A name that ends at `end`, as it is spelled: URScript tells capitals from small letters.
  std::string spelled(const std::string& name, size_t end) const {
    return text_.substr(end - name.size(), name.size());
  }
  std::string take_spelled(TextCursor& cursor) const {
    const std::string name = cursor.take_name();
    return spelled(name, cursor.at());
  }
  // Whether it is a name that a function gives a value of its own: a parameter or a local name.
  bool is_local(const Statement& argument);
  bool is_calculated(const Statement& frame);
  std::optional<Statement> point_in(const Statement& argument, int depth);
  std::vector<int> points_of(const Variable& variable) const;
  struct Offset {
    size_t end;
    int tool;
  };
  std::set<Variable*> used_elsewhere(const std::vector<Statement>& statements,
                                     const std::vector<ProgramTarget>& targets);
  std::optional<UrValue> literal_in(const Statement& part);
  std::optional<UrValue> value_of(const Statement& argument, int depth);
  bool is_place_of_arm(const Statement& argument) const;
  std::optional<UrValue> inverse_of(const std::vector<Statement>& arguments, int depth);
  std::optional<UrValue> shifted(const std::vector<Statement>& arguments, int depth);
  void read_returns(const std::vector<Statement>& statements);
  std::optional<UrValue> returned(const std::string& function,
                                  const std::vector<Statement>& arguments, int depth);
  std::optional<UrValue> element_of(const std::string& name, const Statement& argument,
                                    TextCursor cursor);
  bool count_from_base(UrValue& value) const;
  bool put_in_frame(UrValue& value, const Statement& frame, const std::optional<Pose>& pose);
  std::optional<Pose> constant(const Statement& argument, int depth);

  const std::string& text_;
  const std::string& original_;
  std::vector<ProgramFrame>& frames_;
  const KnownFrames& known_;
  Scopes scopes_;
  ProgramFlow flow_;
  ScopedNames<Variable> variables_;
  std::map<size_t, double> numbers_;  // by where the expressions begin
  int numbers_in_one_another_ = 0;    // that are being found
  std::map<size_t, int> points_;      // of variables, by where their literals stand
  std::map<std::string, std::vector<Variable*>> parameters_;  // of functions
  // What functions return that do nothing else; nothing of a name that has several.
  std::map<std::string, std::optional<Statement>> returns_;
  std::set<size_t> moves_;            // where a move, or the head of a function, names its point
  std::map<size_t, Offset> offsets_;  // expressions of moves that are left alone, by their begin
};

}  // namespace armtrue
