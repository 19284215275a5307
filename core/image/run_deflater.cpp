#include "core/image/run_deflater.hpp"

#include <algorithm>
#include <array>

namespace contourd {
namespace {

// A Huffman code, whose first bit is the lowest.
struct Code {
  std::uint16_t bits;
  std::uint8_t length;
};

// Returns the canonical code of these lengths (RFC 1951, 3.2.2).
template <std::size_t kSymbols>
constexpr std::array<Code, kSymbols> codes_of(const std::array<std::uint8_t, kSymbols>& lengths) {
  std::array<Code, kSymbols> codes{};
  unsigned next = 0;
  for (std::uint8_t length = 1; length < 16; ++length) {
    next <<= 1;
    for (std::size_t symbol = 0; symbol < kSymbols; ++symbol) {
      if (lengths[symbol] != length) continue;
      unsigned reversed = 0;
      for (unsigned bit = 0; bit < length; ++bit)
        reversed |= (next >> bit & 1U) << (length - 1U - bit);
      codes[symbol] = {static_cast<std::uint16_t>(reversed), length};
      ++next;
    }
  }
  return codes;
}

// True if every sequence of bits can be decoded.
template <std::size_t kSymbols>
constexpr bool is_complete(const std::array<std::uint8_t, kSymbols>& lengths) {
  unsigned share = 0;
  for (const std::uint8_t length : lengths)
    share += length == 0 ? 0U : 1U << (15 - length);
  return share == 1U << 15;
}

constexpr std::size_t kEndOfBlock = 256, kFirstLength = 257, kLongest = 285;
constexpr std::size_t kLongestMatch = 258, kShortestMatch = 3;

// Code lengths of the literals and of the classes of match lengths, in bits.
constexpr std::array<std::uint8_t, 286> kLengths = [] {
  std::array<std::uint8_t, 286> lengths{};
  lengths.fill(9);
  lengths[0] = lengths[255] = 4;
  lengths[128] = 8;
  for (std::size_t symbol = kFirstLength; symbol < kLongest; ++symbol)
    lengths[symbol] = symbol < 281 ? 8 : 7;
  lengths[kLongest] = 2;
  return lengths;
}();
// Distances 1 and 2; the second only completes the code.
constexpr std::array<std::uint8_t, 2> kDistanceLengths{1, 1};
// Code lengths of the values in kLengths, as used in the block's head, in bits.
constexpr std::array<std::uint8_t, 19> kHeadLengths{0, 4, 4, 0, 3, 0, 0, 3, 3, 1};
static_assert(is_complete(kLengths) && is_complete(kDistanceLengths) && is_complete(kHeadLengths));

constexpr auto kCodes = codes_of(kLengths);
constexpr auto kHeadCodes = codes_of(kHeadLengths);

// Codes of matches of lengths 3 to 258 with the byte before (RFC 1951, 3.2.5).
constexpr std::array<Code, kLongestMatch + 1> kMatches = [] {
  std::array<Code, kLongestMatch + 1> matches{};
  std::size_t length = kShortestMatch;
  for (std::size_t symbol = kFirstLength; symbol < kLongest; ++symbol) {
    const std::size_t group = (symbol - kFirstLength) / 4;
    const std::size_t extra_bits = group < 2 ? 0 : group - 1;
    const Code code = kCodes[symbol];
    for (std::size_t extra = 0; extra < std::size_t{1} << extra_bits && length < kLongestMatch; ++extra) {
      matches[length++] = {static_cast<std::uint16_t>(code.bits | extra << code.length),
                           static_cast<std::uint8_t>(code.length + extra_bits + 1)};
    }
  }
  matches[kLongestMatch] = {kCodes[kLongest].bits, static_cast<std::uint8_t>(kCodes[kLongest].length + 1)};
  return matches;
}();

constexpr std::uint64_t kAdlerModulus = 65521;

}  // namespace

void RunDeflater::BitWriter::put(std::uint32_t code, unsigned length) {
  bits |= std::uint64_t{code} << count;
  count += length;
  if (count < 32) return;
  for (unsigned i = 0; i < 4; ++i)
    at[i] = static_cast<std::uint8_t>(bits >> (8 * i));
  at += 4;
  bits >>= 32;
  count -= 32;
}

void RunDeflater::BitWriter::put_rest() {
  for (; count > 0; count -= std::min(count, 8U), bits >>= 8)
    *at++ = static_cast<std::uint8_t>(bits);
}

void RunDeflater::begin(std::vector<std::uint8_t>& out, std::size_t at) {
  out_ = &out;
  if (out.size() < at) out.resize(at);
  writer_ = {out.data() + at, 0, 0};
  value_ = 0;
  count_ = 0;
  sum_ = 1;
  sum_of_sums_ = 0;
  make_room(256);
  writer_.put(0x0178, 16);  // deflate, a window of 32 KiB, the fastest level; RFC 1950, 2.2
  write_code_lengths();
}

void RunDeflater::write_code_lengths() {
  constexpr std::array<std::uint8_t, 19> kOrder{16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                                11, 4,  12, 3, 13, 2, 14, 1, 15};
  writer_.put(1, 1);  // the last block
  writer_.put(2, 2);  // with its own code
  writer_.put(kLengths.size() - 257, 5);
  writer_.put(kDistanceLengths.size() - 1, 5);
  writer_.put(kOrder.size() - 4, 4);
  for (const std::uint8_t symbol : kOrder)
    writer_.put(kHeadLengths[symbol], 3);
  for (const std::uint8_t length : kLengths)
    writer_.put(kHeadCodes[length].bits, kHeadCodes[length].length);
  for (const std::uint8_t length : kDistanceLengths)
    writer_.put(kHeadCodes[length].bits, kHeadCodes[length].length);
}

void RunDeflater::make_room(std::size_t size) {
  const auto used = static_cast<std::size_t>(writer_.at - out_->data());
  if (out_->size() - used >= size) return;
  out_->resize(std::max(used + size, 2 * out_->size()));
  writer_.at = out_->data() + used;
}

void RunDeflater::write_run() {
  if (count_ == 0) return;
  sum_run();
  make_room(count_ / kLongestMatch + 64);
  BitWriter writer = writer_;
  const Code literal = kCodes[value_];
  writer.put(literal.bits, literal.length);
  std::size_t left = count_ - 1;
  for (; left >= kLongestMatch; left -= kLongestMatch)
    writer.put(kMatches[kLongestMatch].bits, kMatches[kLongestMatch].length);
  if (left >= kShortestMatch) {
    writer.put(kMatches[left].bits, kMatches[left].length);
  } else {
    for (; left > 0; --left)
      writer.put(literal.bits, literal.length);
  }
  writer_ = writer;
}

// Adler-32 (RFC 1950, 8.2) of the run in closed form. With n < 2^28 + 2^14, 255 n (n + 1) / 2 < 2^63.2: no
// sum overflows.
void RunDeflater::sum_run() {
  const std::uint64_t n = count_;
  sum_of_sums_ = (sum_of_sums_ + n * sum_ + value_ * (n * (n + 1) / 2)) % kAdlerModulus;
  sum_ = (sum_ + n * value_) % kAdlerModulus;
}

std::size_t RunDeflater::finish() {
  write_run();
  count_ = 0;
  make_room(32);
  writer_.put(kCodes[kEndOfBlock].bits, kCodes[kEndOfBlock].length);
  writer_.put_rest();
  for (const std::uint64_t sum : {sum_of_sums_, sum_}) {
    *writer_.at++ = static_cast<std::uint8_t>(sum >> 8);
    *writer_.at++ = static_cast<std::uint8_t>(sum);
  }
  return static_cast<std::size_t>(writer_.at - out_->data());
}

}  // namespace contourd
