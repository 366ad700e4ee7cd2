#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/console.hpp"
#include "compare/compare.hpp"
#include "image/image_io.hpp"

namespace mlt {

ExitCode run_compare(const CompareCommand& command) {
  const PfmImage image = read_pfm(command.image);
  const PfmImage reference = read_pfm(command.reference);
  require_comparable(command.image, image.image.view(), command.reference, reference.image.view());
  const ImageComparison result = compare_images(image.image.view(), reference.image.view());
  print_output(fmt::format("MSE        {:.9g}\nrelMSE     {:.9g}\nmean ratio {:.9g}\n", result.mse,
                           result.rel_mse, result.mean_ratio));
  // Negated, so that a NaN fails.
  if (command.max_rel_mse && !(result.rel_mse <= *command.max_rel_mse)) {
    print_message(fmt::format("mlt: {}: relMSE {:.9g} against {} exceeds --max-relmse {}\n", command.image,
                              result.rel_mse, command.reference, *command.max_rel_mse));
    return ExitCode::kCompareFailed;
  }
  return ExitCode::kOk;
}

}  // namespace mlt
