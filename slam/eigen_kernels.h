// The kernel of Eigen's products of large matrices. It takes seconds to compile, so it is compiled only once,
// in measurement.cc.
#pragma once

#include <Eigen/Core>

namespace Eigen::internal {

using ProductSizes = gebp_traits<double, double>;
extern template struct gebp_kernel<double, double, Index, blas_data_mapper<double, Index, ColMajor>,
                                   ProductSizes::mr, ProductSizes::nr, false, false>;

}  // namespace Eigen::internal
