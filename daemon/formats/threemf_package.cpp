#include "daemon/formats/threemf_package.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "core/model/stray_facets.hpp"
#include "daemon/formats/input_limits.hpp"
#include "daemon/formats/threemf_facets.hpp"
#include "daemon/formats/threemf_part.hpp"
#include "daemon/formats/threemf_side_files.hpp"
#include "daemon/formats/xml_reader.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

constexpr const char* kRelationships = "_rels/.rels";
// Bytes of XML that a facet takes, with its share of the vertices. Slicers write about 60.
constexpr std::uint64_t kXmlBytesPerFacet = 50;

std::string name_in_messages(const std::string& entry) {
  return in_quotes(entry) + " in the 3MF file";
}

std::string in_lower_case(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return text;
}

// Returns the text with its percent-encoded bytes decoded: "a b" of "a%20b".
std::string percent_decoded(std::string_view text) {
  std::string decoded;
  for (; !text.empty(); text.remove_prefix(1)) {
    const char* const digits = text.data() + 1;
    unsigned byte = 0;
    if (text.size() > 2 && text.front() == '%' &&
        std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
      decoded += static_cast<char>(byte);
      text.remove_prefix(2);
    } else {
      decoded += text.front();
    }
  }
  return decoded;
}

// Returns what equivalent names have in common (Open Packaging Conventions, ECMA-376 part 2, 6.2.2): names
// are compared without regard to ASCII case, and may be percent-encoded.
std::string common_name(std::string_view name) {
  return in_lower_case(percent_decoded(name));
}

bool is_model_name(std::string_view name) {
  return common_name(name).ends_with(".model");
}

// Returns the entry of this name, or else one of an equivalent name; nullptr if there is none.
const ZipEntry* find_part(const ZipArchive& archive, std::string_view name) {
  if (const ZipEntry* const exact = archive.find(name)) return exact;
  const auto& entries = archive.entries();
  const auto found = std::ranges::find(entries, common_name(name),
                                       [](const ZipEntry& entry) { return common_name(entry.name); });
  return found == entries.end() ? nullptr : &*found;
}

const ZipEntry& existing_part(const ZipArchive& archive, const std::string& name) {
  const ZipEntry* const entry = find_part(archive, name);
  if (entry == nullptr)
    throw ModelError(fmt::format("the 3MF file lacks {}: export the model again", in_quotes(name)));
  return *entry;
}

// Opens an entry of the package that must exist.
std::unique_ptr<ByteStream> open_entry(const ZipArchive& archive, const std::string& name) {
  return archive.open(existing_part(archive, name));
}

// Opens an entry that describes the package: relationships or a program's side file.
std::unique_ptr<ByteStream> open_description(const ZipArchive& archive, const std::string& name) {
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 24U;
  std::unique_ptr<ByteStream> stream = open_entry(archive, name);
  if (stream->bytes() > kMostBytes)
    throw ModelError(fmt::format("{} has {} bytes, and the limit is {}: export the model again",
                                 name_in_messages(name), stream->bytes(), kMostBytes));
  return stream;
}

// Finds the root model's path in the package's relationships (Open Packaging Conventions).
class RelationshipReader : public XmlHandler {
 public:
  void open(std::string_view name, const XmlAttributes& attributes) override {
    if (!name.ends_with("|Relationship")) return;
    if (attributes.text("Type") != "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel") return;
    root_ = attributes.text("Target");
    if (root_.starts_with('/')) root_.erase(0, 1);
  }
  [[nodiscard]] const std::string& root() const { return root_; }

 private:
  std::string root_;
};

std::string root_of(const ZipArchive& archive) {
  RelationshipReader reader;
  read_xml(*open_description(archive, kRelationships), reader, name_in_messages(kRelationships));
  if (reader.root().empty())
    throw ModelError("the 3MF file names no model in _rels/.rels: export the model again");
  return existing_part(archive, reader.root()).name;
}

