// The innermost step of painting: sixteen cells of a row, each the difference between its pixel's winding
// number and that of the pixel left of it, become sixteen grey pixels. By vector instructions where the
// processor has them for certain (SSE2 on amd64, NEON on arm64), else in plain C++; all give the same bytes.
// Pure functions, thread-safe.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace contourd {

// The winding number one in the cells' units is 2^kWindingBits.
inline constexpr int kWindingBits = 15;
inline constexpr std::size_t kBlockPixels = 16;

// The grey value of a pixel of this winding number by the non-zero rule: its magnitude, at most one, of 255.
[[nodiscard]] inline std::uint8_t grey_of(std::uint32_t winding) {
  constexpr std::uint32_t one = 1U << kWindingBits;
  const auto sign =
      static_cast<std::uint32_t>(static_cast<std::int32_t>(winding) >> 31);  // all ones when negative
  const std::uint32_t magnitude = (winding ^ sign) - sign;
  return static_cast<std::uint8_t>((std::min(magnitude, one) * 255U + one / 2) >> kWindingBits);
}

// Paints kBlockPixels pixels from as many cells, and makes these 0. `winding` is that of the pixel left of
// the first; gives the last one's.
inline std::uint32_t paint_block_plainly(std::uint32_t* cells, std::uint32_t winding, std::uint8_t* pixels) {
  for (std::size_t i = 0; i < kBlockPixels; ++i) {
    winding += cells[i];
    cells[i] = 0;
    pixels[i] = grey_of(winding);
  }
  return winding;
}

#if defined(__SSE2__)

inline std::uint32_t paint_block(std::uint32_t* cells, std::uint32_t winding, std::uint8_t* pixels) {
  __m128i carry = _mm_set1_epi32(static_cast<std::int32_t>(winding));
  // Four windings: sums within the four cells, on top of all before them.
  const auto take_four = [&carry](std::uint32_t* four) {
    auto* const at = reinterpret_cast<__m128i*>(four);
    __m128i sums = _mm_loadu_si128(at);
    _mm_storeu_si128(at, _mm_setzero_si128());
    sums = _mm_add_epi32(sums, _mm_slli_si128(sums, 4));
    sums = _mm_add_epi32(sums, _mm_slli_si128(sums, 8));
    sums = _mm_add_epi32(sums, carry);
    carry = _mm_shuffle_epi32(sums, 0xFF);
    return sums;
  };
  // Eight greys. Packing holds a winding to 2^15 - 1 or -2^15; either's magnitude rounds to 255. The
  // product's upper half, and its lower half's highest bit to round.
  const auto take_eight = [&take_four](std::uint32_t* eight) {
    const __m128i first = take_four(eight);
    const __m128i windings = _mm_packs_epi32(first, take_four(eight + 4));
    const __m128i magnitudes = _mm_max_epi16(windings, _mm_sub_epi16(_mm_setzero_si128(), windings));
    const __m128i factor = _mm_set1_epi16(2 * 255);
    return _mm_add_epi16(_mm_mulhi_epu16(magnitudes, factor),
                         _mm_srli_epi16(_mm_mullo_epi16(magnitudes, factor), 15));
  };
  const __m128i first = take_eight(cells);
  const __m128i greys = _mm_packus_epi16(first, take_eight(cells + 8));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(pixels), greys);
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(carry));
}

#elif defined(__aarch64__)

inline std::uint32_t paint_block(std::uint32_t* cells, std::uint32_t winding, std::uint8_t* pixels) {
  const uint32x4_t zero = vdupq_n_u32(0);
  uint32x4_t carry = vdupq_n_u32(winding);
  // Four windings' magnitudes, held to 2^15 - 1, which rounds to 255 as 2^15 does.
  const auto take_four = [&carry, zero](std::uint32_t* four) {
    uint32x4_t sums = vld1q_u32(four);
    vst1q_u32(four, zero);
    sums = vaddq_u32(sums, vextq_u32(zero, sums, 3));
    sums = vaddq_u32(sums, vextq_u32(zero, sums, 2));
    sums = vaddq_u32(sums, carry);
    carry = vdupq_laneq_u32(sums, 3);
    return vqmovn_s32(vqabsq_s32(vreinterpretq_s32_u32(sums)));
  };
  // (2 m 255 + 2^15) / 2^16.
  const auto take_eight = [&take_four](std::uint32_t* eight) {
    const int16x4_t first = take_four(eight);
    return vqmovun_s16(vqrdmulhq_n_s16(vcombine_s16(first, take_four(eight + 4)), 255));
  };
  const uint8x8_t first = take_eight(cells);
  vst1q_u8(pixels, vcombine_u8(first, take_eight(cells + 8)));
  return vgetq_lane_u32(carry, 3);
}

#else

inline std::uint32_t paint_block(std::uint32_t* cells, std::uint32_t winding, std::uint8_t* pixels) {
  return paint_block_plainly(cells, winding, pixels);
}

#endif

}  // namespace contourd
