// A picture in fewer pixels: every one of the larger counts once, in the mean of the one that it lies in.
#include <catch2/catch.hpp>
#include <vector>

#include "film/image_view.hpp"
#include "math/rng.hpp"

namespace mlt::test {
namespace {

TEST_CASE("a reduced image has the mean of the pixels that lie in each") {
  struct Size {
    std::uint32_t from_width, from_height, width, height;
  };
  for (const Size& size :
       {Size{6, 4, 3, 2}, Size{7, 5, 3, 2}, Size{5, 7, 5, 4}, Size{9, 3, 1, 1}, Size{3, 2, 3, 2}}) {
    CAPTURE(size.from_width, size.from_height, size.width, size.height);
    Rng rng(5, StreamPurpose::kTest, 0);
    std::vector<Vec3> pixels(std::size_t{size.from_width} * size.from_height);
    for (Vec3& pixel : pixels) pixel = Vec3{rng.next_float(), rng.next_float(), rng.next_float()};
    const auto pixel_at = [&pixels](std::size_t i) { return pixels[i]; };
    const ImageBuffer reduced =
        reduced_image(size.from_width, size.from_height, pixel_at, size.width, size.height);
    REQUIRE(reduced.width == size.width);
    REQUIRE(reduced.height == size.height);
    REQUIRE(reduced.pixels.size() == std::size_t{size.width} * size.height);
    for (std::uint32_t y = 0; y < size.height; ++y) {
      for (std::uint32_t x = 0; x < size.width; ++x) {
        // Pixel i of n lies in pixel floor(i m / n) of m.
        double sum = 0, count = 0;
        for (std::uint32_t v = 0; v < size.from_height; ++v) {
          for (std::uint32_t u = 0; u < size.from_width; ++u) {
            if (u * size.width / size.from_width != x || v * size.height / size.from_height != y) continue;
            sum += pixels[std::size_t{v} * size.from_width + u].y;
            count += 1;
          }
        }
        REQUIRE(count > 0);
        // One rounding to float.
        CHECK(reduced.pixels[std::size_t{y} * size.width + x].y == Approx(sum / count).epsilon(6e-8));
      }
    }
  }
}

}  // namespace
}  // namespace mlt::test
