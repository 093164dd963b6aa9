#include "armtrue/programs/robot_program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/text/input_error.h"
#include "kinematics/six_axes.h"

namespace armtrue::robot_program_test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct CorpusFile {
  std::string name;  // krl/axes.src
  const Dialect* dialect = nullptr;
  std::vector<ProgramText> texts;
};

// Every program of tests/programs/targets.
std::vector<CorpusFile> corpus() {
  namespace fs = std::filesystem;
  const fs::path folder(ARMTRUE_TESTS "/programs/targets");
  std::vector<CorpusFile> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const auto dialect = dialect_of_file(entry.path().string());
    if (!entry.is_regular_file() || !dialect) continue;
    CorpusFile file{fs::relative(entry.path(), folder).string(), dialect, {}};
    file.texts.push_back({entry.path().filename().string(), read_text(entry.path())});
    const fs::path dat = fs::path(entry.path()).replace_extension(".dat");
    if (!dialect->facts().data_list.empty() && fs::exists(dat))
      file.texts.push_back({dat.filename().string(), read_text(dat)});
    files.push_back(file);
  }
  std::ranges::sort(files, {}, &CorpusFile::name);
  return files;
}

ProgramCommand command_for(const ProgramTarget& target) {
  ProgramCommand command;
  command.is_corrected = true;
  command.q = command.programmed = target.q;
  command.pose = target.pose;
  return command;
}

// The numerical noise of an inverse kinematics changes no byte.
std::vector<ProgramCommand> commands_without_correction(const RobotProgram& program) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(-1e-10, 1e-10);
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : program.targets) {
    ProgramCommand command = command_for(target);
    for (int j = 0; j < kJoints; ++j) command.q[j] += noise(random);
    for (int i = 0; i < 3; ++i) command.pose.translation[i] += noise(random);
    command.pose.rotation *= rotation_exp({noise(random), noise(random), noise(random)});
    commands.push_back(command);
  }
  return commands;
}

// Some tenths of a millimetre and of a milliradian, the same for all targets of a point.
std::vector<ProgramCommand> commands_with_correction(const RobotProgram& program) {
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : program.targets) {
    std::mt19937 random(static_cast<unsigned>(target.point));
    std::uniform_real_distribution<double> change(-5e-4, 5e-4);
    ProgramCommand command = command_for(target);
    for (int j = 0; j < kJoints; ++j) command.q[j] += change(random);
    for (int i = 0; i < 3; ++i) command.pose.translation[i] += change(random);
    command.pose.rotation *= rotation_exp({change(random), change(random), change(random)});
    commands.push_back(command);
  }
  return commands;
}

RobotProgram with_texts(const RobotProgram& program, const std::vector<std::string>& texts) {
  std::vector<ProgramText> named = program.texts;
  for (size_t i = 0; i < texts.size(); ++i) named[i].text = texts[i];
  return parse_program(*program.dialect, named, {});
}

// [m], [rad]
double rounding_of(const Dialect* dialect, bool is_angle) {
  static const std::map<std::string, std::pair<double, double>> kRounding{
      {"krl", {1e-7, 1e-4 * kDegree}},   {"rapid", {1e-7, 4e-7}},
      {"fanuc", {1e-6, 1e-3 * kDegree}}, {"urscript", {1e-7, 1e-7}},
      {"polyscope", {1e-7, 1e-7}},       {"inform", {1e-6, 1e-4 * kDegree}}};
  const auto& [length, angle] = kRounding.at(dialect->facts().name);
  return is_angle ? angle : length;
}

RobotProgram parsed(const std::string& name, const std::string& text, const std::string& dat = "") {
  std::vector<ProgramText> texts{{name, text}};
  if (!dat.empty()) texts.push_back({"p.dat", dat});
  return parse_program(*dialect_of_file(name), texts, {});
}

TEST(RobotProgramTest, ACorpusOfFifteenProgramsForEachDialectIsRead) {
  std::map<const Dialect*, int> count;
  for (const CorpusFile& file : corpus()) ++count[file.dialect];
  for (const Dialect* dialect : dialects()) EXPECT_GE(count[dialect], 15) << dialect->facts().name;
}

// Counted by hand in the files: targets (auxiliary points of circles too), moves that cannot be
// followed.
TEST(RobotProgramTest, TargetsAreFoundAndWhatCannotBeFollowedIsCounted) {
  std::ifstream table(ARMTRUE_TESTS "/programs/targets/expected.txt");
  std::map<std::string, std::pair<size_t, int>> expected;
  for (std::string name; table >> name;) table >> expected[name].first >> expected[name].second;
  for (const CorpusFile& file : corpus()) {
    const RobotProgram program = parse_program(*file.dialect, file.texts, {});
    ASSERT_TRUE(expected.contains(file.name)) << file.name;
    EXPECT_EQ(program.targets.size(), expected[file.name].first) << file.name;
    EXPECT_EQ(program.left_alone, expected[file.name].second) << file.name;
    EXPECT_TRUE(program.left_alone == 0 || !program.warnings.empty()) << file.name;
  }
}

