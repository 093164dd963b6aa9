#include "armtrue/io/robot_io.h"

#include <gtest/gtest.h>

#include <fstream>
#include <numbers>
#include <sstream>

#include "armtrue/io/catalogue_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/text/input_error.h"

namespace armtrue::robot_io_test {
namespace {

std::string text_of(const std::string& name) {
  std::ifstream file(ARMTRUE_CONFIG "/robots/" + name + ".yaml");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

void expect_error(const std::string& text, const std::string& expected) {
  try {
    parse_robot(text, "r.yaml");
    FAIL() << "no error; expected: " << expected;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
  }
}

TEST(RobotIo, WhatIsWrittenReadsBackTheSame) {
  for (const char* name :
       {"kr360", "kr360-eq1-zero", "kr360-spindle", "kr360-table4", "kr360-undeclared"}) {
    const std::string once = write_robot(parse_robot(text_of(name), name));
    EXPECT_EQ(write_robot(parse_robot(once, name)), once) << name;
  }
}

// A calibration moves zeros, and with them what follows: the file says from where the values count.
TEST(RobotIo, WhatFollowsReadsBackTheSame) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/irb460.yaml").robot;
  EXPECT_EQ(joint_count(robot.chain), 4);
  const std::string nominal = write_robot(robot);
  EXPECT_NE(nominal.find("coupled: {A2: -1}}"), std::string::npos);
  EXPECT_NE(nominal.find("follows: {A2: -1, A3: -1}}"), std::string::npos);
  EXPECT_EQ(nominal.find("from_deg"), std::string::npos);
  for (const char* name : {"A2.theta", "A3.theta", "tilt.theta", "tilt.d", "tilt.follows.A2"})
    move_parameter(robot.chain, *find_parameter(robot.chain, name), 1e-3);
  const std::string text = write_robot(robot);
  EXPECT_NE(text.find("coupled: {A2: -1}, from_deg: {A2: -90}}"), std::string::npos);
  EXPECT_NE(text.find("from_deg: {A2: -90, A3: 90}}"), std::string::npos);
  const Robot again = parse_robot(text, "again.yaml");
  EXPECT_EQ(write_robot(again), text);
  const JointVector q = (JointVector(4) << 0.3, 0.5, 0.9, -1.2).finished();
  EXPECT_EQ(ChainEvaluator(again.chain).pose(q).translation,
            ChainEvaluator(robot.chain).pose(q).translation);
}

TEST(RobotIo, AStepBetweenSessionsReadsBack) {
  const std::string effect =
      "effects:\n"
      "  - {name: re-mastered joint, parameter: A2.theta, driver: session, shape: step, since: \"2\",\n"
      "     sessions: [day 1, \"2\", day 3], coefficients: [{value: 1e-3}]}\n";
  const std::string text = text_of("kr360") + "\n";
  const std::string with = text.find("effects: []") == std::string::npos
                               ? text + effect
                               : replaced(text, "effects: []", effect);
  const Robot robot = parse_robot(with, "r.yaml");
  ASSERT_EQ(robot.effects.size(), 1u);
  EXPECT_EQ(robot.effects.front().driver.sessions,
            (std::vector<std::string>{"day 1", "2", "day 3"}));
  EXPECT_EQ(first_session_after(robot.effects.front()), "2");
  EXPECT_EQ(robot.effects.front().shape.at, 0.5);
  const std::string once = write_robot(robot);
  EXPECT_NE(once.find("since: \"2\""), std::string::npos) << once;
  EXPECT_EQ(write_robot(parse_robot(once, "once")), once);
  expect_error(replaced(with, "since: \"2\"", "since: day 1"), "'day 1' is none of 'sessions'");
  expect_error(replaced(with, "since: \"2\"", "since: day 4"), "'day 4' is none of 'sessions'");
  expect_error(replaced(with, "shape: step", "shape: linear"), "drives the shape 'step'");
}

TEST(RobotIo, SessionsReadBack) {
  const std::string sessions =
      "sessions:\n"
      "  day 2: {x_mm: 3000, y_mm: -1.5, z_mm: 0.1, a_deg: 20, b_deg: 1, c_deg: -2,\n"
      "          theta_deg: {A2: 0.5, A5: -1}, std: {base.x: 0.02, A2.theta: 0.001}}\n"
      "  day 1: {x_mm: 0, y_mm: 0, z_mm: 0, a_deg: 0, b_deg: 0, c_deg: 0}\n"
      "identify_per_session: [A2.theta, A5.theta]\n"
      "links:";
  const Robot robot = parse_robot(replaced(text_of("kr360"), "links:", sessions), "r.yaml");
  ASSERT_EQ(robot.sessions.size(), 2u);
  EXPECT_DOUBLE_EQ(robot.sessions.at("day 2").base.translation.x(), 3);
  EXPECT_DOUBLE_EQ(robot.sessions.at("day 2").zero.at(4), -std::numbers::pi / 180);
  EXPECT_DOUBLE_EQ(robot.sessions.at("day 2").std.at("base.x"), 2e-5);
  EXPECT_EQ(robot.identify_per_session, (std::vector<std::string>{"A2.theta", "A5.theta"}));
  const std::string once = write_robot(robot);
  EXPECT_NE(once.find("theta_deg: {A2: 0.5, A5: -1}, std: {base.x: 0.02, A2.theta: 0.001}}"),
            std::string::npos)
      << once;
  EXPECT_NE(once.find("  day 2: {x_mm: 3000, y_mm: -1.5, z_mm: 0.1, a_deg: 20,"), std::string::npos)
      << once;
  EXPECT_EQ(write_robot(parse_robot(once, "once")), once);
  expect_error(replaced(text_of("kr360"), "links:", "sessions: {a: {x_mm: 1}}\nlinks:"),
               "of 'a': is missing");
  expect_error(replaced(text_of("kr360"), "links:", "sessions: {a: {theta_deg: {A9: 1}}}\nlinks:"),
               "the robot has no driven link 'A9'");
  expect_error(replaced(text_of("kr360"), "links:", "identify_per_session: [A2.d]\nlinks:"),
               "'A2.d' is no zero offset");
}

TEST(RobotIo, AnchorsReadBack) {
  const std::string anchors =
      "anchors:\n"
      "  floor: {x_mm: 2500, y_mm: -1.5, z_mm: 0.1, zero_mm: 0.25}\n"
      "  wall: {x_mm: 0, y_mm: 3000, z_mm: 1500}\n"
      "links:";
  const Robot robot = parse_robot(replaced(text_of("kr360"), "links:", anchors), "r.yaml");
  ASSERT_EQ(robot.chain.anchors.size(), 2u);
  EXPECT_DOUBLE_EQ(robot.chain.anchors[0].zero, 0.25e-3);
  EXPECT_DOUBLE_EQ(robot.chain.anchors[1].position.y(), 3);
  const std::string once = write_robot(robot);
  EXPECT_NE(once.find("  floor: {x_mm: 2500, y_mm: -1.5, z_mm: 0.1, zero_mm: 0.25}"),
            std::string::npos)
      << once;
  EXPECT_EQ(write_robot(parse_robot(once, "once")), once);
  expect_error(replaced(text_of("kr360"), "links:", "anchors: {a: {x_mm: 1, y_mm: 2}}\nlinks:"),
               "of 'a': is missing");
}

TEST(RobotIo, EveryKindOfEffectReadsBack) {
  const std::string effects = R"(effects:
  - {name: a, parameter: A2.theta, driver: gravity-torque 2, shape: linear, coefficients: [{name: c, value: 1e-7, unit: rad/(N m)}]}
  - {name: b, parameter: base, driver: time, shape: step, at_s: 120.5, coefficients: [{value: 1}, {value: 2}]}
  - {name: c, parameter: A4.r, driver: time, shape: exponential, tau_s: 900, coefficients: [{value: 3e-4, std: 1e-5, ci95: [2e-4, 4e-4]}]}
  - name: d
    parameter: A3.theta
    driver: joint-angle 2,4
    shape: series
    series: {basis: fourier, count: 1}
    coefficients: [{value: 1}, {value: 2}, {value: 3}, {value: 4}]
    evidence: {p_value: 0.01}
    indistinguishable: []
  - {name: e, parameter: A5.theta, driver: joint-angle 5, shape: series, series: {basis: spline, count: 290, range: [-2, 2]}}
  - {name: f, parameter: A2.theta, driver: joint-angle 2, shape: harmonic 37.4, coefficients: [{value: 1e-4}, {value: 0}], cycle: {phase_deg: 0}}
  - {name: g, parameter: A3.theta, driver: joint-angle 3 * temperature arm, shape: harmonic 1, coefficients: [{value: 1e-5}, {value: 0}]}
  - {name: h, parameter: A3.theta, driver: joint-angle 3 * arrival 3, shape: linear, coefficients: [{value: 1e-5}]}
  - {name: i, parameter: A3.theta, driver: gravity-torque 3 * payload, shape: linear, coefficients: [{value: 1e-9}]}
)";
  const Robot robot = parse_robot(replaced(text_of("kr360"), "effects: []\n", effects), "r.yaml");
  ASSERT_EQ(robot.effects.size(), 9u);
  EXPECT_EQ(robot.effects[1].shape.at, 120.5);
  EXPECT_EQ(robot.effects[2].coefficients[0].ci95[1], 4e-4);
  EXPECT_EQ(robot.effects[3].driver.second_joint, 3);
  const std::string written = write_robot(robot);
  for (const char* unit : {"unit: rad/K}", "unit: rad/rad}", "unit: rad/(N m kg)}"})
    EXPECT_NE(written.find(unit), std::string::npos) << unit;
  const Robot again = parse_robot(written, "again");
  ASSERT_EQ(again.effects.size(), robot.effects.size());
  for (size_t k = 0; k < again.effects.size(); ++k) {
    EXPECT_EQ(again.effects[k].driver, robot.effects[k].driver);
    EXPECT_EQ(again.effects[k].shape, robot.effects[k].shape);
    ASSERT_EQ(again.effects[k].coefficients.size(), robot.effects[k].coefficients.size());
    for (size_t c = 0; c < again.effects[k].coefficients.size(); ++c)
      EXPECT_EQ(again.effects[k].coefficients[c].value, robot.effects[k].coefficients[c].value);
  }
}

TEST(RobotIo, CoefficientsHaveTheirNamesOrElseTheirPlaces) {
  const auto read = [](const std::string& coefficients) {
    const std::string effects =
        "effects:\n  - {name: a, parameter: A2.theta, driver: joint-angle 2, shape: harmonic 3, "
        "coefficients: [" +
        coefficients + "]}\n";
    return parse_robot(replaced(text_of("kr360"), "effects: []\n", effects), "r.yaml").effects[0];
  };
  for (const char* text : {"{name: cos, value: 2}, {name: sin, value: 1}",
                           "{name: sin, value: 1}, {name: cos, value: 2}", "{value: 1}, {value: 2}",
                           "{name: a, value: 1}, {name: b, value: 2}"}) {
    const Effect effect = read(text);
    EXPECT_EQ(effect.coefficients[0].value, 1) << text;
    EXPECT_EQ(effect.coefficients[1].value, 2) << text;
  }
}

// What a load does on a length is a force, on an angle a torque.
TEST(RobotIo, CoefficientsHaveTheUnitOfTheirParameterAndDriver) {
  const auto units = [](const std::string& parameter, const std::string& driver, int coefficients) {
    Robot robot = parse_robot(text_of("kr360"), "kr360");
    robot.effects.push_back({"e", parameter, *parse_driver(driver), Shape{}, {}});
    robot.effects.front().coefficients.resize(static_cast<size_t>(coefficients));
    const std::string text = write_robot(robot);
    std::vector<std::string> found;
    const std::string key = "unit: ";
    for (size_t at = text.find(key); at != std::string::npos; at = text.find(key, at)) {
      at += key.size();
      found.push_back(text.substr(at, text.find('}', at) - at));
    }
    return found;
  };
  using Units = std::vector<std::string>;
  EXPECT_EQ(units("base.x", "force", 1), Units{"m/N"});
  EXPECT_EQ(units("A3.theta", "force", 1), Units{"rad/(N m)"});
  EXPECT_EQ(units("A2.d", "moment", 1), Units{"m/N"});
  EXPECT_EQ(units("A2.d", "gravity-torque 2", 1), Units{"m/(N m)"});
  EXPECT_EQ(units("A2.d", "joint-angle 2 * force", 1), Units{"m/(rad N)"});
  EXPECT_EQ(units("arm.scale", "temperature air", 1), Units{"1/K"});
  EXPECT_EQ(units("instrument.scale", "temperature air", 1), Units{"1/K"});
  EXPECT_EQ(units("instrument.scale", "position", 1), Units{"\"1\""});
  EXPECT_EQ(units("base", "moment", 1), Units{"rad/(N m)"});
  // Without masses gravity is a basis of accelerations, whose coefficients are no compliances.
  EXPECT_EQ(units("A2.theta", "gravity-torque 2", 2), (Units{"rad/(m/s2)", "rad/(m/s2)"}));
  EXPECT_EQ(units("base", "moment", 2), (Units{"rad/(m/s2)", "rad/(m/s2)"}));
  EXPECT_EQ(units("base", "force", 6),
            (Units{"m/N", "m/N", "m/N", "rad/(N m)", "rad/(N m)", "rad/(N m)"}));
  EXPECT_EQ(units("tool", "time", 6), (Units{"m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"}));
}

TEST(RobotIo, ErrorsNameLineAndKey) {
  const std::string good = text_of("kr360");
  expect_error("", "r.yaml: is empty");
  expect_error("format: armtrue-loop/1\n", "r.yaml:1: key 'format'");
  expect_error("a: [1, 2\n", "is no valid YAML");
  expect_error(replaced(good, "noise:", "nois:"), "key 'nois' is not known");
  expect_error(replaced(good, "joint: revolute", "joint: sliding"), "r.yaml:6: key 'joint'");
  expect_error(replaced(good, "joint: revolute", "joint: prismatic"), "r.yaml:6: key 'min_mm'");
  expect_error(replaced(good, "d_mm: 500", "d_mm: five"), "r.yaml:7: key 'd_mm'");
  expect_error(replaced(good, "d_mm: 500, ", ""), "key 'd_mm' of an entry of 'links': is missing");
  expect_error(replaced(good, "sign: 1", "sign: 2"), "must be 1 or -1");
  expect_error(replaced(good, "min_deg: -185", "min_deg: 200"), "must be above min_deg");
  expect_error(replaced(good, "link: A1, mass", "link: B1, mass"), "has no link 'B1'");
  expect_error(replaced(good, "mass_kg: 851", "mass_kg: -1"), "must be above zero");
  expect_error(replaced(good, "identify: auto", "identify: [A1.alpha, A9.d]"),
               "no parameter 'A9.d'");
  expect_error(replaced(good, "identify: auto", "identify: [instrument.scale]"),
               "r.yaml:20: key 'identify' of the document: instrument.scale is not identified");
  for (const char* key : {"priors", "std"})
    expect_error(
        replaced(good, "identify: auto", std::string(key) + ": {instrument.scale: 1e-3}"),
        std::string("r.yaml:20: key 'instrument.scale' of '") + key + "': instrument.scale is not");
  expect_error(replaced(good, "effects: []",
                        "effects: [{name: a, parameter: A2.theta, driver: 'joint-angle 2,4', "
                        "shape: series, series: {basis: fourier, count: 31}}]"),
               "must be a whole number from 1 to 30");
  expect_error(replaced(good, "effects: []",
                        "effects: [{name: a, parameter: A2.theta, driver: moon, shape: linear}]"),
               "key 'driver'");
  expect_error(replaced(good, "effects: []",
                        "effects: [{name: a, parameter: A2.theta, driver: time, shape: step}]"),
               "key 'at_s'");
  expect_error(replaced(good, "name: A3, joint", "name: A2, joint"), "'A2' stands twice");
  expect_error(replaced(good, "name: A1, joint", "name: tool, joint"),
               "'tool' means something else");
  expect_error(replaced(good, "effects: []",
                        "effects: [{name: a, parameter: A2.theta, driver: time, shape: linear, "
                        "coefficients: [{value: 1, unit: deg/s}]}]"),
               "'deg/s' is not read: values are in SI units");
}

TEST(RobotIo, ADriverThatCannotMoveItsParameterIsAnError) {
  const auto expect = [](const std::string& form, const std::string& expected) {
    const std::string effect = "{name: a, " + form + ", coefficients: [{value: 1e-9}]}";
    expect_error(replaced(text_of("kr360"), "effects: []", "effects:\n  - " + effect), expected);
  };
  expect("parameter: arm.scale, driver: force, shape: linear", "arm.scale is many lengths");
  expect("parameter: instrument.scale, driver: force, shape: linear", "on instrument.scale");
  expect("parameter: instrument.scale, driver: time * force, shape: linear", "on instrument.scale");
  expect("parameter: instrument.scale, driver: moment, shape: linear", "on instrument.scale");
  expect("parameter: A2.d, driver: position, shape: linear", "drives instrument.scale, .range");
  expect("parameter: A2.d, driver: 'joint-angle 2,4', shape: linear", "need the shape 'series'");
  expect("parameter: A2.d, driver: moon, shape: linear", "position (of the instrument)");
  expect("parameter: A2.theta, driver: joint-angle 2, shape: pre-sliding",
         "needs the driver 'stroke");
  expect("parameter: A2.theta, driver: payload, shape: step", "needs a time or an angle");
  expect("parameter: A2.theta, driver: payload * gravity-torque 2, shape: linear", "is none of");
  expect("parameter: instrument.azimuth, driver: position, shape: linear", "would be a constant");
  expect("parameter: target 9, driver: time, shape: step", "no parameter 'target 9'");
}

TEST(RobotIo, TheShippedCatalogueReads) {
  const Catalogue catalogue = read_catalogue(ARMTRUE_CONFIG "/effects/catalogue.yaml");
  const Robot robot = parse_robot(text_of("kr360"), "kr360");
  int effects = 0;
  for (const CatalogueEntry& entry : catalogue)
    for (const Effect& effect : expand(entry, robot)) {
      const bool is_group = effect.parameter == "base" || effect.parameter == "tool" ||
                            effect.parameter == "instrument.point";
      EXPECT_TRUE(is_group || find_parameter(robot.chain, effect.parameter)) << effect.parameter;
      ++effects;
    }
  EXPECT_GT(effects, 100);
}

TEST(RobotIo, ErrorsOfACatalogueNameLineAndKey) {
  const auto text_with = [](const std::string& entry) {
    return "format: armtrue-catalogue/1\neffects:\n  - {name: x, " + entry + "}\n";
  };
  const auto expect = [&](const std::string& entry, const std::string& expected) {
    try {
      parse_catalogue(text_with(entry), "c.yaml");
      ADD_FAILURE() << "no error; expected: " << expected;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("c.yaml:3: key " + expected), std::string::npos)
          << error.what();
    }
  };
  expect("parameter: theta, driver: moon, shape: linear", "'driver' of");
  expect("parameter: theta, driver: position, shape: linear", "'driver' of");
  expect("parameter: instrument.scale, driver: force, shape: linear", "'driver' of");
  expect("parameter: theta, driver: joint-angle 3 * arrival own, shape: linear", "'driver' of");
  expect("parameter: theta, driver: temperature, shape: exponential", "'shape' of");
  expect("parameter: theta, driver: joint-angle own, shape: exponential", "'shape' of");
  expect("parameter: theta, driver: time, shape: linear, sign: postive", "'sign' of");
  const std::string pair =
      "parameter: theta, driver: 'joint-angle 2,4', shape: series, "
      "series: {basis: spline, count: 4, range: [-1, 1]";
  expect(pair + "}", "'second_range' of 'series': is missing");
  const Catalogue read = parse_catalogue(text_with(pair + ", second_range: [-2, 3]}"), "c.yaml");
  EXPECT_EQ(read.at(0).shape.low, (std::array<double, 3>{-1, -2, 0}));
  EXPECT_EQ(read.at(0).shape.high, (std::array<double, 3>{1, 3, 0}));
}

}  // namespace
}  // namespace armtrue::robot_io_test
