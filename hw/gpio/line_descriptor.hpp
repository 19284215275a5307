// An output line by nothing but the descriptor that the kernel gave for it: for whoever may not use the
// library's object for the line, another thread or another process that has inherited it.
#pragma once

namespace contourd {

// One or two calls of the kernel, which takes them from any thread and process at any time, whatever
// interface the line was taken by (libgpiod 1.6: the first; libgpiod 2: the second). True when the line is
// inactive now; false for what is no line, too. Neither allocates nor locks.
[[nodiscard]] bool set_line_inactive(int descriptor) noexcept;

}  // namespace contourd