// Without its head a text is a list of moves, which has no end either.
TEST(RobotProgramTest, ATextThatIsCutOffIsRefused) {
  for (const CorpusFile& file : corpus()) {
    if (file.name == "krl/spaces.src") continue;  // its last line is no END
    EXPECT_NO_THROW(refuse_cut_off(*file.dialect, file.texts)) << file.name;
    if (file.name == "urscript/unwrapped.script") continue;
    for (size_t i = 0; i < file.texts.size(); ++i) {
      const std::string& text = file.texts[i].text;
      for (size_t tenths = 5; tenths < 10; ++tenths)
        EXPECT_THROW(
            refuse_cut_off(*file.dialect, {{"p", text.substr(0, text.size() * tenths / 10)}}),
            InputError)
            << file.name << " text " << i << ", tenths: " << tenths;
    }
  }
}

TEST(RobotProgramTest, WhatIsCutOffIsNamedWithItsLine) {
  const std::vector<ProgramText> texts{
      {"p.src",
       "&ACCESS RV\r\nGLOBAL DEF part()\r\nLIN {X 800,Y 0,Z 900,A 0,B 80,C 0}\r\nLIN {X 8"}};
  try {
    refuse_cut_off(*find_dialect("krl"), texts);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("p.src:2: what begins with 'GLOBAL DEF part()' has no END:"));
  }
}

TEST(RobotProgramTest, LinesThatEndWithCrAloneAreRefused) {
  for (const char* const name : {"krl", "urscript"}) try {
      refuse_cut_off(*find_dialect(name), {{"p", "DEF p()\rLIN {X 8}\rEND\r"}});
      FAIL() << name;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("p: its lines end with CR alone; save it with LF"));
    }
}

TEST(RobotProgramTest, WithoutCorrectionEveryByteIsKept) {
  for (const CorpusFile& file : corpus()) {
    const RobotProgram program = parse_program(*file.dialect, file.texts, {});
    const RewrittenProgram same = rewrite(program, commands_without_correction(program));
    EXPECT_EQ(same.changed, 0) << file.name;
    for (size_t i = 0; i < file.texts.size(); ++i)
      EXPECT_EQ(same.texts[i], file.texts[i].text) << file.name;
  }
}

TEST(RobotProgramTest, TheRewrittenProgramReadsAsTheCommands) {
  for (const CorpusFile& file : corpus()) {
    const RobotProgram program = parse_program(*file.dialect, file.texts, {});
    const std::vector<ProgramCommand> commands = commands_with_correction(program);
    const RewrittenProgram moved = rewrite(program, commands);
    EXPECT_GT(moved.changed, 0) << file.name;
    EXPECT_THAT(moved.warnings, IsEmpty()) << file.name;
    const RobotProgram again = with_texts(program, moved.texts);
    ASSERT_EQ(again.targets.size(), program.targets.size()) << file.name;
    const double length = rounding_of(file.dialect, false), angle = rounding_of(file.dialect, true);
    for (size_t k = 0; k < commands.size(); ++k) {
      const ProgramTarget& target = again.targets[k];
      const std::string where = file.name + " target " + std::to_string(k + 1);
      if (target.kind == TargetKind::joints) {
        EXPECT_LT((target.q - commands[k].q).cwiseAbs().maxCoeff(), 2 * angle) << where;
        continue;
      }
      EXPECT_LT((target.pose.translation - commands[k].pose.translation).norm(), length) << where;
      // The orientation of an auxiliary point may be left out.
      const bool is_stated =
          again.points[static_cast<size_t>(target.point)].numbers[3].is_written();
      if (is_stated || file.dialect != find_dialect("krl")) {
        EXPECT_LT(rotation_log(target.pose.rotation * commands[k].pose.rotation.transpose()).norm(),
                  2 * angle)
            << where;
      }
    }
  }
}

// Without the numbers of the points both texts are the same.
TEST(RobotProgramTest, OnlyNumbersChange) {
  for (const CorpusFile& file : corpus()) {
    const RobotProgram program = parse_program(*file.dialect, file.texts, {});
    const RewrittenProgram moved = rewrite(program, commands_with_correction(program));
    const RobotProgram again = with_texts(program, moved.texts);
    const auto without_numbers = [](const RobotProgram& of, size_t text) {
      std::string result = of.texts[text].text;
      std::vector<std::pair<size_t, size_t>> places;
      for (const ProgramPoint& point : of.points)
        for (const auto* numbers : {&point.numbers, &point.configuration})
          for (const ProgramNumber& number : *numbers)
            if (number.text == static_cast<int>(text) && number.is_written())
              places.emplace_back(number.begin, number.end);
      std::ranges::sort(places, std::greater<>());
      for (const auto& [begin, end] : places) result.replace(begin, end - begin, 1, '#');
      return result;
    };
    if (file.name == "krl/inherited.src" || file.name == "krl/circles.src" ||
        file.name == "krl/splines.src" || file.name == "krl/named.src")
      continue;  // these leave coordinates out, which are added
    if (std::ranges::any_of(program.points, &ProgramPoint::is_shared)) continue;
    // A displaced point is written out.
    if (std::ranges::any_of(program.points, &ProgramPoint::is_expression)) continue;
    for (size_t i = 0; i < program.texts.size(); ++i)
      EXPECT_EQ(without_numbers(again, i), without_numbers(program, i)) << file.name;
  }
}

