#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/path/path.h"
#include "armtrue/path/registration/aside.h"
#include "armtrue/path/registration/clock.h"
#include "armtrue/path/registration/pause.h"
#include "armtrue/path/samples/bad_samples.h"

namespace armtrue {

/// A jump of the record between two samples that does not go back.
struct RecordStep {
  Eigen::Index sample;  ///< first after the jump
  double moved;         ///< [m]
};

/// The rigid motion that removes most of the deviation of a record.
struct RigidDeviation {
  double before, after;  ///< rms of the deviation as recorded, and without the rigid motion [m]
  double moved;          ///< displacement of the middle of the record [m]
  double turned;         ///< [rad]
};

/// A record that does not end where it began, of a program that does. Both ends are means of
/// samples in which the tool stands.
struct OpenRecord {
  Eigen::Index first, last;  ///< the samples of the record between which the program moves
  double apart;              ///< [m]
  double changes;            ///< what the tool may be apart, see RecordDoubts [m]
};

/// A stretch in which the record does not follow the shape of the program.
struct UnfollowedShape {
  Eigen::Index first, last;  ///< samples of the record
  double shape;              ///< rms distance of the program from an even straight motion [m]
  double followed;           ///< share of that shape that the record has
};

/// Time by which a record passes the places of the program later than its clock says.
struct TimeLag {
  double median;    ///< of the samples in motion [s]
  double earliest;  ///< median of the quarter of these samples that is earliest [s]
  double latest;    ///< of the one that is latest [s]
  double speed;     ///< median [m/s]
  double across;    ///< three quarters of the samples deviate across the path by less [m]

  /// From the earliest to the latest quarter, along the path [m].
  double spread() const { return (latest - earliest) * speed; }
};

/// A rotation of the whole record about the part, which round parts hide: their form stays, and
/// each place of it moves along the path.
struct TurnedRecord {
  double turned;  ///< [rad]
  double along;   ///< median along the path [m]
};

/// Deviations that are more likely errors of the instrument, or of another program, than of the
/// arm. A correction would copy them into the part.
struct RecordDoubts {
  /// Present if the record runs beside the program by more than 2 mm, see find_aside(): a cut bends
  /// no arm so far all along. `step`, `rigid`, `turned` and `open` are empty then.
  std::optional<Aside> aside;
  /// A jump above 1.5 mm and above 6 times the median change from sample to sample. At least 70 %
  /// of it remain over ten samples, while the program keeps its velocity. An arm that a cut bends
  /// moves more slowly.
  std::optional<RecordStep> step;
  /// Present if the deviation is above 2 mm and the motion leaves at most a third of it. An arm
  /// with the same error all along the path looks the same.
  std::optional<RigidDeviation> rigid;
  /// Present if the tool stands at both ends of the record, and one motion of the whole record,
  /// turned by more than 0.3 deg, leaves a third of its deviation along the path, also at the
  /// standing ends, where neither clock nor lag moves it. Arms err by 1 to 2 mm in a metre, which
  /// turns a part by 0.1 deg. Empty if `rigid` is present.
  std::optional<TurnedRecord> turned;
  /// Present if one factor about the middle, beyond 1 +- 0.005, leaves a third of the deviation
  /// along the path that motions of the record, a lag and the rate of a clock leave: arms err by 1
  /// to 2 mm in a metre, and forces bend them across the path. The factor less 1.
  std::optional<double> scaled;
  /// Present if the program ends where it starts, with ten samples of the record at least in which
  /// it stands, there and here, and these are farther apart than the changes of the deviation where
  /// the tool starts, where it stops, and the largest at a corner (elsewhere, 19 of 20 are below
  /// it), all three together. They are changes from ten samples to the next ten, so they contain
  /// the noise, and backlash, which an arm that came from another side takes up there.
  /// Empty if `step` or `turned` is present.
  std::optional<OpenRecord> open;
  /// Takes halves and quarters of the samples. There p and m are the differences of the program and
  /// of the record from their best straight motion with constant velocity. Present if p is above 2
  /// mm (rms) and <m, p> / <p, p> < 0.5. The servos of an arm cut corners by less.
  /// Empty if `pause` is present.
  std::optional<UnfollowedShape> unfollowed;
  /// Empty if too few samples are in motion.
  std::optional<TimeLag> lag;
  /// Says that the pass ran at another feed, see find_other_feed(). Only of a record that begins
  /// and ends where the program does. On a straight path such a pass can be registered.
  /// Empty if `pause` is present.
  std::optional<std::string> feed;
  std::optional<Pause> pause;
  /// Present if more than 2 mm (rms) are left in whatever place of the whole record, and none of
  /// the others but `open`, `lag` and `feed` is: an arm errs by less within a part.
  std::optional<RigidDeviation> other_shape;
};

/// The coordinates (0 to 2) of a record that were not measured: all samples have one value, or
/// those of the program in its order, to the last digit, while another coordinate has noise. Empty
/// if the digits of the record are too few to show its noise.
std::vector<Eigen::Index> find_copied_coordinates(const Path& programmed, const Path& record);

/// A coordinate that stays while the tool moves on: all samples from `first` to `last` have one
/// value, to the last digit.
struct FrozenCoordinate {
  Eigen::Index axis;  ///< 0 to 2
  Eigen::Index first, last;
};

/// The longest such run, of samples whose other coordinates change, if chance makes it with a
/// probability below 1e-6: N p^(n - 1), with n its samples, N those of the record, and p the share
/// of neighbours elsewhere in the record that are equal, at least that of noise which is three
/// steps wide. Empty where the digits are too few to show the noise, a tenth of it or more.
std::optional<FrozenCoordinate> find_frozen_coordinate(const Path& record);

/// Whether a record is no reading of an instrument but a product of mirror-correct, such as the
/// corrected path: it has the times of the program and less noise than 0.1 um.
bool looks_computed(const Path& programmed, const Path& record);

/// Where a record begins to hold the readings of another one: the first samples of both that are
/// the same, but for one displacement and the rounding of the coarser record. At least half of the
/// shorter record, with noise of ten digits: no two passes share their noise.
std::optional<std::pair<Eigen::Index, Eigen::Index>> find_copy(const Path& record,
                                                               const Path& other);

/// Share of the samples that lie just between their neighbours, if they are more than half, and the
/// others have noise: their second differences change their sign. 0 if not.
double interpolated_share(const Path& record);

RecordDoubts record_doubts(const Path& programmed, const Path& measured, const ClockFit& clock,
                           const std::vector<BadSample>& bad);

}  // namespace armtrue
