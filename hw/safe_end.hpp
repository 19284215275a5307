// The safe way out of a process that has found a bug in itself.
#pragma once

namespace contourd {

// Turns the light off, stops the motor's steps and blanks the screen, at once and for the rest of the
// process's life. Any thread; neither allocates, locks nor throws. Blocks for at most two refreshes, after
// the light is off (10 s, the kernel's limit, if the display's driver hangs).
void make_safe_at_once() noexcept;

}  // namespace contourd