TEST(RobotProgramTest, CoordinatesThatAreLeftOutAreAddedOnlyWhereThePointBeforeChanges) {
  const RobotProgram program = parsed(
      "p.src", "LIN {X 800,Y 0,Z 900,A 0,B 80,C 0}\nLIN {Z 950}\nLIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\n");
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : program.targets) commands.push_back(command_for(target));
  commands[0].pose.translation.x() += 1e-3;
  EXPECT_EQ(rewrite(program, commands).texts[0],
            "LIN {X 801,Y 0,Z 900,A 0,B 80,C 0}\nLIN {Z 950,X 800}\n"
            "LIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\n");
  commands[0] = command_for(program.targets[0]);
  commands[1].pose.translation.x() += 1e-3;
  EXPECT_EQ(rewrite(program, commands).texts[0],
            "LIN {X 800,Y 0,Z 900,A 0,B 80,C 0}\nLIN {Z 950,X 801}\n"
            "LIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\n");
}

TEST(RobotProgramTest, MovesThatNeedDifferentCorrectionsOfAPointGetPointsOfTheirOwn) {
  const std::string text = "P1={X 800,Y 0,Z 900,A 0,B 80,C 0}\nLIN P1\nPTP P1\n";
  const RobotProgram program = parsed("p.src", text);
  std::vector<ProgramCommand> commands{command_for(program.targets[0]),
                                       command_for(program.targets[1])};
  for (ProgramCommand& command : commands) command.pose.translation.x() += 1e-3;
  commands[1].pose.translation.x() += 4e-8;  // one step of rounding
  EXPECT_THAT(rewrite(program, commands).texts[0], HasSubstr("{X 801,"));
  commands[1].pose.translation.x() += 4e-7;
  EXPECT_EQ(rewrite(program, commands).texts[0],
            "P1={X 800,Y 0,Z 900,A 0,B 80,C 0}\nLIN {X 801,Y 0,Z 900,A 0,B 80,C 0}\n"
            "PTP {X 801.0004,Y 0,Z 900,A 0,B 80,C 0}\n");
  // One of them is left as programmed.
  commands[0].is_corrected = false;
  EXPECT_EQ(rewrite(program, commands).texts[0],
            "P1={X 800,Y 0,Z 900,A 0,B 80,C 0}\nLIN P1\n"
            "PTP {X 801.0004,Y 0,Z 900,A 0,B 80,C 0}\n");
}

TEST(RobotProgramTest, PointsOfTheirOwnAreWrittenAsEachControllerDoes) {
  const auto second_by_a_millimetre = [](const RobotProgram& program) {
    std::vector<ProgramCommand> commands;
    for (const ProgramTarget& target : program.targets) commands.push_back(command_for(target));
    commands[1].pose.translation.x() += 1e-3;
    const RewrittenProgram rewritten = rewrite(program, commands);
    EXPECT_EQ(rewritten.changed, 1);
    EXPECT_THAT(rewritten.warnings, IsEmpty());
    return rewritten.texts[0];
  };
  const std::string declared =
      "CONST robtarget p1:=[[1,2,3], ! a corner\n "
      "[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n";
  EXPECT_EQ(second_by_a_millimetre(
                parsed("p.mod", declared + "MoveL p1,v1,fine,tool0;\nMoveL p1,v1,fine,tool0;\n")),
            declared +
                "MoveL p1,v1,fine,tool0;\nMoveL [[2,2,3],             [1,0,0,0],[0,0,0,0],"
                "[9E9,9E9,9E9,9E9,9E9,9E9]],v1,fine,tool0;\n");
  EXPECT_EQ(
      second_by_a_millimetre(parsed(
          "p.script", "a = p[0.1,0,0.2,0,0,0]\nmovej(a)\nmovel(pose_trans(p[0,0,0,0,0,0], a))\n")),
      "a = p[0.1,0,0.2,0,0,0]\nmovej(a)\nmovel(pose_trans(p[0,0,0,0,0,0], "
      "p[0.101,0,0.2,0,0,0]))\n");
  const std::string values =
      "{\n GP1:\n UF : 0, UT : 0, CONFIG : 'N U T, 0, 0, 0',\n X = 1.000 mm, Y = 0.0 mm, Z = 0.0 "
      "mm,\n"
      " W = 0.0 deg, P = 0.0 deg, R = 0.0 deg\n};\n";
  const std::string moves = "/PROG P\n/ATTR\nLINE_COUNT = 2;\n/MN\n 1:J P[1:a] 9% FINE ;\n 2:L ";
  std::string moved = values;
  moved.replace(moved.find("1.000"), 5, "2.000");
  EXPECT_EQ(
      second_by_a_millimetre(
          parsed("p.ls", moves + "P[1:a] 9mm/sec FINE ;\n/POS\nP[1:\"a\"]" + values + "/END\n")),
      moves + "P[2:a] 9mm/sec FINE ;\n/POS\nP[1:\"a\"]" + values + "P[2:\"a\"]" + moved + "/END\n");
  // Moves that need the same position share it.
  const std::string named = moves + "P[1:a] 9mm/sec FINE ;\n 3:L P[1:a] 9mm/sec FINE ;\n";
  const RobotProgram three = parsed("p.ls", named + "/POS\nP[1:\"a\"]" + values + "/END\n");
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : three.targets) commands.push_back(command_for(target));
  for (const size_t k : {1, 2}) commands[k].pose.translation.x() += 1e-3;
  EXPECT_EQ(rewrite(three, commands).texts[0],
            moves + "P[2:a] 9mm/sec FINE ;\n 3:L P[2:a] 9mm/sec FINE ;\n/POS\nP[1:\"a\"]" + values +
                "P[2:\"a\"]" + moved + "/END\n");
}

