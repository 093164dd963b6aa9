#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/programs/robot_program.h"
#include "armtrue/text/input_error.h"

namespace armtrue::inserted_point_test {
namespace {

using testing::HasSubstr;

RobotProgram parsed(const std::string& name, const std::string& text, const std::string& dat = "") {
  std::vector<ProgramText> texts{{name, text}};
  if (!dat.empty()) texts.push_back({"p.dat", dat});
  return parse_program(*dialect_of_file(name), texts, {});
}

// The targets themselves, as commands.
std::vector<ProgramCommand> commands_for(const RobotProgram& program) {
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : program.targets)
    commands.push_back({true, target.q, target.q, target.pose});
  return commands;
}

// A program of one move to a start and one straight move, whose commands are the targets
// themselves, and one point half-way.
RewrittenProgram with_half_way(const RobotProgram& program, size_t end, double blend = 2e-3) {
  std::vector<ProgramCommand> commands = commands_for(program);
  ProgramPointBetween point{end, program.targets[end].pose, {}, blend};
  JointVector q = JointVector::Zero(kProgramAxes);
  q[3] = -100 * kDegree;
  q[5] = 200 * kDegree;
  point.q = q;
  point.pose.translation += Eigen::Vector3d(-0.1, 0, 0);
  return rewrite(program, commands, {point});
}

TEST(InsertedPointTest, KrlHasAFrameAndTheWordsOfTheMoveAndDoesNotStop) {
  const std::string head =
      "DEF p()\r\n$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}\r\n$TOOL={X 0,Y 0,Z 0,A 0,B 0,C 0}\r\n"
      "PTP {X 1000,Y 0,Z 900,A 0,B 90,C 0,S 2,T 2}\r\n";
  const std::string dat =
      "DEFDAT p\r\nDECL E6POS XP1={X 1200.0,Y 10.0,Z 900.0,A 1.0,B 80.0,C 2.0}\r\n";
  const RobotProgram program =
      parsed("p.src", head + "  LIN XP1 ; to the part\r\nSLIN XP1 WITH $VEL.CP=0.1\r\n", dat);
  const RewrittenProgram first = with_half_way(program, 1), second = with_half_way(program, 2);
  EXPECT_EQ(first.inserted, 1);
  EXPECT_THAT(first.texts[0],
              HasSubstr("\r\n  LIN {X 1100.0,Y 10.0,Z 900.0,A 1.0,B 80.0,C 2.0} C_DIS\r\n"
                        "  LIN XP1 ; to the part\r\n"));
  EXPECT_THAT(second.texts[0], HasSubstr("SLIN {X 1100.0,Y 10.0,Z 900.0,A 1.0,B 80.0,C 2.0} WITH "
                                         "$VEL.CP=0.1 C_SPL\r\nSLIN XP1 WITH $VEL.CP=0.1\r\n"));
  EXPECT_EQ(first.texts[1], dat);
}

// What a frame leaves out comes from the point before.
TEST(InsertedPointTest, KrlFramesAreCompletedWhereTheInsertedPointIsElsewhere) {
  const RobotProgram program = parsed(
      "p.src",
      "DEF p()\n$TOOL={X 0,Y 0,Z 0,A 0,B 0,C 0}\nPTP {X 1000,Y 0,Z 900,A 0,B 90,C 0,S 2,T 2}\n"
      "LIN {X 1200}\nEND\n");
  EXPECT_THAT(with_half_way(program, 1).texts[0], HasSubstr("LIN {X 1100} C_DIS\nLIN {X 1200}\n"));
  ProgramPointBetween point{1, program.targets[1].pose, {}, 1e-3};
  point.pose.translation += Eigen::Vector3d(-0.1, 0, 1e-3);
  EXPECT_THAT(rewrite(program, commands_for(program), {point}).texts[0],
              HasSubstr("LIN {X 1100,Z 901} C_DIS\nLIN {X 1200,Z 900}\n"));
}

// On the branch and at the place that the point between has; in CONFIG and confdata so, too.
TEST(InsertedPointTest, KrlHasTheTurnOfItsJointsAndItsExternalAxes) {
  const RobotProgram program =
      parsed("p.src",
             "LIN {X 1000,Y 0,Z 900,A 0,B 90,C 0,E1 100,E2 5}\n"
             "LIN {X 1200,Y 0,Z 900,A 0,B 90,C 0,S 2,T 2,E1 300.0,E2 5}\n");
  EXPECT_THAT(program.targets[1].obstacle, "");
  ProgramPointBetween point{1, program.targets[1].pose, {}, 1e-3};
  point.q = JointVector::Zero(kProgramAxes);
  (*point.q)[3] = -1;
  point.external = {150.06, 5};
  EXPECT_THAT(rewrite(program, commands_for(program), {point}).texts[0],
              HasSubstr("LIN {X 1200,Y 0,Z 900,A 0,B 90,C 0,S 2,T 8,E1 150.06,E2 5} C_DIS\n"
                        "LIN {X 1200,Y 0,Z 900,A 0,B 90,C 0,S 2,T 2,E1 300.0,E2 5}\n"));
}

TEST(InsertedPointTest, RapidHasConfdataOfItsJointsAndAZone) {
  const std::string ext = "[9E9,9E9,9E9,9E9,9E9,9E9]";
  const RobotProgram program = parsed(
      "p.mod",
      "MODULE p\nCONST robtarget a:=[[900,0,900],[0,0,1,0],[0,0,0,1]," + ext +
          "];\nCONST robtarget b:=[[1200,0,900],[0,0,1,0],[0,0,0,1]," + ext +
          "];\nPROC main()\nMoveJ a,v100,fine,tool0;\n  MoveL b,v100\\V:=200,fine\\Inpos:=inpos50,"
          "tool0\\WObj:=wobj0;\n  MoveLDO a, v100, z10, tool0, do1, 1;\nENDPROC\nENDMODULE\n");
  EXPECT_THAT(with_half_way(program, 1).texts[0],
              HasSubstr("fine,tool0;\n  MoveL [[1100,0,900],[0,0,1,0],[0,-2,2,1]," + ext +
                        "],v100\\V:=200,z1,tool0\\WObj:=wobj0;\n  MoveL b,"));
  // The output is set at the end of the move alone.
  EXPECT_THAT(with_half_way(program, 2).texts[0],
              HasSubstr("  MoveL [[800,0,900],[0,0,1,0],[0,-2,2,1]," + ext +
                        "], v100, z10, tool0;\n  MoveLDO a,"));
  EXPECT_EQ(program.targets[2].blend, 0.01);
}

TEST(InsertedPointTest, ZonesOfRapidAreThoseThatAreDeclaredOnce) {
  const auto zone_of = [](const std::string& zone) {
    const std::string wide = "[FALSE,12,18,18,1.8,18,1.8]";
    return parsed("p.mod", "MODULE p\nCONST zonedata wide:=" + wide +
                               ";\nVAR zonedata open:=" + wide +
                               ";\nCONST zonedata still:=[TRUE,12,18,18,1.8,18,1.8];\nPROC main()\n"
                               "open:=wide;\nMoveL [[800,0,900],[0,0,1,0],[0,0,0,1],"
                               "[9E9,9E9,9E9,9E9,9E9,9E9]],v100," +
                               zone + ",tool0;\nENDPROC\nENDMODULE\n")
               .targets[0]
               .blend /
           kMillimetre;
  };
  EXPECT_EQ(zone_of("z20"), 20);
  EXPECT_EQ(zone_of("wide"), 12);
  EXPECT_EQ(zone_of("[FALSE,7,9,9,1,9,1]"), 7);
  for (const char* const unknown : {"fine", "open", "still", "elsewhere"})
    EXPECT_EQ(zone_of(unknown), 0) << unknown;
}

// Joint angles that the controller calculates from a point are that point; with another tool or
// frame than those of the move they are not followed.
TEST(InsertedPointTest, CalculatedJointsOfRapidAreTheirPoint) {
  const auto moves = [](const std::string& joints) {
    return parsed("p.mod",
                  "MODULE p\nCONST robtarget "
                  "p1:=[[800,0,900],[0,0,1,0],[0,0,0,1],[9E9,9E9,9E9,9E9,9E9,"
                  "9E9]];\nPROC main()\nConfJ\\Off;\nConfL\\Off;\nMoveJ "
                  "RelTool(p1,0,50,0),v100,fine,tool0;\nMoveAbsJ " +
                      joints + ",v100,fine,tool0;\nENDPROC\nENDMODULE\n")
        .targets;
  };
  const std::vector<ProgramTarget> targets = moves("CalcJointT(RelTool(p1,0,50,0), Tool0)");
  ASSERT_EQ(targets.size(), 2);
  EXPECT_EQ(targets[1].kind, TargetKind::cartesian);
  EXPECT_EQ(targets[1].motion, MotionKind::joint);
  EXPECT_EQ(targets[1].pose.translation, targets[0].pose.translation);
  EXPECT_FALSE(targets[0].configuration.is_stated());
  EXPECT_TRUE(targets[1].configuration.is_stated());  // CalcJointT reads it
  for (const char* const other :
       {"CalcJointT(p1, tool1)", "CalcJointT(p1, tool0\\WObj:=wobj0)",
        "CalcJointT(\\UseCurWObjPos, p1, tool0)", "CalcJointT(p1)", "CalcJointT(p1, tool0)+j"})
    EXPECT_EQ(moves(other).size(), 1) << other;
}

// A routine may change what it is handed, also behind an argument that is named.
TEST(InsertedPointTest, ANamedArgumentOfRapidIsNoAssignment) {
  const auto moves = [](const std::string& call) {
    const std::string point = "[[800,0,900],[0,0,1,0],[0,0,0,1],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    return parsed("p.mod", "MODULE p\nVAR robtarget p1:=" + point + ";\nCONST robtarget p2:=" +
                               point + ";\nVAR robtarget x:=" + point + ";\nPROC main()\n" + call +
                               ";\nMoveL p1,v100,fine,tool0;\nMoveL p2,v100,fine,tool0;\n"
                               "MoveL x,v100,fine,tool0;\nENDPROC\nENDMODULE\n")
        .targets.size();
  };
  EXPECT_EQ(moves("n:=1"), 3);
  EXPECT_EQ(moves("near p1"), 2);
  EXPECT_EQ(moves("near 5, p1"), 2);
  EXPECT_EQ(moves("near n:=5, p1"), 2);
  EXPECT_EQ(moves("near 5, n:=5, p1"), 2);
  EXPECT_EQ(moves("IF a=b near n:=5, p1"), 2);
  EXPECT_EQ(moves("near x:=p2"), 3);  // the parameter is another x
  EXPECT_EQ(moves("n:=near(x:=p2)"), 3);
  for (const char* const assigned :
       {"x:=CRobT()", "IF a=b x:=p2", "IF a x:=p2", "IF NOT (a) x:=p2", "IF a THEN x:=CRobT()",
        "IF a n:=1; ELSE x:=CRobT()", "again: x:=CRobT()", "WHILE a DO x:=CRobT()"})
    EXPECT_EQ(moves(assigned), 2) << assigned;
  EXPECT_EQ(moves("x:=p2"), 3);
}

