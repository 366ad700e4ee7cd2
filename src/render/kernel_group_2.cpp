#include "kernel_impl.hpp"

namespace mlt {
template Kernel kernel_of_group<2>(FeatureMask);
}  // namespace mlt
