#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/zone.h"
#include "armtrue/effects/catalogue.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/path_io.h"
#include "armtrue/io/provenance.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/path/joint_path.h"
#include "armtrue/text/input_error.h"

namespace armtrue::app {

/// Exit codes, the same for every command.
inline constexpr int kSuccess = 0;
inline constexpr int kBadInput = 1;  ///< bad data, or reading or writing failed
inline constexpr int kBadUsage = 2;
inline constexpr int kNotReached = 3;  ///< it ran, but a criterion failed

/// One command: its options, those that all commands share, and its work. The constructor opens no
/// file.
class Command {
 public:
  Command(std::string name, const std::string& purpose, const std::string& example);

  /// For the command's own options.
  CLI::App& options() { return app_; }
  /// The options that most commands need, each added on request.
  void add_input(const std::string& what);
  void add_output();
  /// A further product. No two products may go to one file, nor one to a file that is read.
  CLI::Option* add_output(const std::string& name, std::string& path, const std::string& what);
  void add_seed();
  void add_new_sessions();

  std::string input = "-";
  std::string output = "-";
  std::uint64_t seed = 1;
  std::vector<double> new_sessions_s;
  bool verbose = false, quiet = false;

  /// Parses the arguments and runs `work`, whose result is the exit code. Errors become a message
  /// on stderr and their exit code.
  int run(int argc, char** argv, const std::function<int()>& work);

  /// A word to the user on stderr, unless -q.
  void warn(const std::string& message) const;
  /// Shown on stderr only with -v.
  void tell(const std::string& message) const;
  /// What is being done: on stderr, only on a terminal and only after a second of work.
  void progress(const std::string& message);

  /// Reads a robot and a campaign, keeps their sums for the provenance, and passes warnings on.
  RobotFile robot(const std::string& path);
  /// Begins the new sessions that were asked for. Throws InputError if the numbers give a mistake
  /// of units, frames or signs away.
  Campaign campaign(const std::string& path, const Robot& robot);
  /// Columns that the command does not know are named, unless the rows are kept for the output.
  PathFile path(const std::string& path, KeepRows keep = KeepRows::no);
  Provenance provenance() const;

 private:
  void check_outputs() const;
  void begin_new_sessions(Campaign& campaign, bool is_input) const;
  void warn_of_unknown(const std::vector<std::string>& columns) const;

  std::string name_;
  CLI::App app_;
  std::vector<const CLI::Option*> outputs_;
  std::vector<std::pair<std::string, std::string>> inputs_;
  double started_ = 0;
  bool progress_shown_ = false;
};

/// The error of a sample that the robot cannot take, with the file and line where it stands.
InputError at_its_line(const PathFile& file, const UnreachableSample& error);

/// Does work on the path of a file, and throws that error for such a sample.
template <typename Work>
auto on_samples_of(const PathFile& file, const Work& work) {
  try {
    return work();
  } catch (const UnreachableSample& error) {
    throw at_its_line(file, error);
  }
}

/// Splits `A1.alpha, A2.d` at its commas; spaces about an item are no part of it.
std::vector<std::string> split_list(const std::string& text);

/// Targets with numbers for ids, less those that are taken, so that both fit into one file.
std::vector<JointTarget> numbered(const std::vector<JointVector>& configurations,
                                  const std::vector<std::string>& taken);

/// An option of `count` numbers at commas, such as `x,y,z,radius in mm` (the `form`, for messages).
/// One text, not several values: those would take the file that follows for one more.
void add_numbers(CLI::App& options, const std::string& name, std::vector<double>& numbers,
                 size_t count, const std::string& form, const std::string& help);

/// What to say of a fit that did not converge.
std::string not_converged(const CalibrationResult& fit);

/// Checks for options of one number: the messages of CLI11 name the largest double.
CLI::Validator above_zero();
CLI::Validator not_below_zero();
/// CLI11 wraps a seed below zero round, and cuts one that is too large.
CLI::Validator seed_number();

/// The catalogue from a file, or the one that armtrue ships for "".
Catalogue catalogue(const std::string& path);

/// --zone x,y,z,radius [mm], and the zone it stands for; std::invalid_argument if it is none.
void add_zone(CLI::App& options, std::string& zone, const std::string& help);
Zone zone(const std::string& text);

}  // namespace armtrue::app
