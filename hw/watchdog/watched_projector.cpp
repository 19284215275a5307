#include "hw/watchdog/watched_projector.hpp"

#include <algorithm>

namespace contourd {

void WatchedProjector::light_on(Duration exposure, LightOn tell) {
  dark_ = nullptr;
  passed_on_ = false;
  watched_ = true;
  offer_paths_();
  watchdog_.arm(exposure, [this, exposure, tell = std::move(tell)] {
    passed_on_ = true;
    const auto sent = [this, exposure, report_sent = tell.sent](TimePoint earliest) {
      watchdog_.begins(earliest + exposure);
      report_sent(earliest);
    };
    projector_->light_on(exposure, {.sent = sent, .done = tell.done});
  });
}

void WatchedProjector::light_off() noexcept {
  projector_->light_off();
  watchdog_.off_asked();
  if (watched_) await_darkness();
}

void WatchedProjector::power_off() noexcept {
  projector_->power_off();
  watchdog_.off_asked();
  if (watched_) await_darkness();
}

void WatchedProjector::when_dark(std::function<void()> call) {
  dark_ = std::move(call);
  await_darkness();
}

void WatchedProjector::await_darkness() {
  projector_->when_dark([this] {
    watched_ = false;
    watchdog_.disarm();
    if (const auto dark = std::exchange(dark_, nullptr)) dark();
  });
}

std::optional<LightSpan> WatchedProjector::last_light() const {
  if (!passed_on_) return std::nullopt;
  std::optional<LightSpan> light = projector_->last_light();
  const auto& trip = watchdog_.trip();
  if (!light || !trip) return light;
  light->off_earliest = std::min(light->off_earliest.value_or(trip->at), trip->at);
  if (trip->line_off) light->off_latest = std::min(light->off_latest.value_or(trip->at), trip->at);
  return light;
}

}  // namespace contourd
