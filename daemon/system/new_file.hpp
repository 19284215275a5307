// A file that has a name when it is whole: until then it goes with this object or, where the file system has
// files without a name, with the process. Blocks until the disk has it. Not thread-safe.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "hw/file_descriptor.hpp"

namespace contourd {

class NewFile {
 public:
  // In the folder in which it is to be. Each call throws std::system_error, and can be given up then.
  explicit NewFile(std::filesystem::path folder);
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  ~NewFile();

  // Whatever the umask says.
  void let_group_read();
  void let_all_read();
  void write(std::string_view bytes);

  // The last call: it takes the place of what has that name.
  void replace(const std::string& name);
  // The same for what nobody misses after a power cut: the disk is not waited for.
  void replace_for_now(const std::string& name);
  // The last call that returns true: nothing has had that name. Whoever sees it there sees nobody writing it.
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

// Removes what processes that were killed had not given its name yet.
void remove_unfinished_files(const std::filesystem::path& folder);

}  // namespace contourd
