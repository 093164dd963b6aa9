// What is said of a program, and of the two models, before and after it is corrected.

#include "armtrue/compensation/program_findings.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "armtrue/compensation/model_pair.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/programs/corrected_already.h"
#include "armtrue/programs/dialect.h"

namespace armtrue {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

Robot robot(const std::string& name) {
  return read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
}

RobotProgram krl(const std::string& text) {
  return parse_program(*find_dialect("krl"), {{"p.src", text}}, {});
}

const std::string kThree =
    "$TOOL={X 0,Y 0,Z 100,A 0,B 0,C 0}\nPTP {X 800,Y 0,Z 900,A 0,B 80,C 0}\n"
    "LIN {X 810,Y 0,Z 900,A 0,B 80,C 0}\nLIN {X 820,Y 0,Z 900,A 0,B 80,C 0}\n";

TEST(ProgramFindings, OnlyKukaStatesExternalAxes) {
  const Robot rail = robot("kr360-rail");
  EXPECT_EQ(joints_of_program(krl(kThree), rail, "r.yaml").count(), 7);
  const RobotProgram other =
      parse_program(*find_dialect("urscript"), {{"p.script", "movel(p[1,2,3,0,0,0])\n"}}, {});
  try {
    joints_of_program(other, rail, "r.yaml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("p.script: a program of this controller"),
                                    HasSubstr("r.yaml has the joints")));
  }
}

// A program of PolyScope with one waypoint; each arm by its first three lengths a2, a3 and d4 [m].
RobotProgram polyscope(const std::array<double, 3>& arm, const std::array<double, 3>& of_waypoint) {
  const auto rows = [](const char* name, const std::array<double, 3>& l) {
    return fmt::format(
        "<{0}><deltaTheta value=\"0, 0, 0, 0, 0, 0\"/><a value=\"0, {1}, {2}, 0, 0, 0\"/>"
        "<d value=\"0.1807, 0, 0, {3}, 0.11985, 0.11655\"/><alpha value=\"1.570796327, 0, 0, "
        "1.570796327, -1.570796327, 0\"/></{0}>\n",
        name, l[0], l[1], l[2]);
  };
  return parse_program(
      *find_dialect("polyscope"),
      {{"p.urp", "<URProgram>\n" + rows("kinematics", arm) +
                     "<children><MainProgram><children><Move motionType=\"MoveJ\"><children>"
                     "<Waypoint type=\"Fixed\" name=\"W\"><position><JointAngles "
                     "angles=\"0.1, -1.5, 1.7, -1.7, -1.5, 0.4\"/>\n" +
                     rows("Kinematics", of_waypoint) +
                     "</position></Waypoint></children></Move></children></MainProgram>"
                     "</children></URProgram>\n"}},
      {});
}

TEST(ProgramFindings, TheArmThatAProgramStatesIsThatOfTheController) {
  const Robot ur10 = robot("ur10e");
  const std::array<double, 3> own{-0.6127, -0.57155, 0.17415}, printed{-0.61274, -0.57151, 0.1742},
      other{-0.6147, -0.57055, 0.17415}, ur5{-0.425, -0.3922, 0.1333};
  const auto doubt = [&](const std::array<double, 3>& arm, const std::array<double, 3>& waypoint) {
    const RobotProgram program = polyscope(arm, waypoint);
    return doubt_of_stated_arm(program, ur10, joints_of_program(program, ur10, "u.yaml"), "u.yaml");
  };
  EXPECT_EQ(doubt(own, own), "");
  EXPECT_EQ(doubt(printed, own), "");
  // a2 is 2 mm longer and a3 1 mm shorter: apart by sqrt(5 - 4 cos(q3)) mm, at most 3.
  EXPECT_THAT(doubt(other, other), AllOf(HasSubstr("p.urp:2: the arm that the program states here"),
                                         HasSubstr("u.yaml are up to 2.9")));
  EXPECT_THAT(doubt(own, other), HasSubstr("p.urp:4: the arm that"));
  EXPECT_THROW(doubt(ur5, ur5), InputError);
  // The foot of a URDF may be turned.
  Robot turned = ur10;
  turned.chain.base.rotation = rotation_from_abc(180 * kDegree, 0, 0);
  const RobotProgram program = polyscope(own, own);
  EXPECT_EQ(doubt_of_stated_arm(program, turned, joints_of_program(program, turned, "u.yaml"), ""),
            "");
}

