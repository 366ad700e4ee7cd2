#include "scene/statements.hpp"

#include "base/error.hpp"

namespace mlt {

std::vector<std::string> material_kind_names() {
#define MLT_ENUMERATE(name) #name,
  return {MLT_MATERIAL_KINDS(MLT_ENUMERATE)};
#undef MLT_ENUMERATE
}

std::string allowed_words(std::string_view word, const std::vector<std::string>& allowed) {
  const std::string near = suggest(std::string(word), allowed);
  if (!near.empty()) return near;
  if (allowed.empty()) return "; there is none so far";
  constexpr std::size_t kListed = 24;
  std::string text = "; allowed: ";
  for (std::size_t i = 0; i < allowed.size() && i < kListed; ++i) {
    text += (i == 0 ? "" : ", ") + allowed[i];
  }
  return allowed.size() > kListed ? text + ", ..." : text;
}

}  // namespace mlt
