#include "daemon/json/json_schema.hpp"

#include "daemon/json/schema_check.hpp"
#include "daemon/json/schema_text.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

using nlohmann::json;

constexpr std::string_view kTankSchema = R"({
  "type": "object",
  "additionalProperties": false,
  "required": ["name"],
  "properties": {
    "name": {"description": "A name without '/'.", "type": "string", "maxLength": 5, "pattern": "^[^/]+$"},
    "depth_mm": {"description": "Depth, in mm.", "type": "number", "minimum": 1, "maximum": 500},
    "count": {"description": "A number.", "type": "integer", "minimum": -5, "maximum": 10, "default": 3},
    "lid": {"description": "A lid.", "type": "boolean"},
    "kind": {"description": "Which.", "type": "string", "enum": ["vat", "tray"]},
    "rotation_deg": {
      "description": "Turn.", "type": "object", "additionalProperties": false, "default": {},
      "properties": {"x": {"description": "x.", "type": "number", "maximum": 360, "default": 1.5}}
    }
  }
})";

JsonDocument checked(std::string_view text) {
  static const JsonSchema schema(kTankSchema);
  JsonDocument document = JsonDocument::from_text(text, "tank.json");
  schema.check(document);
  return document;
}

Complaints tank_complaints(std::string_view text) {
  return complaints_of([&] { checked(text).throw_if_violated(); });
}

TEST_CASE("a number outside its range is reported with the limit and the unit") {
  CHECK(tank_complaints(R"({"name": "a", "depth_mm": 900})") ==
        Complaints{"/depth_mm: 900 is more than the limit, 500 mm"});
  CHECK(tank_complaints(R"({"name": "a", "depth_mm": 0.5})") ==
        Complaints{"/depth_mm: 0.5 is less than the least allowed, 1 mm"});
  CHECK(tank_complaints(R"({"name": "a", "count": 11})") ==
        Complaints{"/count: 11 is more than the limit, 10"});
  CHECK(tank_complaints(R"({"name": "a", "rotation_deg": {"x": 361}})") ==
        Complaints{"/rotation_deg/x: 361 is more than the limit, 360 degrees"});
  CHECK(tank_complaints(R"({"name": "a", "depth_mm": 500, "count": -5})").empty());
}

TEST_CASE("a wrong type is reported with the found and the expected type") {
  CHECK(tank_complaints(R"({"name": 5})") == Complaints{"/name: expected a text, found 5"});
  CHECK(tank_complaints(R"({"name": "a", "depth_mm": "900"})") ==
        Complaints{"/depth_mm: expected a number, found the text \"900\""});
  CHECK(tank_complaints(R"({"name": "a", "depth_mm": true})") ==
        Complaints{"/depth_mm: expected a number, found true"});
  CHECK(tank_complaints(R"({"name": "a", "lid": 1})") == Complaints{"/lid: expected true or false, found 1"});
  CHECK(tank_complaints(R"({"name": "a", "lid": null})") ==
        Complaints{"/lid: expected true or false, found null"});
  CHECK(tank_complaints(R"({"name": "a", "kind": [1]})") ==
        Complaints{"/kind: expected a text, found an array"});
  CHECK(tank_complaints(R"({"name": "a", "depth_mm": {}})") ==
        Complaints{"/depth_mm: expected a number, found an object"});
  CHECK(tank_complaints(R"({"name": "a", "rotation_deg": 3})") ==
        Complaints{"/rotation_deg: expected an object, found 3"});
  CHECK(tank_complaints("[]") == Complaints{"expected an object, found an array"});
  CHECK(tank_complaints("null") == Complaints{"expected an object, found null"});
}

TEST_CASE("an integer is a whole number in any notation and nothing else") {
  CHECK(tank_complaints(R"({"name": "a", "count": 3.0})").empty());
  CHECK(tank_complaints(R"({"name": "a", "count": 1e1})").empty());
  CHECK(tank_complaints(R"({"name": "a", "count": -3.7})") ==
        Complaints{"/count: expected a whole number, found -3.7"});
  CHECK(tank_complaints(R"({"name": "a", "count": true})") ==
        Complaints{"/count: expected a whole number, found true"});
  CHECK(tank_complaints(R"({"name": "a", "count": "3"})") ==
        Complaints{"/count: expected a whole number, found the text \"3\""});
}

