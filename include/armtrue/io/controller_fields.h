#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"

namespace armtrue {

/// The mastering values of a controller, by number of the axis, from 1.
struct Mastering {
  /// `$MAMES[i]` of KUKA's $machine.dat [deg or mm], assigned to axis i where it is mastered; or
  /// `$DMR_GRP[1].$MASTER_COUN[i]` of FANUC's SYSMAST.VA, the count of the encoder at 0 deg.
  enum class Maker { kuka, fanuc } maker = Maker::kuka;
  std::string file;
  std::map<int, double> values;
};

/// Reads the file of KUKA or FANUC. Throws InputError for any other text, and for malformed
/// numbers.
Mastering read_mastering(const std::string& text, const std::string& file);

/// CSV text of the fields in which a controller holds zero offsets, and KUKA a positioner: columns
/// `axis,field,unit,change,old,new`. `change` is added to the angle that the controller shows; it
/// is then that of an exact arm with the zero offsets of `fitted`. `nominal`: the model of the
/// controller. `mastering`: its present values; without them `old` and `new` are empty.
/// `counts_per_degree`: by axis, of FANUC, negative where the count falls while the axis rises.
/// Throws InputError where the controller has no such axis or the counts are not known.
std::string write_controller_fields(const Robot& fitted, const KinematicChain& nominal,
                                    const std::optional<Mastering>& mastering,
                                    const std::vector<double>& counts_per_degree);

}  // namespace armtrue
