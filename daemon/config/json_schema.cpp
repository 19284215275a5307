#include "daemon/config/json_schema.hpp"

#include <charconv>
#include <cstddef>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <system_error>
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

// Of an array's element; a number that no array has for a key that is none.
std::size_t index_of(const std::string& key) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
  const bool whole = error == std::errc() && end == key.data() + key.size();
  return whole ? index : std::numeric_limits<std::size_t>::max();
}

// Says what is wrong at that place. Nothing where the schema says nothing about it, as for an unknown key's
// inside.
void explain_place(const json& schema, const Path& path, JsonDocument& document) {
  const json* rules = &schema;
  const json* value = &document.value();
  std::string pointer;
  for (const std::string& key : path) {
    if (value->is_array()) {
      const std::size_t index = index_of(key);
      if (index >= value->size() || !rules->contains("items")) return;
      value = &value->at(index);
      rules = &rules->at("items");
      pointer = child_pointer(pointer, key);
      continue;
    }
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
  if (value.is_array() && schema.contains("items")) {
    for (json& item : value)
      fill_defaults(schema["items"], item);
  }
  if (!value.is_object() || !schema.contains("properties")) return;
  for (const auto& property : schema["properties"].items()) {
    const json& rules = property.value();
    if (!value.contains(property.key()) && rules.contains("default"))
      value[property.key()] = rules["default"];
    if (value.contains(property.key())) fill_defaults(rules, value[property.key()]);
  }
}

// References in what is referred to are resolved too, so that they must not go round in a circle. What stands
// beside a reference, such as a description, wins over what is referred to. Recursion is bounded by the
// schema's depth.
void resolve_references(json& schema, std::string_view file, const json& other) {
  if (schema.is_object() && schema.contains("$ref")) {
    const std::string& reference = schema["$ref"].get_ref<const std::string&>();
    const std::size_t hash = reference.find('#');
    if (hash == std::string::npos || reference.substr(0, hash) != file)
      throw std::runtime_error("a schema refers to " + reference + ", which is not in " + std::string(file));
    json resolved = other.at(json::json_pointer(reference.substr(hash + 1)));
    schema.erase("$ref");
    resolved.update(schema);
    schema = std::move(resolved);
    return resolve_references(schema, file, other);
  }
  if (!schema.is_structured()) return;
  for (json& child : schema)
    resolve_references(child, file, other);
}

}  // namespace

struct JsonSchema::Compiled {
  explicit Compiled(json schema_value) : value(std::move(schema_value)) {
    valijson::SchemaParser parser(valijson::SchemaParser::kDraft7);
    const Adapter adapter(value);
    parser.populateSchema(adapter, schema);
  }

  json value;
  valijson::Schema schema;
};

JsonSchema::JsonSchema(std::string_view text) {
  json value = json::parse(text.begin(), text.end());
  resolve_references(value, "", json(value));
  compiled_ = std::make_unique<Compiled>(std::move(value));
}

JsonSchema::JsonSchema(std::string_view text, std::string_view file, const JsonSchema& other) {
  json value = json::parse(text.begin(), text.end());
  resolve_references(value, file, other.value());
  compiled_ = std::make_unique<Compiled>(std::move(value));
}

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

const JsonSchema& plate_schema() {
  static const JsonSchema schema(plate_schema_text, "ticket.schema.json", ticket_schema());
  return schema;
}

const JsonSchema& projector_schema() {
  static const JsonSchema schema(projector_schema_text);
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
