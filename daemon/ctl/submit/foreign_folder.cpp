#include "daemon/ctl/submit/foreign_folder.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <deque>
#include <memory>
#include <system_error>
#include <utility>

#include "daemon/spool/spool_folders.hpp"
#include "daemon/spool/why_ignored.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd::ctl {
namespace {

struct CloseFolder {
  void operator()(DIR* folder) const { ::closedir(folder); }
};

struct Folder {
  std::string path;
  int depth;
};

// False for hidden folders, and for folders with deleted or recovered files, such as "$RECYCLE.BIN".
bool may_hold_models(const std::string& folder) {
  return !folder.starts_with('.') && !folder.starts_with('$') && folder != "lost+found";
}

}  // namespace

ForeignFolder::ForeignFolder(const std::filesystem::path& path)
    : folder_(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (!folder_.valid())
    throw std::system_error(errno, std::generic_category(), "cannot read " + path.string());
}

FileDescriptor ForeignFolder::open(const std::string& path, int flags) const {
  // O_NONBLOCK: opening a FIFO would wait for a writer.
  open_how how{};
  how.flags =
      static_cast<decltype(how.flags)>(flags | O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY | O_NOFOLLOW);
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS | RESOLVE_NO_XDEV;
  return FileDescriptor(
      static_cast<int>(::syscall(SYS_openat2, folder_.get(), path.c_str(), &how, sizeof how)));
}

FileDescriptor ForeignFolder::open(const std::string& path) const {
  FileDescriptor file = open(path, 0);
  if (!file.valid()) {
    const std::error_code code(errno, std::generic_category());
    throw UnreadableFile(code, code.value() == ELOOP ? "it is a symbolic link" : code.message());
  }
  struct stat status {};
  if (::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode))
    throw UnreadableFile(std::make_error_code(std::errc::invalid_argument), "it is not a regular file");
  return file;
}

DIR* ForeignFolder::open_stream(const std::string& path) const {
  const FileDescriptor opened = open(path, O_DIRECTORY);
  // The stream closes its descriptor, so it gets a duplicate.
  return opened.valid() ? ::fdopendir(::dup(opened.get())) : nullptr;
}

FoundModels ForeignFolder::models() const {
  FoundModels found;
  std::size_t names = 0;
  for (std::deque<Folder> folders{{".", 0}}; !folders.empty() && found.all; folders.pop_front()) {
    const auto [path, depth] = folders.front();
    const std::unique_ptr<DIR, CloseFolder> stream(open_stream(path));
    if (!stream) {
      if (depth == 0) throw std::system_error(errno, std::generic_category(), "cannot read the folder");
      if (errno != ENOTDIR && errno != ELOOP) ++found.unread;
      continue;
    }
    while (const dirent* entry = ::readdir(stream.get())) {
      if (++names > kMostNames) {
        found.all = false;
        break;
      }
      const std::string name = entry->d_name;
      std::string below = depth == 0 ? name : fmt::format("{}/{}", path, name);
      const bool is_folder = entry->d_type == DT_DIR || entry->d_type == DT_UNKNOWN;
      if (is_model_name(name) && entry->d_type != DT_DIR)
        found.paths.push_back(std::move(below));
      else if (!name.starts_with('.') && entry->d_type != DT_DIR && why_format_is_ignored(name))
        found.others.push_back(std::move(below));
      else if (is_folder && depth < kDeepest && may_hold_models(name))
        folders.push_back({std::move(below), depth + 1});
    }
  }
  std::ranges::sort(found.paths);
  std::ranges::sort(found.others);
  return found;
}

}  // namespace contourd::ctl
