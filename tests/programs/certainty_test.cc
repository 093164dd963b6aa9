#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/programs/program_project.h"
#include "armtrue/programs/robot_program.h"
#include "armtrue/text/input_error.h"
#include "programs/program_flow.h"

// Moves whose point, frame or tool the text of a program does not show for certain, and points that
// other statements than moves use.

namespace armtrue::certainty_test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

RobotProgram parsed(const std::string& name, const std::string& text) {
  return parse_program(*dialect_of_file(name), {{name, text}}, {});
}

// Lines of the moves that are followed.
std::vector<int> lines_of(const RobotProgram& program) {
  std::vector<int> lines;
  for (const ProgramTarget& target : program.targets) lines.push_back(target.line);
  return lines;
}

// Each target 1 mm higher; joints by 1 mrad.
std::string raised(const RobotProgram& program) {
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : program.targets) {
    ProgramCommand command{true, target.q, target.q, target.pose};
    command.pose.translation.z() += 1e-3;
    command.q[0] += 1e-3;
    commands.push_back(command);
  }
  return rewrite(program, commands).texts[0];
}

std::string tool_of(const RobotProgram& program, size_t target) {
  const int tool = program.targets[target].tool;
  return tool < 0 ? "" : program.frames[static_cast<size_t>(tool)].name;
}

const std::string kTail = ",[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";  // of a robtarget
std::string robtarget(const std::string& name, const std::string& kind = "CONST") {
  return kind + " robtarget " + name + ":=[[1,2,3]" + kTail + ";\n";
}

TEST(Certainty, ARapidRoutineMayGiveANameAnotherPoint) {
  const RobotProgram program =
      parsed("p.mod", robtarget("p1") + "PROC main()\nMoveL p1,v1,fine,tool0;\nENDPROC\n" +
                          "PROC go(robtarget p1)\nMoveL p1,v1,fine,tool0;\nENDPROC\n" +
                          "PROC fetch()\nVAR robtarget p1;\nGetPoint p1;\n"
                          "MoveL p1,v1,fine,tool0;\nENDPROC\n" +
                          "PROC own()\nCONST robtarget p1:=[[7,8,9]" + kTail +
                          ";\nMoveL p1,v1,fine,tool0;\nENDPROC\n" +
                          "PROC other(VAR num p1)\nMoveL p2,v1,fine,tool0;\nENDPROC\n" +
                          "PROC two()\n" + robtarget("p2") + "ENDPROC\n");
  EXPECT_THAT(lines_of(program), ElementsAre(3, 15));
  EXPECT_NEAR(program.targets[1].pose.translation.x(), 7e-3, 1e-12);
  EXPECT_THAT(program.warnings,
              ElementsAre("p.mod:11: left alone: its point is given several values, or changed at "
                          "run time",
                          "p.mod:18: left alone: its point is not declared here; give the "
                          "module that declares it, or a folder with it: --with",
                          "p.mod:6: left alone: its point is a parameter of the routine"));
  EXPECT_THAT(raised(program), AllOf(HasSubstr("p1:=[[1,2,4]"), HasSubstr("p1:=[[7,8,10]"),
                                     Not(HasSubstr("MoveL ["))));
}

TEST(Certainty, ARapidCallDrivesToThePointThatItHandsOver) {
  const auto with = [](const std::string& body) {
    return parsed("p.mod", robtarget("p1") + robtarget("p2") +
                               "PROC main()\nMoveL p2,v1,fine,tool0;\ngo p1,v1;\n"
                               "go Offs(p1,0,0,1),v1;\nENDPROC\n"
                               "PROC go(robtarget p,speeddata v)\n" +
                               body + "ENDPROC\n");
  };
  const std::string move = "MoveL p,v,fine,tool0;\n";
  const RobotProgram program = with("MoveL Offs(p,0,0,9),v,fine,tool0;\n" + move);
  EXPECT_THAT(lines_of(program), ElementsAre(4, 5, 6));
  EXPECT_THAT(program.warnings, ElementsAre(HasSubstr("p.mod:9: left alone: its point is a")));
  EXPECT_THAT(raised(program), AllOf(HasSubstr("p1:=[[1,2,4]"), HasSubstr("go p1,v1;"),
                                     HasSubstr("go [[1.0,2.0,5.0],"), HasSubstr("MoveL p,v,")));
  for (const char* const use :
       {"p.trans.z:=5;\n", "x:=p.trans.z;\n", "other p;\n", "MoveC p,p1,v,fine,tool0;\n"}) {
    const RobotProgram left = with(move + use);
    EXPECT_THAT(lines_of(left), ElementsAre(4)) << use;
    EXPECT_THAT(raised(left), HasSubstr("p1:=[[1,2,3]")) << use;
  }
  const RobotProgram two = with(move + "MoveL p,v,fine,tool0\\WObj:=w1;\n");
  EXPECT_THAT(lines_of(two), ElementsAre(4));
  EXPECT_THAT(two.warnings,
              ElementsAre(HasSubstr("p.mod:5: left alone: its routine drives to it")));
}

TEST(Certainty, AUrCallDrivesToThePointThatItHandsOver) {
  const auto with = [](const std::string& body) {
    return parsed("p.script", "a = p[1,2,3,0,0,0]\nmovej([0,-1,1,0,1,0])\ndef go(p, v):\n" + body +
                                  "end\ngo(a, 0.1)\ngo(p[1,2,5,0,0,0], 0.1)\n");
  };
  const std::string move = "movel(p, v=v)\n";
  const RobotProgram program = with("movel(pose_add(p, p[0,0,1,0,0,0]), v=v)\n" + move);
  EXPECT_THAT(lines_of(program), ElementsAre(2, 7, 8));
  EXPECT_THAT(program.warnings, ElementsAre(HasSubstr("p.script:4: left alone: its target is")));
  EXPECT_THAT(raised(program), AllOf(HasSubstr("a = p[1,2,3.001,"), HasSubstr("go(a, 0.1)"),
                                     HasSubstr("go(p[1,2,5.001,"), HasSubstr("movel(p, v")));
  for (const char* const use :
       {"p[2] = 5\n", "x = p[2]\n", "other(p)\n", "movec(p, a)\n", "p = a\n"}) {
    const RobotProgram left = with(move + use);
    EXPECT_THAT(lines_of(left), ElementsAre(2)) << use;
    EXPECT_THAT(raised(left), HasSubstr("a = p[1,2,3,")) << use;
  }
  // A pose p[..] is no use of p.
  EXPECT_THAT(lines_of(with("force_mode(p[a[0],0,0,0,0,0], [0,0,1,0,0,0])\n" + move)),
              ElementsAre(2, 7, 8));
  const RobotProgram two = with(move + "movel(pose_trans(b, p))\n");
  EXPECT_THAT(lines_of(two), ElementsAre(2));
  EXPECT_THAT(two.warnings,
              ElementsAre(HasSubstr("p.script:7: left alone: its function drives to it")));
}

TEST(Certainty, ARapidRoutineMayBeCalledWithSeveralTools) {
  const std::string tool =
      " tooldata t1:=[TRUE,[[0,0,1],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n";
  const RobotProgram program = parsed(
      "p.mod", "PERS" + tool + robtarget("p1") +
                   "PROC main()\nMoveL p1,v1,fine,t1;\nENDPROC\n"
                   "PROC go(PERS tooldata t1\\PERS wobjdata WObj)\nMoveL p1,v1,fine,t1;\n"
                   "MoveL p1,v1,fine,tool0\\WObj?WObj;\nMoveL p1,v1,fine,tool0\\WObj:=WObj;\n"
                   "MoveL p1,v1,fine,tool0;\nENDPROC\nPROC own()\nVAR" +
                   tool +
                   "MoveL p1,v1,fine,t1;\nENDPROC\nPROC home(PERS tooldata t1)\n"
                   "MoveAbsJ [[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v1,fine,t1;\nENDPROC\n");
  EXPECT_THAT(lines_of(program), ElementsAre(4, 10, 17));  // joint angles need no tool
  EXPECT_THAT(program.warnings,
              ElementsAre("p.mod:7: left alone: its tool or work object is given by its routine; "
                          "also lines 8, 9, 14"));
  // A move that is left alone keeps its point.
  EXPECT_THAT(raised(program), AllOf(HasSubstr("p1:=[[1,2,3]"), HasSubstr("MoveL [[1,2,4]")));
}

TEST(Certainty, ARapidPartThatTheRobotHoldsMovesAboutAToolInTheRoom) {
  const auto tool = [](const char* held) {
    return std::string("PERS tooldata t1:=[") + held +
           ",[[0,0,500],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n";
  };
  const std::string part =
      "PERS wobjdata w1:=[TRUE,TRUE,\"\",[[0,0,100],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n";
  const std::string move = "MoveL p1,v1,fine,t1\\WObj:=w1;\n";
  const RobotProgram program = parsed("p.mod", tool("FALSE") + part + robtarget("p1") + move);
  ASSERT_THAT(lines_of(program), ElementsAre(4));
  // flange * part * p1 = tool: the flange stands at 500 - 3 - 100.
  const ProgramTarget& target = program.targets[0];
  const Pose flange =
      program.frames[target.base].pose * target.pose * inverse(program.frames[target.tool].pose);
  EXPECT_TRUE(flange.translation.isApprox(Eigen::Vector3d(-1e-3, -2e-3, 0.397), 1e-12));
  EXPECT_THAT(raised(program), HasSubstr("[[1,2,2]"));  // the part goes up by 1 mm
  EXPECT_THAT(lines_of(parsed("p.mod", tool("TRUE") + part + robtarget("p1") + move +
                                           "MoveL p1,v1,fine,tool0;\n")),
              ElementsAre(5));
}

TEST(Certainty, ARapidPointThatOtherStatementsUseStaysWhereItIsDeclared) {
  const std::string move = "MoveL p1,v1,fine,tool0;\n";
  for (const char* const use :
       {"Glue p1;\n", "x:=p1.trans.x;\n", "x:=Offs(p1,0,0,1);\n", "IF p1.trans.x>1 Stop;\n",
        "Glue\\At:=p1;\n", "IF a THEN Glue 1,p1; ENDIF\n"}) {
    const RobotProgram program = parsed("p.mod", robtarget("p1") + move + use);
    EXPECT_EQ(program.left_alone, 0) << use;
    EXPECT_THAT(program.warnings, IsEmpty()) << use;
    EXPECT_EQ(raised(program),
              robtarget("p1") + "MoveL [[1,2,4]" + kTail + ",v1,fine,tool0;\n" + use);
  }
  // An offset in a move follows the point.
  const std::string offset = "MoveL Offs(p1,0,0,1),v1,fine,tool0;\n";
  EXPECT_THAT(raised(parsed("p.mod", robtarget("p1") + move + offset)), HasSubstr("p1:=[[1,2,4]"));
  // What is no constant may be changed where it is handed to a routine.
  for (const char* const use : {"GetPoint p1;\n", "SearchL di1,p1,p2,v1,tool0;\n"})
    EXPECT_THAT(lines_of(parsed("p.mod", robtarget("p1", "VAR") + move + "MoveL [[1,2,3]" + kTail +
                                             ",v1,fine,tool0;\n" + use)),
                ElementsAre(3))
        << use;
}

TEST(Certainty, ARapidArrayThatIsUsedByIndexStaysAsItIsDeclared) {
  const std::string declared =
      "CONST robtarget p{2}:=[[[1,2,3]" + kTail + ",[[4,5,6]" + kTail + "];\n";
  const RobotProgram program =
      parsed("p.mod", declared +
                          "MoveL p{1},v1,fine,tool0;\nFOR i FROM 1 TO 2 DO\n"
                          "MoveL p{i},v1,fine,tool0;\nENDFOR\n");
  EXPECT_THAT(
      program.warnings,
      ElementsAre("p.mod:4: left alone: its point is an element of an array, whose index is "
                  "no plain number"));
  EXPECT_THAT(raised(program), AllOf(HasSubstr(declared), HasSubstr("\nMoveL [[1,2,4]")));
}

// Lines with a move, in a module whose data take the first line.
std::vector<int> displaced(const std::string& routines) {
  const std::string move = "MoveL p1,v1,fine,tool0;";
  std::string text = robtarget("p1") + routines;
  for (size_t at = text.find("MOVE;"); at != std::string::npos; at = text.find("MOVE;"))
    text.replace(at, 5, move);
  return lines_of(parsed("p.mod", text));
}

