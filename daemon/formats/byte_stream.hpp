// A source of bytes that are read once, from the first to the last. Used by one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/formats/model_format.hpp"
#include "core/model/model.hpp"

namespace contourd {

// Thrown by a stream whose data is damaged; what() names the file or the entry.
class DamagedStream : public ModelError {
 public:
  using ModelError::ModelError;
};

class ByteStream {
 public:
  ByteStream() = default;
  ByteStream(const ByteStream&) = delete;
  ByteStream& operator=(const ByteStream&) = delete;
  virtual ~ByteStream() = default;

  // Number of bytes that the stream should hold. The file claims it: read_some() shows the truth.
  [[nodiscard]] virtual std::uint64_t bytes() const = 0;
  // Fills at most the span with the next bytes and returns their number, 0 at the end. Blocks. Throws
  // DamagedStream, std::system_error if the file cannot be read.
  virtual std::size_t read_some(std::span<std::byte> into) = 0;
};

// A stream whose first bytes have been read, to recognise a format by them; it gives them again.
class StartedStream : public ByteStream {
 public:
  // Reads the first kSniffBytes of the stream, or as many as it claims to hold. Throws what the stream
  // throws, and DamagedStream if it holds fewer bytes. `name` precedes messages.
  StartedStream(std::unique_ptr<ByteStream> stream, const std::string& name);

  [[nodiscard]] std::uint64_t bytes() const override { return stream_->bytes(); }
  std::size_t read_some(std::span<std::byte> into) override;
  [[nodiscard]] FileStart start() const { return {stream_->bytes(), first_bytes_}; }

 private:
  std::unique_ptr<ByteStream> stream_;
  std::vector<std::byte> first_bytes_;
  std::size_t given_ = 0;  // bytes of first_bytes_
};

// A model of one of the core's formats in a stream.
class StreamedModel {
 public:
  // `name` precedes messages: "the model in the archive". The stream, of which nothing else is read, must
  // outlive the model.
  StreamedModel(StartedStream& stream, std::string name) : stream_(stream), name_(std::move(name)) {}

  // Throws ModelError if the first bytes show what is wrong.
  [[nodiscard]] ModelOutline outline() const;
  // Reads the model up to the stream's end. Call it once. Throws ModelError, and what the stream throws.
  [[nodiscard]] Model read();

 private:
  void read_exactly(std::span<std::byte> into);

  StartedStream& stream_;
  std::string name_;
};

}  // namespace contourd
