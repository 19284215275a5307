// A picture that comes in pieces, as a message is short: one at a time, of one connection. Another's takes
// its place. Event loop's thread only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace contourd {

class PictureUpload {
 public:
  // `most`: bytes of a picture.
  explicit PictureUpload(std::size_t most) : most_(most) {}

  // The piece at `from`; at 0 it begins anew. Returns how many bytes are there. Throws ControlRefusal when it
  // does not continue what is there of that connection, or the picture becomes too large.
  std::size_t add(std::uint64_t connection, std::size_t from, std::span<const std::uint8_t> piece);
  // All of that connection's, which is gone then. Throws ControlRefusal when there is nothing.
  [[nodiscard]] std::vector<std::uint8_t> take(std::uint64_t connection);
  // That connection is no more.
  void drop(std::uint64_t connection);

 private:
  std::size_t most_;
  std::uint64_t connection_ = 0;  // 0: none
  std::vector<std::uint8_t> bytes_;
};

}  // namespace contourd
