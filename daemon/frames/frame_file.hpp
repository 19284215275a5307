// The file of the masks that a continuous print has shown: NAME.frames.bin beside its report. All numbers are
// little-endian. Functions block.
//
//   header   16 bytes "contourd-frames\n", u32 version (1), u32 bytes a record (32),
//            u64 checksum of the 24 bytes before
//   block    u32 number of records (1 to 512), u32 0, u64 checksum of these 8 bytes and the records; records
//   record   i64 shown, ns of the machine's clock; i32 cut, i32 first, i32 last, nm; u32 lit, us;
//            u32 layer, from 0, below 2^23; 2^23 times the 255ths of the lamp's light that white pixels lack;
//            and 2^31 if the mask is the first since the light went on;
//            u16 refreshes, u16 missed (65535: that many or more)
//   end      u32 0, u32 16, u64 checksum of these 8 bytes and the 16 that follow;
//            u64 records in the file, u64 records that are lost
//
// Checksums are checksum_of(). A file has at most kMostRecords, and 16,793,664 bytes. A file that a power cut
// ended has no end: its whole blocks can be read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "daemon/frames/frame_record.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

struct FrameFile {
  static constexpr std::size_t kRecordBytes = 32, kBlockRecords = 512, kMostRecords = 524'288;
  static constexpr std::size_t kHeaderBytes = 32, kBlockHeaderBytes = 16, kEndBytes = 32;
  static constexpr std::size_t kMostBytes = kHeaderBytes + kMostRecords * kRecordBytes +
                                            kMostRecords / kBlockRecords * kBlockHeaderBytes + kEndBytes;

  std::vector<FrameRecord> records;  // in the order of time
  std::uint64_t lost = 0;            // records that were not written
  bool complete = false;             // the file has its end, and nothing after it
  std::size_t after_end = 0;         // bytes after the end, which do not belong to it
};
static_assert(FrameFile::kMostBytes == 16'793'664);

// Reads a file of frames, up to the first block that is torn or damaged; then it is not complete. Throws
// UnreadableFile, and std::runtime_error with a clause if it is no such file, or one of another version.
[[nodiscard]] FrameFile read_frame_file(const std::filesystem::path& path);

// Returns the bytes of a file of frames, of which it reads no more than kMostBytes and one. Throws
// UnreadableFile.
[[nodiscard]] std::string frame_file_text(const std::filesystem::path& path);

// Writes a file of frames, without waiting for the disk. Used by one thread after the other.
class FrameFileWriter {
 public:
  // Makes a new file, which replaces one of this name. Throws std::system_error, as all functions do.
  explicit FrameFileWriter(const std::filesystem::path& path);

  // Adds a block. REQUIRES: 1 to kBlockRecords records; a block with fewer is the last one; at most
  // kMostRecords in all.
  void add(std::span<const FrameRecord> records);
  // Writes the end. Must be the last call.
  void finish(std::uint64_t lost);

  [[nodiscard]] std::size_t records() const { return records_; }

 private:
  FileDescriptor file_;
  std::size_t records_ = 0;
};

}  // namespace contourd
