#include "daemon/config/json_schema.hpp"

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>
#include <vector>

#include "daemon/config/schema_sentence.hpp"
#include "daemon/config/schema_text.hpp"

namespace contourd {
namespace {

using nlohmann::json;
using Adapter = valijson::adapters::NlohmannJsonAdapter;
// A place in a document: the keys from its root.
using Path = std::vector<std::string>;

// valijson's context is "<root>", "[key]", "[key]"...
Path path_of(const std::vector<std::string>& context) {
  Path path;
  for (std::size_t i = 1; i < context.size(); ++i) {
    const std::string& token = context[i];
    const bool bracketed = token.size() >= 2 && token.front() == '[' && token.back() == ']';
    path.push_back(bracketed ? token.substr(1, token.size() - 2) : token);
  }
  return path;
}

// Says what is wrong at that place. Nothing where the schema says nothing about it, as for an unknown key's
// inside.
void explain_place(const json& schema, const Path& path, JsonDocument& document) {
  const json* rules = &schema;
  const json* value = &document.value();
  std::string pointer;
  for (const std::string& key : path) {
    if (!value->is_object() || !value->contains(key)) return;
    if (!rules->contains("properties") || !rules->at("properties").contains(key)) return;
    value = &value->at(key);
    rules = &rules->at("properties").at(key);
    pointer = child_pointer(pointer, key);
  }
  explain(*rules, *value, pointer, document);
}

// Recursion is bounded by the schema's depth.
void fill_defaults(const json& schema, json& value) {
  if (!value.is_object() || !schema.contains("properties")) return;
  for (const auto& property : schema["properties"].items()) {
    const json& rules = property.value();
    if (!value.contains(property.key()) && rules.contains("default"))
      value[property.key()] = rules["default"];
    if (value.contains(property.key())) fill_defaults(rules, value[property.key()]);
  }
}

}  // namespace

struct JsonSchema::Compiled {
  explicit Compiled(std::string_view text) : value(json::parse(text.begin(), text.end())) {
    valijson::SchemaParser parser(valijson::SchemaParser::kDraft7);
    const Adapter adapter(value);
    parser.populateSchema(adapter, schema);
  }

  json value;
  valijson::Schema schema;
};

JsonSchema::JsonSchema(std::string_view text) : compiled_(std::make_unique<Compiled>(text)) {}

JsonSchema::~JsonSchema() = default;

const json& JsonSchema::value() const {
  return compiled_->value;
}

// valijson decides whether the document is valid and names the places, with every place's parents after it.
// What is wrong there is said anew from the schema: its own texts lack the value, and it names one unknown
// key of many.
void JsonSchema::check(JsonDocument& document) const {
  valijson::Validator validator(valijson::Validator::kStrongTypes);
  valijson::ValidationResults results;
  if (!validator.validate(compiled_->schema, Adapter(document.value()), &results)) {
    std::set<Path> places;
    for (const auto& error : results)
      places.insert(path_of(error.context));
    const std::size_t before = document.violations().size();
    for (const Path& place : places)
      explain_place(compiled_->value, place, document);
    if (document.violations().size() == before) {
      const auto first = results.begin();
      document.add_violation(
          "", "it does not fit its schema" + (first == results.end() ? "" : ": " + first->description));
    }
  }
  fill_defaults(compiled_->value, document.value());
}

const JsonSchema& printer_schema() {
  static const JsonSchema schema(contourd_schema_text);
  return schema;
}

const JsonSchema& resin_schema() {
  static const JsonSchema schema(resin_schema_text);
  return schema;
}

const JsonSchema& ticket_schema() {
  static const JsonSchema schema(ticket_schema_text);
  return schema;
}

}  // namespace contourd
