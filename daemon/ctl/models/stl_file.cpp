#include "daemon/ctl/models/stl_file.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstddef>
#include <system_error>

#include "daemon/ctl/terminal/exit_codes.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHeaderBytes = 80, kFacetBytes = 50;
constexpr std::size_t kFlushBytes = 1U << 16U;

void append_word(std::string& bytes, std::uint32_t word) {
  for (unsigned shift = 0; shift < 32; shift += 8)
    bytes += static_cast<char>((word >> shift) & 0xFFU);
}

std::string header(const std::string& what, std::size_t facets) {
  std::string bytes = what + " by contourctl";
  bytes.resize(kHeaderBytes, ' ');
  append_word(bytes, static_cast<std::uint32_t>(facets));
  return bytes;
}

void append_facet(std::string& bytes, const Facet& facet) {
  for (int zero = 0; zero < 3; ++zero)
    append_word(bytes, 0);
  for (const Vertex& vertex : facet.vertices) {
    for (const float coordinate : {vertex.x, vertex.y, vertex.z})
      append_word(bytes, std::bit_cast<std::uint32_t>(coordinate));
  }
  bytes.append(2, '\0');
}

}  // namespace

std::string binary_stl(std::span<const Facet> facets, const std::string& what) {
  std::string bytes = header(what, facets.size());
  bytes.reserve(bytes.size() + kFacetBytes * facets.size());
  for (const Facet& facet : facets)
    append_facet(bytes, facet);
  return bytes;
}

StlFile::StlFile(const fs::path& path, const std::string& what) : path_(path), bytes_(header(what, 0)) {
  std::error_code error;
  if (fs::exists(path, error) && !fs::is_regular_file(path, error)) fail("not a regular file");
  // A link to a file stays a link.
  if (const fs::path linked = fs::canonical(path, error); !error) path_ = linked;
  try {
    file_.emplace(path_.has_parent_path() ? path_.parent_path() : ".");
  } catch (const std::system_error& failure) {
    fail(failure.code().message());
  }
}

void StlFile::add(const Facet& facet) {
  append_facet(bytes_, facet);
  ++facets_;
  if (bytes_.size() >= kFlushBytes) flush();
}

void StlFile::appear() {
  flush();
  append_word(bytes_, facets_);
  try {
    file_->rewrite(kHeaderBytes, bytes_);
    file_->replace_for_now(path_.filename().string());
  } catch (const std::system_error& failure) {
    fail(failure.code().message());
  }
}

void StlFile::flush() {
  try {
    file_->write(bytes_);
  } catch (const std::system_error& failure) {
    fail(failure.code().message());
  }
  bytes_.clear();
}

void StlFile::fail(const std::string& why) const {
  throw OutputError(fmt::format("cannot write {}: {}", path_.string(), why));
}

}  // namespace contourd::ctl
