#include "daemon/formats/amf_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/model/length_unit.hpp"
#include "core/model/stray_facets.hpp"
#include "daemon/formats/threemf_transform.hpp"
#include "daemon/formats/xml_reader.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

constexpr std::size_t kMostAmfNodes = 100'000;        // objects and constellations
constexpr std::size_t kMostAmfInstances = 1'000'000;  // in the file, and when all of them are placed
constexpr unsigned kMostAmfDepth = 32;                // constellations within constellations
constexpr std::size_t kLongestAmfText = 64;           // of a number or an id
// Bytes of XML that a facet takes: <triangle><v1>0</v1><v2>1</v2><v3>2</v3></triangle>
constexpr std::uint64_t kAmfBytesPerFacet = 50;

// A placed object or constellation: an instance of it.
struct Instance {
  std::string id;
  std::array<double, 3> shift{},
      turn{};  // in the file's unit; in degrees or radians, about x, then y, then z
  // By Slic3r and its successors, which mirror and scale before they turn.
  std::array<double, 3> scale{1, 1, 1}, mirror{1, 1, 1};
  bool is_printed = true;
};

// An object, which has triangles, or a constellation, which has instances.
struct Node {
  std::string id;
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Instance> instances;
};

struct AmfFile {
  LengthUnit unit = LengthUnit::Millimeter;
  bool turns_in_radians = false;  // as Slic3r and its successors write them, against the standard
  std::vector<Node> nodes;
  std::size_t curved = 0, modifiers = 0, not_printed = 0;
};

template <typename Number>
std::optional<Number> number_in(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
  text = text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
  if (text.starts_with('+')) text.remove_prefix(1);
  Number number{};
  const auto [after, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || after != text.data() + text.size() || text.empty()) return std::nullopt;
  return number;
}

class AmfReader : public XmlHandler {
 public:
  void open(std::string_view name, const XmlAttributes& attributes) override {
    text_.clear();
    if (std::exchange(is_first_, false)) return open_amf(name, attributes);
    if (name == "object" || name == "constellation") return open_node(attributes);
    if (name == "metadata") metadata_ = attributes.text("type").substr(0, kLongestAmfText);
    if (node_ == nullptr) return;
    if (name == "vertex") {
      in_vertex_ = true;
      given_ = 0;
    } else if (name == "edge") {
      ++file_.curved;
    } else if (name == "normal" && in_vertex_) {
      is_curved_ = true;
    } else if (name == "volume") {
      first_of_volume_ = node_->triangles.size();
      is_modifier_ = false;
    } else if (name == "triangle") {
      in_triangle_ = true;
      given_ = 0;
    } else if (name == "instance") {
      open_instance(attributes);
    }
  }

  void text(std::string_view text) override {
    if (text_.size() <= kLongestAmfText) text_ += text.substr(0, kLongestAmfText + 1);
  }

  void close(std::string_view name) override {
    if (name == "metadata") return close_metadata();
    if (node_ == nullptr) return;
    if (in_vertex_) {
      close_in_vertex(name);
    } else if (in_triangle_) {
      close_in_triangle(name);
    } else if (in_instance_) {
      close_in_instance(name);
    } else if (name == "volume" && is_modifier_) {
      node_->triangles.resize(first_of_volume_);
      ++file_.modifiers;
    } else if (name == "object" || name == "constellation") {
      node_ = nullptr;
    }
    text_.clear();
  }

  [[nodiscard]] bool wants_text() const override { return true; }
  AmfFile take() {
    if (is_curved_) ++file_.curved;
    return std::move(file_);
  }

 private:
  void open_amf(std::string_view name, const XmlAttributes& attributes) {
    if (name != "amf") throw ModelError("it does not begin with an AMF model: export the model again");
    std::string_view unit = attributes.text("unit");
    if (unit.empty()) unit = "millimeter";
    const auto length = length_unit(unit == "feet" ? "foot" : unit);
    if (!length)
      throw ModelError(fmt::format("its unit {} is unknown: export the model in mm", in_quotes(unit)));
    file_.unit = *length;
  }

  void open_node(const XmlAttributes& attributes) {
    if (node_ != nullptr) throw ModelError("an object lies within another object: export the model again");
    if (file_.nodes.size() == kMostAmfNodes)
      throw ModelError(fmt::format("it has more than {} objects: export fewer", kMostAmfNodes));
    node_ = &file_.nodes.emplace_back();
    node_->id = attributes.text("id").substr(0, kLongestAmfText);
    in_vertex_ = in_triangle_ = in_instance_ = is_modifier_ = false;
  }

  void open_instance(const XmlAttributes& attributes) {
    if (++instances_ > kMostAmfInstances)
      throw ModelError(fmt::format("it has more than {} instances: export fewer", kMostAmfInstances));
    node_->instances.push_back({std::string(attributes.text("objectid").substr(0, kLongestAmfText))});
    const std::string_view printed = attributes.text("printable");
    if (printed == "0" || printed == "false") node_->instances.back().is_printed = false;
    in_instance_ = true;
  }

