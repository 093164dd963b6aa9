#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/programs/program_project.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue::krl_flow_test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Eq;
using testing::IsEmpty;
using testing::Not;

const std::string kHead = "DEF p()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\n";
const std::string kWhole = "LIN {X 1,Y 2,Z 3,A 0,B 90,C 0}\n";

RobotProgram parsed(const std::string& text) {
  return parse_program(*find_dialect("krl"), {{"p.src", text}}, {});
}

// Behind the first, in line 4: the targets that are not left alone, as line: X Y Z in mm; `>`: the
// arm always comes from the target before.
std::vector<std::string> targets(const std::string& moves) {
  std::vector<std::string> result;
  const RobotProgram program = parsed(kHead + kWhole + moves);
  for (const ProgramTarget& target : program.targets) {
    const Eigen::Vector3d mm = target.pose.translation / kMillimetre;
    if (target.line > 4)
      result.push_back(fmt::format("{}{}: {:g} {:g} {:g}", target.follows_target ? "> " : "",
                                   target.line, mm[0], mm[1], mm[2]));
  }
  // A move that never runs gives a warning alone.
  EXPECT_TRUE(program.left_alone == 0 || !program.warnings.empty());
  return result;
}

TEST(KrlFlowTest, WhatWaitsAndAssignsLeavesTheArmWhereItIs) {
  EXPECT_THAT(targets("WAIT SEC 1\nWAIT FOR $IN[1]\n$OUT[2]=TRUE\nx=SQRT(2)*(a+b)\nb=c AND (d)\n"
                      "MSG[]=\"to (5)\"\nBAS(#VEL_CP,1)\nIF (x>1) AND NOT(b) THEN\n$OUT[3]=TRUE\n"
                      "ENDIF\nFOR i=1 TO 3\nx=i\nENDFOR\nLIN {Z 5}\n"),
              ElementsAre("> 18: 1 2 5"));
}

// The zone of the last move [mm], 0 if it is not known.
double zone_of(const std::string& moves, const std::string& dat = "") {
  const RobotProgram program =
      parse_program(*find_dialect("krl"), {{"p.src", kHead + kWhole + moves}, {"p.dat", dat}}, {});
  return program.targets.back().blend / kMillimetre;
}

TEST(KrlFlowTest, ZonesAreThoseOfTheWayThatLeadsToTheMove) {
  const std::string dis = "LIN {Z 5} C_DIS\n", set = "$APO.CDIS=7.5\n";
  EXPECT_EQ(zone_of(dis), 0);
  EXPECT_EQ(zone_of(set + dis), 7.5);
  EXPECT_EQ(zone_of("$APO.CDIS=99\n" + set + "$APO.CPTP=50\n" + dis), 7.5);
  EXPECT_EQ(zone_of("$APO={CPTP 50,CDIS 3}\n" + dis), 3);
  EXPECT_EQ(zone_of(set + "LIN {Z 5}\n"), 0);        // it stops
  EXPECT_EQ(zone_of(set + "LIN {Z 5} C_VEL\n"), 0);  // by its speed
  EXPECT_EQ(zone_of(set + "PTP {Z 5} C_PTP\n"), 0);  // by the axes
  EXPECT_EQ(zone_of(set + "PTP {Z 5} C_PTP C_DIS\n"), 7.5);
  EXPECT_EQ(zone_of(set + "$APO.CDIS=2*x\n" + dis), 0);
  EXPECT_EQ(zone_of("IF $IN[1] THEN\n" + set + "ENDIF\n" + dis), 0);
  EXPECT_EQ(zone_of("SLIN {Z 5} WITH $VEL.CP=1, $APO.CDIS=4 C_SPL\n"), 4);
  const std::string dat =
      "DEFDAT p\nDECL LDAT L1={VEL 2.0,ACC 100.0,APO_DIST 60.0,ORI_TYP #VAR}\nENDDAT\n";
  EXPECT_EQ(zone_of("LDAT_ACT=L1\nBAS(#CP_PARAMS,1.0)\n" + dis, dat), 60);
  EXPECT_EQ(zone_of("SLIN {Z 5} WITH $APO=SAPO(L1) C_SPL\n", dat), 60);
  EXPECT_EQ(zone_of(set + "LDAT_ACT=L2\n" + dis, dat), 0);
}

TEST(KrlFlowTest, BehindWhatMayMoveTheArmLeftOutCoordinatesAreUnknown) {
  for (const std::string statement :
       {"sub()", "other.sub (1)", "x=function(1)", "IF function(1) THEN\nENDIF",
        "again:", "INTERRUPT ON 3", "RESUME", "$TOOL={X 0,Y 0,Z 300,A 0,B 0,C 0}", "$BASE.X=3",
        "$IPO_MODE=#TCP\n$IPO_MODE=#BASE\n$BASE={X 1,Y 0,Z 0,A 0,B 0,C 0}", "END\nDEF q()"})
    EXPECT_THAT(targets(statement + "\nLIN {Z 5}\n"), IsEmpty()) << statement;
  // A whole point is certain again, and so is what follows it.
  EXPECT_THAT(targets("sub()\n" + kWhole + "LIN {Z 5}\n"), ElementsAre("6: 1 2 3", "> 7: 1 2 5"));
  // The tool as it was.
  EXPECT_THAT(targets("$TOOL = $nullframe\nLIN {Z 5}\n"), ElementsAre("> 6: 1 2 5"));
}

TEST(KrlFlowTest, ARelativeMoveEndsWhereItsStartSays) {
  EXPECT_THAT(targets("LIN_REL {Z 5}\nLIN_REL{X 1,Y -2} C_DIS #BASE\nPTP_REL {X 2}\n"),
              ElementsAre("> 5: 1 2 8", "> 6: 2 0 8", "> 7: 4 0 8"));
  // In the tool, whose z is x of the frame here.
  EXPECT_THAT(targets("SLIN_REL {Z 5} #TOOL WITH $VEL.CP=1 C_SPL\nLIN {Y 0}\n"),
              ElementsAre("> 5: 6 2 3", "> 6: 6 0 3"));
  EXPECT_THAT(targets("IF a THEN\nLIN {X 9}\nENDIF\nLIN_REL {Z 5}\n"), ElementsAre("> 6: 9 2 3"));
  for (const std::string move :
       {"sub()\nLIN_REL {Z 5}", "LIN_REL {Z a}", "LIN_REL {Z 5,A 3}", "LIN_REL {Z 5,E1 3}",
        "LIN_REL XP1", "CIRC_REL {X 10},{X 20}", "PTP_REL {A1 5}", "LIN_REL {Z 5} #OTHER",
        "PTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nLIN_REL {Z 5}", "LOOP\nLIN_REL {Z 5}\nENDLOOP"})
    for (const std::string& target : targets(move + "\n"))
      EXPECT_THAT(target, HasSubstr(": 0 0 0")) << move;  // of the joint angles
}

TEST(KrlFlowTest, ARelativeMoveFromACorrectedPointIsWrittenOut) {
  const auto rewritten = [](const std::string& moves, bool is_moved) {
    const RobotProgram program = parsed(kHead + moves);
    std::vector<ProgramCommand> commands;
    for (const ProgramTarget& target : program.targets)
      commands.push_back({true, target.q, target.q, target.pose});
    if (is_moved) commands[0].pose.translation.z() += 1e-3;
    return rewrite(program, commands).texts[0].substr(kHead.size());
  };
  const std::string moves =
      kWhole + "LIN_REL{Z 5} C_DIS #BASE ;up\nslin_rel {X 1} C_SPL\nLIN {Y 0}\n";
  EXPECT_EQ(rewritten(moves, false), moves);
  EXPECT_EQ(rewritten(moves, true),
            "LIN {X 1,Y 2,Z 4,A 0,B 90,C 0}\nLIN {X 1.0,Y 2.0,Z 8.0,A 0.0,B 90.0,C 0.0} C_DIS ;up\n"
            "slin_rel {X 1} C_SPL\nLIN {Y 0}\n");
}