TEST(InsertedPointTest, UrscriptHasARadiusAndNoTime) {
  const RobotProgram program =
      parsed("p.script",
             "def p():\n  set_tcp(p[0,0,0,0,0,0])\n  q = p[0.5,0,0.5,0,3.14,0]\n"
             "  movej([0,-1,1,0,1,0])\n  movel(q, a=1.2, v=0.25, r=0.05) # end\n"
             "  movel(pose_trans(p[0,0,0.1,0,0,0], q), 1.2, 0.1, 0, 0.02)\nend\n");
  EXPECT_THAT(with_half_way(program, 1).texts[0],
              HasSubstr("  movel(p[0.4,0,0.5,0,3.14,0], a=1.2, v=0.25, r=0.002)\n  movel(q, a"));
  EXPECT_THAT(with_half_way(program, 2).texts[0],
              HasSubstr("  movel(pose_trans(p[0,0,0.1,0,0,0], p[0.4,0,0.5,0,3.14,0]), 1.2, 0.1, "
                        "r=0.002)\n  movel(pose_trans("));
  EXPECT_EQ(program.targets[1].blend, 0.05);
}

std::string fanuc_position(int number, const std::string& x) {
  return "P[" + std::to_string(number) +
         ":\"a P[9]\"]{\n   GP1:\n\tUF : 0, UT : 0,\tCONFIG : 'N U T, 0, 0, "
         "0',\n\tX =  " +
         x +
         "  mm,\tY =     0.000  mm,\tZ =   900.000  mm,\n\tW =   180.000 deg,\tP =   "
         "  0.000 deg,\tR =     0.000 deg\n};\n";
}

