// Files of models in other formats than STL, for tests.
#pragma once

#include <fmt/format.h>
#include <zip.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/geometry/facet.hpp"
#include "tests/models/models.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::testing {

inline std::string stl_text(std::span<const Facet> facets) {
  const std::vector<std::byte> bytes = models::to_binary_stl(facets);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline std::string gzipped(std::string_view text) {
  constexpr int kGzipWindow = MAX_WBITS + 16;
  z_stream deflater{};
  if (deflateInit2(&deflater, 9, Z_DEFLATED, kGzipWindow, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("no deflater");
  std::string packed(deflateBound(&deflater, text.size()) + 64, '\0');
  deflater.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  deflater.avail_in = static_cast<uInt>(text.size());
  deflater.next_out = reinterpret_cast<Bytef*>(packed.data());
  deflater.avail_out = static_cast<uInt>(packed.size());
  const int result = deflate(&deflater, Z_FINISH);
  packed.resize(deflater.total_out);
  deflateEnd(&deflater);
  if (result != Z_STREAM_END) throw std::runtime_error("the text was not compressed");
  return packed;
}

struct PackedFile {
  std::string name, content;
  bool is_link = false;
  const char* password = nullptr;
};

inline std::string zipped(const std::vector<PackedFile>& files) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "made.zip").string();
  int error = 0;
  zip_t* const archive = zip_open(path.c_str(), ZIP_CREATE, &error);
  if (archive == nullptr) throw std::runtime_error("no archive");
  for (const PackedFile& file : files) {
    zip_source_t* const source = zip_source_buffer(archive, file.content.data(), file.content.size(), 0);
    const zip_int64_t index = zip_file_add(archive, file.name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) throw std::runtime_error("no entry");
    const auto at = static_cast<zip_uint64_t>(index);
    constexpr zip_uint32_t kLink = 0120777U << 16U;
    if (file.is_link) zip_file_set_external_attributes(archive, at, 0, ZIP_OPSYS_UNIX, kLink);
    if (file.password != nullptr) zip_file_set_encryption(archive, at, ZIP_EM_AES_256, file.password);
  }
  if (zip_close(archive) != 0) throw std::runtime_error("the archive was not written");
  std::ifstream written(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(written), {}};
}

// Returns an object of 3MF with these facets, whose vertices are shared.
inline std::string threemf_object(int id, std::span<const Facet> facets, std::string_view type = "model") {
  std::map<std::array<std::uint32_t, 3>, std::size_t> numbers;
  std::string vertices, triangles;
  for (const Facet& facet : facets) {
    std::array<std::size_t, 3> corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Vertex& vertex = facet.vertices[i];
      std::array<std::uint32_t, 3> bits{};
      std::memcpy(bits.data(), &vertex, sizeof vertex);
      const auto [at, is_new] = numbers.try_emplace(bits, numbers.size());
      corners[i] = at->second;
      if (is_new)
        vertices +=
            fmt::format("<vertex x=\"{:.9g}\" y=\"{:.9g}\" z=\"{:.9g}\"/>\n", vertex.x, vertex.y, vertex.z);
    }
    triangles +=
        fmt::format("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>\n", corners[0], corners[1], corners[2]);
  }
  return fmt::format(
      "<object id=\"{}\" "
      "type=\"{}\"><mesh><vertices>\n{}</vertices><triangles>\n{}</triangles></mesh></object>\n",
      id, type, vertices, triangles);
}

// Returns an object made of components, each `<component .../>`.
inline std::string threemf_assembly(int id, std::string_view components) {
  return fmt::format("<object id=\"{}\"><components>{}</components></object>\n", id, components);
}

// Returns a model file. `attributes` are those of the model's element, beside its namespaces.
inline std::string threemf_part(std::string_view objects, std::string_view items,
                                std::string_view attributes = "unit=\"millimeter\"") {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model {} "
      "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
      "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" "
      "xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\">\n"
      "<resources>\n{}</resources><build>{}</build></model>\n",
      attributes, objects, items);
}

// Returns the files of a package around the root model, for zipped().
inline std::vector<PackedFile> threemf_files(std::string root_model) {
  return {{"[Content_Types].xml", "<Types/>"},
          {"_rels/.rels",
           "<?xml version=\"1.0\"?><Relationships "
           "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship "
           "Target=\"/3D/3dmodel.model\" Id=\"rel-1\" "
           "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>"},
          {"3D/3dmodel.model", std::move(root_model)}};
}

inline std::string threemf_of(std::span<const Facet> facets) {
  return zipped(threemf_files(threemf_part(threemf_object(1, facets), "<item objectid=\"1\"/>")));
}

inline bool same_facets(std::span<const Facet> a, std::span<const Facet> b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

}  // namespace contourd::testing
