// Sets an output line by the kernel's descriptor alone, for callers that may not use the library's object for
// the line: another thread, or another process that has inherited the descriptor.
#pragma once

namespace contourd {

// Makes the line inactive by one or two kernel calls, which any thread or process may make at any time. Works
// for both kernel interfaces: libgpiod 1.6 uses the first, libgpiod 2 the second. True if the line is
// inactive now; false also if the descriptor is not a line. Neither allocates nor locks.
[[nodiscard]] bool set_line_inactive(int descriptor) noexcept;

}  // namespace contourd
