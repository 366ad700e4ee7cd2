// Instruction sets that the renderer's inner code is compiled for, in one binary; the best that the processor
// offers is taken unless the job names one. All give the same bits, so the choice is none of the job's image.
#pragma once

#include <cstdint>

namespace mlt {

/// name, help text; in ascending order of preference.
#define MLT_INSTRUCTION_SETS(X)                                     \
  X(base, "what every processor of the machine's architecture has") \
  X(avx2, "x86-64 with AVX2: eight lanes instead of four")

enum class InstructionSet : std::uint8_t {
#define MLT_ENUMERATE(name, help) name,
  MLT_INSTRUCTION_SETS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
};

/// Whether the binary holds code for it and the processor can run that.
bool is_supported(InstructionSet set);

InstructionSet best_instruction_set();

}  // namespace mlt
