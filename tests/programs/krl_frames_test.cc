#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/programs/program_project.h"
#include "armtrue/programs/robot_program.h"

// Which $BASE and $TOOL hold where a program gives them several values.

namespace armtrue::krl_frames_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kHead = "DEF p()\n$BASE=BASE_DATA[1]\n$TOOL=TOOL_DATA[1]\n";
// A move to joint angles is never left alone.
const std::string kJoints = kHead + "PTP {A1 1,A2 -90,A3 90,A4 0,A5 45,A6 0}\n";
const std::string kLine = "LIN {X 1,Y 2,Z 3,A 0,B 90,C 0}\n";
const std::string kTwo =
    "DECL FDAT FP={TOOL_NO 1,BASE_NO 1,IPO_FRAME #BASE}\n"
    "DECL FDAT FG={TOOL_NO 2,BASE_NO 2,IPO_FRAME #BASE}\n";

Pose at(double x, double y, double z, double a = 0) {
  return {rotation_from_abc(a * kDegree, 0, 0), Eigen::Vector3d(x, y, z) * kMillimetre};
}

RobotProgram parsed(const std::string& moves, const std::string& dat = "",
                    const std::vector<ProgramText>& others = {}) {
  const KnownFrames known{{"BASE_DATA[1]", at(10, 0, 0, 90)},
                          {"BASE_DATA[2]", at(20, 0, 0)},
                          {"TOOL_DATA[1]", at(0, 0, 1)},
                          {"TOOL_DATA[2]", at(0, 0, 2)}};
  return parse_program(*find_dialect("krl"), {{"p.src", kJoints + moves}, {"p.dat", dat}}, known,
                       TargetParts::pose, others);
}

// Of each move that is not left alone the position of $BASE, and Z of $TOOL [mm].
std::vector<std::string> frames(const RobotProgram& program) {
  std::vector<std::string> result;
  for (const ProgramTarget& target : program.targets) {
    if (target.kind == TargetKind::joints) continue;
    const Eigen::Vector3d base = program.frames[target.base].pose.translation / kMillimetre;
    result.push_back(fmt::format("{:.3g} {:.3g} {:.3g}, {:.3g}", base[0], base[1], base[2],
                                 program.frames[target.tool].pose.translation[2] / kMillimetre));
  }
  return result;
}

std::vector<std::string> frames(const std::string& moves, const std::string& dat = "") {
  return frames(parsed(moves, dat));
}

TEST(KrlFramesTest, AnFdatHasTheValueThatTheTextGivesIt) {
  const std::string use = "FDAT_ACT=FP\nBAS(#CP_PARAMS,0.5)\n" + kLine;
  const auto last = [&](const std::string& moves) { return frames(moves + use, kTwo); };
  EXPECT_THAT(last(""), ElementsAre("10 0 0, 1"));
  EXPECT_THAT(last("FP.BASE_NO=2\n"), ElementsAre("20 0 0, 1"));
  EXPECT_THAT(last("FP.TOOL_NO=1+1\n"), ElementsAre("10 0 0, 2"));
  EXPECT_THAT(last("FP=FG\n"), ElementsAre("20 0 0, 2"));
  EXPECT_THAT(last("FP={TOOL_NO 2,BASE_NO 1,IPO_FRAME #BASE}\n"), ElementsAre("10 0 0, 2"));
  EXPECT_THAT(last("FP=FG\nFP.BASE_NO=FP.TOOL_NO-1\n"), ElementsAre("10 0 0, 2"));
  // What the last run left, of several values, of a value that comes as it runs.
  EXPECT_THAT(last(use + "FP.BASE_NO=2\n"), ElementsAre("20 0 0, 1"));
  EXPECT_THAT(last("IF $IN[1] THEN\nFP.BASE_NO=2\nENDIF\n"), ElementsAre());
  EXPECT_THAT(last("FP.BASE_NO=n\n"), ElementsAre());
  EXPECT_THAT(last("change(FP)\n"), ElementsAre());
  EXPECT_THAT(parsed("FP.BASE_NO=n\n" + use, kTwo).warnings,
              ElementsAre(HasSubstr("p.src:8: left alone: its frame is calculated as the program "
                                    "runs: 'BASE_DATA[FP.BASE_NO]'")));
}