TEST(RobotProgramTest, ExternalAxesFollowTheCommandsAndAreAddedWhereTheyAreLeftOut) {
  const std::string frame = "LIN {X 800,Y 0,Z 900,A 0,B 80,C 0";
  const RobotProgram program =
      parsed("p.src", "PTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0,E1 50}\n" + frame +
                          ",E1 100.0,E2 5}\n" + frame + "}\n" + frame + "}\n");
  ASSERT_EQ(program.targets.size(), 4u);
  EXPECT_EQ(program.targets[0].external[0], 50);
  EXPECT_EQ(program.targets[3].external[1], 5);
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : program.targets) {
    commands.push_back(command_for(target));
    commands.back().external = target.external;
  }
  EXPECT_EQ(rewrite(program, commands).changed, 0);
  commands[0].external[0] = 50.25;
  commands[1].external[0] = 100.5;
  EXPECT_EQ(rewrite(program, commands).texts[0],
            "PTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0,E1 50.25}\n" + frame + ",E1 100.5,E2 5}\n" +
                frame + ",E1 100}\n" + frame + "}\n");
  // Those of an auxiliary point count for nothing.
  const RobotProgram arc =
      parsed("p.src", frame + ",E1 100}\nCIRC {X 810,Y 10,Z 900,E1 7},{X 820,Y 0}\n");
  EXPECT_EQ(arc.targets[2].external[0], 100);
  EXPECT_EQ(rewrite(arc, commands_without_correction(arc)).texts[0], arc.texts[0].text);
}

TEST(RobotProgramTest, KukaTurnFollowsTheJointsAndStatusIsKept) {
  const RobotProgram program =
      parsed("p.src", "PTP {X 800,Y 0,Z 900,A 0,B 80,C 0,S 18,T 'B1000010'}\n");
  ProgramCommand command = command_for(program.targets[0]);
  command.programmed << 1e-5, -1, 1, 1, 1, 1;
  command.q << -1e-5, -1, 1, 1, 1, 1;
  command.pose.translation.x() += 1e-3;
  EXPECT_EQ(rewrite(program, {command}).texts[0], "PTP {X 801,Y 0,Z 900,A 0,B 80,C 0,S 18,T 67}\n");
}

// The solver finds a joint that is programmed at zero on either side of it.
TEST(RobotProgramTest, KukaTurnAndStatusOfAJointAtZeroAreThoseOfTheCommand) {
  const auto rewritten = [](const std::string& stated, double before, double now, int joint) {
    const RobotProgram program =
        parsed("p.src", "PTP {X 800,Y 0,Z 900,A 0,B 80,C 0," + stated + "}\n");
    ProgramCommand command = command_for(program.targets[0]);
    command.programmed << 1, -1, 1, 1, 1, 1;
    command.q = command.programmed;
    command.programmed[joint] = before * kDegree;
    command.q[joint] = now * kDegree;
    command.pose.translation.x() += 1e-3;
    const std::string text = rewrite(program, {command}).texts[0];
    const size_t at = text.find("C 0,") + 4;
    return text.substr(at, text.find('}') - at);
  };
  for (const double before : {-3e-5, 0.0, 3e-5}) {
    EXPECT_EQ(rewritten("S 2,T 2", before, 0.05, 3), "S 2,T 2");
    EXPECT_EQ(rewritten("S 2,T 2", before, -0.05, 3), "S 2,T 10");
    EXPECT_EQ(rewritten("S 2,T 10", before, 0.05, 3), "S 2,T 2");
    EXPECT_EQ(rewritten("S 2,T 10", before, -0.05, 3), "S 2,T 10");
    // No farther beyond zero than as programmed.
    EXPECT_EQ(rewritten("S 2,T 2", before, -3e-5, 3), before < 0 ? "S 2,T 2" : "S 2,T 10");
    EXPECT_EQ(rewritten("S 2,T 2", before, -0.05, 4), "S 6,T 18");
    EXPECT_EQ(rewritten("S 6", before, 0.05, 4), "S 2");
  }
  // A bit that contradicts the joint stays.
  EXPECT_EQ(rewritten("S 2,T 10", 0.1, 0.2, 3), "S 2,T 10");
  EXPECT_EQ(rewritten("S 2,T 10", 0.1, -0.1, 3), "S 2,T 10");
}