TEST(InsertedPointTest, FanucHasANewPositionAndNewNumbersOfLines) {
  const RobotProgram program = parsed(
      "p.ls",
      "/PROG P\n/ATTR\nLINE_COUNT\t= 3;\n/MN\n   1:J P[1] 100% FINE    ;\n   2:  DO[1]=ON ;\n"
      "   3:L P[2:a] 250mm/sec FINE ACC50    ;\n   4:  ;\n/POS\n" +
          fanuc_position(1, "1000.000") + fanuc_position(2, "1200.000") + "/END\n");
  const std::string text = with_half_way(program, 1).texts[0];
  EXPECT_THAT(text, HasSubstr("LINE_COUNT\t= 4;"));
  EXPECT_THAT(text, HasSubstr("   2:  DO[1]=ON ;\n   3:L P[10] 250mm/sec CNT100 ACC50    ;\n"
                              "   4:L P[2:a] 250mm/sec FINE ACC50    ;\n   5:  ;\n/POS"));
  EXPECT_THAT(text, HasSubstr(fanuc_position(2, "1200.000") +
                              "P[10]{\n   GP1:\n\tUF : 0, UT : 0,\tCONFIG : 'N U T, 0, 0, 1',\n"
                              "\tX =  1100.000  mm,\tY =     0.000"));
}

