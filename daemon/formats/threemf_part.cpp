#include "daemon/formats/threemf_part.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "core/model/length_unit.hpp"
#include "core/model/model.hpp"
#include "daemon/formats/xml_reader.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

constexpr std::size_t kMostObjects = 100'000;
constexpr std::size_t kMostReferences = 1'000'000;  // components and items
constexpr std::size_t kMostPrefixes = 100;

// Names of elements and attributes (3MF Core Specification 1.4, Production Extension 1.1).
#define CONTOURD_3MF_CORE "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
#define CONTOURD_3MF_PRODUCTION "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
constexpr std::string_view kModel = CONTOURD_3MF_CORE "|model";
constexpr std::string_view kObject = CONTOURD_3MF_CORE "|object";
constexpr std::string_view kVertex = CONTOURD_3MF_CORE "|vertex";
constexpr std::string_view kTriangle = CONTOURD_3MF_CORE "|triangle";
constexpr std::string_view kComponent = CONTOURD_3MF_CORE "|component";
constexpr std::string_view kItem = CONTOURD_3MF_CORE "|item";
constexpr std::string_view kMetadata = CONTOURD_3MF_CORE "|metadata";
constexpr std::string_view kPath = CONTOURD_3MF_PRODUCTION "|path";
#undef CONTOURD_3MF_CORE

// Extensions that a file may require: they change no shape, or are read here.
constexpr std::array<std::string_view, 3> kKnownExtensions{
    CONTOURD_3MF_PRODUCTION, "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07"};
#undef CONTOURD_3MF_PRODUCTION

// Settings of Cura by which an object is no part of the model: metadata of the object with the value True.
struct CuraSetting {
  std::string_view name, kind;
};
constexpr std::array kCuraSettings{
    CuraSetting{"anti_overhang_mesh", "support blocker"}, CuraSetting{"support_mesh", "support"},
    CuraSetting{"infill_mesh", "modifier"}, CuraSetting{"cutting_mesh", "modifier"}};
constexpr std::size_t kLongestValue = 32;  // bytes of a setting's value that are compared

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

// Reads a number that is the whole text, apart from blanks around it. Returns false if it is not one.
template <typename Number>
bool parse_number(const char* text, Number& number) {
  if (text == nullptr) return false;
  const std::string_view all(text);
  const char* const end = all.data() + all.size();
  const auto [after, error] = std::from_chars(all.data(), end, number);
  if (error == std::errc{} && after == end) return true;
  std::string_view word = without_blanks(all);
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [last, problem] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (problem == std::errc::result_out_of_range && std::fabs(std::strtod(text, nullptr)) < 1) {
    number = 0;  // too small for the type
    return true;
  }
  return problem == std::errc{} && last == word.data() + word.size();
}

class PartReader : public XmlHandler {
 public:
  explicit PartReader(ThreeMfRoot root) : root_(root) {}

  void name_space(std::string_view prefix, std::string_view uri) override {
    if (prefixes_.size() < kMostPrefixes) prefixes_.insert_or_assign(std::string(prefix), std::string(uri));
  }

  void open(std::string_view name, const XmlAttributes& attributes) override {
    if (is_first_) {
      is_first_ = false;
      return open_model(name, attributes);
    }
    if (in_object_) {
      if (name == kTriangle) return add_triangle(attributes);
      if (name == kVertex) return add_vertex(attributes);
      if (name == kComponent) return add_component(attributes);
      if (name == kMetadata) return open_metadata(attributes);
    }
    if (name == kObject) return open_object(attributes);
    if (name == kItem) add_item(attributes);
  }

  void text(std::string_view text) override {
    if (!kind_.empty() && value_.size() < kLongestValue) value_ += text.substr(0, kLongestValue);
  }
  [[nodiscard]] bool wants_text() const override { return !kind_.empty(); }

  void close(std::string_view name) override {
    if (name == kMetadata && !kind_.empty()) {
      const std::string_view value = without_blanks(value_);
      if (value == "True" || value == "true" || value == "1") object_.kind = kind_;
      kind_.clear();
    }
    if (name != kObject || !in_object_) return;
    in_object_ = false;
    part_.numbers.emplace(object_.id, part_.objects.size());
    part_.objects.push_back(std::move(object_));
  }

  ThreeMfPart take() { return std::move(part_); }

 private:
  void open_model(std::string_view name, const XmlAttributes& attributes) {
    if (name != kModel) throw ModelError("it does not begin with a 3MF model: export the model again");
    const std::string_view unit = attributes.text("unit");
    const auto length = length_unit(unit.empty() ? "millimeter" : unit);
    if (!length)
      throw ModelError(fmt::format("its unit {} is unknown: export the model in mm", in_quotes(unit)));
    part_.unit = *length;
    std::string_view required = attributes.text("requiredextensions");
    while (!(required = without_blanks(required)).empty()) {
      const std::string prefix(required.substr(0, required.find_first_of(" \t\r\n")));
      required.remove_prefix(prefix.size());
      require_extension(prefix);
    }
  }

