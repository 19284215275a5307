#include "daemon/control/picture_upload.hpp"

#include <fmt/format.h>

#include <utility>

#include "daemon/control/control_method.hpp"

namespace contourd {

std::size_t PictureUpload::add(std::uint64_t connection, std::size_t from,
                               std::span<const std::uint8_t> piece) {
  if (from == 0) {
    drop(connection_);
    connection_ = connection;
  }
  if (connection != connection_ || from != bytes_.size()) {
    throw ControlRefusal(
        fmt::format("the piece at {} does not continue this connection's picture, which has {} bytes so "
                    "far: start again at 0",
                    from, connection == connection_ ? bytes_.size() : 0));
  }
  if (piece.size() > most_ - bytes_.size()) {
    drop(connection);
    throw ControlRefusal(fmt::format("a picture has at most {} bytes", most_));
  }
  bytes_.insert(bytes_.end(), piece.begin(), piece.end());
  return bytes_.size();
}

std::vector<std::uint8_t> PictureUpload::take(std::uint64_t connection) {
  if (connection != connection_ || bytes_.empty())
    throw ControlRefusal(
        "no picture was uploaded by this connection, or another connection's upload replaced it");
  connection_ = 0;
  return std::exchange(bytes_, {});
}

void PictureUpload::drop(std::uint64_t connection) {
  if (connection != connection_) return;
  connection_ = 0;
  bytes_ = {};
}

}  // namespace contourd
