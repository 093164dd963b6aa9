#pragma once

#include <Eigen/Core>

/// Eigen's loops over dense matrices of doubles, instantiated once, in kernels.cc. They are named,
/// internal as they are, because each file with a product would else compile them again, which is
/// a third of its time; where Eigen names them otherwise, the list is empty and all compile as
/// before.
#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 90)
namespace Eigen::internal {

using ArmtrueTraits = gebp_traits<double, double>;
using ArmtrueResult = blas_data_mapper<double, Index, ColMajor, Unaligned, 1>;
template <int Order>
using ArmtrueMapper = const_blas_data_mapper<double, Index, Order>;

}  // namespace Eigen::internal

#define ARMTRUE_KERNELS(instantiate)                                                             \
  instantiate struct gebp_kernel<double, double, Index, ArmtrueResult, ArmtrueTraits::mr,        \
                                 ArmtrueTraits::nr, false, false>;                               \
  instantiate struct gemm_pack_lhs<double, Index, ArmtrueMapper<ColMajor>, ArmtrueTraits::mr,    \
                                   ArmtrueTraits::LhsProgress, ArmtrueTraits::LhsPacket4Packing, \
                                   ColMajor>;                                                    \
  instantiate struct gemm_pack_lhs<double, Index, ArmtrueMapper<RowMajor>, ArmtrueTraits::mr,    \
                                   ArmtrueTraits::LhsProgress, ArmtrueTraits::LhsPacket4Packing, \
                                   RowMajor>;                                                    \
  instantiate struct gemm_pack_rhs<double, Index, ArmtrueMapper<ColMajor>, ArmtrueTraits::nr,    \
                                   ColMajor>;                                                    \
  instantiate struct gemm_pack_rhs<double, Index, ArmtrueMapper<RowMajor>, ArmtrueTraits::nr,    \
                                   RowMajor>;                                                    \
  instantiate struct general_matrix_vector_product<Index, double, ArmtrueMapper<ColMajor>,       \
                                                   ColMajor, false, double,                      \
                                                   ArmtrueMapper<RowMajor>, false>;              \
  instantiate struct general_matrix_vector_product<Index, double, ArmtrueMapper<RowMajor>,       \
                                                   RowMajor, false, double,                      \
                                                   ArmtrueMapper<ColMajor>, false>;              \
  ARMTRUE_TRIANGULAR_KERNELS(instantiate, Lower)                                                 \
  ARMTRUE_TRIANGULAR_KERNELS(instantiate, Upper)                                                 \
  ARMTRUE_TRIANGULAR_KERNELS(instantiate, UnitLower)                                             \
  ARMTRUE_TRIANGULAR_KERNELS(instantiate, UnitUpper)

#define ARMTRUE_TRIANGULAR_KERNELS(instantiate, mode)                                             \
  instantiate struct triangular_solve_matrix<double, Index, OnTheLeft, mode, false, ColMajor,     \
                                             ColMajor, 1>;                                        \
  instantiate struct triangular_solve_matrix<double, Index, OnTheLeft, mode, false, RowMajor,     \
                                             ColMajor, 1>;                                        \
  instantiate struct product_triangular_matrix_matrix<double, Index, mode, true, ColMajor, false, \
                                                      ColMajor, false, ColMajor, 1>;              \
  instantiate struct product_triangular_matrix_matrix<double, Index, mode, true, RowMajor, false, \
                                                      ColMajor, false, ColMajor, 1>;
#else
#define ARMTRUE_KERNELS(instantiate)
#endif

namespace Eigen::internal {

ARMTRUE_KERNELS(extern template)

}  // namespace Eigen::internal
