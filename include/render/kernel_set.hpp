// The part of the program that exists once for each instruction set: everything whose memory layout or code
// depends on the number of SIMD lanes, from the compiled world to the kernels. Its objects are linked into
// one per set, in which every symbol but the table below is local (Makefile, KERNEL_SETS), so that no inline
// function compiled for one set can be called by another.
#pragma once

#include "base/render_zone.hpp"
#include "render/instruction_set.hpp"
#include "render/kernel.hpp"
#include "world/world.hpp"

namespace mlt {

struct KernelSet {
  WorldSlots (*plan_world)(MemoryPlan& plan, const WorldCounts& counts) = nullptr;
  World (*compile_world)(const SceneDescription& scene, const WorldCounts& counts, std::uint32_t width,
                         std::uint32_t height, Arena& arena, const WorldSlots& slots,
                         const UnitRunner& runner) = nullptr;
  Kernel (*select_kernel)(FeatureMask features) = nullptr;
};

/// The set must be supported.
const KernelSet& kernel_set(InstructionSet set);

/// The code of a set where that lies in one piece, else nothing.
CodeRange code_of(InstructionSet set);

}  // namespace mlt
