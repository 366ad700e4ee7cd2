#include "render/kernel_set.hpp"

#ifndef MLT_KERNEL_SET
#define MLT_KERNEL_SET mlt_kernel_set_base
#endif

extern "C" const mlt::KernelSet MLT_KERNEL_SET;
extern "C" const mlt::KernelSet MLT_KERNEL_SET{&mlt::plan_world, &mlt::compile_world, &mlt::select_kernel};
