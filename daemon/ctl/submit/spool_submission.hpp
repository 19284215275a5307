// Puts models into the spool's incoming folder: each whole at once, under a name that no job has, its ticket
// before it. Blocks until the disk has them. Not thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>

#include "daemon/spool/spool_folders.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd::ctl {

// From where it stands to its end. Throws UnreadableFile, also when there are more than `most` bytes.
[[nodiscard]] std::string text_of(const FileDescriptor& file, std::uint64_t most);

class SpoolSubmission {
 public:
  explicit SpoolSubmission(const std::filesystem::path& spool);

  [[nodiscard]] const std::filesystem::path& incoming() const { return incoming_; }
  // Of the file that is open, from where it stands; `name` is a model's file name, which gets a number if it
  // has to. No ticket where that is empty. Returns the job's name. Throws UnreadableFile, also when the file
  // has more than `most` bytes, and OutputError; then nothing is left there.
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