TEST(RobotProgramTest, AbbQuadrantsFollowTheJoints) {
  const auto rewritten = [](const std::string& stated, const Eigen::Vector3d& before,
                            const Eigen::Vector3d& now) {
    const RobotProgram program = parsed("p.mod", "MoveJ [[600,0,800],[1,0,0,0]," + stated +
                                                     ",[9E9,9E9,9E9,9E9,9E9,9E9]],v1,z1,tool0;");
    ProgramCommand command = command_for(program.targets[0]);
    command.programmed << before[0], -1, 1, before[1], 1, before[2];
    command.q << now[0], -1, 1, now[1], 1, now[2];
    command.programmed *= kDegree;
    command.q *= kDegree;
    command.pose.translation.x() += 1e-3;
    const std::string text = rewrite(program, {command}).texts[0];
    const size_t at = text.find("0],[", text.find("0],[") + 1) + 3;
    return text.substr(at, text.find(']', at) + 1 - at);
  };
  EXPECT_EQ(rewritten("[0,-1,0,4]", {1e-3, -1e-3, 89.999}, {-1e-3, 1e-3, 90.001}), "[-1,0,1,4]");
  // On a boundary the solver finds either quadrant.
  for (const double noise : {-1e-5, 0.0, 1e-5}) {
    EXPECT_EQ(rewritten("[0,0,0,0]", {noise, noise, 90 + noise}, {1, 0.1, 89}), "[0,0,0,0]");
    EXPECT_EQ(rewritten("[0,0,1,0]", {noise, noise, 90 + noise}, {-1, -0.1, 89}), "[-1,-1,0,0]");
    EXPECT_EQ(rewritten("[-1,0,1,0]", {noise, noise, 90 + noise}, {1, noise, 91}), "[0,0,1,0]");
  }
  // What contradicts the joints stays.
  EXPECT_EQ(rewritten("[1,9E9,0,0]", {10, 10, 10}, {-1, -1, 10}), "[1,9E9,0,0]");
}

// Without group 1 in its mask a program moves a track or a positioner, and the arm stands still.
TEST(RobotProgramTest, AFanucProgramOfOtherGroupsHasNoMoveOfTheArm) {
  const auto program = [](const std::string& groups, const std::string& words = "DEFAULT_GROUP\t") {
    return "/PROG P\n/ATTR\n" + words + "= " + groups +
           ";\n/MN\n1:L P[1] 300mm/sec FINE ;\n/POS\nP[1]{\n GP2:\n UF : 1, UT : 1,\n"
           "J1= 4013.387 mm\n};\n/END\n";
  };
  const auto left_of = [](const std::string& text) {
    try {
      parsed("p.ls", text);
    } catch (const NoTargets& error) {
      return std::make_pair(error.why_left_alone.size(), std::string(error.what()));
    }
    return std::make_pair(size_t{9}, std::string());
  };
  for (const char* const words : {"DEFAULT_GROUP\t", "DEFAULT_GRUP\t"}) {
    const auto [moves, said] = left_of(program("*,1,*,*,*", words));
    EXPECT_EQ(moves, 0u);
    EXPECT_THAT(said, HasSubstr("moves other groups than the arm's"));
  }
  // A point of the arm that is not given is a move of it.
  EXPECT_EQ(left_of(program("1,1,*,*,*")).first, 1u);
  EXPECT_EQ(left_of(program("*,*,*,*,*")).first, 1u);
}

