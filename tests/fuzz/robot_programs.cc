// Readers of robot programs. What is read is corrected and written, too: bytes that are no number
// of a corrected point stay as they are.

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/kinematics/pose.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/programs/displacement.h"
#include "armtrue/programs/program_project.h"
#include "armtrue/programs/robot_program.h"
#include "fuzz/targets.h"
#include "programs/division.h"
#include "programs/routine_copies.h"

namespace armtrue::fuzz {
namespace {

auto lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

// Through the points of the programs in tests/programs/krl.
Path path() {
  const std::vector<Eigen::Vector3d> corners{
      {0, 0, -5},  {300, 0, -5}, {350, 50, -5}, {350, 200, -5}, {0, 0, 50}, {0, 0, 0},
      {100, 0, 0}, {110, 20, 0}, {100, 20, 0},  {100, 80, 0},   {0, 0, 0}};
  constexpr Eigen::Index kPerSide = 5;
  const auto sides = static_cast<Eigen::Index>(corners.size()) - 1;
  Path result;
  result.position.resize(3, sides * kPerSide + 1);
  for (Eigen::Index i = 0; i <= sides * kPerSide; ++i) {
    const auto side = static_cast<size_t>(std::min(i / kPerSide, sides - 1));
    const double t = static_cast<double>(i) / kPerSide - static_cast<double>(side);
    result.position.col(i) = 1e-3 * (corners[side] + t * (corners[side + 1] - corners[side]));
  }
  result.time = Eigen::VectorXd::LinSpaced(result.position.cols(), 0, 1);
  return result;
}

// The .src, and behind a zero byte the .dat.
std::vector<ProgramText> texts_of(const std::string& bytes, const char* name, const char* second) {
  const size_t zero = bytes.find('\0');
  std::vector<ProgramText> texts{{name, bytes.substr(0, zero)}};
  if (zero != std::string::npos) texts.push_back({second, bytes.substr(zero + 1)});
  return texts;
}

// Through the points of a program; the fixed one if it has no two.
Path path_of(const RobotProgram& program) {
  std::vector<Eigen::Vector3d> points;
  constexpr int kSteps = 6;
  for (size_t k = 0; k < program.targets.size(); ++k) {
    const ProgramTarget& target = program.targets[k];
    if (target.kind == TargetKind::joints || target.motion == MotionKind::via) continue;
    const Eigen::Vector3d& end = target.pose.translation;
    if (points.empty()) {
      points.push_back(end);
      continue;
    }
    const Eigen::Vector3d start = points.back();
    const auto arc = target.motion == MotionKind::arc && k > 0
                         ? arc_through(start, program.targets[k - 1].pose.translation, end)
                         : std::nullopt;
    for (int i = 1; i <= kSteps; ++i) {
      const double t = static_cast<double>(i) / kSteps;
      points.push_back(arc ? arc->at(t) : Eigen::Vector3d(start + t * (end - start)));
    }
  }
  if (points.size() < 2) return path();
  Path result;
  result.position.resize(3, static_cast<Eigen::Index>(points.size()));
  for (size_t i = 0; i < points.size(); ++i)
    result.position.col(static_cast<Eigen::Index>(i)) = points[i];
  result.time = Eigen::VectorXd::LinSpaced(result.position.cols(), 0, 1);
  return result;
}

// A point that is written into another move stands on one line there.
auto lines_within_points(const RobotProgram& program) {
  auto sum = lines("");
  for (const ProgramPoint& point : program.points)
    sum += lines(program.texts[static_cast<size_t>(point.text)].text.substr(
        point.begin, point.end - point.begin));
  return sum;
}

// Elsewhere than in the moves, and new ones on lines of their own.
bool declares_points(const Dialect& dialect) {
  return dialect.facts().name == "fanuc" || dialect.facts().name == "inform";
}
bool is_rapid(const Dialect& dialect) { return dialect.facts().name == "rapid"; }

// As mirror-correct displaces a program along a path.
void displace(const RobotProgram& program, const Path& programmed) {
  const DisplacedProgram same = displace_program(program, programmed, programmed.position);
  for (size_t i = 0; i < program.texts.size(); ++i)
    require(same.text.texts[i] == text_without_copies(program, i),
            "a text changed without displacement");
  Eigen::Matrix3Xd corrected = programmed.position;
  for (Eigen::Index i = 0; i < corrected.cols(); ++i)
    corrected(i % 3, i) += 1e-4 * std::sin(static_cast<double>(i));
  const DisplacedProgram moved = displace_program(program, programmed, corrected);
  require(is_rapid(*program.dialect) ||
              lines(moved.text.texts[0]) + lines_within_points(program) >=
                  lines(text_without_copies(program, 0)) + moved.text.inserted,
          "lines are lost");
}

// One in each move that can be divided.
std::vector<ProgramPointBetween> points_between(const RobotProgram& program,
                                                const std::vector<ProgramCommand>& commands) {
  std::vector<ProgramPointBetween> between;
  const auto add = [&](size_t target, MotionKind motion) {
    between.push_back({target, commands[target].pose, commands[target].q, 1e-3, motion});
  };
  for (size_t k = 1; k < program.targets.size(); ++k) {
    const ProgramTarget& target = program.targets[k];
    if (!target.obstacle.empty() || target.kind == TargetKind::joints) continue;
    if (target.motion == MotionKind::line) add(k, MotionKind::line);
    if (k < 2 || program.targets[k - 1].motion != MotionKind::via) continue;
    add(k - 1, MotionKind::via);
    add(k, MotionKind::arc);
    add(k - 1, MotionKind::via);
  }
  return between;
}

// What file names and options say, here by the first line of a program.
void read_names(const Dialect& dialect, const std::string& text) {
  const std::string line = text.substr(0, text.find('\n'));
  find_dialect(line);
  dialect_of_file(line);
  why_illegal_name(dialect, line);
}

// Of a program that another one of its project calls, and that calls this one.
ProgramNeighbours neighbours_of(const Dialect& dialect, std::vector<ProgramText> project,
                                const KnownFrames& known) {
  const std::string name = project.front().name, text = project.front().text;
  const size_t routine = text.find("DEF ") + 4;
  const std::string called = text.substr(std::min(routine, text.size()), text.find('(') - routine);
  project.push_back({"other.src", "DEF other( )\n$BASE=BASE_DATA[1]\n" + called +
                                      "( )\nEND\nGLOBAL DEF sub( )\n$TOOL=TOOL_DATA[1]\n" + called +
                                      "( )\nEND\n"});
  return neighbours_in(dialect, project, known)[name];
}

// As compensate corrects the points of a program.
void correct(const Dialect& dialect, std::vector<ProgramText> texts) {
  read_names(dialect, texts.front().text);
  static const KnownFrames known{{"BASE_DATA[1]", {}}, {"TOOL_DATA[1]", {}}, {"wobj1", {}},
                                 {"tool1", {}},        {"UF[1]", {}},        {"UT[1]", {}},
                                 {"USER[1]", {}},      {"TOOL[0]", {}}};
  const RobotProgram program = parse_program(dialect, texts, known, TargetParts::pose, {},
                                             neighbours_of(dialect, texts, known));
  std::vector<ProgramCommand> commands(program.targets.size());
  RewrittenProgram same = rewrite(program, commands);
  for (size_t i = 0; i < texts.size(); ++i)
    require(same.texts[i] == texts[i].text, "a program changed without correction");
  for (size_t k = 0; k < commands.size(); ++k) {
    const ProgramTarget& target = program.targets[k];
    commands[k] = {true, target.q, target.q, target.pose};
    commands[k].q[static_cast<Eigen::Index>(k % kProgramAxes)] += 1e-4;
    commands[k].pose.translation[static_cast<Eigen::Index>(k % 3)] += 1e-4;
    commands[k].pose.rotation *= rotation_exp({0, 1e-4, 0});
  }
  RewrittenProgram moved = rewrite(program, commands);
  for (size_t i = 0; i < texts.size(); ++i) {
    const auto before = lines(texts[i].text), now = lines(moved.texts[i]);
    // A point of its own: of FANUC a new position; of ABB it stands on one line. Routines may have
    // copies.
    require(declares_points(dialect) || !program.copies.empty() ? now >= before
            : is_rapid(dialect)                                 ? now <= before
                                                                : now == before,
            "lines are lost");
  }
  rename(program, "OTHER_NAME", moved.texts);
  const std::vector<ProgramPointBetween> between = points_between(program, commands);
  const RewrittenProgram divided = rewrite(program, commands, between);
  require(divided.inserted <= moves_of(between), "moves appear");
  require(is_rapid(dialect) || lines(divided.texts[0]) + lines_within_points(program) >=
                                   lines(texts[0].text) + divided.inserted,
          "lines are lost");
  const bool has_poses = std::ranges::any_of(program.targets, [](const ProgramTarget& target) {
    return target.kind == TargetKind::cartesian;
  });
  if (has_poses) displace(program, path_of(program));
}

void displace_krl_program(const std::string& bytes) {
  static const Path programmed = path();
  displace(parse_program(*find_dialect("krl"), texts_of(bytes, "p.src", "p.dat"), {},
                         TargetParts::position),
           programmed);
}
void correct_krl_program(const std::string& bytes) {
  correct(*find_dialect("krl"), texts_of(bytes, "p.src", "p.dat"));
}
void correct_rapid_program(const std::string& bytes) {
  correct(*find_dialect("rapid"), {{"p.mod", bytes}});
}
void correct_fanuc_program(const std::string& bytes) {
  correct(*find_dialect("fanuc"), {{"P.LS", bytes}});
}
void correct_urscript_program(const std::string& bytes) {
  correct(*find_dialect("urscript"), {{"p.script", bytes}});
}
void correct_inform_program(const std::string& bytes) {
  correct(*find_dialect("inform"), {{"P.JBI", bytes}});
}

constexpr Target kRobotPrograms[] = {
    {"krl-path", displace_krl_program},     {"krl", correct_krl_program},
    {"rapid", correct_rapid_program},       {"fanuc", correct_fanuc_program},
    {"urscript", correct_urscript_program}, {"inform", correct_inform_program},
};

}  // namespace

std::span<const Target> robot_program_targets() { return kRobotPrograms; }

}  // namespace armtrue::fuzz
