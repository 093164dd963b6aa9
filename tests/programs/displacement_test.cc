#include "armtrue/programs/displacement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/text/input_error.h"

namespace armtrue::displacement_test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// From (400, 0, 500) mm 100 mm along x, a sample each millimetre; then a quarter of a circle about
// (500, 50, 500) mm to (550, 50, 500).
Path path() {
  constexpr int kLine = 100, kArc = 90;
  Path path;
  path.time.setLinSpaced(kLine + kArc + 1, 0, 10);
  path.position.resize(3, kLine + kArc + 1);
  for (int k = 0; k <= kLine; ++k) path.position.col(k) << 400 + k, 0, 500;
  for (int k = 1; k <= kArc; ++k)
    path.position.col(kLine + k) << 500 + 50 * std::sin(k * kDegree),
        50 - 50 * std::cos(k * kDegree), 500;
  path.position *= kMillimetre;
  return path;
}

RobotProgram urscript(const std::string& moves) {
  return parse_program(*find_dialect("urscript"),
                       {{"p.script", "def p():\n  movej([0,-1,1,0,1,0])\n" + moves + "end\n"}}, {});
}

const char* const kMoves =
    "  movel(p[0.4,0,0.5,0,3,0])\n  movel(p[0.5,0,0.5,0,3,0], a=1.2, v=0.1)\n"
    "  movec(p[0.535355339,0.014644661,0.5,0,3,0], p[0.55,0.05,0.5,0,3,0], a=1.2, v=0.1)\n";

TEST(Displacement, WithoutOneNoByteChanges) {
  const RobotProgram program = urscript(kMoves);
  const DisplacedProgram displaced = displace_program(program, path(), path().position);
  EXPECT_EQ(displaced.text.texts[0], program.texts[0].text);
  EXPECT_EQ(displaced.corrected, 4);
  EXPECT_EQ(displaced.left_alone, 1);  // the joints
  EXPECT_THAT(displaced.warnings,
              ElementsAre("p.script:2: left alone: joint angles, which need the robot"));
}

TEST(Displacement, AConstantOneMovesTheTargetsAndInsertsNothing) {
  Eigen::Matrix3Xd corrected = path().position;
  corrected.row(2).array() += 1e-3;
  const DisplacedProgram displaced = displace_program(urscript(kMoves), path(), corrected);
  EXPECT_EQ(displaced.text.inserted, 0);
  EXPECT_THAT(displaced.text.texts[0],
              HasSubstr("movec(p[0.535355339,0.014644661,0.501,0,3,0], p[0.55,0.05,0.501,0,3,0]"));
}

// A roof of 0.2 mm on the line: its ridge is one point, at the middle.
TEST(Displacement, ABendOnALineIsAPoint) {
  Eigen::Matrix3Xd corrected = path().position;
  for (int k = 0; k <= 100; ++k) corrected(2, k) += 0.2e-3 * (1 - std::abs(k - 50) / 50.0);
  const DisplacedProgram displaced = displace_program(urscript(kMoves), path(), corrected);
  EXPECT_EQ(displaced.text.inserted, 1);
  EXPECT_THAT(displaced.text.texts[0],
              HasSubstr("  movel(p[0.45,0,0.5002,0,3,0], a=1.2, v=0.1, r=0.01)\n"
                        "  movel(p[0.5,0,0.5,0,3,0], a=1.2, v=0.1)\n"));
}

// The same roof on a path that ran 1 mm farther on: its ridge stands there.
TEST(Displacement, ABendMovesAlongTheLineWithThePath) {
  Eigen::Matrix3Xd corrected = path().position;
  corrected.row(0).array() += 1e-3;
  for (int k = 0; k <= 100; ++k) corrected(2, k) += 0.2e-3 * (1 - std::abs(k - 50) / 50.0);
  const DisplacedProgram displaced = displace_program(
      urscript("  movel(p[0.4,0,0.5,0,3,0])\n  movel(p[0.5,0,0.5,0,3,0], a=1.2, v=0.1)\n"), path(),
      corrected);
  EXPECT_EQ(displaced.text.inserted, 1);
  EXPECT_THAT(displaced.text.texts[0],
              HasSubstr("  movel(p[0.451,0,0.5002,0,3,0], a=1.2, v=0.1, r="));
}

// Where the arm leaves the line to round its end, no point holds it there.
TEST(Displacement, ABendWithinTheRadiusOfAnEndIsNoPoint) {
  Eigen::Matrix3Xd corrected = path().position;
  for (int k = 0; k <= 100; ++k) corrected(2, k) += 0.2e-3 * std::min(k / 70.0, (100 - k) / 30.0);
  const std::string start = "  movel(p[0.4,0,0.5,0,3,0])\n  movel(p[0.5,0,0.5,0,3,0], a=1.2, v=0.1";
  const std::string next = ")\n  movel(p[0.5,0.1,0.5,0,3,0], a=1.2, v=0.1)\n";
  EXPECT_EQ(displace_program(urscript(start + next), path(), corrected).text.inserted, 1);
  EXPECT_EQ(displace_program(urscript(start + ", r=0.04" + next), path(), corrected).text.inserted,
            0);
}

