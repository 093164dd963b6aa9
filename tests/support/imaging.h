#pragma once

// Images of a board by a camera, one of both on an arm simulated by KDL: what a calibration without
// a tracker reads.

#include <array>
#include <kdl/frames.hpp>
#include <string>
#include <vector>

#include "oracle.h"

namespace armtrue_oracle {

/// A camera as OpenCV describes one: pinhole with k1 k2 p1 p2 k3, or fisheye with k1 k2 k3 k4.
struct Eye {
  std::string name = "eye";
  bool fisheye = false, on_arm = true;
  double fx = 1200, fy = 1205, cx = 660, cy = 470;  // px
  std::array<double, 5> distortion{};
  int width = 1280, height = 960;
  KDL::Frame place;  // in the measured frame, or in R_A
};

/// The corners of a grid, numbered from 0, row by row.
struct Grid {
  std::string name = "plate";
  int columns = 7, rows = 5;
  double pitch = 0.03;  // m
  KDL::Frame place;     // in R_A, or in the measured frame
};

/// The pixel of a point in the axes of the camera [px]; the point must lie before it.
std::array<double, 2> pixel_of(const Eye& eye, const KDL::Vector& point);

struct ImagingPlan {
  int poses = 40, repeats = 1;
  double noise_px = 0.3;
  double wrong_ids = 0;          // share of corners whose ids are exchanged, in pairs
  double near = 0.4, far = 0.8;  // distance of the camera from the middle of the board [m]
  double tilt = 0.6;             // of the board from facing the camera, at most [rad]
};

/// A file of measurements, pose,repeat,q1_deg..q6_deg,camera,board,corner,u_px,v_px: configurations
/// within 0.9 of the travel in which all corners of the board lie in the image, as the effect
/// changes the arm. `repeats` are numbered.
std::string images_csv(const OracleArm& arm, const HiddenEffect& effect, const Eye& eye,
                       const Grid& grid, const ImagingPlan& plan, Dice& dice);

}  // namespace armtrue_oracle
