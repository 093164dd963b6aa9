#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"

namespace armtrue {

/// What a controller holds of its mastering, by number of the axis, from 1.
struct Mastering {
  /// `$MAMES[i]` of KUKA's $machine.dat [deg or mm], assigned to axis i where it is mastered; or
  /// `$DMR_GRP[1].$MASTER_COUN[i]` of FANUC's SYSMAST.VA, the count of the encoder at 0 deg.
  enum class Maker { kuka, fanuc } maker = Maker::kuka;
  std::string file;
  std::map<int, double> values;
};

/// Reads either file. Throws InputError for any other text, and for numbers that are none.
Mastering read_mastering(const std::string& text, const std::string& file);

/// The table of the fields in which a controller holds zero offsets, and KUKA a positioner: columns
/// `axis,field,unit,change,old,new`. `change` is what is added to the value that the controller
/// shows: an exact arm with the zero offsets of `fitted` stands there. `nominal`: the model of the
/// controller. `mastering`: what it holds now; without it `old` and `new` are empty.
/// `counts_per_degree`: by axis, of FANUC, negative where the count falls while the axis rises.
/// Throws InputError where the controller has no such axis or the counts are not known.
std::string write_controller_fields(const Robot& fitted, const KinematicChain& nominal,
                                    const std::optional<Mastering>& mastering,
                                    const std::vector<double>& counts_per_degree);

}  // namespace armtrue