// The record is that of one tool: between the points of two nothing is known.
TEST(Displacement, BetweenTwoToolsNothingIsInserted) {
  Eigen::Matrix3Xd corrected = path().position;
  for (int k = 0; k <= 100; ++k) corrected(2, k) += 0.2e-3 * (1 - std::abs(k - 50) / 50.0);
  const std::string tail = ",[0,0,1,0],[-1,0,-2,1],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,";
  const auto inserted = [&](const std::string& second) {
    const RobotProgram program =
        parse_program(*find_dialect("rapid"),
                      {{"p.mod", "MoveL [[400,0,500]" + tail + "t1;\nMoveL [[500,0,500]" + tail +
                                     second + ";\n"}},
                      {});
    return displace_program(program, path(), corrected).text.inserted;
  };
  EXPECT_EQ(inserted("t1"), 1);
  EXPECT_EQ(inserted("t2"), 0);
}

// One point says it, if none says otherwise.
TEST(Displacement, AProgramThatWasCorrectedLiesOnTheCorrectedPath) {
  Eigen::Matrix3Xd corrected = path().position;
  for (int k = 0; k <= 100; ++k) corrected(2, k) += 0.2e-3 * (1 - std::abs(k - 50) / 50.0);
  const auto is_corrected = [&](const char* moves) {
    return lies_on_corrected(urscript(moves), path().position, corrected);
  };
  EXPECT_TRUE(is_corrected("  movel(p[0.45,0,0.5002,0,3,0])\n"));
  EXPECT_FALSE(is_corrected("  movel(p[0.45,0,0.5,0,3,0])\n"));
  EXPECT_FALSE(is_corrected("  movel(p[0.45,0,0.5002,0,3,0])\n  movel(p[0.46,0,0.5,0,3,0])\n"));
}

// pose_add of UR: the correction is that of the place where the move ends, and its point takes it.
TEST(Displacement, AShiftedPointGetsTheCorrectionOfItsEnd) {
  const std::string start = "  movel(p[0.4,0,0.5,0,3,0])\n", shifted = "  movel(pose_add(",
                    end = ", p[0.1,0,0,0,0,0]), a=1.2, v=0.1)\n";
  Eigen::Matrix3Xd corrected = path().position;
  for (int k = 50; k <= 100; ++k) corrected(2, k) += 0.2e-3 * (k - 50) / 50.0;
  const auto of_moves = [&](const std::string& moves) {
    return displace_program(urscript(start + moves), path(), corrected);
  };
  const DisplacedProgram literal = of_moves(shifted + "p[0.4,0,0.5,0,3,0]" + end);
  EXPECT_EQ(literal.text.inserted, 1);
  EXPECT_THAT(literal.text.texts[0],
              HasSubstr(start + shifted +
                        "p[0.35,0,0.5,0,3,0], p[0.1,0,0,0,0,0]), a=1.2, v=0.1, r=0.01)\n" +
                        shifted + "p[0.4,0,0.5002,0,3,0]" + end));
  // A named point that one move needs as it is and another one corrected is written out.
  EXPECT_THAT(
      of_moves("  a = p[0.4,0,0.5,0,3,0]\n  movel(a)\n" + shifted + "a" + end).text.texts[0],
      HasSubstr("a = p[0.4,0,0.5,0,3,0]\n  movel(a)\n"));
  // In a frame, the shift counts in that of the robot; off the path it stays.
  const DisplacedProgram off = of_moves(shifted + "p[0.5,0,0.6,0,3,0]" + end);
  EXPECT_EQ(off.corrected, 1);
  EXPECT_THAT(off.warnings, Contains(HasSubstr("p.script:4: left alone: ends off the path")));
}

