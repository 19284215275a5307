#include "daemon/formats/zip_archive.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/model/model.hpp"
#include "daemon/formats/input_limits.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {
namespace {

constexpr std::uint64_t kMostEntries = 10'000;
constexpr std::size_t kLongestEntryName = 1024;

// Layout of an archive's end, by the specification of ZIP (APPNOTE.TXT 4.3.14 to 4.3.16).
constexpr std::size_t kEndBytes = 22, kLongestComment = 65'535;
constexpr std::size_t kEndEntries = 10;  // offset of the number of entries, 16 bits
constexpr std::string_view kEndMark{"PK\x05\x06", 4};
constexpr std::size_t kLocatorBytes = 20, kLocatorOffset = 8;  // offset of the place of the ZIP64 end
constexpr std::string_view kLocatorMark{"PK\x06\x07", 4};
constexpr std::size_t kEnd64Bytes = 56, kEnd64Entries = 32;

class ZipEntryStream : public ByteStream {
 public:
  ZipEntryStream(zip_t* archive, const ZipEntry& entry)
      : file_(zip_fopen_index(archive, entry.index, 0)), name_(entry.name), bytes_(entry.inflated) {
    if (!file_) refuse(zip_error_strerror(zip_get_error(archive)));
  }

  [[nodiscard]] std::uint64_t bytes() const override { return bytes_; }

  std::size_t read_some(std::span<std::byte> into) override {
    const zip_int64_t got = zip_fread(file_.get(), into.data(), into.size());
    if (got < 0) refuse(zip_error_strerror(zip_file_get_error(file_.get())));
    given_ += static_cast<std::uint64_t>(got);
    if (given_ > bytes_) refuse("it holds more bytes than it claims");
    return static_cast<std::size_t>(got);
  }

 private:
  struct Close {
    void operator()(zip_file_t* file) const { zip_fclose(file); }
  };

  [[noreturn]] void refuse(const char* why) const {
    throw DamagedStream(fmt::format("{} in the archive is damaged ({}): copy the archive again",
                                    in_quotes(name_), printable(why)));
  }

  std::unique_ptr<zip_file_t, Close> file_;
  std::string name_;
  std::uint64_t bytes_, given_ = 0;
};

void refuse_entries(std::uint64_t entries) {
  if (entries > kMostEntries)
    throw ModelError(
        fmt::format("the archive holds {} entries, and the limit is {}: unpack it and print its models, "
                    "or slice the model with thicker layers",
                    entries, kMostEntries));
}

template <typename Number>
Number number_at(std::string_view bytes, std::size_t offset) {
  Number number = 0;
  std::memcpy(&number, bytes.data() + offset, sizeof number);  // little-endian, as this machine
  return number;
}

// Reads at most `bytes` bytes from the offset.
std::string read_at(int fd, std::uint64_t offset, std::size_t bytes, const std::filesystem::path& path) {
  std::string text(bytes, '\0');
  std::size_t got = 0;
  while (got < bytes) {
    const ssize_t count = ::pread(fd, text.data() + got, bytes - got, static_cast<off_t>(offset + got));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw std::system_error(errno, std::generic_category(), "cannot read " + path.string());
    if (count == 0) break;
    got += static_cast<std::size_t>(count);
  }
  text.resize(got);
  return text;
}

// Refuses an archive with too many entries before libzip allocates memory for them: checks each place that
// could be the archive's end.
void check_ends(int fd, std::uint64_t file_bytes, const std::filesystem::path& path) {
  const std::size_t bytes = std::min<std::uint64_t>(file_bytes, kEndBytes + kLongestComment + kLocatorBytes);
  const std::string text = read_at(fd, file_bytes - bytes, bytes, path);
  const std::string_view tail = text;
  for (std::size_t at = tail.find(kEndMark); at != std::string_view::npos; at = tail.find(kEndMark, at + 1)) {
    if (at + kEndBytes > tail.size()) break;
    const auto entries = number_at<std::uint16_t>(tail, at + kEndEntries);
    if (entries != 0xFFFF) refuse_entries(entries);
    if (at < kLocatorBytes || tail.substr(at - kLocatorBytes, kLocatorMark.size()) != kLocatorMark) continue;
    const auto place = number_at<std::uint64_t>(tail, at - kLocatorBytes + kLocatorOffset);
    if (place > file_bytes) continue;
    const std::string end = read_at(fd, place, kEnd64Bytes, path);
    if (end.size() == kEnd64Bytes) refuse_entries(number_at<std::uint64_t>(end, kEnd64Entries));
  }
}

// Returns why an entry cannot be read; empty if it can.
std::string fault_of(zip_t* archive, const zip_stat_t& status) {
  zip_uint8_t system = 0;
  zip_uint32_t attributes = 0;
  if (status.encryption_method != ZIP_EM_NONE) return "is encrypted: unpack the archive with its password";
  if (status.comp_method != ZIP_CM_STORE && status.comp_method != ZIP_CM_DEFLATE)
    return "is compressed by a method other than Deflate: pack the archive again with the usual method";
  if (zip_file_get_external_attributes(archive, status.index, 0, &system, &attributes) == 0 &&
      system == ZIP_OPSYS_UNIX && S_ISLNK(static_cast<mode_t>(attributes >> 16U)))
    return "is a link: put the model itself into the archive";
  return "";
}

}  // namespace

