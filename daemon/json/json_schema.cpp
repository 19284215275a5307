#include "daemon/json/json_schema.hpp"

#include <utility>

#include "daemon/json/schema_check.hpp"
#include "daemon/json/schema_text.hpp"

namespace contourd {
namespace {

struct Schemas {
  JsonSchema projector{projector_schema_text, "projector.schema.json"};
  JsonSchema resin{resin_schema_text, "resin.schema.json"};
  JsonSchema printer{contourd_schema_text, "contourd.schema.json", resin};
  JsonSchema ticket{ticket_schema_text, "ticket.schema.json"};
  JsonSchema plate{plate_schema_text, "plate.schema.json", ticket};
};

const Schemas& schemas() {
  static const Schemas all;
  return all;
}

}  // namespace

JsonSchema::JsonSchema(std::string_view text, std::string name)
    : text_{std::move(name), nlohmann::json::parse(text)}, nodes_(read_schema(text_, nullptr)) {}

JsonSchema::JsonSchema(std::string_view text, std::string name, const JsonSchema& other)
    : text_{std::move(name), nlohmann::json::parse(text)}, nodes_(read_schema(text_, &other.text_)) {}

void JsonSchema::check(JsonDocument& document) const {
  check_by_schema(root(), document);
  fill_defaults(root(), document.value());
}

const SchemaNode& JsonSchema::at(const nlohmann::json::json_pointer& place) const {
  if (place.empty()) return root();
  return *at(place.parent_pointer()).followed().properties.at(place.back());
}

const JsonSchema& printer_schema() {
  return schemas().printer;
}

const JsonSchema& plate_schema() {
  return schemas().plate;
}

const JsonSchema& projector_schema() {
  return schemas().projector;
}

const JsonSchema& resin_schema() {
  return schemas().resin;
}

const JsonSchema& ticket_schema() {
  return schemas().ticket;
}

}  // namespace contourd
