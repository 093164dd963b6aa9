// Readers of measurements, paths, robots and documents.

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <initializer_list>
#include <map>
#include <sstream>
#include <string>

#include "armtrue/diagnosis/log_check.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/certificate_io.h"
#include "armtrue/io/compensation_io.h"
#include "armtrue/import/import_io.h"
#include "armtrue/io/joint_target_io.h"
#include "armtrue/io/path_io.h"
#include "armtrue/io/ranking_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/urdf/ur_calibration_io.h"
#include "armtrue/urdf/urdf_io.h"
#include "fuzz/targets.h"

namespace armtrue::fuzz {
namespace {

// A file in memory.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& text) : descriptor_(memfd_create("fuzz", 0)) {
    require(descriptor_ >= 0, "no file in memory can be made");
    require(write(descriptor_, text.data(), text.size()) == static_cast<ssize_t>(text.size()),
            "the file in memory cannot be written");
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

// An arm whose joints have names of their own: a rail below six axes.
const std::vector<JointName>& rail_and_arm() {
  static const std::vector<JointName> joints = [] {
    std::vector<JointName> all{{"e1", "E1", true}};
    all.insert(all.end(), six_axis_names().begin(), six_axis_names().end());
    return all;
  }();
  return joints;
}

const std::vector<JointName>& joints_named_in(const std::string& bytes) {
  return bytes.find("e1_mm") == std::string::npos ? six_axis_names() : rail_and_arm();
}

void read_campaign_file(const std::string& bytes) {
  const std::vector<JointName>& joints = joints_named_in(bytes);
  const Campaign campaign = read_campaign(MemoryFile(bytes).path(), joints).campaign;
  check_log(campaign);
  const auto written_and_read = [&joints](const Campaign& c) {
    return read_campaign(MemoryFile(write_campaign(c, joints)).path(), joints).campaign;
  };
  // Not every number of radians is one of degrees, and orientations are kept as quaternions: both may
  // lose a last digit once.
  const Campaign once = written_and_read(campaign), twice = written_and_read(once);
  require(campaign.rows() == once.rows() && once.q == twice.q && once.position == twice.position &&
              once.distance == twice.distance && once.time_s == twice.time_s,
          "a campaign does not come back");
}

void read_path_file(const std::string& bytes) {
  const std::vector<JointName>& joints = joints_named_in(bytes);
  const MemoryFile file(bytes);
  const PathFile kept = read_path(file.path(), KeepRows::yes, joints);
  write_path_like(kept, kept.path.position);
  const std::string written = write_path(read_path(file.path(), KeepRows::no, joints).path, joints);
  const Path again = read_path(MemoryFile(written).path(), KeepRows::no, joints).path;
  require(write_path(again, joints) == written, "a path does not come back");
}

void read_joint_target_file(const std::string& bytes) {
  const std::vector<JointName>& joints = joints_named_in(bytes);
  const std::string written =
      write_joint_targets(read_joint_targets(MemoryFile(bytes).path(), joints), joints);
  const auto again = read_joint_targets(MemoryFile(written).path(), joints);
  require(write_joint_targets(again, joints) == written, "targets do not come back");
}

void read_target_file(const std::string& bytes) {
  const std::vector<JointName>& joints = joints_named_in(bytes);
  const ProgramFile file = read_program(MemoryFile(bytes).path(), joints);
  std::vector<CorrectedTarget> targets(static_cast<size_t>(file.program.rows()));
  for (CorrectedTarget& target : targets) {
    target.q = JointVector::Zero(std::ssize(joints));
    target.programmed = target.q;
  }
  write_commands(file, targets, CommandKind::joints);
  write_commands(file, targets, CommandKind::cartesian);
}

void read_robot_document(const std::string& bytes) {
  const RobotFile file = read_robot(MemoryFile(bytes).path());
  const std::string written = write_robot(file.robot);
  require(write_robot(parse_robot(written, "written.yaml")) == written, "a robot does not come back");
}

void read_catalogue_document(const std::string& bytes) { parse_catalogue(bytes, "catalogue.yaml"); }

void read_findings_document(const std::string& bytes) {
  static const KinematicChain chain = [] {
    KinematicChain six;
    for (int k = 1; k <= 7; ++k) {
      Link link;
      link.name = k <= 6 ? "A" + std::to_string(k) : "spindle";
      if (k > 6) link.joint = JointKind::fixed;
      six.links.push_back(link);
    }
    return six;
  }();
  read_findings(MemoryFile(bytes).path(), chain);
}

void read_about_document(const std::string& bytes) { read_about(MemoryFile(bytes).path()); }

void read_certificate_document(const std::string& bytes) {
  read_certificate(MemoryFile(bytes).path());
}

// The arm of the document comes back from a document of our own, and into its own; the robot file
// made of it can be read.
void read_urdf_document(const std::string& bytes) {
  frames_beside_base(bytes, "robot.urdf", {});
  const Robot robot = parse_urdf(bytes, "robot.urdf");
  // Metres and radians of another program become mm and deg, and may lose a last digit once; base
  // and tool are angles of rotations.
  const Robot own = parse_urdf(write_urdf(robot), "written.urdf");
  const Robot again = parse_urdf(write_urdf(own), "written.urdf");
  for (size_t k = 0; k < own.chain.links.size(); ++k) {
    const Link &a = own.chain.links[k], &b = again.chain.links[k];
    require(a.alpha == b.alpha && a.d == b.d && a.theta == b.theta && a.r == b.r &&
                a.beta == b.beta && a.sign == b.sign,
            "a link of a URDF does not come back");
  }
  write_into_urdf(robot, bytes, "robot.urdf", {}, {});
  parse_robot(write_robot(robot), "robot.yaml");
}

void read_ur_calibration_document(const std::string& bytes) {
  is_ur_calibration(bytes);
  const Robot robot = parse_ur_calibration(bytes, "calibration.yaml");
  write_into_ur_calibration(robot, bytes, "calibration.yaml", {});
}

// A first line `options: join=time preset=ur-rtde unit=X=mm ...` holds what import-readings is
// called with. Behind a zero byte stands the controller's table.
void read_exported_table(const std::string& bytes) {
  ImportOptions options;
  std::string tables = bytes;
  if (const std::string first = bytes.substr(0, bytes.find('\n')); first.starts_with("options:")) {
    tables = bytes.substr(std::min(first.size() + 1, bytes.size()));
    std::map<std::string, std::string> words;
    std::istringstream stream(first.substr(8));
    for (std::string word; stream >> word;) {
      const size_t equals = std::min(word.find('='), word.size());
      const std::string value = word.substr(std::min(equals + 1, word.size()));
      const std::string name = word.substr(0, equals);
      if (name == "column") options.columns.push_back(value);
      if (name == "unit") options.units.push_back(value);
      if (name == "ignore") options.ignored.push_back(value);
      const std::vector<std::string> formats = import_presets();
      if (name == "preset" && std::ranges::find(formats, value) != formats.end())
        options.presets.push_back(value);
      words[name] = value;
    }
    // The command line lets only these words through.
    const auto choose = [&words](const char* name, std::initializer_list<const char*> known) {
      for (const char* word : known)
        if (words[name] == word) return words[name];
      return std::string();
    };
    options.length_unit = choose("length", {"mm", "cm", "m", "um", "in"});
    options.angle_unit = choose("angle", {"deg", "rad", "mrad"});
    options.time_unit = choose("time", {"s", "ms", "us", "ns", "min", "h"});
    options.angles = choose("angles", {"abc", "rpy", "rotvec"});
    options.quaternion = choose("quaternion", {"wxyz", "xyzw"});
    options.decimal = choose("decimal", {"point", "comma"});
    options.join = choose("join", {"id", "order", "time", "stops"});
  }
  const size_t zero = tables.find('\0');
  const MemoryFile points(tables.substr(0, zero));
  const ImportedReadings readings =
      zero == std::string::npos
          ? import_readings(points.path(), options)
          : import_readings(points.path(), MemoryFile(tables.substr(zero + 1)).path(), options);
  // What is imported can be read.
  read_campaign(MemoryFile(write_campaign(readings.campaign)).path());
}

constexpr Target kTargets[] = {
    {"campaign", read_campaign_file},
    {"path", read_path_file},
    {"joint-targets", read_joint_target_file},
    {"targets", read_target_file},
    {"robot", read_robot_document},
    {"catalogue", read_catalogue_document},
    {"findings", read_findings_document},
    {"about", read_about_document},
    {"certificate", read_certificate_document},
    {"urdf", read_urdf_document},
    {"ur-calibration", read_ur_calibration_document},
    {"import", read_exported_table},
};

}  // namespace

std::span<const Target> data_file_targets() { return kTargets; }

}  // namespace armtrue::fuzz
