#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/path/registration/clock.h"

namespace armtrue {

/// A span of time in which a machine stands still [s].
struct Standstill {
  double begin = 0, end = 0;
};

/// The standstills of a record: the spans of 0.5 s or more in which every 0.5 s keep all rows of
/// `values` (one column per sample) within `tolerance` of each row. A span in which a row moves on
/// by more than three tolerances creeps and is left out. `times` increase.
std::vector<Standstill> find_standstills(const Eigen::VectorXd& times,
                                         const Eigen::MatrixXd& values,
                                         const Eigen::VectorXd& tolerance);

/// By how much the points of an instrument may differ while it measures a machine at rest [m]:
/// three times the extent that the calmest tenth of all spans of 0.5 s stays below, at least
/// 0.05 mm. Nothing sure if the machine rests for less than a tenth of the record.
double rest_tolerance(const Eigen::VectorXd& times, const Eigen::Matrix3Xd& points);

/// One way in which the readings of an instrument may belong to the standstills of a machine.
struct StandstillMatch {
  ClockFit clock;              ///< t_instrument = offset + (1 + rate) * t_machine
  std::vector<int> standstill;  ///< of each reading: index of the standstill, or -1
  int standstills = 0;         ///< how many have a reading
};

/// The readings that lie within standstills by this clock, to `tolerance` [s].
StandstillMatch match_by_clock(const std::vector<Standstill>& standstills,
                               const std::vector<Standstill>& readings, const ClockFit& clock,
                               double tolerance);

/// All ways to join two records with clocks of their own, those that match most standstills first;
/// those that match less than half as many as the first are left out. A reading is a span of time,
/// or an instant, that must lie within a standstill to `tolerance` [s].
///
/// The clock is searched over all offsets and over rates up to 5e-4: each pair of a reading and a
/// standstill allows an interval of offsets, and the offsets of a match are where most intervals
/// overlap. Least squares of the middles then refine offset and rate, the rate with the standard
/// deviation of a quartz as its prior. fit_clock() cannot do this: it compares positions, and here
/// neither the frame of the instrument nor the place of the reflector is known.
/// Standstills and readings are in the order of time.
std::vector<StandstillMatch> match_standstills(const std::vector<Standstill>& standstills,
                                               const std::vector<Standstill>& readings,
                                               double tolerance);

}  // namespace armtrue