// A program of one move to a start and a circular move, in two pieces: the auxiliary points are the
// end of the move, shifted by -0.3 and -0.1 m, the end of the first piece by -0.2 m.
RewrittenProgram in_two_pieces(const RobotProgram& program, size_t end) {
  std::vector<ProgramPointBetween> between;
  for (const auto& [motion, x] :
       {std::pair(MotionKind::via, -0.3), std::pair(MotionKind::arc, -0.2),
        std::pair(MotionKind::via, -0.1)}) {
    ProgramPointBetween point{motion == MotionKind::via ? end - 1 : end, program.targets[end].pose,
                              JointVector::Zero(kProgramAxes), 2e-3, motion};
    point.pose.translation.x() += x;
    between.push_back(point);
  }
  EXPECT_EQ(moves_of(between), 1);
  const RewrittenProgram rewritten = rewrite(program, commands_for(program), between);
  EXPECT_EQ(rewritten.inserted, 1);
  return rewritten;
}

TEST(InsertedPointTest, AKrlArcBecomesArcsAndItsOwnAuxiliaryPointMoves) {
  const std::string dat =
      "DEFDAT p\nDECL E6POS XA={X 1100,Y 50,Z 900,A 0,B 90,C 0}\n"
      "DECL E6POS XB={X 1200,Y 0,Z 900,A 0,B 90,C 0}\n";
  const RobotProgram program =
      parsed("p.src",
             "DEF p()\n$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}\n$TOOL={X 0,Y 0,Z 0,A 0,B 0,C 0}\n"
             "PTP {X 1000,Y 0,Z 900,A 0,B 90,C 0,S 2,T 2}\n  CIRC XA, XB ; round\n",
             dat);
  const RewrittenProgram rewritten = in_two_pieces(program, 2);
  EXPECT_THAT(rewritten.texts[0],
              HasSubstr("\n  CIRC {X 900,Y 0,Z 900,A 0,B 90,C 0}, "
                        "{X 1000,Y 0,Z 900,A 0,B 90,C 0} C_DIS\n"
                        "  CIRC {X 1100,Y 0,Z 900,A 0,B 90,C 0}, XB ; round\n"));
  EXPECT_EQ(rewritten.texts[1], dat);
}

