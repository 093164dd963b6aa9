#include "linear_algebra/kernels.h"

namespace Eigen::internal {

ARMTRUE_KERNELS(template)

}  // namespace Eigen::internal
