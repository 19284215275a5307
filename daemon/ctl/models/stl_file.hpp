// Binary STL files, as contourctl writes them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "core/geometry/facet.hpp"
#include "daemon/system/durable_file.hpp"

namespace contourd::ctl {

// Returns the bytes of a file with these facets. Its header says `what` they are, in up to 65 bytes. The
// normals are 0, because programs compute them from the facets. Pure; thread-safe.
[[nodiscard]] std::string binary_stl(std::span<const Facet> facets, const std::string& what);

// A file that is written facet by facet, and appears when it is complete. Functions throw OutputError; then
// no file appears, and an earlier one stays. Not thread-safe.
class StlFile {
 public:
  // Refuses a path to something else than a file.
  StlFile(const std::filesystem::path& path, const std::string& what);

  void add(const Facet& facet);
  [[nodiscard]] std::uint32_t facets() const { return facets_; }
  // Gives the file its name. Must be the last call.
  void appear();

 private:
  void flush();
  [[noreturn]] void fail(const std::string& why) const;

  std::filesystem::path path_;
  std::optional<NewFile> file_;
  std::string bytes_;
  std::uint32_t facets_ = 0;
};

}  // namespace contourd::ctl