TEST(InsertedPointTest, ARapidArcBecomesArcs) {
  const std::string tail = ",[0,0,1,0],[0,0,0,1],[9E9,9E9,9E9,9E9,9E9,9E9]]";
  const RobotProgram program =
      parsed("p.mod", "MODULE p\nCONST robtarget a:=[[1100,50,900]" + tail +
                          ";\nPROC main()\nMoveJ [[1000,0,900]" + tail +
                          ",v100,fine,tool0;\n  MoveC a, [[1200,0,900]" + tail +
                          ",v100,fine,tool0;\nENDPROC\nENDMODULE\n");
  EXPECT_EQ(program.targets[2].turning, ArcTurning::with_path);
  const std::string written = ",[0,0,1,0],[0,0,0,1],[9E9,9E9,9E9,9E9,9E9,9E9]]";
  EXPECT_THAT(in_two_pieces(program, 2).texts[0],
              HasSubstr("\n  MoveC [[900,0,900]" + written + ", [[1000,0,900]" + written +
                        ",v100,z1,tool0;\n  MoveC [[1100,0,900]" + written + ", [[1200,0,900]" +
                        tail + ",v100,fine,tool0;\n"));
}

TEST(InsertedPointTest, AUrscriptArcBecomesArcs) {
  const RobotProgram program =
      parsed("p.script",
             "def p():\n  a = p[0.4,0.05,0.5,0,3.14,0]\n  movej([0,-1,1,0,1,0])\n"
             "  movec(a, p[0.5,0,0.5,0,3.14,0], 1.2, 0.1, 0.02, 0)\nend\n");
  EXPECT_EQ(program.targets[2].blend, 0.02);
  EXPECT_THAT(in_two_pieces(program, 2).texts[0],
              HasSubstr("  movec(p[0.2,0.00,0.5,0,3.14,0], p[0.3,0,0.5,0,3.14,0], 1.2, "
                        "0.1, r=0.002)\n  movec(p[0.4,0.00,0.5,0,3.14,0], "
                        "p[0.5,0,0.5,0,3.14,0], 1.2, 0.1, 0.02, 0)\n"));
}

TEST(InsertedPointTest, AFanucArcOfTwoLinesBecomesArcs) {
  const RobotProgram program =
      parsed("p.ls",
             "/PROG P\n/ATTR\nLINE_COUNT\t= 2;\n/MN\n   1:J P[1] 100% FINE    ;\n   2:C P[2]    \n"
             "    :  P[3] 250mm/sec FINE    ;\n/POS\n" +
                 fanuc_position(1, "1000.000") + fanuc_position(2, "1100.000") +
                 fanuc_position(3, "1200.000") + "/END\n");
  const std::string text = in_two_pieces(program, 2).texts[0];
  EXPECT_THAT(text, HasSubstr("LINE_COUNT\t= 3;"));
  EXPECT_THAT(text, HasSubstr("   2:C P[10]    \n    :  P[11] 250mm/sec CNT100    ;\n"
                              "   3:C P[12]    \n    :  P[3] 250mm/sec FINE    ;\n/POS"));
  EXPECT_THAT(text, HasSubstr("P[12]{\n   GP1:\n\tUF : 0, UT : 0,\tCONFIG : 'N U T, 0, 0, 0',\n"
                              "\tX =  1100.000  mm"));
}

