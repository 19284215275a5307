// contourd's answers as replies of the HTTP server. Thread-safe (no state).
#pragma once

#include "daemon/web/http_request.hpp"
#include "daemon/web/printer/control_link.hpp"

namespace contourd::web {

inline constexpr unsigned kConflict = 409;  // the printer refuses a request in its present state

// Returns the result as JSON; for an error, its sentence with the status of HTTP that fits it.
[[nodiscard]] HttpReply reply_of(const ControlLink::Json& answer);

}  // namespace contourd::web
