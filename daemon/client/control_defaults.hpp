// Default paths that contourd and contourctl share.
#pragma once

namespace contourd {

inline constexpr const char* kDefaultSocket = "/run/contourd/control.sock";
inline constexpr const char* kDefaultConfig = "/etc/contourd/contourd.json";

}  // namespace contourd
