// An upload of a picture in pieces, because a message is short. There is one upload at a time; an upload from
// another connection replaces it. Event loop's thread only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace contourd {

class PictureUpload {
 public:
  // `most`: maximum size of a picture in bytes.
  explicit PictureUpload(std::size_t most) : most_(most) {}

  // Appends the piece at `from`; 0 starts a new upload. Returns the number of bytes so far. Throws
  // ControlRefusal if the piece does not continue this connection's upload, or if the picture becomes too
  // large.
  std::size_t add(std::uint64_t connection, std::size_t from, std::span<const std::uint8_t> piece);
  // Returns the connection's upload and forgets it. Throws ControlRefusal if there is none.
  [[nodiscard]] std::vector<std::uint8_t> take(std::uint64_t connection);
  // Forgets the upload of a closed connection.
  void drop(std::uint64_t connection);

 private:
  std::size_t most_;
  std::uint64_t connection_ = 0;  // 0: none
  std::vector<std::uint8_t> bytes_;
};

}  // namespace contourd
