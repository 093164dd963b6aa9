#pragma once

#include <string>
#include <vector>

#include "armtrue/path/mirror/force_law.h"
#include "armtrue/path/mirror/mirror.h"
#include "armtrue/path/samples/bad_samples.h"
#include "command_line.h"

namespace armtrue::app {

/// Warnings of deviations that are more likely a mistake than an error of the arm; see
/// record_doubts.h and pass_doubts.h.

/// A record that is named twice looks like two passes that agree: throws InputError. The program,
/// named as a record, looks like a pass without deviation: warns. `files`: the program, then the
/// records.
void refuse_the_same(Command& command, const std::vector<const PathFile*>& files);

/// Throws InputError if the path has the marks of a correction: it is neither a path as it should
/// be nor a record. `instead`: what belongs there; `of_mirror`: what else, if mirror-correct wrote it.
void refuse_corrected(const PathFile& path, const std::string& instead,
                      const std::string& of_mirror = "");

/// Throws InputError if a pass holds the readings of another one, trimmed, shifted or rounded.
void refuse_copies(const std::vector<PathFile>& records);

/// Of records with samples between the readings.
void warn_of_interpolated(Command& command, const std::vector<PathFile>& records);

/// Of passes of a certificate, what their records leave in doubt. `clocks`: of the passes.
void warn_of_certified(Command& command, const PathFile& commanded,
                       const std::vector<PathFile>& passes, const std::vector<ClockFit>& clocks,
                       const ClockOptions& options);

/// Of records that no instrument made, such as a corrected path.
void warn_of_computed(Command& command, const PathFile& programmed,
                      const std::vector<PathFile>& records);

/// Of coordinates of records that were not measured.
void warn_of_copied(Command& command, const PathFile& programmed,
                    const std::vector<PathFile>& records);

void warn_of_bad(Command& command, const PathFile& pass, const std::vector<BadSample>& bad);

/// Throws InputError: too many samples are bad.
[[noreturn]] void refuse(const PathFile& pass, const std::vector<BadSample>& bad);

/// The same of samples that are kept, because they count.
void warn_of_bad_kept(Command& command, const PathFile& pass, const std::vector<BadSample>& bad);

/// Of a corrected path, what the records of its passes leave in doubt.
void warn_of_doubts(Command& command, const PathFile& programmed,
                    const std::vector<PathFile>& passes, const MirrorResult& result,
                    const MirrorOptions& options);

/// A stretch that no sample covers is not corrected; a gap inside a record is interpolated. Between
/// samples of the program the correction is straight.
void warn_of_gaps(Command& command, const PathFile& programmed, const MirrorResult& result);

/// Warns if the robot file hardly predicts what the passes show: the forces are in another unit, or
/// their axes are exchanged.
void warn_of_prediction(Command& command, const PathFile& pass, const ForceLine& measured);

/// Warns if no arm yields so to the force that the passes recorded, as by forces in kN.
void warn_of_force_law(Command& command, const PathFile& pass, const ForceLaw& measured);

/// Of --from-force: warns if the deviation that the forces make is none of an arm, as of forces in
/// kN or mN. `deviation`: of each sample [m].
void warn_of_forces(Command& command, const PathFile& programmed, const Eigen::Matrix3Xd& deviation,
                    const MirrorOptions& options);

/// Warns of samples whose correction --max-mm cuts, and if hardly anything is corrected, as with
/// one in m.
void warn_of_clipping(Command& command, const MirrorResult& result, const MirrorOptions& options);

}  // namespace armtrue::app
