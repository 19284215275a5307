#include "daemon/control/file_pieces.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/system/base64.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {

using Json = ControlMethod::Json;

namespace {

// Returns a number that another content of the file would not have, small enough for every JSON parser.
std::uint64_t version_of(const struct stat& file) {
  const auto nanoseconds = static_cast<std::uint64_t>(file.st_mtim.tv_sec) * 1'000'000'000U +
                           static_cast<std::uint64_t>(file.st_mtim.tv_nsec);
  return 1 + (nanoseconds ^ (static_cast<std::uint64_t>(file.st_ino) << 20U)) % (std::uint64_t{1} << 52U);
}

[[noreturn]] void refuse(const WantedPiece& wanted, std::string_view why) {
  throw ControlRefusal(fmt::format("{} cannot be read: {}", wanted.what, why));
}

}  // namespace

ControlParameter piece_parameter(const char* name, const char* meaning) {
  return ControlParameter::whole_number(name, 0, ControlParameter::kMost, meaning)
      .described_as("a whole number, taken from the previous reply");
}

void add_piece(Json& reply, std::span<const std::uint8_t> file, std::size_t from) {
  expects(from <= file.size(), "the piece begins in the file");
  reply["bytes"] = file.size();
  reply["from"] = from;
  reply["data"] = base64(file.subspan(from, std::min(kPieceBytes, file.size() - from)));
}

WantedPiece wanted_piece(std::string what, const Json& given) {
  WantedPiece wanted{std::move(what), given.value("version", std::uint64_t{0}),
                     given.value("from", std::uint64_t{0})};
  if (wanted.from != 0 && wanted.version == 0) throw InvalidParameters("from needs version");
  return wanted;
}

void add_piece(Json& reply, const std::filesystem::path& path, const WantedPiece& wanted) {
  FileDescriptor file;
  try {
    file = open_regular_file(path, Links::Refuse);
  } catch (const UnreadableFile& error) {
    refuse(wanted, error.what());
  }
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) refuse(wanted, std::strerror(errno));
  const std::uint64_t version = version_of(status), bytes = static_cast<std::uint64_t>(status.st_size);
  if (wanted.version != 0 && wanted.version != version)
    throw ControlRefusal(fmt::format("{} has changed meanwhile; try again", wanted.what));
  if (wanted.from > bytes)
    throw ControlRefusal(fmt::format("from must be at most {}, the size of {} in bytes", bytes, wanted.what));
  std::vector<std::uint8_t> piece(kPieceBytes);
  const ssize_t got = ::pread(file.get(), piece.data(), piece.size(), static_cast<off_t>(wanted.from));
  if (got < 0) refuse(wanted, std::strerror(errno));
  piece.resize(static_cast<std::size_t>(got));
  reply["version"] = version;
  reply["bytes"] = bytes;
  reply["from"] = wanted.from;
  reply["data"] = base64(piece);
}

bool is_own_name(std::string_view name) {
  constexpr std::size_t kLongest = 200;
  return !name.empty() && name.size() <= kLongest && !name.starts_with('.') &&
         name.find_first_of(std::string_view("/\0", 2)) == std::string_view::npos;
}

}  // namespace contourd
