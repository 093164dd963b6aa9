#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/abb/rapid_calls.h"
#include "programs/abb/rapid_insertion.h"
#include "programs/abb/rapid_words.h"
#include "programs/move_reader.h"
#include "programs/program_flow.h"
#include "programs/scoped_names.h"
#include "programs/statement.h"

namespace armtrue {

/// The names of a component of a record, TRANS and Z.
using RapidPath = std::vector<std::string>;

/// The data of a RAPID program: points, tools and work objects that it declares or that are
/// parameters of its routines.
class RapidData {
 public:
  /// `text`: the program by masked(), whose line ends are blanks. All must outlive it.
  RapidData(RobotProgram& program, const std::string& text, const KnownFrames& known,
            TargetParts parts)
      : program_(program), text_(text), known_(known), parts_(parts) {}

  void read(const std::vector<Statement>& statements);
  /// How the program runs, once it is read; it must outlive this.
  void set_flow(const ProgramFlow& flow) { flow_ = flow; }

  /// The point that an argument stands for; -1 and the reason if it cannot be followed. `depth`: of
  /// the displacements that it stands in.
  int point_at(const Statement& argument, TargetKind kind, int line, std::string& why_not,
               int depth = 0);
  /// A tool or a work object.
  struct Frame {
    int index = -1;               ///< in the frames
    std::optional<bool> is_held;  ///< by the robot, if the text says it
  };
  /// The tool or work object of an argument; the reason if it is not certain and a target of this
  /// kind needs it.
  Frame tool_at(const Statement& argument, TargetKind kind, std::string& why_not);
  Frame work_object_at(const Statement& argument, TargetKind kind, std::string& why_not);
  /// Why a tool or a work object of a routine is not certain; empty if the target does not need it.
  std::string why_not_of_routine(TargetKind kind) const {
    return needs_frame(kind) ? "its tool or work object is given by its routine" : "";
  }
  /// Radius of a zone [m]; 0 of fine, and of one that is not known for certain.
  double radius_of_zone(const Statement& argument);
  /// wobj0.
  Frame room_frame();
  const RapidExternalAxes& external() const { return external_; }

  /// A move to the point is left alone: its declaration must stay. An offset starts from it, and
  /// follows it if all moves to the point have the tool and the work object of `in_frames`; null if
  /// they are not known.
  void leave(const Statement& argument, const ProgramTarget* in_frames);
  /// The declarations of all points in an argument must stay.
  void keep(const Statement& argument);

  /// The parameter of a procedure of the text that an argument is, and nothing else.
  std::optional<RoutineParameter> parameter_at(const Statement& argument);
  /// Whether a procedure of the text, of which there is one, gets copies of points.
  bool hands_points_to(const std::string& procedure) const {
    return !points_handed_to(procedure).empty();
  }
  /// Whether moves alone use the point of a parameter, and it is what the call states.
  bool only_moves_use(const RoutineParameter& parameter) const;
  /// What a call hands to the parameters of a procedure, in their order; nothing if it names one of
  /// them. `cursor`: behind the name of the procedure.
  std::vector<Statement> arguments_of_call(TextCursor cursor, size_t end) const;
  /// A point with numbers that no move uses, but another statement does.
  struct Use {
    int line = 0;
    std::string name;
    bool may_move = false;  ///< it is handed to a routine that no text has
  };
  /// Once all moves are read: marks the points whose declaration must stay.
  std::vector<Use> finish();

 private:
  using Element = std::vector<size_t>;  // its indices, from 1; of the whole none
  struct Datum {
    ListItem list;
    int values = 0;  // how often it is given one
    // What the program sets of it, such as ".OFRAME.TRANS", and whether it sets some of it twice.
    std::vector<std::string> set_parts;
    bool is_set_again = false;
    int line = 0;
    std::string type;
    std::string routine;  // of a parameter
    bool is_constant = false, is_parameter = false;
    bool is_copied = false;          // a parameter that is no variable of the caller
    std::optional<size_t> position;  // of a parameter of a procedure that is not optional
    bool is_shared = false;          // other statements than moves use it
    bool is_of_others = false;       // other modules declare it or use it
    int text = 0;                    // in RobotProgram::texts
    std::optional<double> number;    // of a constant
    std::map<Element, int> points;
    // Assignments of it, or of a component: where, of what, and what it becomes.
    struct Change {
      size_t at;
      RapidPath path;
      Statement value;
    };
    std::vector<Change> changes;
    bool is_taken = false;  // a point that is followed takes its value
    bool is_lost = false;   // something else may change it, too, or it is an array
    std::map<std::vector<size_t>, ProgramFlow::Values> flows;  // by indices of changes
  };
  using FramesOfMove = std::pair<int, int>;  // work object and tool, in RobotProgram::frames
  struct Offset {
    Statement argument;
    FramesOfMove frames;
  };
  struct UseOfDatum {
    Use use;
    const Datum* datum;
  };

