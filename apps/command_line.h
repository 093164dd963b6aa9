#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/calibration/left_out.h"
#include "armtrue/diagnosis/sensor_field.h"
#include "armtrue/effects/catalogue.h"
#include "armtrue/io/archive.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/joint_target_io.h"
#include "armtrue/io/path_io.h"
#include "armtrue/io/products/certificate_io.h"
#include "armtrue/io/products/compensation_io.h"
#include "armtrue/io/provenance.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/path/joint_path.h"
#include "armtrue/planning/pose_cloud.h"
#include "armtrue/programs/program_text.h"
#include "armtrue/text/input_error.h"
#include "options.h"

namespace CLI {
class ParseError;
}  // namespace CLI

namespace armtrue::app {

/// Exit codes, the same for every command.
inline constexpr int kSuccess = 0;
inline constexpr int kBadInput = 1;  ///< bad data, or reading or writing failed
inline constexpr int kBadUsage = 2;
inline constexpr int kNotReached = 3;  ///< the command ran, but a criterion failed

/// What a product is: a document of keys or a table, which go to a .json file as JSON, or a
/// program, a page, which must not be called .json.
enum class ProductKind { document, table, other };

/// One command: its options, the options that all commands share, and the files that it reads. It
/// opens no file before all arguments are parsed and checked.
class Command : public OptionGroup {
 public:
  Command(std::string name, const std::string& purpose, std::string example);
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  /// Options that most commands need, each added on request.
  void add_input(const std::string& what);
  void add_output(ProductKind kind = ProductKind::other);
  /// A further product. Two products may not go to one file, and none to a file that is read.
  Option add_output(const std::string& name, std::string& path, const std::string& what,
                    ProductKind kind = ProductKind::other);
  /// A folder of products, which is replaced as a whole; it may contain nothing else.
  Option add_output_folder(const std::string& name, std::string& path, const std::string& what);
  void add_seed();
  void add_new_sessions();
  /// A paragraph of --help on the columns of a file; see columns.h.
  void add_columns(const std::string& columns) { columns_ += "\n" + columns; }

  std::string input = "-";
  std::string output = "-";
  std::uint64_t seed = 1;
  std::vector<double> new_sessions_s;
  bool verbose = false, quiet = false;
  bool arm_in_doubt = false;  ///< refuse_mistakes() doubts that the robot file is of the arm
  bool warned_of_change = false;  ///< refuse_mistakes() warned of a change among the readings
  std::string wrong_readings;  ///< refuse_mistakes() found it: what is calibrated must not be used
  bool angles_read_early = false;  ///< refuse_mistakes() warned that the arm still moved
  SensorError sensor_error;    ///< refuse_mistakes() found it: a fit takes it off the readings

  /// Parses the arguments, then runs `work`. Returns the exit code of the process. An exception
  /// becomes a message on stderr and an exit code.
  int run(int argc, char** argv, const std::function<int()>& work);

  /// A message on stderr, unless -q; it stands in the provenance of what is written after it, too.
  void warn(const std::string& message);
  /// A text on stderr, only with -v.
  void tell(const std::string& message) const;
  /// A result on stderr: on a terminal unless -q, elsewhere only with -v.
  void report(const std::string& message) const;
  /// Reports a product that is a file, unless its name is empty; `note` follows the name.
  void report_written(const std::string& path, const std::string& note = "") const;
  /// Whether report() prints: some results take time.
  bool reports() const;
  /// What the command does now: on stderr, only on a terminal and only after a second of work.
  void progress(const std::string& message);

  /// These read a file, note its SHA-256 for the provenance and print the warnings of the reader.
  RobotFile read_robot(const std::string& path);
  /// Of a file that was read elsewhere.
  void add_to_inputs(const std::string& name, const std::string& sha256) {
    inputs_.emplace_back(name, sha256);
  }
  /// Of a robot that was read before the other inputs; warns of its sizes.
  void add_robot_to_inputs(const RobotFile& file);
  /// Contradictions between columns are errors or warnings (see check_log()). Sessions begin at the
  /// times of --new-session-at-s. A fit leaves out copies of readings, with a warning
  /// (copied_rows()). Call refuse_mistakes() on the result.
  enum class Copies { leave_out, keep };
  Campaign read_campaign(const std::string& path, const Robot& robot,
                         Copies copies = Copies::leave_out);
  /// Warns if a robot that should be nominal is the result of a calibration.
  void warn_if_calibrated(const Robot& robot, const std::string& path);
  /// Takes the effects without a name out of a robot that is to be fitted, with a warning.
  void forget_remainder(Robot& robot, const std::string& path);
  /// Warns, and returns true, if the robot predicts the points as only computed ones. Call it with
  /// the robot file as it was read.
  bool warn_if_computed(const Robot& robot, const Campaign& campaign);
  /// The same, and warns if the robot file fits the readings as it is: no arm is made so.
  void warn_if_needless(const Robot& robot, const Campaign& campaign);
  /// Warns if a file that was read here made the robot: readings agree with what was fitted to
  /// them.
  void warn_of_own_readings(const RobotFile& robot);
  /// Warns if rows of a campaign are among those that calibrated the robot, in whatever file they
  /// stand; `consequence`: what that means for the figures.
  void warn_of_training(const RobotFile& robot, const Campaign& campaign,
                        const std::string& consequence);
  /// Unknown columns are named, unless the rows are kept for the output.
  /// Joint columns are those of the robot, without one those of six axes.
  PathFile read_path(const std::string& path, KeepRows keep = KeepRows::no,
                     const std::optional<Robot>& robot = std::nullopt);
  PathFile read_force_record(const std::string& path);
  /// All columns are kept for the output.
  ProgramFile read_program(const std::string& path, const Robot& robot);
  About read_about(const std::string& path);
  /// The values of an older certificate for a comparison.
  CertifiedValues read_certificate(const std::string& path);
  /// A robot program; with its .dat if `with_dat`: `dat`, or that beside it.
  std::vector<ProgramText> read_program_texts(const std::string& path, const std::string& dat,
                                              bool with_dat);
  /// The texts of a folder of robot programs, or one text.
  std::vector<ProgramText> read_program_folder(const std::string& folder);
  /// The same of an archive; names are those in it.
  std::vector<ProgramText> read_program_archive(const Archive& archive, const std::string& path);

