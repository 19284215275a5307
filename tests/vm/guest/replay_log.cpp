// Makes the disk that a power cut leaves, from the record of dm-log-writes (the kernel's
// Documentation/admin-guide/device-mapper/log-writes.rst):
//   replay-log LOG DISK SEED
// The cut comes after a barrier: a flush, a write that bypasses the cache (FUA) or a mark, after the mark
// "start". Everything recorded up to the barrier is on the disk. Of the writes between it and the next
// barrier a drive may have written any part; the seed selects the blocks. Prints the marks before the cut,
// one per line, and the place of the cut.
#include <fcntl.h>
#include <linux/fs.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace {

constexpr std::uint64_t kMagic = 0x6a736677736872, kVersion = 1;
constexpr std::uint64_t kFlush = 1, kFua = 2, kDiscard = 4, kMark = 8;
// The number of bytes that a drive writes completely or not at all; equal to the file system's block size.
constexpr std::size_t kBlockBytes = 4096;

// The log's structures, little-endian; each starts a sector.
struct Header {
  std::uint64_t magic, version, entries;
  std::uint32_t sector_bytes;
};
struct Entry {
  std::uint64_t sector, sectors, flags, mark_bytes;
};

struct Recorded {
  Entry entry;
  std::uint64_t data;  // offset of the data in the log
  std::string mark;
};

[[noreturn]] void fail(const std::string& what) {
  std::perror(what.c_str());
  std::exit(1);
}

[[noreturn]] void refuse(const char* why) {
  std::fprintf(stderr, "%s\n", why);
  std::exit(1);
}

class Device {
 public:
  Device(const char* path, int flags) : path_(path), fd_(::open(path, flags)) {
    if (fd_ < 0) fail(path_);
  }

  [[nodiscard]] std::uint64_t bytes() const {
    std::uint64_t bytes = 0;
    if (::ioctl(fd_, BLKGETSIZE64, &bytes) != 0) fail(path_);
    return bytes;
  }
  void read(void* to, std::size_t bytes, std::uint64_t at) const {
    for (auto* next = static_cast<char*>(to); bytes > 0;) {
      const ssize_t got = ::pread(fd_, next, bytes, static_cast<off_t>(at));
      if (got <= 0) fail(path_);
      next += got;
      at += static_cast<std::uint64_t>(got);
      bytes -= static_cast<std::size_t>(got);
    }
  }
  void write_all(const std::vector<char>& image) const {
    for (std::size_t at = 0; at < image.size();) {
      const ssize_t put = ::pwrite(fd_, image.data() + at, image.size() - at, static_cast<off_t>(at));
      if (put <= 0) fail(path_);
      at += static_cast<std::size_t>(put);
    }
    if (::fsync(fd_) != 0) fail(path_);
  }

 private:
  const char* path_;
  int fd_;
};

std::vector<Recorded> read_log(const Device& log, std::uint32_t& sector_bytes) {
  Header header{};
  log.read(&header, sizeof header, 0);
  if (header.magic != kMagic || header.version != kVersion) refuse("this is no log of dm-log-writes");
  sector_bytes = header.sector_bytes;
  std::vector<Recorded> records(header.entries);
  std::uint64_t at = sector_bytes;
  for (Recorded& record : records) {
    log.read(&record.entry, sizeof record.entry, at);
    if ((record.entry.flags & kMark) != 0) {
      record.mark.resize(record.entry.mark_bytes);
      log.read(record.mark.data(), record.mark.size(), at + sizeof record.entry);
      record.mark.resize(std::strlen(record.mark.c_str()));
    }
    at += sector_bytes;
    record.data = at;
    if ((record.entry.flags & kDiscard) == 0) at += record.entry.sectors * sector_bytes;
  }
  return records;
}

// The records after which a cut may come.
std::vector<std::size_t> cuts_of(const std::vector<Recorded>& records) {
  std::vector<std::size_t> cuts;
  bool started = false;
  for (std::size_t i = 0; i < records.size(); ++i) {
    started = started || records[i].mark == "start";
    if (started && (records[i].entry.flags & (kFlush | kFua | kMark)) != 0) cuts.push_back(i);
  }
  if (cuts.empty()) refuse("the log has no mark \"start\"");
  return cuts;
}

class Disk {
 public:
  Disk(const Device& log, std::uint64_t bytes, std::uint32_t sector_bytes)
      : log_(log), image_(bytes), sector_bytes_(sector_bytes) {}

  // Writes those blocks of the record for which `is_written` returns true.
  template <typename IsWritten>
  void apply(const Recorded& record, const IsWritten& is_written) {
    const std::uint64_t bytes = record.entry.sectors * sector_bytes_,
                        place = record.entry.sector * sector_bytes_;
    if (place + bytes > image_.size()) refuse("a write lies outside the disk");
    for (std::uint64_t at = 0; at < bytes; at += kBlockBytes) {
      if (!is_written()) continue;
      const std::size_t size = std::min<std::uint64_t>(kBlockBytes, bytes - at);
      if ((record.entry.flags & kDiscard) != 0)
        std::memset(image_.data() + place + at, 0, size);
      else
        log_.read(image_.data() + place + at, size, record.data + at);
    }
  }
  [[nodiscard]] const std::vector<char>& image() const { return image_; }

 private:
  const Device& log_;
  std::vector<char> image_;
  std::uint32_t sector_bytes_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) refuse("usage: replay-log LOG DISK SEED");
  const Device log(argv[1], O_RDONLY), device(argv[2], O_RDWR);
  std::mt19937_64 random(std::strtoull(argv[3], nullptr, 10));
  std::uint32_t sector_bytes = 0;
  const std::vector<Recorded> records = read_log(log, sector_bytes);
  const std::vector<std::size_t> cuts = cuts_of(records);
  const std::size_t chosen = random() % cuts.size(), last = cuts[chosen];

  Disk disk(log, device.bytes(), sector_bytes);
  for (std::size_t i = 0; i <= last; ++i) {
    disk.apply(records[i], [] { return true; });
    if (!records[i].mark.empty()) std::printf("mark %s\n", records[i].mark.c_str());
  }
  unsigned written = 0, unflushed = 0;
  for (std::size_t i = last + 1; i < records.size() && (records[i].entry.flags & (kFlush | kFua)) == 0; ++i) {
    disk.apply(records[i], [&] {
      const bool is_written = (random() & 1U) != 0;
      ++unflushed;
      written += is_written ? 1 : 0;
      return is_written;
    });
  }
  device.write_all(disk.image());
  std::printf("cut after record %zu of %zu, barrier %zu of %zu; of %u blocks after it %u are written\n",
              last + 1, records.size(), chosen + 1, cuts.size(), unflushed, written);
}