// Of XP1 and XP2, and of PA that the program computes.
std::vector<std::string> computed(const std::string& moves, const std::string& declared = "") {
  std::vector<std::string> result;
  try {
    const RobotProgram program = parse_program(
        *find_dialect("krl"),
        {{"p.src",
          "DEF p()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nDECL E6POS PA\n" + moves + "END\n"},
         {"p.dat",
          "DEFDAT P\nDECL E6POS XP1={X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 3,E1 0.0}\n"
          "DECL E6POS XP2={X 7,Y 2,Z 3,A 4,B 5,C 6,S 2,T 3,E1 0.0}\nDECL REAL H=10.0\n" +
              declared + "ENDDAT\n"}},
        {});
    for (const ProgramTarget& target : program.targets) {
      const Eigen::Vector3d mm = target.pose.translation / kMillimetre;
      result.push_back(fmt::format("{}: {:g} {:g} {:g}", target.line, mm[0], mm[1], mm[2]));
    }
  } catch (const NoTargets&) {
  }
  return result;
}

TEST(KrlFlowTest, APointThatConstantsMakeIsKnownWhereItIsCertain) {
  EXPECT_THAT(computed("PA=XP1\nPA.Z=PA.Z+H\nLIN PA\nPA.X=2*H-1+XP2.X\nPTP PA\n"),
              ElementsAre("7: 1 2 13", "9: 26 2 13"));
  // Signs, however many: a damaged file has any number of them.
  const std::string many(1'000'000, '-');
  EXPECT_THAT(computed("PA=XP1\nPA.Z=PA.Z+" + many + "H\nLIN PA\n"),
              Eq(computed("PA=XP1\nPA.Z=PA.Z+H\nLIN PA\n")));
  EXPECT_THAT(computed("PA=XP1\nPA.Z=PA.Z+-" + many + "H\nLIN PA\n"),
              Eq(computed("PA=XP1\nPA.Z=PA.Z-H\nLIN PA\n")));
  EXPECT_THAT(computed("PA=XP1\nLIN PA\nPA=XP2\nLIN PA\nPA={X 0,Y 0,Z 0,A 0,B 0,C 0}\n"),
              ElementsAre("6: 1 2 3", "8: 7 2 3"));
  // Of a branch, a loop, a jump and a subprogram, only what is the same on all ways.
  EXPECT_THAT(computed("PA=XP1\nIF a THEN\nPA=XP2\nLIN PA\nENDIF\nLIN PA\nPA=XP2\nLIN PA\n"),
              ElementsAre("8: 7 2 3", "12: 7 2 3"));
  EXPECT_THAT(computed("PA=XP1\nIF a THEN\nPA=XP2\nGOTO on\nENDIF\nLIN PA\non:\nLIN PA\n"),
              ElementsAre("10: 1 2 3"));
  EXPECT_THAT(computed("PA=XP1\nLOOP\nLIN PA\nPA.Z=PA.Z+H\nENDLOOP\n"), IsEmpty());
  EXPECT_THAT(computed("PA=XP1\nFOR i=1 TO 3\nLIN PA\nENDFOR\n"), ElementsAre("7: 1 2 3"));
  EXPECT_THAT(computed("LOOP\nPA=XP1\nLIN PA\nPA.Z=PA.Z+H\nLIN PA\nENDLOOP\n"),
              ElementsAre("7: 1 2 3", "9: 1 2 13"));
  EXPECT_THAT(computed("PA=XP1\nsub()\nLIN PA\n"), ElementsAre("7: 1 2 3"));
  for (const std::string moves :
       {"LIN PA\n", "PA=XP1\nchange(PA)\nLIN PA\n", "PA=XP1\nPA.Z=PA.Z+$IN\nLIN PA\n",
        "PA=$POS_ACT\nLIN PA\n", "PA=XP1\nPA.Z=PA.Z/3\nLIN PA\n", "PA=XP9\nLIN PA\n",
        "PA=XP1:XP2\nLIN PA\n", "PA=XP1\nPA.Z=unknown\nLIN PA\n", "PA=FP1\nLIN PA\n",
        "PA=XP1\nTRIGGER WHEN DISTANCE=0 DELAY=0 DO change(PA)\nLIN PA\n",
        "sub(1)\nEND\nDEF sub(PA:IN)\nDECL E6POS PA\nPA=XP1\nLIN PA\n",
        // Another variable with the same name.
        "PA=XP1\nsub()\nLIN PA\nEND\nDEF sub()\nDECL E6POS PA\nPA=XP1\n",
        // S and T that the point may keep from XP1.
        "PA=XP1\nPA={X 0,Y 0,Z 0,A 0,B 0,C 0,E1 0.0}\nPTP PA\n"})
    EXPECT_THAT(computed(moves, "DECL FRAME FP1={X 1,Y 2,Z 3,A 4,B 5,C 6}\n"), IsEmpty()) << moves;
  // Products, of variables and as the value of a FRAME.
  const std::string frame = "DECL FRAME FZ={X 1,Y 2,Z 3,A 0,B 0,C 0}\n";
  EXPECT_THAT(computed("DECL FRAME F\nF=$NULLFRAME\nF.Z=H\nLIN FZ:F C_DIS\nF.Z=0\nLIN FZ : "
                       "F:{X 1,Y 0,Z 0,A 0,B 0,C 0} C_DIS\n",
                       frame),
              ElementsAre("8: 1 2 13", "10: 2 2 3"));
  EXPECT_THAT(computed("DECL FRAME F\nF=FZ:FZ\nLIN F\nPA=FZ:FZ\nLIN PA\nF.Z=a\nLIN FZ:F\n", frame),
              ElementsAre("7: 2 4 6", "9: 2 4 6"));
  // What the last run left in a point of the data list.
  const std::string declared = "DECL E6POS PB={X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 3,E1 0.0}\n";
  EXPECT_THAT(computed("LIN PB\nPB=XP2\nLIN PB\n", declared), ElementsAre("7: 7 2 3"));
  // A subprogram of this text, and an interrupt.
  const std::string sub = "END\nDEF sub()\nPB=XP1\n";
  EXPECT_THAT(computed("PB=XP2\nLIN PB\nsub()\nLIN PB\n" + sub, declared),
              ElementsAre("6: 7 2 3", "8: 1 2 3"));
  EXPECT_THAT(computed("INTERRUPT DECL 3 WHEN a DO sub()\nPB=XP2\nLIN PB\n" + sub, declared),
              IsEmpty());
  EXPECT_THAT(
      computed("PB=XP2\nIF f() THEN\nENDIF\nLIN PB\nEND\nDEFFCT BOOL f()\nPB=XP1\n", declared),
      IsEmpty());
}

