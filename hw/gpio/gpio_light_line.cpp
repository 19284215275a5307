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
                      " cannot be used: its descriptor, which turns it off in an emergency, was not found in "
                      "/proc/self/fd");
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
  // The light was cut meanwhile, perhaps before it was on.
  if (!cut_at()) return;
  off();
  refuse_interlocked();
}

void GpioLightLine::cut(TimePoint now) noexcept {
  // The time is set before the line is: on() looks at it after setting the line.
  Duration::rep not_cut = kNotCut;
  cut_at_.compare_exchange_strong(not_cut, now.time_since_epoch().count());
  // A refusal by the kernel is not reported here: the event loop meets it too, in off().
  if (!line_->cut()) return;
  not_cut = kNotCut;
  cut_by_.compare_exchange_strong(not_cut, clock_.now().time_since_epoch().count());
}

std::optional<TimePoint> GpioLightLine::time_of(Duration::rep time) {
  return time == kNotCut ? std::nullopt : std::optional(TimePoint{Duration{time}});
}

void GpioLightLine::refuse_interlocked() const {
  throw LightInterlocked("the light's " + words_ +
                         " stays off because of the emergency stop, the lid, the power-fail signal or an "
                         "input that cannot be read");
}

void GpioLightLine::off() noexcept {
  refuses_off_ = !line_->set(false);
  again_.reset();
  if (!refuses_off_) {
    refusal_reported_ = false;
    return;
  }
  // Retries from the event loop, so that the caller, who is turning the light off, can first do the rest.
  again_ = clock_.call_after(refusal_reported_ ? kTryAgain : Duration{0}, [this] { insist(); });
}

void GpioLightLine::insist() {
  if (!std::exchange(refusal_reported_, true) && on_event_)
    on_event_({MachineEvent::Kind::Fault, "the light may be on: " + cannot_be_set()});
  off();
}

}  // namespace contourd
