// Readers of measurements, paths, robots and documents.

#include <algorithm>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/diagnosis/log_check.h"
#include "armtrue/io/archive.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/controller_fields.h"
#include "armtrue/io/joint_target_io.h"
#include "armtrue/io/path_io.h"
#include "armtrue/io/products/certificate_io.h"
#include "armtrue/io/products/comparison_io.h"
#include "armtrue/io/products/compensation_io.h"
#include "armtrue/io/products/ranking_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/chain.h"
#include "armtrue/urdf/ur_calibration_io.h"
#include "armtrue/urdf/ur_conf_io.h"
#include "armtrue/urdf/urdf_io.h"
#include "fuzz/memory_file.h"
#include "fuzz/targets.h"

namespace armtrue::fuzz {
namespace {

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
  // What is written are points, or lengths to anchors; see write_campaign().
  if (campaign.has_touches() || campaign.has_coordinates()) return;
  const auto written_and_read = [&joints](const Campaign& c) {
    return read_campaign(MemoryFile(write_campaign(c, joints)).path(), joints).campaign;
  };
  // Not every number of radians is one of degrees, and orientations are kept as quaternions: both
  // may lose a last digit once.
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
  write_path_like(kept, kept.path.position.array() + 1e-4);
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
  require(write_robot(parse_robot(written, "written.yaml")) == written,
          "a robot does not come back");
}

void read_catalogue_document(const std::string& bytes) { read_catalogue(MemoryFile(bytes).path()); }

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

void read_run_document(const std::string& bytes) {
  compared_run(read_run(MemoryFile(bytes).path()));
}

void read_certificate_document(const std::string& bytes) {
  read_certificate(MemoryFile(bytes).path());
}

// As a calibration moves an arm.
Robot moved(Robot robot) {
  for (Link& link : robot.chain.links) link.r += 1e-4;
  robot.chain.base.translation.x() += 1e-3;
  return robot;
}

// The same arm, its last frame elsewhere on its axis.
Robot with_another_last_frame(Robot robot) {
  constexpr double kWay = 0.1;
  const int last = link_of_joint(robot.chain, joint_count(robot.chain) - 1);
  robot.chain.links[static_cast<size_t>(last)].r += kWay;
  robot.chain.tool.translation.z() -= kWay;
  return robot;
}

// What stands behind a zero byte: the links at both ends of the arm, and frames that are kept.
std::pair<UrdfEnds, UrdfKept> ends_named_in(const std::string& bytes) {
  UrdfEnds ends;
  UrdfKept kept;
  std::istringstream words(bytes.substr(std::min(bytes.find('\0'), bytes.size() - 1) + 1));
  words >> ends.base >> ends.tip;
  for (std::string word; words >> word;) {
    kept.base |= word == "keep-base";
    kept.tool |= word == "keep-tool";
  }
  return {ends, kept};
}

// The arm of the document comes back from a document of our own, and into its own; the robot file
// made of it can be read.
void read_urdf_document(const std::string& bytes) {
  if (bytes.empty()) return;
  const std::string text = bytes.substr(0, bytes.find('\0'));
  const auto [ends, kept] = ends_named_in(bytes);
  frames_beside_base(text, "robot.urdf", ends);
  urdf_joint_of_link(text, "robot.urdf");
  const Robot robot = parse_urdf(text, "robot.urdf", ends);
  lost_in_urdf(robot);
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
  write_into_urdf(robot, text, "robot.urdf", ends, kept);
  parse_robot(write_robot(robot), "robot.yaml");
  write_into_urdf(moved(robot), text, "robot.urdf", ends, {.tool = true});
  write_into_urdf(with_another_last_frame(robot), text, "robot.urdf", ends, kept);
  Robot another = robot;
  another.chain.links.front().r += 1;
  write_into_urdf(another, text, "robot.urdf", ends, kept);
}

void read_ur_calibration_document(const std::string& bytes) {
  is_ur_calibration(bytes);
  const Robot robot = parse_ur_calibration(bytes, "calibration.yaml");
  write_into_ur_calibration(robot, bytes, "calibration.yaml", {});
  write_into_ur_calibration(moved(robot), bytes, "calibration.yaml", {.base = true, .tool = true});
}

void read_ur_conf(const std::string& bytes) {
  static const Robot type = read_robot(ARMTRUE_CONFIG "/robots/ur5e.yaml").robot;
  is_ur_conf(bytes);
  const Robot robot = parse_ur_conf(bytes, "calibration.conf", type, "ur5e.yaml");
  write_into_ur_conf(robot, bytes, "calibration.conf", type, "ur5e.yaml");
}

void read_mastering_file(const std::string& bytes) {
  static const Robot arm = read_robot(ARMTRUE_CONFIG "/robots/kr360.yaml").robot;
  const std::vector<double> counts(6, 1000);
  write_controller_fields(arm, arm.chain, read_mastering(bytes, "machine.dat"), counts);
}

void read_archive(const std::string& bytes) {
  const Archive archive{MemoryFile(bytes).path()};
  const std::string same = archive.with({});
  require(Archive(MemoryFile(same).path()).members().size() == archive.members().size(),
          "an archive does not come back");
}

constexpr Target kDataFiles[] = {
    {"campaign", read_campaign_file},
    {"path", read_path_file},
    {"joint-targets", read_joint_target_file},
    {"targets", read_target_file},
    {"robot", read_robot_document},
    {"catalogue", read_catalogue_document},
    {"findings", read_findings_document},
    {"about", read_about_document},
    {"certificate", read_certificate_document},
    {"run", read_run_document},
    {"urdf", read_urdf_document},
    {"ur-calibration", read_ur_calibration_document},
    {"ur-conf", read_ur_conf},
    {"mastering", read_mastering_file},
    {"archive", read_archive},
};

}  // namespace

std::span<const Target> data_file_targets() { return kDataFiles; }

}  // namespace armtrue::fuzz