TEST(KrlFlowTest, AComputedPointIsWrittenOutInItsMoveAlone) {
  const std::string head = "DEF p()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nDECL E6POS PA\n";
  const RobotProgram program = parse_program(
      *find_dialect("krl"),
      {{"p.src", head + "PA=XP1\nPA.Z=PA.Z-2*(1-6)\nPTP PA C_DIS\nLIN XP1\nEND\n"},
       {"p.dat", "DEFDAT P\nDECL E6POS XP1={X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 3,E1 7.5}\nENDDAT\n"}},
      {});
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : program.targets)
    commands.push_back({true, target.q, target.q, target.pose});
  EXPECT_EQ(rewrite(program, commands).texts[0], program.texts[0].text);
  for (ProgramCommand& command : commands) command.pose.translation.x() += 1e-3;
  const RewrittenProgram rewritten = rewrite(program, commands);
  EXPECT_EQ(rewritten.texts[0],
            head +
                "PA=XP1\nPA.Z=PA.Z-2*(1-6)\n"
                "PTP {X 2.0,Y 2.0,Z 13.0,A 4.0,B 5.0,C 6.0,S 2,T 3,E1 7.5} C_DIS\n"
                "LIN {X 2,Y 2,Z 3,A 4,B 5,C 6,S 2,T 3,E1 7.5}\nEND\n");
  EXPECT_EQ(rewritten.texts[1], program.texts[1].text);
}

TEST(KrlFlowTest, AMoveToWhereTheArmStandsIsNone) {
  const RobotProgram program = parsed(kHead + "PTP $POS_ACT\nPTP $AXIS_ACT C_PTP\n" + kWhole);
  EXPECT_EQ(program.left_alone, 0);
  EXPECT_EQ(program.targets.size(), 1u);
  EXPECT_THAT(targets("PTP $POS_ACT\nLIN {Z 5}\n"), IsEmpty());
}

TEST(KrlFlowTest, AJumpThatAlwaysGoesLeavesItsFramesBehind) {
  const std::string tool = "$TOOL={X 0,Y 0,Z 300,A 0,B 0,C 0}\n";
  EXPECT_THAT(targets("IF a THEN\n" + tool + "GOTO on\nENDIF\n" + kWhole + "on:\n"),
              ElementsAre("> 9: 1 2 3"));
  EXPECT_THAT(targets("IF a THEN\n" + tool + "GOTO on\nENDIF\non:\n" + kWhole), IsEmpty());
  EXPECT_THAT(targets("IF a THEN\n" + tool + "RETURN\nENDIF\n" + kWhole),
              ElementsAre("> 9: 1 2 3"));
  EXPECT_THAT(targets("LOOP\nIF a THEN\n" + tool + "EXIT\nENDIF\n" + kWhole + "ENDLOOP\n" + kWhole),
              ElementsAre("10: 1 2 3"));
  EXPECT_THAT(targets("GOTO last\nfirst:\n" + kWhole + "last:\n" + tool + "GOTO first\n"),
              ElementsAre("7: 1 2 3"));
}

TEST(KrlFlowTest, ABranchBeginsWhereTheBranchingDoes) {
  EXPECT_THAT(targets("IF a THEN\nLIN {X 10}\nELSE\nLIN {Y 20}\nENDIF\n"),
              ElementsAre("> 6: 10 2 3", "8: 1 20 3"));
  EXPECT_THAT(targets("SWITCH a\nCASE 1\nLIN {X 10}\nCASE 2\nLIN {Y 20}\nDEFAULT\nLIN {Z 30}\n"
                      "ENDSWITCH\n"),
              ElementsAre("> 7: 10 2 3", "9: 1 20 3", "11: 1 2 30"));
}

TEST(KrlFlowTest, BehindABranchOnlyWhatAllWaysHaveIsKnown) {
  const std::string z = "LIN {Z 10}\n", x = "LIN {X 10}\n", last = "LIN {Z 5}\n";
  EXPECT_THAT(targets("IF a THEN\n" + z + "ENDIF\n" + last), Contains("8: 1 2 5"));
  EXPECT_THAT(targets("IF a THEN\n" + z + "ELSE\n" + z + "ENDIF\n" + last), Contains("10: 1 2 5"));
  EXPECT_THAT(targets("IF a THEN\n" + x + "ELSE\n" + x + "ENDIF\n" + last), Contains("10: 10 2 5"));
  EXPECT_THAT(targets("IF a THEN\n" + x + "ENDIF\n" + last), Not(Contains(HasSubstr("8:"))));
  EXPECT_THAT(targets("IF a THEN\n" + x + "ELSE\nsub()\nENDIF\n" + last),
              Not(Contains(HasSubstr("10:"))));
  EXPECT_THAT(targets("SWITCH a\nCASE 1\n" + x + "ENDSWITCH\n" + last),
              Not(Contains(HasSubstr("9:"))));
  EXPECT_THAT(targets("SWITCH a\nCASE 1\n" + x + "DEFAULT\n" + x + "ENDSWITCH\n" + last),
              Contains("11: 10 2 5"));
  // One way ends there.
  for (const std::string leaves : {"RETURN", "GOTO far", "RESUME"})
    EXPECT_THAT(targets("IF a THEN\n" + x + leaves + "\nENDIF\n" + last), Contains("9: 1 2 5"));
}

TEST(KrlFlowTest, ATurnOfALoopBeginsWhereTheTurnBeforeEnds) {
  struct Loop {
    std::string begin, end;
  };
  for (const Loop& kind : {Loop{"LOOP", "ENDLOOP"},
                           {"FOR i=1 TO 3", "ENDFOR"},
                           {"WHILE a", "ENDWHILE"},
                           {"REPEAT", "UNTIL a"}}) {
    const std::string& begin = kind.begin;
    const auto loop = [&](const std::string& moves) {
      return begin + "\n" + moves + kind.end + "\n";
    };
    EXPECT_THAT(targets(loop("LIN {Z 5}\nLIN {X 6}\n")), IsEmpty()) << begin;
    EXPECT_THAT(targets(loop("LIN {X 5}\nLIN {X 6}\n")), ElementsAre("6: 5 2 3", "> 7: 6 2 3"))
        << begin;
    EXPECT_THAT(targets(loop("LIN {Z 5}\n" + kWhole)), ElementsAre("6: 1 2 5", "> 7: 1 2 3"))
        << begin;
    EXPECT_THAT(targets(loop("LIN {X 5}\nsub()\n")), IsEmpty()) << begin;
    EXPECT_THAT(targets(loop("LIN {X 5}\n$BASE={X 1,Y 0,Z 0,A 0,B 0,C 0}\n")), IsEmpty()) << begin;
    // Loops in one another.
    EXPECT_THAT(targets(loop("LOOP\nLIN {Z 5}\nIF a THEN\nEXIT\nENDIF\nENDLOOP\nLIN {X 7}\n")),
                IsEmpty())
        << begin;
  }
}

TEST(KrlFlowTest, ALoopEndsWhereItIsLeft) {
  const std::string last = "LIN {Z 5}\n";
  EXPECT_THAT(targets("LOOP\nLIN {X 5}\nIF a THEN\nEXIT\nENDIF\nLIN {X 6}\nENDLOOP\n" + last),
              Contains("12: 5 2 5"));
  EXPECT_THAT(targets("FOR i=1 TO 3\nLIN {X 5}\nENDFOR\n" + last),
              Not(Contains(HasSubstr("8:"))));  // perhaps without a turn
  EXPECT_THAT(targets("REPEAT\nLIN {X 5}\nUNTIL a\n" + last), Contains("> 8: 5 2 5"));
}

