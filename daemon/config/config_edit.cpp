#include "daemon/config/config_edit.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "daemon/config/printer_config.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::string_view kBlanks = " \t\r\n", kNumber = "-+.0123456789eE";

// Returns where the value of the member `key` begins, if the text contains exactly one member of this name
// whose value begins with one of the characters `begin`, else nullopt.
std::optional<std::size_t> only_value(const std::string& text, std::string_view key, std::string_view begin) {
  const std::string name = fmt::format(R"("{}")", key);
  std::optional<std::size_t> found;
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
    const std::size_t colon = text.find_first_not_of(kBlanks, at + name.size());
    if (colon == std::string::npos || text[colon] != ':') continue;
    const std::size_t value = text.find_first_not_of(kBlanks, colon + 1);
    if (value == std::string::npos || begin.find(text[value]) == std::string_view::npos) continue;
    if (found) return std::nullopt;
    found = value;
  }
  return found;
}

[[noreturn]] void fail(const std::string& what, const fs::path& file) {
  throw std::system_error(errno, std::generic_category(), what + " " + file.string());
}

// Writes all bytes. False after an error, which is in errno.
bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

// A new version of the file `of`, with the owner and permissions of the file `like`, in a file beside it
// until place() replaces `of`.
class Replacement {
 public:
  Replacement(fs::path of, fs::path like)
      : of_(std::move(of)), like_(std::move(like)), path_(of_.string() + ".new") {}
  explicit Replacement(const fs::path& of) : Replacement(of, of) {}
  Replacement(const Replacement&) = delete;
  Replacement& operator=(const Replacement&) = delete;
  ~Replacement() {
    if (!placed_) ::unlink(path_.c_str());
  }

  void write(std::string_view text) const {
    struct stat like {};
    const bool exists = ::stat(like_.c_str(), &like) == 0;
    if (!exists && errno != ENOENT) fail("cannot read", like_);
    if (!exists) like.st_mode = S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH;
    ::unlink(path_.c_str());
    const FileDescriptor file(
        ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, S_IRUSR | S_IWUSR));
    const bool written = file.valid() && write_all(file.get(), text) &&
                         (!exists || ::fchown(file.get(), like.st_uid, like.st_gid) == 0) &&
                         ::fchmod(file.get(), like.st_mode & 07777U) == 0 && ::fsync(file.get()) == 0;
    if (!written) fail("cannot write", path_);
  }

  void place() {
    if (::rename(path_.c_str(), of_.c_str()) != 0) fail("cannot write", of_);
    placed_ = true;
    const FileDescriptor folder(::open(of_.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (folder.valid()) ::fsync(folder.get());
  }

 private:
  fs::path of_, like_, path_;
  bool placed_ = false;
};

// Links the file to an unused backup name and returns that name.
fs::path keep_aside(const fs::path& file) {
  constexpr int kMostBackups = 1000;
  for (int i = 1; i <= kMostBackups; ++i) {
    fs::path kept = file.string() + ".before-setup" + (i > 1 ? fmt::format("-{}", i) : "");
    if (::link(file.c_str(), kept.c_str()) == 0) return kept;
    if (errno != EEXIST) fail("cannot keep", file);
  }
  throw std::system_error(EEXIST, std::generic_category(), "cannot keep " + file.string());
}

}  // namespace

std::string with_number(const std::string& text, std::string_view section, std::string_view key,
                        double number) {
  const std::string pointer = fmt::format("/{}/{}", section, key);
  const auto by_hand = [&] {
    return std::runtime_error(fmt::format(
        "{} cannot be changed in this file automatically: set it to {} by hand", pointer, number));
  };
  Json wanted = Json::parse(text);
  wanted[Json::json_pointer(pointer)] = number;
  std::string changed;
  if (const auto there = only_value(text, key, kNumber)) {
    changed = text;
    changed.replace(*there, std::min(text.find_first_not_of(kNumber, *there), text.size()) - *there,
                    fmt::format("{}", number));
  } else if (const auto object = only_value(text, section, "{")) {
    const std::size_t inside = *object + 1, first = text.find_first_not_of(kBlanks, inside);
    const bool empty = text.compare(first, 1, "}") == 0;
    changed = text;
    changed.insert(inside, fmt::format(R"({}"{}": {}{})", text.substr(inside, first - inside), key, number,
                                       empty ? "" : ","));
  }
  // The search may misread unusual text: accept the result only if the parsed JSON is as wanted.
  const Json read = Json::parse(changed, nullptr, false);
  if (read.is_discarded() || nlohmann::json(read) != nlohmann::json(wanted)) throw by_hand();
  return changed;
}

void set_config_number(const fs::path& file, std::string_view section, std::string_view key, double number) {
  (void)load_printer_config(file);
  const std::string changed = with_number(read_text(file), section, key, number);
  (void)read_printer_config(changed, file);
  replace_file(file, changed);
}

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(stream)), {});
  if (!stream) throw std::system_error(errno, std::generic_category(), "cannot read " + file.string());
  return text;
}

void replace_file(const fs::path& file, std::string_view text) {
  Replacement replacement(fs::canonical(file));
  replacement.write(text);
  replacement.place();
}

void write_beside(const fs::path& existing, const fs::path& file, std::string_view content) {
  Replacement replacement(file, existing);
  replacement.write(content);
  replacement.place();
}

std::optional<fs::path> replace_config(const fs::path& file, const std::string& text, FileBefore before) {
  const fs::path path = fs::weakly_canonical(file);
  (void)read_printer_config(text, path);
  Replacement replacement(path);
  replacement.write(text);
  std::optional<fs::path> kept;
  if (before == FileBefore::Kept && fs::exists(path)) kept = keep_aside(path);
  replacement.place();
  return kept;
}

}  // namespace contourd
