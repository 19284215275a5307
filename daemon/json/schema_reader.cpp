#include "daemon/json/schema_reader.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

using nlohmann::json;

// The place of a schema or keyword: the text and a pointer into it.
struct Place {
  const SchemaText* text;
  std::string pointer;

  [[nodiscard]] Place operator/(std::string_view token) const {
    return {text, child_pointer(pointer, token)};
  }
  auto operator<=>(const Place&) const = default;
};

[[noreturn]] void reject(const Place& place, std::string message) {
  throw ConfigError({{place.text->name, place.pointer, std::move(message)}});
}

void expect(bool fits, const Place& place, const char* what) {
  if (!fits) reject(place, std::string("expected ") + what);
}

const std::string& text_at(const json& value, const Place& place) {
  expect(value.is_string(), place, "a text");
  return value.get_ref<const std::string&>();
}

std::size_t size_at(const json& value, const Place& place) {
  constexpr double kExactLimit = 9007199254740992.0;  // 2^53: doubles hold every whole number up to here
  const bool fits = value.is_number() && value >= 0 && value <= kExactLimit &&
                    std::trunc(value.get<double>()) == value.get<double>();
  expect(fits, place, "a whole number that is not negative");
  return static_cast<std::size_t>(value.get<double>());
}

json number_at(const json& value, const Place& place) {
  expect(value.is_number(), place, "a number");
  return value;
}

const json& list_at(const json& value, const Place& place) {
  expect(value.is_array() && !value.empty(), place, "a list that is not empty");
  return value;
}

const json& object_at(const json& value, const Place& place) {
  expect(value.is_object(), place, "an object");
  return value;
}

// Decodes percent escapes in a reference: "%25" is '%'.
std::string percent_decoded(std::string_view text, const Place& place) {
  std::string decoded;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] != '%') {
      decoded += text[at];
      continue;
    }
    const std::string_view digits = text.substr(at + 1, 2);
    unsigned byte = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), byte, 16);
    expect(digits.size() == 2 && error == std::errc() && end == digits.data() + 2, place,
           "two hexadecimal digits after '%'");
    decoded += static_cast<char>(byte);
    at += 2;
  }
  return decoded;
}

SchemaPattern pattern_at(const json& value, const Place& place) {
  try {
    return SchemaPattern(text_at(value, place));
  } catch (const std::invalid_argument& error) {
    reject(place, error.what());
  }
}

// Returns the named types (one name or a list of names), in the order of json_types().
std::vector<const JsonType*> types_at(const json& value, const Place& place) {
  const std::vector<json> names =
      value.is_array() ? list_at(value, place).get<std::vector<json>>() : std::vector{value};
  std::vector<const JsonType*> types;
  for (const json& name : names) {
    const auto has_name = [&](const JsonType& type) { return type.name == text_at(name, place); };
    if (std::ranges::none_of(json_types(), has_name))
      reject(place, "the type " + in_quotes(text_at(name, place)) + " is not supported");
  }
  for (const JsonType& type : json_types()) {
    const auto is_it = [&type](const json& name) { return name == type.name; };
    if (std::ranges::any_of(names, is_it)) types.push_back(&type);
  }
  return types;
}

class SchemaReader {
 public:
  SchemaReader(const SchemaText& text, const SchemaText* other) : text_(text), other_(other) {}

  // Reads the whole schema. Call it only once.
  SchemaNodes read();
  // Returns the schema at this place; the first call for a place reads it.
  const SchemaNode* schema(const json& value, const Place& place);
  // Returns the schema that the reference names.
  const SchemaNode* referred(const std::string& reference, const Place& place);

 private:
  const SchemaText& text_;
  const SchemaText* other_;
  SchemaNodes nodes_;
  std::map<Place, const SchemaNode*> by_place_;
};

struct Keyword {
  std::string_view name;
  void (*read)(SchemaReader&, SchemaNode&, const json&, const Place&);
};

// Keywords without an effect on validation.
constexpr std::array<std::string_view, 3> kAnnotations{"$comment", "examples", "title"};