// Blocks that close otherwise than they open are no KRL.
TEST(KrlFlowTest, InBlocksThatAreNotUnderstoodNothingIsKnown) {
  EXPECT_THAT(targets("LOOP\nLIN {X 5}\nENDIF\nLIN {X 6}\n"), IsEmpty());
  EXPECT_THAT(targets("ENDLOOP\nLIN {X 6}\n"), IsEmpty());
  EXPECT_THAT(targets("IF a THEN\nLIN {X 5}\nENDFOR\nLIN {X 6}\n"), ElementsAre("> 6: 5 2 3"));
}

// From an unknown place the branch of the move before is no longer certain.
TEST(KrlFlowTest, BehindABranchAStraightMoveTakesItsOwnStatus) {
  const std::string move = "LIN {X 1,Y 2,Z 3,A 0,B 80,C 0,S 2,T 10}\n";
  const RobotProgram program = parsed(kHead + move + move + "IF a THEN\n" + move + "ELSE\n" + move +
                                      "ENDIF\nsub()\n" + move);
  std::vector<bool> continues, is_weak;
  for (const ProgramTarget& target : program.targets) {
    continues.push_back(target.configuration.continues);
    is_weak.push_back(target.configuration.is_weak);
  }
  EXPECT_THAT(continues, ElementsAre(false, true, true, false, false));
  EXPECT_THAT(is_weak, ElementsAre(true, false, false, true, true));
}

std::vector<ProgramCommand> commands_for(const RobotProgram& program) {
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : program.targets)
    commands.push_back({true, target.q, target.q, target.pose});
  return commands;
}

TEST(KrlFlowTest, WhatAPointLeavesOutIsAddedIfOneOfTheWaysToItGivesAnother) {
  const std::string text = kHead + kWhole +
                           "LOOP\nLIN {X 5}\nIF a THEN\nLIN {X 6}\nELSE\nLIN {X 7}\n"
                           "ENDIF\nENDLOOP\n";
  const RobotProgram program = parsed(text);
  ASSERT_EQ(program.targets.size(), 4u);
  EXPECT_EQ(rewrite(program, commands_for(program)).texts[0], text);
  const auto with_y = [&](size_t moved) {
    std::vector<ProgramCommand> commands = commands_for(program);
    commands[moved].pose.translation.y() += 1e-3;
    const std::string after = rewrite(program, commands).texts[0];
    return after.substr(after.find("LOOP"));
  };
  EXPECT_EQ(with_y(1),
            "LOOP\nLIN {X 5,Y 3}\nIF a THEN\nLIN {X 6,Y 2}\nELSE\nLIN {X 7,Y 2}\nENDIF\nENDLOOP\n");
  EXPECT_EQ(with_y(3),
            "LOOP\nLIN {X 5,Y 2}\nIF a THEN\nLIN {X 6}\nELSE\nLIN {X 7,Y 3}\nENDIF\nENDLOOP\n");
}

TEST(KrlFlowTest, AnExternalAxisIsAddedIfOneOfTheWaysToAPointGivesAnother) {
  const RobotProgram program =
      parsed(kHead +
             "LIN {X 1,Y 2,Z 3,A 0,B 90,C 0,E1 100}\nIF a THEN\nLIN {X 5,E1 100}\nENDIF\n"
             "LIN {X 9}\n");
  std::vector<ProgramCommand> commands = commands_for(program);
  for (size_t k = 0; k < commands.size(); ++k) commands[k].external = program.targets[k].external;
  EXPECT_EQ(rewrite(program, commands).texts[0], program.texts[0].text);
  commands[1].external[0] = 100.5;
  EXPECT_THAT(rewrite(program, commands).texts[0],
              HasSubstr("LIN {X 5,E1 100.5}\nENDIF\nLIN {X 9,E1 100}\n"));
}

std::string frames_of(const RobotProgram& program, size_t target) {
  const auto name = [&](int index) {
    return index < 0 ? "none" : program.frames[static_cast<size_t>(index)].name;
  };
  return name(program.targets[target].base) + " " + name(program.targets[target].tool);
}

// Lines of the moves behind the first, in line 4, that are left alone because of their frames.
std::vector<int> uncertain(const std::string& text) {
  std::vector<int> lines;
  const RobotProgram program = parsed(kHead + kWhole + text);
  for (const std::string& warning : program.warnings) {
    if (warning.find("left alone: it may run with several $BASE, $TOOL or $IPO_MODE") ==
        std::string::npos)
      continue;
    lines.push_back(std::stoi(warning.substr(warning.find(':') + 1)));
    for (size_t at = warning.find("; also lines "); at != std::string::npos && at < warning.size();)
      if (std::isdigit(static_cast<unsigned char>(warning[at]))) {
        size_t length = 0;
        lines.push_back(std::stoi(warning.substr(at), &length));
        at += length;
      } else {
        ++at;
      }
  }
  return lines;
}

TEST(KrlFlowTest, AMoveThatMayRunWithSeveralFramesIsLeftAlone) {
  const std::string other = "{X 9,Y 0,Z 0,A 0,B 0,C 0}\n", set = "$BASE=" + other;
  EXPECT_THAT(uncertain("LOOP\n" + kWhole + set + "ENDLOOP\n"), ElementsAre(6));
  EXPECT_THAT(uncertain("LOOP\nFOR i=1 TO 3\n" + kWhole + "ENDFOR\n$TOOL=" + other + "ENDLOOP\n"),
              ElementsAre(7));
  EXPECT_THAT(uncertain("IF a THEN\n" + set + "ENDIF\n" + kWhole + "$BASE=$NULLFRAME\n" + kWhole),
              ElementsAre(8));
  EXPECT_THAT(
      uncertain("SWITCH n\nCASE 1\n" + kWhole + set + "CASE 2\n" + kWhole + "ENDSWITCH\n" + kWhole),
      ElementsAre(12));
  EXPECT_THAT(uncertain("again:\n" + kWhole + set + "GOTO again\n"), ElementsAre(6));
  EXPECT_THAT(uncertain("IF a THEN\n$IPO_MODE=#TCP\nENDIF\n" + kWhole), ElementsAre(8));
  // Set before the first move of each turn, or to what it is; or stated by the move itself.
  EXPECT_THAT(uncertain("LOOP\n$BASE=$NULLFRAME\n" + kWhole + set + kWhole + "ENDLOOP\n"),
              IsEmpty());
  EXPECT_THAT(uncertain("LOOP\n" + kWhole + "$BASE=$NULLFRAME\n$IPO_MODE=#BASE\nENDLOOP\n"),
              IsEmpty());
  EXPECT_THAT(uncertain("LOOP\nS" + kWhole.substr(0, kWhole.size() - 1) +
                        " WITH $BASE=$NULLFRAME\n" + set + "ENDLOOP\n"),
              IsEmpty());
  // Where only the position counts, nothing is left alone.
  EXPECT_EQ(parse_program(*find_dialect("krl"),
                          {{"p.src", kHead + "LOOP\n" + kWhole + set + "ENDLOOP\n"}}, {},
                          TargetParts::position)
                .left_alone,
            0);
}

TEST(KrlFlowTest, ABranchHasTheFramesOfItsBegin) {
  const RobotProgram program =
      parsed(kHead + kWhole + "IF a THEN\n$BASE={X 9,Y 0,Z 0,A 0,B 0,C 0}\n" + kWhole + "ELSE\n" +
             kWhole + "ENDIF\n");
  ASSERT_EQ(program.targets.size(), 3u);
  EXPECT_EQ(frames_of(program, 1), "{X9,Y0,Z0,A0,B0,C0} $NULLFRAME");
  EXPECT_EQ(frames_of(program, 2), "$NULLFRAME $NULLFRAME");
}

