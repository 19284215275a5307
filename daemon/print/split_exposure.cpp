#include "daemon/print/split_exposure.hpp"

#include <algorithm>
#include <chrono>

#include "core/contract/expects.hpp"

namespace contourd {

SplitExposure::SplitExposure(const PanelTone& panel, Pixels width, Pixels height)
    : panel_(panel), split_(panel), pictures_{Mask(width, height), Mask(width, height)} {}

const Mask& SplitExposure::begin(const Mask& light, const Times& times) {
  expects(light.width() == pictures_[0].width() && light.height() == pictures_[0].height(),
          "the mask has the display's size");
  expects(times.asked > Duration{0}, "the exposure has a time");
  times_ = times;
  light_ = &light;
  split_.plan(light, shortest_share(times.asked, times.frame));
  const std::size_t first = picture_at(times.past);
  split_.draw(first, light, {0, height()}, pictures_[on_screen_]);
  follow(first, times.past);
  while (draw_some()) {
  }
  return pictures_[on_screen_];
}

Duration SplitExposure::due(std::size_t picture) const {
  return std::chrono::round<Duration>(split_.begin(picture) * std::chrono::duration<double>(times_.asked));
}

// Returns the last picture that is due by then, or at the refresh that is nearest to then.
std::size_t SplitExposure::picture_at(Duration lit) const {
  std::size_t picture = 0;
  while (picture + 1 < split_.pictures() && due(picture + 1) <= lit + times_.frame / 2)
    ++picture;
  return picture;
}

// Makes the picture after this one the next one.
void SplitExposure::follow(std::size_t picture, Duration lit) {
  next_.reset();
  drawn_rows_ = 0;
  if (picture + 1 < split_.pictures()) next_ = std::max(picture + 1, picture_at(lit));
}

bool SplitExposure::draw_some() {
  constexpr std::int32_t kPixels = 1 << 20;
  if (!next_ || is_drawn()) return false;
  const std::int32_t rows = std::max(1, kPixels / light_->width().count());
  const std::int32_t end = std::min(drawn_rows_ + rows, height());
  split_.draw(*next_, *light_, {drawn_rows_, end}, pictures_[1 - on_screen_]);
  drawn_rows_ = end;
  return !is_drawn();
}

std::optional<Duration> SplitExposure::next_due() const {
  if (!next_) return std::nullopt;
  return due(*next_);
}

const Mask& SplitExposure::next() const {
  expects(is_drawn(), "the next picture is drawn");
  return pictures_[1 - on_screen_];
}

void SplitExposure::shown(Duration lit) {
  expects(is_drawn(), "the next picture is drawn");
  on_screen_ = 1 - on_screen_;
  follow(*next_, lit);
}

}  // namespace contourd
