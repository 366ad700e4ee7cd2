#include "kernel_impl.hpp"

namespace mlt {
template Kernel kernel_of_group<0>(FeatureMask);
}  // namespace mlt