  void declare(const std::string& kind, const Statement& statement, TextCursor cursor, int scope);
  void declare_parameters(const std::string& kind, TextCursor cursor, int scope);
  void note_handed(std::string_view text, const Statement& statement, size_t at, TextCursor behind,
                   Datum& datum) const;
  void read_uses(const Statement& statement);
  std::vector<RoutineParameter> points_handed_to(const std::string& procedure) const;
  bool is_displaced(const Statement& argument) const;
  void keep_starts_in_other_frames();
  bool is_point_text(const Statement& argument) const;
  bool note_assignment(const Statement& statement, const std::string& word, size_t at,
                       TextCursor cursor);
  static void note_set_part(std::string_view text, const std::string& name, TextCursor behind,
                            Datum& datum);
  void read_others(const std::vector<Statement>& statements);
  void note_uses_of_others(const std::string& text, const std::vector<Statement>& statements);
  static bool take_value(const std::string& kind, const std::string& type, TextCursor cursor,
                         Datum& datum);
  // Nothing declares it here: other modules may.
  Datum* find_of_others(const std::string& name) {
    const auto found = of_others_.find(name);
    return found == of_others_.end() ? nullptr : &found->second;
  }
  Datum* find(const std::string& name, size_t at) {
    Datum* const own = names_.find(scopes_, name, scopes_.at(at));
    return own ? own : find_of_others(name);
  }
  bool needs_frame(TargetKind kind) const {
    return kind == TargetKind::cartesian && parts_ == TargetParts::pose;
  }
  std::optional<Element> take_element(TextCursor& cursor);
  static const ListItem* list_of(const Datum& datum, const Element& element);
  // The list of a tool or work object, and its text.
  struct FrameList {
    std::optional<ListItem> list;
    int text = 0;
    std::string name;  // of the frame: with the lines that set it, if any does
  };
  FrameList value_of(const Statement& argument, const char* type, TargetKind kind,
                     std::string& why_not);
  std::optional<Pose> pose_of(const ListItem& list, const std::string& name, TargetKind kind,
                              std::string& why_not) const;
  int add_point(const ListItem& list, TargetKind kind, const std::string& name, int line, int text);
  struct Displacement {
    Statement point;  // the one that is displaced
    Eigen::Vector3d shift = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();  // [m], [rad]
  };
  std::optional<Displacement> displacement_of(const std::string& function,
                                              const Statement& argument);
  int displaced_point(const std::string& function, const Statement& argument, TargetKind kind,
                      int line, std::string& why_not, int depth);
  // `place`: components of data count as they are there; nothing: none does.
  std::optional<double> constant_in(const Statement& argument,
                                    std::optional<size_t> place = std::nullopt, int depth = 0);

  // Records that assignments give constants (rapid_records.cc).
  void note_change(Datum& datum, size_t at, TextCursor behind, size_t end);
  std::optional<ListItem> record_at(Datum& datum, size_t place);
  std::optional<ListItem> component_at(Datum& datum, const RapidPath& path, const std::string& type,
                                       size_t place, int depth);
  template <class OfField>
  static std::optional<ListItem> record_of(const std::string& type, OfField of_field);
  static std::string type_in(const std::string& type, const RapidPath& path);
  static std::optional<ListItem> item_in(const ListItem& record, const std::string& type,
                                         const RapidPath& path);
  std::optional<ListItem> evaluated(const ListItem& item, const std::string& type, size_t place,
                                    int depth);
  std::optional<ListItem> value_in(const Statement& expression, const std::string& type,
                                   const RapidPath& path, size_t place, int depth);
  std::optional<ListItem> named_component(TextCursor& cursor, const std::string& type,
                                          const RapidPath& path, size_t place, int depth);
  std::optional<double> number_of_component(Datum& datum, TextCursor& cursor, size_t place,
                                            int depth);
  int add_assigned_point(Datum& datum, const Statement& argument, int line);
  FrameList assigned_frame(Datum& datum, const std::string& name, size_t place,
                           std::string& why_not);
  int add_frame_named(std::string name, const std::optional<Pose>& pose);
  std::string name_of(const Statement& argument) const {
    return upper(std::string_view(text_).substr(argument.begin, argument.end - argument.begin));
  }
  // TRUE or FALSE.
  std::optional<bool> bool_of(const ListItem& item, int text) const {
    const std::string& whole = program_.texts[text].text;
    const std::string word =
        upper(std::string_view(whole).substr(item.begin, item.end - item.begin));
    if (word != "TRUE" && word != "FALSE") return std::nullopt;
    return word == "TRUE";
  }

  RobotProgram& program_;
  const std::string& text_;
  const KnownFrames& known_;
  const TargetParts parts_;
  Scopes scopes_;
  ScopedNames<Datum> names_;
  std::map<std::string, Datum> of_others_;                 // global data of other modules
  std::vector<UseOfDatum> uses_;                           // of points, outside of moves
  std::vector<Offset> offsets_;                            // moves that are left alone
  RapidRoutines routines_;                                 // of all texts
  std::map<std::string, std::vector<Datum*>> procedures_;  // their parameters, by position
  RapidExternalAxes external_;
  std::optional<ProgramFlow> flow_;
};

}  // namespace armtrue
