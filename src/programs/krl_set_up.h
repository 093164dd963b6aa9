#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/krl_syntax.h"
#include "programs/program_warnings.h"

namespace armtrue {

/// Follows $BASE and $TOOL through a KRL program, in the order of the text: direct assignments,
/// BAS(#BASE,n) and BAS(#TOOL,n), the FDAT of inline forms, WITH of spline moves and blocks, and
/// what a subprogram of the text sets that is called (KUKA, KSS 8.x operating and programming
/// instructions for system integrators).
class KrlSetUps {
 public:
  /// `src`: the text of the .src. All must outlive it.
  KrlSetUps(const std::string& src, const KrlSyntax& syntax, const KnownFrames& known,
            std::vector<ProgramFrame>& frames, ProgramWarnings& warnings);

  struct SetUp {
    int base = -1, tool = -1;      ///< in the frames; -1: not stated
    bool is_external_tcp = false;  ///< the tool is stationary, the robot holds the part
    bool operator==(const SetUp&) const = default;
  };
  struct List {
    std::vector<SetUp> of_moves;
    std::vector<SetUp> behind;  ///< so many statements of KrlSyntax::set_ups
  };

  /// Base and tool at each place of the program.
  List read();

 private:
  enum Part : std::uint8_t { kBase, kTool, kMode };  // kMode: 1 if the tool is stationary
  struct Setting {
    int value;
    size_t by;  // which statement, from 1; 0: none in this DEF
  };
  using Settings = std::array<Setting, 3>;
  static constexpr Settings kNothing{{{-1, 0}, {-1, 0}, {0, 0}}};
  // A loop that is open: what holds where its first turn begins, and for each part the line of the
  // first move that has it from there.
  struct Loop {
    Settings begin;
    std::array<int, 3> line_of_move{};
  };

  SetUp at(const KrlMove& move);
  static SetUp set_up(const Settings& settings);
  void note_use(const Settings& settings, int line);
  void end_loop();
  void apply(size_t index);
  void call(const KrlSetUp& statement);
  Settings effect_of(const std::string& subprogram);
  void assign(const std::string& name, size_t begin, size_t end, int line, Settings& settings);
  void read_bas(const std::string& spelled);
  void read_with(size_t begin, size_t end, int line, Settings& settings);
  void set_fdat(const std::string& name, int line, Settings& settings);
  void set(Part part, int value, Settings& settings) const;
  int frame_of(size_t begin, size_t end);
  int add(const std::string& name, const std::optional<Pose>& pose);
  int number_of(const char* list, int number);
  void warn(int line, const std::string& text);
  std::string_view text(size_t begin, size_t end) const;

  const std::string& src_;
  const KrlSyntax& syntax_;
  const KnownFrames& known_;
  std::vector<ProgramFrame>& frames_;
  ProgramWarnings& warnings_;
  Settings now_ = kNothing;
  std::vector<Loop> loops_;
  std::unordered_map<std::string, size_t> subprograms_;  // statement behind DEF, by name
  std::unordered_map<std::string, Settings> effects_;    // what a subprogram sets
  std::unordered_map<size_t, int> lines_of_calls_;       // that set a frame, until a move has it
  int calls_ = 0;            // within one another, of a subprogram that is looked through
  size_t by_ = 0;            // the number of the statement that is read, from 1
  bool set_before_ = false;  // in an earlier DEF, and not in this one
};

}  // namespace armtrue
