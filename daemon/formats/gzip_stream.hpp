// A file that gzip compressed (RFC 1952), inflated while it is read. Used by one thread.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "daemon/formats/byte_stream.hpp"

namespace contourd {

// True if a file with these first bytes is a gzip archive.
[[nodiscard]] bool is_gzip(std::span<const std::byte> start);

class GzipStream : public ByteStream {
 public:
  // Reads the size that the file claims from its end, or unpacks the file for it if zeros may follow the
  // archive: gzip(1) ignores them, too. `file` is at its beginning, has `bytes` bytes and must
  // outlive the stream; `path` is its name in messages. Throws ModelError if the file is damaged, or if the
  // size exceeds the limits of refuse_inflation(), std::system_error if the file cannot be read.
  GzipStream(std::FILE* file, std::uint64_t bytes, std::filesystem::path path);
  ~GzipStream() override;

  [[nodiscard]] std::uint64_t bytes() const override { return inflated_bytes_; }
  std::size_t read_some(std::span<std::byte> into) override;

 private:
  // Opens a file whose size when it is unpacked is known, or does not matter.
  GzipStream(std::FILE* file, std::uint64_t bytes, std::filesystem::path path, std::uint64_t inflated);
  // Returns the size of the file when it is unpacked, and leaves the file at its beginning.
  static std::uint64_t size_of(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path);

  void fill();
  // Throws DamagedStream if anything but zeros follows the archive.
  void skip_padding();

  std::FILE* file_;
  std::uint64_t left_;  // compressed bytes that are not read yet
  std::filesystem::path path_;
  std::uint64_t inflated_bytes_ = 0;
  std::vector<std::byte> compressed_;
  z_stream inflater_{};
  bool ended_ = false;
};

}  // namespace contourd