TEST(KrlFlowTest, ASubprogramHasTheFramesOfItsCallsAndLeavesItsOwn) {
  const std::string other = "$BASE={X 9,Y 0,Z 0,A 0,B 0,C 0}\n", sub = "END\nDEF sub()\n";
  const RobotProgram program =
      parsed(kHead + kWhole + "sub()\nset()\n" + kWhole + sub + kWhole + "low()\nEND\nDEF low()\n" +
             kWhole + "END\nGLOBAL DEF set()\n" + other + "END\n");
  ASSERT_EQ(program.targets.size(), 4u);
  EXPECT_EQ(frames_of(program, 1), "{X9,Y0,Z0,A0,B0,C0} $NULLFRAME");
  EXPECT_EQ(frames_of(program, 2), "$NULLFRAME $NULLFRAME");
  EXPECT_EQ(frames_of(program, 3), "$NULLFRAME $NULLFRAME");
  EXPECT_THAT(program.warnings, IsEmpty());
  // With two bases it has a copy for the second.
  const RobotProgram twice =
      parsed(kHead + kWhole + "sub()\n" + other + "sub()\n" + sub + kWhole + "END\n");
  EXPECT_EQ(twice.left_alone, 0);
  ASSERT_EQ(twice.targets.size(), 3u);
  EXPECT_THAT(twice.texts[0].text, HasSubstr(other + "sub_2()\n"));
  EXPECT_EQ(frames_of(twice, 1), "$NULLFRAME $NULLFRAME");
  EXPECT_EQ(frames_of(twice, 2), "{X9,Y0,Z0,A0,B0,C0} $NULLFRAME");
  // At any time, and by nothing in this text.
  EXPECT_THAT(uncertain("INTERRUPT DECL 3 WHEN $IN[1] DO sub()\n" + kWhole + sub + kWhole + other +
                        "$TOOL=$NULLFRAME\n" + kWhole + "END\n"),
              ElementsAre(6, 9));
  EXPECT_THAT(uncertain(sub + kWhole + "$BASE=$NULLFRAME\n" + kWhole + "END\n"), ElementsAre(7));
  // A text that states none anywhere is that of --base and --tool.
  EXPECT_EQ(parsed("DEF p()\n" + kWhole + sub + kWhole + "END\n").left_alone, 0);
}

TEST(KrlFlowTest, ANumberedFrameHasTheValueThatTheProgramGivesIt) {
  const std::string frame = "={X 9,Y 0,Z 0,A 0,B 0,C 0}\n";
  for (const std::string set : {"BAS(#BASE,3)\n", "$BASE=BASE_DATA[3]\n"}) {
    const RobotProgram program = parsed(kHead + "BASE_DATA[3]" + frame + set + kWhole);
    const ProgramFrame& base = program.frames[static_cast<size_t>(program.targets[0].base)];
    EXPECT_TRUE(base.is_known) << set;
    EXPECT_DOUBLE_EQ(base.pose.translation.x(), 9e-3) << set;
  }
}

// BASE_DATA belongs to the controller: before the program sets it, it has another value, which
// $config.dat states.
TEST(KrlFlowTest, ANumberedFrameHasTheValueThatItWasGivenLast) {
  const auto set = [](int x) {
    return fmt::format("BASE_DATA[3]={{X {},Y 0,Z 0,A 0,B 0,C 0}}\n", x);
  };
  const auto bases = [](const std::string& text, const std::vector<ProgramText>& others) {
    std::vector<double> x;
    const RobotProgram program = parse_program(*find_dialect("krl"), {{"p.src", kHead + text}}, {},
                                               TargetParts::pose, others);
    for (const ProgramTarget& target : program.targets)
      x.push_back(std::round(program.frames[target.base].pose.translation.x() / 1e-6) / 1e3);
    return x;
  };
  const std::string use = "BAS(#BASE,3)\n" + kWhole;
  EXPECT_THAT(bases(set(9) + use + set(8) + use + set(9) + use, {}), ElementsAre(9, 8, 9));
  const std::string product = "$BASE=BASE_DATA[3]:{X 1,Y 0,Z 0,A 0,B 0,C 0}\n" + kWhole;
  EXPECT_THAT(bases(set(9) + product + set(8) + product, {}), ElementsAre(10, 9));
  EXPECT_THAT(bases("FOR i=1 TO 3\n" + set(9) + use + "ENDFOR\n" + set(9) + use, {}),
              ElementsAre(9, 9));
  EXPECT_THAT(bases("init()\n" + use + "END\nDEF init()\n" + set(9) + "END\n", {}), ElementsAre(9));
  const std::vector<ProgramText> config{{"$config.dat", "DEFDAT $CONFIG\n" + set(7) + "ENDDAT\n"}};
  EXPECT_THAT(bases(use + set(9) + use, config), ElementsAre(7, 9));
  EXPECT_THAT(uncertain(use + set(9) + use), ElementsAre(6));
  EXPECT_THAT(uncertain("IF a THEN\n" + set(9) + "ENDIF\n" + use), ElementsAre(9));
  EXPECT_THAT(uncertain(set(8) + "IF a THEN\n" + set(9) + "ENDIF\n" + use + set(9) + use),
              ElementsAre(10));
  // Set by an index that is calculated, or in part: it is the one that --frame states.
  for (const char* const other : {"BASE_DATA[i]={X 1,Y 0,Z 0,A 0,B 0,C 0}\n", "BASE_DATA[3].X=1\n"})
    EXPECT_FALSE(parsed(kHead + set(9) + other + use).frames.back().is_known) << other;
}

// Before the statement whose expression calls it.
TEST(KrlFlowTest, AFunctionSetsFramesAsASubprogramDoes) {
  const std::string function =
      "END\nDEFFCT INT set(n:IN)\nINT n\n$BASE={X 9,Y 0,Z 0,A 0,B 0,C 0}\n";
  const std::string end = "RETURN(1)\nENDFCT\n", used = "{X9,Y0,Z0,A0,B0,C0} $NULLFRAME";
  const auto last = [&](const std::string& text) {
    const RobotProgram program = parsed(kHead + kWhole + text + function + end);
    EXPECT_EQ(program.left_alone, 0) << text;
    return frames_of(program, program.targets.size() - 1);
  };
  EXPECT_EQ(last("x=set(1)\n" + kWhole), used);
  EXPECT_EQ(last("IF set(1)==1 THEN\n$OUT[1]=TRUE\nELSE\n" + kWhole + "ENDIF\n"), used);
  EXPECT_EQ(last("WAIT FOR set(1)==1\n" + kWhole), used);
  EXPECT_EQ(last("$OUT[set(2)]=TRUE\n" + kWhole), used);
  EXPECT_EQ(last("x=abs(1)\n" + kWhole), "$NULLFRAME $NULLFRAME");
  // A move of the function has the frames of its calls.
  const RobotProgram moves =
      parsed(kHead + "x=go(1)\nEND\nDEFFCT INT go(n:IN)\nINT n\n" + kWhole + end);
  EXPECT_EQ(frames_of(moves, 0), "$NULLFRAME $NULLFRAME");
}

