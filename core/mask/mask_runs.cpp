#include "core/mask/mask_runs.hpp"

#include <bit>
#include <cstring>

namespace contourd {
namespace {

// Eight pixels are handled at a time, as one word.
constexpr std::size_t kWord = sizeof(std::uint64_t);
constexpr std::uint64_t kAllLit = ~std::uint64_t{0};
constexpr std::uint64_t kLowBits = 0x7F7F7F7F7F7F7F7F;

std::uint64_t word_at(const std::uint8_t* pixels) {
  std::uint64_t word;
  std::memcpy(&word, pixels, kWord);
  return word;
}

// Returns how many pixels at the left are 0 in a word of flags.
std::size_t leading_clear(std::uint64_t word) {
  const int bits =
      std::endian::native == std::endian::little ? std::countr_zero(word) : std::countl_zero(word);
  return static_cast<std::size_t>(bits) / 8;
}

// Returns a flag in every pixel that is dark, and in no other.
std::uint64_t dark_pixels(std::uint64_t word) {
  return ~(((word & kLowBits) + kLowBits) | word | kLowBits);
}

std::uint32_t sum_of(std::uint64_t word) {
  constexpr std::uint64_t kEven = 0x00FF00FF00FF00FF;
  const std::uint64_t pairs = (word & kEven) + ((word >> 8) & kEven);
  return static_cast<std::uint32_t>((pairs * 0x0001000100010001) >> 48);
}

// Returns the first lit pixel at or after `at`, or `width`.
std::size_t skip_dark(const std::uint8_t* pixels, std::size_t at, std::size_t width) {
  constexpr std::size_t kBlock = 8 * kWord;
  for (; at + kBlock <= width; at += kBlock) {
    // Words are combined in pairs, so that no word waits for all earlier ones.
    const auto pair_at = [from = pixels + at](std::size_t words) {
      return word_at(from + words * kWord) | word_at(from + (words + 1) * kWord);
    };
    if (((pair_at(0) | pair_at(2)) | (pair_at(4) | pair_at(6))) != 0) break;
  }
  for (; at + kWord <= width; at += kWord) {
    const std::uint64_t word = word_at(pixels + at);
    if (word != 0) return at + leading_clear(word);
  }
  while (at < width && pixels[at] == 0)
    ++at;
  return at;
}

// Returns the first dark pixel at or after `at`, or `width`; adds the grey values before it to `grey`.
std::size_t skip_lit(const std::uint8_t* pixels, std::size_t at, std::size_t width, std::uint32_t& grey) {
  for (; at + kWord <= width; at += kWord) {
    const std::uint64_t word = word_at(pixels + at);
    if (word == kAllLit) {
      grey += 255 * kWord;
      continue;
    }
    const std::uint64_t dark = dark_pixels(word);
    if (dark != 0) {
      const std::size_t end = at + leading_clear(dark);
      while (at < end)
        grey += pixels[at++];
      return end;
    }
    grey += sum_of(word);
  }
  while (at < width && pixels[at] != 0)
    grey += pixels[at++];
  return at;
}

}  // namespace

void MaskRuns::extract(const Mask& mask) {
  runs_.clear();
  row_starts_.clear();
  grey_sum_ = 0;
  for (std::int32_t row = 0; row < mask.height().count(); ++row) {
    row_starts_.push_back(static_cast<std::uint32_t>(runs_.size()));
    extract_row(row, mask.row(row));
  }
  row_starts_.push_back(static_cast<std::uint32_t>(runs_.size()));
}

void MaskRuns::extract_bright(const Mask& mask, const MaskRuns& lit, std::uint8_t least_grey) {
  expects(lit.rows() == mask.height().count(), "the lit pixels are those of the same mask");
  runs_.clear();
  row_starts_.clear();
  grey_sum_ = 0;
  for (std::int32_t row = 0; row < lit.rows(); ++row) {
    row_starts_.push_back(static_cast<std::uint32_t>(runs_.size()));
    for (const PixelRun& run : lit.in_row(row))
      extract_bright_from(run, mask.row(row), least_grey);
  }
  row_starts_.push_back(static_cast<std::uint32_t>(runs_.size()));
}

void MaskRuns::extract_bright_from(const PixelRun& run, std::span<const std::uint8_t> pixels,
                                   std::uint8_t least_grey) {
  const auto is_bright = [pixels, least_grey](std::int32_t at) {
    return pixels[static_cast<std::size_t>(at)] >= least_grey;
  };
  for (std::int32_t at = run.first; at < run.end;) {
    if (!is_bright(at)) {
      ++at;
      continue;
    }
    PixelRun bright{run.row, at, at, 0};
    for (; bright.end < run.end && is_bright(bright.end); ++bright.end)
      bright.grey += pixels[static_cast<std::size_t>(bright.end)];
    grey_sum_ += bright.grey;
    runs_.push_back(bright);
    at = bright.end;
  }
}

void MaskRuns::extract_row(std::int32_t row, std::span<const std::uint8_t> pixels) {
  const std::size_t width = pixels.size();
  for (std::size_t at = 0; (at = skip_dark(pixels.data(), at, width)) < width;) {
    std::uint32_t grey = 0;
    const std::size_t end = skip_lit(pixels.data(), at, width, grey);
    runs_.push_back({row, static_cast<std::int32_t>(at), static_cast<std::int32_t>(end), grey});
    grey_sum_ += grey;
    at = end;
  }
}

}  // namespace contourd