// Of an arc with an end that stays as programmed, its own auxiliary point stays too.
TEST(InsertedPointTest, AnArcWithAnEndAsProgrammedIsNotDivided) {
  const RobotProgram program =
      parsed("p.script",
             "def p():\n  movej([0,-1,1,0,1,0])\n"
             "  movec(p[0.4,0.05,0.5,0,3.14,0], p[0.5,0,0.5,0,3.14,0])\nend\n");
  std::vector<ProgramCommand> commands = commands_for(program);
  commands[2].is_corrected = false;
  const JointVector zero = JointVector::Zero(kProgramAxes);
  const Pose& pose = program.targets[2].pose;
  const RewrittenProgram rewritten = rewrite(program, commands,
                                             {{1, pose, zero, 0, MotionKind::via},
                                              {2, pose, zero, 1e-3, MotionKind::arc},
                                              {1, pose, zero, 0, MotionKind::via}});
  EXPECT_EQ(rewritten.inserted, 0);
  EXPECT_EQ(rewritten.texts[0], program.texts[0].text);
}

TEST(InsertedPointTest, AFanucControllerLoadsThirtyTwoThousandLines) {
  std::string lines = "   1:J P[1] 100% FINE    ;\n";
  for (int k = 2; k <= 32000; ++k) lines += fmt::format("{:4}:L P[2] 9mm/sec FINE ;\n", k);
  const auto program = [&](const std::string& more) {
    return parsed("p.ls", "/PROG P\n/MN\n" + lines + more + "/POS\n" +
                              fanuc_position(1, "1000.000") + fanuc_position(2, "1200.000") +
                              "/END\n");
  };
  std::vector<ProgramCommand> commands(32000);
  EXPECT_EQ(rewrite(program(""), commands).changed, 0);
  EXPECT_THROW(with_half_way(program(""), 1), InputError);
  EXPECT_THROW(rewrite(program("32001:  ;\n"), commands), InputError);
}

TEST(InsertedPointTest, NoneIsInsertedWhereAnEndStaysAsProgrammed) {
  const RobotProgram program =
      parsed("p.script",
             "def p():\n  movej([0,-1,1,0,1,0])\n  movel(p[0.5,0,0.5,0,3.14,0])\n"
             "  movel(p[0.6,0,0.5,0,3.14,0])\nend\n");
  std::vector<ProgramCommand> commands = commands_for(program);
  commands[1].is_corrected = false;
  const ProgramPointBetween first{1, program.targets[1].pose, JointVector::Zero(kProgramAxes),
                                  1e-3},
      second{2, program.targets[2].pose, JointVector::Zero(kProgramAxes), 1e-3};
  const RewrittenProgram rewritten = rewrite(program, commands, {first, second});
  EXPECT_EQ(rewritten.inserted, 0);
  EXPECT_EQ(rewritten.texts[0], program.texts[0].text);
}

