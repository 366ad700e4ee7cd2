// From the options that say what to render, and how, to a RenderRequest.
#pragma once

#include <string>
#include <vector>

#include "app/words.hpp"
#include "render/job.hpp"

namespace mlt {

/// `defaults` with what the options among `words` say; a value that is not allowed leaves the default and
/// adds to `diagnostics`.
RenderRequest read_request(const Words& words, const RenderRequest& defaults, Diagnostics& diagnostics);

/// A warning for each option given that `integrator` does not look at.
std::vector<std::string> unused_options(const Words& words, IntegratorKind integrator);

}  // namespace mlt