TEST(Certainty, ARapidRoutineThatMayBeCalledDisplacedIsLeftAlone) {
  const std::string part = "PROC part()\nMOVE;\nENDPROC\n", on = "PDispSet d;\n",
                    off = "PDispOff;\n";
  EXPECT_THAT(displaced("PROC main()\nMOVE;\n" + on + "part;\n" + off + "MOVE;\nENDPROC\n" + part),
              ElementsAre(3, 7));
  EXPECT_THAT(displaced(part + "PROC main()\n" + on + off + "part;\nMOVE;\nENDPROC\n"),
              ElementsAre(3, 9));
  // Called with and without; under a name that is not known.
  EXPECT_THAT(displaced("PROC main()\npart;\n" + on + "part;\n" + off + "MOVE;\nENDPROC\n" + part),
              ElementsAre(7));
  EXPECT_THAT(displaced("PROC main()\n" + on + "%\"part\"%;\n" + off + "MOVE;\nENDPROC\n" + part),
              ElementsAre(6));
  // A routine may leave it on; a branch or an end of a loop, too.
  EXPECT_THAT(
      displaced("PROC main()\nMOVE;\nset;\nMOVE;\nENDPROC\nPROC set()\n" + on + "ENDPROC\n"),
      Not(Contains(5)));
  EXPECT_THAT(
      displaced("PROC main()\nIF a THEN\n" + on + "ENDIF\nMOVE;\n" + off + "MOVE;\nENDPROC\n"),
      ElementsAre(8));
  EXPECT_THAT(displaced("PROC main()\nIF a " + on + "MOVE;\n" + off + "MOVE;\nENDPROC\n"),
              ElementsAre(6));
  EXPECT_THAT(displaced("PROC main()\nMOVE;\nWHILE a DO\nMOVE;\n" + on + "ENDWHILE\n" + off +
                        "MOVE;\nENDPROC\n"),
              ElementsAre(3, 9));
  EXPECT_THAT(displaced("PROC main()\nMOVE;\nagain:\nMOVE;\n" + on + "IF a GOTO again;\n" + off +
                        "MOVE;\nENDPROC\n"),
              ElementsAre(3, 9));
}

TEST(Certainty, BehindConfOffTheControllerReadsNoConfdata) {
  const std::string move =
      "[[1,2,3],[1,0,0,0],[1,0,1,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v1,fine,tool0;\n";
  const auto stated = [&](const std::string& text) {
    std::string result;
    const RobotProgram program = parsed("p.mod", "PROC main()\n" + text + "ENDPROC\n");
    for (const ProgramTarget& target : program.targets) {
      const Configuration& configuration = target.configuration;
      result += !configuration.is_stated() ? '0' : configuration.is_weak ? '?' : '1';
    }
    return result;
  };
  const std::string joint = "MoveJ " + move, line = "MoveL " + move;
  EXPECT_EQ(stated("ConfL\\Off;\n" + joint + line + "ConfL \\On;\n" + line + "ConfL;\n" + line),
            "1011");
  EXPECT_EQ(stated("ConfJ \\Off;\n" + joint + line + "TriggJ " + move.substr(0, move.find(",v1")) +
                   ",v1,t,fine,tool0;\n"),
            "010");
  EXPECT_EQ(stated("IF a ConfL\\Off;\n" + line + "ConfL\\Off;\n" + line), "?0");
}

// Whether a move to a variable point is followed that other statements and routines have; line 3.
bool is_followed_beside(const std::string& statements, const std::string& routines = "") {
  const RobotProgram program = parsed(
      "p.mod", robtarget("p1", "VAR") + "PROC main()\nMoveL p1,v1,fine,tool0;\n" + statements +
                   "MoveL [[1,2,3]" + kTail + ",v1,fine,tool0;\nENDPROC\n" + routines);
  const std::vector<int> lines = lines_of(program);
  return std::ranges::find(lines, 3) != lines.end();
}

TEST(Certainty, ARapidPointOfWhichAnInstructionMayChangeAComponentIsLeftAlone) {
  for (const char* const use :
       {"Add p1.trans.z,5;\n", "Incr p1.trans.z;\n", "Clear p1.trans.x;\n",
        "IF a=b Decr p1.robconf.cf1;\n", "IF a THEN Add p1.trans.z,5; ENDIF\n",
        "ok:=StrToVal(\"12\",p1.trans.z);\n", "ok:=StrToVal(s,p1);\n",
        "IF NOT StrToVal(s,p1.trans.z) Stop;\n", "UnpackRawBytes r,1,p1.trans.x\\Float4;\n",
        "other p1.trans;\n", "other(p1.trans.z);\n", "other 1,p1.trans;\n", "other\\z:=p1.trans;\n",
        "other z:=p1.trans.z;\n", "%\"other\"%p1.trans.z;\n",
        "TEST a CASE 1: Incr p1.trans.z; ENDTEST\n", "WHILE a DO Incr p1.trans.z; ENDWHILE\n",
        "again: Incr p1.trans.z;\n"})
    EXPECT_FALSE(is_followed_beside(use)) << use;
  for (const char* const use :
       {"x:=p1.trans.z;\n", "IF p1.trans.z>5 Stop;\n", "IF (p1.trans.z)>5 Stop;\n",
        "WHILE p1.trans.z<x DO Incr x; ENDWHILE\n", "Add x,p1.trans.z+1;\n",
        "TPWrite \"z\"\\Num:=p1.trans.z;\n", "x:=Abs(p1.trans.z);\n",
        "IF Distance(p1.trans,q.trans)<5 Stop;\n", "q:=[p1.trans,p1.rot,p1.robconf,p1.extax];\n",
        "q:=Offs(p1,p1.trans.x,0,0);\n", "x:=a{p1.trans.z};\n", "WaitUntil p1.trans.z>5;\n",
        "FOR i FROM 1 TO p1.trans.z DO Incr x; ENDFOR\n", "RETURN p1.trans.z;\n"})
    EXPECT_TRUE(is_followed_beside(use)) << use;
}

TEST(Certainty, ARapidRoutineMayChangeWhatItGetsByReference) {
  const std::string by_number = "go p1.trans.z;\n";
  EXPECT_FALSE(is_followed_beside(by_number, "PROC go(INOUT num z)\nz:=z+5;\nENDPROC\n"));
  EXPECT_FALSE(is_followed_beside(by_number, "PROC go(VAR num z)\nIncr z;\nENDPROC\n"));
  EXPECT_FALSE(is_followed_beside("go p1.trans;\n", "PROC go(INOUT pos t)\nt.z:=5;\nENDPROC\n"));
  // By what it calls.
  EXPECT_FALSE(is_followed_beside(by_number,
                                  "PROC go(INOUT num z)\non z;\nENDPROC\n"
                                  "PROC on(INOUT num z)\nz:=5;\nENDPROC\n"));
  EXPECT_FALSE(is_followed_beside("ok:=go(p1);\n",
                                  "FUNC bool go(INOUT robtarget q)\nq.trans.z:=5;\n"
                                  "RETURN TRUE;\nENDFUNC\n"));
  // A copy, one that it only reads, and another argument that it changes.
  EXPECT_TRUE(is_followed_beside(by_number, "PROC go(num z)\nz:=z+5;\nENDPROC\n"));
  EXPECT_TRUE(is_followed_beside(by_number, "PROC go(VAR num z)\nx:=z;\nENDPROC\n"));
  EXPECT_TRUE(
      is_followed_beside("go p1.trans.z,n;\n", "PROC go(num z,INOUT dnum n)\nn:=z;\nENDPROC\n"));
}

TEST(Certainty, ARapidFrameOfWhichAnInstructionChangesAComponentIsLeftAlone) {
  const std::string declared =
      "PERS tooldata t1:=[TRUE,[[0,0,1],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n"
      "PERS wobjdata w1:=[FALSE,TRUE,\"\",[[1,2,3],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n" +
      robtarget("p1");
  const auto lines = [&](const std::string& use) {
    return lines_of(parsed("p.mod", declared + "PROC main()\n" + use +
                                        "MoveL p1,v1,fine,t1\\WObj:=w1;\n"
                                        "MoveL p1,v1,fine,tool0;\nENDPROC\n"));
  };
  EXPECT_THAT(lines("Add t1.tframe.trans.z,50;\n"), ElementsAre(7));
  EXPECT_THAT(lines("Decr w1.uframe.trans.z;\n"), ElementsAre(7));
  EXPECT_THAT(lines("go w1.oframe;\n"), ElementsAre(7));
  EXPECT_THAT(lines("t1.tframe.trans.z:=t1.tframe.trans.z+50;\n"), ElementsAre(7));
  EXPECT_THAT(lines("Add t1.tload.mass,5;\n"), ElementsAre(6, 7));
  EXPECT_THAT(lines("TPWrite \"\"\\Num:=t1.tframe.trans.z;\n"), ElementsAre(6, 7));
}

TEST(Certainty, ARapidRoutineOfAnotherModuleMayChangeAComponent) {
  const auto lines = [](const std::string& own, const std::string& other) {
    const Dialect& dialect = *find_dialect("rapid");
    const std::vector<ProgramText> program{
        {"own.mod", "MODULE own\nPROC main()\n" + own +
                        "MoveL p1,v1,fine,t1;\n"
                        "MoveL [[1,2,3]" +
                        kTail + ",v1,fine,tool0;\nENDPROC\nENDMODULE\n"}};
    const std::vector<ProgramText> others{
        {"other.mod", "MODULE other\n" + other + "ENDMODULE\n"},
        {"data.mod", "MODULE data\n" + robtarget("p1", "PERS") +
                         "PERS tooldata t1:=[TRUE,[[0,0,1],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],"
                         "0,0,0]];\nENDMODULE\n"}};
    return lines_of(parse_program(dialect, program, {}, TargetParts::pose,
                                  what_others_declare(dialect, program, others)));
  };
  const auto changing = [](const std::string& body) {
    return "PROC go(INOUT num z)\n" + body + "ENDPROC\n";
  };
  EXPECT_THAT(lines("go p1.trans.z;\n", changing("z:=5;\n")), ElementsAre(5));
  EXPECT_THAT(lines("go p1.trans.z;\n", changing("x:=z;\n")), ElementsAre(4, 5));
  EXPECT_THAT(lines("", "PROC go()\nAdd p1.trans.z,5;\nENDPROC\n"), ElementsAre(4));
  EXPECT_THAT(lines("", "PROC go()\nAdd t1.tframe.trans.z,5;\nENDPROC\n"), ElementsAre(4));
  EXPECT_THAT(lines("", "PROC go()\nIF p1.trans.z>5 Stop;\nENDPROC\n"), ElementsAre(3, 4));
  // A parameter with the name of the point hides it only in its own routine.
  EXPECT_THAT(lines("", "PROC go(robtarget p1)\nIncr p1.trans.z;\nENDPROC\n"), ElementsAre(3, 4));
  EXPECT_THAT(lines("", "PROC on(robtarget p1)\nENDPROC\nTRAP go\np1.trans.z:=5;\nENDTRAP\n"),
              ElementsAre(4));
}

TEST(Certainty, ALoopOfRapidGivesItsVariableAValueOfItsOwn) {
  const auto followed = [](const std::string& moves) {
    return lines_of(parsed(
        "p.mod", "CONST num h:=25;\n" + robtarget("p1") + "PROC main()\n" + moves + "ENDPROC\n"));
  };
  const std::string move = "MoveL Offs(p1,0,0,h),v1,fine,tool0;\n";
  EXPECT_THAT(followed(move + "FOR h FROM 1 TO 3 DO\n" + move + "ENDFOR\n" + move),
              ElementsAre(4, 8));
  EXPECT_THAT(followed("FOR i FROM 1 TO 3 DO\nFOR h FROM 1 TO 3 DO\n" + move + "ENDFOR\n" + move +
                       "ENDFOR\n"),
              ElementsAre(8));
}

TEST(Certainty, TheFirstStatementOfARapidTrapOrHandlerIsRead) {
  const auto lines = [](const std::string& text) {
    return lines_of(parsed("p.mod", robtarget("p1", "VAR") + robtarget("p2") + "TRAP t1\n" + text +
                                        "ENDTRAP\nPROC main()\nMoveL p1,v1,fine,tool0;\n"
                                        "MoveL p2,v1,fine,tool0;\nENDPROC\n"));
  };
  EXPECT_THAT(lines("Stop;\n"), ElementsAre(7, 8));
  EXPECT_THAT(lines("MoveL p2,v1,fine,tool0;\n"), ElementsAre(4, 7, 8));
  for (const char* const change : {"p1.trans.z:=5;\n", "Incr p1.trans.z;\n",
                                   "IF a p1.trans.z:=5;\n", "IF a THEN p1.trans.z:=5; ENDIF\n"})
    EXPECT_THAT(lines(change), ElementsAre(8)) << change;
  EXPECT_THROW(lines("PDispSet d;\n"), InputError);  // no move is left
  for (const char* const handler : {"ERROR\n", "ERROR (ERR_A,ERR_B)\n", "UNDO\n", "BACKWARD\n"})
    for (const char* const change : {"p1.trans.z:=5;\n", "Incr p1.trans.z;\n"})
      EXPECT_THAT(lines_of(parsed("p.mod", robtarget("p1", "VAR") +
                                               "PROC main()\n"
                                               "MoveL p1,v1,fine,tool0;\nMoveL [[1,2,3]" +
                                               kTail + ",v1,fine,tool0;\n" + handler + change +
                                               "ENDPROC\n")),
                  ElementsAre(4))
          << handler << change;
}

