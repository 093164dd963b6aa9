#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/programs/program_project.h"
#include "armtrue/programs/robot_program.h"
#include "armtrue/text/input_error.h"

// Jobs of Yaskawa.

namespace armtrue {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const Dialect& inform() { return *find_dialect("inform"); }

const std::string kHeads =
    "///USER 1\r\n///TOOL 0\r\n///POSTYPE USER\r\n///RECTAN\r\n///RCONF 1,0,0,0,0,0\r\n";

// `positions` of //POS with their heads, `instructions` behind NOP.
std::string job(const std::string& positions, const std::string& instructions,
                const std::string& count = "2,0,0,0,0,0") {
  return "/JOB\r\n//NAME PART\r\n//POS\r\n///NPOS " + count + "\r\n" + positions +
         "//INST\r\n///DATE 2024/03/11 09:42\r\n///ATTR SC,RW,RJ\r\n///GROUP1 RB1\r\nNOP\r\n" +
         instructions + "END\r\n";
}

RobotProgram parsed(const std::string& text) {
  return parse_program(inform(), {{"PART.JBI", text}}, {});
}

const std::string kTwo = kHeads +
                         "C00000=10.000,20.000,30.000,180.0000,0.0000,0.0000\r\n"
                         "C00001=110.000,20.000,30.000,180.0000,0.0000,0.0000\r\n";

std::vector<ProgramCommand> commands_of(const RobotProgram& program) {
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : program.targets)
    commands.push_back({true, target.q, target.q, target.pose, {}});
  return commands;
}

