// The picture that errors are measured against, with what is known of its own noise: NAME.pfm, and beside it,
// when it is there, NAME.variance.pfm, the variance of each pixel and channel of NAME.pfm (as in
// ref_images/).
#pragma once

#include <string>

#include "film/image_view.hpp"

namespace mlt {

struct Reference {
  std::string path;
  ImageBuffer image;
  std::string variance_path;  ///< empty when there is none
  /// What the reference's noise adds to every relMSE that is measured against it: the mean over pixels and
  /// channels of variance / (reference^2 + 0.01). 0 without a variance.
  double own_rel_mse = 0;
  double mean = 0;                 ///< over pixels and channels
  double mean_standard_error = 0;  ///< channels of a pixel taken as fully correlated, pixels as independent
};

/// The mean over pixels and channels.
double mean_of_image(const ImageView& image);

/// "folder/name.pfm" to "folder/name.variance.pfm".
std::string variance_path_of(const std::string& path);

/// Throws InputError, naming the file, when one cannot be read, holds a value that is not finite or a
/// negative variance, or when the two differ in size.
Reference read_reference(const std::string& path);

}  // namespace mlt
