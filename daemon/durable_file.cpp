#include "daemon/durable_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <random>
#include <system_error>

#include "hw/file_descriptor.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTemporaryStart = ".contourd-", kTemporaryEnd = ".new";

std::system_error failure() {
  return std::system_error(errno, std::generic_category());
}

void write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(fd, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw failure();
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::fsync(fd) != 0) throw failure();
}

// A dot file: nobody takes it for a job's. Nobody can know it beforehand.
fs::path temporary_name() {
  std::random_device random;
  return fmt::format("{}{:08x}{:08x}{}", kTemporaryStart, random(), random(), kTemporaryEnd);
}

// A file that is written before it gets its name. Until then it goes with this object, or with the process
// where the file system has files without a name.
class NewFile {
 public:
  explicit NewFile(const fs::path& folder)
      : temporary_(folder / temporary_name()),
        file_(::open(folder.c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0644)) {
    if (file_.valid() || (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL)) return;
    file_ = FileDescriptor(
        ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0644));
    named_ = file_.valid();
  }
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  ~NewFile() {
    std::error_code ignored;
    if (named_) fs::remove(temporary_, ignored);
  }

  [[nodiscard]] bool valid() const { return file_.valid(); }
  [[nodiscard]] int get() const { return file_.get(); }

  void replace(const fs::path& path) {
    const std::string unnamed = fmt::format("/proc/self/fd/{}", file_.get());
    if (!named_ && ::linkat(AT_FDCWD, unnamed.c_str(), AT_FDCWD, temporary_.c_str(), AT_SYMLINK_FOLLOW) != 0)
      throw failure();
    named_ = true;
    fs::rename(temporary_, path);
    named_ = false;
  }

 private:
  fs::path temporary_;
  FileDescriptor file_;
  bool named_ = false;
};

}  // namespace

void write_durably(const fs::path& path, std::string_view text) {
  try {
    NewFile file(path.parent_path());
    if (!file.valid()) throw failure();
    write_all(file.get(), text);
    file.replace(path);
  } catch (const std::system_error& error) {
    throw std::system_error(error.code(), "cannot write " + path.string());
  }
  sync_folder(path.parent_path());
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

}  // namespace contourd
