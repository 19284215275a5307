#include "hw/drm/output.hpp"

#include <unistd.h>
#include <xf86drm.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hw/hardware_error.hpp"

namespace contourd {
namespace {

[[noreturn]] void fail_to_set_mode(const std::string& output, const Mode& mode, int error) {
  throw HardwareError(output + " does not take its mode " + describe(mode) + ": " + std::strerror(error));
}

// What a card refuses, it refuses for this output.
template <typename Act>
auto for_output(const std::string& output, Act act) {
  try {
    return act();
  } catch (const HardwareError& error) {
    throw HardwareError(output + ": " + error.what());
  }
}

TimePoint now() {
  return std::chrono::time_point_cast<Duration>(std::chrono::steady_clock::now());
}

TimePoint time_of(const drm_event_vblank& event) {
  return TimePoint{std::chrono::seconds{event.tv_sec} + std::chrono::microseconds{event.tv_usec}};
}

}  // namespace

Output::Output(Card card, const Connector& connector, const DrmDisplayConfig& config)
    : card_(std::move(card)),
      connector_id_(connector.id),
      name_(connector.name + " of " + card_.name()),
      monotonic_(card_.has_monotonic_timestamps()) {
  mode_ = choose_mode(connector.modes, connector.size, config, name_);
  check_format(routes_to(card_, connector).front(), config.format, name_);
  for_output(name_, [&] { card_.become_master(); });
  const auto picture = [&] {
    return for_output(name_, [&] {
      return std::make_unique<Framebuffer>(card_, config.width, config.height, config.format);
    });
  };
  black_ = picture();
  for (int i = 0; i < config.buffers; ++i)
    masks_.push_back(picture());
  set_mode(connector, config);
}

Output::~Output() {
  black_now();
  turn_off();
}

Connector Output::connector() const {
  return card_.connector(connector_id_);
}

void Output::set_mode(const Connector& connector, const DrmDisplayConfig& config) {
  mode_ = choose_mode(connector.modes, connector.size, config, name_);
  for_output(name_, [&] {
    card_.become_master();
    crtc_ = make_crtc(card_, connector, mode_, *black_, config.legacy);
  });
  if (const int error = crtc_->set_mode(*black_); error != 0) fail_to_set_mode(name_, mode_, error);
  now_on_screen(*black_);
}

bool Output::relight(const DrmDisplayConfig& config) {
  const Connector now = connector();
  if (now.status == Connector::Status::Disconnected) return false;
  set_mode(now, config);
  return true;
}

void Output::turn_off() noexcept {
  if (const int error = crtc_ ? crtc_->turn_off() : 0; error != 0) blacken_masks_after(error);
  now_on_screen(*black_);  // as dark as that
}

// The kernel refused: what may be on the screen is blackened where it is, unless the card is gone.
void Output::blacken_masks_after(int error) noexcept {
  if (error == ENODEV) return;
  for (const auto& mask : masks_)
    mask->writer().blacken();
}

// A flip that was waiting is no longer of interest: its event will bear an old serial.
void Output::now_on_screen(const Framebuffer& picture) noexcept {
  flip_.reset();
  next_ = nullptr;
  before_ = std::exchange(on_screen_, &picture);
}

Framebuffer& Output::writable_mask() noexcept {
  const auto is_free = [&](const std::unique_ptr<Framebuffer>& mask) {
    const Framebuffer* picture = mask.get();
    const bool resting = masks_.size() > 2 && picture == before_;
    return picture != on_screen_ && picture != next_ && !resting && (!flip_ || picture != flip_->picture);
  };
  // The one written last, if it is free, most likely resembles what comes now.
  const auto last = std::ranges::find(masks_, written_, &std::unique_ptr<Framebuffer>::get);
  if (last != masks_.end() && is_free(*last)) return **last;
  const auto free = std::ranges::find_if(masks_, is_free);
  return free != masks_.end() ? **free : *masks_.front();
}

std::size_t Output::write(const Mask& mask) noexcept {
  Framebuffer& to = writable_mask();
  written_ = &to;
  return to.writer().write(mask);
}

int Output::show_written() noexcept {
  return show(*written_);
}

int Output::show_black() noexcept {
  return show(*black_);
}

int Output::show(const Framebuffer& picture) noexcept {
  if (flip_) {
    next_ = &picture;
    return 0;
  }
  const int error = crtc_->flip(picture, serial_ + 1);
  if (error == 0) flip_ = Flip{&picture, ++serial_};
  return error;
}

void Output::black_now() noexcept {
  next_ = nullptr;
  const Framebuffer* coming = flip_ ? flip_->picture : on_screen_;
  if (coming == black_.get() || !crtc_) return;
  if (!flip_ && show(*black_) == 0) return;
  const int error = crtc_->show(*black_);
  if (error == 0) return now_on_screen(*black_);
  blacken_masks_after(error);
}

Output::Events Output::read_events() noexcept {
  Events events;
  alignas(drm_event_vblank) char buffer[1024];
  const ssize_t size = ::read(card_.fd(), buffer, sizeof buffer);
  if (size < 0) events.card_is_gone = errno == ENODEV || errno == EIO;
  for (std::size_t at = 0; at + sizeof(drm_event) <= static_cast<std::size_t>(std::max<ssize_t>(size, 0));) {
    drm_event head;
    std::memcpy(&head, buffer + at, sizeof head);
    if (head.type == DRM_EVENT_FLIP_COMPLETE && head.length >= sizeof(drm_event_vblank)) {
      drm_event_vblank event;
      std::memcpy(&event, buffer + at, sizeof event);
      finish_flip(event.user_data, monotonic_ ? time_of(event) : now(), events);
    }
    at += std::max<std::size_t>(head.length, sizeof head);
  }
  return events;
}

void Output::finish_flip(std::uint64_t serial, TimePoint when, Events& events) noexcept {
  if (!flip_ || flip_->serial != serial) return;
  const Framebuffer* const next = next_;
  now_on_screen(*flip_->picture);
  if (next == nullptr) {
    events.shown = when;
  } else {
    events.error = show(*next);
  }
}

}  // namespace contourd
