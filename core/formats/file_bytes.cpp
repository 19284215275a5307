#include "core/formats/file_bytes.hpp"

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "core/formats/model_format.hpp"

namespace contourd {
namespace {

std::system_error cannot_read(const std::filesystem::path& path, std::error_code code) {
  return std::system_error(code, "cannot read " + path.string());
}

// A system_error whose what() is the sentence alone: "Invalid argument" after the sentence would explain
// nothing.
class NotARegularFile : public std::system_error {
 public:
  explicit NotARegularFile(const std::filesystem::path& path)
      : std::system_error(std::make_error_code(std::errc::invalid_argument)),
        sentence_("cannot read " + path.string() + ": it is not a regular file") {}
  [[nodiscard]] const char* what() const noexcept override { return sentence_.what(); }

 private:
  std::runtime_error sentence_;  // a runtime_error, because copying one cannot fail
};

}  // namespace

OpenFile open_regular(const std::filesystem::path& path) {
  std::error_code code;
  // Checked before opening: opening a FIFO would wait for a writer.
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (code && status.type() != std::filesystem::file_type::not_found) throw cannot_read(path, code);
  if (!std::filesystem::exists(status)) {
    throw cannot_read(path, std::make_error_code(std::errc::no_such_file_or_directory));
  }
  if (std::filesystem::is_directory(status)) {
    throw cannot_read(path, std::make_error_code(std::errc::is_a_directory));
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw NotARegularFile(path);
  }
  OpenFile file(std::fopen(path.c_str(), "rb"));
  if (!file) throw cannot_read(path, std::error_code(errno, std::generic_category()));
  return file;
}

void read_exactly(std::FILE* file, std::span<std::byte> into, const std::filesystem::path& path) {
  errno = 0;
  if (std::fread(into.data(), 1, into.size(), file) == into.size()) return;
  throw cannot_read(path, errno != 0 ? std::error_code(errno, std::generic_category())
                                     : std::make_error_code(std::errc::io_error));
}

std::vector<std::byte> read_start(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path) {
  std::vector<std::byte> start(std::min<std::uint64_t>(bytes, kSniffBytes));
  read_exactly(file, start, path);
  std::rewind(file);
  return start;
}

}  // namespace contourd
