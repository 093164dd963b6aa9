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

/// A laser on the tool: it reads how far along its direction a plane is from its origin [m].
struct Laser {
  std::string name = "laser";
  KDL::Vector origin, along{0, 0, 1};
};

/// Readings of random configurations, within 0.9 of the travel, in which the laser ends on each
/// plane in turn, 50 to 600 mm away and by less than 60 deg off its normal, with noise [m].
struct LaserPose {
  std::array<double, 6> q{};
  size_t plane = 0;
  double length = 0;  // [m]
};
std::vector<LaserPose> read_laser(const OracleArm& arm, const Laser& laser,
                                  const std::vector<Fixture>& planes, int poses, double noise,
                                  Dice& dice);

/// The same as a file of measurements: pose, q1_deg ... q6_deg, beam, contact, l_mm.
std::string laser_csv(const std::vector<LaserPose>& poses, const Laser& laser,
                      const std::vector<Fixture>& planes);

/// Points (y, z) of the line of a scanner in its plane [m], of random configurations, within 0.9 of
/// the travel, in which it sees nothing but one fixture, each in turn: planes and spheres.
struct ProfilePose {
  std::array<double, 6> q{};
  size_t fixture = 0;
  std::vector<std::array<double, 2>> points;
};
/// `sensor`: its place on the tool. It casts `rays` rays in its plane up to 15 deg to both sides of
/// its z axis, which end 80 to 400 mm away, by less than 60 deg off the normal; z has noise [m].
std::vector<ProfilePose> read_profiles(const OracleArm& arm, const KDL::Frame& sensor,
                                       const std::vector<Fixture>& fixtures, int poses, int rays,
                                       double noise, Dice& dice);

/// The same as a file of measurements: pose, q1_deg ... q6_deg, contact, profile_y_mm,
/// profile_z_mm.
std::string profiles_csv(const std::vector<ProfilePose>& poses,
                         const std::vector<Fixture>& fixtures);

/// What a tracker with this noise [m] reads in the same configurations: with x_mm, y_mm, z_mm.
std::string points_csv(const OracleArm& arm, const std::vector<TouchedPose>& poses, double noise,
                       Dice& dice);

}  // namespace armtrue_oracle
