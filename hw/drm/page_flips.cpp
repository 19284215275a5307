#include "hw/drm/page_flips.hpp"

#include <algorithm>
#include <utility>

namespace contourd {

using namespace std::chrono_literals;

Duration flip_deadline(Duration frame) {
  return std::max<Duration>(10 * frame, 250ms);
}

PageFlips::PageFlips(std::uint32_t black, std::vector<std::uint32_t> masks) : pictures_(std::move(masks)) {
  pictures_.insert(pictures_.begin(), black);
}

// With three masks, a mask that has left the screen is not free until the next one has left it too.
bool PageFlips::is_free(std::size_t picture) const noexcept {
  const bool resting = pictures_.size() > 3 && picture == before_;
  return picture != on_screen_ && picture != next_ && !resting && (!flip_ || picture != flip_->picture);
}

std::size_t PageFlips::mask_to_write() noexcept {
  // Prefers the mask that was written last if it is free: it is likely to resemble the next one.
  for (std::size_t mask = 1; !is_free(written_) && mask < pictures_.size(); ++mask)
    if (is_free(mask)) written_ = mask;
  return written_ - 1;
}

int PageFlips::show(Crtc& crtc, std::size_t picture, TimePoint now) noexcept {
  if (flip_) {
    next_ = picture;
    return 0;
  }
  const int error = crtc.flip(pictures_[picture], serial_ + 1);
  if (error == 0) flip_ = Flip{picture, ++serial_, now};
  return error;
}

PageFlips::Blackout PageFlips::black_now(Crtc& crtc, TimePoint now) noexcept {
  next_.reset();
  const std::size_t coming = flip_ ? flip_->picture : on_screen_;
  if (coming == kBlack) return {};
  Blackout blackout{.error = show(crtc, kBlack, now), .mask_under_way = {}};
  if (next_) blackout.mask_under_way = coming - 1;
  return blackout;
}

std::optional<PageFlips::Done> PageFlips::finish(Crtc& crtc, std::uint64_t serial, TimePoint now) noexcept {
  if (!flip_ || flip_->serial != serial) return std::nullopt;
  const std::optional<std::size_t> next = next_;
  now_on_screen(flip_->picture);
  if (!next) return Done{.all = true};
  return Done{.error = show(crtc, *next, now)};
}

void PageFlips::now_on_screen(std::size_t picture) noexcept {
  flip_.reset();
  next_.reset();
  before_ = std::exchange(on_screen_, picture);
}

std::optional<TimePoint> PageFlips::waiting_since() const noexcept {
  if (!flip_) return std::nullopt;
  return flip_->since;
}

}  // namespace contourd