// Words by 211 public programs that are listed in both languages.
TEST(RobotProgramTest, AGermanListingOfFanucIsReadAsAnEnglishOne) {
  const auto text = [](bool is_german) {
    std::string listing =
        "/PROG P\n/ATTR\nLINE_COUNT\t= 9;\n/MN\n 1:  UTOOL_NUM=2 ;\n 2:  UFRAME_NUM=1 ;\n"
        " 3:J P[1] 100% CNT0 ;\n 4:  DO[16]=ON ;\n 5:L P[2] 90mm/sec CNT0 Tool_Offset,PR[2] ;\n"
        " 6:L P[2] 90mm/sec CNT0 Skip,LBL[1] ;\n 7:L P[1] 90mm/sec CNT0 ;\n 8:  END ;\n"
        " 9:L P[1] 90mm/sec CNT0 ;\n/POS\n";
    for (const char* const name : {"P[1]", "P[2]"})
      listing += std::string(name) +
                 "{\n GP1:\n UF : F, UT : F, CONFIG : 'F U B, 0, 0, -1',\n X = 1.000 mm, Y = 0.0 "
                 "mm, Z = 0.0 mm,\n W = 0.0 deg, P = 0.0 deg, R = 0.0 deg\n};\n";
    listing += "/END\n";
    const std::pair<const char*, const char*> words[] = {
        {"LINE_COUNT", "ZEILEN"}, {"UTOOL_NUM", "WKZ_NUM"},       {"UFRAME_NUM", "BENUTZER_NUM"},
        {"CONFIG", "KONFIG"},     {"DO[16]=ON", "A[16]=AN"},      {"Skip,LBL", "Interrupt,LABEL"},
        {"sec", "sek"},           {"Tool_Offset", "WKZ_Offset "}, {"END ;", "ENDE ;"}};
    for (const auto& [english, german] : words)
      for (size_t at = 0; is_german && (at = listing.find(english, at)) != std::string::npos;)
        listing.replace(at, std::string(english).size(), german);
    return listing;
  };
  const KnownFrames frames{{"UF[1]", Pose{}}, {"UT[2]", Pose{}}};
  const auto read = [&](bool is_german) {
    return parse_program(*find_dialect("fanuc"), {{"p.ls", text(is_german)}}, frames);
  };
  const RobotProgram english = read(false), german = read(true);
  EXPECT_EQ(german.why_left_alone, english.why_left_alone);
  ASSERT_EQ(english.left_alone, 1);  // displaced by a register that is not given
  ASSERT_EQ(german.targets.size(), english.targets.size());
  ASSERT_EQ(german.targets.size(), 4u);
  for (size_t k = 0; k < english.targets.size(); ++k) {
    const ProgramTarget &a = german.targets[k], &b = english.targets[k];
    EXPECT_EQ(a.configuration.sides, b.configuration.sides);
    EXPECT_EQ(a.configuration.low, b.configuration.low);
    EXPECT_EQ(a.follows_target, b.follows_target);
    EXPECT_EQ(a.never_runs, b.never_runs);
    EXPECT_EQ(german.frames[a.tool].name, english.frames[b.tool].name);
  }
  std::string marked = text(true);
  mark_corrected(*find_dialect("fanuc"), Corrector::compensate, marked);
  EXPECT_THAT(marked, HasSubstr("ZEILEN\t= 10;"));
  // An option with a register that no manual here names; the register where a skip keeps a place.
  for (const auto& [option, left] :
       {std::pair("Versatz,PR[1]", 1), {"Skip,LBL[1],PR[1]=LPOS", 0}}) {
    std::string listing = text(false);
    listing.replace(listing.find("Tool_Offset,PR[2]"), 17, option);
    EXPECT_EQ(parse_program(*find_dialect("fanuc"), {{"p.ls", listing}}, frames).left_alone, left);
  }
}

TEST(RobotProgramTest, FanucJointThreeIsRelativeToTheHorizontal) {
  const RobotProgram program =
      parsed("p.ls",
             "/PROG P\n/MN\n1:J P[1] 100% FINE ;\n/POS\nP[1]{\n GP1:\n UF : 0, UT : 0,\n"
             "J1= 0 deg,J2= 20 deg,J3= -50 deg,J4= 0 deg,J5= -90 deg,J6= 0 deg\n};\n/END\n");
  ASSERT_EQ(program.targets.size(), 1u);
  EXPECT_NEAR(program.targets[0].q[2], -30 * kDegree, 1e-12);
  ProgramCommand command = command_for(program.targets[0]);
  command.q[1] += 0.5 * kDegree;
  EXPECT_THAT(rewrite(program, {command}).texts[0], HasSubstr("J2= 20.5 deg,J3= -50.5 deg,J4= 0 "));
}

TEST(RobotProgramTest, AQuoteInACommentHidesNoMove) {
  const RobotProgram program =
      parsed("p.ls",
             "/PROG P\n/MN\n1:  !don't ;\n2:J P[1] 100% FINE ;\n/POS\nP[1]{\n GP1:\n UF : 0, "
             "UT : 0,\nJ1= 0 deg,J2= 0 deg,J3= 0 deg,J4= 0 deg,J5= -90 deg,J6= 0 deg\n};\n/END\n");
  EXPECT_EQ(program.targets.size(), 1u);
  EXPECT_EQ(program.targets[0].line, 4);
}

TEST(RobotProgramTest, APointThatOnlyAnotherRoutineUsesIsNotPassedInSilence) {
  const RobotProgram program =
      parsed("p.mod",
             "CONST robtarget p1:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
             "CONST robtarget p2:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
             "MoveL p1,v1,fine,tool0;\nGlue p2,v1;\n");
  EXPECT_EQ(program.left_alone, 1);
  EXPECT_THAT(program.warnings, ElementsAre(AllOf(HasSubstr("p.mod:4"), HasSubstr("P2"))));
}