bool is_zip(std::span<const std::byte> start) {
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
  return text.starts_with("PK\x03\x04") || text.starts_with(kEndMark);
}

ZipArchive::ZipArchive(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path)
    : bytes_(bytes) {
  FileDescriptor own(::fcntl(::fileno(file), F_DUPFD_CLOEXEC, 0));
  if (!own.valid()) throw std::system_error(errno, std::generic_category(), "cannot read " + path.string());
  check_ends(own.get(), bytes, path);
  std::FILE* const opened = ::fdopen(::fcntl(own.get(), F_DUPFD_CLOEXEC, 0), "rb");
  if (opened == nullptr)
    throw std::system_error(errno, std::generic_category(), "cannot read " + path.string());
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* const source = zip_source_filep_create(opened, 0, static_cast<zip_int64_t>(bytes), &error);
  if (source == nullptr) {
    std::fclose(opened);
    zip_error_fini(&error);
    throw std::bad_alloc();
  }
  archive_.reset(zip_open_from_source(source, ZIP_RDONLY, &error));
  const std::string why = archive_ ? "" : zip_error_strerror(&error);
  zip_error_fini(&error);
  if (!archive_) {
    zip_source_free(source);
    throw ModelError(fmt::format("the archive is damaged ({}): copy it again", printable(why)));
  }
  list_entries();
}

void ZipArchive::list_entries() {
  const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
  refuse_entries(static_cast<std::uint64_t>(std::max<zip_int64_t>(count, 0)));
  constexpr zip_uint64_t kNeeded = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE;
  for (zip_int64_t i = 0; i < count; ++i) {
    zip_stat_t status;
    if (zip_stat_index(archive_.get(), static_cast<zip_uint64_t>(i), 0, &status) != 0 ||
        (status.valid & kNeeded) != kNeeded)
      throw ModelError(fmt::format("entry {} of the archive is damaged: copy the archive again", i + 1));
    const std::string_view name = status.name;
    if (name.ends_with('/')) continue;
    if (name.size() > kLongestEntryName)
      throw ModelError(
          fmt::format("entry {} of the archive has a name of {} bytes, and the limit is {}: "
                      "pack the archive again with shorter names",
                      i + 1, name.size(), kLongestEntryName));
    entries_.push_back({std::string(name), static_cast<std::uint64_t>(i), status.comp_size, status.size,
                        fault_of(archive_.get(), status)});
  }
}

const ZipEntry* ZipArchive::find(std::string_view name) const {
  const auto found = std::ranges::find(entries_, name, &ZipEntry::name);
  return found == entries_.end() ? nullptr : &*found;
}

std::unique_ptr<ByteStream> ZipArchive::open(const ZipEntry& entry) const {
  if (!entry.fault.empty()) throw ModelError(fmt::format("{} {}", in_quotes(entry.name), entry.fault));
  refuse_inflation({entry.compressed, entry.inflated}, in_quotes(entry.name) + " in the archive");
  return std::make_unique<ZipEntryStream>(archive_.get(), entry);
}

}  // namespace contourd