TEST_CASE("a huge integer is out of range, also one that would wrap around into the range") {
  CHECK(tank_complaints(R"({"name": "a", "count": 4294967299})") ==
        Complaints{"/count: 4294967299 is more than the limit, 10"});
  // As int64 this would be -1.
  CHECK(tank_complaints(R"({"name": "a", "count": 18446744073709551615})") ==
        Complaints{"/count: 1.8446744073709552e+19 is more than the limit, 10"});
  CHECK(tank_complaints(R"({"name": "a", "depth_mm": 18446744073709551615})") ==
        Complaints{"/depth_mm: 1.8446744073709552e+19 is more than the limit, 500 mm"});
  CHECK(tank_complaints(R"({"name": "a", "count": -1e300})") ==
        Complaints{"/count: -1e+300 is less than the least allowed, -5"});
}

TEST_CASE("an unknown key is reported with the closest known key, or with all known keys") {
  CHECK(tank_complaints(R"({"name": "a", "dept_mm": 3})") ==
        Complaints{"/dept_mm: there is no key \"dept_mm\" here; did you mean \"depth_mm\"?"});
  CHECK(
      tank_complaints(R"({"name": "a", "zzzzzzzz": 3})") ==
      Complaints{"/zzzzzzzz: there is no key \"zzzzzzzz\" here; the known keys are \"count\", \"depth_mm\", "
                 "\"kind\", \"lid\", \"name\", \"rotation_deg\""});
  CHECK(tank_complaints(R"({"name": "a", "rotation_deg": {"a/b~": 1}})") ==
        Complaints{"/rotation_deg/a~1b~0: there is no key \"a/b~\" here; the known keys are \"x\""});
  CHECK(tank_complaints(R"({"name": "a", "": 1})").size() == 1);
}

TEST_CASE("all unknown keys are reported, and their values are not checked") {
  CHECK(tank_complaints(
            R"({"name": "a", "u1": {"depth_mm": 900}, "u2": 1, "rotation_deg": {"u3": [], "u4": 0}})")
            .size() == 4);
}

TEST_CASE("a missing key is reported with its description") {
  CHECK(tank_complaints("{}") == Complaints{"/name: this key is missing: A name without '/'"});
}

TEST_CASE("a text is checked against the enumeration, the length and the pattern") {
  CHECK(tank_complaints(R"({"name": "a", "kind": "box"})") ==
        Complaints{"/kind: the text \"box\" is not one of \"vat\", \"tray\""});
  CHECK(tank_complaints(R"({"name": "abcdef"})") ==
        Complaints{"/name: \"abcdef\" is 6 characters long; the limit is 5"});
  CHECK(tank_complaints("{\"name\": \"\xe2\x82\xac\xe2\x82\xac\xe2\x82\xac\xe2\x82\xac\xe2\x82\xac\"}")
            .empty());
  CHECK(tank_complaints(R"({"name": "a/b"})") ==
        Complaints{"/name: \"a/b\" is not allowed: A name without '/'"});
  CHECK(tank_complaints(R"({"name": ""})") == Complaints{"/name: it must not be empty"});
}

TEST_CASE("the longest permitted text does not exhaust the stack of the pattern's matcher") {
  CHECK(tank_complaints("{\"name\": \"" + std::string(1024, 'x') + "\"}").size() == 1);
}

TEST_CASE("duplicate keys and violations of the schema are reported together, sorted by place") {
  CHECK(tank_complaints(R"({"name": "a/b", "lid": 1, "count": 99, "lid": 2})") ==
        Complaints{"/count: 99 is more than the limit, 10", "/lid: this key occurs more than once",
                   "/lid: expected true or false, found 2",
                   "/name: \"a/b\" is not allowed: A name without '/'"});
}

TEST_CASE("missing keys get the schema's defaults, also in sections that are missing") {
  const JsonDocument document = checked(R"({"name": "a"})");
  CHECK(document.value().dump() == R"({"count":3,"name":"a","rotation_deg":{"x":1.5}})");
  CHECK(checked(R"({"name": "a", "count": 4, "rotation_deg": {"x": 2}})").value().at("count").get<int>() ==
        4);
}

TEST_CASE("at most a thousand violations of a document are reported") {
  std::string text = R"({"name": "a")";
  for (int i = 0; i < 5000; ++i)
    text += ", \"u" + std::to_string(i) + "\": 1";
  CHECK(checked(text + "}").violations().size() == 1000);
}

const std::array kAllSchemas{&printer_schema, &projector_schema, &resin_schema, &ticket_schema,
                             &plate_schema};

// Calls `visit` for every property of the schema, parents first. The references must have no cycle.
void each_property(const SchemaNode& named, const std::string& pointer,
                   const std::function<void(const std::string&, const SchemaNode&)>& visit) {
  const SchemaNode& rules = named.followed();
  if (rules.items != nullptr) each_property(*rules.items, child_pointer(pointer, "0"), visit);
  for (const auto& [key, property] : rules.properties) {
    const std::string place = child_pointer(pointer, key);
    visit(place, *property);
    each_property(*property, place, visit);
  }
}