TEST(Certainty, AnElementOfARapidArrayIsFollowedWhereItsIndicesAreConstant) {
  const auto point = [](const char* x) { return "[[" + std::string(x) + ",2,3]" + kTail; };
  const std::string declared = "CONST num n:=2;\nCONST robtarget p{2,2}:=[[" + point("1") + "," +
                               point("4") + "],[" + point("7") + "," + point("9") + "]];\n";
  const auto moved_to = [&](const std::string& element) {
    const RobotProgram program = parsed(
        "p.mod", declared + "MoveL p{1,1},v1,fine,tool0;\nMoveL " + element + ",v1,fine,tool0;\n");
    return program.targets.size() < 2 ? 0 : program.targets[1].pose.translation.x() * 1e3;
  };
  EXPECT_NEAR(moved_to("p{2,1}"), 7, 1e-9);
  EXPECT_NEAR(moved_to("p{n, n}"), 9, 1e-9);
  EXPECT_NEAR(moved_to("Offs(p{1,n},1,0,0)"), 5, 1e-9);
  for (const char* const left : {"p{i,1}", "p{2,3}", "p{0,1}", "p{1.5,1}", "p{2}"})
    EXPECT_EQ(moved_to(left), 0) << left;
}

TEST(Certainty, ARapidFrameThatCannotBeReadLeavesOnlyItsMoves) {
  const std::string tool = "[TRUE,[[0,0,HIGH],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]]";
  const auto with = [&](const char* height) {
    std::string text = tool;
    return text.replace(text.find("HIGH"), 4, height);
  };
  const std::string declared = "PERS tooldata t{2}:=[" + with("1") + "," + with("8") +
                               "];\nPERS tooldata t1:=" + with("h") +
                               ";\nPERS wobjdata w1:=[FALSE,TRUE,\"\",[[1,2,3],[0.9,0,0,0]],"
                               "[[0,0,0],[1,0,0,0]]];\n" +
                               robtarget("p1");
  const auto read = [&](const std::string& tail) {
    return parsed("p.mod", declared + "MoveL p1,v1,fine,tool0;\nMoveL p1,v1,fine," + tail + ";\n");
  };
  const RobotProgram program = read("t{2}");
  EXPECT_THAT(lines_of(program), ElementsAre(5, 6));
  EXPECT_NEAR(program.frames[program.targets[1].tool].pose.translation.z(), 8e-3, 1e-12);
  const auto why = [&](const std::string& tail) {
    const RobotProgram left = read(tail);
    return left.targets.size() == 1 ? left.why_left_alone.at(0) : "";
  };
  EXPECT_EQ(why("t{i}"),
            "its tool or work object is an element of an array, whose index is no "
            "plain number");
  EXPECT_EQ(why("t1"),
            "its tool or work object has no plain numbers; say where it is: --frame "
            "T1=..");
  EXPECT_EQ(why("tool0\\WObj:=w1"),
            "the length of the quaternion of its tool or work object is not 1");
  const RobotProgram given = parse_program(
      *find_dialect("rapid"), {{"p.mod", declared + "MoveL p1,v1,fine,t1;\n"}}, {{"t1", Pose{}}});
  EXPECT_THAT(lines_of(given), ElementsAre(5));
}

TEST(Certainty, ARapidFrameThatARoutineChangesIsNotKnown) {
  const std::string declared =
      "PERS wobjdata w1:=[FALSE,TRUE,\"\",[[1,2,3],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n" +
      robtarget("p1");
  const auto is_known = [&](const std::string& routine) {
    const RobotProgram program =
        parsed("p.mod", declared +
                            "PROC main()\nset w1;\nMoveL p1,v1,fine,tool0\\WObj:=w1;\n"
                            "ENDPROC\nPROC set(PERS wobjdata w)\n" +
                            routine + "ENDPROC\n");
    return program.frames[static_cast<size_t>(program.targets[0].base)].is_known;
  };
  EXPECT_TRUE(is_known("TPWrite \"w.oframe:=\";\n"));
  EXPECT_FALSE(is_known("w.oframe.trans.x:=5;\n"));
  EXPECT_FALSE(is_known("w:=other;\n"));
}

const std::string kJoints = "movej([0,-1,1,0,1,0])\n";

TEST(Certainty, AUrFunctionMayGiveANameAnotherPoint) {
  const std::string head = "def prog():\nglobal a = p[1,2,3,0,0,0]\n" + kJoints + "movel(a)\n";
  const RobotProgram program =
      parsed("p.script", head +
                             "def go(a):\nmovel(a)\nend\ndef own():\nlocal a = p[1,2,5,0,0,0]\n"
                             "movel(a)\nend\ndef other():\nb = p[1,2,6,0,0,0]\nend\n"
                             "movel(b)\ngo(b)\nend\n");
  EXPECT_THAT(lines_of(program), ElementsAre(3, 4, 10));
  EXPECT_NEAR(program.targets[2].pose.translation.z(), 5, 1e-12);
  EXPECT_THAT(
      program.warnings,
      ElementsAre("p.script:15: left alone: its point is given its value in another function; "
                  "also lines 16"));
  EXPECT_THAT(raised(program),
              AllOf(HasSubstr("global a = p[1,2,3.001,"), HasSubstr("movel(a)\ndef"),
                    HasSubstr("local a = p[1,2,5.001,")));
  // Without `local` it is the global one, which has the other value once the function was called.
  const std::string go = "def go():\na = p[1,2,4,0,0,0]\nend\n";
  EXPECT_THAT(lines_of(parsed("p.script", head + go + "go()\nmovel(a)\nend\n")), ElementsAre(3, 4));
}

TEST(Certainty, AUrNameHasTheValueThatItIsGivenLast) {
  const std::string head = "def prog():\n" + kJoints +
                           "f = p[0,0,1,0,0,0]\nhome = p[1,1,1,0,0,0]\n"
                           "a = p[1,2,3,0,0,0]\nmovel(a)\n";
  const RobotProgram program =
      parsed("p.script", head +
                             "a = pose_trans(f, p[1,2,4,0,0,0])\nmovel(a)\nmovel(a)\n"
                             "b = home\nmovel(b)\nend\n");
  EXPECT_THAT(program.warnings, IsEmpty());
  ASSERT_EQ(program.targets.size(), 5u);
  EXPECT_EQ(program.targets[1].base, -1);
  EXPECT_EQ(program.frames[program.targets[2].base].name, "f");
  EXPECT_NEAR(program.targets[3].pose.translation.z(), 4, 1e-12);
  EXPECT_NEAR(program.targets[4].pose.translation.z(), 1, 1e-12);
  // Each where it is given; a name of which another is made stays.
  EXPECT_THAT(raised(program),
              AllOf(HasSubstr("a = p[1,2,3.001,0,0,0]\nmovel(a)\n"),
                    HasSubstr("a = pose_trans(f, p[1,2,4.001,0,0,0])\nmovel(a)\nmovel(a)\n"),
                    HasSubstr("home = p[1,1,1,0,0,0]\n"),
                    HasSubstr("b = home\nmovel(p[1,1,1.001,0,0,0])\n")));
  // Used by others, the expression is written out in the move.
  EXPECT_THAT(raised(parsed("p.script", head + "c = pose_trans(f, p[1,2,4,0,0,0])\nmovel(c)\n"
                                               "textmsg(c)\nend\n")),
              AllOf(HasSubstr("c = pose_trans(f, p[1,2,4,0,0,0])\n"),
                    HasSubstr("movel(pose_trans(f, p[1,2,4.001,0,0,0]))\n")));
  // So is one that is made of another name, or of its own value before.
  const RobotProgram made = parsed(
      "p.script", head + "b = pose_trans( f, a )\nmovel(b)\na = pose_add(a, p[0,0,2,0,0,0])\n" +
                      "movej(get_inverse_kin(a, [0,-1,1,0,1,0]))\nend\n");
  EXPECT_EQ(made.left_alone, 0);
  ASSERT_EQ(made.targets.size(), 4u);
  EXPECT_NEAR((made.frames[made.targets[2].base].pose * made.targets[2].pose).translation.z(), 4,
              1e-12);
  EXPECT_EQ(made.targets[3].base, -1);
  EXPECT_NEAR(made.targets[3].pose.translation.z(), 5, 1e-12);
  EXPECT_THAT(raised(made),
              HasSubstr("a = p[1,2,3,0,0,0]\nmovel(p[1,2,3.001,0,0,0])\nb = pose_trans( f, a )\n"
                        "movel(pose_trans( f, p[1.0,2.0,3.001,0.0,0.0,0.0] ))\n"
                        "a = pose_add(a, p[0,0,2,0,0,0])\nmovej(get_inverse_kin(pose_add("
                        "p[1.0,2.0,3.001,0.0,0.0,0.0], p[0,0,2,0,0,0]), [0,-1,1,0,1,0]))\n"));
  // Not certain: behind a branch, in a loop that changes it, where a thread may, of one element
  // that is not certain, by itself, of the tool at another place, in a frame with several values.
  for (const char* const lines :
       {"if x:\na = p[1,2,4,0,0,0]\nend\nmovel(a)\n",
        "while x:\nmovel(a)\na = p[1,2,4,0,0,0]\nend\n",
        "thread t():\nhome = p[1,2,4,0,0,0]\nend\nrun t()\nmovel(home)\n", "a[i] = 1\nmovel(a)\n",
        "a[2] = g()\nmovel(a)\n", "while x:\na[2] = a[2] + 1\nmovel(a)\nend\n",
        "if x:\na[2] = 1\nend\nmovel(a)\n",
        "while x:\na = pose_add(a, p[0,0,1,0,0,0])\nmovel(a)\nend\n", "a = g()\nmovel(a)\n",
        "q = get_inverse_kin(p[1,2,3,0,0,0])\nmovej(q)\n",
        "f = p[0,0,2,0,0,0]\na = pose_trans(f, p[1,2,4,0,0,0])\nmovel(a)\n"})
    EXPECT_EQ(parsed("p.script", head + lines + "end\n").left_alone, 1) << lines;
}

TEST(Certainty, UrNumbersMayBeSumsAndProducts) {
  const auto x_of = [](const std::string& lines) {
    const RobotProgram program = parsed("p.script", "def prog():\n" + kJoints + lines + "end\n");
    return program.targets.size() < 2
               ? -1.0
               : static_cast<double>(std::lround(program.targets[1].pose.translation.x() * 1e6));
  };
  EXPECT_EQ(x_of("movel(p[0.1+0.05,0,0,0,0,0])\n"), 150000);
  EXPECT_EQ(x_of("movel(p[-15/1000,0,0,0,0,0])\n"), -15000);
  EXPECT_EQ(x_of("h = 0.2\nmovel(p[2*(h - 0.05),0,0,0,0,0])\n"), 300000);
  EXPECT_EQ(x_of("h = 0.2\nk = h / 4\nh = 0.3\nmovel(p[h+k,0,0,0,0,0])\n"), 350000);
  EXPECT_EQ(x_of("a = p[0.5,0,0,0,0,0]\nmovel(p[a[0]*2,0,0,0,0,0])\n"), 1000000);
  for (const char* const unknown :
       {"movel(p[h,0,0,0,0,0])\n", "h = g()\nmovel(p[h,0,0,0,0,0])\n",
        "h = 1\nif x:\nh = 2\nend\nmovel(p[h,0,0,0,0,0])\n", "movel(p[1/0,0,0,0,0,0])\n",
        "h = h + 1\nmovel(p[h,0,0,0,0,0])\n", "movel(p[sin(1),0,0,0,0,0])\n",
        "movel(p[-\n0.5,0,0,0,0,0])\n"})  // a number in its place would take the line, too
    EXPECT_EQ(x_of(unknown), -1.0) << unknown;
  EXPECT_EQ(x_of("movel(p[\n0.25+0.25\n,0,0,0,0,0])\n"), 500000);
  const RobotProgram joints =
      parsed("p.script", "movej([d2r(90),-d2r(45),0,3.141592653589793/2,0,0])\n");
  EXPECT_NEAR(joints.targets.at(0).q[0], std::acos(0.0), 1e-12);
  EXPECT_NEAR(joints.targets.at(0).q[1], -std::acos(0.0) / 2, 1e-12);
  EXPECT_THAT(raised(joints), HasSubstr("movej([1.5717963,-d2r(45),0,3.141592653589793/2,0,0])"));
  // A tool is known by its text, which must mean one tool.
  EXPECT_THAT(parsed("p.script", "def prog():\n" + kJoints +
                                     "h = 1\nset_tcp(p[0,0,h,0,0,0])\nmovel(p[1,2,3,0,0,0])\n"
                                     "h = 2\nset_tcp(p[0,0,h,0,0,0])\nend\n")
                  .warnings,
              ElementsAre(HasSubstr("its tool is not certain")));
}

