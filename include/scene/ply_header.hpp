// The header of a PLY file: which elements with which properties follow, and how they are encoded.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scene/text_scanner.hpp"

namespace mlt {

/// type, its two names in headers.
#define MLT_PLY_TYPES(X)               \
  X(std::int8_t, "char", "int8")       \
  X(std::uint8_t, "uchar", "uint8")    \
  X(std::int16_t, "short", "int16")    \
  X(std::uint16_t, "ushort", "uint16") \
  X(std::int32_t, "int", "int32")      \
  X(std::uint32_t, "uint", "uint32")   \
  X(float, "float", "float32")         \
  X(double, "double", "float64")

enum class PlyType : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

inline constexpr std::uint8_t kPlyTypeBytes[] = {1, 1, 2, 2, 4, 4, 4, 8};
inline std::size_t bytes_of(PlyType type) {
  return kPlyTypeBytes[static_cast<std::size_t>(type)];
}
inline bool is_integer(PlyType type) {
  return type < PlyType::kFloat;
}

struct PlyProperty {
  std::string_view name;
  PlyType type = PlyType::kFloat;        ///< of the value, or of a list's items
  PlyType count_type = PlyType::kUint8;  ///< of a list's length, an integer type
  bool is_list = false;
};

struct PlyElement {
  std::string_view name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  SourceLocation location;

  /// Fewest bytes that one record takes in the file.
  std::uint64_t least_record_bytes(bool ascii) const;
};

struct PlyHeader {
  bool ascii = false;
  std::vector<PlyElement> elements;
};

/// Reads from "ply" to behind the line "end_header". Throws InputError; in particular when an element is
/// declared to have more records than the rest of the file can hold.
PlyHeader read_ply_header(TextScanner& scanner);

}  // namespace mlt
