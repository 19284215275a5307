// A method that a client can call on the printer, with parameters and a result in JSON. A method describes
// itself: the check of its parameters, the reply of the method "methods" and docs/control-api.md come from
// the description. Independent of the transport, which is the control socket.
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

// A parameter of a method and its valid values.
struct ControlParameter {
  using Json = nlohmann::ordered_json;
  enum class Type { Flag, Number, WholeNumber, Text, Object };

  // The largest whole number that every JSON parser keeps.
  static constexpr double kMost = 9'007'199'254'740'991;

  static ControlParameter flag(std::string name, std::string meaning);
  static ControlParameter number(std::string name, double least, double most, const std::string& unit,
                                 std::string meaning);
  static ControlParameter whole_number(std::string name, double least, double most, std::string meaning);
  static ControlParameter text(std::string name, std::string meaning);
  static ControlParameter object(std::string name, std::string meaning);
  static ControlParameter one_of(std::string name, std::vector<std::string> words, std::string meaning);

  // Returns the parameter as one that has to be given.
  [[nodiscard]] ControlParameter needed() const;
  // Returns the parameter with another description of its valid values: the end of "NAME must be ...".
  [[nodiscard]] ControlParameter described_as(std::string values) const;

  // Throws InvalidParameters if the value is not valid.
  void check(const Json& value) const;

  std::string name, meaning;
  std::string must_be;  // the valid values, as in "last must be a whole number from 1 to 100"
  Type type = Type::Text;
  bool is_needed = false;
  double least = 0, most = 0;        // limits of a number
  std::vector<std::string> words{};  // the only valid texts; for a number, texts that are valid, too

 private:
  [[nodiscard]] bool is_valid(const Json& value) const;
};

struct ControlMethod {
  using Json = nlohmann::ordered_json;

  std::string description{};  // a sentence that begins with a verb: "Reports ..."
  std::vector<ControlParameter> parameters{};

  // Returns the result. `parameters` is an object that check() has returned. Throws ControlRefusal and
  // InvalidParameters.
  std::function<Json(const Json& parameters, const ControlCaller& caller)> call{};
  bool changes = false;               // changes the printer; logged with its caller
  bool reports_when_bare = false;     // without parameters it changes nothing, and is not logged
  bool needs_service_rights = false;  // moves or lights the printer by hand

  // Used instead of `call` if set. Calls `later` once with the result or a refusal, before it returns or
  // afterwards from the event loop. The connection's next request waits for that call.
  using Later = std::function<void(std::variant<Json, ControlRefusal> result)>;
  std::function<void(const Json& parameters, const ControlCaller& caller, Later later)> call_later{};

  // True if a call with these parameters changes something.
  [[nodiscard]] bool changes_with(const Json& params) const {
    return changes && !(reports_when_bare && params.empty());
  }
  // Checks the "params" of a request for the method `name`; null if there are none. Returns them as an
  // object. Throws InvalidParameters.
  [[nodiscard]] Json check(const std::string& name, const Json& params) const;
};

// Returns the parameter's value, or nullopt if it is not given. Throws an exception of the JSON library for a
// value of another type, which ControlMethod::check() does not accept.
template <typename Value>
[[nodiscard]] std::optional<Value> given_value(const nlohmann::ordered_json& parameters, const char* name) {
  const auto found = parameters.find(name);
  return found == parameters.end() ? std::nullopt : std::optional(found->get<Value>());
}

// Returns the value, or null if there is none or the text is empty.
template <typename Value>
[[nodiscard]] nlohmann::ordered_json or_null(const std::optional<Value>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}
[[nodiscard]] inline nlohmann::ordered_json or_null(const std::string& text) {
  return text.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(text);
}

using ControlMethods = std::map<std::string, ControlMethod>;

// Returns the descriptions of the methods and of their parameters.
[[nodiscard]] nlohmann::ordered_json describe(const ControlMethods& methods);

}  // namespace contourd
