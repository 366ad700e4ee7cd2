// The program's version; part of every image's metadata, since another version may give other bits.
#pragma once

namespace mlt {

inline constexpr char kVersion[] = "0.1.0";

}  // namespace mlt
