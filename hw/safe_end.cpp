#include "hw/safe_end.hpp"

#include "hw/gpio/step_engine.hpp"
#include "hw/watchdog/last_light_off.hpp"

namespace contourd {

void make_safe_at_once() noexcept {
  last_light_off().light_off();
  StepEngine::inhibit_all();
  last_light_off().display_black();
  last_light_off().light_off();  // another thread may have turned it on meanwhile
}

}  // namespace contourd
