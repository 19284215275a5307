// Writes files that are complete or absent, even after a power cut. Blocks until the data is on the disk.
// Thread-safe.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "hw/file_descriptor.hpp"

namespace contourd {

// Writes an unnamed file, or one with an unpredictable name, and renames it to `path`. Throws
// std::system_error; then the previous file is unchanged.
void write_durably(const std::filesystem::path& path, std::string_view text);

// Flushes a folder's renames to the disk. Does nothing if the file system cannot do it.
void sync_folder(const std::filesystem::path& folder);

// Flushes what others have written to the disk: one file, or all files directly in a folder. Ignores what
// cannot be opened or flushed.
void sync_contents(const std::filesystem::path& path);

// A file that gets its name only when it is complete. Until then it is deleted with this object; on file
// systems with unnamed files (O_TMPFILE) also when the process ends. Not thread-safe.
class NewFile {
 public:
  // Creates the file in the folder of its final name. All functions throw std::system_error; then the file
  // can only be discarded.
  explicit NewFile(std::filesystem::path folder);
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  ~NewFile();

  // Add read permission, regardless of the umask.
  void let_group_read();
  void let_all_read();
  void write(std::string_view bytes);
  // Replaces bytes that were written before.
  void rewrite(std::int64_t offset, std::string_view bytes);

  // Flushes the file and gives it this name, replacing a file that has it. Must be the last call.
  void replace(const std::string& name);
  // Does the same without waiting for the disk, for files that may be lost in a power cut.
  void replace_for_now(const std::string& name);
  // Flushes the file and gives it this name unless the name is taken; then returns false and may be called
  // again. Must be the last call once it returns true. The file is not open for writing by the time its name
  // exists.
  [[nodiscard]] bool appear(const std::string& name);

 private:
  void add_mode(mode_t mode);
  void sync();
  void close_for_writing();
  void name_temporarily();

  std::filesystem::path folder_, temporary_;
  FileDescriptor file_;
  bool named_ = false, written_ = false;
};

// Removes the temporary files that killed processes have left in the folder.
void remove_unfinished_files(const std::filesystem::path& folder);

}  // namespace contourd
