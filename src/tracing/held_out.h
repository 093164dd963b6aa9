#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/tracing/loop.h"
#include "tracing/judged_names.h"

namespace armtrue {

/// What held-out poses say of found effects. They choose only between models that the training
/// poses found: see close_loop().

/// The pose of each reading of an evaluation, from 0.
std::vector<int> poses_of_readings(const Campaign& campaign);

/// Of an effect, by the errors of the readings without it and with it [m].
HeldOutGain gain_of(const std::vector<double>& without, const std::vector<double>& with,
                    const Campaign& held_out, const TraceOptions& options);

/// The effects of a search if held-out poses are predicted worse with them than by the geometry: by
/// a standard error, and by so much that it matters.
std::optional<RejectedModel> rejected_model(const TraceResult& trace, const Campaign& held_out,
                                            const TraceOptions& options);

/// Whether all that the search left in the model are effects that their prior alone holds, and
/// held-out poses are not predicted better with them, by a standard error. Nothing else speaks for
/// them, and an arm without them would become worse.
bool is_against_held(const TraceResult& trace, const Campaign& held_out,
                     const TraceOptions& options);

/// Leaves out found effects that held-out poses deny, or weak ones that they do not support, the
/// worst first; the random effects are then those beside the rest. Returns describe() of each.
std::vector<std::string> leave_out_worse(JudgedTraining& judged, const Campaign& held_out,
                                         const Catalogue& catalogue, const TraceOptions& options);

/// Whether held-out poses speak for the random effects of an arm. Where joints err more than the
/// instrument does, as rounded angles do, the few held-out poses are predicted better by chance:
/// then by a standard error. Beside random errors of the instrument the arm need not predict better
/// than beside a law.
bool speak_for(const Robot& applied, const JudgedTraining& judged, const Campaign& held_out,
               const TraceOptions& options);

}  // namespace armtrue
