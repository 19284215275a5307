#include "hw/gpio/gpio_light_line.hpp"

#include <chrono>
#include <utility>

namespace contourd {
namespace {

constexpr Duration kTryAgain = std::chrono::seconds{1};

}  // namespace

GpioLightLine::GpioLightLine(const GpioLineConfig& config, Clock& clock)
    : GpioLightLine(std::make_unique<GpioOutput>(config, "light", false),
                    "line " + config.line + " of " + config.chip, clock) {}

GpioLightLine::GpioLightLine(std::unique_ptr<OutputLine> line, std::string words, Clock& clock)
    : words_(std::move(words)), clock_(clock), line_(std::move(line)) {}

void GpioLightLine::on() {
  if (refuses_off_) throw HardwareError(cannot_be_set());
  if (!line_->set(true)) {
    off();
    throw HardwareError(cannot_be_set());
  }
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
  if (!std::exchange(told_, true) && disturbed_)
    disturbed_({Disturbance::Kind::Fault, "the light may be on: " + cannot_be_set()});
  off();
}

std::string GpioLightLine::cannot_be_set() const {
  return "the light's " + words_ + " cannot be set: the kernel refuses";
}

}  // namespace contourd