// Returns the bytes of XML that the package's model files hold. Throws ModelError if they are too many.
std::uint64_t model_bytes_of(const ZipArchive& archive) {
  InflatedSize all{0, 0};
  std::set<std::string_view> names;
  for (const ZipEntry& entry : archive.entries()) {
    if (!is_model_name(entry.name)) continue;
    if (!names.insert(entry.name).second)
      throw ModelError(
          fmt::format("the 3MF file holds {} twice: export the model again", in_quotes(entry.name)));
    refuse_inflation({entry.compressed, entry.inflated}, name_in_messages(entry.name));
    all = {all.compressed + entry.compressed, all.inflated + entry.inflated};
    refuse_inflation(all, "the 3MF file");
  }
  return all.inflated;
}

// Reads a file of the model, whose size model_bytes_of() has counted.
ThreeMfPart read_part(const ZipArchive& archive, const std::string& name, ThreeMfRoot root) {
  if (!is_model_name(name))
    throw ModelError(
        fmt::format("the 3MF file names {} as a model file, whose name must end in .model: export "
                    "the model again",
                    in_quotes(name)));
  return read_threemf_part(*open_entry(archive, name), name_in_messages(name), root);
}

ThreeMfModel read_parts(const ZipArchive& archive, const std::string& root) {
  ThreeMfModel model{{}, root};
  ThreeMfPart part = read_part(archive, root, ThreeMfRoot::Yes);
  // Names of entries, by themselves and by what equivalent names have in common: a million references may
  // spell ten thousand names in different ways.
  std::map<std::string, std::string> names;
  for (const ZipEntry& entry : archive.entries())
    names.emplace(entry.name, entry.name);
  for (const ZipEntry& entry : archive.entries())
    names.emplace(common_name(entry.name), entry.name);
  // Reads the reference's file, and sets its path to the name of the entry.
  const auto read_other = [&](ThreeMfReference& reference) {
    if (reference.path.empty()) return;
    auto found = names.find(reference.path);
    if (found == names.end()) found = names.find(common_name(reference.path));
    if (found != names.end()) reference.path = found->second;
    const std::string& path = reference.path;
    if (path == root || model.parts.contains(path)) return;
    model.parts.emplace(path, read_part(archive, path, ThreeMfRoot::No));
  };
  for (ThreeMfReference& item : part.items)
    read_other(item);
  for (ThreeMfObject& object : part.objects)
    for (ThreeMfReference& component : object.components)
      read_other(component);
  model.parts.emplace(root, std::move(part));
  return model;
}

// Returns a sentence about the meshes that are left out; empty if there are none.
std::string left_out_sentence(const std::map<std::string, std::size_t>& kinds) {
  std::string text;
  for (const auto& [kind, count] : kinds)
    text += (text.empty() ? "" : ", ") + count_of(count, kind, kind + "s");
  if (text.empty()) return "";
  return fmt::format("left out, as the file's slicer says that they are no part of the model: {}{}", text,
                     kinds.contains("negative part") ? "; the space of a negative part is printed" : "");
}

}  // namespace

bool is_threemf(const ZipArchive& archive) {
  return find_part(archive, "[Content_Types].xml") != nullptr &&
         find_part(archive, kRelationships) != nullptr;
}

ThreeMfPackage::ThreeMfPackage(const ZipArchive& archive) : archive_(archive), root_(root_of(archive)) {
  const std::uint64_t bytes = model_bytes_of(archive_);
  (void)open_entry(archive_, root_);
  outline_ = {.format = "3mf",
              .most_facets = bytes / kXmlBytesPerFacet,
              .exact = false,
              // The vertices and the triangles before they become facets.
              .buffered_bytes = bytes / kXmlBytesPerFacet * (sizeof(Vertex) + 3 * sizeof(std::uint32_t))};
}

Model ThreeMfPackage::read(std::uint64_t most_facets) const {
  ThreeMfModel model = read_parts(archive_, root_);
  std::map<std::string, std::size_t> kinds = leave_out_kinds(model);
  for (const char* const name : {kPrusaSideFile, kBambuSideFile}) {
    if (find_part(archive_, name) == nullptr) continue;
    const ThreeMfSideFile side_file =
        read_threemf_side_file(*open_description(archive_, name), name_in_messages(name));
    for (const auto& [kind, count] : leave_out(model, side_file))
      kinds[kind] += count;
  }
  Model made = facets_of(model, most_facets);
  if (std::string sentence = left_out_sentence(kinds); !sentence.empty())
    made.warnings.push_back(std::move(sentence));
  drop_stray_facets(made);
  return made;
}

}  // namespace contourd
