// A lock file (flock(2)) in the spool's folder, so that only one process uses the spool. The kernel releases
// the lock when the process ends. One call at a time, from any thread.
#pragma once

#include <filesystem>

#include "hw/file_descriptor.hpp"

namespace contourd {

class SpoolLock {
 public:
  // Takes the lock, or takes it again if another folder has been put in the spool's place. Throws
  // std::runtime_error if the folder cannot be written or another contourd has the lock.
  void take(const std::filesystem::path& spool);

 private:
  FileDescriptor lock_;
};

}  // namespace contourd
