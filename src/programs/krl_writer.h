#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/path/path.h"
#include "armtrue/programs/krl.h"
#include "programs/krl_plan.h"
#include "programs/krl_syntax.h"

namespace armtrue {

/// Writes the corrected program, as correct_krl() says. `plans`: one for each move of `syntax`.
CorrectedKrl write_corrected_krl(const KrlProgram& program, const KrlSyntax& syntax,
                                 const std::vector<KrlPlannedMove>& plans, const Path& programmed,
                                 const Eigen::Matrix3Xd& corrected,
                                 const KrlCorrectionOptions& options);

}  // namespace armtrue