// Six elements by six of the point before: each is found once, or the test does not end.
TEST(Certainty, UrPointsMayEachBeMadeOfTheOneBefore) {
  std::string text = "def prog():\n" + kJoints + "p0 = p[1,2,3,0,0,0]\n";
  for (int k = 1; k <= 25; ++k) {
    const std::string before = "p" + std::to_string(k - 1);
    text += "p" + std::to_string(k) + " = p[" + before + "[0]+1";
    for (const char* const element : {"[1]", "[2]", "[3]", "[4]", "[5]"})
      text += "," + before + element;
    text += "]\n";
  }
  const RobotProgram program = parsed("p.script", text + "movel(p25)\nend\n");
  ASSERT_EQ(program.targets.size(), 2u);
  EXPECT_NEAR(program.targets[1].pose.translation.x(), 26, 1e-12);
}

TEST(Certainty, AUrAssignmentCountsWhereverItStandsInItsLine) {
  const auto z_of = [](const std::string& lines) {
    const RobotProgram program = parsed(
        "p.script", "def prog():\n" + kJoints + "h = 3\n" + lines + "movel(p[1,2,h,0,0,0])\nend\n");
    return program.targets.size() < 2 ? -1 : program.targets[1].pose.translation.z();
  };
  EXPECT_EQ(z_of("k = 1; h = 4\n"), 4);
  EXPECT_EQ(z_of("h = 5; k = 1;\n"), 5);
  EXPECT_EQ(z_of("if h == 4 and k[1] <= 2:\nend\nf(1, h=4)\ns = struct(h=4)\ns.h = 4\n"), 3);
  for (const char* const branch : {"if x: h = 4 end\n", "if x[0] < 1: k = 1; h = 4; end\n",
                                   "while x: h = h + 1 end\n", "if x:\nelse: global h = 4 end\n"})
    EXPECT_EQ(z_of(branch), -1) << branch;
}

TEST(Certainty, AnElementOfAUrPointMayBeGivenAnotherValue) {
  const std::string head = "def prog():\n" + kJoints + "a = p[1,2,3,0,0,0]\nmovel(a)\n",
                    up = "a[2] = a[2] + 0.5\n", end = "end\n";
  const RobotProgram program =
      parsed("p.script", head + up + "movel(a)\n" + up + "a[0] = 9\nb = a\nmovel(b)\n" + end);
  ASSERT_EQ(program.targets.size(), 4u);
  EXPECT_EQ(program.left_alone, 0);
  EXPECT_NEAR(program.targets[1].pose.translation.z(), 3, 1e-12);
  EXPECT_NEAR(program.targets[2].pose.translation.z(), 3.5, 1e-12);
  EXPECT_NEAR(program.targets[3].pose.translation.x(), 9, 1e-12);
  EXPECT_NEAR(program.targets[3].pose.translation.z(), 4, 1e-12);
  // Written out in the moves; what is given stays.
  EXPECT_EQ(raised(program).substr(raised(program).find("a =")),
            "a = p[1,2,3,0,0,0]\nmovel(p[1,2,3.001,0,0,0])\n" + up +
                "movel(p[1.0,2.0,3.501,0.0,0.0,0.0])\n" + up +
                "a[0] = 9\nb = a\nmovel(p[9.0,2.0,4.001,0.0,0.0,0.0])\n" + end);
  const RobotProgram unchanged = parsed("p.script", head + up + "movel(a)\n" + end);
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : unchanged.targets)
    commands.push_back({true, target.q, target.q, target.pose});
  EXPECT_EQ(rewrite(unchanged, commands).texts[0], unchanged.texts[0].text);
}

TEST(Certainty, AUrToolThatIsRestoredIsTheOneBefore) {
  const std::string t1 = "set_tcp(p[0,0,0.1,0,0,0])\n", t2 = "set_tcp(p[0,0,0.2,0,0,0])\n",
                    keep = "old = get_tcp_offset()\n", restore = "set_tcp(old)\n",
                    move = "movel(p[1,2,3,0,0,0])\n";
  const auto tool_behind = [&](const std::string& lines) -> std::string {
    const RobotProgram program =
        parsed("p.script", "def prog():\n" + kJoints + lines + move + "end\n");
    return program.left_alone > 0 ? "?" : tool_of(program, program.targets.size() - 1);
  };
  const std::string look = "def look():\nif x:\n" + keep + t2 + restore + "end\nend\n";
  EXPECT_EQ(tool_behind(t1 + look + "look()\n"), "p[0,0,0.1,0,0,0]");
  EXPECT_EQ(tool_behind(look + t1 + "while y:\nlook()\n" + move + "end\n"), "p[0,0,0.1,0,0,0]");
  EXPECT_EQ(tool_behind(keep + t2 + restore), "");  // of the caller
  EXPECT_EQ(tool_behind(t1 + keep + t2), "p[0,0,0.2,0,0,0]");
  // Another one in between, or several where it is kept.
  EXPECT_EQ(tool_behind(t1 + look + "look()\n" + t2 + "look()\n"), "?");
  EXPECT_EQ(tool_behind(t1 + "if y:\n" + t2 + "end\n" + keep + t2 + restore), "?");
}

// A bracket about an argument is an expression of one name.
TEST(Certainty, ARapidCallMayHaveItsArgumentInBrackets) {
  const std::string head = "MODULE m\n" + robtarget("p10") + "PROC main()\n",
                    pick =
                        "ENDPROC\nPROC pick(robtarget to, num n)\nMoveL to,v1,fine,tool0;\n"
                        "ENDPROC\nENDMODULE\n";
  for (const char* const call : {"pick(p10),3;\n", "pick ( p10 ) , 3;\n", "pick p10,3;\n"}) {
    const RobotProgram program = parsed("m.mod", head + call + pick);
    EXPECT_THAT(lines_of(program), ElementsAre(4)) << call;
    EXPECT_EQ(program.left_alone, 0) << call;
  }
}

TEST(Certainty, AUrPointThatOtherStatementsUseStaysWhereItIsDeclared) {
  const std::string declared = "a = p[1,2,3,0,0,0]\n";
  for (const char* const use :
       {"if get_actual_tcp_pose()[2] < a[2]:\nend\n", "force_mode(a, [0,0,1,0,0,0])\n", "go(a)\n",
        "x = a\n", "movel(pose_trans(a, p[0,0,1,0,0,0]))\n"}) {
    const std::string text = raised(parsed("p.script", declared + kJoints + "movel(a)\n" + use));
    EXPECT_THAT(text, AllOf(HasSubstr(declared), HasSubstr("\nmovel(p[1,2,3.001,"))) << use;
  }
  // Arguments by name, and offsets of moves that are left alone.
  for (const char* const use :
       {"movej([0,-1,1,0,1,0], a=1.2)\n", "movel(pose_add(a, p[0,0,1,0,0,0]))\n"})
    EXPECT_THAT(raised(parsed("p.script", declared + kJoints + "movel(a)\n" + use)),
                HasSubstr("a = p[1,2,3.001,"))
        << use;
}

TEST(Certainty, AnOptimoveOfUrIsAMove) {
  const RobotProgram program =
      parsed("p.script",
             "optimovej([0,-1,1,0,1,0], 0.3, 0.4, 0.02)\noptimovel(p[1,2,3,0,0,0], r=0.05)\n"
             "optimovel(struct(pose=p[1,2,3,0,0,0], frame=\"f\"))\n");
  ASSERT_THAT(lines_of(program), ElementsAre(1, 2));
  EXPECT_EQ(program.left_alone, 1);
  EXPECT_EQ(program.targets[0].motion, MotionKind::joint);
  EXPECT_EQ(program.targets[1].motion, MotionKind::line);
  EXPECT_NEAR(program.targets[0].blend, 0.02, 1e-12);  // behind a and v stands no time
  EXPECT_TRUE(program.targets[1].configuration.continues);
  EXPECT_TRUE(program.targets[1].follows_target);
}

TEST(Certainty, AUrAuxiliaryPointOfZerosHasTheOrientationOfTheEnd) {
  const auto program_of = [](const std::string& via) {
    return parsed("p.script",
                  kJoints + "movel(p[1,2,3,0,3,0])\nmovec(" + via + ", p[1,4,3,0,3,0])\n");
  };
  const RobotProgram program = program_of("p[1,3,3,0,0,0]");
  EXPECT_TRUE(program.targets[2].pose.rotation.isApprox(program.targets[3].pose.rotation, 1e-12));
  EXPECT_THAT(raised(program), HasSubstr("movec(p[1,3,3.001,0,0,0], p[1,4,3.001,0,3,0])"));
  for (const char* const via : {"p[1,3,3,0,0,1]", "pose_trans(p[0,0,1,0,0,0], p[1,3,3,0,0,0])"})
    EXPECT_TRUE(program_of(via).targets[2].has_orientation) << via;
}

TEST(Certainty, AUrMoveThatMayFollowAConveyorIsLeftAlone) {
  const std::string move = "movel(p[1,2,3,0,0,0])\n",
                    begin = "track_conveyor_linear(p[1,0,0,0,0,0], 9)\n",
                    stop = "stop_conveyor_tracking()\n";
  const auto lines = [&](const std::string& body) {
    return lines_of(parsed("p.script", "def prog():\n" + kJoints + body + "end\n"));
  };
  EXPECT_THAT(lines(move + begin + move + kJoints + stop + move), ElementsAre(2, 3, 8));
  EXPECT_THAT(lines("if x:\n" + begin + "end\n" + move + stop + move), ElementsAre(2, 8));
  EXPECT_THAT(lines("while x:\n" + move + begin + "end\n"), ElementsAre(2));
  EXPECT_THAT(lines("def pick():\n" + move +
                    "end\npick()\ntrack_conveyor_circular(p[1,0,0,0,0,0], 9)\n" + "pick()\n"),
              ElementsAre(2));
}

TEST(Certainty, AUrFunctionHasTheToolOfItsCalls) {
  const std::string go = "def go():\nmovel(p[1,2,3,0,0,0])\nend\n";
  const std::string t1 = "set_tcp(p[0,0,0.1,0,0,0])\n", t2 = "set_tcp(p[0,0,0.2,0,0,0])\n";
  const RobotProgram known =
      parsed("p.script", go + "def prog():\n" + t1 + kJoints + "go()\nend\nprog()\n");
  EXPECT_THAT(lines_of(known), ElementsAre(2, 6));
  EXPECT_EQ(tool_of(known, 0), "p[0,0,0.1,0,0,0]");
  const RobotProgram several = parsed(
      "p.script", go + "def prog():\n" + t1 + kJoints + "go()\n" + t2 + "go()\nend\nprog()\n");
  EXPECT_THAT(lines_of(several), ElementsAre(6));
  EXPECT_THAT(several.warnings,
              ElementsAre("p.script:2: left alone: its tool is not certain: set_tcp depends on "
                          "calls or branches before it"));
  // A function that sets the tool; one that nothing here calls.
  const RobotProgram after =
      parsed("p.script", "def prog():\n" + t1 + "def grip():\n" + t2 +
                             "end\nmovel(p[1,2,3,0,0,0])\ngrip()\nmovel(p[1,2,4,0,0,0])\nend\n");
  EXPECT_EQ(tool_of(after, 0), "p[0,0,0.1,0,0,0]");
  EXPECT_EQ(tool_of(after, 1), "p[0,0,0.2,0,0,0]");
  EXPECT_THAT(lines_of(parsed("p.script", go + "def prog():\n" + t1 + kJoints + "end\n")),
              ElementsAre(6));
  // A branch, a loop, a parameter.
  const std::string move = "movel(p[1,2,3,0,0,0])\n";
  EXPECT_THAT(
      lines_of(parsed("p.script", "def prog():\n" + t1 + kJoints + "if x:\n" + t2 + "elif y:\n" +
                                      move + "end\n" + move + t1 + move + "while z:\n" + move +
                                      "if x:\nbreak\nend\nend\nend\n")),
      ElementsAre(3, 7, 11, 13));
  EXPECT_THAT(lines_of(parsed("p.script",
                              "def prog():\n" + kJoints + "while x:\n" + move + t1 + "end\nend\n")),
              ElementsAre(2));
  EXPECT_THAT(lines_of(parsed("p.script", "def prog():\n" + kJoints + "def use(t):\nset_tcp(t)\n" +
                                              "end\nuse(p[0,0,1,0,0,0])\n" + move + "end\n")),
              ElementsAre(2));
  // One of the branches runs if there is an else; break leaves a loop, return the function.
  const auto left = [&](const std::string& path) {
    const RobotProgram program =
        parsed("p.script", "def prog():\n" + t1 + kJoints + "def path():\n" + path +
                               "return True\nend\npath()\n" + move + "end\n");
    return program.left_alone;
  };
  EXPECT_EQ(left("if x:\n" + t2 + "elif y:\n" + t2 + "else:\n" + t2 + "end\n"), 0);
  EXPECT_EQ(left("if x:\n" + t2 + "elif y:\n" + t2 + "end\n"), 1);
  EXPECT_EQ(left("if x:\n" + t2 + "else:\n" + t1 + "end\n"), 1);
  EXPECT_EQ(left("if x:\n" + t2 + "else:\nreturn False\nend\n"), 1);
  EXPECT_EQ(left("while True:\nif x:\nbreak\nend\nend\n" + t2), 0);
  EXPECT_EQ(left("if x:\n" + t2 + "return False\nend\n" + t2), 0);
  EXPECT_EQ(left("if x:\nreturn False\nend\n" + t2), 1);
  EXPECT_EQ(left("while y:\n" + t2 + "if x:\nbreak\nend\n" + t1 + "end\n"), 1);
}

