// Renders jobs in process, and compares their images with numbers and with each other. The replicates of an
// estimate are renders with different seeds: nothing is assumed about what happens inside one render, where
// the states of a chain depend on each other.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "film/image_view.hpp"
#include "render/renderer.hpp"
#include "scene/parse.hpp"
#include "support/statistics.hpp"

namespace mlt::test {

#define MLT_ENUMERATE(name, help) IntegratorKind::name,
inline constexpr IntegratorKind kIntegrators[] = {MLT_INTEGRATOR_KINDS(MLT_ENUMERATE)};
#undef MLT_ENUMERATE

const char* name_of(IntegratorKind kind);

/// Samples a pixel for a statistical test: `samples` in optimised builds, an eighth of them where sanitizers
/// or missing optimisation make each about ten times as slow. The tests stay valid, for they measure their
/// own noise, and only lose power.
std::uint64_t scaled_effort(std::uint64_t samples);

struct RenderResult {
  ImageBuffer image;
  RenderStatistics statistics;
};

/// The whole way from request to developed image, on request.threads workers (default here: one).
RenderResult render(const SceneDescription& scene, RenderRequest request);
RenderResult render(std::string_view scene_text, const RenderRequest& request);

/// A job of `side` x `side` pixels. For PSSMLT, chains of at least 256 mutations and a bootstrap of as many
/// paths as half the mutations, but 1024 at least.
RenderRequest small_request(IntegratorKind kind, std::uint32_t side, std::uint64_t samples_per_pixel,
                            std::uint32_t depth);

/// Renders with seeds first_seed, first_seed + 1, ...
std::vector<RenderResult> render_replicates(const SceneDescription& scene, RenderRequest request,
                                            std::uint32_t replicates, std::uint64_t first_seed);

/// Mean of one channel (0, 1, 2) over the rectangle [x0, x1) x [y0, y1) of the image.
double mean_of(const ImageView& image, int channel, std::uint32_t x0, std::uint32_t y0, std::uint32_t x1,
               std::uint32_t y1);
double mean_of(const ImageView& image, int channel);
double mean_luminance(const ImageView& image);
/// Over the part of [x0, x1) x [y0, y1) that lies in the image.
double mean_luminance(const ImageView& image, std::uint32_t x0, std::uint32_t y0, std::uint32_t x1,
                      std::uint32_t y1);

/// Share of the image's energy that differs between two renders of the same primary samples.
double difference_share(const RenderResult& a, const RenderResult& b);

using Statistic = std::function<double(const ImageView&)>;

/// `statistic` of each replicate.
std::vector<double> statistics_of(const std::vector<RenderResult>& replicates, const Statistic& statistic);
Moments moments_of(const std::vector<RenderResult>& replicates, const Statistic& statistic);
/// Of the film's mean luminance.
Moments luminance_of(const std::vector<RenderResult>& replicates);

/// p-value of "the replicates' mean lies within `slack` of `expected`", for rounding and stated truncation.
double mean_p_value(const Moments& replicates, double expected, double slack);

/// Smallest p-value over the three channels' film means.
double film_mean_p_value(const std::vector<RenderResult>& replicates, const DVec3& expected, double slack);

/// Smallest Welch p-value over all tiles of tile_side x tile_side pixels, for luminance: do two sets of
/// replicates show the same picture? Compare with sidak_threshold(significance, tiles).
struct TileComparison {
  double smallest_p_value = 1;
  std::size_t tiles = 0;
};
TileComparison compare_tiles(const std::vector<RenderResult>& a, const std::vector<RenderResult>& b,
                             std::uint32_t tile_side);

/// Largest difference of a channel, relative to the larger image's largest channel.
double largest_difference(const ImageView& a, const ImageView& b);

}  // namespace mlt::test
