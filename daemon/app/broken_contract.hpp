// The reaction of contourd to a broken contract, which is a bug of its own (core/contract/expects.hpp).
#pragma once

namespace contourd {

// Installs the reaction: from now on a process that breaks a contract makes the machine safe, writes one line
// to stderr and aborts, so that systemd and the light watchdog notice.
void make_safe_on_broken_contract() noexcept;

}  // namespace contourd
