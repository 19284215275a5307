#include "daemon/spool/job_copy.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <vector>

#include "daemon/json/json_document.hpp"
#include "daemon/spool/copied_originals.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/printable.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

FileDescriptor open_part(const fs::path& path) {
  try {
    return open_regular_file(path, Links::Refuse);
  } catch (const UnreadableFile& error) {
    throw JobUnreadable(fmt::format("cannot read {}: {}", printable(path.string()), error.what()));
  }
}

std::system_error failure(const fs::path& path) {
  return std::system_error(errno, std::generic_category(), "cannot copy " + path.string());
}

void write_all(const FileDescriptor& file, const char* bytes, std::size_t size, const fs::path& path) {
  while (size > 0) {
    const ssize_t written = ::write(file.get(), bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw failure(path);
    bytes += written;
    size -= static_cast<std::size_t>(written);
  }
}

// Copies at most `size` bytes, so that a file that grows meanwhile cannot fill the disk.
void copy_file(const FileDescriptor& from, std::uintmax_t size, const fs::path& to,
               const std::atomic<bool>& stop) {
  const FileDescriptor file(::open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
  if (!file.valid()) throw failure(to);
  std::vector<char> buffer(std::size_t{1} << 20U);
  while (size > 0) {
    if (stop) throw std::system_error(std::make_error_code(std::errc::operation_canceled));
    const ssize_t bytes = ::read(from.get(), buffer.data(), std::min<std::uintmax_t>(buffer.size(), size));
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0) throw failure(to);
    if (bytes == 0) break;
    write_all(file, buffer.data(), static_cast<std::size_t>(bytes), to);
    size -= static_cast<std::uintmax_t>(bytes);
  }
  if (::fsync(file.get()) != 0) throw failure(to);
}

std::uintmax_t size_of(const FileDescriptor& file, const fs::path& path) {
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) throw failure(path);
  return static_cast<std::uintmax_t>(status.st_size);
}

fs::path place_of(const fs::path& part, const JobFiles& from, const JobFiles& to) {
  if (from.plate) return to.model / part.filename();
  return part == from.model ? to.model : *to.ticket;
}

}  // namespace

void copy_job(const JobFiles& from, const JobFiles& to, std::uintmax_t most_bytes,
              const std::atomic<bool>& stop) {
  if (from.plate) fs::create_directory(to.model);
  for (const fs::path& part : parts_of(from)) {
    const FileDescriptor file = open_part(part);
    const std::uintmax_t size = size_of(file, part);
    if (size > most_bytes)
      throw std::system_error(std::make_error_code(std::errc::no_space_on_device),
                              "cannot copy " + part.string());
    most_bytes -= size;
    copy_file(file, size, place_of(part, from, to), stop);
  }
  if (from.plate) sync_folder(to.model);
}

void copy_ticket(const fs::path& from, const fs::path& to) {
  const FileDescriptor file = open_part(from);
  const std::uintmax_t size = size_of(file, from);
  if (size > JsonDocument::kLargestBytes) throw JobUnreadable(from.string() + " is too large for a ticket");
  copy_file(file, size, to, false);
}

}  // namespace contourd
