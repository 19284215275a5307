// Writes a zlib stream (RFC 1950) from runs of equal bytes: one deflate block (RFC 1951) whose only matches
// repeat the byte before. The Huffman code is the same for every stream and made for pictures with long runs
// of 0 and 255: 3 bits for 258 repeated bytes, 9 for most single ones. Takes time by the run, not by the
// byte.
//
// Deterministic. Not thread-safe; writes into the caller's buffer and only ever makes it larger.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/contract/expects.hpp"

namespace contourd {

class RunDeflater {
 public:
  // The length of the largest mask's stream, with a filter byte for each row.
  static constexpr std::size_t kMaxBytes = (std::size_t{1} << 28) + (std::size_t{1} << 14);

  // Starts a stream at out[at]. `out` must outlive the stream, and no one else may touch it before finish().
  void begin(std::vector<std::uint8_t>& out, std::size_t at);

  // Adds `count` equal bytes. REQUIRES: at most kMaxBytes in the stream.
  void add(std::uint8_t value, std::size_t count) {
    expects_costly([&] { return count_ + count <= kMaxBytes; }, "a stream has at most kMaxBytes");
    if (value != value_) {
      write_run();
      value_ = value;
      count_ = 0;
    }
    count_ += count;
  }

  // Ends the stream and returns its end in `out`, whose size may be larger.
  [[nodiscard]] std::size_t finish();

 private:
  // The bits not written yet, first bit lowest, and the place to write them.
  struct BitWriter {
    std::uint8_t* at;
    std::uint64_t bits;
    unsigned count;

    void put(std::uint32_t code, unsigned length);
    void put_rest();
  };

  void make_room(std::size_t size);
  void write_code_lengths();
  void write_run();
  void sum_run();

  std::vector<std::uint8_t>* out_ = nullptr;
  BitWriter writer_{};
  std::uint8_t value_ = 0;
  std::size_t count_ = 0;
  std::uint64_t sum_ = 1, sum_of_sums_ = 0;  // sums of Adler-32
};

}  // namespace contourd
