// Puts models into the spool's incoming folder. Each model appears there complete, under a name that no job
// has, after its ticket. Blocks until the files are on disk. Not thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>

#include "daemon/spool/spool_folders.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd::ctl {

// Reads the file from its current position to its end. Throws UnreadableFile, also if there are more than
// `most` bytes.
[[nodiscard]] std::string text_of(const FileDescriptor& file, std::uint64_t most);

class SpoolSubmission {
 public:
  explicit SpoolSubmission(const std::filesystem::path& spool);

  [[nodiscard]] const std::filesystem::path& incoming() const { return incoming_; }
  // Copies the open file `model`, from its current position, into incoming. `name` is a model's file name,
  // which gets a number if it is in use. An empty `ticket` means no ticket. Returns the job's name. Throws
  // UnreadableFile, also if the file has more than `most` bytes, and OutputError; then no file remains.
  [[nodiscard]] std::string put(const std::string& name, const FileDescriptor& model,
                                const std::string& ticket,
                                std::uint64_t most = std::numeric_limits<std::uint64_t>::max()) const;

 private:
  [[nodiscard]] std::string put_unused(const std::string& name, const FileDescriptor& model,
                                       const std::string& ticket, std::uint64_t most) const;
  [[nodiscard]] bool put_ticket(const JobFiles& files, const std::string& ticket) const;

  SpoolFolders folders_;
  std::filesystem::path incoming_;
};

}  // namespace contourd::ctl
