#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/path/registration/clock.h"

namespace armtrue {

/// A span of time in which a machine stands still [s].
struct Standstill {
  double begin = 0, end = 0;
};

/// The standstills of a record: the spans of 0.5 s or more in which each row of `values` (one
/// column per sample) stays within its `tolerance` during every 0.5 s. A span in which a row
/// changes by more than three tolerances in all is a slow motion and is left out. `times` increase.
std::vector<Standstill> find_standstills(const Eigen::VectorXd& times,
                                         const Eigen::MatrixXd& values,
                                         const Eigen::VectorXd& tolerance);

/// By how much the points of an instrument may differ while the machine is at rest [m]: three times
/// the 10 % quantile of the extent of the points over all spans of 0.5 s, at least 0.05 mm. Not
/// reliable if the machine rests for less than a tenth of the record.
double rest_tolerance(const Eigen::VectorXd& times, const Eigen::Matrix3Xd& points);

/// One possible assignment of the readings of an instrument to the standstills of a machine.
struct StandstillMatch {
  ClockFit clock;               ///< t_instrument = offset + (1 + rate) * t_machine
  std::vector<int> standstill;  ///< of each reading: index of the standstill, or -1
  int standstills = 0;          ///< number of standstills with a reading
};

/// The readings that lie within standstills, to `tolerance` [s], if `clock` is the clock.
StandstillMatch match_by_clock(const std::vector<Standstill>& standstills,
                               const std::vector<Standstill>& readings, const ClockFit& clock,
                               double tolerance);

/// All ways to join two records with different clocks, those that match most standstills first.
/// Ways that match less than half as many as the first are left out. A reading is a span of time,
/// or an instant, that must lie within a standstill to `tolerance` [s].
///
/// The search covers all offsets and rates up to 5e-4. Each pair of a reading and a standstill
/// allows an interval of offsets; a match is an offset where most intervals overlap. Of more than
/// 200 readings, runs of 100 successive ones find the clocks, which grow onto all. Least squares
/// on the middles of the spans then refine offset and rate; the rate has a prior with the standard
/// deviation of a quartz clock. fit_clock() cannot do this: it compares positions, and here neither
/// the frame of the instrument nor the place of the reflector is known. Standstills and readings
/// are in the order of time.
std::vector<StandstillMatch> match_standstills(const std::vector<Standstill>& standstills,
                                               const std::vector<Standstill>& readings,
                                               double tolerance);

}  // namespace armtrue
