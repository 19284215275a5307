#include "daemon/formats/byte_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/formats/model_reader.hpp"

namespace contourd {

StartedStream::StartedStream(std::unique_ptr<ByteStream> stream, const std::string& name)
    : stream_(std::move(stream)) {
  std::vector<std::byte> first(std::min<std::uint64_t>(stream_->bytes(), kSniffBytes));
  for (std::span<std::byte> rest = first; !rest.empty();) {
    const std::size_t got = stream_->read_some(rest);
    if (got == 0) throw DamagedStream(name + ": it is damaged: it holds fewer bytes than it claims");
    rest = rest.subspan(got);
  }
  first_bytes_ = std::move(first);
}

std::size_t StartedStream::read_some(std::span<std::byte> into) {
  const std::size_t again = std::min(into.size(), first_bytes_.size() - given_);
  if (again == 0) return stream_->read_some(into);
  std::copy_n(first_bytes_.begin() + static_cast<std::ptrdiff_t>(given_), again, into.begin());
  given_ += again;
  return again;
}

ModelOutline StreamedModel::outline() const {
  try {
    return outline_of_model(stream_.start());
  } catch (const ModelError& error) {
    throw ModelError(fmt::format("{}: {}", name_, error.what()));
  }
}

Model StreamedModel::read() {
  try {
    Model model = read_model(stream_.start(), [this](std::span<std::byte> into) { read_exactly(into); });
    // The checksum is checked at the end.
    std::array<std::byte, 1> more{};
    if (stream_.read_some(more) != 0) throw ModelError("it is damaged: it holds more bytes than it claims");
    return model;
  } catch (const DamagedStream&) {
    throw;
  } catch (const ModelError& error) {
    throw ModelError(fmt::format("{}: {}", name_, error.what()));
  }
}

void StreamedModel::read_exactly(std::span<std::byte> into) {
  for (std::span<std::byte> rest = into; !rest.empty();) {
    const std::size_t got = stream_.read_some(rest);
    if (got == 0) throw ModelError("it is damaged: it holds fewer bytes than it claims");
    rest = rest.subspan(got);
  }
}

}  // namespace contourd