// Rx, Ry, Rz turn about fixed axes, one after the other: a vector along z after Rx = 90 deg lies
// along -y, which Rz = 90 deg turns to x.
TEST(Inform, AnglesTurnAboutFixedAxes) {
  const Pose pose = inform().pose_of_numbers({1, 2, 3, 90, 0, 90});
  EXPECT_LT((pose.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((pose.translation - Eigen::Vector3d(1e-3, 2e-3, 3e-3)).norm(), 1e-15);
  EXPECT_THAT(inform().numbers_of_pose(pose, {0, 0, 0, 91, 1, 89}),
              ElementsAre(testing::DoubleNear(1, 1e-9), testing::DoubleNear(2, 1e-9),
                          testing::DoubleNear(3, 1e-9), testing::DoubleNear(90, 1e-9),
                          testing::DoubleNear(0, 1e-9), testing::DoubleNear(90, 1e-9)));
}

TEST(Inform, FramesAndToolsAreThoseOfTheirNumbers) {
  const RobotProgram program =
      parsed(job(kTwo + "///USER 2\r\n///TOOL 5\r\nC00002=1,2,3,4,5,6\r\n///POSTYPE ROBOT\r\n"
                        "C00003=1,2,3,4,5,6\r\n",
                 "MOVJ C00000 VJ=25.00\r\nMOVL C00002 V=10.0\r\nMOVL C00003 V=10.0\r\n"));
  ASSERT_THAT(program.targets, SizeIs(3));
  const auto name = [&](int frame) { return frame < 0 ? "" : program.frames[frame].name; };
  EXPECT_EQ(name(program.targets[0].base), "USER[1]");
  EXPECT_EQ(name(program.targets[0].tool), "TOOL[0]");
  EXPECT_EQ(name(program.targets[1].base), "USER[2]");
  EXPECT_EQ(name(program.targets[1].tool), "TOOL[5]");
  EXPECT_EQ(name(program.targets[2].base), "");  // --base
  EXPECT_EQ(name(program.targets[2].tool), "TOOL[5]");
}

// A position that two moves need otherwise: the second one gets another, with the lines that it
// needs behind positions of other kinds, and these hold again behind it.
TEST(Inform, AMoveGetsAPositionOfItsOwnWithItsHeads) {
  const std::string pulses = "///TOOL 1\r\n///POSTYPE PULSE\r\n///PULSE\r\nC00002=1,2,3,4,5,6\r\n",
                    variable = "BC00002=7\r\n",
                    moves = "MOVJ C00002 VJ=1.00\r\nMOVL C00001 V=10.0\r\nMOVL C00001 V=10.0\r\n";
  const RobotProgram program = parsed(job(kTwo + pulses + variable, moves, "3,1,0,0,0,0"));
  std::vector<ProgramCommand> commands = commands_of(program);
  ASSERT_THAT(commands, SizeIs(2));
  commands[1].pose.translation.x() += 1e-3;
  const RewrittenProgram rewritten = rewrite(program, commands);
  EXPECT_EQ(
      rewritten.texts[0],
      job(kTwo + pulses +
              "///TOOL 0\r\n///POSTYPE USER\r\n///RECTAN\r\n"
              "///RCONF 1,0,0,0,0,0\r\n"
              "C00003=111.000,20.000,30.000,180.0000,0.0000,0.0000\r\n"
              "///TOOL 1\r\n///POSTYPE PULSE\r\n///PULSE\r\n"
              "///RCONF 1,0,0,0,0,0\r\n" +
              variable,
          "MOVJ C00002 VJ=1.00\r\nMOVL C00001 V=10.0\r\nMOVL C00003 V=10.0\r\n", "4,1,0,0,0,0"));
}

TEST(Inform, AnInsertedMoveDoesNotStop) {
  const RobotProgram program =
      parsed(job(kTwo, "MOVJ C00000 VJ=25.00\r\nMOVL C00001 V=100.0 PL=0 ACC=50\r\n"));
  std::vector<ProgramCommand> commands = commands_of(program);
  ProgramPointBetween between{1, commands[1].pose, {}, 0, MotionKind::line, {}};
  between.pose.translation.x() = 0.05;
  const RewrittenProgram rewritten = rewrite(program, commands, {between});
  EXPECT_EQ(rewritten.inserted, 1);
  EXPECT_EQ(rewritten.texts[0], job(kTwo + "C00002=50.000,20.000,30.000,180.0000,0.0000,0.0000\r\n",
                                    "MOVJ C00000 VJ=25.00\r\nMOVL C00002 V=100.0 ACC=50\r\n"
                                    "MOVL C00001 V=100.0 PL=0 ACC=50\r\n",
                                    "3,0,0,0,0,0"));
}

TEST(Inform, AVariableKeepsItsValueForOtherJobs) {
  const std::string positions = kTwo + "P00003=1.000,2.000,3.000,180.0000,0.0000,0.0000\r\n";
  const RobotProgram program = parsed(job(positions, "MOVL P003 V=10.0\r\n", "2,0,0,1,0,0"));
  std::vector<ProgramCommand> commands = commands_of(program);
  commands[0].pose.translation.z() += 1e-3;
  const std::string text = rewrite(program, commands).texts[0];
  EXPECT_THAT(text, HasSubstr("P00003=1.000,2.000,3.000,"));
  EXPECT_THAT(text, HasSubstr("C00002=1.000,2.000,4.000,180.0000,0.0000,0.0000\r\nP00003"));
  EXPECT_THAT(text, HasSubstr("MOVL C00002 V=10.0"));
}

// What the job sets, or a job that it calls may set, is not known.
TEST(Inform, AVariableThatMayChangeIsLeftAlone) {
  const std::string positions = kTwo + "P00003=1,2,3,180,0,0\r\nP00004=1,2,3,180,0,0\r\n",
                    moves = "MOVJ C00000 VJ=1.00\r\nMOVL P003 V=10.0\r\nMOVL P004 V=10.0\r\n";
  EXPECT_EQ(parsed(job(positions, moves)).left_alone, 0);
  EXPECT_EQ(parsed(job(positions, moves + "SET P003 P004\r\n")).left_alone, 1);
  EXPECT_EQ(parsed(job(positions, moves + "GETS PX004 $PX000\r\n")).left_alone, 1);
  EXPECT_EQ(parsed(job(positions, moves + "SET P[I000] P004\r\n")).left_alone, 2);
  EXPECT_EQ(parsed(job(positions, moves + "CALL JOB:OTHER\r\n")).left_alone, 2);
}

// In a folder the jobs that are called are there, and all that set a variable.
TEST(Inform, AVariableMayBeSetByAnyJobOfTheFolder) {
  const std::string positions = kTwo + "P00003=1,2,3,180,0,0\r\nP00004=1,2,3,180,0,0\r\n",
                    moves = "MOVJ C00000 VJ=1.00\r\nMOVL P003 V=10.0\r\nMOVL P004 V=10.0\r\n";
  const auto left = [&](const std::string& instruction, const std::string& other,
                        const std::string& third = "NOP\r\n") {
    const auto named = [&](const std::string& name, const std::string& instructions) {
      return ProgramText{
          name + ".JBI",
          "/JOB\r\n//NAME " + name + "\r\n//POS\r\n//INST\r\nNOP\r\n" + instructions + "END\r\n"};
    };
    const std::vector<ProgramText> project{{"PART.JBI", job(positions, moves + instruction)},
                                           named("GRIP-1", other),
                                           named("THIRD", third)};
    try {
      return parse_program(inform(), {project[0]}, {}, TargetParts::pose,
                           TextsOfOthers(inform(), project).of("PART.JBI"))
          .left_alone;
    } catch (const NoTargets& all) {
      return static_cast<int>(all.why_left_alone.size());
    }
  };
  const std::string call = "CALL JOB:GRIP-1\r\n";
  EXPECT_EQ(left(call, "DOUT OT#(1) ON\r\n"), 0);
  EXPECT_EQ(left(call, "SET P003 P009\r\n"), 1);
  EXPECT_EQ(left(call, "SET P009 P003\r\n"), 0);
  EXPECT_EQ(left(call, "CALL JOB:THIRD IF B000=1\r\n", "GETS PX004 $PX000\r\n"), 1);
  EXPECT_EQ(left("", "SET P[I000] P009\r\n"), 2);
  // Jobs that are not there, or that a variable names.
  EXPECT_EQ(left("CALL JOB:ELSEWHERE\r\n", ""), 2);
  EXPECT_EQ(left(call, "CALL JOB:ELSEWHERE\r\n"), 2);
  EXPECT_EQ(left("CALL IG#(1)\r\n", ""), 2);
  // A frame counts where a job that runs in between sets it.
  EXPECT_EQ(left(call, "MFRAME UF#(1) P010 P011 P012\r\n"), 3);
  EXPECT_EQ(left("", "MFRAME UF#(1) P010 P011 P012\r\n"), 0);
}

// Behind RET nothing runs up to the next alternative of its block, whatever word begins that.
TEST(Inform, AnAlternativeBehindReturnRuns) {
  const auto never_run = [](const std::string& begin, const std::string& next) {
    const std::string move = "MOVJ C00001 VJ=1.00\r\n";
    std::vector<bool> never;
    for (const ProgramTarget& target :
         parsed(job(kTwo, begin + "RET\r\n" + move + next + move)).targets)
      never.push_back(target.never_runs);
    return never;
  };
  for (const char* next : {"ELSE\r\n", "ELSEIF B000=2\r\n", "ELSEIFEXP B000=2\r\n", "ENDIF\r\n"})
    EXPECT_THAT(never_run("IFTHENEXP B000=1\r\n", next), ElementsAre(true, false)) << next;
  for (const char* next : {"CASE 2\r\n", "DEFAULT\r\n", "ENDSWITCH\r\n"})
    EXPECT_THAT(never_run("SWITCH B000 CASE 1\r\n", next), ElementsAre(true, false)) << next;
  EXPECT_THAT(never_run("", "DOUT OT#(1) ON\r\n"), ElementsAre(true, true));
}

// The position of a move that is left alone stays for it.
TEST(Inform, AShiftedMoveKeepsItsPosition) {
  const RobotProgram program =
      parsed(job(kTwo + "P00000=0,0,5,0,0,0\r\n",
                 "MOVJ C00000 VJ=1.00\r\nMOVL C00001 V=10.0\r\nSFTON P000\r\nMOVL C00001 V=10.0\r\n"
                 "SFTOF\r\n"));
  EXPECT_THAT(program.why_left_alone, ElementsAre("its point is shifted (SFTON)"));
  std::vector<ProgramCommand> commands = commands_of(program);
  commands[1].pose.translation.x() += 1e-3;
  const std::string text = rewrite(program, commands).texts[0];
  EXPECT_THAT(text, HasSubstr("C00001=110.000,"));
  EXPECT_THAT(text, HasSubstr("MOVL C00002 V=10.0\r\nSFTON P000\r\nMOVL C00001 V=10.0"));
}

// A shift that a branch passes over may be on behind it.
TEST(Inform, AShiftInABranchIsNotCertain) {
  const std::string moves =
      "MOVJ C00000 VJ=1.00\r\nIFTHENEXP B000=1\r\nSFTON P000\r\nENDIF\r\n"
      "MOVL C00001 V=10.0\r\nSFTOF\r\nMOVL C00001 V=10.0\r\n";
  EXPECT_THAT(parsed(job(kTwo, moves)).why_left_alone,
              ElementsAre("its point may be shifted (SFTON)"));
}

TEST(Inform, ThreeCircularPointsAreALineAndAnArc) {
  const std::string three = kTwo + "C00002=1,2,3,180,0,0\r\nC00003=4,5,6,180,0,0\r\n",
                    run =
                        "MOVJ C00000 VJ=1.00\r\nMOVC C00001 V=9.0\r\nMOVC C00002 V=9.0\r\n"
                        "MOVC C00003 V=9.0\r\n";
  const auto motions = [](const RobotProgram& program) {
    std::vector<MotionKind> all;
    for (const ProgramTarget& target : program.targets) all.push_back(target.motion);
    return all;
  };
  EXPECT_THAT(motions(parsed(job(three, run))),
              ElementsAre(MotionKind::joint, MotionKind::line, MotionKind::via, MotionKind::arc));
  // A fourth one without FPT: no arcs.
  EXPECT_THAT(motions(parsed(job(three, run + "MOVC C00000 V=9.0\r\n"))),
              ElementsAre(MotionKind::joint, MotionKind::line, MotionKind::joint, MotionKind::joint,
                          MotionKind::joint));
  // The whole arc stays if one of its points does.
  const RobotProgram left = parsed(job(three,
                                       "MOVJ C00000 VJ=1.00\r\nMOVC C00001 V=9.0\r\n"
                                       "MOVC C00002 V=9.0\r\nMOVC LP003 V=9.0\r\n"));
  EXPECT_THAT(motions(left), ElementsAre(MotionKind::joint, MotionKind::line));
  EXPECT_EQ(left.left_alone, 2);
}

TEST(Inform, PulsesAreLeftAloneWithTheReason) {
  try {
    parsed(job("///TOOL 0\r\n///POSTYPE PULSE\r\n///PULSE\r\nC00000=1,2,3,4,5,6\r\n",
               "MOVJ C00000 VJ=1.00\r\n"));
    FAIL();
  } catch (const NoTargets& error) {
    ASSERT_THAT(error.why_left_alone, SizeIs(1));
    EXPECT_THAT(error.why_left_alone[0], HasSubstr("in pulses"));
    EXPECT_THAT(error.what(), HasSubstr("PART.JBI:14: left alone"));
  }
}

// As YRC1000 writes RC.PRM: gear ratios of two robots, one of them with six axes.
std::string parameters(double denominator_of_b = -4) {
  std::vector<double> robot(3000, 0);
  const std::vector<double> denominators{45, -45, 45, 45, denominator_of_b, 45};
  for (size_t i = 0; i < 6; ++i) {
    robot[1030 + i] = i == 4 ? 3000 : 180 * 1024;  // limits
    robot[1090 + i] = denominators[i];
    robot[1100 + i] = i == 4 ? -8 : 90 * 45;
  }
  const auto block = [](const std::string& head, const std::vector<double>& numbers) {
    std::string text = head;
    for (size_t i = 0; i < numbers.size(); ++i)
      text += (i % 10 == 0 ? "\r\n" : ",") + std::to_string(static_cast<int>(numbers[i]));
    return text + "\r\n";
  };
  std::vector<double> seven = robot;
  seven[1096] = 1;
  seven[1106] = 50;
  return "//RC YAS\r\n" + block("///RCD", {1, 2}) + block("///RC1G", robot) +
         block("///RC2G", seven);
}

const std::string kPulses =
    "///TOOL 3\r\n///POSTYPE PULSE\r\n///PULSE\r\n"
    "C00000=1024,-2048,3072,0,-2048,1024\r\nC00001=2048,-2048,3072,0,-2048,1024\r\n";

// 4096 pulses per turn of a motor: S turns 90 times as slowly, B twice as slowly.
TEST(Inform, PulsesAreAnglesByTheParametersOfTheController) {
  const std::string moves = "MOVJ C00000 VJ=1.00\r\nMOVL C00001 V=9.0\r\n";
  const auto read = [&](const std::string& text, const std::string& listing) {
    return parse_program(
        inform(), {{"PART.JBI", text}}, {}, TargetParts::pose,
        what_others_declare(inform(), {{"PART.JBI", text}}, {{"RC.PRM", listing}}));
  };
  const RobotProgram program = read(job(kPulses, moves), parameters());
  ASSERT_THAT(program.targets, SizeIs(2));
  JointVector expected(6);
  expected << 1, -2, 3, 0, -90, 1;
  EXPECT_LT((program.targets[0].q / kDegree - expected).norm(), 1e-9);
  std::vector<ProgramCommand> commands = commands_of(program);
  EXPECT_EQ(rewrite(program, commands).texts[0], program.texts[0].text);
  commands[1].q[0] += 0.0017 * kDegree;  // 1.74 pulses
  commands[1].q[4] += 0.02 * kDegree;    // 0.46 pulses
  EXPECT_THAT(rewrite(program, commands, {}, Corrector::compensate).texts[0],
              HasSubstr("C00001=2050,-2048,3072,0,-2048,1024\r\n"));
  // Another robot, another number of axes, and limits that are no angles: left alone.
  std::string second = job(kPulses, moves);
  second.replace(second.find("RB1"), 3, "RB2");
  EXPECT_THROW(read(second, parameters()), NoTargets);
  EXPECT_THROW(read(job(kPulses, moves), parameters(-4000)), NoTargets);
  EXPECT_THROW(read(job(kPulses, moves), "///RC1G\r\n1,2,3\r\n"), NoTargets);
}

TEST(Inform, ToolsAndUserFramesStandInTheFilesOfTheController) {
  const std::vector<ProgramText> files{
      {"TOOL.CND",
       "//TOOL 0\r\n///NAME A\r\n0.000,0.000,0.000,0.0000,0.0000,0.0000\r\n1.0,2.0,3.0\r\n4.0\r\n"
       "//TOOL 3\r\n///CRC 1\r\n///NAME B\r\n0.000,0.000,100.000,0.0000,0.0000,90.0000\r\n"
       "1.0,2.0,3.0,4.0,5.0,6.0\r\n"},
      {"UFRAME.CND",
       "//UFRAME 1\r\n///NAME C\r\n///TOOL 3\r\n///GROUP 1,0,0\r\n///PULSE\r\n"
       "////ORG C000=1,2,3,4,5,6\r\n////BUSER 500.000,0.000,10.000,0.0000,0.0000,0.0000\r\n"}};
  const std::string text = job(kTwo + "///TOOL 3\r\nC00002=1,2,3,0,0,0\r\n",
                               "MOVJ C00000 VJ=1.00\r\nMOVJ C00002 VJ=1.00\r\n");
  const auto read = [&](const std::vector<ProgramText>& others, const KnownFrames& known) {
    return parse_program(inform(), {{"PART.JBI", text}}, known, TargetParts::pose,
                         what_others_declare(inform(), {{"PART.JBI", text}}, others));
  };
  const RobotProgram program = read(files, {});
  ASSERT_THAT(program.targets, SizeIs(2));
  const ProgramFrame& user = program.frames[program.targets[1].base];
  const ProgramFrame& tool = program.frames[program.targets[1].tool];
  EXPECT_TRUE(user.is_known && tool.is_known);
  EXPECT_LT((user.pose.translation - Eigen::Vector3d(0.5, 0, 0.01)).norm(), 1e-12);
  EXPECT_LT((tool.pose.translation - Eigen::Vector3d(0, 0, 0.1)).norm(), 1e-12);
  EXPECT_LT((tool.pose.rotation * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(),
            1e-12);
  // --frame has priority; two controllers with other frames say nothing.
  const Pose given{Eigen::Matrix3d::Identity(), {0, 0, 1}};
  EXPECT_EQ(read(files, {{"TOOL[3]", given}}).frames[program.targets[1].tool].pose.translation.z(),
            1);
  std::vector<ProgramText> two = files;
  two.push_back({"other/UFRAME.CND", "//UFRAME 1\r\n////BUSER 1,2,3,4,5,6\r\n"});
  EXPECT_FALSE(read(two, {}).frames[program.targets[1].base].is_known);
}

// Where a coordinated move ends is where its position is, whatever the station does; the way there
// is the station's, too. A pose on a base that moves is not known.
TEST(Inform, ACoordinatedMoveEndsAtItsPosition) {
  const std::string angles =
      "///TOOL 0\r\n///POSTYPE ANGLE\r\n///ANGLE\r\nC00002=1,2,3,4,-50,6\r\n"
      "C00003=2,2,3,4,-50,6\r\nBC00002=100.000\r\nEC00002=10.0\r\nEC00003=20.0\r\n"
      "///POSTYPE MTOOL\r\n///RECTAN\r\nC00004=1,2,3,4,5,6\r\n";
  const RobotProgram program = parsed(
      job(kTwo + angles,
          "MOVJ C00002 BC00002 VJ=1.00  +MOVJ EC00002\r\nSMOVL C00003 V=9.0  +MOVJ EC00003\r\n"
          "SMOVC C00002 V=9.0\r\nSMOVL C00000 V=9.0\r\nSMOVL C00004 V=9.0\r\n"
          "MOVL C00001 BC00002 V=9.0\r\n",
          "5,1,2,0,0,0"));
  ASSERT_THAT(program.targets, SizeIs(4));
  for (const ProgramTarget& target : program.targets) EXPECT_EQ(target.motion, MotionKind::joint);
  EXPECT_EQ(program.targets[0].other_axes.at("base axis 1"), 100);
  EXPECT_EQ(program.targets[1].other_axes.at("station axis 1"), 20);
  EXPECT_EQ(program.frames[program.targets[3].base].name, "USER[1]");
  ASSERT_THAT(program.why_left_alone, SizeIs(2));
  EXPECT_THAT(program.why_left_alone[0], HasSubstr("not followed: MTOOL"));
  EXPECT_THAT(program.why_left_alone[1], HasSubstr("the base moves with it (BC00002)"));
}

// DX100: a comment has at most 32 characters with its quote.
TEST(Inform, TheMarkStandsBehindNop) {
  const std::string moves = "MOVJ C00000 VJ=1.00\r\n";
  std::string text = job(kTwo, moves);
  mark_corrected(inform(), Corrector::compensate, text);
  EXPECT_EQ(text, job(kTwo, "'corrected by armtrue compensate\r\n" + moves));
  EXPECT_TRUE(find_correction_mark({{"PART.JBI", text}}, Corrector::compensate));
  EXPECT_THAT(std::string("'corrected by armtrue compensate"), SizeIs(testing::Le(32)));
}

TEST(Inform, TheNameIsThatOfTheFile) {
  const RobotProgram program = parsed(job(kTwo, "MOVJ C00000 VJ=1.00\r\n"));
  std::vector<std::string> texts{program.texts[0].text};
  rename(program, "part-2", texts);
  EXPECT_THAT(texts[0], HasSubstr("//NAME PART-2\r\n"));
  EXPECT_EQ(why_illegal_name(inform(), "12-A_b"), "");
  EXPECT_THAT(why_illegal_name(inform(), "a b"), HasSubstr("use 'a_b'"));
}

// DX100: 9999 lines. Eight of them stand about the ones that are repeated.
TEST(Inform, AJobThatWouldNotLoadIsRefused) {
  for (const int lines : {9998, 9999}) {
    std::string moves = "MOVJ C00000 VJ=1.00\r\nMOVL C00001 V=1.0\r\n";
    for (int i = 8; i < lines; ++i) moves += "DOUT OT#(1) ON\r\n";
    const RobotProgram program = parsed(job(kTwo, moves));
    const std::vector<ProgramCommand> commands = commands_of(program);
    EXPECT_EQ(rewrite(program, commands).texts[0], program.texts[0].text);
    const auto with_one_more = [&] {
      rewrite(program, commands, {{1, commands[1].pose, {}, 0, MotionKind::line, {}}});
    };
    if (lines == 9998)
      EXPECT_NO_THROW(with_one_more());
    else
      EXPECT_THROW(with_one_more(), InputError);
  }
}

}  // namespace
}  // namespace armtrue