// It begins with `run`, so what holds before does not count; what its caller sets later does.
TEST(Certainty, AUrThreadHasTheToolThatHoldsWhereItRuns) {
  const std::string t1 = "set_tcp(p[0,0,0.1,0,0,0])\n", t2 = "set_tcp(p[0,0,0.2,0,0,0])\n",
                    thread = "thread T():\nmovel(p[1,2,3,0,0,0])\nend\n", run = "h = run T()\n";
  const auto left = [&](const std::string& body) {
    return parsed("p.script", "def prog():\n" + kJoints + body + "end\n").left_alone;
  };
  const RobotProgram known = parsed("p.script", "def prog():\n" + kJoints + t1 + thread +
                                                    "while x:\nif y:\n" + run + "end\nend\nend\n");
  EXPECT_EQ(known.left_alone, 0);
  EXPECT_EQ(tool_of(known, 1), "p[0,0,0.1,0,0,0]");
  EXPECT_EQ(left(t2 + thread + t1 + run + "kill h\n"), 0);
  EXPECT_EQ(left(t1 + thread + run + t2), 1);
  EXPECT_EQ(left(t1 + thread + "while x:\n" + run + t2 + "end\n"), 1);
  EXPECT_EQ(left(t1 + thread + run + "def later():\n" + t2 + "end\nlater()\n"), 1);
  EXPECT_EQ(left(thread + "if x:\n" + t1 + "else:\n" + t2 + "end\n" + run), 1);
  EXPECT_EQ(left(t1 + thread + "thread U():\n" + t2 + "end\n" + run + "u = run U()\n"), 1);
  // A function that a thread calls runs at any time, too.
  const std::string move = "movel(p[1,2,4,0,0,0])\n",
                    calls = "def two():\n" + t2 + "end\nthread U():\ntwo()\nend\n";
  EXPECT_EQ(left(t1 + calls + "u = run U()\n" + move), 1);
  EXPECT_EQ(left(t1 + calls + move), 0);
  // What a thread starts, itself or by a call, runs behind the start of that thread.
  const std::string home = "def home():\n" + move + thread + run + "end\n",
                    both = t2 + home + "thread U():\nhome()\nend\n", run_both = "u = run U()\n";
  EXPECT_EQ(left(both + t1 + run_both), 0);
  EXPECT_EQ(left(both + t1 + run_both + "home()\n"), 0);
  EXPECT_EQ(left(both + "home()\n" + t1 + run_both), 2);
  EXPECT_EQ(left(both + t1 + run_both + t2), 2);
  // A counter that PolyScope starts first says nothing about others.
  const std::string counter = "thread C():\nwhile True:\nn = n + 1\nend\nend\nrun C()\n";
  EXPECT_EQ(left(counter + t1 + thread + run), 0);
  EXPECT_EQ(left(counter + t1 + thread + run + t2), 1);
  // What nothing runs or calls never runs, and nothing that it does counts.
  EXPECT_EQ(left(t1 + thread), 0);
  const RobotProgram unused =
      parsed("p.script", "def prog():\n" + kJoints + t1 + thread + "def rq_library():\n" + t2 +
                             "movel(p[1,2,4,0,0,0])\n" + kJoints + "end\n" + run + "end\n");
  EXPECT_EQ(unused.left_alone, 0);
  ASSERT_THAT(lines_of(unused), ElementsAre(2, 5, 10));
  EXPECT_TRUE(unused.targets[2].never_runs);
  EXPECT_FALSE(unused.targets[1].never_runs);
  // Nor do functions that only call one another.
  const RobotProgram cycle =
      parsed("p.script", "def prog():\n" + kJoints + "def one():\ntwo()\nmovel(p[1,2,3,0,0,0])\n" +
                             "end\ndef two():\none()\nmovel(x)\nend\nend\n");
  EXPECT_EQ(cycle.left_alone, 0);
  EXPECT_FALSE(cycle.targets.at(0).never_runs);
}

TEST(Certainty, WhatStandsBehindHaltOfUrNeverRuns) {
  const std::string move = "movel(p[1,2,3,0,0,0])\n";
  const auto never_run = [&](const std::string& text) {
    std::vector<int> lines;
    for (const ProgramTarget& target : parsed("p.script", "def p():\n" + text + "end\n").targets)
      if (target.never_runs) lines.push_back(target.line);
    return lines;
  };
  EXPECT_THAT(never_run(move + "halt\n" + move), ElementsAre(4));
  EXPECT_THAT(never_run(move + "halt # done\n" + move), ElementsAre(4));
  EXPECT_THAT(never_run(move + "return True\n" + move), ElementsAre(4));
  EXPECT_THAT(never_run("if x:\nhalt\nend\n" + move), ElementsAre());
  EXPECT_THAT(never_run("def f():\n" + move + "return 1\nend\nf()\n" + move), ElementsAre());
  EXPECT_THAT(never_run("def f():\n" + move + "halt\n" + move + "end\nf()\n" + move),
              ElementsAre(5, 8));
}

TEST(Certainty, AUrPoseThatConstantsMakeIsCorrected) {
  const auto place = [](const std::string& moves) -> std::string {
    const RobotProgram program = parsed("p.script", kJoints + "a = p[0.4,0,0.5,0,0,0]\n" + moves);
    const ProgramTarget& target = program.targets.back();
    if (target.kind == TargetKind::joints) return "";
    const ProgramFrame frame = target.base < 0
                                   ? ProgramFrame{"", Pose{}, true}
                                   : program.frames.at(static_cast<size_t>(target.base));
    if (!frame.is_known) return frame.name;
    const Eigen::Vector3d at = (frame.pose * target.pose).translation * 10;
    return std::to_string(std::lround(at.x())) + std::to_string(std::lround(at.z()));
  };
  const std::string shift = "p[0.1,0,0.2,0,0,0]";
  EXPECT_EQ(place("movel(pose_add(a, " + shift + "))\n"), "57");
  EXPECT_EQ(place("s = " + shift + "\nmovel(pose_add(a, pose_inv(s)))\n"), "33");
  EXPECT_EQ(place("movel(pose_trans(pose_trans(a, " + shift + "), a))\n"), "912");
  EXPECT_EQ(place("movel(pose_trans(pose_inv(a), " + shift + "))\n"), "-3-3");
  EXPECT_EQ(place("movel(pose_trans(a, pose_trans(" + shift + ", a)))\n"), "912");
  EXPECT_EQ(place("movel(pose_add(pose_trans(a, a), " + shift + "))\n"), "912");
  EXPECT_EQ(place("movel(pose_trans(b, pose_trans(" + shift + ", a)))\n"), "");
  EXPECT_EQ(place("movel(pose_trans(a, pose_trans(b, a)))\n"), "");
  EXPECT_EQ(place("movel(pose_add(a, p[0.1,0,0.2,0,0,0.1]))\n"), "");
  EXPECT_EQ(place("movel(pose_add(get_actual_tcp_pose(), a))\n"), "");
  const std::string declared = "a = p[0.4,0,0.5,0,0,0]\n", end = shift + "))\nforce_mode(a, 1)\n";
  EXPECT_THAT(raised(parsed("p.script", kJoints + declared + "movel(pose_add(a, " + end)),
              HasSubstr(declared + "movel(pose_add(p[0.4,0,0.501,0,0,0], " + end));
}

TEST(Certainty, AUrFrameThatIsCalculatedIsNoPlace) {
  const std::string head = "def prog():\n" + kJoints, move = "p[1,2,3,0,0,0]))\n";
  for (const std::string frame : {"movel(pose_trans(get_actual_tcp_pose(), ",
                                  "here = get_actual_tcp_pose()\nmovel(pose_trans(here, ",
                                  "f = p[1,0,0,0,0,0]\nf = p[2,0,0,0,0,0]\nmovel(pose_trans(f, "}) {
    const RobotProgram program = parsed("p.script", head + frame + move + "end\n");
    EXPECT_THAT(program.warnings, ElementsAre(HasSubstr("its frame is calculated at run time")))
        << frame;
    EXPECT_EQ(program.targets.size(), 1u);
  }
  const std::string text = head + "f = g()\nmovel(pose_trans(f, " + move + "end\n";
  EXPECT_EQ(
      parse_program(*find_dialect("urscript"), {{"p.script", text}}, {{"f", Pose{}}}).left_alone,
      0);
  // One that the installation holds.
  EXPECT_EQ(parsed("p.script", head + "movel(pose_trans(f, " + move + "end\n").left_alone, 0);
  // A tool with several values; one that only this solution has.
  EXPECT_THAT(parsed("p.script", head + "t = p[0,0,1,0,0,0]\nset_tcp(t)\nmovel(p[1,2,3,0,0,0])\n"
                                        "t = p[0,0,2,0,0,0]\nset_tcp(t)\nend\n")
                  .warnings,
              ElementsAre(HasSubstr("its tool is not certain")));
  const std::string inverse = "movej(get_inverse_kin(p[1,2,3,0,0,0], [0,-1,1,0,1,0], 1e-10, 1e-10";
  EXPECT_EQ(parsed("p.script", head + inverse + "))\nend\n").left_alone, 0);
  EXPECT_EQ(parsed("p.script", head + inverse + ", p[0,0,1,0,0,0]))\nend\n").left_alone, 1);
}

// One pose of --frame cannot be that of all moves.
TEST(Certainty, ARapidFrameThatIsSetAgainIsNoPlace) {
  const auto left_of = [](const std::string& first, const std::string& second,
                          const std::string& move = "MoveL p10,v1,fine,t\\WObj:=w;\n") {
    const std::string pose = "[[0,0,0],[1,0,0,0]]";
    return parse_program(
               *find_dialect("rapid"),
               {{"p.mod", "MODULE m\n" + robtarget("p10") + "PERS wobjdata w:=[FALSE,TRUE,\"\"," +
                              pose + "," + pose + "];\nPERS tooldata t:=[TRUE," + pose +
                              ",[1,[0,0,1],[1,0,0,0],0,0,0]];\nPROC main()\nMoveAbsJ "
                              "[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v1,fine,t;\n" +
                              first + move + second + "ENDPROC\nENDMODULE\n"}},
               {{"W", Pose{}}, {"T", Pose{}}, {"V", Pose{}}})
        .left_alone;
  };
  EXPECT_EQ(left_of("w.oframe:=a;\n", ""), 0);
  EXPECT_EQ(left_of("w.oframe.trans.x:=a;\n", "w.oframe.trans.y:=b;\n"), 0);
  EXPECT_EQ(left_of("t.tload:=a;\n", "t.tload := b;\n"), 0);
  EXPECT_EQ(left_of("w.oframe:=a;\n", "w.oframe := b;\n"), 1);
  EXPECT_EQ(left_of("w.oframe.trans.x:=a;\n", "w.oframe:=b;\n"), 1);
  EXPECT_EQ(left_of("w:=a;\n", "w.uframe.rot:=b;\n"), 1);
  EXPECT_EQ(left_of("t.tframe:=a;\n", "t.tframe:=b;\n"), 1);
  // Declared in a module that is not given.
  EXPECT_EQ(left_of("v:=a;\n", "v:=b;\n", "MoveL p10,v1,fine,t\\WObj:=v;\n"), 1);
}

