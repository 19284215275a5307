// What a front (the control socket; others may come) can have the printer do or tell: by name, with
// parameters and a result, whatever they travel in.
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

// A method's refusal: the printer is in no state for it.
class ControlRefusal : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A parameter is missing, unknown or out of its range.
class InvalidParameters : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct ControlMethod {
  using Json = nlohmann::ordered_json;

  // Returns the result; throws ControlRefusal and InvalidParameters. `parameters` is an object.
  std::function<Json(const Json& parameters, const ControlCaller& caller)> call;
  std::vector<std::string> parameters{};  // the names that it may have
  bool changes = false;                   // something: it is in the log with its caller
  bool needs_service_rights = false;      // it moves or lights the printer by hand

  // Where it is set, instead of `call`: returns the result, or nothing and calls `later` with it or with a
  // refusal once, from the loop and never from inside. What the same connection asks next waits for that.
  using Later = std::function<void(std::variant<Json, ControlRefusal> result)>;
  std::function<std::optional<Json>(const Json& parameters, const ControlCaller& caller, Later later)>
      call_later{};
};

using ControlMethods = std::map<std::string, ControlMethod>;

}  // namespace contourd
