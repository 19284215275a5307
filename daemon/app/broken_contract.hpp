// What becomes of contourd when it finds a mistake of its own (core/contract/expects.hpp).
#pragma once

namespace contourd {

// From now on the process that breaks a contract makes the machine safe, says so in one line to stderr, and
// is aborted, so that systemd and the light watchdog see it.
void make_safe_on_broken_contract() noexcept;

}  // namespace contourd
