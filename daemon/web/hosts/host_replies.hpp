// Shared parts of the replies of other print hosts' interfaces. Thread-safe (no state).
#pragma once

#include <string>

#include "daemon/web/http_request.hpp"
#include "daemon/web/printer/control_link.hpp"

namespace contourd::web {

// The refusal of what a client would do by hand.
inline constexpr const char* kByHandSentence =
    "the plate is moved and the light is switched by hand only at the printer (contourctl)";

// Returns a text of an object; an empty one if there is none.
[[nodiscard]] inline std::string json_text(const ControlLink::Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

// Returns the JSON in ASCII.
[[nodiscard]] inline std::string ascii_of(const ControlLink::Json& json) {
  return json.dump(-1, ' ', true, ControlLink::Json::error_handler_t::replace);
}

// Answer with JSON, with nothing, which is success, and with a sentence about a refusal.
inline void answer_json(HttpRequest& request, const ControlLink::Json& json) {
  request.answer({.type = "application/json", .body = ascii_of(json)});
}
inline void answer_done(HttpRequest& request) {
  request.answer(HttpReply{});
}
inline void refuse_host_request(HttpRequest& request, unsigned status, const std::string& why) {
  request.answer({.status = status, .body = why + "\n"});
}

}  // namespace contourd::web
