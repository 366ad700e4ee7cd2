#include "render/kernel.hpp"

#include "kernel_impl.hpp"

namespace mlt {

#define MLT_KERNEL_GROUPS(X) X(0) X(1) X(2) X(3)

#define MLT_DECLARE(group) extern template Kernel kernel_of_group<group>(FeatureMask);
MLT_KERNEL_GROUPS(MLT_DECLARE)
#undef MLT_DECLARE

Kernel select_kernel(FeatureMask features) {
  MLT_CHECK(is_consistent(features));
  switch (features / kMasksPerGroup) {
#define MLT_CASE(group) \
  case group:           \
    return kernel_of_group<group>(features);
    MLT_KERNEL_GROUPS(MLT_CASE)
#undef MLT_CASE
  }
  MLT_CHECK_OP(features, <, kFeatureMaskCount);
  return {};
}

}  // namespace mlt
