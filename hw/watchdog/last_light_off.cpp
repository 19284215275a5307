#include "hw/watchdog/last_light_off.hpp"

#include "hw/gpio/step_engine.hpp"
#include "hw/watchdog/light_paths.hpp"

namespace contourd {
namespace {

constinit LastLightOff of_this_process;

}  // namespace

LastLightOff& last_light_off() noexcept {
  return of_this_process;
}

void LastLightOff::set(const LightOffers& offers) noexcept {
  const std::size_t other = 1 - current_;
  offers_[other] = offers;
  current_ = other;
}

void LastLightOff::light_off() const noexcept {
  const LightOffers& offers = now();
  (void)turn_line_off(offers.line.descriptor);
  send_light_off(offers.serial.descriptor, offers.serial.message);
}

void LastLightOff::display_black() const noexcept {
  show_black(now().display.descriptor, now().display.message);
}

void make_safe_at_once() noexcept {
  last_light_off().light_off();
  StepEngine::inhibit_all();
  last_light_off().display_black();
  last_light_off().light_off();  // another thread may have turned it on meanwhile
}

}  // namespace contourd
