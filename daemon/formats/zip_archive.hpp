// A ZIP archive, opened for reading. Used by one thread.
#pragma once

#include <zip.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/formats/byte_stream.hpp"

namespace contourd {

// A file in an archive.
struct ZipEntry {
  std::string name;  // in UTF-8, with its folders, as in the archive
  std::uint64_t index = 0;
  std::uint64_t compressed = 0, inflated = 0;  // bytes, as the archive claims
  // Why the entry cannot be read, a clause that follows its name; empty if it can.
  std::string fault{};
};

// True if a file with these first bytes is a ZIP archive.
[[nodiscard]] bool is_zip(std::span<const std::byte> start);

class ZipArchive {
 public:
  // Reads the list of entries. `file` is read through a descriptor of the archive's own and must have `bytes`
  // bytes; `path` is its name in messages. Throws ModelError if the archive is damaged or has more than
  // 10,000 entries, std::system_error if it cannot be read.
  ZipArchive(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path);

  // The files of the archive, in its order, without folders.
  [[nodiscard]] const std::vector<ZipEntry>& entries() const { return entries_; }
  // Returns the entry of this name, or nullptr. ZIP names are case-sensitive.
  [[nodiscard]] const ZipEntry* find(std::string_view name) const;
  // Size of the archive's file.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  // Opens an entry; several may be open at the same time. The archive must outlive the stream. Throws
  // ModelError if the entry is encrypted or damaged, or becomes larger than refuse_inflation() allows.
  [[nodiscard]] std::unique_ptr<ByteStream> open(const ZipEntry& entry) const;

 private:
  struct Discard {
    void operator()(zip_t* archive) const { zip_discard(archive); }
  };

  void list_entries();

  std::uint64_t bytes_;
  std::unique_ptr<zip_t, Discard> archive_;
  std::vector<ZipEntry> entries_;
};

}  // namespace contourd