// Where assignments of constants hold for certain, and nowhere else.
TEST(Certainty, ARapidRecordHasWhatItsAssignmentsGiveIt) {
  const std::string pose = "[[0,0,0],[1,0,0,0]]";
  const auto heights = [&](const std::string& statements, const std::string& routines = "") {
    const RobotProgram program = parsed(
        "p.mod", "MODULE m\n" + robtarget("p1") + "VAR robtarget pv;\nPERS tooldata t:=[TRUE," +
                     pose + ",[1,[0,0,1],[1,0,0,0],0,0,0]];\nPERS wobjdata w:=[FALSE,TRUE,\"\"," +
                     pose + "," + pose + "];\nPROC main()\nMoveL p1,v1,fine,tool0;\n" + statements +
                     "ENDPROC\n" + routines + "ENDMODULE\n");
    std::vector<double> found;  // [mm] of the base, the point and the tool
    for (const ProgramTarget& target : program.targets)
      found.push_back(1e3 *
                      (program.frames[static_cast<size_t>(target.base)].pose.translation.z() +
                       target.pose.translation.z() +
                       program.frames[static_cast<size_t>(target.tool)].pose.translation.z()));
    return found;
  };
  const auto of_p1 = heights("").at(0);
  const auto last = [&](const std::string& statements, const std::string& routines = "") {
    const std::vector<double> all = heights(statements, routines);
    return all.size() == 2 ? std::optional(std::round(1e6 * (all[1] - of_p1)) / 1e6) : std::nullopt;
  };
  const std::string by_w = "MoveL p1,v1,fine,tool0\\WObj:=w;\n", by_t = "MoveL p1,v1,fine,t;\n",
                    to_pv = "MoveL pv,v1,fine,tool0;\n";
  EXPECT_EQ(last("w.uframe:=[[0,0,7],[1,0,0,0]];\nw.oframe.trans.z:=2;\n" + by_w), 9);
  EXPECT_EQ(last("w.uframe.trans.z:=7;\nw.uframe:=[[0,0,3],[1,0,0,0]];\n" + by_w), 3);
  EXPECT_EQ(last("t.tframe:=[[0,0,50],[1,0,0,0]];\n" + by_t), 50);
  EXPECT_EQ(last("pv:=p1;\npv.trans.z:=pv.trans.z+2*4;\n" + to_pv), 8);
  EXPECT_EQ(last("pv:=[p1.trans,p1.rot,p1.robconf,p1.extax];\n" + to_pv), 0);
  EXPECT_EQ(last("lift;\n" + by_w, "PROC lift()\nw.uframe.trans.z:=4;\nENDPROC\n"), 4);
  EXPECT_EQ(last("IF a lift;\n" + by_w, "PROC lift()\nw.uframe.trans.z:=4;\nENDPROC\n"),
            std::nullopt);
  EXPECT_EQ(last("IF a w.uframe.trans.z:=4;\n" + by_w), std::nullopt);
  EXPECT_EQ(last("w.uframe.trans.z:=h;\n" + by_w), std::nullopt);
  EXPECT_EQ(last(by_w + "w.uframe.trans.z:=4;\n"), std::nullopt);  // of the last run
  EXPECT_EQ(last("pv.trans:=p1.trans;\n" + to_pv), std::nullopt);
  EXPECT_EQ(last("pv:=p1;\nAdd pv.trans.z,5;\n" + to_pv), std::nullopt);
  EXPECT_EQ(last("pv:=p1;\nWHILE a DO\npv.trans.z:=pv.trans.z+5;\nENDWHILE\n" + to_pv),
            std::nullopt);
}

TEST(Certainty, ARapidMoveMayNameItsArgumentsOrBeNamed) {
  const RobotProgram program =
      parsed("p.mod", robtarget("p1") +
                          "PROC main()\nMoveL ToPoint:=p1,v1,fine,Tool:=tool0;\n"
                          "%\"MoveL\"%p1,v1,fine,tool0;\nENDPROC\n");
  EXPECT_EQ(program.targets.size(), 1u);
  EXPECT_EQ(program.left_alone, 1);
}

TEST(Certainty, AUrNameIsThatOfItsCapitals) {
  const RobotProgram program =
      parsed("p.script", "def prog():\na = p[1,2,3,0,0,0]\nA = p[1,2,4,0,0,0]\n" + kJoints +
                             "movel(a)\nmovel(A)\nmovel(b)\nend\ndef go(B):\nmovel(b)\nend\n");
  ASSERT_EQ(program.targets.size(), 3u);
  EXPECT_NEAR(program.targets[1].pose.translation.z(), 3, 1e-12);
  EXPECT_NEAR(program.targets[2].pose.translation.z(), 4, 1e-12);
  EXPECT_EQ(program.left_alone, 2);
}

std::string fanuc_position(int number, const std::string& frames = "UF : 1, UT : 1") {
  return "P[" + std::to_string(number) + "]{\n GP1:\n " + frames +
         ", CONFIG : 'N U T, 0, 0, 0',\n X = 1.000 mm, Y = 2.000 mm, Z = 3.000 mm,\n"
         " W = 0.0 deg, P = 0.0 deg, R = 0.0 deg\n};\n";
}

RobotProgram fanuc(const std::string& moves, const std::string& positions) {
  return parsed("p.ls", "/PROG P\n/MN\n" + moves + "/POS\n" + positions + "/END\n");
}

TEST(Certainty, AFanucToolInTheRoomAndADisplacedMoveAreNamed) {
  const RobotProgram program = fanuc(
      "1:L P[1] 9mm/sec FINE ;\n2:L P[1] 9mm/sec FINE RTCP ;\n"
      "3:L P[1] 9mm/sec FINE Offset,PR[1] ;\n4:L P[2:Offset INC] 9mm/sec FINE ;\n"
      "5:L PR[1] 9mm/sec FINE Offset,PR[1] ;\n6:L P[2] 9mm/sec FINE Skip,LBL[1],PR[5]=LPOS ;\n",
      fanuc_position(1) + fanuc_position(2));
  EXPECT_THAT(lines_of(program), ElementsAre(3, 6, 8));
  EXPECT_THAT(
      program.warnings,
      ElementsAre("p.ls:4: left alone: its tool stands in the room (RTCP)",
                  "p.ls:5: left alone: the move is displaced (OFFSET), and no listing "
                  "(--with POSREG.VA) says by how much, or it turns, or the program sets its "
                  "register",
                  "p.ls:7: left alone: its point is a register, and no listing (--with "
                  "POSREG.VA) has it, or the program sets it"));
}

TEST(Certainty, RapidOffsetsMayStandInOneAnother) {
  const auto program = [](int depth) {
    std::string point = "p1";
    for (int k = 0; k < depth; ++k) point += ",0,0,1)";
    std::string begin;
    for (int k = 0; k < depth; ++k) begin += "Offs(";
    return parsed("p.mod", robtarget("p1") + "MoveL p1,v1,fine,tool0;\nMoveL " + begin + point +
                               ",v1,fine,tool0;\n");
  };
  const RobotProgram two = program(2);
  ASSERT_THAT(lines_of(two), ElementsAre(2, 3));
  EXPECT_NEAR(two.targets[1].pose.translation.z(), 5e-3, 1e-12);
  EXPECT_THAT(lines_of(program(20000)), ElementsAre(2));
}

TEST(Certainty, ARapidDisplacementGoesWithCallsFromModuleToModule) {
  const Dialect& dialect = *find_dialect("rapid");
  const auto lines = [&](const std::string& own, const std::string& other) {
    const std::vector<ProgramText> program{{"own.mod", "MODULE own\n" + own + "ENDMODULE\n"}};
    const std::vector<ProgramText> others{{"other.mod", "MODULE other\n" + other + "ENDMODULE\n"}};
    return lines_of(parse_program(dialect, program, {}, TargetParts::pose,
                                  what_others_declare(dialect, program, others)));
  };
  const std::string move = "MoveL [[1,2,3]" + kTail + ",v1,fine,tool0;\n", end = "ENDPROC\n",
                    main = "PROC main()\n" + move + "shift;\n" + move + end,
                    shift = "PROC shift()\n", on = "PDispSet d;\n", off = "PDispOff;\n";
  EXPECT_THAT(lines(main, shift + on + end), ElementsAre(3));
  EXPECT_THAT(lines(main, shift + "deeper;\n" + end + "PROC deeper()\nPDispOn d,e;\n" + end),
              ElementsAre(3));
  EXPECT_THAT(lines(main, shift + on + "MOVE;\n" + off + end), ElementsAre(3, 5));
  EXPECT_THAT(lines("PROC main()\n" + on + move + "shift;\n" + move + end, shift + off + end),
              ElementsAre(6));
  // A part that another module calls with a displacement, or with and without one.
  const std::string part = "PROC main()\n" + move + end + "PROC part()\n" + move + end,
                    all = "PROC all()\n";
  EXPECT_THAT(lines(part, all + "part;\n" + end + "PROC teach()\n" + on + end), ElementsAre(3, 6));
  EXPECT_THAT(lines(part, all + on + "part;\n" + off + end), ElementsAre(3));
  EXPECT_THAT(lines(part, all + "part;\n" + on + "part;\n" + off + end), ElementsAre(3));
}

TEST(Certainty, AFanucFrameThatAnotherProgramSetsIsNotTheListedOne) {
  const Dialect& dialect = *find_dialect("fanuc");
  const auto program = [](const std::string& moves, const std::string& positions) {
    return "/PROG P\n/MN\n" + moves + "/POS\n" + positions + "/END\n";
  };
  const std::string listing =
      "[*SYSTEM*]$MNUFRAME  Storage: SHADOW  Access: RW  : ARRAY[1,9] OF POSITION\n"
      "  [1,1] =   Group: 1   Config: N D B, 0, 0, 0\n"
      "  X: 100.0 Y: 0.0 Z: 0.0\n  W: 0.0 P: 0.0 R: 0.0\n";
  const std::vector<ProgramText> own{
      {"MAIN.LS", program("1:  CALL SETF ;\n2:L P[1] 9mm/sec FINE ;\n3:L P[2] 9mm/sec FINE ;\n",
                          fanuc_position(1) + fanuc_position(2, "UF : 0, UT : 0"))}};
  const auto read = [&](const std::string& other, const KnownFrames& known = {}) {
    return parse_program(
        dialect, own, known, TargetParts::pose,
        what_others_declare(dialect, own,
                            {{"SYSFRAME.VA", listing}, {"SETF.LS", program(other, "")}}));
  };
  EXPECT_THAT(lines_of(read("1:  UFRAME[2]=PR[3] ;\n2:  PR[4]=UFRAME[1] ;\n")), ElementsAre(4, 5));
  const KnownFrames given{{"UF[1]", Pose{}}};
  for (const char* const set : {"1:  UFRAME[1]=PR[3] ;\n", "1:  BENUTZER[1:name]=PR[3] ;\n",
                                "1:  UFRAME[R[1]]=PR[3] ;\n"}) {
    const RobotProgram left = read(set);
    EXPECT_THAT(lines_of(left), ElementsAre(5)) << set;
    EXPECT_THAT(left.warnings, Contains(HasSubstr("MAIN.LS:4: left alone: another program sets "
                                                  "UFRAME[1]; say where it is: --frame UF[1]=")));
    EXPECT_THAT(lines_of(read(set, given)), ElementsAre(4, 5)) << set;
  }
}

// The variables of the controller are the same frames.
TEST(Certainty, AFanucProgramMaySetFramesAsVariables) {
  const std::string active = "1:  UFRAME_NUM=1 ;\n2:  UTOOL_NUM=1 ;\n",
                    moves = "4:L P[1] 9mm/sec FINE ;\n5:L P[2] 9mm/sec FINE ;\n",
                    positions =
                        fanuc_position(1, "UF : F, UT : F") + fanuc_position(2, "UF : 2, UT : 1");
  const auto lines = [&](const std::string& set) {
    return lines_of(fanuc(active + "3:  " + set + " ;\n" + moves, positions));
  };
  EXPECT_THAT(lines("$MNUFRAMENUM[2]"), ElementsAre(6, 7));  // sets nothing
  EXPECT_THAT(lines("$MNUFRAMENUM[1]=3"), ElementsAre(7));
  EXPECT_THAT(lines("$MNUTOOLNUM[1]=3"), ElementsAre(7));
  EXPECT_THAT(lines("$WAITTMOUT=3"), ElementsAre(6, 7));
  EXPECT_THROW(lines("$MNUFRAME[1,2]=PR[3]"), NoTargets);
  EXPECT_THROW(lines("$MNUTOOL[1,1].$X=3"), NoTargets);
}

