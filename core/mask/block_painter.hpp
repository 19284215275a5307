// The innermost step of painting: turns sixteen cells of a row into sixteen grey pixels. A cell is the
// difference between its pixel's winding number and that of the pixel to the left. Uses vector instructions
// where the processor is certain to have them (SSE2 on amd64, NEON on arm64), otherwise plain C++; all give
// the same bytes. Pure functions, thread-safe.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace contourd {

static_assert(std::endian::native == std::endian::little, "bits_of() reads eight bytes as one word");

// A winding number of 1 is 2^kWindingBits in the cells' units.
inline constexpr int kWindingBits = 15;
inline constexpr std::size_t kBlockPixels = 16;

// Returns the grey value of a pixel with this winding number by the non-zero rule: the number's magnitude, at
// most 1, times 255.
[[nodiscard]] inline std::uint8_t grey_of(std::uint32_t winding) {
  constexpr std::uint32_t kOne = 1U << kWindingBits;
  const auto sign =
      static_cast<std::uint32_t>(static_cast<std::int32_t>(winding) >> 31);  // all ones if negative
  const std::uint32_t magnitude = (winding ^ sign) - sign;
  return static_cast<std::uint8_t>((std::min(magnitude, kOne) * 255U + kOne / 2) >> kWindingBits);
}

// Returns a bit for each of 64 bytes that are 0 or 1.
[[nodiscard]] inline std::uint64_t bits_of_scalar(const std::uint8_t* bytes) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < 64; i += 8) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, bytes + i, sizeof eight);
    // Byte k's bit ends up in bit 56 + k of the product, without any carry.
    bits |= (eight * 0x0102040810204080U >> 56) << i;
  }
  return bits;
}

// Paints kBlockPixels pixels from as many cells, and sets these cells to 0. `winding` is the winding number
// of the pixel left of the first. Returns the last pixel's winding number.
inline std::uint32_t paint_block_scalar(std::uint32_t* cells, std::uint32_t winding, std::uint8_t* pixels) {
  for (std::size_t i = 0; i < kBlockPixels; ++i) {
    winding += cells[i];
    cells[i] = 0;
    pixels[i] = grey_of(winding);
  }
  return winding;
}

// A winding number of 0, less a half: where winding numbers are 0 to 1 only, half of 1 is subtracted from the
// winding number that is carried from block to block, so that 16 bits hold it.
inline constexpr std::uint32_t kNoWinding = 0U - (1U << (kWindingBits - 1));
inline constexpr std::int32_t kHalfWinding = 1 << (kWindingBits - 1);
// Limit on the sum of the rounding errors of a pixel's sides: half a grey value.
inline constexpr std::int32_t kWindingSlack = 64;

// The range of winding numbers painted, less a half.
struct ScalarWindingRange {
  std::int32_t lowest = 0, highest = 0;
  [[nodiscard]] bool is_zero_to_one() const {
    return lowest >= -kHalfWinding - kWindingSlack && highest <= kHalfWinding + kWindingSlack;
  }
};

// Paints like paint_block_scalar(), for contours that do not overlap, whose winding numbers are 0 to 1 only.
// Lower ones count as 0 and higher ones as 1; `range` records that there were any.
inline std::uint32_t paint_covered_block_scalar(std::uint32_t* cells, std::uint32_t winding,
                                                std::uint8_t* pixels, ScalarWindingRange& range) {
  for (std::size_t i = 0; i < kBlockPixels; ++i) {
    winding += cells[i];
    cells[i] = 0;
    const auto off_middle = static_cast<std::int32_t>(winding);
    range.lowest = std::min(range.lowest, off_middle);
    range.highest = std::max(range.highest, off_middle);
    pixels[i] = grey_of(
        static_cast<std::uint32_t>(std::clamp(off_middle, -kHalfWinding, kHalfWinding) + kHalfWinding));
  }
  return winding;
}

#if defined(__SSE2__)

[[nodiscard]] inline std::uint64_t bits_of(const std::uint8_t* bytes) {
  const auto sixteen_from = [bytes](std::size_t first) {
    const __m128i values = _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes + first));
    return static_cast<std::uint64_t>(_mm_movemask_epi8(_mm_slli_epi16(values, 7))) << first;
  };
  return sixteen_from(0) | sixteen_from(16) | sixteen_from(32) | sixteen_from(48);
}