TEST(RobotProgramTest, BehindAMoveThatIsLeftAloneAStraightMoveTakesItsOwnStatus) {
  const RobotProgram program = parsed("p.src",
                                      "LIN {X 1,Y 2,Z 3,A 0,B 80,C 0,S 2,T 10}\n"
                                      "LIN {X 1,Y 2,Z 3,A 0,B 80,C 0,S 2,T 10}\nPTP XHOME\n"
                                      "LIN {X 1,Y 2,Z 3,A 0,B 80,C 0,S 2,T 10}\n");
  EXPECT_TRUE(program.targets[1].configuration.continues);
  EXPECT_FALSE(program.targets[2].configuration.continues);
}

TEST(RobotProgramTest, FramesAndToolsHoldFromTheirLineOn) {
  const RobotProgram program =
      parsed("p.src", read_text(ARMTRUE_TESTS "/programs/targets/krl/base_and_tool.src"));
  const auto name = [&](int index) {
    return index < 0 ? "" : program.frames[static_cast<size_t>(index)].name;
  };
  ASSERT_EQ(program.targets.size(), 4u);
  EXPECT_EQ(name(program.targets[0].base), "{X1500.0,Y0.0,Z600.0,A90.0,B0.0,C0.0}");
  EXPECT_EQ(name(program.targets[2].base), "BASE_DATA[3]");
  EXPECT_EQ(name(program.targets[2].tool), "TOOL_DATA[2]");
  EXPECT_EQ(name(program.targets[3].tool), "TOOL_DATA[1]");
  EXPECT_TRUE(program.frames[static_cast<size_t>(program.targets[3].base)].is_known);
  EXPECT_FALSE(program.frames[static_cast<size_t>(program.targets[2].base)].is_known);
}

TEST(RobotProgramTest, InlineFormsAndSplinesNameTheirFrames) {
  for (const CorpusFile& file : corpus()) {
    if (file.name != "krl/inline.src") continue;
    const RobotProgram program =
        parse_program(*file.dialect, file.texts, {{"base_data[3]", Pose{}}});
    ASSERT_EQ(program.targets.size(), 3u);
    const auto frame = [&](int index) { return program.frames[static_cast<size_t>(index)]; };
    EXPECT_EQ(frame(program.targets[0].tool).name, "TOOL_DATA[1]");
    EXPECT_TRUE(frame(program.targets[0].base).is_known);
    EXPECT_EQ(frame(program.targets[1].tool).name, "TOOL_DATA[2]");
    EXPECT_EQ(frame(program.targets[2].tool).name, "TOOL_DATA[1]");
    EXPECT_EQ(frame(program.targets[2].base).name, "BASE_DATA[0]");
  }
}

TEST(RobotProgramTest, NamesFollowTheFileWhereTheControllerWantsThat) {
  RobotProgram program = parsed("p.src", "DEF  old( )\nLIN {X 800,Y 0,Z 900,A 0,B 80,C 0}\nEND\n",
                                "DEFDAT OLD PUBLIC\nENDDAT\n");
  std::vector<std::string> texts{program.texts[0].text, program.texts[1].text};
  rename(program, "Old", texts);
  EXPECT_EQ(texts[0], program.texts[0].text);
  rename(program, "fresh", texts);
  EXPECT_THAT(texts[0], HasSubstr("DEF  fresh( )\n"));
  EXPECT_THAT(texts[1], HasSubstr("DEFDAT fresh PUBLIC\n"));
  texts[0] = ";" + program.texts[0].text;
  rename(program, "fresh", texts);
  EXPECT_EQ(texts[0], ";" + program.texts[0].text);
  EXPECT_EQ(why_illegal_name(*find_dialect("krl"), "part_1"), "");
  EXPECT_THAT(why_illegal_name(*find_dialect("krl"), "1-part"), HasSubstr("'P1_part'"));
  EXPECT_THAT(why_illegal_name(*find_dialect("krl"), "a_name_of_twenty_five_abc"),
              HasSubstr("'a_name_of_twenty_five_ab'"));
  EXPECT_EQ(why_illegal_name(*find_dialect("urscript"), "1-part"), "");
}

// The first routine has the name of the file, also if it is a function; the others keep theirs.
TEST(RobotProgramTest, TheNameOfAFunctionFollowsTheFile) {
  RobotProgram program = parsed("p.src",
                                "DEFFCT INT old( )\nLIN {X 800,Y 0,Z 900,A 0,B 80,C 0}\nsub( )\n"
                                "RETURN 1\nENDFCT\nDEF sub( )\nEND\n");
  std::vector<std::string> texts{program.texts[0].text};
  rename(program, "fresh", texts);
  EXPECT_TRUE(texts[0].starts_with("DEFFCT INT fresh( )\nLIN {X 800,")) << texts[0];
  EXPECT_TRUE(texts[0].ends_with("DEF sub( )\nEND\n")) << texts[0];
}

