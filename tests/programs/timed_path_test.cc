// A program as a path in time: where the arm is when, by the closed form of a motion that speeds
// up, keeps its feed and slows down.

#include "armtrue/programs/timed_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/text/input_error.h"

namespace armtrue::timed_path_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr ProgramSpeed kSpeed{.feed = 0.05, .acceleration = 0.5, .period = 0.01, .standstill = 0.5};

TimedProgram timed(const char* dialect, const std::string& text) {
  const RobotProgram program =
      parse_program(*find_dialect(dialect), {{"p", text}}, {}, TargetParts::position);
  return timed_path(program, kSpeed);
}

TimedProgram krl(const std::string& moves) {
  return timed("krl", "DEF p()\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\nPTP {X 100,Y 0,Z 50}\n" +
                          moves + "END\n");
}

double duration(const Path& path) {
  return path.time[path.samples() - 1] - path.time[0] - 2 * kSpeed.standstill + kSpeed.period;
}

// The time at which the path is at a point, which it passes once.
double time_at(const Path& path, const Eigen::Vector3d& point) {
  for (Eigen::Index i = 0; i < path.samples(); ++i)
    if ((path.position.col(i) - point * kMillimetre).norm() < 1e-9) return path.time[i];
  return NAN;
}

// Up to the feed within 0.1 s and 2.5 mm, and down again: 100 mm take 2 + 0.1 s.
TEST(TimedPath, StopsWhereTheProgramDoes) {
  const auto [path, warnings] = krl("LIN {X 200,Y 0,Z 50}\nLIN {X 200,Y 100,Z 50}\n");
  EXPECT_THAT(warnings, IsEmpty());
  EXPECT_NEAR(duration(path), 2 * 2.1, 1e-9);
  const double begin = path.time[0] + kSpeed.standstill - kSpeed.period;
  EXPECT_NEAR(time_at(path, {200, 0, 50}) - begin, 2.1, 1e-9);
  // 0.05 s after the start: half an acceleration of 0.5 m/s^2.
  EXPECT_NEAR(position_at(path, Eigen::VectorXd::Constant(1, begin + 0.05))(0, 0),
              0.1 + 0.5 * 0.5 * 0.05 * 0.05, 1e-9);
  // After a second the feed has made 0.05 (1 - 0.1 / 2) m.
  EXPECT_NEAR(position_at(path, Eigen::VectorXd::Constant(1, begin + 1))(0, 0), 0.1475, 1e-9);
}

TEST(TimedPath, KeepsItsFeedThroughAPointThatIsApproximated) {
  const auto [path, warnings] = krl("LIN {X 200,Y 0,Z 50} C_DIS\nLIN {X 200,Y 100,Z 50}\n");
  EXPECT_NEAR(duration(path), 4.1, 1e-9);
  const double begin = path.time[0] + kSpeed.standstill - kSpeed.period;
  EXPECT_NEAR(time_at(path, {200, 0, 50}) - begin, 2.05, 1e-9);
}

// What a piece is too short for: 2 mm at 0.5 m/s^2 take 2 sqrt(2 mm / a).
TEST(TimedPath, AShortMoveDoesNotReachTheFeed) {
  EXPECT_NEAR(duration(krl("LIN {X 102,Y 0,Z 50}\n").path), 2 * std::sqrt(2e-3 / 0.5), 1e-9);
}

// Half a circle of 50 mm about (150, 0, 50).
TEST(TimedPath, AnArcHasItsLength) {
  const auto [path, warnings] = krl("CIRC {X 150,Y 50,Z 50},{X 200,Y 0,Z 50}\n");
  EXPECT_NEAR(duration(path), 0.05 * std::numbers::pi / 0.05 + 0.1, 1e-9);
  for (Eigen::Index i = 0; i < path.samples(); ++i)
    EXPECT_NEAR((path.position.col(i) - Eigen::Vector3d(0.15, 0, 0.05)).norm(), 0.05, 1e-12);
}

TEST(TimedPath, TimesIncreaseAndTheToolStandsAtBothEnds) {
  const Path path = krl("LIN {X 133.3,Y 0,Z 50} C_DIS\nLIN {X 133.3,Y 41.7,Z 50}\n").path;
  for (Eigen::Index i = 1; i < path.samples(); ++i)
    EXPECT_GT(path.time[i], path.time[i - 1] + 4e-3);
  EXPECT_EQ(path.position.col(0), path.position.col(40));
  EXPECT_EQ(path.position.col(path.samples() - 1), path.position.col(path.samples() - 40));
}