constexpr std::array<Keyword, 20> kKeywords{{
    {"$schema",
     [](SchemaReader&, SchemaNode&, const json& value, const Place& place) {
       const std::string& draft = text_at(value, place);
       if (!draft.starts_with("http://json-schema.org/draft-07/schema"))
         reject(place, "the draft " + in_quotes(draft) + " is not supported; only draft 7 is");
     }},
    {"$id",
     [](SchemaReader&, SchemaNode&, const json& value, const Place& place) {
       text_at(value, place);
       if (place.pointer != "/$id") reject(place, "$id is only supported for the whole schema");
     }},
    {"$ref", [](SchemaReader& reader, SchemaNode& node, const json& value,
                const Place& place) { node.reference = reader.referred(text_at(value, place), place); }},
    {"description", [](SchemaReader&, SchemaNode& node, const json& value,
                       const Place& place) { node.description = text_at(value, place); }},
    {"default",
     [](SchemaReader&, SchemaNode& node, const json& value, const Place&) { node.default_value = value; }},
    {"definitions",
     [](SchemaReader& reader, SchemaNode&, const json& value, const Place& place) {
       for (const auto& definition : object_at(value, place).items())
         reader.schema(definition.value(), place / definition.key());
     }},
    {"type", [](SchemaReader&, SchemaNode& node, const json& value,
                const Place& place) { node.types = types_at(value, place); }},
    {"enum", [](SchemaReader&, SchemaNode& node, const json& value,
                const Place& place) { node.enumeration = list_at(value, place).get<std::vector<json>>(); }},
    {"minimum", [](SchemaReader&, SchemaNode& node, const json& value,
                   const Place& place) { node.minimum = number_at(value, place); }},
    {"maximum", [](SchemaReader&, SchemaNode& node, const json& value,
                   const Place& place) { node.maximum = number_at(value, place); }},
    {"minLength", [](SchemaReader&, SchemaNode& node, const json& value,
                     const Place& place) { node.min_length = size_at(value, place); }},
    {"maxLength", [](SchemaReader&, SchemaNode& node, const json& value,
                     const Place& place) { node.max_length = size_at(value, place); }},
    {"pattern", [](SchemaReader&, SchemaNode& node, const json& value,
                   const Place& place) { node.pattern = pattern_at(value, place); }},
    {"minItems", [](SchemaReader&, SchemaNode& node, const json& value,
                    const Place& place) { node.min_items = size_at(value, place); }},
    {"maxItems", [](SchemaReader&, SchemaNode& node, const json& value,
                    const Place& place) { node.max_items = size_at(value, place); }},
    {"items",
     [](SchemaReader& reader, SchemaNode& node, const json& value, const Place& place) {
       if (value.is_array())
         reject(place, "a schema for each element is not supported, only one for all elements");
       node.items = reader.schema(value, place);
     }},
    {"required",
     [](SchemaReader&, SchemaNode& node, const json& value, const Place& place) {
       expect(value.is_array(), place, "a list");
       for (std::size_t i = 0; i < value.size(); ++i)
         node.required.push_back(text_at(value[i], place / std::to_string(i)));
     }},
    {"properties",
     [](SchemaReader& reader, SchemaNode& node, const json& value, const Place& place) {
       for (const auto& property : object_at(value, place).items())
         node.properties.emplace(property.key(), reader.schema(property.value(), place / property.key()));
     }},
    {"additionalProperties",
     [](SchemaReader& reader, SchemaNode& node, const json& value, const Place& place) {
       node.additional_properties = reader.schema(value, place);
     }},
    {"oneOf",
     [](SchemaReader& reader, SchemaNode& node, const json& value, const Place& place) {
       for (std::size_t i = 0; i < list_at(value, place).size(); ++i)
         node.one_of.push_back(reader.schema(value[i], place / std::to_string(i)));
     }},
}};

void read_keyword(SchemaReader& reader, SchemaNode& node, const std::string& name, const json& value,
                  const Place& place) {
  if (std::ranges::count(kAnnotations, name) > 0) return;
  const auto keyword = std::ranges::find(kKeywords, name, &Keyword::name);
  if (keyword == kKeywords.end()) reject(place, "the keyword " + in_quotes(name) + " is not supported");
  keyword->read(reader, node, value, place);
}

// Returns the schemas that are also checked against the same value.
std::vector<const SchemaNode*> of_same_value(const SchemaNode& node) {
  std::vector<const SchemaNode*> next = node.one_of;
  if (node.reference != nullptr) next.push_back(node.reference);
  return next;
}

// Returns the schemas of the members that fill_defaults() adds to a new object. The references must have no
// cycle.
std::vector<const SchemaNode*> of_defaults(const SchemaNode& node) {
  std::vector<const SchemaNode*> next;
  for (const auto& [key, property] : node.followed().properties) {
    if (property->default_here() != nullptr) next.push_back(property);
  }
  return next;
}

// Finds cycles by a depth-first search. Recursion is bounded by the schema's size.
class CircleSearch {
 public:
  using Next = std::vector<const SchemaNode*> (*)(const SchemaNode&);
  explicit CircleSearch(Next next) : next_(next) {}

  bool finds_from(const SchemaNode& node) {
    if (done_.contains(&node)) return false;
    if (!open_.insert(&node).second) return true;
    for (const SchemaNode* next : next_(node)) {
      if (finds_from(*next)) return true;
    }
    open_.erase(&node);
    done_.insert(&node);
    return false;
  }

 private:
  Next next_;
  std::set<const SchemaNode*> open_, done_;
};

const SchemaNode* SchemaReader::schema(const json& value, const Place& place) {
  if (const auto known = by_place_.find(place); known != by_place_.end()) return known->second;
  SchemaNode& node = *nodes_.emplace_back(std::make_unique<SchemaNode>());
  by_place_.emplace(place, &node);
  expect(value.is_object() || value.is_boolean(), place, "a schema");
  node.is_false = value == false;
  if (!value.is_object()) return &node;
  for (const auto& member : value.items())
    read_keyword(*this, node, member.key(), member.value(), place / member.key());
  return &node;
}

const SchemaNode* SchemaReader::referred(const std::string& reference, const Place& place) {
  const std::size_t hash = std::min(reference.find('#'), reference.size());
  const std::string file = reference.substr(0, hash);
  const std::string pointer =
      percent_decoded(std::string_view(reference).substr(std::min(hash + 1, reference.size())), place);
  const bool is_other = other_ != nullptr && file == other_->name;
  const SchemaText* text = file.empty() ? place.text : is_other ? other_ : nullptr;
  if (text == nullptr) reject(place, "there is no schema " + in_quotes(file) + " to refer to");
  try {
    return schema(text->value.at(json::json_pointer(pointer)), {text, pointer});
  } catch (const json::exception&) {
    reject(place, "there is no " + in_quotes(reference) + " to refer to");
  }
}

SchemaNodes SchemaReader::read() {
  schema(text_.value, {&text_, ""});
  for (const auto next : {of_same_value, of_defaults}) {
    CircleSearch search(next);
    for (const auto& [place, node] : by_place_) {
      if (search.finds_from(*node)) reject(place, "this schema refers back to itself");
    }
  }
  return std::move(nodes_);
}

}  // namespace

SchemaNodes read_schema(const SchemaText& text, const SchemaText* other) {
  return SchemaReader(text, other).read();
}

}  // namespace contourd
