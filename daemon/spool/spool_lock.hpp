// Has one process alone use a spool: a lock (flock(2)) in its folder, which goes with the process.
// Thread-safe where calls are made one at a time.
#pragma once

#include <filesystem>

#include "hw/file_descriptor.hpp"

namespace contourd {

class SpoolLock {
 public:
  // Again where the folder is another by now, and the lock with it. Throws std::runtime_error when it cannot
  // be written there, or another contourd has the lock.
  void take(const std::filesystem::path& spool);

 private:
  FileDescriptor lock_;
};

}  // namespace contourd