TEST(ProgramFindings, WhatTheBackupSaysOfItsArmIsNamed) {
  const auto with = [](const std::string& machine) {
    return parse_program(
        *find_dialect("krl"), {{"p.src", kThree}}, {}, TargetParts::pose,
        {{"R1/Mada/$machine.dat", "DEFDAT $MACHINE PUBLIC\n" + machine + "\nENDDAT\n"}});
  };
  const Robot kr360 = robot("kr360-spindle");
  const auto doubt = [&](const std::string& machine) {
    return doubt_of_arm_name(with(machine), kr360, "r.yaml");
  };
  EXPECT_EQ(doubt("CHAR $TRAFONAME[]=\"#KR360R2830 C4 FLR\""), "");
  EXPECT_EQ(doubt("CHAR $TRAFONAME[]=\"#SCARA\""), "");
  EXPECT_THAT(doubt("CHAR $TRAFONAME[]=\"#KR210R2700_2 S C2 FLR\""),
              HasSubstr("R1/Mada/$machine.dat:2: the arm of this controller is '#KR210R2700_2 S C2 "
                        "FLR', and r.yaml is '"));
  EXPECT_THAT(doubt("$MODEL_NAME[]=\"#KR30HA\""), HasSubstr("is '#KR30HA'"));
  const RobotProgram accurate = with("BOOL $ABS_ACCUR=TRUE");
  EXPECT_EQ(accurate.own_model_line, 2);
  EXPECT_EQ(accurate.texts[accurate.own_model_text].name, "R1/Mada/$machine.dat");
  EXPECT_EQ(with("BOOL $ABS_ACCUR=FALSE").own_model_line, 0);
}

TEST(ProgramFindings, TwoToolsAreAnError) {
  EXPECT_NO_THROW(refuse_two_tools(krl(kThree), false));
  EXPECT_THROW(refuse_two_tools(krl(kThree), true), InputError);
}

TEST(ProgramFindings, SomeMovesOutOfReachAreLeftAloneAndAllAreNot) {
  RobotProgram program = krl(kThree);
  UnreachableTarget some(1, "out of reach");
  some.out_of_reach = {{1, "out of reach"}};
  EXPECT_TRUE(leave_what_is_out_of_reach(some, program));
  EXPECT_EQ(program.targets.size(), 2u);
  EXPECT_THAT(program.why_left_alone[0], HasSubstr("out of reach (frame of this command, tool "));
  UnreachableTarget all(0, "out of reach");
  all.out_of_reach = {{0, "out of reach"}, {1, "out of reach"}};
  EXPECT_FALSE(leave_what_is_out_of_reach(all, program));
  EXPECT_EQ(program.targets.size(), 2u);
}

TEST(ProgramFindings, MovesInFramesThatNobodyStatesAreLeftAloneUnlessAllAre) {
  const std::string at = "{X 800,Y 0,Z 900,A 0,B 80,C 0}\n",
                    tool = "$TOOL={X 0,Y 0,Z 1,A 0,B 0,C 0}\n",
                    base = "$BASE={X 0,Y 0,Z 1,A 0,B 0,C 0}\n";
  const Robot kr360 = robot("kr360-spindle");
  const auto left = [&](const std::string& text) {
    RobotProgram program = krl(text);
    leave_what_has_no_place(program, joints_of_program(program, kr360, "r.yaml"));
    return program.why_left_alone;
  };
  const auto some = left(tool + base + "LIN " + at + "$BASE=BASE_DATA[3]\nLIN " + at);
  ASSERT_EQ(some.size(), 1u);
  EXPECT_THAT(some[0], HasSubstr("--frame 'BASE_DATA[3]=x,y,z,a,b,c'"));
  EXPECT_TRUE(left(tool + "$BASE=BASE_DATA[3]\nLIN " + at).empty());
}

// An arc of which one point is out of reach leaves no target.
TEST(ProgramFindings, AnArcIsOutOfReachWithEitherOfItsPoints) {
  RobotProgram program =
      krl("LIN {X 800,Y 0,Z 900,A 0,B 80,C 0}\n"
          "CIRC {X 810,Y 5,Z 900,A 0,B 80,C 0},{X 820,Y 0,Z 900,A 0,B 80,C 0}\n");
  ASSERT_EQ(program.targets.size(), 3u);
  UnreachableTarget all(0, "out of reach");
  all.out_of_reach = {{0, "out of reach"}, {2, "out of reach"}};
  EXPECT_FALSE(leave_what_is_out_of_reach(all, program));
  EXPECT_EQ(program.targets.size(), 3u);
  UnreachableTarget some(1, "out of reach");
  some.out_of_reach = {{1, "out of reach"}};
  EXPECT_TRUE(leave_what_is_out_of_reach(some, program));
  EXPECT_EQ(program.targets.size(), 1u);
}