TEST(KrlFlowTest, FdatMayBeStatedWhereItIsSet) {
  EXPECT_EQ(
      frames_of(parsed(kHead + "FDAT_ACT = {TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE}\n" + kWhole), 0),
      "BASE_DATA[0] TOOL_DATA[1]");
  EXPECT_THAT(parsed(kHead + "FDAT_ACT={TOOL_NO 1,BASE_NO 2,IPO_FRAME #TCP}\n" + kWhole +
                     "FDAT_ACT={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}\n" + kWhole)
                  .warnings,
              ElementsAre("p.src:5: left alone: its tool stands in the room (#TCP), and the robot "
                          "holds the part"));
}

// BAS.SRC of the controller: #PTP_DAT and #CP_DAT set velocities alone.
TEST(KrlFlowTest, FdatHoldsFromTheBasThatSetsFrames) {
  const std::string fdat = "FDAT_ACT={TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE}\n",
                    of_fdat = "BASE_DATA[0] TOOL_DATA[1]", before = "$NULLFRAME $NULLFRAME";
  const auto last = [](const std::string& moves) {
    const RobotProgram program = parsed(kHead + moves + kWhole);
    return frames_of(program, program.targets.size() - 1);
  };
  EXPECT_EQ(last(fdat + "BAS(#PTP_DAT )\nBAS (#VEL_PTP,10 )\n"), before);
  EXPECT_EQ(last(fdat + "BAS(#CP_DAT)\n"), before);
  EXPECT_EQ(last("BAS(#PTP_DAT)\n" + fdat + "BAS (#FRAMES )\nBAS(#VEL_PTP,100)\n"), of_fdat);
  EXPECT_EQ(last(fdat + "BAS(#PTP_DAT)\nBAS(#FRAMES)\n"), of_fdat);
  EXPECT_EQ(last(fdat + "BAS(#PTP_PARAMS,30)\n"), of_fdat);
  EXPECT_EQ(last(fdat + "BAS(#CP_PARAMS,0.2)\n$BASE=$NULLFRAME\n"), "$NULLFRAME TOOL_DATA[1]");
  EXPECT_EQ(last(fdat + "BAS(#PTP_DAT)\n" + kWhole + "BAS(#CP_PARAMS,0.2)\n"), of_fdat);
  EXPECT_THAT(parsed(kHead + "FDAT_ACT=FX\nBAS(#PTP_PARAMS,1)\nBAS(#FRAMES)\n" + kWhole).warnings,
              ElementsAre("p.src:4: the tool and base of 'FX' are not declared as FDAT"));
  // Of several ways one has another FDAT.
  const RobotProgram several =
      parsed(kHead + fdat + "BAS(#PTP_DAT)\nIF $IN[1] THEN\nFDAT_ACT={TOOL_NO 2,BASE_NO 0}\n" +
             "BAS(#PTP_DAT)\nENDIF\n" + kWhole + "BAS(#FRAMES)\n" + kWhole);
  EXPECT_EQ(several.targets.size(), 1U);
  EXPECT_EQ(several.left_alone, 1);
}

// BAS.SRC of the controller.
TEST(KrlFlowTest, InitmovSetsWorldAndTheFirstTool) {
  const std::string init = "BAS (#INITMOV,0 )\n", initial = "BASE_DATA[0] TOOL_DATA[1]";
  EXPECT_EQ(frames_of(parsed(kHead + init + kWhole), 0), initial);
  EXPECT_EQ(frames_of(parsed(kHead + init + "$BASE=$NULLFRAME\n" + kWhole), 0),
            "$NULLFRAME TOOL_DATA[1]");
  EXPECT_EQ(frames_of(parsed(kHead + "sub()\nEND\nDEF sub()\n" + init + kWhole + "END\n"), 0),
            initial);
  // --base and --tool are for programs that state nothing.
  EXPECT_EQ(parsed("DEF p()\n" + init + kWhole).targets.at(0).tool, -1);
}

// Another kinematic system carries it.
TEST(KrlFlowTest, AnExternalBaseTakesThePlaceOfTheBaseBefore) {
  const RobotProgram program = parsed(kHead + "BAS(#EX_BASE,1)\n" + kWhole);
  EXPECT_EQ(frames_of(program, 0), "BAS(#EX_BASE,1) $NULLFRAME");
  EXPECT_FALSE(program.frames[static_cast<size_t>(program.targets[0].base)].is_known);
}

TEST(KrlFlowTest, FramesCountFromWorldWhereTheArmStandsAtRobroot) {
  const std::string root = "$ROBROOT={X 0.0,Y 0.0,Z 500.0,A 0.0,B 0.0,C 180.0}\n";
  const auto base = [](const std::string& machine, const KnownFrames& known = {}) {
    const std::vector<ProgramText> own{
        {"p.src",
         "DEF p()\n$TOOL=$NULLFRAME\nBASE_DATA[1]={X 0,Y 0,Z 100,A 0,B 0,C 0}\n"
         "BAS(#BASE,1)\n" +
             kWhole}};
    const std::vector<ProgramText> others{
        {"R1/Mada/$machine.dat", "DEFDAT $MACHINE PUBLIC\n" + machine + "ENDDAT\n"}};
    const RobotProgram program =
        parse_program(*find_dialect("krl"), own, known, TargetParts::pose,
                      what_others_declare(*find_dialect("krl"), own, others));
    return program.frames[static_cast<size_t>(program.targets[0].base)].pose;
  };
  const Pose turned = base(root);
  EXPECT_TRUE(turned.translation.isApprox(Eigen::Vector3d(0, 0, 0.4)));
  EXPECT_TRUE(turned.rotation.isApprox(Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix()));
  EXPECT_TRUE(base("DECL FRAME " + root).translation.isApprox(turned.translation));
  const Eigen::Vector3d stated(0, 0, 0.1);
  EXPECT_EQ(base("$ROBROOT={X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}\n").translation, stated);
  EXPECT_EQ(base("$EX_KIN={ET1 #ERSYS,ET2 #NONE}\n" + root).translation, stated);
  // What --frame states counts from R_0.
  EXPECT_EQ(base(root, {{"BASE_DATA[1]", {Eigen::Matrix3d::Identity(), stated}}}).translation,
            stated);
}

TEST(KrlFlowTest, AFrameMayBeAProduct) {
  const std::string set = "$BASE = BASE_DATA[3] : {X 0,Y 5,Z 0,A 0,B 0,C 0}\n",
                    text = kHead + set + kWhole;
  const auto base = [](const RobotProgram& program) {
    return program.frames[static_cast<size_t>(program.targets[0].base)];
  };
  // Y of a frame that is turned by 90 deg about z is -X.
  const std::string value = "BASE_DATA[3]={X 9,Y 0,Z 0,A 90,B 0,C 0}\n";
  const ProgramFrame product = base(parsed(kHead + value + set + kWhole));
  EXPECT_TRUE(product.is_known);
  EXPECT_TRUE(product.pose.translation.isApprox(Eigen::Vector3d(4e-3, 0, 0)));
  EXPECT_EQ(base(parsed(text)).name, "BASE_DATA[3]");
  EXPECT_FALSE(base(parsed(text)).is_known);
  const Pose given{Eigen::Matrix3d::Identity(), {1, 0, 0}};
  EXPECT_TRUE(
      base(parse_program(*find_dialect("krl"), {{"p.src", text}}, {{"base_data[3]", given}}))
          .pose.translation.isApprox(Eigen::Vector3d(1, 5e-3, 0)));
  const std::string whole = "base_data[3]:{X0,Y5,Z0,A0,B0,C0}";
  EXPECT_TRUE(base(parse_program(*find_dialect("krl"), {{"p.src", text}}, {{whole, given}}))
                  .pose.translation.isApprox(Eigen::Vector3d(1, 0, 0)));
}

