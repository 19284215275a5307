#include "daemon/web/printer_answer.hpp"

#include <string>

#include "daemon/web/printer/fetched_file.hpp"

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

unsigned status_of(int code) {
  constexpr int kInvalidParameters = -32602, kRefused = -32000, kNotAllowed = -32001;
  switch (code) {
    case kInvalidParameters:
      return 400;
    case kRefused:
      return kConflict;
    case kNotAllowed:
      return 403;
    case ControlLink::kUnreachable:
      return 503;
    case kNoFile:
      return 502;
    default:
      return 500;
  }
}

}  // namespace

HttpReply reply_of(const Json& answer) {
  if (answer.contains("result"))
    return {.type = "application/json",
            .body = answer["result"].dump(-1, ' ', true, Json::error_handler_t::replace)};
  const Json& error = answer["error"];
  return {.status = status_of(error.value("code", 0)),
          .body = error.value("message", "contourd refuses") + "\n"};
}

}  // namespace contourd::web
