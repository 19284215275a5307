#include "daemon/print/split_exposure.hpp"

#include <algorithm>

#include "core/contract/expects.hpp"

namespace contourd {

SplitExposure::SplitExposure(const PanelTone& panel, Pixels width, Pixels height)
    : split_(panel), pictures_{Mask(width, height), Mask(width, height)} {}

const Mask& SplitExposure::begin(const Mask& light, const Times& times) {
  expects(light.width() == pictures_[0].width() && light.height() == pictures_[0].height(),
          "the mask has the display's size");
  expects(times.asked > Duration{0}, "the exposure has a time");
  times_ = times;
  light_ = &light;
  split_.plan(light, in_seconds(kShortestPicture * times.frame) / in_seconds(times.asked));
  const std::size_t first = picture_at(times.past);
  split_.draw(first, light, pictures_[on_screen_]);
  draw_after(first, times.past);
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

void SplitExposure::draw_after(std::size_t picture, Duration lit) {
  next_.reset();
  if (picture + 1 == split_.pictures()) return;
  next_ = std::max(picture + 1, picture_at(lit));
  split_.draw(*next_, *light_, pictures_[1 - on_screen_]);
}

std::optional<Duration> SplitExposure::next_due() const {
  if (!next_) return std::nullopt;
  return due(*next_);
}

const Mask& SplitExposure::next() const {
  expects(next_.has_value(), "a picture follows");
  return pictures_[1 - on_screen_];
}

void SplitExposure::shown(Duration lit) {
  expects(next_.has_value(), "a picture follows");
  on_screen_ = 1 - on_screen_;
  draw_after(*next_, lit);
}

}  // namespace contourd
