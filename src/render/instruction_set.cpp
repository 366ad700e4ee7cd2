#include "render/instruction_set.hpp"

#include "base/assert.hpp"
#include "render/kernel_set.hpp"

// A set that the binary was linked without has no address. The linker defines the ends of the section that
// the Makefile puts a set's code into.
#define MLT_DECLARE(name, help, condition)                                                 \
  extern "C" [[gnu::weak]] const mlt::KernelSet mlt_kernel_set_##name;                     \
  extern "C" [[gnu::weak, gnu::visibility("hidden")]] const char __start_kernels_##name[]; \
  extern "C" [[gnu::weak, gnu::visibility("hidden")]] const char __stop_kernels_##name[];
MLT_INSTRUCTION_SETS(MLT_DECLARE)
#undef MLT_DECLARE

#if defined(__x86_64__)
#define MLT_CPU_HAS(feature) (__builtin_cpu_supports(feature) != 0)
#else
#define MLT_CPU_HAS(feature) false
#endif

namespace mlt {

const char* instruction_set_name(InstructionSet set) {
  switch (set) {
#define MLT_CASE(name, help, condition) \
  case InstructionSet::name:            \
    return #name;
    MLT_INSTRUCTION_SETS(MLT_CASE)
#undef MLT_CASE
  }
  return "";
}

bool is_supported(InstructionSet set) {
  switch (set) {
#define MLT_CASE(name, help, condition) \
  case InstructionSet::name:            \
    return &mlt_kernel_set_##name != nullptr && (condition);
    MLT_INSTRUCTION_SETS(MLT_CASE)
#undef MLT_CASE
  }
  return false;
}

InstructionSet best_instruction_set() {
  InstructionSet best = InstructionSet::base;
#define MLT_PREFER(name, help, condition) \
  if (is_supported(InstructionSet::name)) best = InstructionSet::name;
  MLT_INSTRUCTION_SETS(MLT_PREFER)
#undef MLT_PREFER
  return best;
}

const KernelSet& kernel_set(InstructionSet set) {
  MLT_CHECK(is_supported(set));
  switch (set) {
#define MLT_CASE(name, help, condition) \
  case InstructionSet::name:            \
    return mlt_kernel_set_##name;
    MLT_INSTRUCTION_SETS(MLT_CASE)
#undef MLT_CASE
  }
  return mlt_kernel_set_base;
}

CodeRange code_of(InstructionSet set) {
  switch (set) {
#define MLT_CASE(name, help, condition) \
  case InstructionSet::name:            \
    return {__start_kernels_##name, __stop_kernels_##name};
    MLT_INSTRUCTION_SETS(MLT_CASE)
#undef MLT_CASE
  }
  return {};
}

}  // namespace mlt