  Provenance provenance() const;

  /// For a product whose name is derived. Throws a mistake in the arguments if an argument names
  /// this file too, also by another name or as the file behind a standard stream; InputWouldBeLost
  /// if it was read; OutputError if it cannot be written.
  void check_derived_output(const std::string& path) const;

 private:
  int parse_and_work(int argc, char** argv, const std::function<int()>& work);
  int finish_parsing(const CLI::ParseError& error) const;
  std::string usage_mistake(const CLI::ParseError& error) const;
  std::vector<std::pair<std::string, std::string>> named_files(const CLI::Option* own) const;
  void refuse_named(const std::string& path, const std::string& name, const CLI::Option* own) const;
  void check_outputs() const;
  void check_folders() const;
  void leave_out_copies(Campaign& campaign);
  void warn_of_turns(const std::string& source, const std::vector<MovedByTurns>& moved,
                     const Robot& robot, const std::vector<int>& lines);
  void begin_new_sessions(Campaign& campaign, bool is_input) const;
  void warn_of_unknown(const std::vector<std::string>& columns);

  std::string name_, example_, columns_;
  std::vector<const CLI::Option*> outputs_, with_json_, folders_;
  std::vector<std::pair<std::string, std::string>> inputs_;
  std::vector<std::string> warnings_;
  double started_ = 0;
  bool progress_shown_ = false, has_input_ = false;
};

/// Throws InputError if the numbers of a campaign show a mistake of units, frames or signs, and
/// warns of possible ones. The diagnosis calibrates the robot.
void refuse_mistakes(Command& command, const Robot& robot, const Campaign& campaign);

/// The encoder values of an option, see joints_of(). Warns if its angles look like radians.
JointVector joints_of(Command& command, const std::vector<double>& numbers, const Robot& robot,
                      const std::string& option);

/// Warns of all sentences that are not empty.
void warn_of_all(Command& command, const std::vector<std::string>& doubts);

/// Throws InputError if the robot file has sessions, but not all of the campaign.
void require_sessions(const Robot& robot, const Campaign& campaign);

/// The error of a sample that the robot cannot take, with the file and line of the sample.
InputError at_its_line(const PathFile& file, const UnreachableSample& error);

/// Runs `work` on the path of a file; throws at_its_line() for a sample that the robot cannot take.
template <typename Work>
auto on_samples_of(const PathFile& file, const Work& work) {
  try {
    return work();
  } catch (const UnreachableSample& error) {
    throw at_its_line(file, error);
  }
}

/// Throws InputError if two robots of one command have not the same joints, by number and kind;
/// `a` and `b` are their files.
void require_same_joints(const Robot& robot, const std::string& a, const Robot& other,
                         const std::string& b);

/// The same of `robot` and of `truth`, which is measured in its place; warns if they are no models
/// of one arm.
void require_one_arm(Command& command, const Robot& robot, const std::string& a, const Robot& truth,
                     const std::string& b);

/// Warns of targets beyond the travel of the joints, which a real controller refuses.
void warn_beyond_travel(Command& command, const std::string& file,
                        const std::vector<JointTarget>& targets, const KinematicChain& chain);

/// Targets with the ids 1, 2, 3 ..., without the ids in `taken`, so that both fit into one file.
std::vector<JointTarget> numbered(const std::vector<PlannedPose>& poses,
                                  const std::vector<std::string>& taken);

/// --parameters and --correlations.
void add_parameter_tables(Command& command, std::string& parameters, std::string& correlations);
/// Writes those that are asked for. `nominal`: the robot before the calibration; `poses`: of the
/// fit.
void write_parameter_tables(const std::string& parameters, const std::string& correlations,
                            const Robot& nominal, const CalibrationResult& result, int poses);

/// Sets what is identified to that of --identify, unless it is empty. Throws InputError for an
/// entry that names nothing of the robot.
void use_identify(const std::string& list, Robot& robot);
/// The entries of a list such as base,tool that `option` gives. Throws InputError for one that
/// names nothing of the robot.
std::vector<std::string> parameters_of(const std::string& option, const std::string& list,
                                       const Robot& robot);

/// Reads a catalogue; "" stands for the catalogue that armtrue ships.
Catalogue catalogue(const std::string& path);

}  // namespace armtrue::app
