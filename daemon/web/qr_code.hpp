// QR codes on a terminal. Thread-safe (no state).
#pragma once

#include <string>

namespace contourd::web {

// Returns the text as a QR code for a terminal with UTF-8 and colours: two rows of modules a line, dark on
// light whatever the terminal's colours are, with the margin that readers need. Empty if the text is too
// long.
[[nodiscard]] std::string qr_code_of(const std::string& text);

// True if standard output is a terminal that can show it.
[[nodiscard]] bool can_show_qr_code();

}  // namespace contourd::web
