#include "daemon/control/control_method.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace contourd {

using Json = ControlMethod::Json;

ControlParameter ControlParameter::flag(std::string name, std::string meaning) {
  return {
      .name = std::move(name), .meaning = std::move(meaning), .must_be = "true or false", .type = Type::Flag};
}

ControlParameter ControlParameter::number(std::string name, double least, double most,
                                          const std::string& unit, std::string meaning) {
  return {.name = std::move(name),
          .meaning = std::move(meaning),
          .must_be = fmt::format("a number from {:g} to {:g} {}", least, most, unit),
          .type = Type::Number,
          .least = least,
          .most = most};
}

ControlParameter ControlParameter::whole_number(std::string name, double least, double most,
                                                std::string meaning) {
  return {.name = std::move(name),
          .meaning = std::move(meaning),
          .must_be = fmt::format("a whole number from {:.0f} to {:.0f}", least, most),
          .type = Type::WholeNumber,
          .least = least,
          .most = most};
}

ControlParameter ControlParameter::text(std::string name, std::string meaning) {
  return {.name = std::move(name), .meaning = std::move(meaning), .must_be = "a text that is not empty"};
}

ControlParameter ControlParameter::object(std::string name, std::string meaning) {
  return {
      .name = std::move(name), .meaning = std::move(meaning), .must_be = "an object", .type = Type::Object};
}

ControlParameter ControlParameter::one_of(std::string name, std::vector<std::string> words,
                                          std::string meaning) {
  return {.name = std::move(name),
          .meaning = std::move(meaning),
          .must_be = fmt::format("one of {}", fmt::join(words, ", ")),
          .words = std::move(words)};
}

ControlParameter ControlParameter::needed() const {
  ControlParameter parameter = *this;
  parameter.is_needed = true;
  return parameter;
}

ControlParameter ControlParameter::described_as(std::string values) const {
  ControlParameter parameter = *this;
  parameter.must_be = std::move(values);
  return parameter;
}

bool ControlParameter::is_valid(const Json& value) const {
  const bool is_word =
      value.is_string() && std::ranges::find(words, value.get_ref<const std::string&>()) != words.end();
  switch (type) {
    case Type::Flag:
      return value.is_boolean();
    case Type::Object:
      return value.is_object();
    case Type::Text:
      return words.empty() ? value.is_string() && value != "" : is_word;
    case Type::WholeNumber:
      if (!value.is_number_integer()) return is_word;
      [[fallthrough]];
    case Type::Number:
      // NaN, for a value that is no number, is not in the range.
      const double number = value.is_number() ? value.get<double>() : NAN;
      return number >= least && number <= most;
  }
  return false;
}

void ControlParameter::check(const Json& value) const {
  if (!is_valid(value)) throw InvalidParameters(fmt::format("{} must be {}", name, must_be));
}

Json ControlMethod::check(const std::string& name, const Json& params) const {
  std::vector<std::string> known;
  for (const ControlParameter& each : parameters)
    known.push_back(each.name);
  const std::string names = fmt::format("{}", fmt::join(known, ", "));
  if (!params.empty()) {
    if (known.empty()) throw InvalidParameters(fmt::format("the method \"{}\" takes no parameters", name));
    if (!params.is_object())
      throw InvalidParameters(fmt::format("the method \"{}\" takes its parameters by name: {}", name, names));
    for (const auto& [given, value] : params.items()) {
      if (std::ranges::find(known, given) == known.end())
        throw InvalidParameters(
            fmt::format("the method \"{}\" has no parameter \"{}\"; there are {}", name, given, names));
    }
  }
  for (const ControlParameter& each : parameters) {
    const bool is_given = params.is_object() && params.contains(each.name);
    if (is_given || each.is_needed) each.check(is_given ? params[each.name] : Json());
  }
  return params.empty() ? Json::object() : params;
}

Json describe(const ControlMethods& methods) {
  Json all = Json::array();
  for (const auto& [name, method] : methods) {
    Json parameters = Json::array();
    for (const ControlParameter& each : method.parameters) {
      const bool is_number =
          each.type == ControlParameter::Type::Number || each.type == ControlParameter::Type::WholeNumber;
      parameters.push_back({{"name", each.name},
                            {"meaning", each.meaning},
                            {"needed", each.is_needed},
                            {"must_be", each.must_be},
                            {"least", is_number ? Json(each.least) : Json()},
                            {"most", is_number ? Json(each.most) : Json()},
                            {"words", each.words}});
    }
    all.push_back({{"name", name},
                   {"description", method.description},
                   {"parameters", std::move(parameters)},
                   {"changes", method.changes},
                   {"needs_service_rights", method.needs_service_rights}});
  }
  return {{"methods", std::move(all)}};
}

}  // namespace contourd