TEST(KrlFramesTest, AnFdatIsReadWhereItIsUsed) {
  const auto last = [&](const std::string& moves) { return frames(moves, kTwo); };
  EXPECT_THAT(last("FP.TOOL_NO=2\nSLIN {X 1,Y 2,Z 3,A 0,B 90,C 0} WITH $TOOL=STOOL2(FP), "
                   "$BASE=SBASE(FP)\n"),
              ElementsAre("10 0 0, 2"));
  // FDAT_ACT takes the value that it has there.
  EXPECT_THAT(last("FDAT_ACT=FG\nFG.BASE_NO=1\nBAS(#CP_PARAMS,0.5)\n" + kLine), ElementsAre());
  EXPECT_THAT(last("FG.BASE_NO=2\nFDAT_ACT=FG\nFG.BASE_NO=1\nBAS(#CP_PARAMS,0.5)\n" + kLine),
              ElementsAre("20 0 0, 2"));
  EXPECT_EQ(
      parsed("FP.IPO_FRAME=#TCP\n$IPO_MODE=SIPOMODE(FP.IPO_FRAME)\n" + kLine, kTwo).left_alone, 1);
  // What another program may set of a shared one.
  const std::string use = "FDAT_ACT=FS\nBAS(#CP_PARAMS,0.5)\n" + kLine;
  const ProgramText list{"$config.dat",
                         "DEFDAT $CONFIG\nDECL FDAT FS={TOOL_NO 2,BASE_NO 2}\nENDDAT\n"};
  EXPECT_THAT(frames(parsed(use, "", {list})), ElementsAre("20 0 0, 2"));
  EXPECT_THAT(frames(parsed(use, "", {list, {"q.src", "DEF q()\nFS.BASE_NO=1\nEND\n"}})),
              ElementsAre());
}

TEST(KrlFramesTest, AFrameIsFollowedFromTheOneBefore) {
  EXPECT_THAT(frames("$BASE=$BASE:{X 5,Y 0,Z 0,A 0,B 0,C 0}\n" + kLine), ElementsAre("10 5 0, 1"));
  EXPECT_THAT(frames("$BASE.Z=$BASE.Z+15\n" + kLine + "$BASE.Z=$BASE.Z-5\n$TOOL.Z=7\n" + kLine),
              ElementsAre("10 0 15, 1", "10 0 10, 7"));
  EXPECT_THAT(
      frames("n=2\nBAS(#BASE,n)\n" + kLine + "$BASE=BASE_DATA[n-1]\n" + kLine, "DECL INT n=1\n"),
      ElementsAre("20 0 0, 1", "10 0 0, 1"));
  EXPECT_THAT(frames("f={X 1,Y 0,Z 0,A 0,B 0,C 0}\n$BASE=f\n" + kLine + "f.X=2\n$BASE=f\n" + kLine,
                     "DECL FRAME f\n"),
              ElementsAre("1 0 0, 1", "2 0 0, 1"));
}

TEST(KrlFramesTest, OnlyMovesInACalculatedFrameAreLeft) {
  const std::string reset = "$BASE=BASE_DATA[2]\n" + kLine;
  for (const std::string calculated :
       {"$BASE=$BASE:f(1)", "$BASE.Z=h", "$BASE.Z=$BASE.Z*2", "$BASE.Q=1", "BAS(#BASE,n)",
        "$BASE=BASE_DATA[n]", "$BASE=g(1)", "$BASE={X h,Y 0,Z 0,A 0,B 0,C 0}"}) {
    const RobotProgram program = parsed(calculated + "\n" + kLine + reset);
    EXPECT_THAT(frames(program), ElementsAre("20 0 0, 1")) << calculated;
    EXPECT_EQ(program.left_alone, 1) << calculated;
  }
  // A loop displaces it further at each turn.
  EXPECT_THAT(frames("LOOP\n$BASE.Z=$BASE.Z+15\n" + kLine + "ENDLOOP\n"), ElementsAre());
  EXPECT_THAT(frames("LOOP\n$BASE=BASE_DATA[2]\n$BASE.Z=$BASE.Z+15\n" + kLine + "ENDLOOP\n"),
              ElementsAre("20 0 15, 1"));
  // A frame that is given is as it is given.
  const RobotProgram given =
      parse_program(*find_dialect("krl"), {{"p.src", kHead + "$BASE.Z=h\n" + kLine}},
                    {{"$BASE.Z=h", at(1, 2, 3)}, {"TOOL_DATA[1]", at(0, 0, 4)}});
  EXPECT_THAT(frames(given), ElementsAre("1 2 3, 4"));
}

