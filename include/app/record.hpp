// What is kept of a render besides its pixels: the command that reproduces it, the metadata inside images,
// the statistics file and the closing summary.
#pragma once

#include <string>
#include <vector>

#include "base/json_string.hpp"
#include "image/image_io.hpp"
#include "render/job.hpp"
#include "render/pilot.hpp"
#include "render/renderer.hpp"

namespace mlt {

/// `word` as a POSIX shell reads it back: quoted where it holds more than plain characters.
std::string shell_quote(const std::string& word);

/// The full form of `mlt render` that gives the same image bit for bit, with every default written out.
/// Leaves out what has no influence on pixels: threads, memory limit, names of outputs. The exposure, which
/// changes only PNG files, stands last and only when it is not 0. `rounds` are those made, or to be made.
std::string canonical_command(const std::string& scene, const RenderJob& job, float exposure,
                              std::uint64_t rounds);

struct RenderRecord {
  RenderJob job;
  RenderStatistics statistics;
  std::string command;                ///< canonical_command
  std::optional<PilotFinding> pilot;  ///< of a request that left the integrator to a pilot
  std::size_t planned_memory_bytes = 0;
  std::size_t peak_memory_bytes = 0;
};

/// Highest resident memory of this process so far, in bytes; 0 when the system does not tell.
std::size_t peak_memory_bytes();

/// For images: Software, Version, Command, Seed, Film-Hash, Partial ("yes" or "no").
std::vector<TextEntry> image_metadata(const RenderRecord& record);

/// One JSON object, one key a line. Numbers that are not finite become null.
std::string to_json(const RenderRecord& record);

/// The closing summary, several lines.
std::string summary(const RenderRecord& record);

}  // namespace mlt
