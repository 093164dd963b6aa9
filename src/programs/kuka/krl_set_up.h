#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/kuka/krl_syntax.h"
#include "programs/program_warnings.h"

namespace armtrue {

/// Follows $BASE and $TOOL through a KRL program, also through its calls, branches, loops and
/// jumps: direct assignments, BAS with a base, a tool or #INITMOV, the FDAT of inline forms, WITH
/// of spline moves and blocks (KUKA, KSS 8.x operating and programming instructions for system
/// integrators), and what other programs of its project hand on: HandedFrames are base, tool and
/// mode, `#TCP` if the tool is stationary, else `#BASE`. A subprogram that nothing calls begins
/// without base and tool.
class KrlSetUps {
 public:
  /// `src`: the text of the .src. All must outlive it.
  KrlSetUps(const std::string& src, const KrlSyntax& syntax, const ProgramNeighbours& neighbours,
            const KnownFrames& known, std::vector<ProgramFrame>& frames, ProgramWarnings& warnings);

  struct SetUp {
    int base = -1, tool = -1;      ///< in the frames; -1: not stated
    bool is_external_tcp = false;  ///< the tool is stationary, the robot holds the part
    bool is_uncertain = false;     ///< it may be one of several; then nothing is stated
    bool is_calculated = false;    ///< uncertain because another program calculates it
    bool is_interrupted = false;   ///< uncertain because an interrupt or a TRIGGER may set it
    bool operator==(const SetUp&) const = default;
  };
  struct List {
    std::vector<SetUp> of_moves;
    std::vector<SetUp> behind;  ///< so many statements of KrlSyntax::set_ups
    std::vector<bool> are_of_callers;  ///< of moves: whether callers in other programs state them
    std::string callers;        ///< which hand on several; empty if none do
    std::string interrupts;     ///< subprograms that set frames at any time; empty if none do
    std::vector<std::string> not_followed;  ///< of moves: the frame whose value is not; or empty
  };

  /// Base and tool at each place of the program.
  List read();
  /// The same where a statement begins; once read() was called.
  SetUp before(size_t statement) const { return at(statement - 1); }
  /// What a statement that calls another program hands on.
  HandedFrames handed_on(size_t statement) const;
  /// The frames that a routine of ProgramNeighbours::begins leaves to its callers. If they begin
  /// with any_frames(), frames that it keeps are `as_before`.
  HandedFrames left_by(const std::string& routine) const;
  static HandedFrames any_frames();

 private:
  enum Part : std::uint8_t { kBase, kTool, kMode };  // kMode: 1 if the tool is stationary
  static constexpr std::array<int, 3> kStart{-1, -1, 0};
  static constexpr int kAnyMode = 2, kUncertain = ProgramFlow::kUncertain;
  static constexpr int kCalculated = -2;               // by another program, as it runs
  static constexpr int kOfCaller = -3;                 // of without_callers_
  static constexpr int kNoFdat = -1;                   // else: of the set-ups of the syntax
  using Settings = std::array<std::optional<int>, 3>;  // that a statement sets
  using Span = std::pair<size_t, size_t>;              // of the text: begin, end
  // A subprogram that an INTERRUPT or a TRIGGER calls, and that sets a part.
  struct Interrupt {
    std::string name;
    Span own;                       // where only it runs; empty if others call it, too
    ProgramFlow::Values may_run{};  // 0: not yet
  };
  using SettingsInOrder = std::array<std::vector<ProgramFlow::Setting>, 3>;

