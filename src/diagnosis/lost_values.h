#pragma once

#include "armtrue/campaign/campaign.h"
#include "armtrue/diagnosis/log_check.h"

namespace armtrue {

/// Adds to `findings` the marks that loggers write in place of a value that they did not get, such
/// as -127 or 85 of a temperature, 0 of a time, -9999 or 3276.7 of a load. Errors: a number that
/// stands in three rows or more to the last digit, and
/// - as a temperature, comes back, and jumps from and to its neighbours in the order of the visits
///   by 10 K and by ten steps (median) of the series, or lies farther from all others than they do
///   from each other;
/// - as a time, is that of several poses while each other pose has a time of its own, and the clock
///   goes on after it without a gap;
/// - as a force or a torque, lies ten times as far from all others as they do from each other, or
///   stands in all of a row's components.
/// Warnings: a temperature that stays the same to the last digit and then jumps; torques that are
/// all zero; a payload that is far from all others, or zero again and again between rows with load.
void check_lost_values(const Campaign& campaign, Findings& findings);

}  // namespace armtrue
