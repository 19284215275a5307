// contourd's answers as replies of the HTTP server. Thread-safe (no state).
#pragma once

#include <string_view>

#include "daemon/web/http_request.hpp"
#include "daemon/web/printer/control_link.hpp"

namespace contourd::web {

inline constexpr unsigned kConflict = 409;  // the printer refuses a request in its present state

// Returns the result as JSON; for an error, its sentence with the status of HTTP that fits it.
[[nodiscard]] HttpReply reply_of(const ControlLink::Json& answer);

// Returns the part of a file that the header Range asks for (RFC 9110, 14.2), as browsers do for a film; the
// whole file if the header is empty or names anything but one range of bytes.
[[nodiscard]] HttpReply part_of(HttpReply whole, std::string_view range);

}  // namespace contourd::web