// A wave of 0.2 mm in the radius of the arc, three times round: pieces of it keep within some um of
// the corrected path, and no piece is shorter than 5 deg.
TEST(Displacement, AWaveOnAnArcIsArcs) {
  Eigen::Matrix3Xd corrected = path().position;
  const Eigen::Vector3d centre(0.5, 0.05, 0.5);
  for (int k = 0; k <= 90; ++k) {
    const Eigen::Vector3d out = (path().position.col(100 + k) - centre).normalized();
    corrected.col(100 + k) += 0.2e-3 * std::sin(12 * k * kDegree) * out;
  }
  const RobotProgram program = urscript(kMoves);
  DisplacementOptions options;
  options.tolerance = 20e-6;
  const DisplacedProgram displaced = displace_program(program, path(), corrected, options);
  EXPECT_GT(displaced.text.inserted, 5);
  EXPECT_LT(displaced.text.inserted, 18);
  const RobotProgram read =
      parse_program(*find_dialect("urscript"), {{"p.script", displaced.text.texts[0]}}, {});
  ASSERT_EQ(read.targets.size(),
            program.targets.size() + 2 * static_cast<size_t>(displaced.text.inserted));
  // Every written point lies on the corrected arc.
  for (size_t k = 3; k < read.targets.size(); ++k) {
    const Eigen::Vector3d from = read.targets[k].pose.translation - centre;
    const double angle = std::atan2(from.x(), -from.y());
    EXPECT_NEAR(from.norm(), 0.05 + 0.2e-3 * std::sin(12 * angle), 10e-6) << k;
  }
}

TEST(Displacement, RapidKeepsTheConfdataOfTheEndAndFanucItsTurns) {
  Eigen::Matrix3Xd corrected = path().position;
  for (int k = 0; k <= 100; ++k) corrected(2, k) += 0.2e-3 * (1 - std::abs(k - 50) / 50.0);
  const std::string tail = ",[0,0,1,0],[-1,0,-2,1],[9E9,9E9,9E9,9E9,9E9,9E9]]";
  const RobotProgram rapid =
      parse_program(*find_dialect("rapid"),
                    {{"p.mod", "MoveL [[400,0,500]" + tail + ",v100,fine,t1;\nMoveL [[500,0,500]" +
                                   tail + ",v100,fine,t1;\n"}},
                    {});
  EXPECT_THAT(displace_program(rapid, path(), corrected).text.texts[0],
              HasSubstr("MoveL [[450,0,500.2],[0,0,1,0],[-1,0,-2,1],[9E9,9E9,9E9,9E9,"
                        "9E9,9E9]],v100,z1,t1;\n"));
  const auto position = [](int number, const char* x) {
    return "P[" + std::to_string(number) +
           "]{\n GP1:\n UF : 1, UT : 1, CONFIG : 'N U T, 0, 1, 0',\n X = " + x +
           " mm, Y = 0.0 mm, Z = 500.0 mm,\n W = 0.0 deg, P = 0.0 deg, R = 0.0 deg\n};\n";
  };
  const RobotProgram fanuc = parse_program(
      *find_dialect("fanuc"),
      {{"P.LS", "/PROG P\n/MN\n 1:L P[1] 9mm/sec FINE ;\n 2:L P[2] 9mm/sec FINE ;\n/POS\n" +
                    position(1, "400.0") + position(2, "500.0") + "/END\n"}},
      {});
  EXPECT_THAT(displace_program(fanuc, path(), corrected).text.texts[0],
              HasSubstr("P[3]{\n GP1:\n UF : 1, UT : 1, CONFIG : 'N U T, 0, 1, 0',\n X = 450.0 mm, "
                        "Y = 0.0 mm, Z = 500.2 mm"));
}

// One that only begins on the path is named, one that has no point there is not.
TEST(Displacement, AnArcThatLeavesThePathIsNamed) {
  const std::string lines = "  movel(p[0.4,0,0.5,0,3,0])\n  movel(p[0.5,0,0.5,0,3,0])\n";
  const auto warnings_of = [&](const std::string& moves) {
    return displace_program(urscript(lines + moves), path(), path().position).warnings;
  };
  const std::string words = ": an arc that starts or ends off the path";
  const std::string leaves =
      "  movec(p[0.535355339,0.014644661,0.5,0,3,0], p[0.6,0.05,0.5,0,3,0])\n";
  EXPECT_THAT(warnings_of(leaves), Contains(HasSubstr("p.script:5" + words)));
  const std::string away = "  movel(p[0.4,0,0.9,0,3,0])\n";
  EXPECT_THAT(warnings_of(away + "  movec(p[0.5,0,0.9,0,3,0], p[0.5,0.1,0.9,0,3,0])\n"),
              Not(Contains(HasSubstr(words))));
}

TEST(Displacement, AProgramOfAnotherPathIsRefused) {
  EXPECT_THROW(displace_program(urscript("  movel(p[0.4,0,0.6,0,3,0])\n"), path(), path().position),
               InputError);
  EXPECT_THROW(displace_program(urscript(""), path(), path().position), InputError);
  const RobotProgram half = urscript(
      "  movel(p[0.4,0,0.9,0,3,0])\n  movel(p[0.4,0,0.7,0,3,0])\n  movel(p[0.4,0,0.5,0,3,0])\n");
  EXPECT_THAT(displace_program(half, path(), path().position).warnings,
              Contains(HasSubstr("only 1 of the 3 points of the program lie")));
}

}  // namespace
}  // namespace armtrue::displacement_test
