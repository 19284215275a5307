#include "core/mask/picture_stack.hpp"

#include <algorithm>
#include <cstring>
#include <span>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr unsigned kBits = 7;
constexpr std::uint8_t kMore = 1U << kBits;

void append_run(std::uint8_t grey, std::size_t length, std::vector<std::uint8_t>& runs) {
  runs.push_back(grey);
  for (; length >= kMore; length >>= kBits)
    runs.push_back(static_cast<std::uint8_t>(length | kMore));
  runs.push_back(static_cast<std::uint8_t>(length));
}

// Returns the end of the run of equal pixels that begins at `from`.
std::size_t end_of_run(std::span<const std::uint8_t> pixels, std::size_t from) {
  std::size_t end = from + 1;
  std::uint64_t equal = 0, next = 0;
  std::memset(&equal, pixels[from], sizeof equal);
  for (; end + sizeof next <= pixels.size(); end += sizeof next) {
    std::memcpy(&next, pixels.data() + end, sizeof next);
    if (next != equal) break;
  }
  while (end < pixels.size() && pixels[end] == pixels[from])
    ++end;
  return end;
}

// Returns the first and the end of the pixels that are not dark; equal if all are.
struct LitPart {
  std::int32_t first, end;
};
LitPart lit_part(std::span<const std::uint8_t> row) {
  const std::size_t first = row[0] == 0 ? end_of_run(row, 0) : 0;
  std::size_t end = row.size();
  while (end > first && row[end - 1] == 0)
    --end;
  return {static_cast<std::int32_t>(first), static_cast<std::int32_t>(end)};
}

}  // namespace

PictureStack::PictureStack(Pixels width, Pixels height, Nanometers thickness)
    : width_(width), height_(height), thickness_(thickness) {
  constexpr std::int32_t kLargestSide = 16384;
  for (const Pixels side : {width, height})
    expects(1 <= side.count() && side.count() <= kLargestSide, "a picture has a mask's size");
  expects(thickness > Nanometers{}, "a layer has a thickness");
}

void PictureStack::add(const Mask& picture) {
  expects(picture.width() == width_ && picture.height() == height_, "pictures of a stack have one size");
  const std::span<const std::uint8_t> pixels = picture.pixels();
  const std::size_t begin = runs_.size();
  for (std::size_t from = 0; from < pixels.size();) {
    const std::size_t end = end_of_run(pixels, from);
    append_run(pixels[from], end - from, runs_);
    from = end;
  }
  const auto added = std::span(runs_).subspan(begin);
  if (!pictures_.empty() &&
      std::ranges::equal(added, std::span(runs_).subspan(pictures_.back().begin,
                                                         pictures_.back().end - pictures_.back().begin))) {
    runs_.resize(begin);
    pictures_.push_back(pictures_.back());
    return;
  }
  pictures_.push_back({begin, runs_.size()});
  widen(picture);
}

void PictureStack::widen(const Mask& picture) {
  for (std::int32_t y = 0; y < height_.count(); ++y) {
    const auto [first, end] = lit_part(picture.row(y));
    if (first == end) continue;
    if (!lit_) lit_ = PixelBox{first, y, end, y + 1};
    lit_ = PixelBox{std::min(lit_->left, first), std::min(lit_->top, y), std::max(lit_->right, end),
                    std::max(lit_->bottom, y + 1)};
  }
}

void PictureStack::draw(Nanometers height, Mask& mask) const {
  expects(mask.width() == width_ && mask.height() == height_, "the mask has the pictures' size");
  const std::int64_t layer = height < Nanometers{} ? -1 : height.count() / thickness_.count();
  std::uint8_t* to = mask.row(0).data();
  if (layer < 0 || layer >= static_cast<std::int64_t>(pictures_.size())) {
    std::memset(to, 0, mask.pixels().size());
    return;
  }
  const auto [begin, end] = pictures_[static_cast<std::size_t>(layer)];
  for (std::size_t at = begin; at < end;) {
    const std::uint8_t grey = runs_[at++];
    std::size_t length = 0;
    for (unsigned bits = 0;; bits += kBits) {
      const std::uint8_t byte = runs_[at++];
      length |= static_cast<std::size_t>(byte & (kMore - 1U)) << bits;
      if (byte < kMore) break;
    }
    std::memset(to, grey, length);
    to += length;
  }
}

}  // namespace contourd
