#include "daemon/system/durable_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <random>
#include <system_error>
#include <utility>

namespace contourd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTemporaryStart = ".contourd-", kTemporaryEnd = ".new";

std::system_error failure() {
  return std::system_error(errno, std::generic_category());
}

// Returns an unpredictable name. The leading dot keeps the spool from taking the file for a job.
fs::path temporary_name() {
  std::random_device random;
  return fmt::format("{}{:08x}{:08x}{}", kTemporaryStart, random(), random(), kTemporaryEnd);
}

std::string open_path(const FileDescriptor& file) {
  return fmt::format("/proc/self/fd/{}", file.get());
}

}  // namespace

void write_durably(const fs::path& path, std::string_view text) {
  try {
    NewFile file(path.parent_path());
    file.write(text);
    file.replace(path.filename().string());
  } catch (const std::system_error& error) {
    throw std::system_error(error.code(), "cannot write " + path.string());
  }
  sync_folder(path.parent_path());
}

void sync_folder(const fs::path& folder) {
  const FileDescriptor directory(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.valid()) ::fsync(directory.get());
}

void sync_contents(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  if (fs::is_directory(status)) {
    for (const auto& entry : fs::directory_iterator(path, error))
      if (fs::is_regular_file(entry.symlink_status(error))) sync_contents(entry.path());
    return;
  }
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK | O_NOFOLLOW));
  if (file.valid()) ::fsync(file.get());
}

NewFile::NewFile(fs::path folder)
    : folder_(std::move(folder)),
      temporary_(folder_ / temporary_name()),
      file_(::open(folder_.c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0644)) {
  if (file_.valid()) return;
  if (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL) throw failure();
  file_ =
      FileDescriptor(::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0644));
  if (!file_.valid()) throw failure();
  named_ = true;
}

NewFile::~NewFile() {
  std::error_code ignored;
  if (named_) fs::remove(temporary_, ignored);
}

void NewFile::let_group_read() {
  add_mode(S_IRUSR | S_IRGRP);
}

void NewFile::let_all_read() {
  add_mode(S_IRUSR | S_IRGRP | S_IROTH);
}

void NewFile::add_mode(mode_t mode) {
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0 || ::fchmod(file_.get(), (status.st_mode & 07777U) | mode) != 0)
    throw failure();
}

void NewFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw failure();
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void NewFile::rewrite(std::int64_t offset, std::string_view bytes) {
  if (::lseek(file_.get(), offset, SEEK_SET) < 0) throw failure();
  write(bytes);
  if (::lseek(file_.get(), 0, SEEK_END) < 0) throw failure();
}

void NewFile::sync() {
  if (::fsync(file_.get()) != 0) throw failure();
}

void NewFile::close_for_writing() {
  if (std::exchange(written_, true)) return;
  FileDescriptor reading(::open(open_path(file_).c_str(), O_RDONLY | O_CLOEXEC));
  if (!reading.valid()) throw failure();
  file_ = std::move(reading);
}

void NewFile::name_temporarily() {
  if (!named_ &&
      ::linkat(AT_FDCWD, open_path(file_).c_str(), AT_FDCWD, temporary_.c_str(), AT_SYMLINK_FOLLOW) != 0)
    throw failure();
  named_ = true;
}

void NewFile::replace(const std::string& name) {
  sync();
  replace_for_now(name);
}

void NewFile::replace_for_now(const std::string& name) {
  name_temporarily();
  fs::rename(temporary_, folder_ / name);
  named_ = false;
}

bool NewFile::appear(const std::string& name) {
  sync();
  close_for_writing();
  const fs::path path = folder_ / name;
  const int result =
      named_ ? ::renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, path.c_str(), RENAME_NOREPLACE)
             : ::linkat(AT_FDCWD, open_path(file_).c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW);
  if (result != 0 && errno == EEXIST) return false;
  if (result != 0) throw failure();
  named_ = false;
  return true;
}

void remove_unfinished_files(const fs::path& folder) {
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    std::error_code ignored;
    if (name.starts_with(kTemporaryStart) && name.ends_with(kTemporaryEnd))
      fs::remove(entry->path(), ignored);
  }
}

}  // namespace contourd
