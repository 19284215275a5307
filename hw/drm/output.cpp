#include "hw/drm/output.hpp"

#include <fcntl.h>
#include <linux/kd.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <utility>

#include "core/contract/expects.hpp"
#include "hw/drm/color.hpp"
#include "hw/drm/crtc_route.hpp"
#include "hw/file_descriptor.hpp"
#include "hw/hardware_error.hpp"
#include "hw/owned.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

using KernelCrtc = Owned<drmModeCrtc, drmModeFreeCrtc>;

[[noreturn]] void fail_to_set_mode(const std::string& output, const Mode& mode, int error) {
  throw HardwareError(output + " rejected its mode " + describe(mode) + ": " + std::strerror(error));
}

// Calls `act` and adds the output's name to a HardwareError.
template <typename Act>
auto for_output(const std::string& output, Act act) {
  try {
    return act();
  } catch (const HardwareError& error) {
    throw HardwareError(output + ": " + error.what());
  }
}

// Sets the active virtual terminal to graphics mode. Returns 0 or an errno; 0 also if there are no virtual
// terminals, because then no text is drawn.
int stop_drawing_text() {
  const FileDescriptor terminal(::open("/dev/tty0", O_WRONLY | O_NOCTTY | O_CLOEXEC));
  if (!terminal.valid()) return errno == ENOENT || errno == ENODEV || errno == ENXIO ? 0 : errno;
  return ::ioctl(terminal.get(), KDSETMODE, KD_GRAPHICS) == 0 ? 0 : errno;
}

// Overwrites the console's picture with black. Returns 0 or an errno.
int blacken(const fs::path& console) {
  const FileDescriptor picture(::open(console.c_str(), O_WRONLY | O_CLOEXEC));
  if (!picture.valid()) return errno;
  static constexpr std::array<char, 65536> kBlack{};
  for (;;) {
    const ssize_t count = ::write(picture.get(), kBlack.data(), kBlack.size());
    if (count > 0) continue;
    return count == 0 || errno == ENOSPC || errno == EFBIG ? 0 : errno;
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
  std::vector<std::uint32_t> masks;
  for (int i = 0; i < config.buffers; ++i)
    masks.push_back(masks_.emplace_back(picture())->id());
  flips_ = PageFlips(black_->id(), std::move(masks));
  set_mode(connector, config);
}

Output::~Output() {
  black_now();
  turn_off();
}

Duration Output::frame() const {
  return Duration{std::llround(1e9 / refresh_hz(mode_))};
}

void Output::set_mode(const Connector& connector, const DrmDisplayConfig& config) {
  mode_ = choose_mode(connector.modes, connector.size, config, name_);
  for_output(name_, [&] {
    card_.become_master();
    crtc_ = make_crtc(card_, connector, mode_, black_->id(), config.legacy);
  });
  if (const int error = crtc_->set_mode(black_->id()); error != 0) fail_to_set_mode(name_, mode_, error);
  flips_.reset();
  const KernelCrtc shown(drmModeGetCrtc(card_.fd(), crtc_->id()));
  // 0 if the picture is on another plane than the CRTC's first.
  if (shown && shown->buffer_id != black_->id() && shown->buffer_id != 0)
    throw HardwareError(name_ + " accepted black but shows another picture");
  color_warnings_ = settle_color(card_, crtc_->id(), connector, mode_, name_);
}

bool Output::restore(const DrmDisplayConfig& config) {
  if (flip_waits()) blacken_masks();  // a mask may be on the screen for as long as the driver hangs
  const Connector now = connector();
  if (now.status == Connector::Status::Disconnected) return false;
  set_mode(now, config);
  return true;
}

void Output::turn_off() noexcept {
  if (const int error = crtc_ ? crtc_->turn_off() : 0; error != 0) blacken_masks_after(error);
  flips_.reset();  // as dark as black
}

// Handles a refusal by the kernel: blackens the masks in their memory, as one may be on the screen, unless
// the card is gone.
void Output::blacken_masks_after(int error) noexcept {
  if (error != ENODEV) blacken_masks();
}

void Output::blacken_masks() noexcept {
  for (const auto& mask : masks_)
    mask->writer().blacken();
}

void Output::write(const Mask& mask) noexcept {
  expects(mask.width().count() == mode_.hdisplay && mask.height().count() == mode_.vdisplay,
          "the mask has the mode's size");
  masks_[flips_.mask_to_write()]->writer().write(mask);
}

int Output::show_written() noexcept {
  return flips_.show_written(*crtc_, now());
}

int Output::show_black() noexcept {
  return flips_.show_black(*crtc_, now());
}

int Output::black_now() noexcept {
  if (!crtc_) return 0;
  const PageFlips::Blackout blackout = flips_.black_now(*crtc_, now());
  if (blackout.error != 0) blacken_masks_after(blackout.error);
  if (blackout.mask_under_way) masks_[*blackout.mask_under_way]->writer().blacken();
  return blackout.error;
}

bool Output::flip_is_overdue() const noexcept {
  const auto since = flips_.waiting_since();
  return since && now() - *since > flip_deadline(frame());
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
      const TimePoint when = monotonic_ ? time_of(event) : now();
      if (const auto done = flips_.finish(*crtc_, event.user_data, now())) {
        events.error = done->error;
        if (done->all) events.shown = when;
      }
    }
    at += std::max<std::size_t>(head.length, sizeof head);
  }
  return events;
}

std::optional<fs::path> console_of(const fs::path& card) {
  std::error_code none;
  for (const auto& entry :
       fs::directory_iterator("/sys/class/drm" / card.filename() / "device" / "graphics", none)) {
    if (entry.path().filename().string().starts_with("fb")) return "/dev" / entry.path().filename();
  }
  return std::nullopt;
}

std::optional<std::string> keep_console_dark(const fs::path& card) {
  const auto console = console_of(card);
  if (!console) return std::nullopt;
  const int drawing = stop_drawing_text();
  const int picture = blacken(*console);
  if (drawing == 0 && picture == 0) return std::nullopt;
  return "the text console (" + console->string() + ") may come back as light on " + card.string() +
         " if this program dies: " +
         (drawing != 0 ? std::string("the terminal cannot be set to graphics mode (/dev/tty0: ") +
                             std::strerror(drawing) + ")"
                       : console->string() + " cannot be blackened (" + std::strerror(picture) + ")") +
         "; the kernel parameter fbcon=map:9 keeps it off every output";
}

DisplayProbe restored(std::shared_ptr<Output> output, const DrmDisplayConfig& config) {
  DisplayProbe probe{.output = std::move(output)};
  try {
    probe.is_back = probe.output->restore(config);
    if (probe.is_back) probe.console_warning = keep_console_dark(probe.output->card().path());
  } catch (const std::exception& error) {
    probe.refusal = error.what();
    probe.output->turn_off();
  }
  return probe;
}

DisplayProbe probe_all(const DrmDisplayConfig& config) {
  OutputSearch search;
  try {
    search = find_output(config);
  } catch (const std::exception&) {
    return {};
  }
  if (!search.found) return {};
  try {
    return open_display(std::move(*search.found), config);
  } catch (const std::exception& error) {
    return {.output = nullptr, .is_back = false, .refusal = error.what()};
  }
}

DisplayProbe open_display(FoundOutput found, const DrmDisplayConfig& config) {
  DisplayProbe probe;
  probe.console_warning = keep_console_dark(found.card.path());
  probe.output = std::make_shared<Output>(std::move(found.card), found.connector, config);
  probe.is_back = true;
  return probe;
}

}  // namespace contourd