TEST(KrlFramesTest, WhatAnInterruptSetsHoldsAnywhereBehindIt) {
  const std::string decl = "INTERRUPT DECL 5 WHEN $IN[9] DO ir()\n",
                    trigger = "TRIGGER WHEN DISTANCE=0 DELAY=0 DO ir() PRIO=-1\n";
  const auto with = [](const std::string& moves, const std::string& routine) {
    return frames(kLine + moves + kLine + "END\nDEF ir()\n" + routine + "END\n" +
                  "DEF set()\nBAS(#BASE,2)\nEND\n");
  };
  for (const std::string& start : {decl, trigger}) {
    EXPECT_THAT(with(start, "$OUT[1]=TRUE\n"), ElementsAre("10 0 0, 1", "10 0 0, 1"));
    for (const std::string set : {"$BASE=BASE_DATA[2]\n", "$TOOL.Z=$TOOL.Z+5\n", "BAS(#TOOL,2)\n",
                                  "set()\n", "FDAT_ACT={TOOL_NO 2,BASE_NO 2}\nBAS(#FRAMES)\n"})
      EXPECT_THAT(with(start, set), ElementsAre("10 0 0, 1")) << start << set;
  }
  // It may come between; a move that states them itself has them.
  EXPECT_THAT(with(decl + "$BASE=BASE_DATA[2]\n", "$BASE=BASE_DATA[1]\n"),
              ElementsAre("10 0 0, 1"));
  const std::string stated = "SLIN {X 1,Y 2,Z 3,A 0,B 90,C 0} WITH $BASE=BASE_DATA[2]\n";
  EXPECT_THAT(with(decl + stated, "$BASE=BASE_DATA[1]\n"), ElementsAre("10 0 0, 1", "20 0 0, 1"));
  // Its own moves have what it sets.
  EXPECT_THAT(with(decl, "BAS(#BASE,2)\nBAS(#TOOL,2)\n" + kLine),
              ElementsAre("10 0 0, 1", "20 0 0, 2"));
  EXPECT_THAT(parsed(decl + kLine + "END\nDEF ir()\nBAS(#BASE,2)\nEND\n").warnings,
              ElementsAre(HasSubstr("p.src:6: left alone: it may run with several $BASE, $TOOL or "
                                    "$IPO_MODE: an INTERRUPT or TRIGGER before it calls IR")));
}

TEST(KrlFramesTest, AnInterruptMayCallAnotherProgram) {
  const Dialect& krl = *find_dialect("krl");
  const auto moves = [&](const std::string& routine) {
    const std::vector<ProgramText> project{
        {"p.src", kJoints + "INTERRUPT DECL 5 WHEN $IN[9] DO ir()\n" + kLine},
        {"ir.src", "DEF ir()\n" + routine + "END\n"}};
    return parse_program(krl, {project[0]}, {}, TargetParts::pose,
                         TextsOfOthers(krl, project).of("p.src"),
                         neighbours_in(krl, project, {})["p.src"])
        .targets.size();
  };
  EXPECT_EQ(moves("$OUT[1]=TRUE\n"), 2u);
  EXPECT_EQ(moves("BAS(#BASE,2)\n"), 1u);
}

// A FRAME that an E6POS is given leaves its S, T and external axes as they are.
TEST(KrlFramesTest, APositionMayBeAProduct) {
  const auto z = [](const std::string& moves, const std::string& point) {
    std::vector<int> result;
    for (const ProgramTarget& target :
         parsed(moves, "DECL E6POS XP={X 1,Y 2,Z 3,A 0,B 90,C 0" + point + "}\nDECL E6POS XA\n")
             .targets)
      if (target.kind == TargetKind::cartesian)
        result.push_back(static_cast<int>(std::lround(target.pose.translation[2] / kMillimetre)));
    return result;
  };
  const std::string product = "XA=XP:{X -10,Y 0,Z 0,A 0,B 0,C 0}\n";
  EXPECT_THAT(z(product + "LIN XA\n", ",S 2,T 34"), ElementsAre(13));
  // PTP goes by S and T, which it may keep from before.
  EXPECT_THAT(z(product + "PTP XA\nXA=XP\n", ",S 2,T 34"), ElementsAre());
  // What the last run left of external axes counts only where some are stated.
  const std::string place = "XA=XP\nXA.Z=XA.Z+5\nLIN XA\nXA=$POS_ACT\n";
  EXPECT_THAT(z(place, ",S 2,T 34"), ElementsAre(8));
  EXPECT_THAT(z(product + "LIN XA\nXA=$POS_ACT\n", ",S 2,T 34,E1 5"), ElementsAre());
}

}  // namespace
}  // namespace armtrue::krl_frames_test
