// Instruction sets that the renderer's inner code is compiled for, in one binary; the best that the processor
// offers is taken unless the job names one. All give the same bits, so the choice is none of the job's image.
#pragma once

#include <cstdint>

namespace mlt {

/// name, help text, what the processor must have: the flags that the Makefile compiles the set with; in
/// ascending order of preference. MLT_CPU_HAS is for src/render/instruction_set.cpp alone to define.
#define MLT_INSTRUCTION_SETS(X)                                                                       \
  X(base, "what every processor of the machine's architecture has", true)                             \
  X(avx2, "x86-64 with AVX2: eight lanes instead of four", MLT_CPU_HAS("avx2") && MLT_CPU_HAS("fma")) \
  X(avx512, "x86-64 with AVX-512: sixteen lanes where chains are lanes",                              \
    MLT_CPU_HAS("avx512f") && MLT_CPU_HAS("avx512vl") && MLT_CPU_HAS("avx512dq") &&                   \
        MLT_CPU_HAS("avx512bw") && MLT_CPU_HAS("avx2") && MLT_CPU_HAS("fma") && MLT_CPU_HAS("bmi") && \
        MLT_CPU_HAS("bmi2"))

enum class InstructionSet : std::uint8_t {
#define MLT_ENUMERATE(name, help, condition) name,
  MLT_INSTRUCTION_SETS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
};

/// As `--isa` takes it.
const char* instruction_set_name(InstructionSet set);

/// Whether the binary holds code for it and the processor can run that.
bool is_supported(InstructionSet set);

InstructionSet best_instruction_set();

}  // namespace mlt
