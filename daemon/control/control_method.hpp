// A method that a client can call on the printer, with parameters and a result in JSON. Independent of the
// transport, which is the control socket.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "daemon/system/control_caller.hpp"

namespace contourd {

// Thrown if the printer refuses a method in its current state.
class ControlRefusal : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Thrown if a parameter is missing, unknown or out of range.
class InvalidParameters : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct ControlMethod {
  using Json = nlohmann::ordered_json;

  // Returns the result. `parameters` is an object. Throws ControlRefusal and InvalidParameters.
  std::function<Json(const Json& parameters, const ControlCaller& caller)> call;
  std::vector<std::string> parameters{};  // names of the parameters that the method accepts
  bool changes = false;                   // changes the printer; logged with its caller
  bool needs_service_rights = false;      // moves or lights the printer by hand

  // Used instead of `call` if set. Returns the result, or returns nullopt and later calls `later` once with
  // the result or a refusal, from the event loop. The connection's next request waits for that call.
  using Later = std::function<void(std::variant<Json, ControlRefusal> result)>;
  std::function<std::optional<Json>(const Json& parameters, const ControlCaller& caller, Later later)>
      call_later{};
};

using ControlMethods = std::map<std::string, ControlMethod>;

}  // namespace contourd
