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
