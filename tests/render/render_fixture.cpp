#include "render_fixture.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace mlt::test {

const char* name_of(IntegratorKind kind) {
  switch (kind) {
#define MLT_CASE(name, help) \
  case IntegratorKind::name: \
    return #name;
    MLT_INTEGRATOR_KINDS(MLT_CASE)
#undef MLT_CASE
    case IntegratorKind::automatic:
      return "auto";
  }
  return "unknown";
}

std::uint64_t scaled_effort(std::uint64_t samples) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__OPTIMIZE__)
  return std::max<std::uint64_t>(1, samples / 8);
#else
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
  return std::max<std::uint64_t>(1, samples / 8);
#endif
#endif
  return samples;
#endif
}

RenderResult render(const SceneDescription& scene, RenderRequest request) {
  if (!request.threads) request.threads = 1;
  Renderer renderer(scene, resolve_job(request, scene));
  renderer.prepare();
  const std::atomic<bool> stop{false};
  RenderResult result;
  result.statistics = renderer.run(stop, nullptr, nullptr);
  const ImageView view = renderer.image();
  result.image = ImageBuffer{view.width, view.height, {view.pixels.begin(), view.pixels.end()}};
  return result;
}

RenderResult render(std::string_view scene_text, const RenderRequest& request) {
  return render(parse_scene_text(scene_text, "test"), request);
}

RenderRequest small_request(IntegratorKind kind, std::uint32_t side, std::uint64_t samples_per_pixel,
                            std::uint32_t depth) {
  RenderRequest request;
  request.integrator = kind;
  request.width = side;
  request.height = side;
  request.samples_per_pixel = samples_per_pixel;
  request.depth = depth;
  const std::uint64_t mutations = std::uint64_t{side} * side * samples_per_pixel;
  request.chains = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(mutations / 256, 1, 256));
  request.bootstrap = std::max<std::uint64_t>(1024, mutations / 2);
  return request;
}

std::vector<RenderResult> render_replicates(const SceneDescription& scene, RenderRequest request,
                                            std::uint32_t replicates, std::uint64_t first_seed) {
  std::vector<RenderResult> results;
  for (std::uint32_t i = 0; i < replicates; ++i) {
    request.seed = first_seed + i;
    results.push_back(render(scene, request));
  }
  return results;
}

double mean_of(const ImageView& image, int channel, std::uint32_t x0, std::uint32_t y0, std::uint32_t x1,
               std::uint32_t y1) {
  double sum = 0;
  for (std::uint32_t y = y0; y < y1; ++y) {
    for (std::uint32_t x = x0; x < x1; ++x) {
      sum += static_cast<double>(image.pixels[std::size_t{y} * image.width + x][channel]);
    }
  }
  return sum / (static_cast<double>(x1 - x0) * static_cast<double>(y1 - y0));
}

double mean_of(const ImageView& image, int channel) {
  return mean_of(image, channel, 0, 0, image.width, image.height);
}

double mean_luminance(const ImageView& image) {
  return mean_luminance(image, 0, 0, image.width, image.height);
}

double mean_luminance(const ImageView& image, std::uint32_t x0, std::uint32_t y0, std::uint32_t x1,
                      std::uint32_t y1) {
  x1 = std::min(x1, image.width);
  y1 = std::min(y1, image.height);
  return 0.2126 * mean_of(image, 0, x0, y0, x1, y1) + 0.7152 * mean_of(image, 1, x0, y0, x1, y1) +
         0.0722 * mean_of(image, 2, x0, y0, x1, y1);
}

std::vector<double> statistics_of(const std::vector<RenderResult>& replicates, const Statistic& statistic) {
  std::vector<double> values;
  for (const RenderResult& replicate : replicates) values.push_back(statistic(replicate.image.view()));
  return values;
}

Moments moments_of(const std::vector<RenderResult>& replicates, const Statistic& statistic) {
  return moments(statistics_of(replicates, statistic));
}

Moments luminance_of(const std::vector<RenderResult>& replicates) {
  return moments_of(replicates, [](const ImageView& image) { return mean_luminance(image); });
}

double mean_p_value(const Moments& replicates, double expected, double slack) {
  const double deviation = replicates.mean - expected;
  const double excess = std::fabs(deviation) <= slack ? 0.0 : deviation - std::copysign(slack, deviation);
  return student_t_test(replicates, replicates.mean - excess).p_value;
}

double film_mean_p_value(const std::vector<RenderResult>& replicates, const DVec3& expected, double slack) {
  double smallest = 1;
  for (int channel = 0; channel < 3; ++channel) {
    const Moments measured =
        moments_of(replicates, [channel](const ImageView& image) { return mean_of(image, channel); });
    smallest = std::min(smallest, mean_p_value(measured, expected[channel], slack));
  }
  return smallest;
}

TileComparison compare_tiles(const std::vector<RenderResult>& a, const std::vector<RenderResult>& b,
                             std::uint32_t tile_side) {
  TileComparison result;
  const ImageBuffer& first = a.front().image;
  for (std::uint32_t y = 0; y < first.height; y += tile_side) {
    for (std::uint32_t x = 0; x < first.width; x += tile_side) {
      const auto tile = [&](const ImageView& image) {
        return mean_luminance(image, x, y, x + tile_side, y + tile_side);
      };
      const double p = welch_t_test(moments_of(a, tile), moments_of(b, tile)).p_value;
      result.smallest_p_value = std::min(result.smallest_p_value, p);
      result.tiles += 1;
    }
  }
  return result;
}

double largest_difference(const ImageView& a, const ImageView& b) {
  double difference = 0;
  double largest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      const double left = static_cast<double>(a.pixels[i][channel]);
      const double right = static_cast<double>(b.pixels[i][channel]);
      difference = std::max(difference, std::fabs(left - right));
      largest = std::max({largest, std::fabs(left), std::fabs(right)});
    }
  }
  return largest > 0 ? difference / largest : difference;
}

double difference_share(const RenderResult& a, const RenderResult& b) {
  double difference = 0, sum = 0;
  for (std::size_t i = 0; i < a.image.pixels.size(); ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      const double left = static_cast<double>(a.image.pixels[i][channel]);
      difference += std::fabs(left - static_cast<double>(b.image.pixels[i][channel]));
      sum += left;
    }
  }
  return difference / sum;
}

}  // namespace mlt::test
