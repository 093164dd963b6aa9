#pragma once

// An arm that touches things at rest, by KDL: what a calibration without a tracker reads.

#include <array>
#include <kdl/frames.hpp>
#include <string>
#include <vector>

#include "oracle.h"

namespace armtrue_oracle {

/// A thing at rest in R_A [m].
struct Fixture {
  enum class Kind { point, plane, sphere };
  std::string name;
  Kind kind = Kind::point;
  KDL::Vector place;            // of a plane: a point in it
  KDL::Vector normal{0, 0, 1};  // of a plane
  double radius = 0;            // of a sphere
};

/// The arm with every link parameter off by normal errors, angles and lengths; but that of
/// `scale`, the parameter d of this link, is exact.
OracleArm with_errors(OracleArm arm, double length, double angle, int scale, Dice& dice);

/// Configurations, within 0.9 of the travel, in which the arm touches each fixture in turn. The
/// touch is off by `noise` [m] per number that it reads.
struct TouchedPose {
  std::array<double, 6> q{};
  size_t fixture = 0;
};
std::vector<TouchedPose> touch(const OracleArm& arm, const std::vector<Fixture>& fixtures,
                               int poses, double noise, Dice& dice);

/// The same as a file of measurements: pose, q1_deg ... q6_deg, contact.
std::string touches_csv(const std::vector<TouchedPose>& poses,
                        const std::vector<Fixture>& fixtures);

/// What a tracker with this noise [m] reads in the same configurations: with x_mm, y_mm, z_mm.
std::string points_csv(const OracleArm& arm, const std::vector<TouchedPose>& poses, double noise,
                       Dice& dice);

}  // namespace armtrue_oracle