  void close_metadata() {
    // The programs that grew from Slic3r.
    if (node_ == nullptr && metadata_ == "cad") file_.turns_in_radians = text_.starts_with("Slic3r");
    if (metadata_ == "slic3r.modifier" && text_ == "1") is_modifier_ = true;
    if (metadata_ == "slic3r.volume_type" && text_ != "ModelPart") is_modifier_ = true;
    text_.clear();
  }

  void close_in_vertex(std::string_view name) {
    if (name == "vertex") {
      in_vertex_ = false;
      if (given_ != 7) throw ModelError("a vertex has not x, y and z: export the model again");
      node_->vertices.push_back(vertex_);
      return;
    }
    if (name.size() != 1 || name[0] < 'x' || name[0] > 'z') return;
    const auto number = number_in<float>(text_);
    if (!number || !std::isfinite(*number))
      throw ModelError(
          fmt::format("vertex {} of object {} is not three finite numbers: export the model again",
                      node_->vertices.size(), in_quotes(node_->id)));
    (name[0] == 'x' ? vertex_.x : name[0] == 'y' ? vertex_.y : vertex_.z) = *number;
    given_ |= 1U << static_cast<unsigned>(name[0] - 'x');
  }

  void close_in_triangle(std::string_view name) {
    if (name == "triangle") {
      in_triangle_ = false;
      if (given_ != 7) throw ModelError("a triangle has not v1, v2 and v3: export the model again");
      node_->triangles.push_back(triangle_);
      return;
    }
    if (name.size() != 2 || name[0] != 'v' || name[1] < '1' || name[1] > '3') return;
    const auto number = number_in<std::uint32_t>(text_);
    if (!number || *number >= node_->vertices.size())
      throw ModelError(fmt::format(
          "triangle {} of object {} does not name three of the {} vertices: export the model again",
          node_->triangles.size(), in_quotes(node_->id), node_->vertices.size()));
    const auto corner = static_cast<std::size_t>(name[1] - '1');
    triangle_[corner] = *number;
    given_ |= 1U << corner;
  }

  void close_in_instance(std::string_view name) {
    if (name == "instance") {
      in_instance_ = false;
      return;
    }
    Instance& instance = node_->instances.back();
    if (name == "printable") {
      instance.is_printed = text_ != "0";
      return;
    }
    std::array<double, 3>* const figures = name.starts_with("delta")    ? &instance.shift
                                           : name.starts_with("r")      ? &instance.turn
                                           : name.starts_with("scale")  ? &instance.scale
                                           : name.starts_with("mirror") ? &instance.mirror
                                                                        : nullptr;
    if (figures == nullptr) return;
    const auto number = number_in<double>(text_);
    if (!number || !std::isfinite(*number))
      throw ModelError(
          fmt::format("{} of an instance is not a finite number: export the model again", in_quotes(name)));
    if (name == "scale") {
      figures->fill(*number);
    } else if (name.back() >= 'x' && name.back() <= 'z') {
      (*figures)[static_cast<std::size_t>(name.back() - 'x')] = *number;
    }
  }

  AmfFile file_;
  Node* node_ = nullptr;  // is being read
  Vertex vertex_{};
  std::array<std::uint32_t, 3> triangle_{};
  unsigned given_ = 0;  // bits of the coordinates or corners that were given
  bool is_first_ = true, in_vertex_ = false, in_triangle_ = false, in_instance_ = false;
  bool is_modifier_ = false, is_curved_ = false;
  std::size_t first_of_volume_ = 0, instances_ = 0;
  std::string text_, metadata_;
};

// Returns the map that an instance makes.
ThreeMfTransform transform_of(const Instance& instance, bool radians) {
  ThreeMfTransform all;
  for (std::size_t axis = 0; axis < 3; ++axis)
    all.m[4 * axis] = instance.mirror[axis] < 0 ? -instance.scale[axis] : instance.scale[axis];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (instance.turn[axis] == 0) continue;
    const double angle = radians ? instance.turn[axis] : instance.turn[axis] * std::numbers::pi / 180;
    const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
    ThreeMfTransform turn;
    turn.m[4 * b] = turn.m[4 * c] = std::cos(angle);
    turn.m[3 * b + c] = std::sin(angle);
    turn.m[3 * c + b] = -std::sin(angle);
    all = combined(all, turn);
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    all.m[9 + axis] = instance.shift[axis];
  return all;
}

class AmfExpansion {
 public:
  AmfExpansion(AmfFile& file, std::uint64_t most_facets) : file_(file), most_facets_(most_facets) {
    for (std::size_t i = 0; i < file.nodes.size(); ++i)
      if (!numbers_.emplace(file.nodes[i].id, i).second)
        throw ModelError(fmt::format("two objects of the AMF model have the id {}: export the model again",
                                     in_quotes(file.nodes[i].id)));
  }

