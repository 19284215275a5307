// The way out of a process that has found a mistake of its own.
#pragma once

namespace contourd {

// Light off, no further step of the motor, screen black: at once, and for as long as the process still is.
// Any thread; neither allocates, locks nor throws. Blocks for two refreshes at most, when the light is off
// (10 s, the kernel's limit, if the display's driver hangs).
void make_safe_at_once() noexcept;

}  // namespace contourd
