// Elementary functions with the same bits on every machine (provisional bodies, signatures final).
#pragma once

#include <cmath>

namespace mlt {

inline void sincos_2pi(float u, float& s, float& c) {
  s = static_cast<float>(std::sin(6.283185307179586 * u));
  c = static_cast<float>(std::cos(6.283185307179586 * u));
}
inline float exp_f(float x) {
  return static_cast<float>(std::exp(static_cast<double>(x)));
}
inline float exp2_f(float x) {
  return static_cast<float>(std::exp2(static_cast<double>(x)));
}
inline float log_f(float x) {
  return static_cast<float>(std::log(static_cast<double>(x)));
}
inline float log2_f(float x) {
  return static_cast<float>(std::log2(static_cast<double>(x)));
}
inline float pow_f(float x, float y) {
  return static_cast<float>(std::pow(static_cast<double>(x), static_cast<double>(y)));
}
inline float acos_f(float x) {
  return static_cast<float>(std::acos(static_cast<double>(x)));
}
inline float atan2_f(float y, float x) {
  return static_cast<float>(std::atan2(static_cast<double>(y), static_cast<double>(x)));
}

struct DSinCos {
  double sin = 0;
  double cos = 1;
};
inline DSinCos sincos_degrees(double degrees) {
  return {std::sin(degrees * 0.017453292519943295), std::cos(degrees * 0.017453292519943295)};
}
inline double tan_degrees(double degrees) {
  return std::tan(degrees * 0.017453292519943295);
}

}  // namespace mlt
