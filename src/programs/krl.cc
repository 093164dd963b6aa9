#include "armtrue/programs/krl.h"

#include "programs/krl_plan.h"
#include "programs/krl_syntax.h"
#include "programs/krl_writer.h"

namespace armtrue {

CorrectedKrl correct_krl(const KrlProgram& program, const Path& programmed,
                         const Eigen::Matrix3Xd& corrected, const KrlCorrectionOptions& options) {
  const KrlSyntax syntax = parse_krl(program);
  return write_corrected_krl(program, syntax, plan_krl_moves(program, syntax, programmed),
                             programmed, corrected, options);
}

}  // namespace armtrue
