#include "material/parameters.hpp"

#include <fmt/core.h>

#include "base/error.hpp"

namespace mlt {

void require_in_range(const MaterialDescription& material, const char* parameter, double value, double low,
                      double high) {
  if (value >= low && value <= high) return;
  const SourceLocation& place = material.location;
  throw InputError(Diagnostic{place.file, place.line, place.column,
                              fmt::format("material '{}': {} is {}, allowed is {} to {}", material.name,
                                          parameter, value, low, high)});
}

void require_in_range(const MaterialDescription& material, const char* parameter, const DVec3& value,
                      double low, double high) {
  require_in_range(material, parameter, value.x, low, high);
  require_in_range(material, parameter, value.y, low, high);
  require_in_range(material, parameter, value.z, low, high);
}

}  // namespace mlt