TEST_CASE("every property of every schema has a description, its unit and limits") {
  for (const auto schema : kAllSchemas) {
    each_property(schema().root(), "", [](const std::string& place, const SchemaNode& property) {
      INFO(place);
      const SchemaNode& rules = property.followed();

      REQUIRE_FALSE(rules.types.empty());
      const std::string description = property.description_here();
      CHECK(description != SchemaNode().description_here());
      const auto may_be = [&](std::string_view type) {
        return std::ranges::count(rules.types, type, &JsonType::name) > 0;
      };
      const bool is_number = may_be("number") || may_be("integer");
      CHECK(is_number == rules.minimum.has_value());
      CHECK(is_number == rules.maximum.has_value());
      const bool is_object = may_be("object");
      const bool is_closed = rules.additional_properties != nullptr && rules.additional_properties->is_false;
      CHECK(is_object == is_closed);
      for (const auto& [ending, unit] : {std::pair{"_mm", "mm"},
                                         {"_um", "um"},
                                         {"_ms", "ms"},
                                         {"_us", "us"},
                                         {"_mm_s3", "mm/s3"},
                                         {"_hz", "Hz"},
                                         {"_mm_s", "mm/s"},
                                         {"_mm_s2", "mm/s2"},
                                         {"_px", "pixels"},
                                         {"_mb", "MB"},
                                         {"_mw_cm2", "mW/cm²"},
                                         {"_mj_cm2", "mJ/cm²"},
                                         {"_deg", "degrees"}}) {
        if (place.ends_with(ending)) CHECK(description.find(unit) != std::string::npos);
      }
    });
  }
}

TEST_CASE("a complaint about a number has the unit of its description") {
  int units = 0;
  for (const auto schema : kAllSchemas) {
    each_property(schema().root(), "", [&units](const std::string& place, const SchemaNode& property) {
      if (!property.followed().maximum) return;
      const std::string key = place.substr(place.rfind('/') + 1);
      json alone = {{"type", "object"}, {"additionalProperties", false}};
      alone["properties"][key] = {{"description", "A number."}, {"type", "number"}, {"maximum", 1}};
      JsonDocument document = JsonDocument::from_text(json{{key, 2}}.dump(), "test.json");
      JsonSchema(alone.dump()).check(document);
      const std::string complaint = complaints_of([&] { document.throw_if_violated(); }).at(0);
      const std::string limit = ": 2 is more than the limit, 1";
      const std::string unit = complaint.substr(complaint.find(limit) + limit.size());
      if (unit.empty() || unit == " px" || unit == " per mm") return;  // descriptions name these otherwise
      ++units;
      INFO(complaint);
      const std::string description = property.description_here() + ".";
      CHECK(std::ranges::any_of(std::string_view(".,;: "), [&](char after) {
        return description.find("in" + unit + after) != std::string::npos;
      }));
    });
  }
  CHECK(units > 50);
}

TEST_CASE("every default in a schema satisfies that schema") {
  for (const auto schema : kAllSchemas) {
    each_property(schema().root(), "", [](const std::string& place, const SchemaNode& property) {
      if (property.default_here() == nullptr) return;
      INFO(place);
      JsonDocument document = JsonDocument::from_text("{}", "test.json");
      document.value() = *property.default_here();
      check_by_schema(property, document);
      CHECK(document.violations().empty());
    });
  }
}

TEST_CASE("the embedded schemas are the files in config") {
  CHECK(json::parse(contourd_schema_text) == testing::shipped("contourd.schema.json"));
  CHECK(json::parse(plate_schema_text) == testing::shipped("plate.schema.json"));
  CHECK(json::parse(projector_schema_text) == testing::shipped("projector.schema.json"));
  CHECK(json::parse(resin_schema_text) == testing::shipped("resin.schema.json"));
  CHECK(json::parse(ticket_schema_text) == testing::shipped("ticket.schema.json"));
}

TEST_CASE("no embedded schema has a duplicate key") {
  for (const std::string_view text : {contourd_schema_text, plate_schema_text, projector_schema_text,
                                      resin_schema_text, ticket_schema_text})
    CHECK(JsonDocument::from_text(text, "schema").violations().empty());
}

// Checks that only "description" and "default" stand beside "$ref"; the draft ignores all other keywords
// there.
void check_keywords_beside_references(const json& schema) {
  if (schema.is_object() && schema.contains("$ref")) {
    for (const auto& member : schema.items())
      CHECK((member.key() == "$ref" || member.key() == "description" || member.key() == "default"));
  }
  for (const json& part : schema) {
    if (part.is_structured()) check_keywords_beside_references(part);
  }
}

