// Constants in float, rounded to nearest from their true values.
#pragma once

namespace mlt {

inline constexpr float kPi = 0x1.921fb6p+1f;
inline constexpr float kTwoPi = 0x1.921fb6p+2f;
inline constexpr float kInversePi = 0x1.45f306p-2f;
inline constexpr float kInverse4Pi = 0x1.45f306p-4f;

}  // namespace mlt