// In /MN a comment stands in brackets without quotes: what follows it is no text.
TEST(Certainty, AFanucCommentMayHoldAnApostrophe) {
  const std::string move = "1:L P[1] 9mm/sec FINE ;\n",
                    positions = fanuc_position(1) + fanuc_position(2);
  const auto lines = [&](const std::string& others) {
    return lines_of(fanuc(move + others, positions));
  };
  EXPECT_THAT(lines("2:L P[2:point d'appro] 9mm/sec FINE Offset,PR[1] ;\n"), ElementsAre(3));
  EXPECT_THAT(lines("2:L P[2:point d'appro] 9mm/sec FINE ;\n"), ElementsAre(3, 4));
  EXPECT_THAT(lines("2:  P[2:d'ici]=LPOS ;\n3:L P[2] 9mm/sec FINE ;\n"), ElementsAre(3));
  const std::string listing =
      "[*POSREG*]$POSREG  Storage: SHADOW  Access: RW  : ARRAY[1,9] OF Position Reg\n"
      "  [1,1] =   'd'ici'   Group: 1   Config: N U T, 0, 0, 0\n"
      "  X: 1.0 Y: 2.0 Z: 3.0\n  W: 0.0 P: 0.0 R: 0.0\n";
  const auto with_listing = [&](const std::string& before) {
    return lines_of(parse_program(*find_dialect("fanuc"),
                                  {{"p.ls", "/PROG P\n/MN\n" + move + before +
                                                "3:  UFRAME_NUM=1 ;\n4:  UTOOL_NUM=1 ;\n"
                                                "5:L PR[1] 9mm/sec FINE ;\n/POS\n" +
                                                positions + "/END\n"}},
                                  {}, TargetParts::pose, {{"POSREG.VA", listing}}));
  };
  EXPECT_THAT(with_listing("2:  PR[2:d'ici]=LPOS ;\n"), ElementsAre(3, 7));
  EXPECT_THAT(with_listing("2:  PR[1:d'ici]=LPOS ;\n"), ElementsAre(3));
  EXPECT_THAT(with_listing("2:  PR[GP1:1,3:d'ici]=5 ;\n"), ElementsAre(3, 7));
  EXPECT_THAT(with_listing("2:  PR[GP1:1,3:d'ici]=R[1] ;\n"), ElementsAre(3));
  EXPECT_THAT(with_listing("2:  PR[1,3]=5 ;\n3:  CALL OTHER ;\n"), ElementsAre(3));
  EXPECT_THAT(with_listing("2:  SEARCH START[1] PR[1] ;\n"), ElementsAre(3));
}

TEST(Certainty, AFanucMoveBehindATouchOffsetIsDisplaced) {
  const std::string move = "L P[1] 9mm/sec FINE ;\n";
  const RobotProgram program =
      fanuc("1:" + move + "2:  --eg:L P[1] PR[5]=P[1] ;\n3:  Touch Offset PR[32] ;\n4:" + move +
                "5:  Touch Offset End ;\n6:" + move,
            fanuc_position(1));
  EXPECT_THAT(lines_of(program), ElementsAre(3, 8));
  EXPECT_THAT(program.warnings,
              ElementsAre("p.ls:6: left alone: the move is displaced (Touch Offset)"));
  EXPECT_THAT(raised(program), HasSubstr("3:  Touch Offset PR[32] ;\n4:L P[1] 9mm"));
}

// With a positioner at `turn`.
std::string coordinated(int number, const std::string& turn) {
  std::string position = fanuc_position(number);
  position.insert(position.find("};"), "GP2:\nUF : 1, UT : 2,\nJ1 = " + turn + " deg\n");
  return position;
}

TEST(Certainty, AFanucFrameOnAPositionerIsKnownWhileThatStands) {
  const std::string moves = "1:L P[1] 9mm/sec FINE COORD ;\n2:L P[2] 9mm/sec FINE ;\n";
  const RobotProgram standing = fanuc(moves, coordinated(1, "20.0") + coordinated(2, "20.0"));
  EXPECT_THAT(lines_of(standing), ElementsAre(3, 4));
  EXPECT_FALSE(standing.frames[0].is_known);  // --frame says where it stands then
  for (const std::string& positions : {coordinated(1, "20.0") + coordinated(2, "20.1"),
                                       coordinated(1, "20.0") + fanuc_position(2)})
    EXPECT_THAT(lines_of(fanuc(moves, positions)), ElementsAre(4)) << positions;
}

TEST(Certainty, AFanucPointThatOtherStatementsUseStaysAndItsMovesGetANewOne) {
  const std::string move = "1:L P[1] 9mm/sec FINE ;\n", number = fanuc_position(1);
  for (const char* const use :
       {"2:  PR[5]=P[1] ;\n", "2:L P[R[1]] 9mm/sec FINE ;\n", "2:  PR[5]=P[R[1]] ;\n",
        "2:L P[1] 9mm/sec FINE INC ;\n", "2:L P[1] 9mm/sec FINE COORD ;\n",
        "2:L P[1] 9mm/sec FINE RTCP ;\n"})
    EXPECT_THAT(raised(fanuc(move + use, number)),
                AllOf(HasSubstr("1:L P[2] 9mm/sec FINE ;\n" + std::string(use)),
                      HasSubstr(number + "P[2]{"), HasSubstr("Z = 4.000 mm")))
        << use;
  // An offset follows the point.
  EXPECT_THAT(raised(fanuc(move + "2:L P[1] 9mm/sec FINE Offset,PR[1] ;\n", number)),
              HasSubstr("1:L P[1] 9mm/sec FINE ;"));
  EXPECT_THROW(fanuc("1:  P[R[1]]=LPOS ;\n2:L P[1] 9mm/sec FINE ;\n", number), InputError);
}

TEST(Certainty, AFanucPointInTheActiveFrameNeedsItsNumber) {
  const std::string at = "P[1]", move = "L P[1] 9mm/sec FINE ;\n";
  const auto lines = [&](const std::string& moves) {
    return lines_of(fanuc("1:J P[2] 9% FINE ;\n" + moves,
                          fanuc_position(1, "UF : F, UT : F") + fanuc_position(2)));
  };
  const std::string numbers = "2:  UFRAME_NUM=2 ;\n3:  UTOOL_NUM=3 ;\n";
  EXPECT_THAT(lines("2:" + move), ElementsAre(3));
  EXPECT_THAT(lines(numbers + "4:" + move), ElementsAre(3, 6));
  EXPECT_THAT(lines("2:  UFRAME_NUM=2 ;\n3:" + move), ElementsAre(3));
  EXPECT_THAT(lines(numbers + "4:  CALL A ;\n5:" + move), ElementsAre(3));
  EXPECT_THAT(lines(numbers + "4:  UTOOL_NUM=R[1] ;\n5:" + move), ElementsAre(3));
  EXPECT_THAT(lines(numbers + "4:  IF (R[1]=1),UTOOL_NUM=2 ;\n5:" + move), ElementsAre(3));
  EXPECT_THAT(lines(numbers + "4:  IF R[1]=1 THEN ;\n5:  UTOOL_NUM=3 ;\n6:  ENDIF ;\n7:" + move),
              ElementsAre(3, 9));
  EXPECT_THAT(lines(numbers + "4:  IF R[1]=1 THEN ;\n5:  UTOOL_NUM=4 ;\n6:  ELSE ;\n" +
                    "7:  UTOOL_NUM=4 ;\n8:  ENDIF ;\n9:" + move),
              ElementsAre(3, 11));
  EXPECT_THAT(lines(numbers + "4:  LBL[1] ;\n5:" + move + "6:  UTOOL_NUM=4 ;\n7:  JMP LBL[1] ;\n"),
              ElementsAre(3));
  const RobotProgram program = fanuc(numbers + "4:" + move, fanuc_position(1, "UF : F, UT : F"));
  EXPECT_EQ(tool_of(program, 0), "UT[3]");
}

TEST(Certainty, AFanucMoveToWhichNoJumpLeadsNeverRuns) {
  const auto never_run = [](const std::string& between) {
    const RobotProgram program =
        fanuc("1:J P[2] 9% FINE ;\n2:  " + between + "3:L P[1] 9mm/sec FINE ;\n",
              fanuc_position(1) + fanuc_position(2));
    return program.targets.back().never_runs;
  };
  const std::string jump = "JMP LBL[2] ;\n", label = "  LBL[1:gripped] ;\n",
                    end = "  LBL[2] ;\n  END ;\n";
  EXPECT_TRUE(never_run(jump + end + label));
  EXPECT_TRUE(never_run("JMP LBL[7] ;\n" + label));
  EXPECT_TRUE(never_run("ABORT ;\n" + label));
  EXPECT_FALSE(never_run("IF DI[1]=ON,JMP LBL[1] ;\n" + jump + end + label));
  EXPECT_FALSE(never_run("WAIT DI[1]=ON TIMEOUT,LBL[1] ;\n" + jump + end + label));
  EXPECT_FALSE(never_run("SELECT R[1]=1,JMP LBL[1] ;\n" + jump + end + label));
  EXPECT_FALSE(never_run("JMP LBL[R[1]] ;\n" + label));
  EXPECT_TRUE(never_run("JMP LBL[R[1]] ;\n"));
  EXPECT_FALSE(never_run("IF DI[1]=ON,JMP LBL[2] ;\n" + label + "  LBL[2] ;\n"));
}

// What a program that is called, or that this calls, does to frames: where its text is there and
// names none, they stay.
TEST(Certainty, AFanucCallOfAProgramWithoutFramesKeepsThem) {
  const Dialect& dialect = *find_dialect("fanuc");
  const auto text = [](const std::string& name, const std::string& lines,
                       const std::string& positions = "") {
    return ProgramText{name + ".LS",
                       "/PROG " + name + "\n/MN\n" + lines + "/POS\n" + positions + "/END\n"};
  };
  const auto frames_of_move = [&](const std::string& call, const std::string& of_a,
                                  const std::string& of_b) {
    const std::vector<ProgramText> own{
        text("MAIN",
             "1:  UFRAME_NUM=2 ;\n2:  UTOOL_NUM=3 ;\n3:  " + call +
                 " ;\n4:L P[1] 9mm/sec FINE ;\n5:L P[2] 9mm/sec FINE ;\n",
             fanuc_position(1, "UF : F, UT : F") + fanuc_position(2))};
    const RobotProgram program =
        parse_program(dialect, own, {}, TargetParts::pose,
                      what_others_declare(dialect, own, {text("A", of_a), text("B", of_b)}));
    std::vector<std::string> frames;
    for (const ProgramTarget& target : program.targets)
      if (target.line == 6)
        frames = {program.frames.at(target.base).name, program.frames.at(target.tool).name};
    return frames;
  };
  const std::string gripper = "1:  RO[1]=ON ;\n2:  PR[7]=LPOS ;\n", calls_b = "1:  CALL B ;\n";
  for (const std::string& call : {"CALL A", "AUFRUF A(1)", "RUN A", "IF DI[1]=ON,CALL A"}) {
    EXPECT_THAT(frames_of_move(call, gripper, ""), ElementsAre("UF[2]", "UT[3]")) << call;
    EXPECT_THAT(frames_of_move(call, calls_b, gripper), ElementsAre("UF[2]", "UT[3]")) << call;
    for (const std::string set : {"UFRAME_NUM=1", "UTOOL_NUM=1", "WKZ_NUM=1", "UTOOL[3]=PR[1]",
                                  "IF (R[1]=1),UFRAME_NUM=R[1]", "$MNUFRAMENUM[1]=1", "CALL C"})
      EXPECT_THAT(frames_of_move(call, calls_b, "1:  " + set + " ;\n"), ElementsAre())
          << call << ", " << set;
  }
}

TEST(Certainty, AFanucFrameThatTheProgramSetsIsNotKnownFromThereOn) {
  const std::string move = "L P[1] 9mm/sec FINE ;\n";
  const auto lines = [&](const std::string& moves) {
    return lines_of(fanuc(moves + "9:L P[2] 9mm/sec FINE ;\n",
                          fanuc_position(1) + fanuc_position(2, "UF : 2, UT : 2")));
  };
  EXPECT_THAT(lines("1:" + move + "2:  UFRAME[1]=PR[2] ;\n3:" + move), ElementsAre(3, 6));
  EXPECT_THAT(lines("1:" + move + "2:  UTOOL[1]=PR[2] ;\n3:" + move), ElementsAre(3, 6));
  EXPECT_THAT(lines("1:  FOR R[1]=1 TO 4 ;\n2:" + move + "3:  UFRAME[1]=PR[2] ;\n4:  ENDFOR ;\n"),
              ElementsAre(7));
  EXPECT_THAT(lines("1:" + move + "2:  UFRAME[R[1]]=PR[2] ;\n3:" + move), ElementsAre(3));
}