// Behind the last line of the main part, which may span several lines of the file.
TEST(RobotProgramTest, TheMarkOfFanucIsTheNextLineAndIsCounted) {
  const std::string head = "/PROG P\n/ATTR\nLINE_COUNT = ", end = "/POS\n/END\n";
  const std::string lines = ";\n/MN\n  9:J P[1] 9% FINE ;\n 10:C P[2]\n    P[3] 9mm/sec FINE ;\n";
  std::string text = head + "10" + lines + end;
  mark_corrected(*find_dialect("fanuc"), Corrector::compensate, text);
  EXPECT_TRUE(text.starts_with(head + "11" + lines + " 11:  !corrected by armtrue compensate"))
      << text;
  EXPECT_TRUE(text.ends_with(" ;\n" + end)) << text;
}

TEST(RobotProgramTest, BracketsInGreatNumberAreNoNumber) {
  constexpr size_t kMany = 200000;
  EXPECT_THROW(parsed("p.mod",
                      "MODULE p\nCONST robtarget a:=[[600,0,800],[1,0,0,0],[0,0,0,0],"
                      "[9E9,9E9,9E9,9E9,9E9,9E9]];\nPROC main()\nMoveL Offs(a," +
                          std::string(kMany, '(') + "1" + std::string(kMany, ')') +
                          ",0,0),v100,z1,tool0;\nENDPROC\nENDMODULE\n"),
               InputError);
}

TEST(RobotProgramTest, ATextWithoutTargetsIsAnError) {
  EXPECT_THROW(parsed("p.src", "DEF p()\nEND\n"), InputError);
  EXPECT_THROW(parsed("p.mod", ""), InputError);
  EXPECT_THROW(parsed("p.script", "def p():\nend\n"), InputError);
  EXPECT_THROW(parsed("p.ls", "/PROG P\n/MN\n/POS\n/END\n"), InputError);
}

// One point before each straight move that may be divided.
std::vector<ProgramPointBetween> points_between(const RobotProgram& program,
                                                const std::vector<ProgramCommand>& commands) {
  std::vector<ProgramPointBetween> points;
  for (size_t k = 1; k < program.targets.size(); ++k) {
    const ProgramTarget& target = program.targets[k];
    if (target.motion == MotionKind::line && target.follows_target && target.obstacle.empty())
      points.push_back({k, commands[k].pose, commands[k].q, 1e-3});
  }
  return points;
}

// Another number of damaged programs, for a run by hand.
int damaged_programs() {
  const char* const count = std::getenv("ARMTRUE_DAMAGED_PROGRAMS");
  return count ? std::atoi(count) : 12000;
}

// Damaged programs are read or refused; what is read comes back byte for byte.
TEST(RobotProgramTest, DamagedProgramsNeverCrash) {
  std::mt19937 random(7);
  const auto below = [&](size_t limit) { return limit ? random() % limit : 0; };
  const std::vector<std::string> words{"{",       "}",
                                       "[",       "]",
                                       "(",       ")",
                                       ",",       ";",
                                       "\"",      "'",
                                       "!",       "#",
                                       ":=",      "=",
                                       "\n",      "\r",
                                       "-",       "1e999",
                                       "nan",     "P[1]",
                                       "p[",      "MoveL ",
                                       "LIN ",    "CONST robtarget p1:=[[",
                                       "$BASE={", "/POS",
                                       "GP1:",    "S 2,T 'B",
                                       "movel(",  "9E9",
                                       "E1 1",    std::string(1, '\0'),
                                       "\xFC",    "[[[[[[[[[[[[[[[[[[[["};
  const std::vector<CorpusFile> files = corpus();
  int read = 0, inserted = 0;
  for (int round = 0; round < damaged_programs(); ++round) {
    CorpusFile file = files[static_cast<size_t>(round) % files.size()];
    std::string& text = file.texts[below(file.texts.size())].text;
    for (size_t count = 1 + below(6); count > 0; --count) {
      const size_t at = below(text.size() + 1), length = below(30);
      switch (below(6)) {
        case 0:
          text.insert(at, words[below(words.size())]);
          break;
        case 1:
          text.erase(at, length);
          break;
        case 2:
          text.insert(below(text.size() + 1), text.substr(at, length));
          break;
        case 3:
          text.replace(at, length, words[below(words.size())]);
          break;
        case 4:
          if (below(8) == 0) text.resize(at);
          break;
        default:
          if (at < text.size()) text[at] = static_cast<char>(below(256));
      }
    }
    try {
      const RobotProgram program = parse_program(*file.dialect, file.texts, {});
      const RewrittenProgram same = rewrite(program, commands_without_correction(program));
      for (size_t i = 0; i < file.texts.size(); ++i)
        ASSERT_EQ(same.texts[i], file.texts[i].text) << file.name << " round " << round;
      const std::vector<ProgramCommand> commands = commands_with_correction(program);
      const auto between = points_between(program, commands);
      const RewrittenProgram divided = rewrite(program, commands, between);
      inserted += divided.inserted;
      ++read;
    } catch (const InputError&) {
    }
  }
  EXPECT_GT(read, 3000);
  EXPECT_GT(inserted, 1000);
}

}  // namespace
}  // namespace armtrue::robot_program_test