// Arcs whose tool turns in a way that the end does not state, or that end elsewhere.
TEST(InsertedPointTest, ArcsThatAreNotFollowedAreNamed) {
  const auto obstacle = [](const std::string& name, const std::string& text) {
    const ProgramTarget end = parsed(name, text).targets.back();
    EXPECT_EQ(end.motion, MotionKind::arc);
    EXPECT_FALSE(end.follows_target) << text;
    return end.obstacle;
  };
  const std::string f = "{X 1,Y 2,Z 3,A 4,B 5,C 6}";
  EXPECT_EQ(obstacle("p.src", "PTP " + f + "\nCIRC " + f + "," + f + ",CA 180"),
            "its angle says where it ends");
  EXPECT_EQ(obstacle("p.src", "PTP " + f + "\n$circ_type = #PATH\nCIRC " + f + "," + f),
            "$CIRC_TYPE is #PATH in this program");
  EXPECT_EQ(
      obstacle("p.script", "movej([0,-1,1,0,1,0])\nmovec(p[1,0,0,0,0,0],p[1,1,0,0,0,0],mode=1)"),
      "its tool turns with the arc (mode)");
  EXPECT_EQ(
      obstacle("p.ls", "/PROG P\n/MN\n 1:A P[1] 9mm/sec FINE;\n 2:A P[1] 9mm/sec FINE;\n/POS\n" +
                           fanuc_position(1, "1.000") + "/END\n"),
      "");
  const std::string t = "[[1,0,0],[1,0,0,0],[0,0,0,0],[0,0,0,0,0,0]]";
  const auto turning = [&](const std::string& mode) {
    return parsed("p.mod", "CirPathMode" + mode + ";\nMoveC " + t + "," + t + ",v1,z1,tool0;")
        .targets.back()
        .turning;
  };
  EXPECT_EQ(turning(""), ArcTurning::with_path);
  EXPECT_EQ(turning("\\PathFrame"), ArcTurning::with_path);
  EXPECT_EQ(turning("\\ObjectFrame"), ArcTurning::in_frame);
  EXPECT_EQ(turning("\\CirPointOri"), ArcTurning::perhaps_through_via);
}

// Lines of moves (1 to 9) that do not come from the target before in any case; `X` cannot be
// divided.
TEST(InsertedPointTest, TheArmComesFromTheTargetBeforeUnlessSomethingStandsBetween) {
  const auto unknown_lines = [](const std::string& name, const std::string& text) {
    std::string lines;
    for (const ProgramTarget& target : parsed(name, text).targets) {
      if (!target.follows_target) lines += std::to_string(target.line);
      if (!target.obstacle.empty()) lines += "X";
    }
    return lines;
  };
  const std::string f = "{X 1,Y 2,Z 3,A 4,B 5,C 6}";
  EXPECT_EQ(unknown_lines("p.src", "DEF p()\nLIN " + f + "\n$VEL.CP=1\nLIN " + f +
                                       "\nIF a THEN\nLIN " + f + "\nENDIF\nLIN " + f + "\nEND\n"),
            "28");
  EXPECT_EQ(
      unknown_lines("p.src", "LIN " + f + "\nSUB()\nLIN " + f + "\nLIN_REL {X 1}\nLIN " + f +
                                 "\nWAIT SEC 1\nTRIGGER WHEN DISTANCE=1 DELAY=0 DO a=1\nLIN " + f +
                                 "\nx=y(1)\nLIN " + f),
      "13XX10");
  const std::string t = "[[1,0,0],[1,0,0,0],[0,0,0,0],[0,0,0,0,0,0]],v1,z1,tool0;";
  EXPECT_EQ(
      unknown_lines("p.mod", "PROC a()\nMoveL " + t + "\nMoveL " + t + "\nIF b MoveL " + t +
                                 "\nMoveL " + t + "\nSet do1;\nMoveL " + t + "\nc;\nMoveL " + t),
      "2X4X59");
  EXPECT_EQ(
      unknown_lines("p.script",
                    "def a():\n movel(p[1,0,0,0,0,0])\n sleep(1)\n movel(p[1,0,0,0,0,0])\n"
                    " while x:\n  movel(p[1,0,0,0,0,0])\n end\n movel(p[1,0,0,0,0,0], t=2)\n"),
      "268X");
  EXPECT_EQ(
      unknown_lines(
          "p.ls",
          "/PROG P\n/MN\n 1:L P[1] 9mm/sec FINE;\n 2:L P[1] 2sec FINE;\n 3: !L P[7];\n"
          " 4:L P[1] 9mm/sec FINE;\n 5: LBL[1];\n 6:L P[1] 9mm/sec FINE Skip,LBL[1];\n/POS\n" +
              fanuc_position(1, "1.000") + "/END\n"),
      "3X8X");
}

}  // namespace
}  // namespace armtrue::inserted_point_test