  Model run() {
    std::vector<bool> is_placed(file_.nodes.size());
    for (const Node& node : file_.nodes)
      for (const Instance& instance : node.instances)
        is_placed[number_of(instance)] = true;
    ThreeMfTransform to_mm;
    to_mm.m[0] = to_mm.m[4] = to_mm.m[8] = millimeters_in(file_.unit);
    for (std::size_t i = 0; i < file_.nodes.size(); ++i)
      if (!is_placed[i]) place(i, to_mm, 1);
    if (placed_ == 0 && !file_.nodes.empty())
      throw ModelError("all constellations of the AMF model contain themselves: export the model again");
    return std::move(made_);
  }

 private:
  [[nodiscard]] std::size_t number_of(const Instance& instance) const {
    const auto found = numbers_.find(instance.id);
    if (found == numbers_.end())
      throw ModelError(
          fmt::format("the AMF model places object {}, which does not exist: export the model again",
                      in_quotes(instance.id)));
    return found->second;
  }

  void place(std::size_t number, const ThreeMfTransform& transform, unsigned depth) {
    if (depth > kMostAmfDepth)
      throw ModelError(
          fmt::format("constellations of the AMF model are nested more than {} levels deep, or contain "
                      "themselves: export the model again",
                      kMostAmfDepth));
    if (++placed_ > kMostAmfInstances)
      throw ModelError(
          fmt::format("the AMF model places more than {} objects: export it as one mesh", kMostAmfInstances));
    const Node& node = file_.nodes[number];
    add_mesh(node, transform);
    for (const Instance& instance : node.instances) {
      const ThreeMfTransform own = transform_of(instance, file_.turns_in_radians);
      if (!instance.is_printed)
        ++file_.not_printed;
      else
        place(number_of(instance), combined(own, transform), depth + 1);
    }
  }

  void add_mesh(const Node& node, const ThreeMfTransform& transform) {
    if (node.triangles.size() > most_facets_ - made_.facets.size())
      throw ModelError(fmt::format(
          "the AMF model's copies come to more facets than there is room for ({}): print fewer copies, "
          "or simplify the model",
          most_facets_));
    if (node.triangles.empty()) return;
    const double determinant = transform.determinant();
    if (determinant == 0)
      throw ModelError(fmt::format(
          "an instance of the AMF model makes object {} flat: export the model again", in_quotes(node.id)));
    const bool is_identity = transform == ThreeMfTransform{};
    const auto at = [&](std::uint32_t corner) {
      return is_identity ? node.vertices[corner] : transform(node.vertices[corner]);
    };
    for (const auto& [v1, v2, v3] : node.triangles) {
      made_.facets.push_back({{at(v1), at(determinant < 0 ? v3 : v2), at(determinant < 0 ? v2 : v3)}});
      if (!is_finite(made_.facets.back()))
        throw ModelError(fmt::format("object {} of the AMF model leaves the range of numbers by its instance",
                                     in_quotes(node.id)));
    }
  }

  AmfFile& file_;
  std::uint64_t most_facets_;
  std::map<std::string_view, std::size_t> numbers_;
  std::size_t placed_ = 0;
  Model made_;
};

}  // namespace

bool is_amf(const FileStart& start) {
  const std::string_view text(reinterpret_cast<const char*>(start.bytes.data()), start.bytes.size());
  const std::size_t begin = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (begin == std::string_view::npos) return false;
  const std::size_t root = text.find("<amf");
  const std::string_view xml = text.substr(begin);
  const bool has_prolog = xml.starts_with("<?xml") || xml.starts_with("<!--");
  // A comment that fills the first bytes hides what the file is; few other models begin with one.
  const std::size_t comment = xml.rfind("<!--");
  const bool is_hidden = comment != std::string_view::npos &&
                         xml.find("-->", comment) == std::string_view::npos &&
                         start.bytes.size() < start.file_bytes;
  return root == begin || (has_prolog && (root != std::string_view::npos || is_hidden));
}

ModelOutline amf_outline(std::uint64_t bytes) {
  return {.format = "amf",
          .most_facets = bytes / kAmfBytesPerFacet,
          .exact = false,
          .buffered_bytes = bytes / kAmfBytesPerFacet * (sizeof(Vertex) + 3 * sizeof(std::uint32_t))};
}

Model read_amf(ByteStream& stream, const std::string& name, std::uint64_t most_facets) {
  AmfReader reader;
  read_xml(stream, reader, name);
  AmfFile file = reader.take();
  Model made = AmfExpansion(file, most_facets).run();
  made.unit = file.unit;
  if (file.curved > 0)
    made.warnings.push_back(
        "the AMF file has curved triangles, which are read as flat ones: export it as a finer mesh");
  if (file.modifiers > 0)
    made.warnings.push_back(
        "left out, as the file's slicer says that they are no part of the model: modifiers");
  if (file.not_printed > 0) made.warnings.push_back("the file marks some objects as not printable: left out");
  drop_stray_facets(made);
  return made;
}

}  // namespace contourd
