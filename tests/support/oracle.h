#pragma once

// An arm simulated another way: KDL frames, weights summed in world axes, its own random numbers.
// The tests give what it writes to the commands, which must find out what was hidden in it.

#include <array>
#include <functional>
#include <kdl/frames.hpp>
#include <random>
#include <string>
#include <vector>

namespace armtrue_oracle {

struct OracleLink {
  double alpha = 0, d = 0, theta = 0, r = 0, beta = 0, sign = 1, min = 0, max = 0;  // m, rad
};
struct OracleMass {
  int link = 0;
  double kg = 0;
  KDL::Vector centre;
};
struct OracleArm {
  KDL::Frame base, tool;
  std::array<OracleLink, 7> links;
  std::vector<OracleMass> masses;
  KDL::Vector gravity{0, 0, -9.81};
  double scale = 1;  // of the lengths that the instrument reads
  // Errors of what an instrument at kStation reads: of the distance [m] and of its two angles.
  double range = 0, azimuth = 0, elevation = 0;
  KDL::Vector point;             // what it adds to the point that it reads [m]
  double second_wire = 0;        // zero error of the second wire, beside that of its anchor [m]
  double second_wire_share = 0;  // of its length that it reads too much
  double second_wire_drum = 0;   // eccentricity of its drum: amplitude of a cycle of kDrum [m]
};

/// Where an instrument of range and angles stands in R_A; z is up.
inline const KDL::Vector kStation{3.6, -2.9, 1.3};

/// Circumference of the drum of a wire [m].
inline constexpr double kDrum = 0.314;

/// Reads an armtrue-robot/1 file, as far as the oracle needs it.
OracleArm read_arm(const std::string& path);

/// What an effect may depend on.
struct Moment {
  std::array<double, 6> q{};
  std::array<int, 6> arrival{};
  std::array<double, 6> stroke{};    // way since the last reversal, signed
  std::array<double, 6> friction{};  // of Dahl's model, -1 to 1
  double time_s = 0;
  std::array<double, 6> torque{};  // of gravity about each joint [N m]
  // Of the weights beyond frame j about its origin, in its axes; frame 0 is R_0 [N m].
  std::array<KDL::Vector, 6> bending{};
  KDL::Vector overturning;               // of all weights about the base origin, axes of R_0 [N m]
  double payload_kg = 0;                 // carried at the measured frame
  KDL::Vector force;                     // on the measured frame, axes of R_A [N]
  std::array<double, 6> force_torque{};  // of it about each joint [N m]
  double temperature_c = 20;
};
/// An effect changes the arm for the moment of one reading.
using HiddenEffect = std::function<void(const Moment&, OracleArm&)>;

KDL::Frame forward(const OracleArm& arm, const std::array<double, 6>& q);
/// How the measured frame moves per radian of each joint, without the errors of the instrument: a
/// step of Newton's needs no more.
std::array<KDL::Twist, 6> slopes(const OracleArm& arm, const std::array<double, 6>& q);
Moment moment_of(const OracleArm& arm, const std::array<double, 6>& q);

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high);
  double normal();
  int below(int n) { return static_cast<int>(engine_() % static_cast<unsigned>(n)); }

 private:
  std::mt19937 engine_;
};

/// A configuration within nine tenths of the travel of each joint.
std::array<double, 6> random_joints(const OracleArm& arm, Dice& dice);
bool within_travel(const OracleArm& arm, const std::array<double, 6>& q);

struct OracleAnchor {
  KDL::Vector position;  // of the wire's end, in R_A [m]
  double zero = 0;       // what the instrument reads at no distance [m]
};

struct CampaignPlan {
  int poses = 60, repeats = 3;
  double noise_mm = 0.095, noise_mrad = 0.15;
  double blunders = 0;
  double rest_mrad = 0;  // how far each joint rests from what is read; of a pose at every return
  bool orientation = true;
  bool known_masses = false;            // the true arm weighs what the nominal one does
  bool motor_torque = false;            // is logged: what holds the true arm against gravity
  std::vector<OracleAnchor> anchors{};  // if any, distances from each are read instead of poses
  unsigned seed = 1;
};

struct Hidden {
  std::string family;
  std::string parameter, driver;  // as armtrue should name them; empty for none
  HiddenEffect effect;            // of unit size
  double cycles_per_turn = 0;     // of a gear train, if that is what is hidden
  bool conditions = false;        // payload, force and temperature change, and are logged
  double step_at_s = 0;           // when it happened, if something did
  bool strokes = false;           // are logged
};

/// The families that the tests hide; x- are those that no catalogue knows. `x-sum-of-2` and
/// `x-sum-of-12`, so many sines of one joint's angle, take more poses to tell, and `bent-upper-arm`
/// has no leading parameter: they are not among these.
std::vector<std::string> families();
Hidden hidden(const std::string& family, Dice& dice, double duration_s);

struct Written {
  Hidden truth;
  double amplitude = 0;
  double floor_mean_mm = 0;  ///< mean error of the held-out readings against the true poses
};

/// Writes DIR/train.csv and DIR/test.csv: a true arm whose geometry differs from `nominal` by some
/// 0.3 mm and 0.3 mrad everywhere, its masses by 10 to 30 %, and the hidden effect scaled so that
/// `size_mm` RMS of it is left in position after the best geometric refit (in orientation, by 1
/// mrad per mm, where it moves no point; all that it moves, where the refit leaves nothing).
Written write_campaign(const OracleArm& nominal, const std::string& family, double size_mm,
                       const CampaignPlan& plan, const std::string& directory);

/// Writes a campaign of one visit to each pose, in their order: the true arm of the plan's seed,
/// with the effect as it is.
void write_visits(const OracleArm& nominal, const HiddenEffect& effect,
                  const std::vector<std::array<double, 6>>& commanded, const CampaignPlan& plan,
                  const std::string& path);

}  // namespace armtrue_oracle