TEST_CASE("only a description or a default stands beside a reference in the schemas of config") {
  for (const char* name : {"contourd", "plate", "projector", "resin", "ticket"})
    check_keywords_beside_references(testing::shipped(name + std::string(".schema.json")));
}

TEST_CASE("a place in the schema is found by the document's keys") {
  using Pointer = json::json_pointer;
  CHECK(printer_schema().at(Pointer("/z_axis/travel_mm")).maximum == json(500));
  CHECK(printer_schema().at(Pointer("/z_axis/step/line")).followed().min_length == 1U);
  CHECK(&printer_schema().at(Pointer("")) == &printer_schema().root());
  CHECK_THROWS_AS(printer_schema().at(Pointer("/z_axis/colour")), std::out_of_range);
}

TEST_CASE("a schema refers to parts of itself, and a description beside a reference wins") {
  const JsonSchema schema(R"({"type": "object",
    "definitions": {"size": {"description": "A size.", "type": "number", "minimum": 1, "default": 3},
                    "pair": {"type": "object", "properties": {"a": {"$ref": "#/definitions/size"}}}},
    "properties": {"one": {"$ref": "#/definitions/pair", "description": "One."},
                   "other": {"$ref": "#/definitions/pair"}}})");
  CHECK(schema.root().properties.at("one")->description_here() == "One");
  CHECK(schema.root().properties.at("other")->description_here() == "see the schema");
  JsonDocument document = JsonDocument::from_text(R"({"one": {"a": 0}, "other": {}})", "test.json");
  schema.check(document);
  REQUIRE(document.violations().size() == 1);
  CHECK(document.violations()[0].pointer == "/one/a");
  CHECK(document.value()["other"]["a"] == 3);
  CHECK_THROWS(JsonSchema(R"({"properties": {"x": {"$ref": "#/definitions/none"}}})"));
}

TEST_CASE("a schema refers to parts of another schema") {
  const JsonSchema other(R"({"properties": {"size": {"type": "number", "minimum": 1, "default": 3}}})",
                         "other.json");
  const JsonSchema schema(R"({"type": "object", "properties": {"list": {"type": "array", "maxItems": 2,
    "items": {"type": "object", "properties": {"size": {"$ref": "other.json#/properties/size"}}}}}})",
                          "schema", other);
  JsonDocument document = JsonDocument::from_text(R"({"list": [{"size": 0}, {}]})", "test.json");
  schema.check(document);
  REQUIRE(document.violations().size() == 1);
  CHECK(document.violations()[0].pointer == "/list/0/size");
  CHECK(document.value()["list"][1]["size"] == 3);
  JsonDocument longer = JsonDocument::from_text(R"({"list": [{}, {}, {}]})", "test.json");
  schema.check(longer);
  REQUIRE(longer.violations().size() == 1);
  CHECK(longer.violations()[0].message == "there are 3 in this list; the limit is 2");
  CHECK_THROWS(JsonSchema(R"({"$ref": "third.json#/properties/size"})", "schema", other));
  CHECK_THROWS(JsonSchema(R"({"$ref": "other.json#/properties/colour"})", "schema", other));
}

TEST_CASE("a schema may refer to a part of its own text, also indirectly") {
  const JsonSchema schema(R"({"definitions": {
      "short": {"type": "integer", "maximum": 9},
      "pair": {"type": "object", "properties": {"a": {"$ref": "#/definitions/short"}}}},
    "type": "object", "properties": {"one": {"$ref": "#/definitions/short"}, "two": {"$ref": "#/definitions/pair"}}})");
  JsonDocument document = JsonDocument::from_text(R"({"one": 10, "two": {"a": 11}})", "x.json");
  schema.check(document);
  REQUIRE(document.violations().size() == 2);
  CHECK(document.violations()[0].message == "10 is more than the limit, 9");
  CHECK(document.violations()[1].pointer == "/two/a");
}

TEST_CASE("keys that a plate shares with a ticket are defined once, in the ticket's schema") {
  const json file = testing::shipped("plate.schema.json");
  const json& model = file["properties"]["models"]["items"]["properties"];
  for (const auto& property : model.items()) {
    if (property.key() == "file") continue;
    CHECK(property.value()["$ref"] == "ticket.schema.json#/properties/" + property.key());
    const SchemaNode& of_model = *plate_schema().root().properties.at("models")->items;
    CHECK(of_model.properties.at(property.key())->description_here() ==
          ticket_schema().root().properties.at(property.key())->description_here());
  }
}

}  // namespace
}  // namespace contourd