// Where another statement stands on the line of a move, or the move may end elsewhere.
TEST(Certainty, NoMoveFollowsOneThatEndsElsewhere) {
  const RobotProgram skipped = fanuc(
      "1:L P[1] 9mm/sec FINE Skip,LBL[1] ;\n2:L P[1] 9mm/sec FINE ;\n"
      "3:L P[1] 9mm/sec FINE ;\n",
      fanuc_position(1));
  EXPECT_FALSE(skipped.targets[1].follows_target);
  EXPECT_TRUE(skipped.targets[2].follows_target);
  const RobotProgram called =
      parsed("p.script", kJoints +
                             "movel(p[1,2,3,0,0,0]); go()\nmovel(p[1,2,3,0,0,0])\n"
                             "movel(p[1,2,3,0,0,0]);\nmovel(p[1,2,3,0,0,0])\n");
  EXPECT_FALSE(called.targets[2].follows_target);
  EXPECT_TRUE(called.targets[3].follows_target);
  EXPECT_TRUE(called.targets[4].follows_target);
  const std::string branch = "if x:\nmovel(p[1,2,3,0,0,0])\n", behind = "movel(p[1,2,4,0,0,0])\n";
  for (const char* const end : {"x = 1 end\n", "end\n", "local x = 1; end\n"})
    EXPECT_FALSE(parsed("p.script", kJoints + branch + end + behind).targets[2].follows_target)
        << end;
  // What PolyScope writes before each of its nodes does nothing.
  EXPECT_TRUE(
      parsed("p.script", kJoints + "$ 3 \"Waypoint_2\" \"breakAfter\"\nmovel(p[1,2,3,0,0,0])\n")
          .targets[1]
          .follows_target);
  // Arcs of RAPID whose CirPathMode depends on the caller.
  const std::string move = "MoveC p1,p1,v1,fine,tool0;\n";
  const RobotProgram arcs =
      parsed("p.mod", robtarget("p1") + "PROC main()\nMoveL p1,v1,fine,tool0;\n" + move +
                          "part;\n" + "CirPathMode\\ObjectFrame;\npart;\nENDPROC\nPROC part()\n" +
                          "Set do1;\n" + move + "ENDPROC\n");
  EXPECT_TRUE(arcs.targets[2].follows_target);
  EXPECT_FALSE(arcs.targets[4].follows_target);
}

// Lines of the targets to which no way leads.
std::vector<int> never_run(const RobotProgram& program) {
  std::vector<int> lines;
  for (const ProgramTarget& target : program.targets)
    if (target.never_runs) lines.push_back(target.line);
  return lines;
}

TEST(Certainty, AKukaMoveBehindAJumpOrInASubprogramThatNothingCallsNeverRuns) {
  const std::string move = "PTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\n";
  const auto lines = [&](const std::string& body) {
    return never_run(parsed("p.src", "DEF p()\n" + body + "END\n"));
  };
  EXPECT_THAT(lines(move + "RETURN\n" + move + move), ElementsAre(4, 5));
  EXPECT_THAT(lines("GOTO on\n" + move + "on:\n" + move), ElementsAre(3));
  EXPECT_THAT(lines("IF a THEN\nRETURN\n" + move + "ENDIF\n" + move), ElementsAre(4));
  EXPECT_THAT(lines("IF a THEN\nRETURN\nELSE\n" + move + "ENDIF\n" + move), IsEmpty());
  EXPECT_THAT(lines("LOOP\n" + move + "IF a THEN\nEXIT\nENDIF\nENDLOOP\n" + move), IsEmpty());
  EXPECT_THAT(lines("LOOP\n" + move + "ENDLOOP\n" + move), ElementsAre(5));
  EXPECT_THAT(lines("HALT\n" + move), IsEmpty());
  EXPECT_THAT(lines(move + "END\nDEF other()\n" + move), ElementsAre(5));
  EXPECT_THAT(lines(move + "END\nGLOBAL DEF other()\n" + move), IsEmpty());
  EXPECT_THAT(lines("other()\nEND\nDEF other()\n" + move), IsEmpty());
  EXPECT_THAT(lines("a=other()\nEND\nDEFFCT BOOL other()\n" + move), IsEmpty());
  const std::string interrupt = "INTERRUPT DECL 3 WHEN a DO other()\n";
  EXPECT_THAT(lines(interrupt + move + "END\nDEF other()\n" + move), IsEmpty());
  // What never runs is not left alone either.
  const RobotProgram program =
      parsed("p.src", "DEF p()\nLIN XA\n" + move + "RETURN\nLIN XB\n" + move + "END\n");
  EXPECT_EQ(program.left_alone, 1);
}

TEST(Certainty, ARapidMoveBehindAJumpOrInALocalRoutineThatNothingCallsNeverRuns) {
  const std::string move = "MoveL p1,v1,fine,tool0;\n";
  const auto lines = [&](const std::string& body) {
    return never_run(parsed("p.mod", robtarget("p1") + "PROC main()\n" + body + "ENDPROC\n"));
  };
  EXPECT_THAT(lines(move + "RETURN;\n" + move), ElementsAre(5));
  EXPECT_THAT(lines(move + "GOTO on;\n" + move + "on:\n" + move), ElementsAre(5));
  EXPECT_THAT(lines("IF a RETURN;\n" + move), IsEmpty());
  EXPECT_THAT(lines("IF a THEN\nRETURN;\n" + move + "ELSE\n" + move + "ENDIF\n" + move),
              ElementsAre(5));
  EXPECT_THAT(lines("EXIT;\n" + move + "ERROR\n" + move), ElementsAre(4));
  EXPECT_THAT(lines("RETURN;\nENDPROC\nPROC other()\n" + move), IsEmpty());
  const std::string local = "ENDPROC\nLOCAL PROC other()\n" + move;
  EXPECT_THAT(lines(local), ElementsAre(5));
  EXPECT_THAT(lines("other;\n" + local), IsEmpty());
  EXPECT_THAT(lines("%\"other\"%;\n" + local), IsEmpty());
  EXPECT_THAT(lines(move + "main;\n"), IsEmpty());
}

TEST(Certainty, AFanucMoveBehindAJumpOrTheEndNeverRuns) {
  const std::string move = "L P[1] 9mm/sec FINE ;\n";
  const auto lines = [&](const std::string& moves) {
    return never_run(fanuc(moves, fanuc_position(1)));
  };
  EXPECT_THAT(lines("1:" + move + "2:  END ;\n3:" + move), ElementsAre(5));
  EXPECT_THAT(lines("1:  JMP LBL[1] ;\n2:" + move + "3:  LBL[1] ;\n4:" + move), ElementsAre(4));
  EXPECT_THAT(lines("1:  IF R[1]=1,JMP LBL[1] ;\n2:" + move + "3:  LBL[1] ;\n"), IsEmpty());
  EXPECT_THAT(lines("1:  IF R[1]=1 THEN ;\n2:  END ;\n3:  ELSE ;\n4:" + move + "5:  ENDIF ;\n"),
              IsEmpty());
}

// A move that is out of reach.
TEST(Certainty, AMoveThatIsLeftAloneLaterKeepsItsPoints) {
  const std::string joints = "{A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}";
  RobotProgram program = parse_program(
      *find_dialect("krl"),
      {{"p.src", "DEF p()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nPTP " + joints +
                     "\nLIN XP1\nLIN {X 1,Y 2,Z 9,A 0,B 0,C 0}\n"
                     "CIRC {X 1,Y 3,Z 9,A 0,B 0,C 0},{X 2,Y 3,Z 9,A 0,B 0,C 0}\nLIN XP1\nEND\n"},
       {"p.dat", "DEFDAT P\nE6POS XP1={X 1,Y 2,Z 3,A 0,B 0,C 0}\nENDDAT\n"}},
      {});
  ASSERT_THAT(lines_of(program), ElementsAre(4, 5, 6, 7, 7, 8));
  leave_alone(program, {{1, "far"}, {4, "far"}});
  EXPECT_THAT(lines_of(program), ElementsAre(4, 6, 8));
  EXPECT_EQ(program.left_alone, 2);
  EXPECT_THAT(program.warnings, ElementsAre("p.src:5: left alone: far; also lines 7"));
  EXPECT_FALSE(program.targets[1].follows_target);
  EXPECT_THAT(program.targets[1].starts, IsEmpty());
  EXPECT_THAT(program.targets[2].starts, IsEmpty());
  std::vector<ProgramCommand> commands;
  for (const ProgramTarget& target : program.targets) {
    commands.push_back({true, target.q, target.q, target.pose});
    commands.back().pose.translation.z() += 1e-3;
  }
  const RewrittenProgram rewritten = rewrite(program, commands);
  EXPECT_EQ(rewritten.texts[1], program.texts[1].text);
  EXPECT_THAT(rewritten.texts[0],
              AllOf(HasSubstr("LIN XP1\nLIN {X 1,Y 2,Z 10,A 0,B 0,C 0}\nCIRC {X 1,Y 3,Z 9,"),
                    HasSubstr("LIN {X 1,Y 2,Z 4,A 0,B 0,C 0}\nEND")));
}

// An arc of FANUC's A has no auxiliary point: no move before it goes with it.
TEST(Certainty, AnArcOfOnePointIsLeftAloneByItself) {
  RobotProgram program =
      fanuc("1:A P[1] 9mm/sec FINE ;\n2:A P[2] 9mm/sec FINE ;\n3:C P[1]\n:P[2] 9mm/sec FINE ;\n",
            fanuc_position(1) + fanuc_position(2));
  ASSERT_THAT(lines_of(program), ElementsAre(3, 4, 5, 5));
  EXPECT_THAT(targets_of_move(program, 0), ElementsAre(0));
  EXPECT_THAT(targets_of_move(program, 1), ElementsAre(1));
  EXPECT_THAT(targets_of_move(program, 3), ElementsAre(2, 3));
  leave_alone(program, {{0, "far"}});
  EXPECT_THAT(lines_of(program), ElementsAre(4, 5, 5));
}

// What such a routine is called with elsewhere counts for itself only.
TEST(Certainty, ARoutineThatSetsNothingHandsOnWhatItIsCalledWith) {
  const std::string t1 = "set_tcp(p[0,0,0.1,0,0,0])\n", t2 = "set_tcp(p[0,0,0.2,0,0,0])\n",
                    go = "def deep():\nmovel(p[1,2,3,0,0,0])\nend\ndef go():\ndeep()\nend\n",
                    move = "movel(p[1,2,4,0,0,0])\n";
  const RobotProgram program =
      parsed("p.script", "def prog():\n" + kJoints + go + t1 + "go()\n" + move + t2 + "go()\n" +
                             move + "def unused():\ngo()\nend\nend\n");
  EXPECT_THAT(lines_of(program), ElementsAre(2, 11, 14));
  EXPECT_EQ(tool_of(program, 1), "p[0,0,0.1,0,0,0]");
  EXPECT_EQ(tool_of(program, 2), "p[0,0,0.2,0,0,0]");
  EXPECT_THAT(program.warnings,
              ElementsAre("p.script:4: left alone: its tool is not certain: set_tcp depends on "
                          "calls or branches before it"));
  // One that sets a tool, also by a call or in a branch, hands on none.
  for (const std::string& set : {t2, "if x:\n" + t2 + "end\n"})
    EXPECT_EQ(
        parsed("p.script", "def prog():\n" + kJoints + "def deep():\nend\ndef go():\ndeep()\n" +
                               set + "end\n" + t1 + move + "if y:\ngo()\nend\n" + move + "end\n")
            .left_alone,
        1)
        << set;
}

TEST(Certainty, AFlowEndsWhereNothingChanges) {
  using Step = ProgramFlow::Step;
  ProgramFlow flow;  // two routines that call each other, and a thread
  flow.add(Step::routine, 1, "a");
  flow.add(Step::call, 3, "b");
  flow.add(Step::end_routine, 5);
  flow.add(Step::routine, 6, "b");
  flow.add(Step::branch, 7);
  flow.add(Step::call, 8, "a");
  flow.add(Step::end_block, 9);
  flow.add(Step::end_routine, 10);
  flow.add(Step::call, 12, "a");
  EXPECT_EQ(flow.follow({}, 5).at(4), 5);
  const ProgramFlow::Values once = flow.follow({{2, 1}}, 0);
  EXPECT_EQ(once.at(7), 1);
  EXPECT_EQ(once.at(13), 1);
  EXPECT_EQ(once.at(1), ProgramFlow::kUncertain);
  flow.add(Step::interrupt, 20, "t");
  flow.add(Step::end_routine, 25);
  EXPECT_EQ(flow.follow({{2, 1}}, 0).at(22), ProgramFlow::kUncertain);
  EXPECT_EQ(flow.follow({{21, 1}}, 0).at(0), ProgramFlow::kUncertain);
}

}  // namespace
}  // namespace armtrue::certainty_test