TEST(ProgramFindings, FiveTargetsOfANoteAreNamed) {
  Campaign visits;
  std::vector<CorrectedTarget> targets(7);
  for (int k = 0; k < 7; ++k) visits.pose_ids.push_back("P" + std::to_string(k));
  EXPECT_THAT(sentences_of_notes(targets, visits, "t.csv"), IsEmpty());
  for (int k = 1; k < 7; ++k) targets[k].notes.push_back(CommandNote::limit);
  EXPECT_THAT(sentences_of_notes(targets, visits, "t.csv"),
              ElementsAre("t.csv: 6 of 7 targets: limit (P1, P2, P3, P4, P5, ...)"));
}

TEST(ProgramFindings, MovesOfOneCauseAreNamedTogether) {
  Campaign visits;
  visits.line = {3, 4, 5};
  BetweenPoints between;
  between.moves = {{0, 0.1, 1e-4, 0, ""}, {1, 0.1, 2e-4, 0, "a step"}, {2, 0.1, 3e-4, 0, "a step"}};
  EXPECT_THAT(sentences_of_moves(between, visits, "p.src"),
              ElementsAre("p.src: predicted error between points up to 0.3 mm in 2 of 3 moves: a "
                          "step (line 4, 5)"));
}

TEST(ModelPair, ExchangedFilesAreNamed) {
  const Robot nominal = robot("kr360-spindle");
  Robot calibrated = nominal;
  calibrated.std["A1.r"] = 1e-5;
  EXPECT_EQ(why_not_a_pair({calibrated, nominal, "closed.yaml", "nominal.yaml"}), "");
  EXPECT_THAT(why_not_a_pair({nominal, calibrated, "nominal.yaml", "closed.yaml"}),
              HasSubstr("exchange --robot and --controller"));
  Robot turned = nominal;
  turned.chain.links.back().theta += 90 * kDegree;
  EXPECT_THAT(why_not_a_pair({turned, nominal, "a.yaml", "b.yaml"}), HasSubstr("90 deg"));
}

TEST(ModelPair, ArmsThatStandFarApartAreOthers) {
  const Robot nominal = robot("kr360-spindle");
  const ModelPair pair{nominal, nominal, "a.yaml", "b.yaml"};
  EXPECT_EQ(why_other_arm(pair, 49e-3), "");
  EXPECT_THAT(why_other_arm(pair, 51e-3), HasSubstr("a.yaml and b.yaml are different arms"));
}

// Loads that nothing follows are doubted, and only those.
TEST(ModelPair, IdleLoadsAreDoubted) {
  const Robot nominal = robot("ur10e");
  const ModelPair pair{nominal, nominal, "a.yaml", "b.yaml"};
  Campaign visits;
  const size_t without = doubts_of_models(pair, visits, "the commands").size();
  visits.payload_kg = {0, 5};
  const std::vector<std::string> doubts = doubts_of_models(pair, visits, "the commands");
  ASSERT_EQ(doubts.size(), without + 1);
  EXPECT_THAT(doubts.back(), HasSubstr("the payload changes nothing"));
}

// Points show no orientation of the arm; images do, though they read none.
TEST(ModelPair, OrientationsThatNothingShowsAreDoubted) {
  const Robot nominal = robot("ur10e");
  Robot calibrated = nominal;
  calibrated.uncertainty = Uncertainty{};
  calibrated.uncertainty->parameters = {"shoulder_link.theta", "tool.x"};
  const auto doubts = [&] {
    return doubts_of_models({calibrated, nominal, "closed.yaml", "b.yaml"}, {}, "the commands");
  };
  EXPECT_THAT(doubts(), Contains(HasSubstr("no orientation was measured")));
  calibrated.uncertainty->parameters.emplace_back("board plate.x");
  EXPECT_THAT(doubts(), Not(Contains(HasSubstr("no orientation was measured"))));
}

TEST(CorrectedAlready, AMarkedTextIsRefused) {
  std::string text = "DEF p()\nEND\n";
  EXPECT_NO_THROW(refuse_corrected_texts({{"p.src", text}}));
  mark_corrected(*find_dialect("krl"), Corrector::mirror, text);
  EXPECT_THROW(refuse_corrected_texts({{"p.src", text}}), CorrectedAlready);
}

}  // namespace
}  // namespace armtrue
