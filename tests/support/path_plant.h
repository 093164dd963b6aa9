#pragma once

// A machining cell simulated another way, for the tests of paths: a tool that a cutting force
// pushes aside, axes that wind up by friction, a servo that lags, and an instrument with a clock of
// its own. Nothing of armtrue is used. SI units; all vectors in the axes of the cell, z up.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace plant {

enum class Shape {
  line,    ///< 300 mm along x
  arc,     ///< 162 deg of radius 180 mm
  corner,  ///< 150 mm along x, then 150 mm along y, with a stop at the corner as LIN without
           ///< blending
  spiral,  ///< two turns, radius 20 to 70 mm
  pocket,  ///< three squares with a stop at each corner, each 80 mm above and inside the last
};

/// A path as programmed: 16 ms, 27 mm/s, acceleration 0.3 m/s^2, standing for 1 s at both ends. The
/// tool is in the stock between two arc lengths.
struct Program {
  Eigen::VectorXd time;
  Eigen::Matrix3Xd position;
  Eigen::VectorXd arc_length;
  double entry = 0, exit = 0;  ///< arc lengths
};

Program program(Shape shape);

struct Options {
  /// Cutting: per metre of depth the force along (feed, left of it, up); its slow variation belongs
  /// to the part, so that it comes back in every pass of one `part_seed`.
  double depth = 0.008;
  Eigen::Vector3d force_per_depth{-800, 4700, -1600};  ///< [N/m]
  double force_variation = 0.15;                       ///< RMS, relative
  double ramp = 0.004;                                 ///< length of entry and of exit
  std::uint64_t part_seed = 1;
  /// Displacement per force [m/N].
  Eigen::Matrix3d compliance = (Eigen::Matrix3d() << 18e-6, 2e-6, 1e-6,  //
                                2e-6, 22e-6, -1e-6,                      //
                                1e-6, -1e-6, 20e-6)
                                   .finished();
  /// If any, instead of it one for each time of the program: an arm gives way otherwise everywhere.
  std::vector<Eigen::Matrix3d> compliance_along;

  /// Two horizontal axes, the first at this angle to x. Each drags the tool behind by half its
  /// step; after a reversal it takes `wind_up` of travel until it does so the other way. Both come
  /// to the start from beyond it.
  double axes_angle = 0.44;
  std::array<double, 2> reversal_step{0.25e-3, 0.15e-3};
  double wind_up = 20e-6;

  double lag = 0.004;  ///< time constant of the servo; on a straight line nothing tells it from a
                       ///< clock offset
  Eigen::Vector3d static_offset{0.03e-3, -0.02e-3, 0.04e-3};
  double repeatability =
      0;  ///< RMS per axis of a smooth change from pass to pass; 0.03e-3 is usual

  /// The instrument: its time is (1 + clock_rate) * (time of the program) + clock_offset.
  double clock_offset = 1.0, clock_rate = 100e-6;
  double period = 0.032;
  double noise = 0.095e-3;   ///< of the position, per axis
  double force_noise = 1.5;  ///< per axis
  double lost = 0.01;        ///< share of samples without a row
  std::uint64_t pass_seed = 1;
};

/// Everything off: the tool is where it was told to be, and the instrument shows it.
Options ideal();

struct Record {
  // As the instrument has it.
  Eigen::VectorXd time;
  Eigen::Matrix3Xd position, force;
  // What nobody knows: the tool at the times of the program.
  Eigen::VectorXd true_time;
  Eigen::Matrix3Xd true_position, true_force;
};

/// Runs `commanded`, one position for each time of the program (the program itself, or a corrected
/// one): the stock stays where the program is.
Record run(const Program& program, const Eigen::Matrix3Xd& commanded, const Options& options);

/// Distance of each position, one for each time of the program, from the programmed path.
Eigen::VectorXd distances(const Program& program, const Eigen::Matrix3Xd& position);

/// Their mean over the samples in motion: the mean 3-D deviation normal to the path.
double mean_distance(const Program& program, const Eigen::Matrix3Xd& position);

}  // namespace plant