TEST(TimedPath, OrientationsAreThereIfAllPointsStateThem) {
  EXPECT_FALSE(krl("LIN {X 200,Y 0,Z 50}\n").path.has_orientation());
  const Path path = timed("krl",
                          "DEF p()\nPTP {X 100,Y 0,Z 50,A 0,B 0,C 0}\n"
                          "LIN {X 200,Y 0,Z 50,A 90,B 0,C 0}\nEND\n")
                        .path;
  ASSERT_TRUE(path.has_orientation());
  EXPECT_NEAR(path.orientation(0, path.samples() - 1), 90 * kDegree, 1e-12);
}

// The longest of two that a move of joints parts; the other is named.
TEST(TimedPath, TheLongestRowOfMovesIsThePath) {
  const auto [path, warnings] =
      krl("LIN {X 110,Y 0,Z 50}\nPTP {X 0,Y 0,Z 50}\nLIN {X 100,Y 0,Z 50}\n");
  EXPECT_NEAR(path.position(0, 0), 0, 1e-12);
  EXPECT_THAT(warnings,
              ElementsAre(HasSubstr("p:4: no part of the path, which is that of line 6")));
}

TEST(TimedPath, AProgramOfJointsHasNone) {
  EXPECT_THROW(timed("krl", "DEF p()\nPTP {X 0,Y 0,Z 50}\nPTP {X 10,Y 0,Z 50}\nEND\n"), InputError);
}

// How each maker says that a point is passed: stops twice, once.
struct Maker {
  const char* dialect;
  std::string text;
};

TEST(TimedPath, EachMakerSaysWhereTheArmStops) {
  const auto ur = [](const char* radius) {
    return "def p():\n  movel(p[0,0,0.5,0,3,0])\n  movel(p[0.1,0,0.5,0,3,0]" + std::string(radius) +
           ")\n  movel(p[0.1,0.1,0.5,0,3,0])\nend\n";
  };
  const auto abb = [](const std::string& zone) {
    const std::string tail = ",[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v50,";
    return "MODULE m\n  PROC p()\n    MoveL [[0,0,500]" + tail +
           "fine,tool0;\n    MoveL [[100,0,500]" + tail + zone +
           ",tool0;\n    MoveL [[100,100,500]" + tail + "fine,tool0;\n  ENDPROC\nENDMODULE\n";
  };
  const auto fanuc = [](const std::string& end) {
    const auto position = [](int k, const char* xyz) {
      return "P[" + std::to_string(k) +
             "]{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\t" + xyz +
             ",\n\tW =     0.000  deg,\tP =     0.000  deg,\tR =     0.000  deg\n};\n";
    };
    return "/PROG  P\n/MN\n   1:L P[1] 50mm/sec FINE    ;\n   2:L P[2] 50mm/sec " + end +
           "    ;\n   3:L P[3] 50mm/sec FINE    ;\n/POS\n" +
           position(1, "X =     0.000  mm,\tY =     0.000  mm,\tZ =   500.000  mm") +
           position(2, "X =   100.000  mm,\tY =     0.000  mm,\tZ =   500.000  mm") +
           position(3, "X =   100.000  mm,\tY =   100.000  mm,\tZ =   500.000  mm") + "/END\n";
  };
  const std::vector<Maker> stop{{"urscript", ur("")},
                                {"rapid", abb("fine")},
                                {"fanuc", fanuc("FINE")},
                                {"fanuc", fanuc("CNT0")}};
  const std::vector<Maker> pass{
      {"urscript", ur(",r=0.01")}, {"rapid", abb("z5")}, {"fanuc", fanuc("CNT100")}};
  for (const auto& [dialect, text] : stop)
    EXPECT_NEAR(duration(timed(dialect, text).path), 4.2, 1e-9) << text;
  for (const auto& [dialect, text] : pass)
    EXPECT_NEAR(duration(timed(dialect, text).path), 4.1, 1e-9) << text;
}

}  // namespace
}  // namespace armtrue::timed_path_test