TEST(KrlFlowTest, AMoveThatKeepsItsOrientationIsNamed) {
  const auto warnings = [](const std::string& moves) {
    return parsed("$ORI_TYPE=#CONSTANT\n" + kHead + "PTP" + kWhole.substr(3) + moves).warnings;
  };
  EXPECT_THAT(warnings(kWhole + "PTP {A 5}\n"), IsEmpty());
  EXPECT_THAT(warnings("LIN {X 5,A 7}\n" + kWhole),
              ElementsAre(AllOf(HasSubstr("p.src:6: $ORI_TYPE is #CONSTANT in this program"),
                                HasSubstr("; also lines 7"))));
  EXPECT_THAT(parsed(kHead + kWhole + "LIN {X 5,A 7}\n").warnings, IsEmpty());
}

TEST(KrlFlowTest, TheFramesOfASplineBlockAreThoseOfItsFirstLine) {
  const std::string frame = "{X 5,Y 0,Z 0,A 0,B 0,C 0}";
  const RobotProgram program =
      parsed(kHead + "spline with $VEL={CP 1,ORI1 2}, $BASE = " + frame + ", $TOOL=" + frame +
             "\nS" + kWhole + "SPL {Z 4} WITH $TOOL=$NULLFRAME\nSPL {Z 5}\nENDSPLINE\n" + kWhole);
  EXPECT_EQ(program.left_alone, 2);  // the second has another tool, and leaves X out
  ASSERT_EQ(program.targets.size(), 2u);
  EXPECT_EQ(frames_of(program, 0), "{X5,Y0,Z0,A0,B0,C0} {X5,Y0,Z0,A0,B0,C0}");
  EXPECT_EQ(frames_of(program, 1), "$NULLFRAME $NULLFRAME");
}

TEST(KrlFlowTest, MovesOfAToolInTheRoomAreLeftAloneWhereverThatIsStated) {
  const std::string point = kWhole.substr(4, kWhole.size() - 5);
  const std::string fdat =
      "DECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #TCP,POINT2[] \" \"}\n"
      "DECL FDAT FP2={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE,POINT2[] \" \"}\n";
  const auto form = [&](const std::string& name) {
    return " WITH $VEL= SVEL_CP(0.2, , LCPDAT1), $TOOL= STOOL2(" + name + "), $BASE= SBASE(" +
           name + "), $IPO_MODE= SIPOMODE(" + name + ".IPO_FRAME), $LOAD= SLOAD(" + name +
           ".TOOL_NO)\n";
  };
  const auto left_alone = [&](const std::string& moves) {
    const RobotProgram program = parsed(fdat + kHead + kWhole + moves);
    EXPECT_EQ(
        program.left_alone > 0,
        !program.warnings.empty() &&
            program.warnings[0].find("its tool stands in the room (#TCP)") != std::string::npos)
        << moves;
    return program.left_alone;
  };
  EXPECT_EQ(left_alone("SLIN " + point + form("FP1")), 1);
  EXPECT_EQ(left_alone("SLIN " + point + form("FP2")), 0);
  EXPECT_EQ(left_alone("SLIN " + point + " WITH $TOOL=STOOL2(FP1)\n"), 1);
  EXPECT_EQ(left_alone("LIN " + point + " WITH $IPO_MODE=#TCP\n"), 1);
  EXPECT_EQ(left_alone("SLIN " + point + " WITH $VEL.CP=0.1, $IPO_MODE = #tcp\n"), 1);
  EXPECT_EQ(left_alone("SPLINE WITH $IPO_MODE=#TCP\nSPL " + point + "\nENDSPLINE\n" + kWhole), 1);
  EXPECT_EQ(left_alone("$IPO_MODE=#TCP\nSLIN " + point + " WITH $IPO_MODE=#BASE\n"), 0);
}

// The name of $BASE with which the first move of one of two programs runs; `?` if it is left alone.
std::string base_of(const std::string& path, const std::vector<ProgramText>& project) {
  const Dialect& krl = *find_dialect("krl");
  const auto text = std::ranges::find(project, path, &ProgramText::name);
  const RobotProgram program =
      parse_program(krl, {*text}, {}, TargetParts::pose, TextsOfOthers(krl, project).of(path),
                    neighbours_in(krl, project, {})[path]);
  const ProgramTarget& target = program.targets[0];
  return target.kind == TargetKind::joints ? "?"
         : target.base < 0                 ? ""
                                           : program.frames[target.base].name;
}

// Behind the move that is asked for one to joint angles, which is never left alone.
const std::string kEnd = "PTP {A1 1,A2 -90,A3 90,A4 0,A5 45,A6 0}\nEND\n";
const std::string kCaller = "DEF a()\n$TOOL=$NULLFRAME\n$BASE=BASE_DATA[1]\n";

std::string base_of_called(const std::string& caller, const std::string& more = "",
                           const std::string& called = "DEF b()\n" + kWhole) {
  return base_of("b.src", {{"a.src", caller + "END\n"}, {"b.src", called + kEnd}, {"c.src", more}});
}

TEST(KrlFlowTest, AProgramBeginsWithTheFramesOfItsCallers) {
  EXPECT_EQ(base_of_called(kCaller + "b()\n"), "BASE_DATA[1]");
  EXPECT_EQ(base_of_called(kCaller + "b()\nb ( )\n"), "BASE_DATA[1]");
  EXPECT_EQ(base_of_called("DEF a()\n"), "");
  EXPECT_EQ(base_of_called(kCaller + "b()\n$BASE=BASE_DATA[2]\nb()\n"), "?");
  EXPECT_EQ(base_of_called(kCaller + "b()\n", "DEF c()\nb()\nEND\n"), "?");
  // A function in an expression, an interrupt, a name of two programs, calls in a ring.
  EXPECT_EQ(base_of_called(kCaller + "x=1+b(2)\n"), "BASE_DATA[1]");
  EXPECT_EQ(base_of_called(kCaller + "b()\n",
                           "DEF c()\nGLOBAL INTERRUPT DECL 3 WHEN $IN[1] DO b()\nEND\n"),
            "?");
  EXPECT_EQ(base_of_called(kCaller + "b()\n", "DEF b()\nEND\n"), "?");
  EXPECT_EQ(
      base_of_called("DEF a()\nb()\n", "", "DEF b()\n" + kWhole + "IF $IN[1] THEN\na()\nENDIF\n"),
      "?");
  const std::string initial = "DEF b()\nBAS(#INITMOV,0)\n" + kWhole;
  EXPECT_EQ(base_of_called(kCaller + "b()\n", "", initial), "BASE_DATA[0]");
  EXPECT_EQ(base_of_called("DEF a()\nb()\n", "", initial), "");
  // What is calculated is another frame at each call.
  EXPECT_EQ(base_of_called("DEF a()\n$TOOL=$NULLFRAME\n$BASE=BASE_DATA[n]\nb()\n"), "?");
  // A local routine of the caller has the name.
  EXPECT_EQ(base_of_called(kCaller + "b()\nEND\nDEF b()\n"), "");
}