inline std::uint32_t paint_block(std::uint32_t* cells, std::uint32_t winding, std::uint8_t* pixels) {
  __m128i carry = _mm_set1_epi32(static_cast<std::int32_t>(winding));
  // Returns four windings: the sums within the four cells, plus everything to their left.
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
  // Returns eight grey values. Packing limits a winding to 2^15 - 1 or -2^15; the magnitude of either rounds
  // to 255. The result is the product's upper half, rounded by the highest bit of its lower half.
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

struct WindingRange {
  __m128i lowest = _mm_setzero_si128(), highest = _mm_setzero_si128();
  [[nodiscard]] bool is_zero_to_one() const {
    const __m128i below = _mm_cmplt_epi16(lowest, _mm_set1_epi16(-kHalfWinding - kWindingSlack));
    const __m128i above = _mm_cmpgt_epi16(highest, _mm_set1_epi16(kHalfWinding + kWindingSlack));
    return _mm_movemask_epi8(_mm_or_si128(below, above)) == 0;
  }
};

inline std::uint32_t paint_covered_block(std::uint32_t* cells, std::uint32_t winding, std::uint8_t* pixels,
                                         WindingRange& range) {
  __m128i carry = _mm_set1_epi32(static_cast<std::int32_t>(winding));
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
  // Saturation limits a winding to 2^15 - 1, which rounds to 255 as 2^15 does.
  const auto take_eight = [&take_four, &range](std::uint32_t* eight) {
    const __m128i first = take_four(eight);
    const __m128i off_middle = _mm_packs_epi32(first, take_four(eight + 4));
    range.lowest = _mm_min_epi16(range.lowest, off_middle);
    range.highest = _mm_max_epi16(range.highest, off_middle);
    const __m128i windings =
        _mm_max_epi16(_mm_adds_epi16(off_middle, _mm_set1_epi16(kHalfWinding)), _mm_setzero_si128());
    const __m128i factor = _mm_set1_epi16(2 * 255);
    return _mm_add_epi16(_mm_mulhi_epu16(windings, factor),
                         _mm_srli_epi16(_mm_mullo_epi16(windings, factor), 15));
  };
  const __m128i first = take_eight(cells);
  const __m128i greys = _mm_packus_epi16(first, take_eight(cells + 8));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(pixels), greys);
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(carry));
}

#elif defined(__aarch64__)

[[nodiscard]] inline std::uint64_t bits_of(const std::uint8_t* bytes) {
  return bits_of_scalar(bytes);
}

inline std::uint32_t paint_block(std::uint32_t* cells, std::uint32_t winding, std::uint8_t* pixels) {
  const uint32x4_t zero = vdupq_n_u32(0);
  uint32x4_t carry = vdupq_n_u32(winding);
  // Returns the magnitudes of four windings, limited to 2^15 - 1, which rounds to 255 as 2^15 does.
  const auto take_four = [&carry, zero](std::uint32_t* four) {
    uint32x4_t sums = vld1q_u32(four);
    vst1q_u32(four, zero);
    sums = vaddq_u32(sums, vextq_u32(zero, sums, 3));
    sums = vaddq_u32(sums, vextq_u32(zero, sums, 2));
    sums = vaddq_u32(sums, carry);
    carry = vdupq_laneq_u32(sums, 3);
    return vqmovn_s32(vqabsq_s32(vreinterpretq_s32_u32(sums)));
  };
  // Returns eight grey values: (2 m 255 + 2^15) / 2^16.
  const auto take_eight = [&take_four](std::uint32_t* eight) {
    const int16x4_t first = take_four(eight);
    return vqmovun_s16(vqrdmulhq_n_s16(vcombine_s16(first, take_four(eight + 4)), 255));
  };
  const uint8x8_t first = take_eight(cells);
  vst1q_u8(pixels, vcombine_u8(first, take_eight(cells + 8)));
  return vgetq_lane_u32(carry, 3);
}

struct WindingRange {
  int16x8_t lowest = vdupq_n_s16(0), highest = vdupq_n_s16(0);
  [[nodiscard]] bool is_zero_to_one() const {
    return vminvq_s16(lowest) >= -kHalfWinding - kWindingSlack &&
           vmaxvq_s16(highest) <= kHalfWinding + kWindingSlack;
  }
};

inline std::uint32_t paint_covered_block(std::uint32_t* cells, std::uint32_t winding, std::uint8_t* pixels,
                                         WindingRange& range) {
  const uint32x4_t zero = vdupq_n_u32(0);
  uint32x4_t carry = vdupq_n_u32(winding);
  const auto take_four = [&carry, zero](std::uint32_t* four) {
    uint32x4_t sums = vld1q_u32(four);
    vst1q_u32(four, zero);
    sums = vaddq_u32(sums, vextq_u32(zero, sums, 3));
    sums = vaddq_u32(sums, vextq_u32(zero, sums, 2));
    sums = vaddq_u32(sums, carry);
    carry = vdupq_laneq_u32(sums, 3);
    return vqmovn_s32(vreinterpretq_s32_u32(sums));
  };
  // Saturation limits a winding to 2^15 - 1, which rounds to 255 as 2^15 does.
  const auto take_eight = [&take_four, &range](std::uint32_t* eight) {
    const int16x4_t first = take_four(eight);
    const int16x8_t off_middle = vcombine_s16(first, take_four(eight + 4));
    range.lowest = vminq_s16(range.lowest, off_middle);
    range.highest = vmaxq_s16(range.highest, off_middle);
    const int16x8_t windings = vmaxq_s16(vqaddq_s16(off_middle, vdupq_n_s16(kHalfWinding)), vdupq_n_s16(0));
    return vqmovun_s16(vqrdmulhq_n_s16(windings, 255));
  };
  const uint8x8_t first = take_eight(cells);
  vst1q_u8(pixels, vcombine_u8(first, take_eight(cells + 8)));
  return vgetq_lane_u32(carry, 3);
}

#else

using WindingRange = ScalarWindingRange;

[[nodiscard]] inline std::uint64_t bits_of(const std::uint8_t* bytes) {
  return bits_of_scalar(bytes);
}

inline std::uint32_t paint_covered_block(std::uint32_t* cells, std::uint32_t winding, std::uint8_t* pixels,
                                         WindingRange& range) {
  return paint_covered_block_scalar(cells, winding, pixels, range);
}

inline std::uint32_t paint_block(std::uint32_t* cells, std::uint32_t winding, std::uint8_t* pixels) {
  return paint_block_scalar(cells, winding, pixels);
}

#endif

}  // namespace contourd
