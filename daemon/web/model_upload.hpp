// A model that a client sends: its bytes go straight to a file without a name in the spool's incoming folder,
// which gets its name when it is complete. Whatever ends the upload before, no file remains. The disk is
// used by a worker thread only. Event loop's thread only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "daemon/system/worker.hpp"

namespace contourd::web {

struct UploadLimits {
  std::uint64_t most_bytes = 0;  // size of the largest model
  std::uint64_t free_bytes = 0;  // room that an upload leaves on the disk
};

// A refusal of an upload: the status of HTTP, and a sentence for the user.
struct UploadRefusal {
  unsigned status = 500;
  std::string why;
};

class ModelUpload {
 public:
  using Written = std::function<void(const std::optional<UploadRefusal>& refusal)>;
  using Finished = std::function<void(const std::optional<UploadRefusal>& refusal, const std::string& job)>;

  // `spool` is the folder with incoming/; `name`, of the model's file, is one that why_bad_file_name()
  // accepts. The worker must outlive the object.
  ModelUpload(Worker& disk, std::filesystem::path spool, std::string name, UploadLimits limits);

  // Appends bytes to the file. `written` is called later; after a refusal there must be no further call.
  void write(std::string bytes, Written written);
  // Makes the file a job with this ticket, or without one if the text is empty, under a name that no job has,
  // once it is on the disk. `finished` is called later.
  void finish(std::string ticket, Finished finished);

 private:
  struct File;

  Worker& disk_;
  std::shared_ptr<File> file_;  // used by the worker's thread only
};

}  // namespace contourd::web
