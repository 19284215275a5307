// Two numbers, such as x and y of a point, that slicer.cpp calculates at once: by one vector instruction if
// the processor has them (SSE2, NEON), otherwise one after the other. Each result has the same bits as the
// plain operation on the one number. Values; thread-safe.
#pragma once

#include <bit>
#include <cstddef>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "core/geometry/facet.hpp"

namespace contourd {

using DoublePair [[gnu::vector_size(2 * sizeof(double))]] = double;

[[nodiscard]] inline DoublePair pair_of(float first, float second) {
  return DoublePair{first, second};
}
[[nodiscard]] inline DoublePair xy_of(const Vertex& vertex) {
#if defined(__SSE2__)
  static_assert(offsetof(Vertex, x) == 0 && offsetof(Vertex, y) == sizeof(float));
  return _mm_cvtps_pd(_mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i_u*>(&vertex))));
#else
  return DoublePair{vertex.x, vertex.y};
#endif
}
[[nodiscard]] inline DoublePair pair_of(const Point& point) {
  return std::bit_cast<DoublePair>(point);
}
[[nodiscard]] inline Point point_of(DoublePair pair) {
  return std::bit_cast<Point>(pair);
}

}  // namespace contourd
