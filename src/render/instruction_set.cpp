#include "render/instruction_set.hpp"

#include "base/assert.hpp"
#include "render/kernel_set.hpp"

extern "C" const mlt::KernelSet mlt_kernel_set_base;
#ifdef MLT_HAS_AVX2
extern "C" const mlt::KernelSet mlt_kernel_set_avx2;
#endif

namespace mlt {

bool is_supported(InstructionSet set) {
  switch (set) {
    case InstructionSet::base:
      return true;
    case InstructionSet::avx2:
#ifdef MLT_HAS_AVX2
      return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
      return false;
#endif
  }
  return false;
}

InstructionSet best_instruction_set() {
  InstructionSet best = InstructionSet::base;
#define MLT_PREFER(name, help) \
  if (is_supported(InstructionSet::name)) best = InstructionSet::name;
  MLT_INSTRUCTION_SETS(MLT_PREFER)
#undef MLT_PREFER
  return best;
}

const KernelSet& kernel_set(InstructionSet set) {
  MLT_CHECK(is_supported(set));
#ifdef MLT_HAS_AVX2
  if (set == InstructionSet::avx2) return mlt_kernel_set_avx2;
#endif
  return mlt_kernel_set_base;
}

}  // namespace mlt