  void require_extension(const std::string& prefix) const {
    const auto declared = prefixes_.find(prefix);
    const std::string uri = declared == prefixes_.end() ? prefix : declared->second;
    if (std::ranges::find(kKnownExtensions, uri) == kKnownExtensions.end())
      throw ModelError(
          fmt::format("the model requires the 3MF extension \"{}\", which contourd does not read: "
                      "export the model as a mesh, or as STL",
                      printable(uri)));
  }

  void open_object(const XmlAttributes& attributes) {
    if (in_object_) throw ModelError("an object lies within another object: export the model again");
    if (part_.objects.size() == kMostObjects)
      throw ModelError(fmt::format("it has more than {} objects: export fewer", kMostObjects));
    object_ = {};
    object_.id = number_of(attributes, "id", "an object");
    const std::string_view type = attributes.text("type");
    object_.type = type.empty() ? "model" : type.substr(0, 32);
    if (part_.numbers.contains(object_.id))
      throw ModelError(fmt::format("two objects have the id {}: export the model again", object_.id));
    in_object_ = true;
  }

  // The name is "cura:SETTING", whatever the prefix of Cura's namespace is, or the setting alone.
  void open_metadata(const XmlAttributes& attributes) {
    const std::string_view name = attributes.text("name");
    const std::string_view setting = name.substr(name.find(':') + 1);
    const auto* const found = std::ranges::find(kCuraSettings, setting, &CuraSetting::name);
    if (found == kCuraSettings.end()) return;
    kind_ = found->kind;
    value_.clear();
  }

  void add_vertex(const XmlAttributes& attributes) {
    Vertex vertex{};
    if (!parse_number(attributes.find("x"), vertex.x) || !parse_number(attributes.find("y"), vertex.y) ||
        !parse_number(attributes.find("z"), vertex.z) || !std::isfinite(vertex.x) ||
        !std::isfinite(vertex.y) || !std::isfinite(vertex.z))
      throw ModelError(
          fmt::format("vertex {} of object {} is not three finite numbers: export the model again",
                      object_.vertices.size(), object_.id));
    object_.vertices.push_back(vertex);
  }

  void add_triangle(const XmlAttributes& attributes) {
    std::array<std::uint32_t, 3> corners{};
    if (!parse_number(attributes.find("v1"), corners[0]) ||
        !parse_number(attributes.find("v2"), corners[1]) ||
        !parse_number(attributes.find("v3"), corners[2]) ||
        std::ranges::max(corners) >= object_.vertices.size())
      throw ModelError(
          fmt::format("triangle {} of object {} does not name three of the {} vertices: export the "
                      "model again",
                      object_.triangles.size(), object_.id, object_.vertices.size()));
    object_.triangles.push_back(corners);
    object_.has_geometry = true;
  }

  void add_component(const XmlAttributes& attributes) {
    object_.components.push_back(reference_in(attributes, "a component"));
    object_.has_geometry = true;
    const ThreeMfReference& made = object_.components.back();
    // Each object is made of earlier ones, so that no object contains itself.
    if (made.path.empty() && !part_.numbers.contains(made.object))
      throw ModelError(
          fmt::format("a component of object {} is object {}, which does not come before it: export "
                      "the model again",
                      object_.id, made.object));
  }

  void add_item(const XmlAttributes& attributes) {
    ThreeMfReference item = reference_in(attributes, "an item");
    const std::string_view printable = attributes.text("printable");
    if (printable == "0" || printable == "false")
      ++part_.not_printable;
    else
      part_.items.push_back(std::move(item));
  }

  ThreeMfReference reference_in(const XmlAttributes& attributes, std::string_view what) {
    if (++references_ > kMostReferences)
      throw ModelError(fmt::format("it has more than {} components and items", kMostReferences));
    ThreeMfReference reference;
    reference.object = number_of(attributes, "objectid", what);
    if (const char* const transform = attributes.find("transform"))
      reference.transform = parse_transform(transform);
    if (const char* const path = attributes.find(kPath)) {
      if (root_ == ThreeMfRoot::No)
        throw ModelError(
            fmt::format("{} is in another file, {}, which only the root model may say: export the "
                        "model again",
                        what, in_quotes(path)));
      reference.path = path[0] == '/' ? path + 1 : path;
      if (reference.path.empty()) throw ModelError(fmt::format("the path of {} is empty", what));
    }
    return reference;
  }

  [[nodiscard]] static std::uint32_t number_of(const XmlAttributes& attributes, const char* name,
                                               std::string_view what) {
    std::uint32_t number = 0;
    if (!parse_number(attributes.find(name), number))
      throw ModelError(fmt::format("the {} of {} is not a number: export the model again", name, what));
    return number;
  }

  ThreeMfRoot root_;
  ThreeMfPart part_;
  ThreeMfObject object_;  // is being read
  bool in_object_ = false, is_first_ = true;
  std::size_t references_ = 0;
  std::string kind_, value_;  // of the metadata that is being read; empty if it does not matter
  std::map<std::string, std::string> prefixes_;  // URIs of namespaces, by prefix
};

}  // namespace

ThreeMfPart read_threemf_part(ByteStream& stream, const std::string& name, ThreeMfRoot root) {
  PartReader reader(root);
  read_xml(stream, reader, name);
  return reader.take();
}

}  // namespace contourd
