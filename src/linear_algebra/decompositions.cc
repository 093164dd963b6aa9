#include "linear_algebra/decompositions.h"

namespace Eigen {

ARMTRUE_DECOMPOSITIONS(template)

}  // namespace Eigen
