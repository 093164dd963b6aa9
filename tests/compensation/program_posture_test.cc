// The posture of a target that states none: that in which the arm comes to it through the program.
// The expected joint angles are from inverse kinematics of its own, beside armtrue, by Newton's
// method from the joint angles of the move before.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/program_findings.h"
#include "armtrue/compensation/program_targets.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"

namespace armtrue {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

// A program of one maker: two joint moves with the wrist bent to either side, and a straight one.
struct Maker {
  const char *dialect, *file, *robot;
  std::string begin, up, down, line;
  std::vector<double> line_up, line_down;  // the joint angles of the line [deg]
};

const Maker kKuka{"krl",
                  "p.src",
                  "kr10-r1100",
                  "DEF p()\n$TOOL={X 10,Y 5,Z 120,A 30,B 10,C 0}\n"
                  "$BASE={X 450,Y -100,Z 250,A 20,B 3,C -4}\n",
                  "PTP {A1 0,A2 -90,A3 90,A4 0,A5 45,A6 0}\n",
                  "PTP {A1 0,A2 -90,A3 90,A4 180,A5 -45,A6 180}\n",
                  "LIN {X 280,Y 90,Z 440,A 132,B 12,C 154}\n",
                  {-7.7426, -82.4420, 96.7668, -6.2875, 45.1785, -0.7824},
                  {-7.7426, -82.4420, 96.7668, 173.7125, -45.1785, 179.2176}};

const Maker kAbb{
    "rapid",
    "p.mod",
    "irb120",
    "MODULE m\nPERS tooldata t:=[TRUE,[[10,0,80],[0.98480775,0,0.17364818,0]],"
    "[1,[0,0,1],[1,0,0,0],0,0,0]];\nPERS wobjdata w:=[FALSE,TRUE,\"\","
    "[[250,-50,100],[0.9961947,0,0,0.08715574]],[[10,5,2],[1,0,0,0]]];\n"
    "CONST robtarget pA:=[[122.2,20,238.1],[0.02378649,0.34215861,0.93869293,-0.03488945],"
    "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nPROC main()\nConfL\\Off;\n",
    "MoveAbsJ [[0,10,0,0,60,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,t;\n",
    "MoveAbsJ [[0,10,0,150,-60,-150],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,t;\n",
    "MoveL pA,v100,fine,t\\WObj:=w;\n",
    {5.1407, 7.3385, 19.6883, -21.8955, 46.6348, 47.5463},
    {5.1407, 7.3385, 19.6883, 158.1045, -46.6348, -132.4537}};

const Maker kUr{"urscript",
                "p.script",
                "ur5e",
                "def p():\nset_tcp(p[0.01,0.02,0.1,0,0,0.3])\n",
                "movej([0,-1.5708,1.5708,-1.5708,-1.5708,0])\n",
                "movej([0,-1.5708,1.5708,1.5708,1.5708,3.14])\n",
                "movel(p[-0.3,-0.4,0.3,2.1,2.2,-0.1])\n",
                {35.5645, -88.8315, 102.4514, -106.2723, -83.7500, 15.8561},
                {35.5645, -62.1853, 67.1751, 82.3579, 83.7500, 195.8561}};

// What becomes of a program: the joint angles of each target [deg], or why it is left alone.
std::vector<std::string> left;
std::vector<std::vector<double>> driven(const Maker& maker, const std::string& text,
                                        std::optional<JointVector> start = std::nullopt) {
  left.clear();
  const Robot arm =
      read_robot(ARMTRUE_CONFIG "/robots/" + std::string(maker.robot) + ".yaml").robot;
  RobotProgram program =
      parse_program(*find_dialect(maker.dialect), {{maker.file, maker.begin + text}}, {});
  remove_what_never_runs(program);
  const ProgramJoints joints = joints_of_program(program, arm, "r.yaml");
  CompensationOptions options;
  options.start = start;
  std::vector<CorrectedTarget> targets;
  while (targets.empty()) try {
      targets = compensate(arm, arm, program_targets(program, options, joints), options);
    } catch (const UnreachableTarget& error) {
      for (const auto& [row, why] : error.in_doubt) left.push_back(why);
      if (!leave_what_is_out_of_reach(error, program)) throw;
    }
  std::vector<std::vector<double>> all;
  for (const CorrectedTarget& target : targets) {
    all.emplace_back();
    for (int j = 0; j < kProgramAxes; ++j) all.back().push_back(target.programmed[j] / kDegree);
  }
  return all;
}

auto is_at(const std::vector<double>& expected) {
  return testing::Pointwise(testing::DoubleNear(2e-4), expected);
}

TEST(ProgramPosture, OfTheMoveBeforeIt) {
  for (const auto& [maker, end] :
       {std::pair(kKuka, "END\n"), std::pair(kAbb, "ENDPROC\nENDMODULE\n"),
        std::pair(kUr, "end\n")}) {
    EXPECT_THAT(driven(maker, maker.up + maker.line + end)[1], is_at(maker.line_up));
    EXPECT_THAT(driven(maker, maker.down + maker.line + end)[1], is_at(maker.line_down));
  }
}

TEST(ProgramPosture, MovesThatNeverRunLeadNowhere) {
  EXPECT_THAT(driven(kKuka, kKuka.up + "GOTO L1\n" + kKuka.down + "L1:\n" + kKuka.line + "END\n"),
              ElementsAre(SizeIs(6), is_at(kKuka.line_up)));
  EXPECT_THAT(driven(kAbb, kAbb.up + "GOTO on;\n" + kAbb.down + "on:\n" + kAbb.line +
                               "ENDPROC\nENDMODULE\n"),
              ElementsAre(SizeIs(6), is_at(kAbb.line_up)));
  EXPECT_THAT(driven(kUr, kUr.up + "def never():\n" + kUr.down + "end\n" + kUr.line + "end\n"),
              ElementsAre(SizeIs(6), is_at(kUr.line_up)));
}

TEST(ProgramPosture, ARoutineBeginsWithWhatItsCallsEndWith) {
  EXPECT_THAT(driven(kKuka, kKuka.up + "sub()\n" + kKuka.down + "END\nDEF sub()\n" + kKuka.line +
                                "END\n")[2],
              is_at(kKuka.line_up));
  EXPECT_THAT(driven(kAbb, kAbb.up + "sub;\n" + kAbb.down + "ENDPROC\nPROC sub()\n" + kAbb.line +
                               "ENDPROC\nENDMODULE\n")[2],
              is_at(kAbb.line_up));
  EXPECT_THAT(
      driven(kUr, kUr.down + "sub()\n" + kUr.up + "end\ndef sub():\n" + kUr.line + "end\n")[2],
      is_at(kUr.line_down));
  // And it ends with what its last move leaves.
  EXPECT_THAT(driven(kKuka, kKuka.up + "sub()\n" + kKuka.line + "END\nDEF sub()\n" + kKuka.down +
                                "END\n")[1],
              is_at(kKuka.line_down));
}

TEST(ProgramPosture, ABranchThatEndsDoesNotJoin) {
  EXPECT_THAT(driven(kKuka, kKuka.up + "IF $IN[1] THEN\n" + kKuka.down + kKuka.line +
                                "RETURN\nENDIF\n" + kKuka.line + "END\n"),
              ElementsAre(SizeIs(6), SizeIs(6), is_at(kKuka.line_down), is_at(kKuka.line_up)));
  EXPECT_THAT(driven(kAbb, kAbb.up + "IF x THEN\n" + kAbb.down + "RETURN;\nENDIF\n" + kAbb.line +
                               "ENDPROC\nENDMODULE\n")[2],
              is_at(kAbb.line_up));
  for (const char* end : {"halt\n", "return 1\n"})
    EXPECT_THAT(driven(kUr, kUr.up + "if x:\n" + kUr.down + end + "end\n" + kUr.line + "end\n")[2],
                is_at(kUr.line_up));
}

TEST(ProgramPosture, WaysWithSeveralPosturesLeaveTheMoveAlone) {
  EXPECT_THAT(driven(kKuka, kKuka.up + "IF $IN[1] THEN\n" + kKuka.down + "ENDIF\n" + kKuka.line +
                                kKuka.line + kKuka.up + "END\n"),
              SizeIs(3));
  EXPECT_THAT(left, ElementsAre(AllOf(HasSubstr("line 4, line 6"), HasSubstr("S and T")),
                                HasSubstr("ways with several postures")));
  EXPECT_THAT(driven(kAbb, kAbb.up + "IF x THEN\n" + kAbb.down + "ENDIF\n" + kAbb.line +
                               "ENDPROC\nENDMODULE\n"),
              SizeIs(2));
  EXPECT_THAT(driven(kUr, kUr.up + "while x:\n" + kUr.line + kUr.down + "end\nend\n"), SizeIs(2));
  EXPECT_THAT(left, SizeIs(1));
  // With one posture on all ways, and where the point states it.
  EXPECT_THAT(
      driven(kUr, kUr.up + "while x:\n" + kUr.line + "if y:\n" + kUr.up + "end\nend\nend\n"),
      ElementsAre(SizeIs(6), is_at(kUr.line_up), SizeIs(6)));
  EXPECT_THAT(driven(kKuka, kKuka.up + "IF $IN[1] THEN\n" + kKuka.down + "ENDIF\n" +
                                "LIN {X 280,Y 90,Z 440,A 132,B 12,C 154,S 2,T 43}\nEND\n"),
              ElementsAre(SizeIs(6), SizeIs(6), SizeIs(6)));
}

TEST(ProgramPosture, AllBranchesTogetherLeaveNoOtherWay) {
  const std::string flipped = kKuka.down + "ELSE\n" + kKuka.down + "ENDIF\n" + kKuka.line + "END\n";
  EXPECT_THAT(driven(kKuka, kKuka.up + "IF $IN[1] THEN\n" + flipped)[3], is_at(kKuka.line_down));
  EXPECT_THAT(driven(kKuka, kKuka.up + "SWITCH i\nCASE 1\n" + kKuka.down + "DEFAULT\n" +
                                kKuka.down + "ENDSWITCH\n" + kKuka.line + "END\n")[3],
              is_at(kKuka.line_down));
  EXPECT_THAT(
      driven(kKuka, kKuka.up + "REPEAT\n" + kKuka.down + "UNTIL x\n" + kKuka.line + "END\n")[2],
      is_at(kKuka.line_down));
}

// The start counts where the program begins, and only there.
TEST(ProgramPosture, TheStartIsThatOfTheProgram) {
  JointVector start(6);
  start << 0, -1.57, 1.57, -1.57, -1.57, 0;
  EXPECT_THROW(driven(kUr, kUr.line + kUr.up + "end\n"), UnreachableTarget);
  EXPECT_THAT(driven(kUr, kUr.line + kUr.down + kUr.line + "end\n", start),
              ElementsAre(is_at(kUr.line_up), SizeIs(6), is_at(kUr.line_down)));
}

}  // namespace
}  // namespace armtrue