  void follow_statements();
  SettingsInOrder follow_round();
  void follow(const ProgramFlow& flow, const SettingsInOrder& settings);
  static void add(const Settings& set, const KrlSetUp& statement, SettingsInOrder& settings);
  void add_fdats(const ProgramFlow& flow, std::vector<ProgramFlow::Setting> kept,
                 SettingsInOrder& settings);
  bool is_without_bas(size_t fdat) const;
  void find_interrupts(const SettingsInOrder& settings);
  std::vector<Span> texts_run_by(const std::string& routine) const;
  bool may_be_set_by(const std::string& interrupt, Part part, const SettingsInOrder& settings,
                     const std::vector<Span>& texts) const;
  bool is_interrupted(size_t part, size_t place) const;
  std::string name_of(const KrlSetUp& definition) const;
  void follow_without_callers(const ProgramFlow& flow, SettingsInOrder& settings);
  bool are_of_callers(size_t place, const Settings& of_move) const;
  bool add_initial_frames(SettingsInOrder& settings);
  bool is_bas(const KrlSetUp& statement, std::initializer_list<std::string_view> commands) const;
  void add_callers(ProgramFlow& flow, SettingsInOrder& settings);
  void add_what_others_leave(SettingsInOrder& settings, std::vector<ProgramFlow::Setting>& fdats);
  int handed(const HandedFrame& frame, size_t part);
  HandedFrame as_handed(int value, size_t part) const;
  HandedFrames all_as_handed(size_t place) const;
  Settings begin_of(const KrlSetUp& definition) const;
  void leave_subprograms(List& list) const;
  SetUp at(size_t place, const Settings& of_move = {}) const;
  Settings with_of(const KrlMove& move);
  Settings set_by(const KrlSetUp& statement);
  void assign(const std::string& name, size_t begin, size_t end, int line, Settings& settings);
  void read_bas(const std::string& spelled, size_t at, Settings& settings);
  int number_in(const char* list, const std::string& number, const std::string& spelled, size_t at);
  Settings read_fdat(const KrlSetUp& statement, size_t place);
  std::optional<KrlFdat> fdat_at(const std::string& name, size_t place) const;
  void read_with(size_t begin, size_t end, int line, Settings& settings);
  void set_fdat(const std::string& name, const std::optional<KrlFdat>& fdat,
                const Statement& statement, Settings& settings);
  int with_component(Part part, const std::string& spelled, size_t place);
  int frame_of(size_t begin, size_t end, size_t place);
  int product_of(const std::vector<Statement>& factors, const std::string& spelled, size_t place);
  int held_at(Part part, size_t place);
  int held_before(Part part, size_t place);
  int add(const std::string& name, const std::optional<Pose>& pose);
  int add_value(const std::string& name, const Pose& pose);
  int add_not_followed(const std::string& spelled);
  void set_not_followed(const std::string& fdat, Settings& settings);
  std::string not_followed(const SetUp& set_up) const;
  int add_name(const std::string& name, size_t place);
  int value_at(const std::string& name, const KrlSetFrame& frame, size_t place);
  std::optional<int> kept_in(const std::string& name, Part part, size_t place);
  int number_of(const char* list, int number, size_t place);
  std::string_view text(size_t begin, size_t end) const;

  const std::string& src_;
  const KrlSyntax& syntax_;
  const ProgramNeighbours& neighbours_;
  const KnownFrames& known_;
  std::vector<ProgramFrame>& frames_;
  ProgramWarnings& warnings_;
  std::set<std::pair<int, std::string>> undeclared_;  // FDATs that were named, by line
  std::map<std::string, size_t> behind_callers_of_;  // places behind the text
  std::array<ProgramFlow::Values, 3> values_, without_callers_;
  std::map<std::string, ProgramFlow::Values> of_set_frames_;  // by name: index in the frames
  std::map<std::string, std::map<std::vector<double>, int>> values_of_names_;  // frames by poses
  std::set<int> not_followed_;                                                 // frames
  std::array<std::vector<Interrupt>, 3> interrupts_;                           // of each part
  bool is_followed_ = false;        // values_ hold, perhaps not all of them yet
  bool depends_on_itself_ = false;  // a frame on the one before: $BASE=$BASE:{..}, $BASE.Z=..
};

}  // namespace armtrue