TEST(KrlFlowTest, CallersAreNamedWhereTheFramesAreTheirs) {
  const auto warnings = [](const std::string& own) {
    const Dialect& krl = *find_dialect("krl");
    const std::vector<ProgramText> project{{"a.src", kCaller + "b()\nEND\n"},
                                           {"b.src", "DEF b()\n" + own + kWhole + kEnd}};
    return parse_program(krl, {project[1]}, {}, TargetParts::pose,
                         TextsOfOthers(krl, project).of("b.src"),
                         neighbours_in(krl, project, {})["b.src"])
        .warnings;
  };
  EXPECT_THAT(warnings(""), Contains(HasSubstr("b.src:2: $BASE and $TOOL are those with which")));
  EXPECT_THAT(warnings("$TOOL=$NULLFRAME\n"), Contains(HasSubstr("are those with which")));
  EXPECT_THAT(warnings("$TOOL=$NULLFRAME\n$BASE=BASE_DATA[1]\n"), IsEmpty());
  const std::string branch = "$TOOL=$NULLFRAME\nIF $IN[1] THEN\n$BASE=BASE_DATA[1]\n";
  EXPECT_THAT(warnings(branch + "ENDIF\n"), Contains(HasSubstr("are those with which")));
  EXPECT_THAT(warnings(branch + "ELSE\n$BASE=BASE_DATA[1]\nENDIF\n"), IsEmpty());
}

std::string base_behind(const std::string& call, const std::string& called) {
  const std::string text = "DEF a()\n$TOOL=$NULLFRAME\n$BASE=BASE_DATA[1]\n";
  const Dialect& krl = *find_dialect("krl");
  const std::vector<ProgramText> project{{"a.src", text + call + "\n" + kWhole + kEnd},
                                         {"b.src", called}};
  const RobotProgram program = parse_program(krl, {project[0]}, {}, TargetParts::pose,
                                             TextsOfOthers(krl, project).of("a.src"),
                                             neighbours_in(krl, project, {})["a.src"]);
  const ProgramTarget& target = program.targets[0];
  return target.kind == TargetKind::joints ? "?" : program.frames[target.base].name;
}

// BAS(#TOOL,1) is TOOL_DATA[1], though the program does not name it.
TEST(KrlFlowTest, ANumberedToolThatAnotherProgramSetsIsNotKnown) {
  const auto is_known = [](const std::string& other) {
    const Dialect& krl = *find_dialect("krl");
    const std::string frame = "{X 0,Y 0,Z 100,A 0,B 0,C 0}";
    const std::vector<ProgramText> project{
        {"a.src", "DEF a()\nBAS(#TOOL,1)\nBAS(#BASE,0)\nPTP " + frame + "\nEND\n"},
        {"$config.dat",
         "DEFDAT $CONFIG\nDECL FRAME TOOL_DATA[16]\nTOOL_DATA[1]=" + frame + "\nENDDAT\n"},
        {"b.src", "DEF b()\n" + other + "\nEND\n"}};
    const RobotProgram program = parse_program(krl, {project[0]}, {}, TargetParts::pose,
                                               TextsOfOthers(krl, project).of("a.src"),
                                               neighbours_in(krl, project, {})["a.src"]);
    return program.frames.at(program.targets.at(0).tool).is_known;
  };
  EXPECT_TRUE(is_known("x=1"));
  EXPECT_FALSE(is_known("TOOL_DATA[1].Z=120"));
}

TEST(KrlFlowTest, AProgramGoesOnWithTheFramesThatACalledOneLeaves) {
  EXPECT_EQ(base_behind("b()", "DEF b()\nEND\n"), "BASE_DATA[1]");
  EXPECT_EQ(base_behind("b()", "DEF b()\n$BASE=BASE_DATA[2]\nEND\n"), "BASE_DATA[2]");
  EXPECT_EQ(base_behind("b()", "DEF b()\nIF $IN[1] THEN\n$BASE=BASE_DATA[2]\nENDIF\nEND\n"), "?");
  EXPECT_EQ(base_behind("b()", "DEF b()\nIF $IN[1] THEN\nRETURN\nENDIF\n$BASE=BASE_DATA[2]\nEND\n"),
            "?");
  EXPECT_EQ(base_behind("b()", "DEF b(n:IN)\n$BASE=BASE_DATA[n]\nEND\n"), "?");
  EXPECT_EQ(base_behind("x=b()", "DEFFCT INT b()\n$BASE=BASE_DATA[2]\nRETURN 1\nENDFCT\n"), "?");
  EXPECT_EQ(base_behind("x=b()", "DEFFCT INT b()\nRETURN 1\nENDFCT\n"), "BASE_DATA[1]");
  // BAS takes the FDAT that the other program has set.
  const std::string fdat = "FDAT_ACT={TOOL_NO 1,BASE_NO 2}\nBAS(#FRAMES)\n";
  EXPECT_EQ(base_behind("FDAT_ACT={TOOL_NO 1,BASE_NO 3}\nBAS(#FRAMES)\nb()\nBAS(#CP_PARAMS,1)",
                        "DEF b()\n" + fdat + "END\n"),
            "BASE_DATA[2]");
  // Another routine of it, and one that its own routine calls.
  EXPECT_EQ(
      base_behind("g()",
                  "DEF b()\nEND\nGLOBAL DEF g()\nl()\nEND\nDEF l()\n$BASE=BASE_DATA[2]\nEND\n"),
      "BASE_DATA[2]");
}

// Whether a move to a global point is known, which this program and another one set.
bool is_shared_point_known(const std::string& text, const std::string& other,
                           const std::string& submit = "DEF s()\nEND\n") {
  const Dialect& krl = *find_dialect("krl");
  const std::string point = "{X 1,Y 2,Z 3,A 0,B 0,C 0}\n";
  const std::vector<ProgramText> project{{"a.src", "DEF a()\n" + kWhole + text + kEnd},
                                         {"b.src", other},
                                         {"p.dat", "DEFDAT p PUBLIC\nDECL GLOBAL FRAME c=" + point +
                                                       "DECL GLOBAL FRAME g=" + point + "ENDDAT\n"},
                                         {"s.sub", submit},
                                         {"d.src", "DEF d()\nx=1\nEND\n"}};
  const RobotProgram program = parse_program(krl, {project[0]}, {}, TargetParts::pose,
                                             TextsOfOthers(krl, project).of("a.src"),
                                             neighbours_in(krl, project, {})["a.src"]);
  return program.left_alone == 0;
}

TEST(KrlFlowTest, AGlobalPointThatSeveralProgramsSetIsKnownUntilOneOfThemMayRun) {
  const std::string other = "DEF b()\ng=c\nEND\n";
  EXPECT_TRUE(is_shared_point_known("g=c\nLIN g\n", other));
  EXPECT_TRUE(is_shared_point_known("b()\ng=c\nd()\nLIN g\n", other));
  EXPECT_FALSE(is_shared_point_known("LIN g\ng=c\n", other));
  EXPECT_FALSE(is_shared_point_known("g=c\nb()\nLIN g\n", other));
  EXPECT_FALSE(is_shared_point_known("g=c\nx=1+b()\nLIN g\n", other));
  EXPECT_FALSE(is_shared_point_known("g=c\nl()\nLIN g\nEND\nDEF l()\nb()\n", other));
  EXPECT_FALSE(is_shared_point_known("g=c\nLIN g\n", other, "DEF s()\nb()\nEND\n"));
  EXPECT_FALSE(is_shared_point_known("g=c\nLIN g\n", other, "DEF s()\ng=c\nEND\n"));
  EXPECT_FALSE(
      is_shared_point_known("g=c\nTRIGGER WHEN PATH=0 DELAY=0 DO b() PRIO=-1\nLIN g\n", other));
}

}  // namespace
}  // namespace armtrue::krl_flow_test
