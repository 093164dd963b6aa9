#pragma once

#include <array>

#include "armtrue/path/path.h"
#include "support/path_plant.h"

namespace armtrue {

inline constexpr std::array kShapes{plant::Shape::line, plant::Shape::arc, plant::Shape::corner,
                                    plant::Shape::spiral};

inline Path path_of(const plant::Program& program) {
  Path path;
  path.time = program.time;
  path.position = program.position;
  return path;
}

/// What the instrument recorded.
inline Path record_of(const plant::Record& record) {
  Path path;
  path.time = record.time;
  path.position = record.position;
  path.force = record.force;
  return path;
}

/// The cell number `k`: another part, clock and direction of its axes.
inline plant::Options cell(int k) {
  plant::Options options;
  options.part_seed = 100 + static_cast<std::uint64_t>(k);
  options.pass_seed = 1 + static_cast<std::uint64_t>(k);
  options.clock_offset = 0.3 + 0.037 * k;
  options.clock_rate = (k % 5 - 2) * 70e-6;
  options.axes_angle = 0.44 + 0.3 * k;
  return options;
}

}  // namespace armtrue
