#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/zone.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/effects/robot.h"

namespace armtrue::app {

/// Splits `A1.alpha, A2.d` at its commas; spaces around an item are dropped.
std::vector<std::string> split_list(const std::string& text);

/// `count` finite numbers separated by commas, or any number of them. Throws std::invalid_argument;
/// the message names the `form`.
std::vector<double> numbers_from_text(const std::string& text, std::optional<size_t> count,
                                      const std::string& form);

/// x,y,z,radius [mm]. Throws std::invalid_argument.
Zone zone_from_text(const std::string& text);

/// x0,x1,y0,y1,z0,z1 [mm] of --box-mm; no box for no numbers. Throws std::invalid_argument if an
/// end lies before its beginning.
std::optional<Box> box_from_numbers(const std::vector<double>& numbers_mm);

/// The encoder values of an option [rad or m] from numbers in deg and mm. Throws UsageError if the
/// robot has another number of joints.
JointVector joints_of(const std::vector<double>& numbers, const Robot& robot,
                      const std::string& option);

}  // namespace armtrue::app
