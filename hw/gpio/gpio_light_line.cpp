#include "hw/gpio/gpio_light_line.hpp"

#include <chrono>
#include <utility>

namespace contourd {
namespace {

constexpr Duration kTryAgain = std::chrono::seconds{1};

std::unique_ptr<CuttableLine> take_light(const GpioLineConfig& config) {
  auto line = std::make_unique<GpioOutput>(config, "light", false);
  if (line->descriptor() >= 0) return line;
  throw HardwareError("the light's line " + config.line + " of " + config.chip +
                      " could not be turned off in time: its descriptor is not found in /proc/self/fd");
}

}  // namespace

GpioLightLine::GpioLightLine(const GpioLineConfig& config, Clock& clock)
    : GpioLightLine(take_light(config), "line " + config.line + " of " + config.chip, clock) {}

GpioLightLine::GpioLightLine(std::unique_ptr<CuttableLine> line, std::string words, Clock& clock)
    : words_(std::move(words)), clock_(clock), line_(std::move(line)) {}

void GpioLightLine::on() {
  if (refuses_off_) throw HardwareError(cannot_be_set());
  if (cut_at()) refuse_interlocked();
  if (!line_->set(true)) {
    off();
    throw HardwareError(cannot_be_set());
  }
  // Cut meanwhile, perhaps before it was on.
  if (!cut_at()) return;
  off();
  refuse_interlocked();
}

void GpioLightLine::cut(TimePoint now) noexcept {
  // Before the line: whoever has just set it looks again.
  Duration::rep not_cut = kNotCut;
  cut_at_.compare_exchange_strong(not_cut, now.time_since_epoch().count());
  // What the kernel refuses here it refuses the event loop too, which tells.
  if (!line_->cut()) return;
  not_cut = kNotCut;
  cut_by_.compare_exchange_strong(not_cut, clock_.now().time_since_epoch().count());
}

std::optional<TimePoint> GpioLightLine::time_of(Duration::rep time) {
  return time == kNotCut ? std::nullopt : std::optional(TimePoint{Duration{time}});
}

void GpioLightLine::refuse_interlocked() const {
  throw LightInterlocked(
      "the light's " + words_ +
      " stays off: the emergency stop, the lid or an input that cannot be read asks for it");
}

void GpioLightLine::off() noexcept {
  refuses_off_ = !line_->set(false);
  again_.reset();
  if (!refuses_off_) {
    told_ = false;
    return;
  }
  // From the event loop: whoever turns the light off has more to do first.
  again_ = clock_.call_after(told_ ? kTryAgain : Duration{0}, [this] { insist(); });
}

void GpioLightLine::insist() {
  if (!std::exchange(told_, true) && on_event_)
    on_event_({MachineEvent::Kind::Fault, "the light may be on: " + cannot_be_set()});
  off();
}

std::string GpioLightLine::cannot_be_set() const {
  return "the light's " + words_ + " cannot be set: the kernel refuses";
}

}  // namespace contourd
