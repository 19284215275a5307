#include "daemon/system/secret_file.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <stdexcept>

#include "daemon/system/durable_file.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {
namespace {

std::string text_of_secrets(const FileDescriptor& file) {
  std::array<char, kMostSecretBytes> buffer;
  std::string text;
  while (text.size() < kMostSecretBytes) {
    const ssize_t bytes = ::read(file.get(), buffer.data(), buffer.size() - text.size());
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes <= 0) break;
    text.append(buffer.data(), static_cast<std::size_t>(bytes));
  }
  return text;
}

}  // namespace

std::string read_secret_file(const std::filesystem::path& file) {
  const FileDescriptor opened = open_regular_file(file, Links::Follow);
  struct stat status {};
  if (::fstat(opened.get(), &status) != 0 || (status.st_mode & S_IRWXO) != 0) {
    const std::string name = printable(file.string());
    throw std::runtime_error(
        fmt::format("{}: other users can read the secrets: sudo chmod 600 {}", name, name));
  }
  return text_of_secrets(opened);
}

std::string secret_value(std::string_view text, std::string_view key) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    if (line.size() > key.size() && line.starts_with(key) && line[key.size()] == ' ')
      return std::string(line.substr(key.size() + 1));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return "";
}

void write_secret_file(const std::filesystem::path& file, std::string_view text) {
  const mode_t before = ::umask(S_IRWXG | S_IRWXO);
  try {
    write_durably(file, text);
  } catch (...) {
    ::umask(before);
    throw;
  }
  ::umask(before);
}

}  // namespace contourd
